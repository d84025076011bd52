//! A crown as both renderers read it: made once, uploaded once, drawn many times.

use super::ambient::{AMBIENT_SIZE, ambient_occlusion};
use super::color::{linear, srgb_byte};
use super::packed_cube::PackedCube;
use crate::base::{Cancel, Cancelled, Digest};
use crate::raster::{Cubemap, Straight};
use crate::scene::{Crown, Trunk};
use glam::{DVec3, Vec3};
use std::sync::Arc;

/// What is known of a crown before a camera is. A clone shares the cubemaps.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedCrown {
    /// Distance from the centre to the surface, metres.
    pub(crate) radius: Arc<PackedCube<f32>>,
    /// Colour in sRGB; the fourth channel is the share of the sky that the surface sees.
    pub(crate) surface: Arc<PackedCube<[u8; 4]>>,
    /// That share by itself, so that colours can change without it.
    ambient: Arc<Cubemap<f32>>,
    /// The centre, metres above and beside the base.
    pub(crate) center: Vec3,
    /// R_min and R_max of thesis §5.1, metres.
    pub(crate) radius_range: (f32, f32),
    /// Mean radius, metres.
    pub(crate) mean_radius: f32,
    /// Height by width, from 1 to [`MOST_SLENDER`].
    pub(crate) slender: f32,
    /// See [`Crown::cover`].
    pub(crate) cover: f32,
    /// From the centre to the foot of the stem, and the stem's radius, metres; 0: no stem.
    pub(crate) stem: [f32; 4],
    /// Of the radii and of the colours: by them a renderer knows what it has.
    pub(crate) radius_digest: Digest,
    pub(crate) surface_digest: Digest,
}

/// Light and alpha of a texel of colour while its levels are made.
type Texel = [f32; 4];

impl PreparedCrown {
    /// Packs the cubemaps of a crown and bakes its ambient occlusion.
    ///
    /// Takes about 50 ms for a size of 256.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(crown: &Crown, cancel: &Cancel) -> Result<Self, Cancelled> {
        let radius = PackedCube::new(crown.radius_m.clone(), mean, |x| x);
        let ambient = ambient_occlusion(&radius, AMBIENT_SIZE, cancel)?;
        let surface = PackedCube::new(with_ambient(&crown.color, &ambient), mean_texel, packed);
        Ok(Self {
            radius_digest: Digest::of(bytemuck::cast_slice(radius.texels())),
            surface_digest: Digest::of(bytemuck::cast_slice(surface.texels())),
            radius: Arc::new(radius),
            surface: Arc::new(surface),
            ambient: Arc::new(ambient),
            center: crown.center_m.as_vec3(),
            radius_range: crown.radius_range_m(),
            mean_radius: crown.mean_radius_m() as f32,
            slender: slender(crown),
            cover: crown.cover,
            stem: [0.0; 4],
        })
    }

    /// This crown on a stem, which throws a shadow too. The stem itself is a mesh of the scene,
    /// [`super::PreparedMesh::of_trunk`].
    #[must_use]
    pub fn on_stem(self, trunk: &Trunk) -> Self {
        let foot = trunk.base_m.as_vec3() - self.center;
        Self {
            stem: foot.extend(trunk.base_radius_m as f32).to_array(),
            ..self
        }
    }

    /// This crown with the radii and the centre of `crown`; its colours and its occlusion stay.
    ///
    /// For a shape that is being dragged: a tenth of the time of [`PreparedCrown::new`], and only
    /// the radii go to the card again. The occlusion is that of the shape before; prepare the crown
    /// anew once the drag is over. A stem stays where it is, below a centre that may move.
    #[must_use]
    pub fn reshaped(&self, crown: &Crown) -> Self {
        let radius = PackedCube::new(crown.radius_m.clone(), mean, |x| x);
        Self {
            radius_digest: Digest::of(bytemuck::cast_slice(radius.texels())),
            radius: Arc::new(radius),
            center: crown.center_m.as_vec3(),
            radius_range: crown.radius_range_m(),
            mean_radius: crown.mean_radius_m() as f32,
            slender: slender(crown),
            cover: crown.cover,
            ..self.clone()
        }
    }

    /// This crown with the colours of `crown`; its shape stays, and with it the occlusion.
    #[must_use]
    pub fn recolored(&self, crown: &Crown) -> Self {
        let texels = with_ambient(&crown.color, &self.ambient);
        let surface = PackedCube::new(texels, mean_texel, packed);
        Self {
            surface_digest: Digest::of(bytemuck::cast_slice(surface.texels())),
            surface: Arc::new(surface),
            ..self.clone()
        }
    }

    /// R_min and R_max, metres.
    pub fn radius_range_m(&self) -> (f32, f32) {
        self.radius_range
    }
}

