//! The foliage of a photograph all around a crown: a cubemap from a photograph and a mask.
//!
//! The photograph is first resized so that one of its pixels is a texel; the textures are made of that
//! ([`texture`](super::texture)), joined to a box ([`assembled`]) and laid around the crown
//! ([`wrapped`]). Leaves are as large as in the photograph, at the poles as well as at eye level.

use super::SynthesisError;
use super::assembly::{Lattice, assembled};
use super::canvas::Known;
use super::exemplar::{Exemplar, ExemplarSettings};
use super::foliage::shown;
use super::photo_front::{CrownSurface, Front};
use super::texture::{SynthesisSettings, texture_around};
use super::wrapping::{Extent, Wrapping, wrapped};
use crate::base::{Cancel, Cancelled, Progress, Seed};
use crate::geometry::Point;
use crate::raster::{CubeFace, Cubemap, Image, Mask, Rect, Straight, opaque_bounds, resized};
use rayon::prelude::*;

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
    /// Which texels are the photograph's own; none unless it was to stay on the front.
    pub from_photo: Cubemap<bool>,
    /// How texture lies around the crown.
    pub wrapping: Wrapping,
}

/// How far the crown of `mask` reaches from `center`, pixels, if it is as deep as wide; `None` when the mask is empty.
pub fn extent_of(mask: &Mask, center: Point) -> Option<Extent> {
    let bounds = opaque_bounds(mask)?;
    let (top, height) = (f64::from(bounds.y) - 0.5, f64::from(bounds.height));
    Some(Extent {
        across: f64::from(bounds.width) / 2.0,
        depth: f64::from(bounds.width) / 2.0,
        up: (center.y - top).clamp(0.0, height),
        down: (top + height - center.y).clamp(0.0, height),
    })
}

/// The foliage of `photo` inside `mask` around a crown of `extent`. Stages: `exemplar`, those of
/// [`texture`](super::texture) three times, `assemble`.
///
/// With a `front` the photograph stays on the front of that surface and the textures grow out of it:
/// what it shows of the crown is known to the synthesis, which continues it ([`super::photo_front`]).
///
/// # Errors
/// [`SynthesisError`].
///
/// # Panics
/// When the size is below [`CubemapSettings::LEAST_SIZE`].
#[expect(clippy::too_many_arguments, reason = "the last three are every step's")]
pub fn foliage_cubemap(
    photo: &Image<Straight>,
    mask: &Mask,
    extent: Extent,
    front: Option<CrownSurface<'_>>,
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
    let front = front.map(|surface| {
        let shown = shown(&scaled.photo, &scaled.mask, settings.exemplar.without_sky);
        Front::new(&scaled, &exemplar, shown, surface)
    });
    let known = known_textures(front.as_ref(), &wrapping, cancel)?;
    stage.advance();
    drop(stage);
    let lattice = lattice(
        &exemplar, &known, &wrapping, settings, seed, progress, cancel,
    )?;
    let grown = wrapped(&lattice, &wrapping, settings.size, cancel)?;
    let (color, from_photo) = match front {
        Some(front) => front.laid_over(&grown, cancel)?,
        None => (grown, Cubemap::filled(settings.size, false)),
    };
    Ok(FoliageCubemap {
        color,
        from_photo,
        wrapping,
    })
}

/// What is settled of the lateral texture, the top and the bottom.
fn known_textures(
    front: Option<&Front<'_>>,
    wrapping: &Wrapping,
    cancel: &Cancel,
) -> Result<[Known; 3], Cancelled> {
    let size = wrapping.size();
    let known = |[width, height]: [u32; 2], texel: &(dyn Fn(u32, u32) -> LidTexel + Sync)| {
        let Some(front) = front else {
            return Ok(Image::filled(width, height, None));
        };
        let row = |y: u32| {
            cancel.check()?;
            let seen = |x: u32| {
                let (face, x, y) = texel(x, y);
                front.known(wrapping.direction(face, f64::from(x), f64::from(y)))
            };
            Ok((0..width).map(seen).collect::<Vec<_>>())
        };
        let rows: Result<Vec<_>, Cancelled> = (0..height).into_par_iter().map(row).collect();
        Ok(Image::from_pixels(width, height, rows?.concat()))
    };
    Ok([
        known(size.lateral(), &|x, y| size.lateral_texel(x, y))?,
        known(size.lid(), &|x, y| (CubeFace::PosY, x, y))?,
        known(size.lid(), &|x, y| (CubeFace::NegY, x, y))?,
    ])
}

/// A face, a column and a row.
type LidTexel = (CubeFace, u32, u32);

/// The box of texture that grows around what is `known` of its three textures.
fn lattice(
    exemplar: &Exemplar,
    known: &[Known; 3],
    wrapping: &Wrapping,
    settings: &CubemapSettings,
    seed: Seed,
    progress: &Progress<'_>,
    cancel: &Cancel,
) -> Result<Lattice, SynthesisError> {
    let synthesis = SynthesisSettings {
        tiles_x: false,
        ..settings.synthesis
    };
    let made = |name: &str, known: &Known| {
        let seed = seed.derive(name, 0);
        let preview = |_| {};
        texture_around(exemplar, known, &synthesis, seed, preview, progress, cancel)
            .map(|texture| texture.image)
    };
    let [lateral, top, bottom] = known;
    let lateral = made("lateral", lateral)?;
    let [top, bottom] = [made("top", top)?, made("bottom", bottom)?];
    let stage = progress.stage("assemble", 1);
    let lattice = assembled(&lateral, &top, &bottom, wrapping.size(), cancel)?;
    stage.advance();
    Ok(lattice)
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

    #[test]
    fn the_extent_is_measured_from_the_centre_to_the_edge() {
        let mask = Image::filled(10, 20, true);
        let extent = extent_of(&mask, Point::new(4.5, 4.5)).unwrap();
        assert_eq!((extent.across, extent.up, extent.down), (5.0, 5.0, 15.0));
        assert_eq!(extent_of(&Image::filled(3, 3, false), Point::ZERO), None);
    }
}
