//! One photograph and the mask of its crown become a crown to be drawn (thesis §4.6).
//!
//! The mask is inflated to a base mesh and the mesh becomes a radius in every direction; foliage
//! like that of the photograph is synthesised around it; its light and dark become relief, and the
//! relief moves the radius.
//!
//! Scales: the base mesh is made from the mask with its longer side at [`CrownSettings::size`]
//! pixels. The foliage is made from the photograph at the scale at which a texel of the cubemap,
//! laid on a sphere as large as the crown, is as large as a pixel: leaves keep their size.

use super::foliage::{PhotoSurface, crown_foliage};
use super::frame::{CrownFrame, scaled_mask};
use crate::base::{Cancel, Cancelled, Progress, Seed};
use crate::crown::{
    Domain, Inflation, InflationError, RadiusError, ReliefSettings, SettingError, closed_surface,
    height_cubemap, into_world, merged_radius_cubemap, radius_with_relief, turned_copies,
};
use crate::geometry::Mesh;
use crate::raster::{Image, Mask, Straight};
use crate::scene::Crown;
use crate::synth::{CubemapSettings, SynthesisError};
use serde::{Deserialize, Serialize};

/// How a crown is made from a photograph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrownSettings {
    /// Texels along a face of all cubemaps, and pixels along the longer side of the mask that is
    /// inflated; a multiple of 16, 32 … 1024.
    pub size: u32,
    /// The tangent at the silhouette, thesis §4.3: 0 is flat; a disc is nearest to a ball at 2.25.
    pub k: f64,
    /// Copies of the base mesh turned about the trunk and merged, 1 … 16.
    pub copies: u32,
    /// ρ, how far the relief moves the surface, as a share of the radius, 0 … 1.5.
    pub rho: f64,
    /// How light becomes relief.
    pub relief: ReliefSettings,
    /// Height of the crown, metres.
    pub height_m: f64,
    /// Height of the crown's lowest point above the ground, metres; by default
    /// [`TRUNK_SHARE`] of the crown's height.
    pub trunk_height_m: Option<f64>,
}

/// Height of the bare trunk where nobody says more, as a share of the crown's: what a free-standing
/// broad-leaved tree shows.
pub const TRUNK_SHARE: f64 = 0.2;

impl Default for CrownSettings {
    fn default() -> Self {
        Self {
            size: 256,
            k: 2.25,
            copies: 1,
            rho: 0.35,
            relief: ReliefSettings::default(),
            height_m: 10.0,
            trunk_height_m: None,
        }
    }
}

