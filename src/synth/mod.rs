//! Foliage from an example: textures of any size that look like the crown of a photograph, and
//! cubemaps of them without a visible edge.
//!
//! An [`Exemplar`] is prepared once from a photograph and a mask: which pixels are foliage, how they
//! look at several levels of blur, and which look alike. [`texture`] joins pieces of it at the
//! coarsest level by graph cuts and then corrects the seams level by level, so that detail stays as
//! crisp as the photograph and features keep their size.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! section 4.5 ("the thesis" below). Departure: the pixels of finer levels are not searched for in
//! the whole exemplar (Wei & Levoy 2000) but carried along as coordinates and corrected (Lefebvre &
//! Hoppe 2005), which takes a second instead of three quarters of an hour.
//!
//! Imports `base`, `raster`, `geometry`, `solve`.

mod assembly;
mod canvas;
mod cube_seam;
mod cubemap;
mod edge_statistic;
mod exemplar;
mod flatten;
mod foliage;
mod level;
mod patches;
mod photo_front;
mod refine;
mod seam;
mod similar;
mod statistics;
mod texture;
mod unique;
mod wrapping;

pub use assembly::{Lattice, LatticeSize, assembled};
pub use canvas::Known;
pub use cube_seam::cube_seam;
pub use cubemap::{CubemapSettings, FoliageCubemap, extent_of, foliage_cubemap};
pub use edge_statistic::{EdgeStatistic, edge_statistic};
pub use exemplar::{Exemplar, ExemplarSettings, FEWEST_PIXELS, MOST_LEVELS};
pub use photo_front::CrownSurface;
pub use seam::{Seam, Side, StepCost, seam};
pub use statistics::{patch_distance, repeated_share};
pub use texture::{SynthesisSettings, Texture, texture, texture_around};
pub use wrapping::{Extent, Wrapping, wrapped};

use crate::base::Cancelled;

/// Why there is no texture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum SynthesisError {
    /// Photograph and mask have different sizes.
    #[error("the mask is {}×{} pixels, the photograph {}×{}", mask[0], mask[1], photo[0], photo[1])]
    SizesDiffer {
        /// Width and height of the photograph.
        photo: [u32; 2],
        /// Width and height of the mask.
        mask: [u32; 2],
    },
    /// Hardly anything of the photograph is foliage.
    #[error(
        "only {pixels} pixels of the crown are foliage away from its edge; a texture needs {FEWEST_PIXELS}"
    )]
    TooLittleFoliage {
        /// Pixels that could be used.
        pixels: usize,
    },
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}
