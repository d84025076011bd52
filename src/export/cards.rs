//! Cards: flat pieces of a sprite stood upright, alone or crossed about the trunk.
//!
//! Frame: glTF's. +Y up, metres, the foot at the origin, the first card in the plane z = 0 facing
//! +Z. Card i of n is turned by i · 180°/n about +Y.
//!
//! Each card has two sides of its own, back to back, instead of a material that draws both: readers
//! turn the normals of such a material round behind (glTF asks for it), and a crown whose top is lit
//! from the front would be lit from below behind. Normals are those of the sides, bent upwards: the
//! cards then take up much the same light where they cross, and there is no dark seam along the
//! trunk where one is seen at a grazing angle. Tangents point along the picture's x, so a normal map
//! with Y+ lies as it was painted, in front and (mirrored) behind.
//!
//! Wind weights follow Sousa (*Vegetation procedural animation and shading in Crysis*, GPU Gems 3,
//! ch. 16): red is how freely an edge flutters (0 at the trunk's axis, 1 at the outermost leaf),
//! green the phase (one value a card, so that crossed cards do not move as one), blue how far the
//! whole sways (0 at the foot, 1 at the top, growing with the square of the height).

use super::model_mesh::ModelMesh;
use super::sprite::Sprite;
use crate::geometry::Point;

/// How far normals are bent: this much up for 1 outwards, 56°. Bent less, crossed cards show their
/// edges; bent more, light from the side no longer shapes the tree.
const LIFT: f64 = 1.5;

/// Distance of a side from the middle of its card, as a share of the tree's height: a ray tracer,
/// which draws sides that face away too, must be able to tell which comes first.
const SIDE_GAP: f64 = 1e-4;

/// A flat piece of a sprite, in pixels of its canvas.
#[derive(Debug, Clone, PartialEq)]
pub struct Flat {
    /// Positions from the canvas' top-left corner, y down.
    pub vertices: Vec<Point>,
    /// Indices of `vertices`, counter-clockwise as seen by the viewer.
    pub triangles: Vec<[u32; 3]>,
}

impl Flat {
    /// A piece of these triangles, each turned to be counter-clockwise as seen by the viewer;
    /// vertices that no triangle uses are left out.
    pub fn new(vertices: Vec<Point>, triangles: Vec<[u32; 3]>) -> Self {
        let mut place: Vec<Option<u32>> = vec![None; vertices.len()];
        let mut kept = Vec::new();
        let triangles = triangles
            .into_iter()
            .map(|[a, b, c]| {
                let [pa, pb, pc] = [a, b, c].map(|i| vertices[i as usize]);
                // y points down: a positive product is clockwise on screen.
                if (pb - pa).perp_dot(pc - pa) > 0.0 {
                    [a, c, b]
                } else {
                    [a, b, c]
                }
            })
            .map(|corners| {
                corners.map(|i| {
                    *place[i as usize].get_or_insert_with(|| {
                        kept.push(vertices[i as usize]);
                        kept.len() as u32 - 1
                    })
                })
            })
            .collect();
        Self {
            vertices: kept,
            triangles,
        }
    }

    /// A rectangle of two triangles from its top-left and bottom-right corners.
    pub fn rectangle([top_left, bottom_right]: [Point; 2]) -> Self {
        let vertices = vec![
            Point::new(top_left.x, bottom_right.y),
            bottom_right,
            Point::new(bottom_right.x, top_left.y),
            top_left,
        ];
        Self::new(vertices, vec![[0, 1, 2], [0, 2, 3]])
    }

    /// Area of all triangles, in square pixels.
    pub fn area(&self) -> f64 {
        let double = |[a, b, c]: &[u32; 3]| {
            let [a, b, c] = [a, b, c].map(|&i| self.vertices[i as usize]);
            (b - a).perp_dot(c - a).abs()
        };
        self.triangles.iter().map(double).sum::<f64>() / 2.0
    }

    /// Whether a triangle holds `at`; its edges count as inside.
    pub fn contains(&self, at: Point) -> bool {
        self.triangles.iter().any(|corners| {
            let [a, b, c] = corners.map(|i| self.vertices[i as usize]);
            [(a, b), (b, c), (c, a)]
                .iter()
                .all(|&(p, q)| (q - p).perp_dot(at - p) <= 1e-9)
        })
    }
}

