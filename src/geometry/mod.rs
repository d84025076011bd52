//! Shapes without pictures: polylines and polygons in the plane.
//!
//! Coordinates are those of images: x to the right, y down, lengths in pixels.
//!
//! Imports `base`.

mod equal_chords;
mod polygon;

pub use equal_chords::equal_chords;
pub use polygon::{Polygon, contains, perimeter, segments_cross, self_crossings, signed_area};

/// A point or vector in the plane; x to the right, y down, in pixels unless said otherwise.
pub type Point = glam::DVec2;
