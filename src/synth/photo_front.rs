//! The photograph on the front of the crown, and foliage that grows out of it everywhere else.
//!
//! Each direction leads to the crown's surface and from there straight to the picture plane: that pixel
//! of the photograph is what the photographer saw there. Where the surface faces the viewer and the
//! photograph shows leaves, it stays: those texels are known to the synthesis, which fills the gaps
//! where sky showed through and continues the photograph over the rest of the crown. Around the border
//! of what is known the synthesised foliage and the photograph's outermost part, which would be smeared
//! towards the silhouette, are both there to choose from; the cheapest seam over the texels of the cube
//! ([`cube_seam`]) decides.
//!
//! All of this is done with the large-scale light taken out
//! ([`super::ExemplarSettings::flatten`]). In the end it is put back on the front, on the photograph and
//! on what fills its gaps alike, and fades towards the border, where the crown goes on in even light.
//!
//! Source: growing texture around given pixels is Lefebvre & Hoppe's correction with constraints, the
//! seam that of Kwatra et al. 2003 on another graph; the rest is ours.

use super::cube_seam::cube_seam;
use super::cubemap::ScaledPhoto;
use super::exemplar::Exemplar;
use super::seam::{Side, StepCost};
use crate::base::{Cancel, Cancelled};
use crate::geometry::Point;
use crate::raster::{CubeFace, Cubemap, Image, Mask, Straight};
use glam::DVec3;
use rayon::prelude::*;

/// Facing (normal · direction to the viewer) from which on the photograph stays: 0.55 is 57° off, where
/// it is drawn out to less than twice its width. Higher, and less is left of the photograph; lower, and
/// smeared leaves show at three-quarter view.
const SURELY_FRONT: f64 = 0.55;

/// Facing below which the photograph is never taken: it is drawn out to 2.5 times its width there.
const NEVER_FRONT: f64 = 0.4;

/// Facing from which on the photograph has all of its own light; from there to [`SURELY_FRONT`] it fades.
const OWN_LIGHT: f64 = 0.95;

/// What a texel between [`NEVER_FRONT`] and [`SURELY_FRONT`] costs that is not taken from the
/// photograph, towards the latter; a step of a seam costs about a hundred between leaves. Higher, and
/// more is smeared; 0, and the cheapest seam is the shortest.
const MOST_PREFERRED: f64 = 30.0;

/// The surface of a crown without relief.
#[derive(Debug, Clone, Copy)]
pub struct CrownSurface<'a> {
    /// The centre in the photograph; it lies in the picture's plane.
    pub center: Point,
    /// The distance of the surface from the centre, pixels of the photograph.
    pub radius: &'a Cubemap<f32>,
}

impl CrownSurface<'_> {
    /// How much the surface in every direction faces the viewer, −1 … 1, as a cubemap of `size` texels:
    /// the z of its normal.
    pub fn facing(&self, size: u32) -> Cubemap<f64> {
        let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
        let texel = |face, x, y| facing(self.radius, face, [centre(x), centre(y)]);
        Cubemap::from_faces(CubeFace::ALL.map(|face| {
            let texels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
            let pixels = texels.map(|(x, y)| texel(face, x, y)).collect();
            Image::from_pixels(size, size, pixels)
        }))
    }
}

/// The photograph on the front of a crown, ready to be looked up.
pub(super) struct Front<'a> {
    photo: &'a ScaledPhoto,
    exemplar: &'a Exemplar,
    /// Where the scaled photograph shows the crown and no sky.
    shown: Mask,
    surface: CrownSurface<'a>,
}

/// What the front has in a direction.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// The photograph's colour in even light, if it shows the crown there.
    color: Option<Straight>,
    /// What its place in the photograph has to be multiplied by to get its own light back.
    light: [f32; 3],
    facing: f64,
}

