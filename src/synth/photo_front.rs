//! The photograph on the front of the crown, the synthesised foliage everywhere else.
//!
//! Each texel looks along its direction to the crown's surface and from there straight to the picture
//! plane: that pixel of the photograph is what the photographer saw there. Where the surface faces the
//! viewer the photograph stays; towards the silhouette, where it would be smeared, it must end; and in
//! the wide band between, the cheapest seam over the texels of the cube ([`cube_seam`]) decides. Sky
//! that shows through the crown, and what surrounds it, comes from the synthesised foliage too.
//!
//! The synthesised foliage has some of the photograph's large-scale light taken out
//! ([`super::ExemplarSettings::flatten`]); the photograph on the front loses it gradually towards the
//! band, so that no step of brightness is left for the seam to hide.
//!
//! Source: the seam is that of Kwatra et al. 2003 on another graph; the rest is ours.

use super::cube_seam::{chosen, cube_seam};
use super::cubemap::FoliageCubemap;
use super::seam::{Side, StepCost};
use crate::base::{Cancel, Cancelled};
use crate::geometry::Point;
use crate::raster::{CubeFace, Cubemap, Image, Mask, Straight, dilated};
use glam::DVec3;
use rayon::prelude::*;

/// Facing (normal · direction to the viewer) from which on the photograph stays: 0.85 is 32° off.
/// Lower, and foreshortened leaves show at three-quarter view; higher, and less is left of the
/// photograph.
const SURELY_FRONT: f64 = 0.85;

/// Facing below which the photograph is never taken: it is drawn out to more than three times its
/// width there.
const NEVER_FRONT: f64 = 0.3;

/// What a texel of the band costs that is not taken from the photograph although it could be, towards
/// [`SURELY_FRONT`]; a step of a seam costs about a hundred between leaves. Without it the cheapest seam
/// is the shortest, and the photograph shrinks to patches between gaps of sky.
const MOST_PREFERRED: u8 = 60;

/// Pixels around sky in which the seam may run.
const AROUND_SKY: u8 = 2;

/// The surface of a crown without relief.
#[derive(Debug, Clone, Copy)]
pub struct CrownSurface<'a> {
    /// The centre in the photograph; it lies in the picture's plane.
    pub center: Point,
    /// The distance of the surface from the centre, pixels of the photograph.
    pub radius: &'a Cubemap<f32>,
}

/// The colours of `foliage` with the photograph that it was made of on the front.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn with_photo_front(
    foliage: &FoliageCubemap,
    surface: CrownSurface<'_>,
    cancel: &Cancel,
) -> Result<Cubemap<Straight>, Cancelled> {
    let photo = Front::new(foliage);
    let size = foliage.color.size();
    let row = |face: CubeFace, y: u32| {
        cancel.check()?;
        let texels = (0..size).map(|x| photo.texel(surface, face, [x, y], size));
        Ok(texels.collect::<Vec<_>>())
    };
    let rows: Vec<Vec<Seen>> = (0..6 * size)
        .into_par_iter()
        .map(|index| row(CubeFace::ALL[(index / size) as usize], index % size))
        .collect::<Result<_, Cancelled>>()?;
    let seen = Cubemap::from_faces(std::array::from_fn(|face| {
        let first = face * size as usize;
        Image::from_pixels(size, size, rows[first..first + size as usize].concat())
    }));
    let (color, side) = (seen.map(|texel| texel.0), seen.map(|texel| texel.1));
    let preference = seen.map(|texel| texel.2);
    let (from_foliage, _) = cube_seam(
        &color,
        &foliage.color,
        &side,
        &preference,
        StepCost::Difference,
        cancel,
    )?;
    Ok(chosen(&color, &foliage.color, &from_foliage))
}

/// What the photograph shows in a texel; whether it may, must or must not be taken; and what it costs
/// not to take it where it may.
type Seen = (Straight, Side, u8);

/// A texel that the photograph does not show.
const NOTHING: Seen = (Straight([0; 4]), Side::Second, 0);

/// The photograph, ready to be looked up.
struct Front<'a> {
    foliage: &'a FoliageCubemap,
    /// The photograph, its light evened out.
    even: Image<Straight>,
    /// Where leaves are, and no sky within [`AROUND_SKY`] pixels.
    inner: Mask,
}

impl<'a> Front<'a> {
    fn new(foliage: &'a FoliageCubemap) -> Self {
        let leaves = foliage.exemplar.foliage();
        let outside = dilated(&leaves.map(|&inside| !inside), AROUND_SKY);
        let mut even = foliage.scaled.photo.clone();
        let (picture, bounds) = (foliage.exemplar.picture(), foliage.exemplar.bounds());
        for y in 0..bounds.height {
            for x in 0..bounds.width {
                if picture.at(x, y).alpha() > 0 {
                    even.set(bounds.x + x, bounds.y + y, picture.at(x, y));
                }
            }
        }
        Self {
            foliage,
            even,
            inner: outside.map(|&outside| !outside),
        }
    }

    /// What the photograph shows in a texel.
    fn texel(
        &self,
        surface: CrownSurface<'_>,
        face: CubeFace,
        [x, y]: [u32; 2],
        size: u32,
    ) -> Seen {
        let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
        let (u, v) = (centre(x), centre(y));
        let facing = facing(surface.radius, face, [u, v]);
        if facing <= NEVER_FRONT {
            return NOTHING;
        }
        let point = position(surface.radius, face.direction(u, v));
        let seen = Point::new(surface.center.x + point.x, surface.center.y - point.y);
        let place = self.foliage.scaled.place(seen);
        let near = |place: f64| libm::round(place) as i64;
        let (column, row) = (near(place.x), near(place.y));
        let leaves = self.foliage.exemplar.foliage();
        if leaves.get(column, row) != Some(true) {
            return NOTHING;
        }
        let evened = smooth_step((SURELY_FRONT + 0.1 - facing) / (SURELY_FRONT - NEVER_FRONT));
        let colors = [&self.foliage.scaled.photo, &self.even];
        let [raw, even] = colors.map(|image| bilinear(image, leaves, place));
        let mixed = |c: usize| (raw[c] + (even[c] - raw[c]) * evened + 0.5) as u8;
        let color = Straight([mixed(0), mixed(1), mixed(2), 255]);
        let front = (facing - NEVER_FRONT) / (SURELY_FRONT - NEVER_FRONT);
        let preference = f64::from(MOST_PREFERRED) * front.min(1.0);
        let is_inner = self.inner.get(column, row) == Some(true);
        match facing >= SURELY_FRONT && is_inner {
            true => (color, Side::First, 0),
            false => (color, Side::Either, preference as u8),
        }
    }
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
