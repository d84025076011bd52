//! All borders of a mask, by border following.
//!
//! Suzuki & Abe, *Topological structural analysis of digitized binary images by border following*
//! (1985), as implemented by `imageproc`. Foreground is 8-connected; the points of a border are
//! centres of foreground pixels.

use crate::geometry::{Point, signed_area};
use crate::raster::{Image, Mask};
use imageproc::contours::{BorderType, find_contours};

/// One border of a mask.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Pixel centres along the border; each is a neighbour of the next, the last of the first.
    /// Pixels that the border passes twice (thin twigs) are listed twice.
    pub points: Vec<Point>,
    /// Index of the border around this one, if any.
    pub parent: Option<usize>,
    /// Whether this is the border of a hole.
    pub is_hole: bool,
}

/// All borders of a mask.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outlines {
    /// In the order in which a scan by rows from the top meets them.
    pub all: Vec<Outline>,
}

impl Outlines {
    /// Borders that are inside no other: the outer borders of separate parts (TV §4.2).
    pub fn exterior(&self) -> impl Iterator<Item = &Outline> {
        self.all.iter().filter(|outline| outline.parent.is_none())
    }

    /// The exterior border of most points, counter-clockwise as seen on screen; the first one of
    /// several. `None` for an empty mask.
    pub fn longest_exterior(&self) -> Option<Vec<Point>> {
        let mut longest: Option<&Outline> = None;
        for outline in self.exterior() {
            if longest.is_none_or(|best| outline.points.len() > best.points.len()) {
                longest = Some(outline);
            }
        }
        let mut points = longest?.points.clone();
        if signed_area(&points) < 0.0 {
            points[1..].reverse();
        }
        Some(points)
    }
}

/// All borders of `mask`, with who surrounds whom.
pub fn outlines(mask: &Mask) -> Outlines {
    // A frame of background: the method assumes one, and so no border is cut by the image's edge.
    let (width, height) = (mask.width() + 2, mask.height() + 2);
    let mut framed = image::GrayImage::new(width, height);
    for y in 0..mask.height() {
        for (x, _) in mask
            .row(y)
            .iter()
            .enumerate()
            .filter(|(_, inside)| **inside)
        {
            framed.put_pixel(x as u32 + 1, y + 1, image::Luma([255]));
        }
    }
    let all = find_contours::<i32>(&framed)
        .into_iter()
        .map(|contour| Outline {
            points: contour
                .points
                .iter()
                .map(|p| Point::new(f64::from(p.x - 1), f64::from(p.y - 1)))
                .collect(),
            parent: contour.parent,
            is_hole: contour.border_type == BorderType::Hole,
        })
        .collect();
    Outlines { all }
}

/// The mask of all points inside the closed `contour`, shifted by `offset`, on a canvas of
/// `width` × `height`: the contour drawn, and everything that a flood from outside cannot reach
/// (TV §5.1). The contour may reach beyond the canvas.
pub fn filled(contour: &[Point], offset: Point, width: u32, height: u32) -> Mask {
    // The flood needs a closed line and a way round it.
    let beyond = contour
        .iter()
        .map(|&point| point + offset)
        .map(|p| {
            (-p).max(p - Point::new(f64::from(width), f64::from(height)))
                .max_element()
        })
        .fold(0.0, f64::max);
    let margin = beyond.ceil().min(MOST_BEYOND_PX) as u32 + 2;
    let shift = offset + f64::from(margin);
    let mut barrier = Image::filled(width + 2 * margin, height + 2 * margin, false);
    for (a, b) in contour.iter().zip(contour.iter().cycle().skip(1)) {
        draw_line(&mut barrier, *a + shift, *b + shift);
    }
    crate::raster::flooded_from_outside(&barrier).cropped(margin, margin, width, height)
}

/// How far beyond the canvas a contour is followed. Cages reach some ten pixels; a limit only
/// keeps absurd input from asking for absurd memory.
const MOST_BEYOND_PX: f64 = 4096.0;

/// Marks an 8-connected chain of pixels from `a` to `b`.
fn draw_line(mask: &mut Mask, a: Point, b: Point) {
    let steps = (b - a).abs().max_element().ceil().max(1.0);
    for i in 0..=steps as u32 {
        let point = a.lerp(b, f64::from(i) / steps).round();
        let inside = point.x >= 0.0
            && point.y >= 0.0
            && point.x < f64::from(mask.width())
            && point.y < f64::from(mask.height());
        if inside {
            mask.set(point.x as u32, point.y as u32, true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::mask;

    #[test]
    fn a_ring_has_an_outer_border_and_a_hole_inside_it() {
        let found = outlines(&mask(&["###", "#.#", "###"]));
        assert_eq!(found.all.len(), 2);
        assert_eq!(found.exterior().count(), 1);
        assert!(found.all[1].is_hole);
        assert_eq!(found.all[1].parent, Some(0));
        let longest = found.longest_exterior().unwrap();
        assert_eq!(longest.len(), 8);
        assert!(signed_area(&longest) > 0.0, "counter-clockwise on screen");
    }

    #[test]
    fn parts_at_the_edge_of_the_image_are_found() {
        let found = outlines(&mask(&["##.", "##.", "..#"]));
        assert_eq!(found.exterior().count(), 1, "corners connect");
        assert_eq!(
            outlines(&mask(&["#"])).longest_exterior(),
            Some(vec![Point::ZERO])
        );
        assert_eq!(outlines(&mask(&["..."])).longest_exterior(), None);
    }

    #[test]
    fn filling_an_outline_gives_the_mask_without_holes() {
        let full = mask(&[".....", ".###.", ".###.", ".###.", "....."]);
        let ring = mask(&[".....", ".###.", ".#.#.", ".###.", "....."]);
        let longest = outlines(&ring).longest_exterior().unwrap();
        assert_eq!(filled(&longest, Point::ZERO, 5, 5), full);
    }

    #[test]
    fn a_contour_that_reaches_beyond_the_canvas_is_filled() {
        let square = [(-3.0, -3.0), (-3.0, 9.0), (2.0, 9.0), (2.0, -3.0)].map(Point::from);
        let inside = filled(&square, Point::ZERO, 5, 2);
        assert_eq!(inside, mask(&["###..", "###.."]));
    }
}
