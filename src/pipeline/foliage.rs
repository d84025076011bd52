//! Foliage all around a crown whose surface is known.

use super::crown::CrownError;
use super::frame::CrownFrame;
use crate::base::{Cancel, Progress, Seed};
use crate::geometry::Point;
use crate::raster::{Cubemap, Image, Mask, Straight, opaque_bounds};
use crate::synth::{CrownSurface, CubemapSettings, Extent, foliage_cubemap, with_photo_front};

/// A crown's surface as the photograph sees it.
#[derive(Debug, Clone, PartialEq)]
pub struct PhotoSurface {
    /// The crown's centre, pixels of the photograph.
    pub center: Point,
    /// From there to the surface without relief, pixels of the photograph.
    pub radius: Cubemap<f32>,
}

impl PhotoSurface {
    /// From metres: the surface at `base_m` around the centre of `frame`, of the crown in `mask` (at
    /// the photograph's own size) that is `height_m` high.
    ///
    /// # Panics
    /// When the mask is empty.
    pub fn new(mask: &Mask, frame: &CrownFrame, base_m: &Cubemap<f32>, height_m: f64) -> Self {
        let bounds = opaque_bounds(mask).expect("the mask is not empty");
        let pixels_per_metre = f64::from(bounds.height) / height_m;
        let middle = f64::from(bounds.x) + f64::from(bounds.width - 1) / 2.0;
        let bottom = f64::from(bounds.y + bounds.height) - 0.5;
        let above = frame.center_m.y - frame.base_m;
        Self {
            center: Point::new(
                middle + frame.center_m.x * pixels_per_metre,
                bottom - above * pixels_per_metre,
            ),
            radius: base_m.map(|&metres| (f64::from(metres) * pixels_per_metre) as f32),
        }
    }
}

/// Colours around the crown of `mask` in `photo`, whose surface is `surface`; with `photo_front` the
/// photograph itself stays on the front. Stage: `foliage`, and inside it those of [`foliage_cubemap`] and
/// `front`.
///
/// # Errors
/// [`CrownError::Synthesis`] and [`CrownError::Cancelled`].
#[allow(
    clippy::too_many_arguments,
    reason = "two pictures, what is known, how, and the three that every step takes"
)]
pub fn crown_foliage(
    photo: &Image<Straight>,
    mask: &Mask,
    surface: &PhotoSurface,
    settings: &CubemapSettings,
    photo_front: bool,
    seed: Seed,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<Cubemap<Straight>, CrownError> {
    let stage = progress.stage("foliage", 2);
    let extent = Extent::of_surface(&surface.radius);
    let foliage = foliage_cubemap(photo, mask, extent, settings, seed, &progress, cancel)?;
    stage.advance();
    if !photo_front {
        return Ok(foliage.color);
    }
    let front = progress.stage("front", 1);
    let surface = CrownSurface {
        center: surface.center,
        radius: &surface.radius,
    };
    let color = with_photo_front(&foliage, surface, cancel)?;
    front.advance();
    stage.advance();
    Ok(color)
}
