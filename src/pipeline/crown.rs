//! One photograph and the mask of its crown become a crown to be drawn (thesis §4.6).
//!
//! The mask is inflated to a base mesh and the mesh becomes a radius in every direction; foliage
//! like that of the photograph is synthesised around it; its light and dark become relief, and the
//! relief moves the radius.
//!
//! Scales: the base mesh is made from the mask with its longer side at [`CrownSettings::size`]
//! pixels. The foliage is made from the photograph at the scale at which a texel of the cubemap,
//! laid on a sphere as large as the crown, is as large as a pixel: leaves keep their size.

use super::frame::{CrownFrame, scaled_mask, scaled_photo};
use crate::base::{Cancel, Cancelled, Progress, Seed};
use crate::crown::{
    Domain, Envelope, Inflation, InflationError, RadiusError, ReliefSettings, SettingError,
    closed_surface, envelope, height_cubemap, into_world, merged_radius_cubemap,
    radius_with_relief, turned_copies,
};
use crate::geometry::Mesh;
use crate::raster::{Cubemap, Image, Mask, Straight};
use crate::scene::Crown;
use crate::synth::{
    Exemplar, ExemplarSettings, SynthesisError, SynthesisSettings, assembled, even_angles, texture,
    texture_sizes,
};
use serde::{Deserialize, Serialize};

/// How a crown is made from a photograph.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CrownSettings {
    /// Texels along a face of all cubemaps, and pixels along the longer side of the mask that is
    /// inflated; a multiple of 16, 32 … 1024.
    pub size: u32,
    /// How much of the mask's outline shapes the volume.
    pub envelope: Envelope,
    /// The tangent at the silhouette, thesis §4.3: 0 is flat; a disc is nearest to a ball at 2.25.
    /// By default so large that the crown is as deep as it is wide, which for a disc is 2.08.
    pub k: Option<f64>,
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

/// The largest k: beyond, a surface is nothing but walls.
const MOST_K: f64 = 50.0;

impl Default for CrownSettings {
    fn default() -> Self {
        Self {
            size: 256,
            envelope: Envelope::default(),
            k: None,
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
        let k = self.k.unwrap_or(1.0);
        let trunk = self.trunk_height_m.unwrap_or(0.0);
        let rules = [
            ("size", size, size_fits, "a multiple of 16 from 32 to 1024"),
            ("k", k, (0.01..=MOST_K).contains(&k), "0.01 to 50"),
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
    let color = foliage(photo, mask, settings.size, seed, progress, cancel)?;
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
    let scaled = scaled_mask(mask, settings.size)
        .and_then(|scaled| envelope(&scaled, &settings.envelope))
        .ok_or(InflationError::Empty)?;
    let domain = Domain::new(&scaled)?;
    let frame = CrownFrame::new(
        &scaled,
        settings.height_m,
        settings
            .trunk_height_m
            .unwrap_or(TRUNK_SHARE * settings.height_m),
    );
    let bounds = domain.bounds();
    let inflation = Inflation::new(domain, progress, cancel)?;
    let k = match settings.k {
        Some(k) => k,
        None => k_of_depth(&inflation, f64::from(bounds.width) / 2.0, cancel)?,
    };
    let sheet = inflation.sheet(&vec![k; inflation.domain().ring().len()], cancel)?;
    let pixels = closed_surface(&scaled, &sheet.positions, |_| k);
    let base_mesh = into_world(&pixels, bounds, frame.metres_per_pixel, frame.base_m);
    Ok(CrownShape { base_mesh, frame })
}

/// The k at which the highest point of the sheet is `depth` pixels in front of the silhouette: heights
/// are linear in k.
fn k_of_depth(inflation: &Inflation, depth: f64, cancel: &Cancel) -> Result<f64, CrownError> {
    let sheet = inflation.sheet(&vec![1.0; inflation.domain().ring().len()], cancel)?;
    let highest = sheet.positions.iter().map(|p| p.z).fold(0.0, f64::max);
    Ok((depth / highest.max(1e-9)).min(MOST_K))
}

/// Foliage like that of the crown, all around it.
fn foliage(
    photo: &Image<Straight>,
    mask: &Mask,
    size: u32,
    seed: Seed,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<Cubemap<Straight>, CrownError> {
    let stage = progress.stage("foliage", 5);
    let (photo, mask) = scaled_photo(photo, mask, size);
    let exemplar = Exemplar::new(&photo, &mask, &ExemplarSettings::default(), cancel)?;
    stage.advance();
    let [sides, lid] = texture_sizes(size);
    let made = |name: &str, [width, height]: [u32; 2]| {
        let settings = SynthesisSettings::default();
        let seed = seed.derive(name, 0);
        let made = texture(&exemplar, width, height, &settings, seed, &progress, cancel);
        stage.advance();
        made
    };
    let lateral = made("lateral", sides)?;
    let (top, bottom) = (made("top", lid)?, made("bottom", lid)?);
    let color = even_angles(&assembled(&lateral, &top, &bottom, cancel)?);
    stage.advance();
    Ok(color)
}
