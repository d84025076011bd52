//! Pictures of a scene: passes for graphics cards through wgpu, and their twin on the processor.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! chapter 5 ("the thesis" below).
//!
//! Imports `base`, `raster`, `geometry`, `branches` (leaves, bark), `crown`, `scene`.

mod ambient;
mod boughs;
mod color;
pub mod cpu;
mod error;
mod frame;
mod fronds;
mod gpu;
mod leaf_atlas;
mod leaf_pictures;
mod leaf_set;
mod mesh;
mod needles;
mod pace;
mod packed_cube;
mod prepared;
mod proxy;
mod renderer;
mod ribs;
mod settings;
mod shaders;
mod shoot;
mod surface;

pub(crate) use color::{linear, srgb_byte};
pub use error::RenderError;
pub(crate) use frame::leaf_area;
pub use frame::{CrownNumbers, Frame, InstanceNumbers, SceneView};
pub use gpu::{Gpu, GpuRenderer, Shown, Viewport};
pub use leaf_atlas::LeafAtlas;
pub(crate) use leaf_pictures::leaf_pictures;
pub use leaf_set::LeafSet;
pub(crate) use mesh::on_trunk;
pub use mesh::{MeshVertex, PreparedMesh};
pub use packed_cube::PackedCube;
pub use prepared::PreparedCrown;
pub use proxy::Proxy;
pub use renderer::{Backend, Renderer};
pub(crate) use ribs::{EVEN, INNER, Ribs, RibsFrom, WIDEST, bough_root, in_tiers};
pub use settings::{
    LeafClip, LeafSettings, Mode, Occlusion, ReliefSettings, RenderSettings, Shortcut,
    SwitchSettings, View,
};
pub use shaders::Pass;
