//! Ambient occlusion of a crown: which share of the light from all around its surface gets.
//!
//! For each direction from the centre the surface's horizon is sought in some azimuths about the
//! normal, stepping over the sphere of directions in growing steps, as horizon-based ambient
//! occlusion does over a picture (Bavoil, Sainz & Dimitrov, *Image-Space Horizon-Based Ambient
//! Occlusion*, 2008). A slice with the horizon at the elevation e gets 1 − sin² e of its
//! cosine-weighted light. The thesis (§5.3) approximates all this by the height above the ground
//! and the distance to the centre.
//!
//! Limits: the surface is known as a radius, so what hides behind an overhang is not.

use super::packed_cube::PackedCube;
use super::surface::{normal, tangents};
use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Cubemap, Image};
use glam::Vec3;
use rayon::prelude::*;

/// Texels along a side of the baked cubemap: occlusion is smoother than the surface.
pub(super) const AMBIENT_SIZE: u32 = 128;

/// Directions about the normal in which the horizon is sought.
const AZIMUTHS: usize = 8;

/// Angles from the centre at which the horizon is looked at, radians: from a leaf's next
/// neighbours to the other side of a bay.
const STEPS: [f32; 7] = [0.02, 0.045, 0.08, 0.14, 0.23, 0.37, 0.58];

/// The share of light, 0 … 1, that each direction's piece of surface gets from around it.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn ambient_occlusion(
    radius: &PackedCube<f32>,
    size: u32,
    cancel: &Cancel,
) -> Result<Cubemap<f32>, Cancelled> {
    let faces = CubeFace::ALL.map(|face| {
        let mut pixels = vec![0.0; (size * size) as usize];
        let rows = pixels.par_chunks_mut(size as usize).enumerate();
        rows.for_each(|(y, row)| {
            if cancel.is_cancelled() {
                return;
            }
            for (x, open) in row.iter_mut().enumerate() {
                let place = |i: usize| (2.0 * i as f64 + 1.0) / f64::from(size) - 1.0;
                let direction = face.direction(place(x), place(y)).normalize();
                *open = openness(radius, direction.as_vec3());
            }
        });
        Image::from_pixels(size, size, pixels)
    });
    cancel.check()?;
    Ok(Cubemap::from_faces(faces))
}

/// The share of light that the surface in `direction` (a unit vector) gets.
fn openness(radius: &PackedCube<f32>, direction: Vec3) -> f32 {
    // Level 1 as far as there is one: a texel's own noise is no horizon.
    let level = u32::from(radius.levels() > 1);
    let normal = normal(radius, direction, level);
    let from = direction * radius.sampled(direction, level);
    let (right, up) = tangents(direction);
    let mut open = 0.0;
    for azimuth in 0..AZIMUTHS {
        let angle = (azimuth as f32 + 0.5) * (std::f32::consts::TAU / AZIMUTHS as f32);
        let aside = right * libm::cosf(angle) + up * libm::sinf(angle);
        let mut sine = 0.0f32;
        for step in STEPS {
            let ahead = direction * libm::cosf(step) + aside * libm::sinf(step);
            let toward = ahead * radius.sampled(ahead, level) - from;
            let elevation = toward.dot(normal) / toward.dot(toward).sqrt();
            sine = sine.max(elevation);
        }
        open += 1.0 - sine * sine;
    }
    open / AZIMUTHS as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn occlusion(shape: impl Fn(glam::DVec3) -> f64) -> Cubemap<f32> {
        let radius = Cubemap::from_directions(64, |d| shape(d.normalize()) as f32);
        let mean = |four: [f32; 4]| four.iter().sum::<f32>() * 0.25;
        let packed = PackedCube::new(radius, mean, |x| x);
        ambient_occlusion(&packed, 32, &Cancel::new()).unwrap()
    }

    #[test]
    fn a_ball_is_open_everywhere() {
        let open = occlusion(|_| 3.0);
        let all = open.faces().iter().flat_map(|face| face.pixels());
        assert!(all.clone().all(|&share| share > 0.99));
    }

    #[test]
    fn a_hollow_is_darker_than_its_rim() {
        // A dent of 25 degrees around +Z.
        let open = occlusion(|d| {
            let angle = libm::acos(d.z.clamp(-1.0, 1.0));
            3.0 - 1.2 * libm::exp(-(angle / 0.25) * (angle / 0.25))
        });
        let bottom = open.sampled(glam::DVec3::Z);
        let rim = open.sampled(glam::DVec3::new(0.6, 0.0, 1.0));
        assert!(bottom < 0.75 && rim > 0.9, "{bottom} {rim}");
    }

    #[test]
    fn a_cancelled_bake_ends() {
        let packed = PackedCube::new(Cubemap::filled(16, 1.0), |four| four[0], |x: f32| x);
        let cancel = Cancel::new();
        cancel.cancel();
        assert!(ambient_occlusion(&packed, 16, &cancel).is_err());
    }
}
