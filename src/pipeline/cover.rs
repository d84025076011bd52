//! How much of a crown's outline its leaves fill: in sparse crowns one sees sky and the stem.
//!
//! Only a cut-out tells: in a photograph sky behind the leaves is as opaque as they are.

use super::pictured::Pixels;
use crate::raster::{Image, Rect, Straight, closed_and_filled};

/// How wide bays and gaps may be that belong to the outline which leaves are spread in, as a share of the
/// crown's longer side.
const BAY: f64 = 0.045;

/// Longer side of what is looked at, pixels.
const LONGEST: u32 = 512;

/// Least alpha that shows.
const SEEN: u8 = 96;

/// Every so many pixels along each side a picture is asked whether it is a cut-out.
const ASKED: usize = 8;

/// How much of its outline the crown fills in `photo`, 0 … 1; `None` unless that is a cut-out.
pub(super) fn cover_in(photo: &Image<Straight>, crown: &Pixels<'_>) -> Option<f64> {
    let rows = (0..photo.height()).step_by(ASKED);
    let mut asked = rows.flat_map(|y| photo.row(y).iter().step_by(ASKED));
    let is_cut_out = asked.any(|pixel| pixel.alpha() < SEEN);
    let alpha = |x: u32, y: u32| match (crown.has)(x, y) {
        true => photo.at(x, y).alpha(),
        false => 0,
    };
    is_cut_out.then(|| cover(alpha, crown.bounds))
}

/// The mean alpha, 0 … 1, within the outline around what shows in `bounds`.
fn cover(alpha: impl Fn(u32, u32) -> u8, bounds: Rect) -> f64 {
    let step = bounds.width.max(bounds.height).div_ceil(LONGEST);
    let [width, height] = [bounds.width, bounds.height].map(|side| side.div_ceil(step));
    let reach = (BAY * f64::from(width.max(height)))
        .round()
        .clamp(1.0, 60.0) as u32;
    let mut thinned = Image::filled(width + 2 * reach, height + 2 * reach, 0u8);
    for y in 0..height {
        for x in 0..width {
            let value = alpha(bounds.x + x * step, bounds.y + y * step);
            thinned.set(x + reach, y + reach, value);
        }
    }
    let outline = closed_and_filled(&thinned.map(|&alpha| alpha >= SEEN), reach as u8);
    let within = thinned.pixels().iter().zip(outline.pixels());
    let (mut sum, mut count) = (0.0, 0.0);
    for (&alpha, _) in within.filter(|(_, is_within)| **is_within) {
        sum += f64::from(alpha) / 255.0;
        count += 1.0;
    }
    (sum / f64::max(count, 1.0)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branches::leaf_name::LeafName;
    use crate::pipeline::CrownSettings;
    use crate::raster::Mask;

    fn cover_of((photo, mask): (Image<Straight>, Mask), leaf: LeafName) -> f64 {
        let nothing = mask.map(|_| false);
        let settings = CrownSettings::default();
        settings.masked(&photo, [&mask, &nothing], leaf).cover
    }

    /// A disc of leaves in a grid of `step` pixels, each half as wide.
    fn leaves(step: u32, sky: Straight) -> (Image<Straight>, Mask) {
        let is_leaf = |i: u32| {
            let (x, y) = (i % 400, i / 400);
            let is_in_disc = x.abs_diff(200).pow(2) + y.abs_diff(200).pow(2) < 150 * 150;
            is_in_disc && x % step < step / 2 && y % step < step / 2
        };
        let mask = Mask::from_pixels(400, 400, (0..160_000).map(is_leaf).collect());
        let color = |&leaf: &bool| match leaf {
            true => Straight([60, 120, 40, 255]),
            false => sky,
        };
        (mask.map(color), mask)
    }

    #[test]
    fn a_cut_out_with_leaves_on_a_quarter_of_its_outline_has_that_cover() {
        let tree = leaves(8, Straight([0; 4]));
        let found = cover_of(tree.clone(), LeafName::Ovate);
        assert!((0.22..0.32).contains(&found), "{found}");
        assert_eq!(cover_of(tree, LeafName::Frond), 1.0);
    }

    #[test]
    fn a_photograph_tells_nothing_of_its_cover() {
        let tree = leaves(8, Straight([150, 180, 230, 255]));
        assert_eq!(cover_of(tree, LeafName::Ovate), 1.0);
    }
}
