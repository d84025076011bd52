//! Gaussian smoothing of a picture, the whole of it or within a mask.
//!
//! Normalised convolution (Knutsson & Westin, *Normalized and differential convolution*, 1993):
//! values and mask are smoothed alike and divided, so that what lies outside the mask, however
//! bright, has no part in the result. Far outside, where the kernel meets nothing of the mask,
//! the result is the mean of all that is inside.

use super::{Image, Mask};
use crate::base::{Cancel, Cancelled, Kernel, with_level_of_cpu};
use rayon::prelude::*;

/// Standard deviations after which the kernel ends: what is cut off weighs 0.3 %.
const REACH: f64 = 3.0;

/// `values` smoothed by a Gaussian of standard deviation `sigma` pixels that sees only what lies in the frame. A
/// `sigma` of 0 changes nothing.
///
/// # Errors
/// [`Cancelled`].
pub fn smoothed(values: &Image<f32>, sigma: f64, cancel: &Cancel) -> Result<Image<f32>, Cancelled> {
    let half = half_kernel(sigma);
    if half.len() == 1 {
        return Ok(values.clone());
    }
    let mut smooth = both_ways(values, &half, cancel)?;
    // What the kernel meets of the frame is the product of what it meets along and across.
    let met = |count: u32| along_rows(&Image::filled(count, 1, 1.0), &half, cancel);
    let (across, down) = (met(values.width())?, met(values.height())?);
    for (y, down) in (0..).zip(down.pixels()) {
        for (value, across) in smooth.row_mut(y).iter_mut().zip(across.pixels()) {
            *value /= across * down;
        }
    }
    Ok(smooth)
}

/// `values` smoothed by a Gaussian of standard deviation `sigma` pixels that sees only the pixels of
/// `mask`; defined for all pixels. A `sigma` of 0 changes nothing.
///
/// ```
/// use boscage::{base::Cancel, raster::{Image, smoothed_within}};
/// let values = Image::from_pixels(4, 1, vec![2.0, 2.0, 2.0, 900.0]);
/// let mask = Image::from_pixels(4, 1, vec![true, true, true, false]);
/// let smooth = smoothed_within(&values, &mask, 1.0, &Cancel::new()).unwrap();
/// assert!(smooth.pixels().iter().all(|value| (value - 2.0f32).abs() < 1e-5));
/// ```
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// When `mask` has another size than `values`.
pub fn smoothed_within(
    values: &Image<f32>,
    mask: &Mask,
    sigma: f64,
    cancel: &Cancel,
) -> Result<Image<f32>, Cancelled> {
    let size = (values.width(), values.height());
    assert_eq!(size, (mask.width(), mask.height()), "the mask fits");
    let half = half_kernel(sigma);
    if half.len() == 1 {
        return Ok(values.clone());
    }
    let share = mask.map(|&inside| if inside { 1.0f32 } else { 0.0 });
    let inside = values.pixels().iter().zip(share.pixels());
    let masked = inside.map(|(value, share)| if *share > 0.0 { *value } else { 0.0 });
    let masked = Image::from_pixels(size.0, size.1, masked.collect());
    let sum: f64 = masked.pixels().iter().map(|&value| f64::from(value)).sum();
    let mean = (sum / mask.count().max(1) as f64) as f32;
    let mut smooth = both_ways(&masked, &half, cancel)?;
    let weight = both_ways(&share, &half, cancel)?;
    for (value, &weight) in smooth.pixels_mut().iter_mut().zip(weight.pixels()) {
        *value = if weight > 0.0 { *value / weight } else { mean };
    }
    Ok(smooth)
}

/// `image` convolved with the symmetric kernel in both directions; beyond the frame all is 0.
fn both_ways(image: &Image<f32>, half: &[f32], cancel: &Cancel) -> Result<Image<f32>, Cancelled> {
    // Two passes of "along the rows, then transposed": rows are what vector units like.
    let once = transposed(&along_rows(image, half, cancel)?);
    Ok(transposed(&along_rows(&once, half, cancel)?))
}

/// The kernel from its middle outwards, of sum 1 over both halves.
fn half_kernel(sigma: f64) -> Vec<f32> {
    let reach = (REACH * sigma).ceil() as usize;
    let bell: Vec<f64> = (0..=reach)
        .map(|i| {
            if i == 0 {
                1.0
            } else {
                let x = i as f64 / sigma;
                libm::exp(-0.5 * x * x)
            }
        })
        .collect();
    let sum = 2.0 * bell.iter().sum::<f64>() - bell[0];
    bell.iter().map(|weight| (weight / sum) as f32).collect()
}

