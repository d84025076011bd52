//! From a mask to the base mesh of a crown, by any of the methods that people compare.
//!
//! Every mesh is watertight and lies in the mask's frame: x to the right, y down, z towards the
//! viewer, pixels; [`super::into_world`] turns it upright.

use super::cube_sphere::cube_sphere;
use super::distance::{DistanceShape, distance_sheet};
use super::domain::Domain;
use super::inflation::{Inflation, InflationError, Sheet};
use super::iterative::{IterativeSettings, iterative_sheet};
use super::profile::nearest;
use super::radial::{Crossing, RadialSilhouette};
use super::radius::{RadiusError, merged_radius_cubemap, turned_copies};
use super::surface::closed_surface;
use super::tangent::{Tangent, TangentError};
use crate::base::{Cancel, Cancelled, Progress};
use crate::geometry::{Mesh, Point};
use crate::raster::{Image, Mask, Rect};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How a mask becomes a body.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// The factorised bilaplacian system, [`Inflation`].
    Bilaplacian,
    /// Turning the silhouette, [`RadialSilhouette`].
    Radial(Crossing),
    /// The distance to the silhouette, [`distance_sheet`].
    Distance(DistanceShape),
    /// The bilaplacian by smoothing, [`iterative_sheet`].
    Iterative(IterativeSettings),
}

impl Method {
    /// Whether k has a part in it.
    pub fn uses_tangent(self) -> bool {
        matches!(self, Self::Bilaplacian | Self::Iterative(_))
    }
}

/// Why there is no base mesh.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BaseMeshError {
    /// The mask or its k cannot be inflated.
    #[error(transparent)]
    Inflation(#[from] InflationError),
    /// There is no usable k.
    #[error(transparent)]
    Tangent(#[from] TangentError),
    /// Copies or sub-crowns cannot be merged.
    #[error(transparent)]
    Radius(#[from] RadiusError),
}

impl From<Cancelled> for BaseMeshError {
    fn from(cancelled: Cancelled) -> Self {
        Self::Inflation(cancelled.into())
    }
}

impl BaseMeshError {
    /// Whether the work was stopped, and nothing is wrong.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Inflation(InflationError::Cancelled(_)) | Self::Radius(RadiusError::Cancelled(_))
        )
    }
}

/// A watertight mesh over a mask.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseMesh {
    /// In the mask's frame. Unless it was turned ([`Method::Radial`]), its first vertices are the
    /// front of the mask's pixels by rows.
    pub mesh: Mesh,
    /// Pixels whose places were solved for.
    pub unknowns: usize,
}

/// The base mesh of `mask`. Stages: `assemble`, `factor`, `solve`, `surface`, as far as the method
/// has them.
///
/// ```
/// use boscage::base::{Cancel, Progress};
/// use boscage::crown::{Method, Tangent, base_mesh};
/// use boscage::geometry::Topology;
/// use boscage::raster::Image;
/// let mask = Image::filled(16, 24, true);
/// let made = base_mesh(&mask, &Tangent::Constant(2.0), Method::Bilaplacian, Progress::silent(),
///     &Cancel::new()).unwrap();
/// assert_eq!(made.unknowns, 14 * 22);
/// assert!(Topology::of(&made.mesh).is_watertight());
/// ```
///
/// # Errors
/// [`BaseMeshError`]: an empty mask, a k that cannot be used, cancellation.
pub fn base_mesh(
    mask: &Mask,
    tangent: &Tangent,
    method: Method,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<BaseMesh, BaseMeshError> {
    let stage = progress.stage("assemble", 1);
    let domain = Arc::new(Domain::new(mask)?);
    let k = tangent.on_ring(&domain)?;
    stage.advance();
    drop(stage);
    let sheet = match method {
        Method::Bilaplacian => {
            Inflation::new(Arc::clone(&domain), progress, cancel)?.sheet(&k, cancel)?
        }
        Method::Distance(shape) => distance_sheet(&domain, shape, cancel)?,
        Method::Iterative(settings) => iterative_sheet(&domain, &k, settings, progress, cancel)?,
        Method::Radial(crossing) => {
            let silhouette = RadialSilhouette::new(mask, crossing, cancel)?;
            let silhouette = silhouette.ok_or(InflationError::Empty)?;
            let mesh = silhouette.mesh(star_cells(domain.bounds()));
            return Ok(BaseMesh { mesh, unknowns: 0 });
        }
    };
    let _stage = progress.stage("surface", 0);
    let unknowns = if method.uses_tangent() {
        domain.unknowns()
    } else {
        0
    };
    Ok(BaseMesh {
        mesh: sheet_surface(&sheet, &k),
        unknowns,
    })
}

/// The closed surface of a sheet, see [`closed_surface`]; thin places take the k of the nearest ring
/// pixel.
///
/// # Panics
/// When `k_of_ring` has not one value a ring pixel.
pub fn sheet_surface(sheet: &Sheet, k_of_ring: &[f64]) -> Mesh {
    let domain = &sheet.domain;
    assert_eq!(k_of_ring.len(), domain.ring().len(), "one k a ring pixel");
    // The ring reaches one pixel beyond the mask's frame.
    let (width, height) = (domain.mask().width() + 2, domain.mask().height() + 2);
    let mut ring = Image::filled(width, height, None);
    for (pixel, &k) in domain.ring().iter().zip(k_of_ring) {
        ring.set((pixel.x + 1) as u32, (pixel.y + 1) as u32, Some(k));
    }
    closed_surface(domain.mask(), &sheet.positions, |place| {
        nearest(&ring, place + Point::ONE)
    })
}

/// `mesh` and its copies turned about the vertical axis through `center`, merged by the largest
/// radius, as a star-shaped mesh of `cells` cells along the edges of a cube (thesis, Fig. 4.16).
///
/// # Errors
/// As [`merged_radius_cubemap`].
pub fn copies_merged(
    mesh: &Mesh,
    center: DVec3,
    copies: u32,
    cells: u32,
    cancel: &Cancel,
) -> Result<Mesh, RadiusError> {
    star_around(&turned_copies(mesh, center, copies), center, cells, cancel)
}

/// The union of `meshes` as seen from `center`, as a star-shaped mesh.
pub(super) fn star_around(
    meshes: &[Mesh],
    center: DVec3,
    cells: u32,
    cancel: &Cancel,
) -> Result<Mesh, RadiusError> {
    let radius = merged_radius_cubemap(meshes, center, 2 * cells, cancel)?;
    Ok(cube_sphere(&radius, center, cells).mesh)
}

/// Cells for a star-shaped mesh over `bounds` whose triangles are as large as a pixel or two.
pub fn star_cells(bounds: Rect) -> u32 {
    (bounds.width.max(bounds.height) / 2).clamp(8, 256)
}
