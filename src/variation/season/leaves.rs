//! Which pixels of a crown are leaves, how light they are, and how the crown lies in the picture.

use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Rect, Straight, opaque_bounds, row_ends, smoothed_within};
use crate::segment::Label;
use crate::variation::{Tree, hsl};
use rayon::prelude::*;

/// Hues of leaves, in turns: from orange to blue-green.
const LEAF_HUES: [f64; 2] = [24.0 / 360.0, 175.0 / 360.0];

/// Hues of green leaves.
const GREEN_HUES: [f64; 2] = [62.0 / 360.0, 175.0 / 360.0];

/// Saturation below which a pixel is wood, sky or snow rather than leaf, and from which it is leaf.
const SATURATION: [f64; 2] = [0.08, 0.22];

/// Share of leaves below which, and density of the crown below which, a tree counts as bare.
const BARE_LEAVES: f64 = 0.25;
const BARE_DENSITY: f64 = 0.55;

/// The leaves of a crown.
pub(super) struct Leaves {
    /// How much each pixel is leaf, 0 to 1; 0 outside the crown.
    pub(super) share: Image<f32>,
    /// Light of each pixel, 0 to 255.
    pub(super) light: Image<u8>,
    /// Light minus the mean around, in standard deviations: above 0 for lit leaves.
    pub(super) relief: Image<f32>,
    /// The crown's bounds.
    pub(super) bounds: Rect,
    green: f64,
    density: f64,
}

impl Leaves {
    /// The leaves of `tree`; `None` when it has no crown.
    pub(super) fn of(tree: &Tree, cancel: &Cancel) -> Result<Option<Self>, Cancelled> {
        let crown = tree.labels.map(|label| *label == Label::Crown);
        let Some(bounds) = opaque_bounds(&crown) else {
            return Ok(None);
        };
        let light = tree.image.map(|pixel| light(*pixel));
        let pixels = tree.image.pixels().par_iter().zip(tree.labels.pixels());
        let (share, is_green): (Vec<f32>, Vec<bool>) = pixels
            .map(|(pixel, label)| match label {
                Label::Crown => leafage(*pixel),
                _ => (0.0, false),
            })
            .unzip();
        let all = crown.count() as f64;
        let leafy: f64 = share.iter().map(|share| f64::from(*share)).sum();
        let green = is_green.into_iter().filter(|green| *green).count() as f64;
        let share = Image::from_pixels(light.width(), light.height(), share);
        let values = light.map(|&light| f32::from(light));
        let sigma = f64::from(bounds.height) / 40.0;
        let mean = smoothed_within(&values, &crown, sigma, cancel)?;
        let difference = values.pixels().iter().zip(mean.pixels());
        let difference: Vec<f32> = difference.map(|(value, mean)| value - mean).collect();
        let inside = difference.iter().zip(crown.pixels());
        let energy: f64 = inside
            .filter(|(_, crown)| **crown)
            .map(|(value, _)| f64::from(value * value))
            .sum();
        let deviation = (energy / all).sqrt().max(1.0) as f32;
        let relief = difference.iter().map(|value| value / deviation).collect();
        let density = all / extent(&crown, bounds).max(1.0);
        Ok(Some(Self {
            relief: Image::from_pixels(light.width(), light.height(), relief),
            share: if leafy < BARE_LEAVES * all && density >= BARE_DENSITY {
                // Leaves of no leaf colour, grey olives say: all of the crown is leaves.
                crown.map(|&crown| f32::from(u8::from(crown)))
            } else {
                share
            },
            light,
            bounds,
            green: green / all,
            density,
        }))
    }

    /// Pixels that are leaf.
    pub(super) fn count(&self) -> usize {
        let share = self.share.pixels().iter();
        share.filter(|share| **share > 0.0).count()
    }

    /// Whether most of the crown is green.
    pub(super) fn are_green(&self) -> bool {
        self.green > 0.4
    }

    /// Whether the crown is limbs already.
    pub(super) fn are_fallen(&self) -> bool {
        self.density < BARE_DENSITY && self.green < BARE_LEAVES
    }
}

/// Pixels between the first and the last of each row.
fn extent(crown: &Mask, bounds: Rect) -> f64 {
    let rows = bounds.y..bounds.y + bounds.height;
    let widths = rows.filter_map(|y| {
        let [first, last] = row_ends(crown.row(y), |&inside| inside)?;
        Some((last - first + 1) as f64)
    });
    widths.sum()
}

/// Whether a pixel shows a green leaf.
pub(super) fn is_green_leaf(pixel: Straight) -> bool {
    leafage(pixel).1
}

/// How much a pixel of a crown is leaf, 0 to 1, and whether it is a green one.
fn leafage(pixel: Straight) -> (f32, bool) {
    let [r, g, b, _] = pixel.0;
    let [hue, saturation, lightness] = hsl([r, g, b]);
    // In deep shade colour means little, and most of it is leaf.
    let dark = (1.6 - lightness / 0.09).clamp(0.0, 1.0);
    let [low, high] = SATURATION;
    let coloured = match is_between(hue, LEAF_HUES) {
        true => ((saturation - low) / (high - low)).clamp(0.0, 1.0),
        false => 0.0,
    };
    let share = coloured.max(dark) as f32;
    (share, is_between(hue, GREEN_HUES) && share > 0.3)
}

fn is_between(value: f64, [low, high]: [f64; 2]) -> bool {
    (low..=high).contains(&value)
}

/// Luminance, 0 to 255.
pub(super) fn light(pixel: Straight) -> u8 {
    let [r, g, b, _] = pixel.0.map(u32::from);
    ((54 * r + 183 * g + 19 * b) / 256) as u8
}
