//! Files that other programs take: one file a format. Functions here make bytes; who writes them to
//! disk is the caller.
//!
//! Imports `base`, `raster`, `geometry`, `crown`, `scene`.

mod atlas;
mod crown_folder;
mod crown_mesh;
mod glb;
mod obj;
mod ply;

pub use atlas::{AtlasLayout, atlas};
pub use crown_folder::{
    CROWN_RECORD, CrownFolderError, CrownRecord, crown_file_names, crown_files, crown_from_files,
};
pub use crown_mesh::crown_glb;
pub use glb::{GlbError, MeshParts, glb};
pub use obj::obj;
pub use ply::{PlyError, decode_ply, encode_ply};