/// Every row convolved with the symmetric kernel; beyond the frame all is 0.
fn along_rows(image: &Image<f32>, half: &[f32], cancel: &Cancel) -> Result<Image<f32>, Cancelled> {
    let (width, reach) = (image.width() as usize, half.len() - 1);
    let mut out = Image::filled(image.width(), image.height(), 0.0);
    out.pixels_mut()
        .par_chunks_mut(width)
        .zip(image.pixels().par_chunks(width))
        .try_for_each_init(
            || vec![0.0f32; width + 2 * reach],
            |padded, (out, row)| {
                cancel.check()?;
                padded[reach..reach + width].copy_from_slice(row);
                with_level_of_cpu(Row { padded, half, out });
                Ok(())
            },
        )?;
    Ok(out)
}

/// One row: for each pair of weights one sweep over all pixels.
struct Row<'a> {
    padded: &'a [f32],
    half: &'a [f32],
    out: &'a mut [f32],
}

impl Kernel for Row<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (width, reach) = (self.out.len(), self.half.len() - 1);
        let middle = &self.padded[reach..reach + width];
        for (out, value) in self.out.iter_mut().zip(middle) {
            *out = self.half[0] * value;
        }
        for (step, &weight) in self.half.iter().enumerate().skip(1) {
            let left = &self.padded[reach - step..reach - step + width];
            let right = &self.padded[reach + step..reach + step + width];
            for ((out, left), right) in self.out.iter_mut().zip(left).zip(right) {
                *out += weight * (left + right);
            }
        }
    }
}

fn transposed(image: &Image<f32>) -> Image<f32> {
    /// Side of a tile that stays in the nearest cache.
    const TILE: usize = 32;
    let (width, height) = (image.width() as usize, image.height() as usize);
    let mut out = vec![0.0; width * height];
    for top in (0..height).step_by(TILE) {
        for left in (0..width).step_by(TILE) {
            for y in top..(top + TILE).min(height) {
                for x in left..(left + TILE).min(width) {
                    out[x * height + y] = image.pixels()[y * width + x];
                }
            }
        }
    }
    Image::from_pixels(image.height(), image.width(), out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The sum over all pairs of pixels, in double precision.
    fn reference(values: &Image<f32>, mask: &Mask, sigma: f64, x: i64, y: i64) -> f64 {
        let reach = (REACH * sigma).ceil() as i64;
        let (mut sum, mut weight) = (0.0, 0.0);
        for dy in -reach..=reach {
            for dx in -reach..=reach {
                if mask.get(x + dx, y + dy) == Some(true) {
                    let square = (dx * dx + dy * dy) as f64 / (sigma * sigma);
                    let bell = libm::exp(-0.5 * square);
                    weight += bell;
                    sum += bell * f64::from(values.get(x + dx, y + dy).unwrap());
                }
            }
        }
        sum / weight
    }

    #[test]
    fn both_passes_give_the_double_sum_over_the_mask() {
        let mut random = crate::base::Seed(1).random();
        let values = (0..23 * 17).map(|_| random.unit() as f32).collect();
        let values = Image::from_pixels(23, 17, values);
        let mask = values.map(|_| random.unit() < 0.6);
        for sigma in [0.4, 1.0, 3.7] {
            let smooth = smoothed_within(&values, &mask, sigma, &Cancel::new()).unwrap();
            for y in 0..17 {
                for x in (0..23).filter(|&x| mask.at(x, y)) {
                    let expected = reference(&values, &mask, sigma, x.into(), y.into());
                    let found = f64::from(smooth.at(x, y));
                    assert!((found - expected).abs() < 1e-5, "{found} {expected}");
                }
            }
        }
    }

    #[test]
    fn the_whole_frame_is_a_mask_that_is_everywhere() {
        let mut random = crate::base::Seed(2).random();
        let values = (0..19 * 26).map(|_| random.unit() as f32).collect();
        let values = Image::from_pixels(19, 26, values);
        for sigma in [0.0, 0.8, 4.1] {
            let whole = smoothed(&values, sigma, &Cancel::new()).unwrap();
            let everywhere = values.map(|_| true);
            let within = smoothed_within(&values, &everywhere, sigma, &Cancel::new()).unwrap();
            for (whole, within) in whole.pixels().iter().zip(within.pixels()) {
                assert!((whole - within).abs() < 1e-5, "{whole} {within}");
            }
        }
    }

    #[test]
    fn what_lies_outside_has_no_part() {
        let mask = Image::from_pixels(3, 1, vec![true, true, false]);
        let smooth = |outside| {
            let values = Image::from_pixels(3, 1, vec![0.25, 0.75, outside]);
            smoothed_within(&values, &mask, 2.0, &Cancel::new()).unwrap()
        };
        assert_eq!(smooth(0.0), smooth(f32::NAN));
    }
}