/// The colours of a crown as linear light, with its ambient occlusion beside them.
fn with_ambient(color: &Cubemap<Straight>, ambient: &Cubemap<f32>) -> Cubemap<Texel> {
    let mut texels = color.map(|&Straight([r, g, b, _])| [linear(r), linear(g), linear(b), 0.0]);
    let places = Cubemap::from_directions(color.size(), |direction| ambient.sampled(direction));
    for face in crate::raster::CubeFace::ALL {
        let open = places.face(face).pixels();
        for (texel, &open) in texels.face_mut(face).pixels_mut().iter_mut().zip(open) {
            texel[3] = open;
        }
    }
    texels
}

/// Largest height by width that leaves are spread for.
const MOST_SLENDER: f32 = 4.0;

/// How far a crown reaches up and down, by how far it reaches aside; crowns wider than high have 1.
fn slender(crown: &Crown) -> f32 {
    const SIDES: usize = 16;
    let radius = &crown.radius_m;
    let around = (0..SIDES).map(|i| {
        let turn = std::f64::consts::TAU * i as f64 / SIDES as f64;
        radius.sampled(DVec3::new(libm::cos(turn), 0.0, libm::sin(turn)))
    });
    let aside = around.sum::<f32>() / SIDES as f32;
    let along = 0.5 * (radius.sampled(DVec3::Y) + radius.sampled(DVec3::NEG_Y));
    (along / aside.max(1e-6)).clamp(1.0, MOST_SLENDER)
}

fn mean([a, b, c, d]: [f32; 4]) -> f32 {
    (a + b + c + d) * 0.25
}

fn mean_texel(four: [Texel; 4]) -> Texel {
    std::array::from_fn(|i| mean(four.map(|texel| texel[i])))
}

fn packed([r, g, b, open]: Texel) -> [u8; 4] {
    let open = (open.clamp(0.0, 1.0) * 255.0 + 0.5) as u8;
    [srgb_byte(r), srgb_byte(g), srgb_byte(b), open]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_average_light_and_not_srgb_values() {
        let mut color = Cubemap::filled(16, Straight([0, 0, 0, 255]));
        for face in crate::raster::CubeFace::ALL {
            for (i, pixel) in color.face_mut(face).pixels_mut().iter_mut().enumerate() {
                let on = (i + i / 16) % 2 == 0;
                *pixel = Straight([if on { 255 } else { 0 }, 0, 0, 255]);
            }
        }
        let crown = Crown {
            color,
            ..Crown::ball(16)
        };
        let prepared = PreparedCrown::new(&crown, &Cancel::new()).unwrap();
        let ([texel, ..], _, _) = prepared.surface.around(Vec3::Z, 1);
        assert_eq!(texel[0], 188, "half the light is sRGB 188");
        assert_eq!(prepared.radius_range_m(), (2.0, 2.0));
    }

    #[test]
    fn a_change_of_one_part_keeps_the_other() {
        let crown = |radius: f32, red: u8| Crown {
            radius_m: Cubemap::from_directions(16, |d| radius + 0.2 * d.normalize().x as f32),
            color: Cubemap::filled(16, Straight([red, 90, 40, 255])),
            ..Crown::ball(16)
        };
        let prepared = |crown: &Crown| PreparedCrown::new(crown, &Cancel::new()).unwrap();
        let one = prepared(&crown(2.0, 50));
        assert_eq!(one.recolored(&crown(2.0, 70)), prepared(&crown(2.0, 70)));
        let larger = one.reshaped(&crown(3.0, 50));
        assert_eq!(larger.surface_digest, one.surface_digest);
        assert_eq!(larger.radius, prepared(&crown(3.0, 50)).radius);
        assert_ne!(larger.radius_digest, one.radius_digest);
    }
}
