//! Triangles with colours at their corners, as both renderers read them: stems, and the surfaces of
//! crowns.

use super::color::linear;
use crate::base::Digest;
use crate::branches::bark::{Bark, BarkKind};
use crate::crown::cube_sphere;
use crate::geometry::Mesh;
use crate::raster::Straight;
use crate::scene::{Crown, Trunk};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;
use std::sync::Arc;

/// A corner of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct MeshVertex {
    /// Metres, world.
    pub position: [f32; 3],
    /// Share of the light from all around that arrives.
    pub open: f32,
    /// Outward unit vector.
    pub normal: [f32; 3],
    /// Share of the sun that arrives.
    pub sunlit: f32,
    /// Linear.
    pub color: [f32; 3],
    /// To a multiple of 16 bytes.
    pub padding: f32,
}

/// Triangles, three corners each. A clone shares them.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedMesh {
    pub(crate) corners: Arc<[MeshVertex]>,
    /// Of the corners: by it a renderer knows a mesh again.
    pub(crate) digest: Digest,
}

/// Corners around a stem, and rings along it.
const AROUND: u32 = 72;
const ALONG: u32 = 220;

impl PreparedMesh {
    /// `mesh` with colours (linear) at its vertices.
    pub fn new(mesh: &Mesh, color: impl Fn(usize) -> [f32; 3]) -> Self {
        Self::from_corners(corners(mesh, color))
    }

    fn from_corners(corners: Vec<MeshVertex>) -> Self {
        Self {
            digest: Digest::of(bytemuck::cast_slice(&corners)),
            corners: corners.into(),
        }
    }

    /// `mesh` with a number at each vertex shown as a heat map: dark blue for `range.0` over green
    /// to yellow for `range.1`. For k along a silhouette, or for a map's distortion.
    pub fn heat_map(mesh: &Mesh, values: &[f64], range: (f64, f64)) -> Self {
        let span = (range.1 - range.0).max(f64::MIN_POSITIVE);
        Self::new(mesh, |i| {
            let value = values.get(i).copied().unwrap_or(range.0);
            heat(((value - range.0) / span).clamp(0.0, 1.0) as f32)
        })
    }

    /// The displaced surface of a crown, `cells` × `cells` squares a face, in its own colours.
    pub fn of_crown(crown: &Crown, cells: u32) -> Self {
        let mesh = cube_sphere(&crown.radius_m, crown.center_m, cells).mesh;
        Self::new(&mesh, |i| {
            let direction = mesh.positions[i] - crown.center_m;
            let [r, g, b, _] = crown.color.nearest(direction).0;
            [linear(r), linear(g), linear(b)]
        })
    }

    /// The base mesh of a crown, coloured by the distance to its centre.
    pub fn of_base(crown: &Crown) -> Self {
        let positions = &crown.base_mesh.positions;
        let far: Vec<f64> = positions
            .iter()
            .map(|p| p.distance(crown.center_m))
            .collect();
        let most = far.iter().copied().fold(0.0, f64::max);
        Self::heat_map(&crown.base_mesh, &far, (0.0, most))
    }

    /// The base mesh of a crown, coloured by how much it stretches the photograph that is laid on it
    /// from the front: the area of the surface by that of its picture, 1 (dark) to 8 and more, in
    /// halvings of the tone (thesis §4.3: where foliage must be synthesised instead).
    pub fn of_stretch(crown: &Crown) -> Self {
        /// Stretch at the end of the scale, powers of two.
        const MOST: f64 = 3.0;
        let normals = crown.base_mesh.vertex_normals();
        let halvings: Vec<f64> = normals
            .iter()
            .map(|normal| -libm::log2(normal.z.abs().max(1e-6)))
            .collect();
        Self::heat_map(&crown.base_mesh, &halvings, (0.0, MOST))
    }

