//! The shape of a crown: from a mask to a base mesh, from a photograph to relief, from both to the
//! radius of the crown in every direction.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! chapter 4 ("the thesis" below). In the plane of the mask coordinates are those of images; a
//! height z points out of the picture towards the viewer, in pixels.
//!
//! Imports `base`, `raster`, `geometry`, `solve`.

mod domain;
mod inflation;
mod restart;

pub use domain::{Domain, RingPixel};
pub use inflation::{Inflation, InflationError, Sheet};
