//! Resolved plain data: what renderers draw and exporters write. Nothing here is computed.
//!
//! World frame: right-handed, +Y up, metres, the tree's base at the origin, the photograph's plane
//! at z = 0, the viewer at +Z.
//!
//! Imports `base`, `raster`, `geometry`, `branches` (kinds of bark).

mod camera;
mod crown;
mod instance;
mod light;
mod stem_look;
mod trunk;

pub use camera::{Camera, ViewAxes};
pub use crown::Crown;
pub use instance::CrownInstance;
pub use light::{Backdrop, Light};
pub use stem_look::StemLook;
pub use trunk::Trunk;
