//! Files that other programs take: one file a format. Functions here make bytes; who writes them to
//! disk is the caller.
//!
//! Imports `base`, `raster`, `geometry`, `scene`.

mod atlas;
mod crown_folder;
mod ply;

pub use atlas::{AtlasLayout, atlas};
pub use crown_folder::{
    CROWN_RECORD, CrownFolderError, CrownRecord, crown_file_names, crown_files, crown_from_files,
};
pub use ply::{PlyError, decode_ply, encode_ply};
