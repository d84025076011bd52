//! From what a user gives to a scene: which steps follow one another, with which settings.
//!
//! The command line and the studio call the same functions here with the same settings, so that
//! the same inputs give the same bytes.
//!
//! Imports `base`, `raster`, `geometry`, `paint`, `crown`, `synth`, `scene`, `document` (settings).

mod crown;
mod frame;
mod live;
mod request;
mod tree_maps;

pub use crown::{
    ColoredSurface, CrownError, CrownSettings, CrownShape, TRUNK_SHARE, colored_surface, crown,
    crown_of_regions, crown_shape,
};
pub use frame::CrownFrame;
pub use live::{LiveCrown, LiveInput, LiveResult, Quality};
pub use request::{CrownRequest, is_crown};
pub use tree_maps::{DEPTH_SHARE, TreeMaps, tree_maps};