/// `planes` copies of `flat`, crossed about the trunk; one is a plain billboard. The sides of a card
/// follow one another, the front first.
pub fn crossed(sprite: &Sprite, flat: &Flat, planes: u32) -> ModelMesh {
    let mut mesh = ModelMesh::default();
    for plane in 0..planes {
        let share = f64::from(plane) / f64::from(planes);
        for side in [1.0, -1.0] {
            add_side(&mut mesh, sprite, flat, share, side);
        }
    }
    mesh
}

/// Adds one side of the card turned by `share` · 180°: `side` is 1 for the front, −1 for the back.
fn add_side(mesh: &mut ModelMesh, sprite: &Sprite, flat: &Flat, share: f64, side: f64) {
    let [top_left, bottom_right] = sprite.corners().map(|corner| sprite.metres(corner));
    let reach = top_left.x.abs().max(bottom_right.x.abs()).max(1e-9);
    let top = top_left.y.max(1e-9);
    let (sin, cos) = quarter_exact(share);
    let (out_x, out_z) = (side * sin, side * cos);
    let gap = SIDE_GAP * top;
    let length = (1.0 + LIFT * LIFT).sqrt();
    let normal = [out_x, LIFT, out_z].map(|v| (v / length) as f32);
    // Behind, the picture is mirrored, and so is the frame of its normal map.
    let tangent = [cos, 0.0, -sin, side].map(|v| v as f32);
    let first = mesh.positions.len() as u32;
    for &vertex in &flat.vertices {
        let at = sprite.metres(vertex);
        let uv = sprite.uv(vertex);
        let height = (at.y / top).clamp(0.0, 1.0);
        let position = [at.x * cos + gap * out_x, at.y, gap * out_z - at.x * sin];
        mesh.positions.push(position.map(|v| v as f32));
        mesh.normals.push(normal);
        mesh.tangents.push(tangent);
        mesh.uvs.push([uv.x as f32, uv.y as f32]);
        let edge = (at.x.abs() / reach).min(1.0);
        mesh.wind
            .push([edge, share, height * height].map(|v| v as f32));
    }
    for &[a, b, c] in &flat.triangles {
        let corners = if side > 0.0 { [a, b, c] } else { [a, c, b] };
        mesh.indices.extend(corners.map(|corner| first + corner));
    }
}

/// Sine and cosine of `share` · 180°, without rounding errors at 90°.
fn quarter_exact(share: f64) -> (f64, f64) {
    if share == 0.5 {
        return (1.0, 0.0);
    }
    let angle = share * std::f64::consts::PI;
    (libm::sin(angle), libm::cos(angle))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::SpriteSettings;
    use crate::raster::{Image, Straight};
    use glam::Vec3;

    #[test]
    fn crossed_cards_stand_on_the_ground_and_face_both_ways() {
        let image = Image::filled(20, 40, Straight([1, 2, 3, 255]));
        let foot = Point::new(9.5, 39.0);
        let sprite = Sprite::new(&image, foot, SpriteSettings::default()).unwrap();
        for planes in 1..=4 {
            let mesh = crossed(&sprite, &Flat::rectangle(sprite.corners()), planes);
            assert_eq!(mesh.positions.len(), 8 * planes as usize);
            let heights = mesh.positions.iter().map(|p| p[1]);
            assert_eq!(heights.clone().fold(f32::MAX, f32::min), 0.0);
            assert!((heights.fold(0.0, f32::max) - 10.0).abs() < 1e-5);
            let mut facing = Vec3::ZERO;
            for corners in mesh.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(mesh.positions[corners[i] as usize]));
                let face = (b - a).cross(c - a).normalize();
                facing += face;
                let normal = Vec3::from(mesh.normals[corners[0] as usize]);
                let wanted = (face + LIFT as f32 * Vec3::Y).normalize();
                assert!((normal - wanted).length() < 1e-6, "{face} {normal}");
                let [x, y, z, sign] = mesh.tangents[corners[0] as usize];
                let tangent = Vec3::new(x, y, z);
                assert!(tangent.dot(normal).abs() < 1e-6);
                // To the right of the picture is along the tangent, up is along the bitangent.
                let uv = |i: usize| mesh.uvs[corners[i] as usize];
                for (p, q, from, to) in [(a, b, uv(0), uv(1)), (b, c, uv(1), uv(2))] {
                    let along = (q - p).dot(tangent);
                    assert!(along * (to[0] - from[0]) >= 0.0);
                }
                assert!((normal.cross(tangent) * sign).y > 0.5);
            }
            assert!(facing.length() < 1e-5, "each side has another behind it");
            for (uv, position) in mesh.uvs.iter().zip(&mesh.positions) {
                assert_eq!(uv[1] > 0.5, position[1] < 5.0, "top is v = 0");
            }
        }
    }
}
