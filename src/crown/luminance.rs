//! Brightness as a clue to depth: the luminance of a picture of foliage (thesis §4.4).
//!
//! L = 0.2126 R + 0.7152 G + 0.0722 B on sRGB values, as in the thesis. The thesis then stretches
//! L to 0 … 1 by its extremes; here 1 % at either end may lie outside, since one glint of the sun
//! would otherwise flatten all the rest. Nothing is clamped.

use crate::raster::Straight;

/// The luminance of a pixel, 0 … 1; alpha has no part in it.
///
/// ```
/// use boscage::{crown::luminance, raster::Straight};
/// assert_eq!(luminance(Straight([0, 0, 0, 255])), 0.0);
/// assert!((luminance(Straight([255, 255, 255, 255])) - 1.0).abs() < 1e-6);
/// assert!(luminance(Straight([0, 200, 0, 255])) > luminance(Straight([200, 0, 200, 255])));
/// ```
#[inline]
pub fn luminance(pixel: Straight) -> f32 {
    pixel.luma() / 255.0
}

/// A linear map that takes two values to 0 and 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stretch {
    low: f32,
    scale: f32,
}

impl Stretch {
    /// Takes the values below which the shares `tail` and 1 − `tail` of `values` lie to 0 and 1. One
    /// value everywhere becomes 0.5.
    pub(super) fn of(mut values: Vec<f32>, tail: f64) -> Self {
        if values.is_empty() {
            return Self {
                low: 0.0,
                scale: 1.0,
            };
        }
        let last = values.len() - 1;
        let rank = (tail * last as f64) as usize;
        let low = *values.select_nth_unstable_by(rank, f32::total_cmp).1;
        let high = *values.select_nth_unstable_by(last - rank, f32::total_cmp).1;
        if high - low > 1e-6 {
            Self {
                low,
                scale: 1.0 / (high - low),
            }
        } else {
            Self {
                low: low - 0.5,
                scale: 1.0,
            }
        }
    }

    /// The value on the new scale; may lie outside 0 … 1.
    #[inline]
    pub(super) fn apply(self, value: f32) -> f32 {
        (value - self.low) * self.scale
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_few_glints_do_not_flatten_the_rest() {
        let mut values: Vec<f32> = (0..1000).map(|i| 0.2 + 0.0002 * i as f32).collect();
        values[17] = 50.0;
        let stretch = Stretch::of(values, 0.01);
        assert!((stretch.apply(0.202) - 0.0).abs() < 0.01);
        assert!((stretch.apply(0.398) - 1.0).abs() < 0.01);
    }

    #[test]
    fn one_value_is_in_the_middle() {
        assert_eq!(Stretch::of(vec![0.25; 9], 0.01).apply(0.25), 0.5);
    }
}
