//! The relief of a photographed crown: a height for each pixel of its mask (thesis §4.4).
//!
//! Luminance is taken for openness: under an even sky the deep places between the leaves are dark.
//! A pyramid of smoothed luminances ([`ReliefSettings`]) is summed, then the result is "pasted" onto
//! the silhouette: Poisson's equation with the Laplacian of the sum inside and 0 all along the
//! silhouette (Pérez, Gangnet & Blake, *Poisson image editing*, 2003).
//!
//! Smoothing never looks outside the mask, so bright sky behind the crown does not lift its rim.
//! Limits: sun from one side is light, not shape; [`ReliefSettings::even_light`] takes off what
//! changes slowly, a sharp shadow stays a step.

use super::luminance::{Stretch, luminance};
use super::pyramid::{ReliefSettings, summed};
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Straight, opaque_bounds, smoothed_within};
use crate::solve::poisson;

/// Share of the pixels at either end whose luminance may leave 0 … 1.
const TAIL: f64 = 0.01;

/// The height of each pixel of the crown `mask` in `photo`: 0 on its silhouette (the mask's pixels
/// with one of the four neighbours outside) and outside, larger towards the viewer. A step from the
/// crown's darkest to its lightest is about 1; heights may be negative.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// When `mask` has another size than `photo`.
pub fn relief(
    photo: &Image<Straight>,
    mask: &Mask,
    settings: &ReliefSettings,
    cancel: &Cancel,
) -> Result<Image<f32>, Cancelled> {
    let size = (photo.width(), photo.height());
    assert_eq!(size, (mask.width(), mask.height()), "the mask fits");
    let Some(bounds) = opaque_bounds(mask) else {
        return Ok(Image::filled(size.0, size.1, 0.0));
    };
    let light = photo.map(|&pixel| luminance(pixel));
    let inside = light.pixels().iter().zip(mask.pixels());
    let inside = inside.filter(|(_, inside)| **inside);
    let stretch = Stretch::of(inside.map(|(light, _)| *light).collect(), TAIL);
    let light = light.map(|&light| stretch.apply(light));
    let width = f64::from(bounds.width.max(bounds.height));
    let smoothed = |image: &Image<f32>, sigma: f64| smoothed_within(image, mask, sigma, cancel);
    let sum = summed(&light, settings, width, smoothed, add)?;
    pasted(&sum, mask, cancel)
}

fn add(sum: &mut Image<f32>, image: &Image<f32>, weight: f32) {
    for (sum, pixel) in sum.pixels_mut().iter_mut().zip(image.pixels()) {
        *sum += weight * pixel;
    }
}

