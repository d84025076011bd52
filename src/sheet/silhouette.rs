//! An outline as a picture.

use super::paint::{Canvas, Rgba, closed};
use crate::geometry::Point;
use crate::raster::{Image, Premultiplied};

const INSIDE: Rgba = [112, 124, 106, 255];
const LINE: Rgba = [44, 54, 44, 255];

/// The closed outline `contour`, filled and drawn round, on clear ground of `size` pixels square.
pub fn silhouette(contour: &[Point], size: u32) -> Image<Premultiplied> {
    let mut canvas = Canvas::new(size, size, [0; 4]);
    let path = closed([contour], 1.0, Point::splat(0.5));
    canvas.fill(path.as_ref(), INSIDE);
    canvas.stroke(path.as_ref(), (f64::from(size) / 220.0).max(0.8), LINE);
    canvas.into_image().premultiplied()
}
