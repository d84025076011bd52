//! Smooth noise from hashed lattices: for bark, for crooked limbs, for patches of leaf colour.
//!
//! Only products, sums and whole-number hashes: the same bits on every machine.

/// Noise in [−1, 1] that changes over a distance of about 1; `salt` chooses another field.
pub(super) fn noise2(x: f32, y: f32, salt: u32) -> f32 {
    let (x0, tx) = cell(x);
    let (y0, ty) = cell(y);
    let at = |dx: i32, dy: i32| lattice(x0 + dx, y0 + dy, 0, salt);
    mix(mix(at(0, 0), at(1, 0), tx), mix(at(0, 1), at(1, 1), tx), ty)
}

/// [`noise2`] in space.
pub(super) fn noise3(x: f32, y: f32, z: f32, salt: u32) -> f32 {
    let (x0, tx) = cell(x);
    let (y0, ty) = cell(y);
    let (z0, tz) = cell(z);
    let at = |dx: i32, dy: i32, dz: i32| lattice(x0 + dx, y0 + dy, z0 + dz, salt);
    let layer = |dz: i32| {
        mix(
            mix(at(0, 0, dz), at(1, 0, dz), tx),
            mix(at(0, 1, dz), at(1, 1, dz), tx),
            ty,
        )
    };
    mix(layer(0), layer(1), tz)
}

/// `a` at 0, `b` at 1.
pub(super) fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 below `low`, 1 above `high`, a smooth ramp between.
pub(super) fn ramp(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn cell(x: f32) -> (i32, f32) {
    let floor = libm::floorf(x);
    let t = x - floor;
    (floor as i32, t * t * (3.0 - 2.0 * t))
}

fn lattice(x: i32, y: i32, z: i32, salt: u32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77)
        ^ (z as u32).wrapping_mul(0xc2b2_ae3d)
        ^ salt.wrapping_mul(0x27d4_eb2f);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^= h >> 15;
    (h >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_continuous_and_salted() {
        for i in 0..500 {
            let x = i as f32 * 0.37 - 90.0;
            let value = noise3(x, 0.3 * x, -x, 5);
            assert!((-1.0..=1.0).contains(&value));
            assert!((noise2(x, 2.0, 1) - noise2(x + 1e-3, 2.0, 1)).abs() < 0.01);
        }
        assert_ne!(noise2(0.0, 0.0, 1), noise2(0.0, 0.0, 2));
    }
}
