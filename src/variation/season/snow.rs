//! Snow on what faces the sky.
//!
//! A pixel catches snow when the sky is close above it (the upper rims of boughs and limbs), when it is
//! on the lit top of a clump, and the more the higher it stands; the best places are covered first.
//! Snow keeps the light and shade of what it lies on, in the colours of snow.

use super::colors::{Ramp, ramp_of};
use super::leaves::light;
use crate::base::{Cancel, Cancelled, Seed};
use crate::raster::{Image, Straight, opaque_bounds, smoothed_within};
use crate::segment::Label;
use crate::variation::Tree;
use crate::variation::noise::Noise;

/// Colours of snow from shade to light.
const SNOW: Ramp = [
    [148.0, 164.0, 190.0],
    [214.0, 222.0, 234.0],
    [252.0, 253.0, 255.0],
];

/// Share of a tree under snow when all that can be is.
const MOST: f64 = 0.62;

/// How far below the sky a rim still catches snow, and how large the clumps are, as shares of the
/// tree's height.
const RIM: f64 = 0.012;
const CLUMP: f64 = 0.014;

/// Lets snow fall on `tree`: `amount` 1 covers all that faces the sky.
pub(super) fn fall(
    tree: &mut Tree,
    amount: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let seen = tree.image.map(|pixel| pixel.alpha() >= 64);
    let Some(bounds) = opaque_bounds(&seen) else {
        return Ok(());
    };
    let height = f64::from(bounds.height);
    let lights = tree.image.map(|pixel| f32::from(light(*pixel)));
    let fine = smoothed_within(&lights, &seen, (0.25 * CLUMP * height).max(0.7), cancel)?;
    let coarse = smoothed_within(&lights, &seen, (2.0 * CLUMP * height).max(2.0), cancel)?;
    let rims = rims(&tree.image, (RIM * height).max(1.5) as u32);
    let noise = Noise::new(&mut seed.derive("snow", 0).random());
    let width = tree.image.width();
    let catch: Vec<f64> = (0..seen.pixels().len())
        .map(|at| {
            if !seen.pixels()[at] {
                return f64::NEG_INFINITY;
            }
            let (x, y) = ((at as u32 % width), (at as u32 / width));
            let up = 1.0 - f64::from(y.saturating_sub(bounds.y)) / height;
            let rim = f64::from(rims.pixels()[at]);
            let clump = f64::from(fine.pixels()[at] - coarse.pixels()[at]) / 22.0;
            let place = [x, y].map(|v| f64::from(v) / (0.03 * height));
            let grain = noise.at(place) - 0.5;
            if tree.labels.pixels()[at] == Label::Trunk {
                rim - 0.5
            } else {
                0.7 * rim + clump.clamp(-1.5, 1.5) + 0.25 * up + 0.35 * grain
            }
        })
        .collect();
    cancel.check()?;
    cover(&mut tree.image, &catch, &fine, &coarse, amount);
    Ok(())
}

/// Covers the share of pixels that catch most.
fn cover(
    image: &mut Image<Straight>,
    catch: &[f64],
    fine: &Image<f32>,
    coarse: &Image<f32>,
    amount: f64,
) {
    let mut sorted: Vec<f64> = catch.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| {
        let index = ((1.0 - share) * sorted.len() as f64) as usize;
        sorted
            .get(index.min(sorted.len().saturating_sub(1)))
            .copied()
            .unwrap_or(0.0)
    };
    let share = MOST * amount;
    // Soft over a tenth of the covered share on both sides.
    let (low, high) = (at((1.25 * share).min(1.0)), at(0.75 * share));
    for (place, pixel) in image.pixels_mut().iter_mut().enumerate() {
        if !catch[place].is_finite() {
            continue;
        }
        let t = ((catch[place] - low) / (high - low).max(1e-6)).clamp(0.0, 1.0);
        if t <= 0.0 {
            continue;
        }
        let own = f64::from(light(*pixel)) - f64::from(coarse.pixels()[place]);
        let local = f64::from(fine.pixels()[place] - coarse.pixels()[place]);
        let rank = (0.62 + own / 160.0 + local / 90.0).clamp(0.0, 1.0);
        let snow = ramp_of(&SNOW, rank);
        let mixed = |c: usize| {
            let (from, to) = (f64::from(pixel.0[c]), f64::from(snow[c]));
            (from + (to - from) * t + 0.5) as u8
        };
        *pixel = Straight([mixed(0), mixed(1), mixed(2), pixel.alpha()]);
    }
}

/// How close above each pixel the sky is: 1 right above it, 0 from `reach` pixels on; less on what is
/// too thin to carry much.
fn rims(image: &Image<Straight>, reach: u32) -> Image<f32> {
    let mut rims = image.map(|_| 0.0f32);
    for x in 0..image.width() {
        let mut y = 0;
        while y < image.height() {
            let is_wood = |y: u32| y < image.height() && image.at(x, y).alpha() >= 96;
            let from = y;
            while is_wood(y) {
                y += 1;
            }
            let thick = y - from;
            let carried = (thick as f32 / (1.5 * reach as f32)).min(1.0);
            for row in from..(from + reach).min(y) {
                rims.set(x, row, carried * (1.0 - (row - from) as f32 / reach as f32));
            }
            y += 1;
        }
    }
    rims
}