/// No crown could be made.
#[derive(Debug, thiserror::Error)]
pub enum CrownError {
    /// Photograph and mask have different sizes.
    #[error("the mask is {}×{} pixels, the photograph {}×{}", mask[0], mask[1], photo[0], photo[1])]
    SizesDiffer {
        /// Width and height of the photograph.
        photo: [u32; 2],
        /// Width and height of the mask.
        mask: [u32; 2],
    },
    /// A setting is outside its range.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The mask cannot be inflated.
    #[error(transparent)]
    Inflation(#[from] InflationError),
    /// The mesh has no surface around its centre.
    #[error(transparent)]
    Radius(#[from] RadiusError),
    /// The photograph gives no foliage.
    #[error(transparent)]
    Synthesis(#[from] SynthesisError),
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

impl CrownError {
    /// Whether the work was asked to stop, at whatever depth.
    pub fn is_cancelled(&self) -> bool {
        matches!(
            self,
            Self::Cancelled(_)
                | Self::Inflation(InflationError::Cancelled(_))
                | Self::Radius(RadiusError::Cancelled(_))
                | Self::Synthesis(SynthesisError::Cancelled(_))
        )
    }
}

impl CrownSettings {
    /// Checks that all values are in range.
    ///
    /// # Errors
    /// [`SettingError`], the first that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        let size = f64::from(self.size);
        let size_fits = (32..=1024).contains(&self.size) && self.size.is_multiple_of(16);
        let trunk = self.trunk_height_m.unwrap_or(0.0);
        let rules = [
            ("size", size, size_fits, "a multiple of 16 from 32 to 1024"),
            ("k", self.k, (0.01..=20.0).contains(&self.k), "0.01 to 20"),
            (
                "copies",
                f64::from(self.copies),
                (1..=16).contains(&self.copies),
                "1 to 16",
            ),
            ("rho", self.rho, (0.0..=1.5).contains(&self.rho), "0 to 1.5"),
            (
                "height_m",
                self.height_m,
                (0.01..=1000.0).contains(&self.height_m),
                "0.01 to 1000",
            ),
            (
                "trunk_height_m",
                trunk,
                (0.0..=1000.0).contains(&trunk),
                "0 to 1000",
            ),
        ];
        match rules.into_iter().find(|rule| !rule.2) {
            None => self.relief.check(),
            Some((name, value, _, range)) => Err(SettingError { name, value, range }),
        }
    }
}

/// The crown of the tree in `photo`, whose pixels are told by `mask`.
///
/// Stages of `progress`: `shape`, `foliage`, `relief`.
///
/// # Errors
/// [`CrownError`].
pub fn crown(
    photo: &Image<Straight>,
    mask: &Mask,
    settings: &CrownSettings,
    seed: Seed,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<Crown, CrownError> {
    settings.check()?;
    let sizes = [
        [photo.width(), photo.height()],
        [mask.width(), mask.height()],
    ];
    if sizes[0] != sizes[1] {
        return Err(CrownError::SizesDiffer {
            photo: sizes[0],
            mask: sizes[1],
        });
    }
    let stage = progress.stage("shape", 2);
    let shape = crown_shape(mask, settings, progress, cancel)?;
    stage.advance();
    let copies = turned_copies(&shape.base_mesh, shape.frame.center_m, settings.copies);
    let base_m = merged_radius_cubemap(&copies, shape.frame.center_m, settings.size, cancel)?;
    stage.advance();
    drop(stage);
    let foliage = CubemapSettings {
        size: settings.size,
        ..CubemapSettings::default()
    };
    let surface = PhotoSurface::new(mask, &shape.frame, &base_m, settings.height_m);
    let color = crown_foliage(
        photo, mask, &surface, &foliage, false, seed, progress, cancel,
    )?;
    let stage = progress.stage("relief", 1);
    let height = height_cubemap(&color, &settings.relief, cancel)?;
    let radius_m = radius_with_relief(&base_m, &height, settings.rho);
    stage.advance();
    drop(stage);
    Ok(Crown {
        center_m: shape.frame.center_m,
        radius_m,
        color,
        height,
        base_mesh: shape.base_mesh,
    })
}

/// A base mesh and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct CrownShape {
    /// The mesh, metres, in the frame of the tree.
    pub base_mesh: Mesh,
    /// From the pixels of the mask to the tree.
    pub frame: CrownFrame,
}

/// The inflated `mask`, without relief and copies.
///
/// # Errors
/// [`CrownError`].
pub fn crown_shape(
    mask: &Mask,
    settings: &CrownSettings,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<CrownShape, CrownError> {
    let scaled = scaled_mask(mask, settings.size).ok_or(InflationError::Empty)?;
    let domain = Domain::new(&scaled)?;
    let frame = CrownFrame::new(
        &scaled,
        settings.height_m,
        settings
            .trunk_height_m
            .unwrap_or(TRUNK_SHARE * settings.height_m),
    );
    let bounds = domain.bounds();
    let k_of_ring = vec![settings.k; domain.ring().len()];
    let inflation = Inflation::new(domain, progress, cancel)?;
    let sheet = inflation.sheet(&k_of_ring, cancel)?;
    let pixels = closed_surface(&scaled, &sheet.positions, |_| settings.k);
    let base_mesh = into_world(&pixels, bounds, frame.metres_per_pixel, frame.base_m);
    Ok(CrownShape { base_mesh, frame })
}
