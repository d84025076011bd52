//! Large sparse problems on pixel grids: linear systems (assembled once, factorised once, solved many
//! times) and minimum cuts.
//!
//! Imports `base`, `raster`.

mod min_cut;
mod network;

pub use min_cut::Cut;
pub use network::{Edge, HARD, Network};