    /// A stem with furrowed bark, in the shade of `crown` where it stands below or within it.
    pub fn of_trunk(trunk: &Trunk, crown: &Crown) -> Self {
        let place = |i: u32, j: u32| {
            let along = f64::from(j) / f64::from(ALONG);
            // Rings are nearer to each other at the foot, where one looks.
            (
                f64::from(i) / f64::from(AROUND),
                along * (0.4 + 0.6 * along),
            )
        };
        let mut mesh = Mesh::default();
        let mut colors = Vec::new();
        for j in 0..=ALONG {
            for i in 0..AROUND {
                let (turn, along) = place(i, j);
                let (position, color) = on_trunk(trunk, turn, along);
                mesh.positions.push(position);
                colors.push(color);
            }
        }
        for j in 0..ALONG {
            for i in 0..AROUND {
                let at = |i: u32, j: u32| j * AROUND + i % AROUND;
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.triangles.extend([[a, d, b], [b, d, c]]);
            }
        }
        let mut corners = corners(&mesh, |i| colors[i]);
        for corner in &mut corners {
            let outside = outside_crown(crown, DVec3::from(corner.position.map(f64::from)));
            corner.open = OPEN_BELOW + (1.0 - OPEN_BELOW) * outside;
            corner.sunlit = SUNLIT_BELOW + (1.0 - SUNLIT_BELOW) * outside;
        }
        Self::from_corners(corners)
    }
}

/// The corners of the triangles of `mesh`, in full light.
fn corners(mesh: &Mesh, color: impl Fn(usize) -> [f32; 3]) -> Vec<MeshVertex> {
    let normals = mesh.vertex_normals();
    let corner = |&index: &u32| {
        let i = index as usize;
        MeshVertex {
            position: mesh.positions[i].as_vec3().to_array(),
            open: 1.0,
            normal: normals[i].as_vec3().to_array(),
            sunlit: 1.0,
            color: color(i),
            padding: 0.0,
        }
    };
    mesh.triangles.iter().flatten().map(corner).collect()
}

/// The place of the bark at the share `turn` around and `along` up a stem, and its linear colour.
pub(crate) fn on_trunk(trunk: &Trunk, turn: f64, along: f64) -> (DVec3, [f32; 3]) {
    let bark = bark_of(trunk);
    let angle = turn * std::f64::consts::TAU;
    let outward = DVec3::new(libm::cos(angle), 0.0, libm::sin(angle));
    let height = (trunk.top_m.y - trunk.base_m.y) * along;
    // Roots: the foot is lobed.
    let low = libm::exp(-height / (2.5 * trunk.base_radius_m));
    let lobes = 1.0 + 0.16 * low * libm::sin(5.0 * angle + 1.0);
    let radius = trunk.radius_m(along) * lobes;
    let place = outward * trunk.base_radius_m + DVec3::Y * height;
    let relief = bark.relief(place.as_vec3(), radius as f32);
    let deep = 0.05 * radius * (f64::from(relief) - 1.0);
    let color = bark.colour(along as f32) * relief;
    let linear = |value: f32| linear(value.clamp(0.0, 255.0) as u8);
    (
        trunk.axis_m(along) + outward * (radius + deep),
        [linear(color.x), linear(color.y), linear(color.z)],
    )
}

/// The bark of a stem: as its picture shows it, or that of an oak.
fn bark_of(trunk: &Trunk) -> Bark {
    let Some(look) = trunk.look else {
        return Bark {
            kind: BarkKind::Furrowed,
            low: [112, 98, 82],
            high: [120, 108, 92],
        };
    };
    let [r, g, b] = look.bark;
    let luma = Straight([r, g, b, 255]).luma();
    let lift = (LEAST_LUMA / luma.max(1.0)).clamp(LIFT, MOST_LIFT);
    let lit = look.bark.map(|channel| {
        let pale = luma + (f32::from(channel) - luma) * COLOURED;
        (lift * pale).clamp(0.0, 245.0) as u8
    });
    Bark {
        kind: look.bark_kind,
        low: lit,
        high: lit,
    }
}

/// How much lighter bark is than its picture, at least and at most: furrows darken it again, and the picture has
/// shade in it. It is lifted to the luma, if that needs no more: what is darker stood in the shade.
const LIFT: f32 = 1.3;
const MOST_LIFT: f32 = 2.6;
const LEAST_LUMA: f32 = 92.0;
/// Share of its colour that bark keeps: the sun has coloured that of the picture, and will again.
const COLOURED: f32 = 0.7;

