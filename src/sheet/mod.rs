//! Pictures for people: what a tree's outline looks like, many trees side by side.
//!
//! Plain pixels, drawn with `tiny-skia`: the same bits on every machine, no window needed.
//!
//! Imports `base`, `raster`, `geometry`, `contour`.

mod contact;
mod font;
mod map;
mod overlay;
mod paint;
mod scene;
mod silhouette;
mod stand;
mod table;

pub use contact::{Cell, contact_sheet};
pub use map::map_sheet;
pub use overlay::{Overlay, overlay};
pub use silhouette::silhouette;
pub use stand::{Forest, rows_of_trees};
pub use table::table_sheet;
