//! One photograph and the mask of its crown become a crown to be drawn (thesis §4.6).
//!
//! The mask is inflated to a base mesh and the mesh becomes a radius in every direction; foliage
//! like that of the photograph is synthesised around it; its light and dark become relief, and the
//! relief moves the radius.
//!
//! Scales: the base mesh is made from the mask's envelope with its longer side at
//! [`CrownSettings::size`] pixels. The foliage is made from the photograph at the scale at which a
//! texel, laid on the crown, is as large as a pixel: leaves keep their size.

use super::frame::{CrownFrame, Volume, union};
use crate::base::{Cancel, Cancelled, Progress, Seed};
use crate::crown::{
    BaseMeshError, Domain, Envelope, Inflation, InflationError, Method, ProfileError, RadiusError,
    ReliefSettings, SettingError, SubCrown, Tangent, TangentError, crown_center, height_cubemap,
    into_world, merged_radius_cubemap, radius_with_relief, sheet_surface, silhouette,
    sub_crowns_merged, turned_copies, without_steep_walls,
};
use crate::geometry::{Mesh, Point};
use crate::raster::{Cubemap, Image, Mask, Rect, Straight, opaque_bounds};
use crate::scene::{Crown, StemLook};
use crate::synth::{CrownSurface, CubemapSettings, Extent, SynthesisError, foliage_cubemap};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

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
    pub k: Option<Tangent>,
    /// Copies of the base mesh turned about the trunk and merged, 1 … 16.
    pub copies: u32,
    /// ρ, how far the relief moves the surface, as a share of the radius, 0 … 1.5.
    pub rho: f64,
    /// How light becomes relief.
    pub relief: ReliefSettings,
    /// Whether the photograph stays on the front, and the rest grows out of it.
    pub photo_front: bool,
    /// How foliage is synthesised; its size is that of the crown.
    pub foliage: CubemapSettings,
    /// Height of the crown, metres.
    pub height_m: f64,
    /// Height of the crown's lowest point above the ground, metres; by default
    /// [`TRUNK_SHARE`] of the crown's height.
    pub trunk_height_m: Option<f64>,
    /// Whether the crown stands about one straight stem, as a spruce: each height is made as deep as it is
    /// wide, and its tip may be sharp.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub round: bool,
    /// How much of the crown's outline leaves fill, 0 to 1: in sparse ones one sees the stem.
    #[serde(skip_serializing_if = "is_closed")]
    pub cover: f64,
    /// What the picture shows of the stem (`pipeline::stem`); otherwise one that suits the tree's height.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stem: Option<StemLook>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_closed(cover: &f64) -> bool {
    *cover >= 1.0
}

/// Height of the bare trunk where nobody says more, as a share of the crown's: what a free-standing
/// broad-leaved tree shows.
pub const TRUNK_SHARE: f64 = 0.2;

/// The largest k: beyond, a surface is nothing but walls.
const MOST_K: f64 = 50.0;

/// How much of itself the radius without relief may change by for each radian. An ellipsoid three times
/// as high as wide needs 1.33, the tip of a slender conifer 2; colours are drawn out to 2.2 times their
/// width at 2.
const STEEPEST_BASE: f64 = 2.0;

/// The same of a crown about one straight stem: the tip of a spruce twice as high as wide has 4, and its
/// needles may be drawn out there.
const STEEPEST_SPIRE: f64 = 4.5;

