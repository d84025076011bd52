//! Files that other programs take: one file a format. Functions here make bytes; who writes them to
//! disk is the caller.
//!
//! A picture of a tree becomes a [`Sprite`] (trimmed, bled, with its foot and its size in metres);
//! from it come mip chains, block-compressed textures, atlas pages, cards and glTF files.
//!
//! A crown becomes models with levels of detail ([`CrownModel`]), impostors ([`Impostor`]) and
//! cubemaps.
//!
//! Imports `base`, `raster`, `geometry`, `contour`, `branches` (twigs), `crown`, `scene`, `render`
//! (the bark of stems).

mod atlas;
mod atlas_json;
mod bleed;
mod blocks;
mod cards;
mod crown_folder;
mod crown_mesh;
mod crown_model;
mod cutout;
mod dds;
mod exr;
mod gallery;
mod glb;
mod impostor;
mod ktx2_file;
mod leaf_alpha;
mod leaf_cards;
mod lod_model;
mod mips;
mod model_mesh;
mod obj;
mod ply;
mod preset;
mod record;
mod rib_cards;
mod scatter;
mod sprite;
mod sprite_atlas;
mod stem;
mod tree_model;
mod twig_outline;
mod uastc;

pub use atlas::{AtlasLayout, atlas};
pub use atlas_json::{AtlasSprite, atlas_json_array, atlas_json_hash};
pub use bleed::{bled, bled_from};
pub use blocks::{BlockFormat, CompressedLevels, compressed};
pub use cards::{Flat, crossed};
pub use crown_folder::{
    CROWN_RECORD, CrownFilesError, CrownFolderError, CrownRecord, crown_file_names, crown_files,
    crown_from_files,
};
pub use crown_mesh::crown_glb;
pub use crown_model::{CrownModel, ModelMaterial, leaf_model, surface_model};
pub use cutout::{Cutout, cutout};
pub use dds::encode_dds;
pub use exr::{encode_exr_colors, encode_exr_values};
pub use gallery::{GalleryTree, gallery_crown, gallery_list, gallery_page, gallery_tree};
pub use glb::{Glb, GlbError, Instance, Material, MeshId, NodeId};
pub use impostor::{
    Impostor, ImpostorForm, ImpostorSettings, frame_direction, godot_shader, impostor, portrait,
    three_module,
};
pub use ktx2_file::{encode_ktx2, encode_ktx2_colors, encode_ktx2_radii};
pub use lod_model::{LodModel, LodStyle, WindChannels, lod_glb};
pub use mips::{ALPHA_CUTOFF, coverage, data_mips, mips, normal_mips};
pub use model_mesh::ModelMesh;
pub use obj::obj;
pub use ply::{PlyError, decode_ply, encode_ply};
pub use preset::{Preset, TextureStyle};
pub use record::{
    CutoutRecord, ImpostorRecord, LicenseRecord, PresetCrown, PresetLibrary, PresetTree,
};
pub use scatter::{ScatterSettings, scattered};
pub use sprite::{Sprite, SpriteError, SpriteSettings};
pub use sprite_atlas::{
    AtlasError, AtlasSettings, PageContent, Placed, SpriteLayout, atlas_layout, atlas_page,
};
pub use tree_model::{Lod, TreeModel};
