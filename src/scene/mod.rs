//! Resolved plain data: what renderers draw and exporters write. Nothing here is computed.
//!
//! World frame: right-handed, +Y up, metres, the tree's base at the origin, the photograph's plane
//! at z = 0, the viewer at +Z.
//!
//! Imports `base`, `raster`, `geometry`.

mod crown;

pub use crown::Crown;
