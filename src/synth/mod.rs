//! Foliage from an example: textures of any size that look like the crown of a photograph, and
//! cubemaps of them without a visible edge.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! section 4.5 ("the thesis" below).
//!
//! Imports `base`, `raster`, `solve`, `crown`.

mod assembly;
mod cube_seam;
mod seam;

pub use assembly::{assembled, band, even_angles, texture_sizes};
pub use cube_seam::cube_seam;
pub use seam::{Seam, Side, StepCost, seam};
