//! Colour continued under clear texels, so that no filter ever mixes in the colour of nothing.
//!
//! A texture unit interpolates colour and alpha separately: beside the last leaf it reads the
//! colour of a texel that nobody sees. If that is black, the leaf gets a dark fringe. Here clear
//! texels get the colours of the nearest leaves by push and pull (Gortler, Grzeszczuk, Szeliski &
//! Cohen, *The Lumigraph*, 1996): a pyramid of averages weighted by alpha, then every texel takes
//! from the coarser level what it lacks. Linear in the number of texels, smooth, and without the
//! streaks of a nearest-texel fill.

use crate::raster::{Image, Straight};
use rayon::prelude::*;

/// How much weight makes an average complete. A coarse texel of which a quarter is leaf is as good
/// as a full one; with 1 far colours would wash into the gaps, with less it gets blocky.
const ENOUGH: f32 = 0.25;

/// `image` with colour under its clear texels; alpha and the colours of all others stay.
///
/// ```
/// use boscage::export::bled;
/// use boscage::raster::{Image, Straight};
/// let image = Image::from_pixels(2, 1, vec![Straight([10, 200, 30, 255]), Straight([0; 4])]);
/// assert_eq!(bled(&image).at(1, 0), Straight([10, 200, 30, 0]));
/// ```
pub fn bled(image: &Image<Straight>) -> Image<Straight> {
    let alpha = image.map(|pixel| pixel.alpha());
    let mut out = bled_from(image, &alpha);
    for (out, pixel) in out.pixels_mut().iter_mut().zip(image.pixels()) {
        out.0[3] = pixel.alpha();
    }
    out
}

/// `map` with all four channels continued from where `alpha` is above 0 to where it is 0: for maps
/// that belong to a picture of that alpha.
///
/// # Panics
/// When the two have different sizes.
pub fn bled_from(map: &Image<Straight>, alpha: &Image<u8>) -> Image<Straight> {
    assert_eq!(
        (map.width(), map.height()),
        (alpha.width(), alpha.height()),
        "a map is as large as its picture"
    );
    let pyramid = pushed(map, alpha);
    let filled = pulled(&pyramid);
    let mut out = map.clone();
    let known = alpha.pixels().par_iter().zip(&filled.texels);
    out.pixels_mut()
        .par_iter_mut()
        .zip(known)
        .filter(|(_, (alpha, _))| **alpha == 0)
        .for_each(|(out, (_, [r, g, b, a, _]))| *out = Straight([*r, *g, *b, *a].map(rounded)));
    out
}

fn rounded(value: f32) -> u8 {
    (value + 0.5).clamp(0.0, 255.0) as u8
}

/// Weighted sums: four channels times weight, and the weight (0 to 1).
type Texel = [f32; 5];

struct Level {
    width: usize,
    height: usize,
    texels: Vec<Texel>,
}

/// From the whole picture down to one texel.
fn pushed(map: &Image<Straight>, alpha: &Image<u8>) -> Vec<Level> {
    let texels = map.pixels().par_iter().zip(alpha.pixels());
    let first = Level {
        width: map.width() as usize,
        height: map.height() as usize,
        texels: texels
            .map(|(pixel, &alpha)| {
                let weight = f32::from(alpha) / 255.0;
                let [r, g, b, a] = pixel.0.map(|value| f32::from(value) * weight);
                [r, g, b, a, weight]
            })
            .collect(),
    };
    let mut levels = vec![first];
    while let Some(last) = levels.last().filter(|last| last.width.max(last.height) > 1) {
        let next = halved(last);
        levels.push(next);
    }
    levels
}

fn halved(level: &Level) -> Level {
    let (width, height) = (level.width.div_ceil(2), level.height.div_ceil(2));
    let mut texels = vec![[0.0; 5]; width * height];
    texels
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let rows = 2 * y..(2 * y + 2).min(level.height);
            for (x, out) in row.iter_mut().enumerate() {
                let columns = 2 * x..(2 * x + 2).min(level.width);
                for source in rows.clone().map(|row| row * level.width) {
                    for texel in &level.texels[source + columns.start..source + columns.end] {
                        for (sum, value) in out.iter_mut().zip(texel) {
                            *sum += 0.25 * value;
                        }
                    }
                }
            }
        });
    Level {
        width,
        height,
        texels,
    }
}

/// From one texel up to the whole picture: full colours everywhere, of weight 1.
fn pulled(pyramid: &[Level]) -> Level {
    let mut coarse: Option<Level> = None;
    for level in pyramid.iter().rev() {
        let mut texels = level.texels.clone();
        texels
            .par_chunks_mut(level.width)
            .enumerate()
            .for_each(|(y, row)| {
                for (x, texel) in row.iter_mut().enumerate() {
                    let below = coarse.as_ref().map(|coarse| interpolated(coarse, x, y));
                    *texel = completed(*texel, below);
                }
            });
        coarse = Some(Level {
            width: level.width,
            height: level.height,
            texels,
        });
    }
    coarse.unwrap_or_else(|| unreachable!("a picture has a level"))
}

/// The colour of a weighted sum, completed by that of the coarser level.
fn completed(sum: Texel, below: Option<Texel>) -> Texel {
    let weight = sum[4];
    let below = below.unwrap_or([0.0; 5]);
    if weight <= 0.0 {
        return [below[0], below[1], below[2], below[3], 1.0];
    }
    let share = (weight / ENOUGH).min(1.0);
    let mut out = [1.0; 5];
    for channel in 0..4 {
        let own = sum[channel] / weight;
        out[channel] = if below[4] > 0.0 {
            below[channel] + share * (own - below[channel])
        } else {
            own
        };
    }
    out
}

/// Bilinear sample of the coarser level at texel (x, y) of the finer one.
fn interpolated(coarse: &Level, x: usize, y: usize) -> Texel {
    // The neighbour on the side where the fine texel lies takes a quarter.
    let taps = |at: usize, count: usize| {
        let near = at / 2;
        let far = if at.is_multiple_of(2) {
            near.saturating_sub(1)
        } else {
            (near + 1).min(count - 1)
        };
        [(near, 0.75), (far, 0.25)]
    };
    let mut out = [0.0; 5];
    for (row, across) in taps(y, coarse.height) {
        for (column, down) in taps(x, coarse.width) {
            let texel = &coarse.texels[row * coarse.width + column];
            for (sum, value) in out.iter_mut().zip(texel) {
                *sum += across * down * value;
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shows_stays_and_what_is_clear_gets_the_colour_beside_it() {
        let mut image = Image::filled(37, 21, Straight([0, 0, 0, 0]));
        for y in 8..12 {
            image.set(3, y, Straight([200, 40, 20, 255]));
            image.set(33, y, Straight([10, 160, 220, 90]));
        }
        let out = bled(&image);
        for (out, pixel) in out.pixels().iter().zip(image.pixels()) {
            assert_eq!(out.alpha(), pixel.alpha());
            if pixel.alpha() > 0 {
                assert_eq!(out, pixel);
            }
            // No channel leaves the range of the two colours: nothing of the black ground comes in.
            assert!((10..=200).contains(&out.0[0]) && out.0[1] >= 40 && out.0[2] >= 20);
        }
        assert!(out.at(1, 9).0[0] > 150, "{:?}", out.at(1, 9));
        assert!(out.at(35, 9).0[2] > 150, "{:?}", out.at(35, 9));
    }

    #[test]
    fn an_empty_picture_stays_empty() {
        let image = Image::filled(5, 3, Straight([0; 4]));
        assert_eq!(bled(&image), image);
    }
}
