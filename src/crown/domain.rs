//! What the pixels of a mask are to the inflation: unknown, silhouette, or the ring outside.
//!
//! Source: the thesis, §4.3.2. The silhouette are the pixels of the mask with one of their four
//! neighbours outside (so it is 8-connected); the ring are the pixels outside with one of their four
//! neighbours in the mask. Wherever the 13-point stencil of an unknown reaches beyond the unknowns,
//! it meets a pixel of one of the two.
//!
//! Departure: the thesis places an outer pixel half a pixel outside "its" silhouette pixel without
//! saying which of several; we take the mean over all four neighbours that belong to the mask. The
//! frame of the image is outside, so a mask may touch it.

use super::InflationError;
use crate::geometry::Point;
use crate::raster::{Image, Mask, Rect, opaque_bounds};

/// The four neighbours of a pixel.
const NEIGHBOURS: [(i64, i64); 4] = [(0, -1), (-1, 0), (1, 0), (0, 1)];

/// The eight neighbours of a pixel, by eighths of a turn from +x towards +y.
pub(super) const AROUND: [(i64, i64); 8] = [
    (1, 0),
    (1, 1),
    (0, 1),
    (-1, 1),
    (-1, 0),
    (-1, -1),
    (0, -1),
    (1, -1),
];

/// A pixel just outside the mask.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RingPixel {
    /// Column, from −1 to the width of the mask.
    pub x: i32,
    /// Row, from −1 to the height of the mask.
    pub y: i32,
    /// Where the surface passes behind the silhouette here: the mean of the points half-way to the
    /// neighbours in the mask, in mask pixels.
    pub position: Point,
}

/// A mask and the classes of its pixels.
#[derive(Debug, Clone)]
pub struct Domain {
    mask: Mask,
    bounds: Rect,
    pixels: Vec<(u32, u32)>,
    silhouette: Vec<bool>,
    unknown: Mask,
    ring: Vec<RingPixel>,
}

impl Domain {
    /// Classifies the pixels of `mask`.
    ///
    /// # Errors
    /// When the mask is empty.
    pub fn new(mask: &Mask) -> Result<Self, InflationError> {
        let bounds = opaque_bounds(mask).ok_or(InflationError::Empty)?;
        let inside = |x: i64, y: i64| mask.get(x, y) == Some(true);
        let mut unknown = Image::filled(mask.width(), mask.height(), false);
        let (mut pixels, mut silhouette) = (Vec::new(), Vec::new());
        for y in 0..mask.height() {
            for x in (0..mask.width()).filter(|&x| mask.at(x, y)) {
                let all = neighbours(x.into(), y.into()).all(|(x, y)| inside(x, y));
                unknown.set(x, y, all);
                pixels.push((x, y));
                silhouette.push(!all);
            }
        }
        Ok(Self {
            ring: ring(mask, bounds),
            mask: mask.clone(),
            bounds,
            pixels,
            silhouette,
            unknown,
        })
    }

    /// The mask.
    pub fn mask(&self) -> &Mask {
        &self.mask
    }

    /// All pixels of the mask, row by row from the top.
    pub fn pixels(&self) -> &[(u32, u32)] {
        &self.pixels
    }

    /// Whether pixel number `pixel` of [`Self::pixels`] is on the silhouette.
    pub fn is_silhouette(&self, pixel: usize) -> bool {
        self.silhouette[pixel]
    }

    /// Number of pixels off the silhouette.
    pub fn unknowns(&self) -> usize {
        self.silhouette.iter().filter(|is| !**is).count()
    }

    /// The pixels off the silhouette, as a mask.
    pub fn interior(&self) -> &Mask {
        &self.unknown
    }

    /// The pixels just outside the mask, row by row from the top.
    pub fn ring(&self) -> &[RingPixel] {
        &self.ring
    }

    /// The smallest rectangle around the mask's pixels.
    pub fn bounds(&self) -> Rect {
        self.bounds
    }
}

fn neighbours(x: i64, y: i64) -> impl Iterator<Item = (i64, i64)> {
    NEIGHBOURS.into_iter().map(move |(dx, dy)| (x + dx, y + dy))
}

fn ring(mask: &Mask, bounds: Rect) -> Vec<RingPixel> {
    let inside = |&(x, y): &(i64, i64)| mask.get(x, y) == Some(true);
    let (left, top) = (i64::from(bounds.x), i64::from(bounds.y));
    let (right, bottom) = (
        left + i64::from(bounds.width),
        top + i64::from(bounds.height),
    );
    let mut ring = Vec::new();
    for (x, y) in (top - 1..=bottom).flat_map(|y| (left - 1..=right).map(move |x| (x, y))) {
        if inside(&(x, y)) {
            continue;
        }
        let (mut sum, mut count) = ((0, 0), 0);
        for (nx, ny) in neighbours(x, y).filter(inside) {
            sum = (sum.0 + nx, sum.1 + ny);
            count += 1;
        }
        if count > 0 {
            let mean = Point::new(sum.0 as f64, sum.1 as f64) / f64::from(count);
            let own = Point::new(x as f64, y as f64);
            ring.push(RingPixel {
                x: x as i32,
                y: y as i32,
                position: (own + mean) / 2.0,
            });
        }
    }
    ring
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_pixel_has_four_around_it() {
        let domain = Domain::new(&Image::filled(1, 1, true)).unwrap();
        assert_eq!(domain.unknowns(), 0);
        assert!(domain.is_silhouette(0));
        let places: Vec<_> = domain.ring().iter().map(|r| (r.x, r.y)).collect();
        assert_eq!(places, [(0, -1), (-1, 0), (1, 0), (0, 1)]);
        assert_eq!(domain.ring()[2].position, Point::new(0.5, 0.0));
    }

    #[test]
    fn a_square_has_one_unknown_and_a_notch_two_neighbours() {
        let domain = Domain::new(&Image::filled(3, 3, true)).unwrap();
        assert_eq!(domain.unknowns(), 1);
        assert_eq!(domain.ring().len(), 12);
        let notch = Image::from_pixels(2, 2, vec![true, true, true, false]);
        let domain = Domain::new(&notch).unwrap();
        let corner = domain.ring().iter().find(|r| (r.x, r.y) == (1, 1)).unwrap();
        assert_eq!(corner.position, Point::new(0.75, 0.75));
    }

    #[test]
    fn an_empty_mask_is_refused() {
        let empty = Image::filled(4, 4, false);
        assert!(matches!(Domain::new(&empty), Err(InflationError::Empty)));
    }
}
