//! A cut-out: a flat mesh around what shows of a sprite, so that a card draws fewer clear pixels.
//!
//! What shows is grown by some pixels, its outer borders are followed and simplified (Ramer 1972,
//! Douglas & Peucker 1973) by less than it was grown, so that no pixel that shows is cut off; then
//! the polygons are triangulated (constrained Delaunay). Growing starts small and goes on until the
//! polygons have few enough vertices. Holes are not cut: they cost vertices and save little.
//!
//! Limits: tiny separate parts count like all others; if even the widest growth leaves too many
//! vertices, or the simplified polygons cross one another, the answer is the whole frame.

use super::cards::Flat;
use super::sprite::Sprite;
use crate::contour::outlines;
use crate::geometry::{Point, Polygon, contains, signed_area};
use crate::raster::{Mask, dilated};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

/// Growth in shares of the frame's longer side, tried in this order.
const GROWTHS: [f64; 5] = [0.006, 0.01, 0.016, 0.025, 0.04];

/// Largest growth in pixels that [`dilated`] takes.
const LARGEST_GROWTH_PX: f64 = 250.0;

/// Of the growth, what simplification may use; the rest keeps filters away from the edge.
const SIMPLIFIED_SHARE: f64 = 0.8;

/// Least alpha that is kept inside: half of the cutoff, for what bilinear filters bring above it.
const LEAST_ALPHA: u8 = 64;

/// A cut-out and what it saves.
#[derive(Debug, Clone, PartialEq)]
pub struct Cutout {
    /// The mesh, in pixels of the canvas.
    pub flat: Flat,
    /// Its area as a share of the frame's rectangle: 1 − this is the overdraw saved.
    pub area: f64,
}

/// A cut-out of at most about `most_vertices` vertices.
pub fn cutout(sprite: &Sprite, most_vertices: usize) -> Cutout {
    let mask = sprite.image.map(|pixel| pixel.alpha() >= LEAST_ALPHA);
    let frame = sprite.frame;
    let side = f64::from(frame.width.max(frame.height));
    GROWTHS
        .iter()
        .find_map(|share| {
            let growth = (share * side).clamp(2.0, LARGEST_GROWTH_PX) as u8;
            let polygons = polygons(&mask, growth);
            let vertices: usize = polygons.iter().map(Vec::len).sum();
            if vertices > most_vertices {
                return None;
            }
            let flat = triangulated(&polygons)?;
            let area = flat.area() / (f64::from(frame.width) * f64::from(frame.height));
            (area < 1.0).then_some(Cutout { flat, area })
        })
        .unwrap_or_else(|| Cutout {
            flat: Flat::rectangle(sprite.corners()),
            area: 1.0,
        })
}

/// The simplified outer borders of `mask` grown by `growth` pixels; in positions (corners at whole
/// numbers), kept on the canvas.
fn polygons(mask: &Mask, growth: u8) -> Vec<Polygon> {
    let grown = dilated(mask, growth);
    let (width, height) = (f64::from(mask.width()), f64::from(mask.height()));
    let tolerance = SIMPLIFIED_SHARE * f64::from(growth);
    outlines(&grown)
        .exterior()
        .map(|outline| {
            // Pixel centres become positions; borders on the canvas' edge reach to the edge.
            let to_edge = |at: f64, side: f64| match at {
                at if at <= 0.0 => 0.0,
                at if at >= side - 1.0 => side,
                at => at + 0.5,
            };
            let place = |p: &Point| Point::new(to_edge(p.x, width), to_edge(p.y, height));
            simplified(
                &outline.points.iter().map(place).collect::<Vec<_>>(),
                tolerance,
            )
        })
        .filter(|polygon| polygon.len() >= 3 && signed_area(polygon).abs() > 1.0)
        .collect()
}

