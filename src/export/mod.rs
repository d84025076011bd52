//! Files that other programs take: one file a format. Functions here make bytes; who writes them to
//! disk is the caller.
//!
//! Imports `base`, `raster`, `geometry`, `scene`.

mod glb;
mod obj;

pub use glb::{GlbError, MeshParts, glb};
pub use obj::obj;
