//! New trees from old ones: exemplars, their outlines combined, their colours warped and mixed.
//!
//! After Argudo, Andújar & Chica, *Tree Variations* (2017); what we do otherwise is said where it
//! is done.
//!
//! Imports `base`, `raster`, `geometry`, `contour`, `segment`.

mod histogram;
mod mean_value;
mod sampling;
mod warp;
mod warp_image;

pub use histogram::{Histogram, Transfer};
pub use mean_value::{Cage, CageError, coordinates, mapped_exactly};
pub use warp::{Warp, WarpPrecision};
pub use warp_image::{inside_polygons, warped};