impl<'a> Front<'a> {
    /// The front of `surface` in `photo`, of which `shown` may be used.
    pub(super) fn new(
        photo: &'a ScaledPhoto,
        exemplar: &'a Exemplar,
        shown: Mask,
        surface: CrownSurface<'a>,
    ) -> Self {
        Self {
            photo,
            exemplar,
            shown,
            surface,
        }
    }

    /// The photograph's colour in `direction`, in even light, where it surely stays.
    pub(super) fn known(&self, direction: DVec3) -> Option<[u8; 3]> {
        let (face, u, v) = CubeFace::of(direction);
        let seen = self.seen(face, [u, v])?;
        let Straight([r, g, b, _]) = seen.color.filter(|_| seen.facing >= SURELY_FRONT)?;
        Some([r, g, b])
    }

    /// The photograph over `grown`, which continues it; and which texels are the photograph's.
    ///
    /// # Errors
    /// [`Cancelled`] when the work was asked to stop.
    pub(super) fn laid_over(
        &self,
        grown: &Cubemap<Straight>,
        cancel: &Cancel,
    ) -> Result<(Cubemap<Straight>, Cubemap<bool>), Cancelled> {
        let seen = self.cubemap(grown.size(), cancel)?;
        let color = |seen: &Option<Seen>| seen.and_then(|seen| seen.color).unwrap_or_default();
        let side = seen.map(|seen| match seen {
            Some(seen) if seen.color.is_some() && seen.facing >= SURELY_FRONT => Side::First,
            Some(seen) if seen.color.is_some() => Side::Either,
            _ => Side::Second,
        });
        let preference = seen.map(|seen| {
            let facing = seen.map_or(0.0, |seen| seen.facing);
            let share = (facing - NEVER_FRONT) / (SURELY_FRONT - NEVER_FRONT);
            (MOST_PREFERRED * share.clamp(0.0, 1.0)) as u8
        });
        let (photo, cost) = (seen.map(color), StepCost::Difference);
        let (from_grown, _) = cube_seam(&photo, grown, &side, &preference, cost, cancel)?;
        let faces = CubeFace::ALL.map(|face| {
            let [photo, grown] = [&photo, grown].map(|map| map.face(face).pixels());
            let chosen = photo.iter().zip(grown).zip(from_grown.face(face).pixels());
            let chosen = chosen.map(|((&a, &b), &second)| if second { b } else { a });
            let seen = seen.face(face).pixels().iter();
            let lit = chosen.zip(seen).map(|(color, seen)| match seen {
                Some(seen) => relit(color, seen.light),
                None => color,
            });
            Image::from_pixels(from_grown.size(), from_grown.size(), lit.collect())
        });
        Ok((
            Cubemap::from_faces(faces),
            from_grown.map(|&second| !second),
        ))
    }

    /// What the front has in every texel of a cubemap.
    fn cubemap(&self, size: u32, cancel: &Cancel) -> Result<Cubemap<Option<Seen>>, Cancelled> {
        let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
        let row = |face: CubeFace, y: u32| {
            cancel.check()?;
            let texels = (0..size).map(|x| self.seen(face, [centre(x), centre(y)]));
            Ok(texels.collect::<Vec<_>>())
        };
        let rows: Vec<Vec<Option<Seen>>> = (0..6 * size)
            .into_par_iter()
            .map(|index| row(CubeFace::ALL[(index / size) as usize], index % size))
            .collect::<Result<_, Cancelled>>()?;
        Ok(Cubemap::from_faces(std::array::from_fn(|face| {
            let first = face * size as usize;
            Image::from_pixels(size, size, rows[first..first + size as usize].concat())
        })))
    }

