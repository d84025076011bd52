//! A crown as both renderers read it: made once, uploaded once, drawn many times.

use super::ambient::{AMBIENT_SIZE, ambient_occlusion};
use super::color::{linear, srgb_byte};
use super::packed_cube::PackedCube;
use crate::base::{Cancel, Cancelled, Digest, Hasher};
use crate::raster::{Cubemap, Straight};
use crate::scene::Crown;
use glam::Vec3;

/// What is known of a crown before a camera is.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedCrown {
    /// Distance from the centre to the surface, metres.
    pub(crate) radius: PackedCube<f32>,
    /// Colour in sRGB; the fourth channel is the share of the sky that the surface sees.
    pub(crate) surface: PackedCube<[u8; 4]>,
    /// The centre, metres above and beside the base.
    pub(crate) center: Vec3,
    /// R_min and R_max of thesis §5.1, metres.
    pub(crate) radius_range: (f32, f32),
    /// Mean radius, metres.
    pub(crate) mean_radius: f32,
    /// Of all the above: by it a renderer knows a crown again.
    pub(crate) digest: Digest,
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
        let (least, most) = crown.radius_range_m();
        let radius = PackedCube::new(crown.radius_m.clone(), mean, |x| x);
        let ambient = ambient_occlusion(&radius, AMBIENT_SIZE, cancel)?;
        let surface = PackedCube::new(with_ambient(&crown.color, &ambient), mean_texel, packed);
        let digest = Hasher::new("boscage prepared crown")
            .with(bytemuck::cast_slice(radius.texels()))
            .with(bytemuck::cast_slice(surface.texels()))
            .with(bytemuck::bytes_of(&crown.center_m))
            .finish();
        Ok(Self {
            radius,
            surface,
            center: crown.center_m.as_vec3(),
            radius_range: (least, most),
            mean_radius: mean_radius(crown),
            digest,
        })
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

/// The mean of all texels of the radius.
fn mean_radius(crown: &Crown) -> f32 {
    let faces = crown.radius_m.faces();
    let sums = faces
        .iter()
        .map(|face| face.pixels().iter().map(|&r| f64::from(r)).sum::<f64>());
    let count = 6 * faces[0].pixels().len();
    (sums.sum::<f64>() / count as f64) as f32
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
    use crate::geometry::Mesh;

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
            center_m: glam::DVec3::new(0.0, 5.0, 0.0),
            radius_m: Cubemap::filled(16, 2.0),
            color,
            height: Cubemap::filled(16, 0.5),
            base_mesh: Mesh::default(),
        };
        let prepared = PreparedCrown::new(&crown, &Cancel::new()).unwrap();
        let ([texel, ..], _, _) = prepared.surface.around(Vec3::Z, 1);
        assert_eq!(texel[0], 188, "half the light is sRGB 188");
        assert_eq!(prepared.radius_range_m(), (2.0, 2.0));
    }
}
