//! The foliage of a photograph all around a crown: a cubemap from a photograph and a mask.
//!
//! The photograph is first resized so that one of its pixels is a texel; the textures are made of that
//! ([`texture`](super::texture)), joined to a box ([`assembled`]) and laid around the crown
//! ([`wrapped`]). Leaves are as large as in the photograph, at the poles as well as at eye level.

use super::SynthesisError;
use super::assembly::assembled;
use super::exemplar::{Exemplar, ExemplarSettings};
use super::texture::{SynthesisSettings, texture};
use super::wrapping::{Extent, Wrapping, wrapped};
use crate::base::{Cancel, Progress, Seed};
use crate::geometry::Point;
use crate::raster::{Cubemap, Image, Mask, Rect, Straight, opaque_bounds, resized};

/// How a cubemap of foliage is made.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct CubemapSettings {
    /// Texels along a side of a face, at least [`CubemapSettings::LEAST_SIZE`].
    pub size: u32,
    /// Whether texture is laid as on a ball, however long the crown; see [`super::Wrapping`].
    pub as_ball: bool,
    /// How the exemplar is prepared.
    pub exemplar: ExemplarSettings,
    /// How textures are made; `tiles_x` counts for nothing.
    pub synthesis: SynthesisSettings,
}

impl CubemapSettings {
    /// Smallest faces: below, the bands in which seams are sought have no room.
    pub const LEAST_SIZE: u32 = 32;
}

impl Default for CubemapSettings {
    fn default() -> Self {
        Self {
            size: 256,
            as_ball: false,
            exemplar: ExemplarSettings::default(),
            synthesis: SynthesisSettings::default(),
        }
    }
}

/// A cubemap of foliage and what it was made of.
#[derive(Debug, Clone)]
pub struct FoliageCubemap {
    /// The colours, opaque.
    pub color: Cubemap<Straight>,
    /// How texture lies around the crown.
    pub wrapping: Wrapping,
    /// The part of the photograph around the crown at the scale of the texture.
    pub(super) scaled: ScaledPhoto,
    pub(super) exemplar: Exemplar,
}

