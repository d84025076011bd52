//! Cards: flat pieces of a sprite stood upright, alone or crossed about the trunk.
//!
//! Frame: glTF's. +Y up, metres, the foot at the origin, the first card in the plane z = 0 facing
//! +Z. Card i of n is turned by i · 180°/n about +Y. Normals are those of the cards; tangents point
//! along the picture's x, bitangents up, so a normal map with Y+ lies as it was painted.
//!
//! Wind weights follow Sousa (*Vegetation procedural animation and shading in Crysis*, GPU Gems 3,
//! ch. 16): red is how freely an edge flutters (0 at the trunk's axis, 1 at the outermost leaf),
//! green the phase (one value a card, so that crossed cards do not move as one), blue how far the
//! whole sways (0 at the foot, 1 at the top, growing with the square of the height).

use super::sprite::Sprite;
use crate::geometry::Point;

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

/// A mesh for an engine, one entry of each list a vertex.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CardMesh {
    /// In metres.
    pub positions: Vec<[f32; 3]>,
    /// Of unit length.
    pub normals: Vec<[f32; 3]>,
    /// Unit vector along the picture's x, and the sign of the bitangent; none where no normal map is
    /// used.
    pub tangents: Vec<[f32; 4]>,
    /// (0, 0) top left.
    pub uvs: Vec<[f32; 2]>,
    /// Edge flutter, phase, sway; each 0 … 1.
    pub wind: Vec<[f32; 3]>,
    /// Three a triangle, counter-clockwise as seen from the front.
    pub indices: Vec<u32>,
}

/// `planes` copies of `flat`, crossed about the trunk; one is a plain billboard.
pub fn crossed(sprite: &Sprite, flat: &Flat, planes: u32) -> CardMesh {
    let mut mesh = CardMesh::default();
    let [top_left, bottom_right] = sprite.corners().map(|corner| sprite.metres(corner));
    let reach = top_left.x.abs().max(bottom_right.x.abs()).max(1e-9);
    let top = top_left.y.max(1e-9);
    for plane in 0..planes {
        let share = f64::from(plane) / f64::from(planes);
        let (sin, cos) = quarter_exact(share);
        let first = mesh.positions.len() as u32;
        for &vertex in &flat.vertices {
            let at = sprite.metres(vertex);
            let uv = sprite.uv(vertex);
            let height = (at.y / top).clamp(0.0, 1.0);
            mesh.positions
                .push([at.x * cos, at.y, -at.x * sin].map(|v| v as f32));
            mesh.normals.push([sin, 0.0, cos].map(|v| v as f32));
            mesh.tangents.push([cos, 0.0, -sin, 1.0].map(|v| v as f32));
            mesh.uvs.push([uv.x as f32, uv.y as f32]);
            let edge = (at.x.abs() / reach).min(1.0);
            mesh.wind
                .push([edge, share, height * height].map(|v| v as f32));
        }
        let corners = flat.triangles.iter().flatten();
        mesh.indices.extend(corners.map(|corner| first + corner));
    }
    mesh
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
    fn crossed_cards_stand_on_the_ground_and_face_outwards() {
        let image = Image::filled(20, 40, Straight([1, 2, 3, 255]));
        let foot = Point::new(9.5, 39.0);
        let sprite = Sprite::new(&image, foot, SpriteSettings::default()).unwrap();
        for planes in 1..=4 {
            let mesh = crossed(&sprite, &Flat::rectangle(sprite.corners()), planes);
            assert_eq!(mesh.positions.len(), 4 * planes as usize);
            let heights = mesh.positions.iter().map(|p| p[1]);
            assert_eq!(heights.clone().fold(f32::MAX, f32::min), 0.0);
            assert!((heights.fold(0.0, f32::max) - 10.0).abs() < 1e-5);
            for corners in mesh.indices.chunks(3) {
                let [a, b, c] = [0, 1, 2].map(|i| Vec3::from(mesh.positions[corners[i] as usize]));
                let face = (b - a).cross(c - a).normalize();
                let normal = Vec3::from(mesh.normals[corners[0] as usize]);
                assert!(face.dot(normal) > 0.999, "{face} {normal}");
                let tangent = mesh.tangents[corners[0] as usize];
                let bitangent = normal.cross(Vec3::new(tangent[0], tangent[1], tangent[2]));
                assert!((bitangent * tangent[3] - Vec3::Y).length() < 1e-6);
            }
            for (uv, position) in mesh.uvs.iter().zip(&mesh.positions) {
                assert_eq!(uv[1] > 0.5, position[1] < 5.0, "top is v = 0");
            }
        }
    }
}
