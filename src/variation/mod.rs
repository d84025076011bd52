//! New trees from old ones: exemplars, their outlines combined, their colours warped and mixed.
//!
//! After Argudo, Andújar & Chica, *Tree Variations* (2017); what we do otherwise is said where it
//! is done.
//!
//! Imports `base`, `raster`, `geometry`, `contour`, `segment`.

mod distortion;
mod exemplar;
mod mean_value;
mod mix;
mod normalize;
mod sampling;
mod synthesis;
mod warp;

pub use distortion::Distortion;
pub use exemplar::{Exemplar, ExemplarError, ExemplarSettings, Outlined, Shape};
pub use mean_value::{Cage, CageError, coordinates, mapped_exactly};
pub use normalize::{Normalized, Placement, normalized};
pub use synthesis::{Layout, Source, Variation, synthesized};
pub use warp::{Warp, WarpPrecision};