/// The foliage of `photo` inside `mask` around a crown of `extent`. Stages: `exemplar`, those of
/// [`texture`](super::texture) three times, `assemble`.
///
/// # Errors
/// [`SynthesisError`].
///
/// # Panics
/// When the size is below [`CubemapSettings::LEAST_SIZE`].
pub fn foliage_cubemap(
    photo: &Image<Straight>,
    mask: &Mask,
    extent: Extent,
    settings: &CubemapSettings,
    seed: Seed,
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<FoliageCubemap, SynthesisError> {
    assert!(
        settings.size >= CubemapSettings::LEAST_SIZE,
        "faces are too small"
    );
    let wrapping = Wrapping::new(settings.shaped(extent), settings.size);
    let stage = progress.stage("exemplar", 1);
    let scaled = ScaledPhoto::new(photo, mask, wrapping.texels_per_pixel())?;
    let exemplar = Exemplar::new(&scaled.photo, &scaled.mask, &settings.exemplar, cancel)?;
    stage.advance();
    drop(stage);
    let size = wrapping.size();
    let made = |name: &str, [width, height]: [u32; 2]| {
        let settings = SynthesisSettings {
            tiles_x: false,
            ..settings.synthesis
        };
        let seed = seed.derive(name, 0);
        texture(&exemplar, width, height, &settings, seed, progress, cancel)
    };
    let lateral = made("lateral", size.lateral())?;
    let [top, bottom] = [made("top", size.lid())?, made("bottom", size.lid())?];
    let stage = progress.stage("assemble", 1);
    let lattice = assembled(&lateral, &top, &bottom, size, cancel)?;
    let color = wrapped(&lattice, &wrapping, settings.size, cancel)?;
    stage.advance();
    drop(stage);
    Ok(FoliageCubemap {
        color,
        wrapping,
        scaled,
        exemplar,
    })
}

impl CubemapSettings {
    /// The shape that texture is laid around.
    fn shaped(&self, extent: Extent) -> Extent {
        if !self.as_ball {
            return extent;
        }
        // The ball of the thesis's scale: the geometric mean of half width and half height.
        let radius = libm::sqrt(extent.across * (extent.up + extent.down) / 2.0);
        Extent::ball(radius)
    }
}

/// A photograph's crown at another scale.
#[derive(Debug, Clone)]
pub(super) struct ScaledPhoto {
    /// The crown's bounds, clear outside the mask.
    pub(super) photo: Image<Straight>,
    /// What of it is wholly inside the mask.
    pub(super) mask: Mask,
    /// The bounds in the photograph.
    bounds: Rect,
}

impl ScaledPhoto {
    /// Resized with colours weighted by the mask, so that no background gets into the leaves.
    fn new(photo: &Image<Straight>, mask: &Mask, scale: f64) -> Result<Self, SynthesisError> {
        let sides = [
            [photo.width(), photo.height()],
            [mask.width(), mask.height()],
        ];
        if sides[0] != sides[1] {
            return Err(SynthesisError::SizesDiffer {
                photo: sides[0],
                mask: sides[1],
            });
        }
        let bounds = opaque_bounds(mask).ok_or(SynthesisError::TooLittleFoliage { pixels: 0 })?;
        let pixels = photo.pixels().iter().zip(mask.pixels());
        let cut_out = pixels.map(|(pixel, &inside)| match inside {
            true => pixel.premultiplied(),
            false => Straight::default().premultiplied(),
        });
        let cut_out = Image::from_pixels(sides[0][0], sides[0][1], cut_out.collect());
        let texels = |length: u32| (libm::round(f64::from(length) * scale) as u32).max(1);
        let small = resized(
            &cut_out,
            bounds,
            texels(bounds.width),
            texels(bounds.height),
        );
        Ok(Self {
            mask: small.map(|pixel| pixel.alpha() == 255),
            photo: small.straight(),
            bounds,
        })
    }

    /// Where a point of the photograph lies here.
    pub(super) fn place(&self, point: Point) -> Point {
        let scale = |here: u32, there: u32| f64::from(here) / f64::from(there);
        let corner = Point::new(f64::from(self.bounds.x), f64::from(self.bounds.y));
        let scale = Point::new(
            scale(self.photo.width(), self.bounds.width),
            scale(self.photo.height(), self.bounds.height),
        );
        (point - corner + 0.5) * scale - 0.5
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_background_gets_into_the_scaled_crown() {
        let photo = Image::from_pixels(
            40,
            40,
            (0..1600)
                .map(|i| Straight([if i % 40 < 20 { 200 } else { 0 }, 60, 10, 255]))
                .collect(),
        );
        let mask = Image::from_pixels(40, 40, (0..1600).map(|i| i % 40 < 20).collect());
        let scaled = ScaledPhoto::new(&photo, &mask, 0.37).unwrap();
        assert_eq!((scaled.photo.width(), scaled.photo.height()), (7, 15));
        assert!(
            scaled
                .photo
                .pixels()
                .iter()
                .all(|pixel| pixel.0 == [200, 60, 10, 255])
        );
        let corner = scaled.place(Point::new(-0.5, -0.5));
        assert!((corner - Point::new(-0.5, -0.5)).length() < 1e-12);
        let end = scaled.place(Point::new(19.5, 39.5));
        assert!((end - Point::new(6.5, 14.5)).length() < 1e-12);
    }

    #[test]
    fn masks_and_photographs_that_do_not_fit_are_refused() {
        let photo = Image::filled(8, 8, Straight([9, 9, 9, 255]));
        let other = Image::filled(8, 9, true);
        let empty = Image::filled(8, 8, false);
        let scaled = |mask: &Mask| ScaledPhoto::new(&photo, mask, 1.0).unwrap_err();
        assert!(matches!(scaled(&other), SynthesisError::SizesDiffer { .. }));
        assert!(matches!(
            scaled(&empty),
            SynthesisError::TooLittleFoliage { pixels: 0 }
        ));
    }
}
