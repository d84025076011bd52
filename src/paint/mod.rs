//! Painting masks by hand: labels in tiles that remember cheaply, and the tools that change them.
//!
//! Every tool is a function on plain data. Brushes change a [`TiledMask`] and return the rectangle
//! that changed; selecting tools return a *selection*, a [`TiledMask`] of 0 and 1, that
//! [`painted`] or the morphology then uses. What took its time can be cancelled and is the same for
//! any number of threads.
//!
//! Labels: 0 background, 1 crown, 2 trunk, 3 and up sub-crowns (see [`CROWN`], [`TRUNK`]).
//! Coordinates are those of images, pixel centres at whole numbers.
//!
//! Imports `base`, `raster`, `geometry`, `solve`, `segment`.

mod brush;
mod color_model;
mod flood;
mod grey;
mod livewire;
mod morphology;
mod pack;
mod patch;
mod polygon;
mod reduced;
mod smart;
mod tiled;
mod whole;

pub use brush::{BrushSettings, Sample, Stroke};
pub use flood::{Reach, color_selection, region_selection};
pub use grey::{LAST_GREY_LABEL, grey_from_mask, grey_of, mask_from_grey, mask_from_picture};
pub use livewire::Livewire;
pub use morphology::{grown, shrunk, smoothed};
pub use pack::{PackError, PackedTile};
pub use patch::{MaskPatch, Side};
pub use polygon::{FillRule, polygon_selection};
pub use reduced::{MOST_REDUCED, changed_tiles, mean_colors, pixel_borders};
pub use smart::{INSIDE, OUTSIDE, smart_selection};
pub use tiled::{BACKGROUND, CROWN, Over, Paint, TILE, TRUNK, TiledMask, joined, painted};
pub use whole::{Mirror, holes_filled, inverted, mirrored, without_specks};
