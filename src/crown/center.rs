//! The centre of a crown, from which its radius is measured.
//!
//! The thesis takes the centroid of the crown's area (§4.2.1): the best point in sight of all of the
//! silhouette is hardly better. A centroid can lie outside a crescent or beside a narrow bridge,
//! though, where the crown has no thickness and radii would be 0; then the centre moves to where the
//! crown is thick.

use super::chamfer::{PIXEL, chamfer};
use crate::geometry::Point;
use crate::raster::{Mask, opaque_bounds};

/// How thick the crown must be at its centroid, as a share of its thickest place: below this the
/// surface near the centre would show as a dent in the radius.
const THICK_ENOUGH: f64 = 0.4;

/// The centre of the crown `mask`, in its pixels: the centroid, or where that lies outside or in a
/// thin place the pixel that is thickest for its distance from the centroid. `None` when the mask is
/// empty.
///
/// ```
/// use boscage::{crown::crown_center, geometry::Point, raster::Image};
/// let disc = Image::from_pixels(21, 21, (0..441i32).map(|i| {
///     let (x, y) = (i % 21 - 10, i / 21 - 10);
///     x * x + y * y <= 81
/// }).collect());
/// assert_eq!(crown_center(&disc), Some(Point::new(10.0, 10.0)));
/// ```
pub fn crown_center(mask: &Mask) -> Option<Point> {
    opaque_bounds(mask)?;
    let inside = || {
        (0..mask.height()).flat_map(move |y| {
            let row = mask.row(y).iter().enumerate();
            row.filter(|(_, inside)| **inside)
                .map(move |(x, _)| (x as u32, y))
        })
    };
    let place = |(x, y): (u32, u32)| Point::new(f64::from(x), f64::from(y));
    let sum = inside().map(place).fold(Point::ZERO, |sum, p| sum + p);
    let centroid = sum / mask.count() as f64;
    let depth = chamfer(&mask.map(|inside| !inside), true);
    let deep = |(x, y): (u32, u32)| f64::from(depth.at(x, y)) / f64::from(PIXEL);
    let deepest = inside().map(deep).fold(0.0, f64::max);
    let nearest = (centroid.x.round() as u32, centroid.y.round() as u32);
    if mask.at(nearest.0, nearest.1) && deep(nearest) >= THICK_ENOUGH * deepest {
        return Some(centroid);
    }
    let worth = |pixel| deep(pixel) - 0.5 * place(pixel).distance(centroid);
    inside()
        .map(|pixel| (worth(pixel), pixel))
        .reduce(|best, next| if next.0 > best.0 { next } else { best })
        .map(|(_, pixel)| place(pixel))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    fn drawn(width: u32, height: u32, inside: impl Fn(f64, f64) -> bool) -> Mask {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let inside = pixels.map(|(x, y)| inside(f64::from(x), f64::from(y)));
        Image::from_pixels(width, height, inside.collect())
    }

    #[test]
    fn the_centre_of_a_ring_lies_in_its_middle_line() {
        let ring = drawn(101, 101, |x, y| {
            let r = (x - 50.0).hypot(y - 50.0);
            (30.0..=50.0).contains(&r)
        });
        let center = crown_center(&ring).unwrap();
        let r = (center.x - 50.0).hypot(center.y - 50.0);
        assert!((35.0..=45.0).contains(&r), "{r}");
    }

    #[test]
    fn a_bridge_between_two_discs_is_too_thin() {
        let dumbbell = drawn(141, 61, |x, y| {
            (x - 30.0).hypot(y - 30.0) <= 28.0
                || (x - 110.0).hypot(y - 30.0) <= 28.0
                || (y - 30.0).abs() <= 2.0 && (30.0..=110.0).contains(&x)
        });
        let center = crown_center(&dumbbell).unwrap();
        assert!((center.x - 70.0).abs() > 25.0, "{center}");
    }

    #[test]
    fn small_and_full_masks_have_centres_and_empty_ones_none() {
        assert_eq!(
            crown_center(&Image::filled(3, 1, true)),
            Some(Point::new(1.0, 0.0))
        );
        assert_eq!(crown_center(&Image::filled(1, 1, true)), Some(Point::ZERO));
        assert_eq!(crown_center(&Image::filled(4, 4, false)), None);
    }
}