/// Shares of the light from all around and of the sun's that reach the stem right below a crown: that from the
/// side still does.
const OPEN_BELOW: f32 = 0.4;
const SUNLIT_BELOW: f32 = 0.16;

/// How far outside a crown a place is, 0 at its surface to 1 at twice its radius, for the light that it gets.
fn outside_crown(crown: &Crown, position: DVec3) -> f32 {
    let offset = position - crown.center_m;
    let reach = f64::from(crown.radius_m.sampled(offset + DVec3::Y * 1e-9));
    let outside = (offset.length() / reach - 1.0).clamp(0.0, 1.0);
    outside.sqrt() as f32
}

/// A colour for 0 … 1, linear: dark blue, green, yellow.
fn heat(value: f32) -> [f32; 3] {
    const STOPS: [[f32; 3]; 4] = [
        [0.04, 0.01, 0.15],
        [0.02, 0.16, 0.27],
        [0.10, 0.55, 0.16],
        [0.98, 0.80, 0.02],
    ];
    let place = value * (STOPS.len() - 1) as f32;
    let low = (place as usize).min(STOPS.len() - 2);
    let share = place - low as f32;
    std::array::from_fn(|i| STOPS[low][i] * (1.0 - share) + STOPS[low + 1][i] * share)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ball() -> Crown {
        Crown::ball(16)
    }

    #[test]
    fn a_stem_faces_outwards_and_is_dark_below_the_crown() {
        let crown = ball();
        let trunk = Trunk::under(&crown);
        let mesh = PreparedMesh::of_trunk(&trunk, &crown);
        for triangle in mesh.corners.chunks_exact(3) {
            let [a, b, c] = [0, 1, 2].map(|i| DVec3::from(triangle[i].position.map(f64::from)));
            let normal = (b - a).cross(c - a);
            let along = (a.y - trunk.base_m.y) / (trunk.top_m.y - trunk.base_m.y);
            assert!(normal.dot(a - trunk.axis_m(along)) > 0.0);
        }
        let first = mesh.corners.first().unwrap();
        let last = mesh.corners.last().unwrap();
        assert!(
            first.position[1] < 0.1 && first.open > 0.8 && last.open < 0.5 && last.sunlit < 0.3
        );
    }

    #[test]
    fn heat_goes_from_its_first_colour_to_its_last() {
        assert_eq!(heat(0.0), [0.04, 0.01, 0.15]);
        let end = heat(1.0).map(|channel| (channel * 100.0).round());
        assert_eq!(end, [98.0, 80.0, 2.0]);
    }

    #[test]
    fn a_photograph_is_stretched_where_the_surface_turns_away() {
        let mut crown = ball();
        crown.base_mesh = cube_sphere(&crown.radius_m, crown.center_m, 16).mesh;
        let mesh = PreparedMesh::of_stretch(&crown);
        let tone = |direction: DVec3| {
            let place = crown.center_m + 2.0 * direction;
            let far = |corner: &&MeshVertex| {
                let position = DVec3::from(corner.position.map(f64::from));
                position.distance(place)
            };
            let nearest = mesh.corners.iter().min_by(|a, b| far(a).total_cmp(&far(b)));
            nearest.unwrap().color
        };
        assert_eq!(tone(DVec3::Z), heat(0.0));
        assert_eq!(tone(DVec3::X), heat(1.0));
        // At 60 degrees the surface is twice its picture: one of three halvings.
        let slanted = DVec3::new(0.75f64.sqrt(), 0.0, 0.5);
        let (found, expected) = (tone(slanted), heat(1.0 / 3.0));
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 0.1, "{found} {expected}");
        }
    }

    #[test]
    fn the_surface_of_a_crown_has_its_radius() {
        let mesh = PreparedMesh::of_crown(&ball(), 8);
        assert_eq!(mesh.corners.len(), 6 * 8 * 8 * 2 * 3);
        for corner in mesh.corners.iter() {
            let offset = DVec3::from(corner.position.map(f64::from)) - DVec3::new(0.0, 5.0, 0.0);
            assert!((offset.length() - 2.0).abs() < 1e-3);
        }
    }
}
