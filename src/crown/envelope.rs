//! The envelope of a crown: its mask without gaps, bays and loose twigs.
//!
//! Masks of real crowns follow every gap in the foliage. A thin plate is held down along each of
//! them, so that an inflated mask of an oak comes out as a pancake (the thesis asks for dense crowns
//! for this reason, §4.1.1). A crown's *volume* has no such gaps: sky seen between two branches lies
//! between what is in front and what is behind. So the mask is closed (bays narrower than twice
//! [`Envelope::close`] vanish), its holes are filled, it is opened (twigs thinner than twice
//! [`Envelope::open`] vanish), and the largest part is kept. The fine silhouette comes back with the
//! relief.

use super::chamfer::{PIXEL, chamfer};
use crate::raster::{
    Image, Mask, component_sizes, flooded_from_outside, labelled_components, opaque_bounds,
};
use serde::{Deserialize, Serialize};

/// How much of a mask's outline belongs to the crown's volume.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Envelope {
    /// Radius of the bays that are filled, as a share of the crown's longer side, 0 … 0.25.
    pub close: f64,
    /// Radius of the spurs that are cut off, as a share of the crown's longer side, 0 … 0.25.
    pub open: f64,
}

impl Default for Envelope {
    /// An oak's bays between its boughs are up to a tenth of its height wide; its twigs stick out of
    /// the crown by less than a fortieth.
    fn default() -> Self {
        Self {
            close: 0.05,
            open: 0.025,
        }
    }
}

/// The envelope of `mask`, cropped to its bounds with one pixel around, and where its first pixel lies
/// in `mask` (outside, mostly); `None` when `mask` is empty.
///
/// ```
/// use boscage::{crown::{Envelope, envelope}, raster::Image};
/// // A square of 20 pixels with a hole and a slot.
/// let mut mask = Image::filled(20, 20, true);
/// mask.set(10, 10, false);
/// mask.row_mut(4)[..8].fill(false);
/// let (whole, from) = envelope(&mask, &Envelope::default()).unwrap();
/// assert_eq!((whole.width(), from), (22, [-1, -1]));
/// assert!(whole.at(11, 11) && whole.at(4, 5));
/// ```
pub fn envelope(mask: &Mask, settings: &Envelope) -> Option<(Mask, [i64; 2])> {
    let bounds = opaque_bounds(mask)?;
    let longest = f64::from(bounds.width.max(bounds.height));
    let thirds = |share: f64| (share * longest * f64::from(PIXEL)).round() as u32;
    let (close, open) = (thirds(settings.close), thirds(settings.open));
    let margin = close / PIXEL + 2;
    let mut padded = Image::filled(bounds.width + 2 * margin, bounds.height + 2 * margin, false);
    for y in 0..bounds.height {
        let row = &mask.row(bounds.y + y)[bounds.x as usize..][..bounds.width as usize];
        padded.row_mut(y + margin)[margin as usize..][..row.len()].copy_from_slice(row);
    }
    let closed = shrunk(&grown(&padded, close), close);
    let filled = flooded_from_outside(&closed);
    let opened = grown(&shrunk(&filled, open), open);
    let part = largest_part(if opened.count() > 0 { &opened } else { &filled });
    let found = opaque_bounds(&part)?;
    let (x, y) = (found.x - 1, found.y - 1);
    let cropped = part.cropped(x, y, found.width + 2, found.height + 2);
    let from = |bound: u32, at: u32| i64::from(bound) + i64::from(at) - i64::from(margin);
    Some((cropped, [from(bounds.x, x), from(bounds.y, y)]))
}

fn grown(mask: &Mask, thirds: u32) -> Mask {
    chamfer(mask, false).map(|&distance| distance <= thirds)
}

fn shrunk(mask: &Mask, thirds: u32) -> Mask {
    chamfer(&mask.map(|inside| !inside), true).map(|&distance| distance > thirds)
}

/// The component with the most pixels, the first of several.
fn largest_part(mask: &Mask) -> Mask {
    let labels = labelled_components(mask);
    let sizes = component_sizes(&labels);
    let largest = (1..sizes.len()).rev().max_by_key(|&label| sizes[label]);
    labels.map(|&label| Some(label as usize) == largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(size: u32, inside: impl Fn(f64, f64) -> bool) -> Mask {
        let pixels = (0..size * size).map(|i| inside(f64::from(i % size), f64::from(i / size)));
        Image::from_pixels(size, size, pixels.collect())
    }

    #[test]
    fn slits_holes_spurs_and_specks_vanish_and_the_rest_stays() {
        let disc = |x: f64, y: f64| (x - 100.0).hypot(y - 100.0) <= 80.0;
        let torn = drawn(200, |x, y| {
            let slit = (x - 60.0).abs() < 5.0 && y < 100.0;
            let hole = (x - 130.0).hypot(y - 120.0) < 15.0;
            let spur = (y - 100.0).abs() < 2.0 && x > 100.0 && x < 198.0;
            let speck = (x - 10.0).hypot(y - 10.0) < 6.0;
            (disc(x, y) && !slit && !hole) || spur || speck
        });
        let found = envelope(&torn, &Envelope::default()).unwrap().0.count() as f64;
        let whole = drawn(200, disc).count() as f64;
        assert!((found / whole - 1.0).abs() < 0.02, "{found} of {whole}");
    }

    #[test]
    fn tiny_masks_stay_and_empty_ones_have_none() {
        let settings = Envelope::default();
        assert_eq!(
            envelope(&Image::filled(1, 1, true), &settings)
                .unwrap()
                .0
                .count(),
            1
        );
        assert_eq!(envelope(&Image::filled(3, 3, false), &settings), None);
        let line = Image::filled(60, 1, true);
        assert_eq!(envelope(&line, &settings).unwrap().0.count(), 60);
    }
}
