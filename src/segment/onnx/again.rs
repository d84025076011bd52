//! A second look at the foot of the tree.
//!
//! A trunk is a twentieth of a photograph's width, five pixels of what the network sees: too few for
//! its edges. So the network looks at the part around it again, twice as large or more, and what it
//! says there takes the place of what it said first, fading in from the borders of that part.

use super::guided::PLANES;
use super::letterbox::Letterbox;
use super::likelihood::{CROWN, TRUNK};
use crate::raster::{Image, Mask, Rect, component_sizes, labelled_components, opaque_bounds};

/// Likelihood of trunk from which on a place may be one.
const MAY_BE_TRUNK: f32 = 0.3;

/// Likelihood of trunk and crown together from which on a place of a photograph is tree: the outermost
/// leaves are seen through, and people draw around them.
pub(super) const TREE: f32 = 0.4;

/// Rows of the tree in which its foot is, counted from below, where no trunk is seen: one in so many.
const LOWEST: u32 = 10;

/// A part as large as this is not worth a second look, as part of the picture's longer side.
const LARGEST: f64 = 0.8;

/// Part of its side over which what was seen again fades in: one in so many.
const FADE: f32 = 7.0;

/// The part of the picture to look at again: a square about the likeliest trunk or the lowest part of
/// the tree, twice as high as that and half the picture at least. `None` where there is no tree, or
/// nothing to gain.
pub(super) fn foot(likelihoods: &Image<[f32; PLANES]>, letterbox: &Letterbox) -> Option<Rect> {
    let Letterbox { crop, inner, .. } = *letterbox;
    let seen = likelihoods.cropped(inner.x, inner.y, inner.width, inner.height);
    let found = trunk(&seen).or_else(|| lowest(&seen))?;
    let (width, height) = (f64::from(inner.width), f64::from(inner.height));
    let longest = width.max(height);
    let side = (2.0 * f64::from(found.height)).max(longest / 2.0);
    if side > LARGEST * longest {
        return None;
    }
    let middle = f64::from(found.x) + f64::from(found.width) / 2.0;
    let bottom = (f64::from(found.y + found.height) + side / 4.0).min(height);
    let columns = [middle - side / 2.0, middle + side / 2.0];
    let left_right = columns.map(|x| x.clamp(0.0, width) * f64::from(crop.width) / width);
    let rows = [(bottom - side).max(0.0), bottom];
    let top_bottom = rows.map(|y| y * f64::from(crop.height) / height);
    let [left, right] = left_right.map(|x| (x + 0.5) as u32);
    let [top, bottom] = top_bottom.map(|y| (y + 0.5) as u32);
    (right > left && bottom > top).then(|| Rect {
        x: crop.x + left,
        y: crop.y + top,
        width: right - left,
        height: bottom - top,
    })
}

/// The bounds of the largest piece that may be trunk.
fn trunk(seen: &Image<[f32; PLANES]>) -> Option<Rect> {
    let numbers = labelled_components(&seen.map(|own| own[TRUNK] > MAY_BE_TRUNK));
    let counts = component_sizes(&numbers);
    let largest = (1..counts.len())
        .rev()
        .max_by_key(|&number| counts[number])?;
    opaque_bounds(&numbers.map(|&number| number as usize == largest))
}

/// The bounds of the lowest part of the tree.
fn lowest(seen: &Image<[f32; PLANES]>) -> Option<Rect> {
    let mut tree: Mask = seen.map(|own| own[TRUNK] + own[CROWN] > TREE);
    let bounds = opaque_bounds(&tree)?;
    for y in bounds.y..bounds.y + bounds.height - bounds.height.div_ceil(LOWEST) {
        tree.row_mut(y).fill(false);
    }
    opaque_bounds(&tree)
}

/// Puts what was seen of the picture's part `part` into `fine`, which shows its part `crop`.
pub(super) fn put(
    fine: &mut Image<[f32; PLANES]>,
    crop: Rect,
    again: &Image<[f32; PLANES]>,
    part: Rect,
) {
    let across = ramp(
        part.width,
        part.x > crop.x,
        part.x + part.width < crop.x + crop.width,
    );
    let down = ramp(
        part.height,
        part.y > crop.y,
        part.y + part.height < crop.y + crop.height,
    );
    for (y, down) in (0..part.height).zip(&down) {
        let from = (part.x - crop.x) as usize;
        let row = &mut fine.row_mut(part.y - crop.y + y)[from..from + part.width as usize];
        for ((own, seen), across) in row.iter_mut().zip(again.row(y)).zip(&across) {
            for (own, seen) in own.iter_mut().zip(seen) {
                *own += down * across * (seen - *own);
            }
        }
    }
}

/// How much what was seen again counts, along one axis.
fn ramp(count: u32, rises: bool, falls: bool) -> Vec<f32> {
    let weight = |i: u32| {
        let at = (i as f32 + 0.5) / count as f32 * FADE;
        let up = if rises { at.min(1.0) } else { 1.0 };
        let down = if falls { (FADE - at).min(1.0) } else { 1.0 };
        up.min(down)
    };
    (0..count).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rect(x: u32, y: u32, width: u32, height: u32) -> Rect {
        Rect {
            x,
            y,
            width,
            height,
        }
    }

    /// A picture of 400 × 800, seen at 32 × 64, with a stem of these columns and rows.
    fn seen(stem: Rect, what: [f32; PLANES]) -> (Image<[f32; PLANES]>, Letterbox) {
        let letterbox = Letterbox::new(rect(0, 0, 400, 800), 64, 64);
        let mut likelihoods = Image::filled(64, 64, [0.0; PLANES]);
        for y in stem.y..stem.y + stem.height {
            for x in stem.x..stem.x + stem.width {
                likelihoods.set(16 + x, y, what);
            }
        }
        (likelihoods, letterbox)
    }

    #[test]
    fn the_trunk_is_looked_at_again() {
        let (likelihoods, letterbox) = seen(rect(15, 40, 2, 12), [0.8, 0.1]);
        // 32 of the 64 rows, the lowest 8 of them below the trunk; all columns.
        let found = foot(&likelihoods, &letterbox).unwrap();
        assert_eq!(found, rect(0, 350, 400, 400));
        let (likelihoods, letterbox) = seen(rect(15, 20, 2, 40), [0.8, 0.1]);
        assert_eq!(foot(&likelihoods, &letterbox), None);
    }

    #[test]
    fn without_a_trunk_the_lowest_leaves_are_looked_at_again() {
        let (likelihoods, letterbox) = seen(rect(2, 0, 9, 50), [0.1, 0.8]);
        let found = foot(&likelihoods, &letterbox).unwrap();
        assert_eq!(found, rect(0, 325, 281, 400));
        let (likelihoods, letterbox) = seen(rect(0, 0, 0, 0), [0.0, 0.0]);
        assert_eq!(foot(&likelihoods, &letterbox), None);
    }

    #[test]
    fn what_was_seen_again_fades_in_from_the_borders_within_the_picture() {
        let mut fine = Image::filled(28, 28, [0.0, 1.0]);
        let part = rect(0, 14, 14, 14);
        let again = Image::filled(14, 14, [1.0, 0.0]);
        put(&mut fine, rect(0, 0, 28, 28), &again, part);
        assert_eq!(fine.at(0, 27), [1.0, 0.0]);
        assert_eq!(fine.at(0, 13), [0.0, 1.0]);
        assert_eq!(fine.at(0, 14), [0.25, 0.75]);
        assert_eq!(fine.at(13, 27), [0.25, 0.75]);
        assert_eq!(fine.at(14, 27), [0.0, 1.0]);
    }
}
