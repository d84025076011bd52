//! The shape of a crown: from a mask to a base mesh, from a photograph to relief, from both to the
//! radius of the crown in every direction.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! chapter 4 ("the thesis" below). In the plane of the mask coordinates are those of images; a
//! height z points out of the picture towards the viewer, in pixels.
//!
//! Imports `base`, `raster`, `geometry`, `solve`, `contour`.

mod base_mesh;
mod center;
mod chamfer;
mod cube_sphere;
mod distance;
mod domain;
mod envelope;
mod expression;
mod gentle;
mod height;
mod inflation;
mod iterative;
mod leaf_points;
mod luminance;
mod profile;
mod pyramid;
mod radial;
mod radial_raster;
mod radius;
mod relief;
mod restart;
mod sub_crowns;
mod surface;
mod tangent;

pub use base_mesh::{
    BaseMesh, BaseMeshError, Method, base_mesh, copies_merged, sheet_surface, star_cells,
};
pub use center::crown_center;
pub use cube_sphere::{CubeSphere, cube_sphere, grid_line};
pub use distance::{DistanceShape, distance_sheet, distances_to_silhouette};
pub use domain::{Domain, RingPixel};
pub use envelope::{Envelope, envelope};
pub use expression::{Expression, ExpressionError};
pub use gentle::without_steep_walls;
pub use height::{height_cubemap, radius_with_relief};
pub use inflation::{Inflation, InflationError, Sheet};
pub use iterative::{IterativeSettings, iterative_sheet};
pub use leaf_points::{LEAF_POINTS, leaf_points};
pub use luminance::luminance;
pub use profile::{Profile, ProfileError, silhouette};
pub use pyramid::{Pyramid, ReliefSettings, SettingError};
pub use radial::{Crossing, RadialSilhouette};
pub use radius::{
    LEAST_SHARE, RadiusError, merged_radius_cubemap, radius_cubemap, turned, turned_copies,
};
pub use relief::relief;
pub use sub_crowns::{SubCrown, labelled_regions, sub_crowns_merged};
pub use surface::{closed_surface, into_world};
pub use tangent::{PRESETS, Preset, Tangent, TangentError};
