//! Colours between files, light and the screen.
//!
//! Shading is done on linear light of Rec. 709 primaries; pictures are sRGB. The filmic curve is
//! K. Narkowicz's fit of the Academy's reference curve (*ACES Filmic Tone Mapping Curve*, 2015): a
//! short toe, a long shoulder, rational, so that both renderers compute it alike.

/// Linear light of an sRGB value.
pub(crate) fn linear(srgb: u8) -> f32 {
    let value = f32::from(srgb) / 255.0;
    if value <= 0.040_45 {
        value / 12.92
    } else {
        libm::powf((value + 0.055) / 1.055, 2.4)
    }
}

/// The linear light of every sRGB value.
pub(crate) fn linear_table() -> [f32; 256] {
    std::array::from_fn(|value| linear(value as u8))
}

/// The sRGB value 0 … 1 of linear light 0 … 1.
#[inline]
pub(crate) fn srgb(linear: f32) -> f32 {
    let value = linear.clamp(0.0, 1.0);
    if value <= 0.003_130_8 {
        value * 12.92
    } else {
        1.055 * libm::powf(value, 1.0 / 2.4) - 0.055
    }
}

/// The sRGB value 0 … 255 of linear light 0 … 1, to nearest.
#[inline]
pub(crate) fn srgb_byte(linear: f32) -> u8 {
    (srgb(linear) * 255.0 + 0.5) as u8
}

/// What the filmic curve makes of linear light ≥ 0: 0 … 1.
#[inline]
pub(crate) fn filmic(light: f32) -> f32 {
    // The fit expects half the exposure that would keep middle grey.
    let x = light * 0.72;
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_srgb_value_survives_the_round_trip() {
        for value in 0..=255 {
            assert_eq!(srgb_byte(linear(value)), value);
        }
    }

    #[test]
    fn the_curve_rises_from_black_to_white_and_keeps_middle_grey() {
        let curve: Vec<f32> = (0..200).map(|i| filmic(i as f32 * 0.1)).collect();
        assert!(curve.is_sorted());
        assert_eq!(curve[0], 0.0);
        assert!(curve[199] > 0.98);
        assert!((filmic(0.18) - 0.18).abs() < 0.03);
    }
}
