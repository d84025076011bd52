//! Where a crown stands and how large it is: from the pixels of its mask to metres.

use crate::crown::{Envelope, crown_center, envelope};
use crate::geometry::Point;
use crate::raster::{Image, Mask, Premultiplied, Rect, opaque_bounds, resized};
use glam::DVec3;

/// From the pixels of a mask to the frame of the tree: metres, +Y up, the tree's base at the origin,
/// the picture's plane at z = 0.
///
/// The crown's bounds have the height that the user gives. Their lowest row lies at the height of the
/// trunk, their middle above the tree's base: a trunk that leans is not known from a crown's mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrownFrame {
    /// Metres of a pixel of the mask that is inflated.
    pub metres_per_pixel: f64,
    /// Height of the crown's lowest point above the ground.
    pub base_m: f64,
    /// The centre of the crown.
    pub center_m: DVec3,
}

impl CrownFrame {
    /// The frame of the crown `mask`, `height_m` high with its lowest row at `base_m`.
    ///
    /// # Panics
    /// When the mask is empty.
    pub fn new(mask: &Mask, height_m: f64, base_m: f64) -> Self {
        let bounds = opaque_bounds(mask).expect("the mask is not empty");
        let center = crown_center(mask).expect("the mask is not empty");
        let metres_per_pixel = height_m / f64::from(bounds.height);
        let frame = Self {
            metres_per_pixel,
            base_m,
            center_m: DVec3::ZERO,
        };
        Self {
            center_m: frame.world_from_mask(bounds, center),
            ..frame
        }
    }

    /// The place of a pixel of the mask with these `bounds`, in the picture's plane.
    pub fn world_from_mask(&self, bounds: Rect, pixel: Point) -> DVec3 {
        let middle = f64::from(bounds.x) + f64::from(bounds.width - 1) / 2.0;
        let bottom = f64::from(bounds.y + bounds.height) - 0.5;
        let place = DVec3::new(pixel.x - middle, bottom - pixel.y, 0.0);
        place * self.metres_per_pixel + DVec3::Y * self.base_m
    }
}

/// The volume of a crown as a mask, at the scale at which it is inflated.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Volume {
    /// The envelope of the crown.
    pub(super) mask: Mask,
    /// Pixels of it for one of the photograph.
    pub(super) scale: f64,
    /// Where its first pixel's corner lies in the photograph, pixels from the corner there.
    origin: Point,
}

impl Volume {
    /// The envelope of `mask` after scaling so that the crown's longer side has `longest` pixels;
    /// `None` when nothing is left of it.
    pub(super) fn new(mask: &Mask, longest: u32, settings: &Envelope) -> Option<Self> {
        let bounds = opaque_bounds(mask)?;
        let scale = f64::from(longest) / f64::from(bounds.width.max(bounds.height));
        let scaled = resized_mask(mask, bounds, scale);
        let (mask, from) = envelope(&scaled, settings)?;
        let corner = Point::new(f64::from(bounds.x), f64::from(bounds.y));
        Some(Self {
            mask,
            scale,
            origin: corner + Point::new(from[0] as f64, from[1] as f64) / scale,
        })
    }

    /// As [`Volume::new`] for the union of `regions` (masks of one size): each has its own envelope,
    /// which is given too, a mask of the volume's size. `None` when nothing is left of one.
    pub(super) fn of_regions(
        regions: &[&Mask],
        longest: u32,
        settings: &Envelope,
    ) -> Option<(Self, Vec<Mask>)> {
        let bounds = opaque_bounds(&union(regions)?)?;
        let scale = f64::from(longest) / f64::from(bounds.width.max(bounds.height));
        let scaled = regions.iter().map(|mask| resized_mask(mask, bounds, scale));
        let envelopes: Vec<(Mask, [i64; 2])> = scaled
            .map(|mask| envelope(&mask, settings))
            .collect::<Option<_>>()?;
        let first = |axis: usize| envelopes.iter().map(|(_, from)| from[axis]).min();
        let from = [first(0)?, first(1)?];
        let end = |axis: usize| {
            let ends = envelopes
                .iter()
                .map(|(mask, from)| from[axis] + i64::from([mask.width(), mask.height()][axis]));
            ends.max()
        };
        let [width, height] = [(end(0)? - from[0]) as u32, (end(1)? - from[1]) as u32];
        let placed = |(mask, at): &(Mask, [i64; 2])| {
            let (left, top) = ((at[0] - from[0]) as usize, (at[1] - from[1]) as u32);
            let mut placed = Image::filled(width, height, false);
            for y in 0..mask.height() {
                let row = &mut placed.row_mut(top + y)[left..][..mask.width() as usize];
                row.copy_from_slice(mask.row(y));
            }
            placed
        };
        let masks: Vec<Mask> = envelopes.iter().map(placed).collect();
        let corner = Point::new(f64::from(bounds.x), f64::from(bounds.y));
        let volume = Self {
            mask: union(&masks.iter().collect::<Vec<_>>())?,
            scale,
            origin: corner + Point::new(from[0] as f64, from[1] as f64) / scale,
        };
        Some((volume, masks))
    }