impl Default for CrownSettings {
    fn default() -> Self {
        Self {
            size: 256,
            envelope: Envelope::default(),
            k: None,
            copies: 1,
            rho: 0.25,
            relief: ReliefSettings::default(),
            photo_front: false,
            foliage: CubemapSettings::default(),
            height_m: 10.0,
            trunk_height_m: None,
            round: false,
            cover: 1.0,
            stem: None,
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
    /// k cannot be used.
    #[error(transparent)]
    Tangent(#[from] TangentError),
    /// k along the silhouette cannot be used.
    #[error(transparent)]
    Profile(#[from] ProfileError),
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

impl From<BaseMeshError> for CrownError {
    fn from(error: BaseMeshError) -> Self {
        match error {
            BaseMeshError::Inflation(error) => error.into(),
            BaseMeshError::Tangent(error) => error.into(),
            BaseMeshError::Radius(error) => error.into(),
        }
    }
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
    /// Height of the crown's lowest point above the ground, metres.
    fn base_m(&self) -> f64 {
        self.trunk_height_m.unwrap_or(TRUNK_SHARE * self.height_m)
    }

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
            (
                "cover",
                self.cover,
                (0.0..=1.0).contains(&self.cover),
                "0 to 1",
            ),
            (
                "stem",
                self.stem.map_or(0.0, |stem| stem.base_radius_m),
                self.stem.is_none_or(|stem| stem.is_sound()),
                "a stem with radii from 0.0001 to 100 m",
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
    with_relief(
        colored_surface(photo, mask, settings, seed, progress, cancel)?,
        settings,
        progress,
        cancel,
    )
}

/// As [`crown`], of several regions of one photograph, each inflated with its own k, shifted by its
/// own depth and merged: [`sub_crowns_merged`]. The foliage is that of all of them;
/// [`CrownSettings::k`] has no part in it. `regions` are masks of the photograph's size and their
/// depths pixels of it.
///
/// # Errors
/// [`CrownError`].
pub fn crown_of_regions(
    photo: &Image<Straight>,
    regions: &[SubCrown],
    settings: &CrownSettings,
    seed: Seed,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<Crown, CrownError> {
    let masks: Vec<&Mask> = regions.iter().map(|region| &region.mask).collect();
    for mask in &masks {
        check(photo, mask, settings)?;
    }
    let mask = union(&masks).ok_or(InflationError::Empty)?;
    let stage = progress.stage("shape", 2);
    let shape = shape_of_regions(regions, &masks, settings, progress, cancel)?;
    stage.advance();
    let base_m = base_radius(&shape, settings, cancel)?;
    stage.advance();
    drop(stage);
    let colored = colored(
        photo,
        &mask,
        (shape, base_m),
        settings,
        seed,
        progress,
        cancel,
    )?;
    with_relief(colored, settings, progress, cancel)
}

/// The last part of [`crown`].
fn with_relief(
    surface: ColoredSurface,
    settings: &CrownSettings,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<Crown, CrownError> {
    let ColoredSurface {
        shape,
        base_m,
        color,
        ..
    } = surface;
    let stage = progress.stage("relief", 1);
    let height = height_cubemap(&color, &settings.relief, cancel)?;
    let radius_m = radius_with_relief(&base_m, &height, settings.rho, settings.relief.steepest);
    stage.advance();
    drop(stage);
    Ok(Crown {
        center_m: shape.frame.center_m,
        radius_m,
        color,
        height,
        base_mesh: shape.base_mesh,
        cover: settings.cover as f32,
        stem: settings.stem,
    })
}

/// The surface of a crown without relief, and its colours.
#[derive(Debug, Clone, PartialEq)]
pub struct ColoredSurface {
    /// The base mesh and where it stands.
    pub shape: CrownShape,
    /// From the crown's centre to the surface of all copies, metres.
    pub base_m: Cubemap<f32>,
    /// The colours.
    pub color: Cubemap<Straight>,
    /// Which of them are the photograph's own; none unless it was to stay on the front.
    pub from_photo: Cubemap<bool>,
}

impl ColoredSurface {
    /// How much of what faces the viewer by `facing` or more (1 is straight towards) shows the
    /// photograph's own pixels, as a share of its texels; 0 when nothing does.
    pub fn photo_share(&self, facing: f64) -> f64 {
        let surface = CrownSurface {
            center: self.shape.photo_center,
            radius: &self.base_m,
        };
        let facings = surface.facing(self.color.size());
        let (mut own, mut all) = (0u32, 0u32);
        for (facings, from_photo) in facings.faces().iter().zip(self.from_photo.faces()) {
            for (&at, &is_own) in facings.pixels().iter().zip(from_photo.pixels()) {
                if at >= facing {
                    all += 1;
                    own += u32::from(is_own);
                }
            }
        }
        f64::from(own) / f64::from(all.max(1))
    }
}

/// The first part of [`crown`]: stages `shape` and `foliage`.
///
/// # Errors
/// [`CrownError`].
pub fn colored_surface(
    photo: &Image<Straight>,
    mask: &Mask,
    settings: &CrownSettings,
    seed: Seed,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<ColoredSurface, CrownError> {
    check(photo, mask, settings)?;
    let stage = progress.stage("shape", 2);
    let shape = crown_shape(mask, settings, progress, cancel)?;
    stage.advance();
    let base_m = base_radius(&shape, settings, cancel)?;
    stage.advance();
    drop(stage);
    colored(
        photo,
        mask,
        (shape, base_m),
        settings,
        seed,
        progress,
        cancel,
    )
}

pub(super) fn check(
    photo: &Image<Straight>,
    mask: &Mask,
    settings: &CrownSettings,
) -> Result<(), CrownError> {
    settings.check()?;
    let sizes = [
        [photo.width(), photo.height()],
        [mask.width(), mask.height()],
    ];
    match sizes[0] == sizes[1] {
        true => Ok(()),
        false => Err(CrownError::SizesDiffer {
            photo: sizes[0],
            mask: sizes[1],
        }),
    }
}

/// From the crown's centre to the surface of all copies, metres.
pub(super) fn base_radius(
    shape: &CrownShape,
    settings: &CrownSettings,
    cancel: &Cancel,
) -> Result<Cubemap<f32>, RadiusError> {
    let center = shape.frame.center_m;
    let copies = turned_copies(&shape.base_mesh, center, settings.copies);
    let radius = merged_radius_cubemap(&copies, center, settings.size, cancel)?;
    let steepest = match settings.round {
        true => STEEPEST_SPIRE,
        false => STEEPEST_BASE,
    };
    Ok(without_steep_walls(&radius, steepest))
}

/// The stage `foliage`: colours around a shape and its radius.
pub(super) fn colored(
    photo: &Image<Straight>,
    mask: &Mask,
    (shape, base_m): (CrownShape, Cubemap<f32>),
    settings: &CrownSettings,
    seed: Seed,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<ColoredSurface, CrownError> {
    let stage = progress.stage("foliage", 1);
    let foliage = CubemapSettings {
        size: settings.size,
        ..settings.foliage
    };
    let radius = base_m.map(|&radius| radius * shape.photo_px_per_m as f32);
    let extent = Extent::of_surface(&radius);
    let surface = CrownSurface {
        center: shape.photo_center,
        radius: &radius,
    };
    let front = settings.photo_front.then_some(surface);
    let made = foliage_cubemap(
        photo, mask, extent, front, &foliage, seed, &progress, cancel,
    )?;
    stage.advance();
    drop(stage);
    Ok(ColoredSurface {
        shape,
        base_m,
        color: made.color,
        from_photo: made.from_photo,
    })
}

/// A base mesh and where it stands.
#[derive(Debug, Clone, PartialEq)]
pub struct CrownShape {
    /// The mesh, metres, in the frame of the tree.
    pub base_mesh: Mesh,
    /// From the pixels of the mask to the tree.
    pub frame: CrownFrame,
    /// The crown's centre in the photograph, pixels.
    pub photo_center: Point,
    /// Pixels of the photograph in a metre.
    pub photo_px_per_m: f64,
    /// The least and the largest k along the silhouette; unknown of several regions.
    pub k: Option<[f64; 2]>,
}

/// The line around a crown, in pixels of the photograph; the centre of its first pixel is (0, 0).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Silhouette {
    /// Places along it with their t, as [`silhouette`] has them. None of several regions.
    pub points: Vec<(f64, Point)>,
    /// Upper left and lower right corner of the crown's bounds: between them i and j of a formula go
    /// from 0 to 1.
    pub bounds: [Point; 2],
}

impl Silhouette {
    fn of(volume: &Volume, bounds: Rect) -> Self {
        let in_photo = |(t, place): (f64, Point)| (t, volume.photo_from_mask(place));
        let corner = Point::new(f64::from(bounds.x), f64::from(bounds.y)) - 0.5;
        let size = Point::new(f64::from(bounds.width), f64::from(bounds.height));
        Self {
            points: silhouette(&volume.mask).into_iter().map(in_photo).collect(),
            bounds: [corner, corner + size].map(|place| volume.photo_from_mask(place)),
        }
    }

    /// i and j of a place in the photograph.
    pub fn shares(&self, place: Point) -> [f64; 2] {
        let [from, to] = self.bounds;
        let share = (place - from) / (to - from);
        [share.x.clamp(0.0, 1.0), share.y.clamp(0.0, 1.0)]
    }

    /// Where `change` moves it.
    pub(super) fn moved(&self, change: impl Fn(Point) -> Point) -> Self {
        Self {
            points: self.points.iter().map(|&(t, at)| (t, change(at))).collect(),
            bounds: self.bounds.map(change),
        }
    }
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
    Inflated::new(mask, settings, progress, cancel)?.shape(settings, cancel)
}

/// A mask that is ready for any k.
pub(super) struct Inflated {
    volume: Volume,
    inflation: Inflation,
    pub(super) silhouette: Arc<Silhouette>,
}

impl Inflated {
    /// Prepares `mask` at the size and with the envelope of `settings`; nothing else of them counts.
    pub(super) fn new(
        mask: &Mask,
        settings: &CrownSettings,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, CrownError> {
        let volume =
            Volume::new(mask, settings.size, &settings.envelope).ok_or(InflationError::Empty)?;
        let inflation = Inflation::new(Domain::new(&volume.mask)?, progress, cancel)?;
        let silhouette = Silhouette::of(&volume, inflation.domain().bounds());
        Ok(Self {
            silhouette: Arc::new(silhouette),
            volume,
            inflation,
        })
    }

    /// The base mesh for the k of `settings`, as large as they say.
    pub(super) fn shape(
        &self,
        settings: &CrownSettings,
        cancel: &Cancel,
    ) -> Result<CrownShape, CrownError> {
        let Self {
            volume, inflation, ..
        } = self;
        let center = crown_center(&volume.mask).ok_or(InflationError::Empty)?;
        let frame = CrownFrame::new(&volume.mask, settings.height_m, settings.base_m());
        let bounds = inflation.domain().bounds();
        let k = match &settings.k {
            Some(tangent) => tangent.on_ring(inflation.domain())?,
            None => k_of_depth(inflation, f64::from(bounds.width) / 2.0, cancel)?,
        };
        let mut pixels = sheet_surface(&inflation.sheet(&k, cancel)?, &k);
        if settings.round {
            make_round(&mut pixels);
        }
        let in_photo = |length: f64| length / volume.scale;
        Ok(CrownShape {
            base_mesh: into_world(&pixels, bounds, frame.metres_per_pixel, frame.base_m),
            frame,
            photo_center: volume.photo_from_mask(center),
            photo_px_per_m: in_photo(1.0 / frame.metres_per_pixel),
            k: Some([
                k.iter().copied().fold(f64::INFINITY, f64::min),
                k.iter().copied().fold(0.0, f64::max),
            ]),
        })
    }
}

/// Makes each row of an inflated `mesh`, in pixels, as deep as it is wide.
fn make_round(mesh: &mut Mesh) {
    let row = |y: f64| y.round().max(0.0) as usize;
    let rows = mesh.positions.iter().map(|p| row(p.y)).max().unwrap_or(0) + 1;
    // Left, right and depth of each row.
    let mut ends = vec![[f64::INFINITY, f64::NEG_INFINITY, 0.0]; rows];
    for place in &mesh.positions {
        let [left, right, depth] = &mut ends[row(place.y)];
        *left = left.min(place.x);
        *right = right.max(place.x);
        *depth = depth.max(place.z.abs());
    }
    // Over a few rows: boughs do not reach as far to all sides in the same row.
    let reach = rows / 24;
    let factor = |at: usize| {
        let around = &ends[at.saturating_sub(reach)..(at + reach + 1).min(rows)];
        let found = around.iter().filter(|ends| ends[0] <= ends[1]);
        let (half, depth) = found.fold((0.0, 0.0), |sum, [left, right, depth]| {
            (sum.0 + 0.5 * (right - left), sum.1 + depth)
        });
        (half / f64::max(depth, 1e-6)).min(4.0)
    };
    let factors: Vec<f64> = (0..rows).map(factor).collect();
    for place in &mut mesh.positions {
        place.z *= factors[row(place.y)];
    }
}

/// The merged `regions`, whose masks are `masks`, without relief and copies.
pub(super) fn shape_of_regions(
    regions: &[SubCrown],
    masks: &[&Mask],
    settings: &CrownSettings,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<CrownShape, CrownError> {
    let made = Volume::of_regions(masks, settings.size, &settings.envelope);
    let (volume, masks) = made.ok_or(InflationError::Empty)?;
    let scaled: Vec<SubCrown> = regions
        .iter()
        .zip(masks)
        .map(|(region, mask)| SubCrown {
            mask,
            tangent: region.tangent.clone(),
            depth_px: region.depth_px * volume.scale,
        })
        .collect();
    let (pixels, center) = sub_crowns_merged(&scaled, Method::Bilaplacian, progress, cancel)?;
    let bounds = opaque_bounds(&volume.mask).ok_or(InflationError::Empty)?;
    let mut frame = CrownFrame::new(&volume.mask, settings.height_m, settings.base_m());
    let in_plane = frame.world_from_mask(bounds, center.truncate());
    frame.center_m = in_plane + DVec3::Z * center.z * frame.metres_per_pixel;
    Ok(CrownShape {
        base_mesh: into_world(&pixels, bounds, frame.metres_per_pixel, frame.base_m),
        frame,
        photo_center: volume.photo_from_mask(center.truncate()),
        photo_px_per_m: 1.0 / frame.metres_per_pixel / volume.scale,
        k: None,
    })
}

/// One k for the whole ring at which the highest point of the sheet is `depth` pixels in front of the
/// silhouette: heights are linear in k.
pub(super) fn k_of_depth(
    inflation: &Inflation,
    depth: f64,
    cancel: &Cancel,
) -> Result<Vec<f64>, CrownError> {
    let ring = inflation.domain().ring().len();
    let sheet = inflation.sheet(&vec![1.0; ring], cancel)?;
    let highest = sheet.positions.iter().map(|p| p.z).fold(0.0, f64::max);
    Ok(vec![(depth / highest.max(1e-9)).min(MOST_K); ring])
}
