//! Pictures of a scene: passes for graphics cards through wgpu, and their twin on the processor.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! chapter 5 ("the thesis" below).
//!
//! Imports `base`, `raster`, `geometry`, `scene`.

mod ambient;
mod color;
pub mod cpu;
mod frame;
mod packed_cube;
mod prepared;
mod settings;
mod surface;

pub use frame::{CrownNumbers, Frame, InstanceNumbers, View3d};
pub use packed_cube::PackedCube;
pub use prepared::PreparedCrown;
pub use settings::{
    LeafClip, LeafSettings, Mode, Occlusion, ReliefSettings, RenderSettings, Shortcut, View,
};
