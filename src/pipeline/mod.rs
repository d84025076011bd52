//! From what a user gives to a scene: which steps follow one another, with which settings.
//!
//! The command line and the studio call the same functions here with the same settings, so that
//! the same inputs give the same bytes.
//!
//! Imports `base`, `raster`, `geometry`, `contour`, `segment`, `paint`, `variation`, `crown`, `synth`,
//! `scene`, `document` (settings).

mod cover;
mod crown;
mod frame;
mod gallery;
mod k_map;
mod leaf;
mod live;
mod picture_shape;
mod pictured;
mod request;
mod stem;
mod tree_maps;

pub use crown::{
    ColoredSurface, CrownError, CrownSettings, CrownShape, Silhouette, TRUNK_SHARE,
    colored_surface, crown, crown_of_regions, crown_shape,
};
pub use frame::CrownFrame;
pub use gallery::{
    GalleryTree, Pool, Slot, Wishes, brood_of, choice_settings, favourite_of, gallery_slots,
    genome_of, parts_of_mix,
};
pub use k_map::k_on_mesh;
pub use leaf::leaf_of_picture;
pub use live::{LiveCrown, LiveInput, LiveResult, Quality};
pub use picture_shape::{PictureShape, picture_shape};
pub use pictured::Pixels;
pub use request::{CrownRequest, is_crown};
pub use tree_maps::{DEPTH_SHARE, TreeMaps, tree_maps};
