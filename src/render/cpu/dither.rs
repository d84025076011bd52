//! Patterns of samples by hashing: the end of `shaders/shared/frame.wgsl` on the processor.

/// A number from 0 to 1 for a sample of the picture: what shows of something that fades.
#[inline(always)]
pub(super) fn pattern(x: u32, y: u32, salt: u32) -> f32 {
    hashed(x.wrapping_mul(0x9e37_79b1) ^ hash(y.wrapping_mul(0x85eb_ca77) ^ salt))
}

/// A number from 0 to 1 for a whole number.
#[inline(always)]
pub(super) fn hashed(value: u32) -> f32 {
    (hash(value) >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// A permutation of the whole numbers (C. Wellons, *lowbias32*, 2018).
#[inline(always)]
pub(super) fn hash(value: u32) -> u32 {
    let mut x = value;
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pattern_is_uniform() {
        let values: Vec<f32> = (0..10_000).map(|i| pattern(i % 100, i / 100, 7)).collect();
        let mean = values.iter().sum::<f32>() / 10_000.0;
        assert!((mean - 0.5).abs() < 0.01);
        assert!(values.iter().all(|value| (0.0..1.0).contains(value)));
    }
}