    /// The place in the photograph of a place in the mask; pixel centres are whole in both.
    pub(super) fn photo_from_mask(&self, place: Point) -> Point {
        self.origin + (place + 0.5) / self.scale - 0.5
    }
}

/// The pixels of all `masks`, which have one size; `None` when there are none.
pub(super) fn union(masks: &[&Mask]) -> Option<Mask> {
    let (first, others) = masks.split_first()?;
    let mut all = (*first).clone();
    for mask in others {
        for (all, &own) in all.pixels_mut().iter_mut().zip(mask.pixels()) {
            *all |= own;
        }
    }
    Some(all)
}

fn scaled_size(bounds: Rect, scale: f64) -> [u32; 2] {
    [bounds.width, bounds.height].map(|side| (f64::from(side) * scale).round().max(1.0) as u32)
}

fn resized_mask(mask: &Mask, bounds: Rect, scale: f64) -> Mask {
    let [width, height] = scaled_size(bounds, scale);
    if [width, height] == [bounds.width, bounds.height] {
        return mask.cropped(bounds.x, bounds.y, bounds.width, bounds.height);
    }
    let cover = mask.map(|&inside| Premultiplied([if inside { 255 } else { 0 }; 4]));
    resized(&cover, bounds, width, height).map(|pixel| pixel.alpha() >= 128)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crowns_bounds_get_the_height_and_stand_on_the_trunk() {
        let mut mask = Image::filled(20, 30, false);
        for y in 5..25 {
            mask.row_mut(y)[4..14].fill(true);
        }
        let frame = CrownFrame::new(&mask, 8.0, 2.0);
        assert_eq!(frame.metres_per_pixel, 0.4);
        assert!(frame.center_m.distance(DVec3::new(0.0, 6.0, 0.0)) < 1e-9);
        let volume = Volume::new(
            &mask,
            40,
            &Envelope {
                close: 0.0,
                open: 0.0,
            },
        )
        .unwrap();
        assert_eq!((volume.mask.width(), volume.mask.height()), (22, 42));
        // The first of two pixels that the photograph's pixel (4, 5) became.
        let place = volume.photo_from_mask(Point::new(1.0, 1.0));
        assert!(place.distance(Point::new(3.75, 4.75)) < 1e-9);
    }

    #[test]
    fn regions_keep_their_places_in_one_frame() {
        let block = |left: usize| {
            let mut mask = Image::filled(40, 30, false);
            for y in 10..20 {
                mask.row_mut(y)[left..left + 10].fill(true);
            }
            mask
        };
        let (left, right) = (block(5), block(25));
        let sharp = Envelope {
            close: 0.0,
            open: 0.0,
        };
        let (volume, masks) = Volume::of_regions(&[&left, &right], 60, &sharp).unwrap();
        assert_eq!((volume.mask.width(), volume.mask.height()), (62, 22));
        assert_eq!(volume.mask.count(), 800);
        let bounds = |mask: &Mask| opaque_bounds(mask).map(|b| (b.x, b.y, b.width, b.height));
        assert_eq!(bounds(&masks[0]), Some((1, 1, 20, 20)));
        assert_eq!(bounds(&masks[1]), Some((41, 1, 20, 20)));
        // As that of the union where nothing is closed or cut.
        let both = union(&[&left, &right]).unwrap();
        let whole = Volume::new(&both, 60, &sharp);
        assert!(whole.is_none_or(|whole| whole.origin == volume.origin));
        assert!(Volume::of_regions(&[], 60, &sharp).is_none());
    }
}
