//! Changing the size of a picture.
//!
//! A separable filter of two passes in single precision, rows in parallel. (The crate made for this,
//! `fast_image_resize`, is four times faster but is generic down to its kernels: it added half a
//! minute to every build of ours, and a picture is resized once and then cached.)

use super::{Image, Premultiplied, Rect};
use rayon::prelude::*;

/// Half-width of the Catmull–Rom kernel, in pixels of the coarser of the two pictures.
const SUPPORT: f64 = 2.0;

/// The part `crop` of `image`, resized to `width` × `height` pixels.
///
/// Catmull–Rom, widened to the size of a target pixel when the picture gets smaller, so that small
/// leaves neither alias nor ring. Edges map to edges: the centre of target pixel x lies at
/// `(x + 0.5) · crop.width / width − 0.5` pixels of the crop. What lies outside the crop counts as
/// a continuation of its border.
///
/// # Panics
/// When `crop` is empty or reaches outside, or a target side is 0.
pub fn resized(
    image: &Image<Premultiplied>,
    crop: Rect,
    width: u32,
    height: u32,
) -> Image<Premultiplied> {
    let across = taps(crop.width, width);
    let down = taps(crop.height, height);
    let columns = width as usize;

    // First across, for the rows of the crop, then down.
    let mut narrow = vec![[0.0f32; 4]; columns * crop.height as usize];
    narrow
        .par_chunks_mut(columns)
        .enumerate()
        .for_each(|(y, out)| {
            let row =
                &image.row(crop.y + y as u32)[crop.x as usize..(crop.x + crop.width) as usize];
            for (out, tap) in out.iter_mut().zip(&across) {
                // Not summed in place: fresh memory that is read before it is written costs twice.
                let mut sums = [0.0f32; 4];
                for (source, weight) in row[tap.first..].iter().zip(&tap.weights) {
                    for (sum, &value) in sums.iter_mut().zip(&source.0) {
                        *sum += f32::from(value) * weight;
                    }
                }
                *out = sums;
            }
        });
    let mut pixels = vec![Premultiplied::default(); columns * height as usize];
    pixels
        .par_chunks_mut(columns)
        .zip(&down)
        .for_each(|(out, tap)| {
            let mut sums = vec![[0.0f32; 4]; columns];
            let rows = narrow[tap.first * columns..].chunks(columns);
            for (row, weight) in rows.zip(&tap.weights) {
                for (sum, pixel) in sums.iter_mut().zip(row) {
                    for (sum, value) in sum.iter_mut().zip(pixel) {
                        *sum += value * weight;
                    }
                }
            }
            for (pixel, sum) in out.iter_mut().zip(&sums) {
                *pixel = rounded(*sum);
            }
        });
    Image::from_pixels(width, height, pixels)
}

/// The source pixels that make one target pixel, along one axis.
struct Taps {
    /// The first of them.
    first: usize,
    /// Their weights, of sum 1.
    weights: Vec<f32>,
}

/// All of `image`, its sides `scale` times as long, rounded, and at least 1; see [`resized`].
pub fn scaled(image: &Image<Premultiplied>, scale: f64) -> Image<Premultiplied> {
    let side = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).max(1);
    let (width, height) = (side(image.width()), side(image.height()));
    resized(image, image.rect(), width, height)
}

/// The taps of all `target` pixels made from `source` pixels.
fn taps(source: u32, target: u32) -> Vec<Taps> {
    let scale = f64::from(source) / f64::from(target);
    let width = scale.max(1.0);
    let last = i64::from(source) - 1;
    (0..target)
        .map(|i| {
            let centre = (f64::from(i) + 0.5) * scale - 0.5;
            let from = (centre - SUPPORT * width).ceil() as i64;
            let to = (centre + SUPPORT * width).floor() as i64;
            let first = from.clamp(0, last);
            let mut weights = vec![0.0; (to.clamp(0, last) - first + 1) as usize];
            for position in from..=to {
                let weight = catmull_rom((position as f64 - centre) / width);
                weights[(position.clamp(0, last) - first) as usize] += weight;
            }
            let sum: f64 = weights.iter().sum();
            Taps {
                first: first as usize,
                weights: weights.iter().map(|weight| (weight / sum) as f32).collect(),
            }
        })
        .collect()
}

/// The interpolating cubic of Catmull and Rom (1974), 0 from distance 2 on.
fn catmull_rom(distance: f64) -> f64 {
    let d = distance.abs();
    if d < 1.0 {
        (1.5 * d - 2.5) * d * d + 1.0
    } else if d < 2.0 {
        ((-0.5 * d + 2.5) * d - 4.0) * d + 2.0
    } else {
        0.0
    }
}

/// The nearest pixel; the kernel's negative lobes may leave a colour above its alpha.
fn rounded(sum: [f32; 4]) -> Premultiplied {
    let [r, g, b, alpha] = sum.map(|value| (value + 0.5).clamp(0.0, 255.0) as u8);
    Premultiplied([r.min(alpha), g.min(alpha), b.min(alpha), alpha])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn whole(side: u32) -> Rect {
        Rect {
            x: 0,
            y: 0,
            width: side,
            height: side,
        }
    }

    #[test]
    fn a_flat_picture_stays_flat_and_colour_stays_below_alpha() {
        let mut image = Image::filled(8, 8, Premultiplied([100, 50, 20, 200]));
        for (width, height) in [(21, 13), (3, 5), (1, 1)] {
            let flat = resized(&image, whole(8), width, height);
            assert!(
                flat.pixels()
                    .iter()
                    .all(|&p| p == Premultiplied([100, 50, 20, 200]))
            );
        }
        image.set(3, 3, Premultiplied([255, 255, 255, 255]));
        image.set(4, 3, Premultiplied([0; 4]));
        let grown = resized(&image, whole(8), 40, 40);
        assert!(grown.pixels().iter().all(|p| p.0[0] <= p.0[3]));
    }

    #[test]
    fn the_same_size_changes_nothing() {
        let pixels = (0..64)
            .map(|i| Premultiplied([i, i / 2, 0, i * 2]))
            .collect();
        let image = Image::from_pixels(8, 8, pixels);
        assert_eq!(resized(&image, whole(8), 8, 8), image);
    }

    #[test]
    fn a_ramp_stays_a_ramp() {
        let pixels = (0..16).map(|i| Premultiplied([0, 0, 0, 16 * i])).collect();
        let ramp = Image::from_pixels(16, 1, pixels);
        let all = Rect {
            x: 0,
            y: 0,
            width: 16,
            height: 1,
        };
        let twice = resized(&ramp, all, 32, 1);
        for x in 4..28 {
            let expected = 16.0 * ((f64::from(x) + 0.5) / 2.0 - 0.5);
            assert!((f64::from(twice.at(x, 0).0[3]) - expected).abs() <= 0.5);
        }
    }
}
