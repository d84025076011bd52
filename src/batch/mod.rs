//! Jobs that fill folders: many trees from a library, a library for an engine.
//!
//! The command line and the studio's batches do the same work here: both make a checked job of what
//! they were told and run it in the surroundings of a [`run::Run`]. What stands in the way of a job
//! is found before it begins; each file is written whole or not at all; the same inputs, settings and
//! seed give the same bytes, whoever asks.
//!
//! Imports `base`, `raster`, `geometry`, `contour`, `segment`, `paint`, `branches`, `variation`, `scene`,
//! `crown`, `document`, `pipeline`, `render` (for its errors), `export`, `sheet`.

pub(crate) mod crown;
pub(crate) mod export;
pub(crate) mod export_crown;
mod export_pages;
mod export_shared;
pub(crate) mod export_tree;
pub(crate) mod failure;
pub(crate) mod input;
pub(crate) mod items;
pub(crate) mod library;
pub(crate) mod model;
pub(crate) mod output;
pub(crate) mod parents;
pub(crate) mod project_crowns;
pub(crate) mod records;
pub(crate) mod run;
pub(crate) mod score;
pub(crate) mod sheets;
mod stamp;
pub(crate) mod tree_crown;
pub(crate) mod vary;

pub use export_crown::ImpostorName;
pub use export_tree::{ExportMap, ModelTextures, TextureForm};
pub use vary::MapName;
