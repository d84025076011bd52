//! Shapes without pictures: polylines and polygons in the plane, triangle meshes in space.
//!
//! Coordinates in the plane are those of images: x to the right, y down, lengths in pixels. Those in
//! space are the world's: right-handed, +Y up, the viewer at +Z, metres unless said otherwise.
//!
//! Imports `base`.

mod equal_chords;
mod mesh;
mod polygon;
mod topology;

pub use equal_chords::equal_chords;
pub use mesh::Mesh;
pub use polygon::{Polygon, contains, signed_area};
pub use topology::Topology;

/// A point or vector in the plane; x to the right, y down, in pixels unless said otherwise.
pub type Point = glam::DVec2;