/// A closed polyline with vertices left out that are nearer than `tolerance` to what remains.
fn simplified(points: &[Point], tolerance: f64) -> Polygon {
    // Two points far apart split the loop into two chains.
    let first = points[0];
    let farthest = (0..points.len())
        .max_by(|&a, &b| {
            first
                .distance(points[a])
                .total_cmp(&first.distance(points[b]))
        })
        .unwrap_or(0);
    let mut kept = vec![false; points.len() + 1];
    kept[0] = true;
    kept[farthest] = true;
    let closed: Vec<Point> = points.iter().copied().chain([first]).collect();
    let mut chains = vec![(0, farthest), (farthest, points.len())];
    while let Some((from, to)) = chains.pop() {
        let (mut worst, mut at) = (tolerance, None);
        for i in from + 1..to {
            let distance = distance_to_segment(closed[i], closed[from], closed[to]);
            if distance > worst {
                (worst, at) = (distance, Some(i));
            }
        }
        if let Some(at) = at {
            kept[at] = true;
            chains.extend([(from, at), (at, to)]);
        }
    }
    let vertices = points.iter().zip(&kept).filter(|(_, kept)| **kept);
    vertices.map(|(point, _)| *point).collect()
}

fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let along = b - a;
    let length = along.length_squared();
    let t = if length > 0.0 {
        ((p - a).dot(along) / length).clamp(0.0, 1.0)
    } else {
        0.0
    };
    p.distance(a + along * t)
}

/// The inside of `polygons` as triangles, `None` when they cross one another.
fn triangulated(polygons: &[Polygon]) -> Option<Flat> {
    let mut cdt = ConstrainedDelaunayTriangulation::<Point2<f64>>::new();
    for polygon in polygons {
        let handles = polygon
            .iter()
            .map(|p| cdt.insert(Point2::new(p.x, p.y)).ok())
            .collect::<Option<Vec<_>>>()?;
        for (i, &from) in handles.iter().enumerate() {
            let to = handles[(i + 1) % handles.len()];
            if from != to
                && cdt.try_add_constraint(from, to).is_empty()
                && !cdt.exists_constraint(from, to)
            {
                return None;
            }
        }
    }
    let vertices: Vec<Point> = cdt
        .vertices()
        .map(|v| Point::new(v.position().x, v.position().y))
        .collect();
    let triangles = cdt
        .inner_faces()
        .filter_map(|face| {
            let corners = face.vertices().map(|vertex| vertex.fix().index());
            let centre = corners.iter().map(|&i| vertices[i]).sum::<Point>() / 3.0;
            let inside = polygons.iter().any(|polygon| contains(polygon, centre));
            inside.then(|| corners.map(|i| i as u32))
        })
        .collect();
    Some(Flat::new(vertices, triangles))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::SpriteSettings;
    use crate::raster::{Image, Straight};

    /// A lollipop: a round crown on a thin trunk.
    fn sprite() -> Sprite {
        let mut image = Image::filled(200, 300, Straight([0; 4]));
        for y in 0..300u32 {
            for x in 0..200u32 {
                let (dx, dy) = (f64::from(x) - 100.0, f64::from(y) - 90.0);
                if dx.hypot(dy) < 80.0 || (dx.abs() < 6.0 && y >= 90) {
                    image.set(x, y, Straight([50, 120, 40, 255]));
                }
            }
        }
        Sprite::new(&image, Point::new(100.0, 299.0), SpriteSettings::default()).unwrap()
    }

    #[test]
    fn all_that_shows_is_inside_and_overdraw_is_saved() {
        let sprite = sprite();
        let cut = cutout(&sprite, 64);
        assert!(cut.area < 0.6, "{}", cut.area);
        assert!(cut.flat.vertices.len() <= 64);
        for y in 0..sprite.image.height() {
            for x in 0..sprite.image.width() {
                if sprite.image.at(x, y).alpha() >= 128 {
                    let centre = Point::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
                    assert!(cut.flat.contains(centre), "({x}, {y})");
                }
            }
        }
    }

    #[test]
    fn with_too_few_vertices_the_frame_is_taken() {
        let cut = cutout(&sprite(), 3);
        assert_eq!((cut.flat.vertices.len(), cut.area), (4, 1.0));
    }
}
