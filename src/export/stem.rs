//! The stem of a crown as a textured mesh: a tapered tube around the curve of a [`Trunk`], its bark
//! unrolled into one picture.
//!
//! The picture's left and right edges meet at the seam of the tube, and the bark has none there, so
//! any sampler will do. Furrows are in the picture only: at the distance from which whole trees are
//! seen they have no outline.

use super::model_mesh::ModelMesh;
use crate::geometry::Mesh;
use crate::raster::{Image, Straight};
use crate::render::{on_trunk, srgb_byte};
use crate::scene::Trunk;
use glam::DVec3;

/// Width and height of the bark's picture: once around, and from the top to the foot.
const BARK_PX: [u32; 2] = [256, 1024];

/// Height of a tree, and what its stem is moved by so that its foot stands at the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stand {
    /// From the ground to the top, metres.
    pub(super) height_m: f64,
    /// What is added to positions in the crown's frame.
    pub(super) shift: DVec3,
}

impl Stand {
    /// How far a place sways, 0 at the foot and 1 at the top.
    pub(super) fn sway(&self, y: f64) -> f64 {
        let share = (y / self.height_m).clamp(0.0, 1.0);
        share * share
    }
}

/// The bark of `trunk`, unrolled: once around from left to right, the foot at the bottom.
pub(super) fn bark_picture(trunk: &Trunk) -> Image<Straight> {
    let [width, height] = BARK_PX;
    let texels = (0..width * height).map(|i| {
        let turn = (f64::from(i % width) + 0.5) / f64::from(width);
        let along = 1.0 - (f64::from(i / width) + 0.5) / f64::from(height);
        let (_, color) = on_trunk(trunk, turn, along);
        let [r, g, b] = color.map(srgb_byte);
        Straight([r, g, b, 255])
    });
    Image::from_pixels(width, height, texels.collect())
}

/// The tube of `trunk` in `around` × `along` quads.
pub(super) fn stem(trunk: &Trunk, stand: &Stand, around: u32, along: u32) -> ModelMesh {
    let ring = |j: u32| {
        let share = f64::from(j) / f64::from(along);
        // Rings are nearer to each other at the foot, where the roots flare.
        share * (0.3 + 0.7 * share)
    };
    let place = |i: u32, j: u32| {
        let angle = f64::from(i % around) / f64::from(around) * std::f64::consts::TAU;
        let outward = DVec3::new(libm::cos(angle), 0.0, libm::sin(angle));
        let share = ring(j);
        trunk.axis_m(share) + outward * trunk.radius_m(share) + stand.shift
    };
    let mut closed = Mesh::default();
    for j in 0..=along {
        closed.positions.extend((0..around).map(|i| place(i, j)));
    }
    for j in 0..along {
        for i in 0..around {
            let at = |i: u32, j: u32| j * around + i % around;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            closed.triangles.extend([[a, d, b], [b, d, c]]);
        }
    }
    let normals = closed.vertex_normals();
    let mut mesh = ModelMesh::default();
    for j in 0..=along {
        for i in 0..=around {
            let vertex = (j * around + i % around) as usize;
            let at = closed.positions[vertex];
            let u = f64::from(i) / f64::from(around);
            mesh.positions.push(at.as_vec3().to_array());
            mesh.normals.push(normals[vertex].as_vec3().to_array());
            mesh.uvs.push([u as f32, (1.0 - ring(j)) as f32]);
            mesh.wind.push([0.0, 0.0, stand.sway(at.y) as f32]);
        }
    }
    let row = around + 1;
    for j in 0..along {
        for i in 0..around {
            let a = j * row + i;
            let [b, c, d] = [a + 1, a + row + 1, a + row];
            mesh.indices.extend([a, d, b, b, d, c]);
        }
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stem_stands_on_the_ground_and_faces_outwards() {
        let trunk = Trunk {
            look: None,
            base_m: DVec3::new(0.0, 0.0, 1.0),
            top_m: DVec3::new(0.0, 5.0, 1.0),
            base_radius_m: 0.2,
            top_radius_m: 0.1,
            bow_m: DVec3::ZERO,
        };
        let stand = Stand {
            height_m: 8.0,
            shift: -trunk.base_m,
        };
        let mesh = stem(&trunk, &stand, 8, 4);
        assert_eq!(mesh.indices.len(), 8 * 4 * 6);
        for (position, normal) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((0.0..=5.0).contains(&position[1]));
            assert!(position[0] * normal[0] + position[2] * normal[2] > 0.0);
        }
        let foot = mesh.positions.iter().position(|p| p[1] == 0.0).unwrap();
        assert_eq!(mesh.uvs[foot][1], 1.0, "the picture's foot is below");
        assert_eq!(mesh.wind[foot], [0.0; 3], "the foot stands still");
    }
}