/// The field whose Laplacian off the silhouette is that of `heights` and that is 0 on it.
fn pasted(heights: &Image<f32>, mask: &Mask, cancel: &Cancel) -> Result<Image<f32>, Cancelled> {
    let steps = [(1, 0), (-1, 0), (0, 1), (0, -1)];
    let mut interior = mask.clone();
    let mut right = Image::filled(mask.width(), mask.height(), 0.0f64);
    for y in 0..mask.height() {
        for x in (0..mask.width()).filter(|&x| mask.at(x, y)) {
            let around = steps.map(|(dx, dy)| (i64::from(x) + dx, i64::from(y) + dy));
            if around.iter().all(|&(x, y)| mask.get(x, y) == Some(true)) {
                let sum: f64 = around
                    .iter()
                    .map(|&(x, y)| f64::from(heights.at(x as u32, y as u32)))
                    .sum();
                right.set(x, y, 4.0 * f64::from(heights.at(x, y)) - sum);
            } else {
                interior.set(x, y, false);
            }
        }
    }
    Ok(poisson(&interior, &right, cancel)?.map(|&height| height as f32))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn disc(size: u32) -> Mask {
        let middle = f64::from(size - 1) / 2.0;
        let pixels = (0..size * size).map(|i| {
            let (x, y) = (f64::from(i % size) - middle, f64::from(i / size) - middle);
            x.hypot(y) < middle - 1.0
        });
        Image::from_pixels(size, size, pixels.collect())
    }

    fn grey(size: u32, light: impl Fn(u32, u32) -> u8) -> Image<Straight> {
        let pixels = (0..size * size).map(|i| {
            let light = light(i % size, i / size);
            Straight([light, light, light, 255])
        });
        Image::from_pixels(size, size, pixels.collect())
    }

    fn on_silhouette(mask: &Mask, x: u32, y: u32) -> bool {
        let (x, y) = (i64::from(x), i64::from(y));
        let around = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)];
        around.iter().any(|&(x, y)| mask.get(x, y) != Some(true))
    }

    #[test]
    fn one_colour_is_flat_whatever_the_sky_is() {
        let mask = disc(40);
        let photo = grey(40, |x, y| if mask.at(x, y) { 90 } else { 255 });
        let flat = relief(&photo, &mask, &ReliefSettings::default(), &Cancel::new()).unwrap();
        assert!(flat.pixels().iter().all(|height| height.abs() < 1e-4));
    }

    #[test]
    fn a_harmonic_light_is_no_relief_and_a_paraboloid_is_kept() {
        // One level only: the luminance itself, light not evened.
        let settings = ReliefSettings {
            levels: 1,
            even_light: 0.0,
            ..Default::default()
        };
        let mask = disc(61);
        let ramp = grey(61, |x, _| (40 + 3 * x) as u8);
        let flat = relief(&ramp, &mask, &settings, &Cancel::new()).unwrap();
        assert!(flat.pixels().iter().all(|height| height.abs() < 1e-4));
        let square = |x: u32, y: u32| (f64::from(x) - 30.0).powi(2) + (f64::from(y) - 30.0).powi(2);
        let dome = grey(61, |x, y| {
            (240.0 - 0.2 * square(x, y)).clamp(0.0, 255.0).round() as u8
        });
        let height = relief(&dome, &mask, &settings, &Cancel::new()).unwrap();
        // The dome falls by 0.2 · 29² = 168 levels to its rim of the 164 or so within the tails.
        let top = height.at(30, 30);
        assert!((0.95..1.1).contains(&top), "{top}");
        assert!(height.at(30, 10) < 0.6 * top && height.at(30, 10) > 0.4 * top);
    }

    #[test]
    fn the_silhouette_is_at_zero_and_a_lit_pixel_never_sinks() {
        let mut random = crate::base::Seed(9).random();
        let size = 24;
        for _ in 0..12 {
            let mask = disc(size).map(|&inside| inside && random.unit() < 0.93);
            let photo = grey(size, |x, y| ((x * 37 + y * 101 + x * y * 13) % 180) as u8);
            let settings = ReliefSettings::default();
            let before = relief(&photo, &mask, &settings, &Cancel::new()).unwrap();
            for y in 0..size {
                for x in 0..size {
                    if on_silhouette(&mask, x, y) || !mask.at(x, y) {
                        assert_eq!(before.at(x, y), 0.0);
                    }
                }
            }
            let (x, y) = (random.below(24) as u32, random.below(24) as u32);
            let mut lit = photo.clone();
            let light = photo.at(x, y).0[0] + 30;
            lit.set(x, y, Straight([light, light, light, 255]));
            let after = relief(&lit, &mask, &settings, &Cancel::new()).unwrap();
            assert!(after.at(x, y) >= before.at(x, y) - 1e-4, "({x}, {y})");
        }
    }

    #[test]
    fn degenerate_masks_are_flat() {
        let settings = ReliefSettings::default();
        let photo = grey(5, |x, _| 20 * x as u8);
        for inside in [true, false] {
            let mask = Image::filled(5, 5, inside);
            assert!(relief(&photo, &mask, &settings, &Cancel::new()).is_ok());
        }
        let mut dot = Image::filled(5, 5, false);
        dot.set(2, 2, true);
        let flat = relief(&photo, &dot, &settings, &Cancel::new()).unwrap();
        assert!(flat.pixels().iter().all(|&height| height == 0.0));
    }
}