    /// What the front has in the direction of (u, v) of `face`; `None` where it faces the viewer too
    /// little.
    fn seen(&self, face: CubeFace, uv: [f64; 2]) -> Option<Seen> {
        let facing = facing(self.surface.radius, face, uv);
        if facing <= NEVER_FRONT {
            return None;
        }
        let point = position(self.surface.radius, face.direction(uv[0], uv[1]));
        let center = self.surface.center;
        let place = self
            .photo
            .place(Point::new(center.x + point.x, center.y - point.y));
        let near = |place: f64| libm::round(place) as i64;
        let is_shown = self.shown.get(near(place.x), near(place.y)) == Some(true);
        let gain = self.exemplar.gain(place);
        let color = is_shown.then(|| {
            let raw = bilinear(&self.photo.photo, &self.shown, place);
            let [r, g, b] = [0, 1, 2].map(|i| (raw[i] as f32 * gain[i] + 0.5).min(255.0) as u8);
            Straight([r, g, b, 255])
        });
        let faded = smooth_step((OWN_LIGHT - facing) / (OWN_LIGHT - SURELY_FRONT)) as f32;
        Some(Seen {
            color,
            light: gain.map(|gain| faded + (1.0 - faded) / gain),
            facing,
        })
    }
}

/// `color` with each channel multiplied by that of `light`.
fn relit(color: Straight, light: [f32; 3]) -> Straight {
    let Straight([r, g, b, alpha]) = color;
    let [r, g, b] = [(r, 0), (g, 1), (b, 2)]
        .map(|(value, i)| (f32::from(value) * light[i] + 0.5).min(255.0) as u8);
    Straight([r, g, b, alpha])
}

/// The point of the surface in `direction`, from the centre, y up.
fn position(radius: &Cubemap<f32>, direction: DVec3) -> DVec3 {
    let direction = direction.normalize();
    direction * f64::from(radius.sampled(direction))
}

/// How much the surface in a texel faces the viewer: the z of its normal, 1 straight towards.
fn facing(radius: &Cubemap<f32>, face: CubeFace, [u, v]: [f64; 2]) -> f64 {
    // Two texels of the radius on each side: its own steps are not to show.
    let step = 4.0 / f64::from(radius.size());
    let at = |u: f64, v: f64| position(radius, face.direction(u, v));
    let right = at(u + step, v) - at(u - step, v);
    let down = at(u, v + step) - at(u, v - step);
    down.cross(right).normalize_or_zero().z
}

fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The colour of `image` at `place`, from those of the four pixels around that belong to `mask`; the
/// nearest one must.
fn bilinear(image: &Image<Straight>, mask: &Mask, place: Point) -> [f64; 3] {
    let (left, top) = (libm::floor(place.x), libm::floor(place.y));
    let (right, down) = (place.x - left, place.y - top);
    let (mut sum, mut total) = ([0.0; 3], 0.0);
    for (dy, row) in [(0, 1.0 - down), (1, down)] {
        for (dx, column) in [(0, 1.0 - right), (1, right)] {
            let (x, y) = (left as i64 + dx, top as i64 + dy);
            if mask.get(x, y) != Some(true) {
                continue;
            }
            let weight = row * column;
            let pixel = image.at(x as u32, y as u32).0;
            for (sum, value) in sum.iter_mut().zip(pixel) {
                *sum += weight * f64::from(value);
            }
            total += weight;
        }
    }
    sum.map(|sum| sum / f64::max(total, 1e-9))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ball_faces_the_viewer_as_much_as_its_directions_do() {
        let ball = Cubemap::filled(64, 30.0f32);
        for face in CubeFace::ALL {
            for (u, v) in [(0.0, 0.0), (0.5, -0.3), (-0.97, 0.97)] {
                let expected = face.direction(u, v).normalize().z;
                assert!((facing(&ball, face, [u, v]) - expected).abs() < 1e-2);
            }
        }
    }

    #[test]
    fn colours_come_from_the_mask_only() {
        let image = Image::from_pixels(2, 1, vec![Straight([10, 20, 30, 255]), Straight([200; 4])]);
        let mask = Image::from_pixels(2, 1, vec![true, false]);
        let color = bilinear(&image, &mask, Point::new(0.4, 0.0));
        assert!((color[2] - 30.0).abs() < 1e-9);
    }
}
