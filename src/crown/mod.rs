//! The shape of a crown: from a mask to a base mesh, from a photograph to relief, from both to the
//! radius of the crown in every direction.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! chapter 4 ("the thesis" below). In the plane of the mask coordinates are those of images; a
//! height z points out of the picture towards the viewer, in pixels.
//!
//! Imports `base`, `raster`, `geometry`, `solve`.

mod center;
mod cube_sphere;
mod domain;
mod height;
mod inflation;
mod leaf_points;
mod luminance;
mod pyramid;
mod radial_raster;
mod radius;
mod relief;
mod surface;

pub use center::crown_center;
pub use cube_sphere::{CubeSphere, cube_sphere, grid_line};
pub use domain::{Domain, RingPixel};
pub use height::{height_cubemap, radius_with_relief};
pub use inflation::{Inflation, InflationError, Sheet};
pub use leaf_points::{LEAF_POINTS, leaf_points};
pub use luminance::luminance;
pub use pyramid::{Pyramid, ReliefSettings, SettingError};
pub use radius::{
    LEAST_SHARE, RadiusError, merged_radius_cubemap, radius_cubemap, turned, turned_copies,
};
pub use relief::relief;
pub use surface::{closed_surface, into_world};
