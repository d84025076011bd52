//! Triangles: `shaders/mesh.wgsl` on the processor, with what a card does before it: triangles that
//! reach behind the near plane are cut off there (Sutherland & Hodgman, *Reentrant Polygon
//! Clipping*, 1974).

use super::Band;
use super::shade::{Place, shaded};
use crate::render::frame::Frame;
use crate::render::mesh::{MeshVertex, PreparedMesh};
use glam::Vec3;

/// What of a triangle lies before the near plane, or a half of it.
struct Piece {
    corners: [MeshVertex; 3],
    /// Whether the edge opposite to each corner is one of the triangle's own.
    own_edges: [bool; 3],
}

/// A triangle on the screen.
struct Projected {
    /// Places of the corners, samples; and 1 / distance of each.
    x: [f32; 3],
    y: [f32; 3],
    near: [f32; 3],
    /// 1 / (twice its area).
    per_area: f32,
}

/// Half the width of the lines of a wireframe, samples.
const LINE: f32 = 0.7;

/// Draws a mesh into a band.
pub(super) fn draw(frame: &Frame, mesh: &PreparedMesh, band: &mut Band<'_>) {
    for corners in mesh.corners.as_chunks::<3>().0 {
        let away = corners.map(|corner| distance(frame, &corner));
        if away.iter().all(|&away| away >= frame.near) {
            let whole = Piece {
                corners: *corners,
                own_edges: [true; 3],
            };
            fill_piece(frame, &whole, band);
        } else if away.iter().any(|&away| away > frame.near) {
            for piece in before_eye(corners, away, frame.near).iter().flatten() {
                fill_piece(frame, piece, band);
            }
        }
    }
}

fn fill_piece(frame: &Frame, piece: &Piece, band: &mut Band<'_>) {
    if let Some(triangle) = projected(frame, &piece.corners) {
        fill(frame, piece, &triangle, band);
    }
}

/// How far a corner lies before the plane of the eye.
fn distance(frame: &Frame, corner: &MeshVertex) -> f32 {
    let seen = Vec3::from(corner.position) - Vec3::from(frame.eye);
    seen.dot(Vec3::from(frame.forward))
}

/// The one or two triangles that make up what lies `near` or further of a triangle whose corners
/// are so far `away`.
fn before_eye(corners: &[MeshVertex; 3], away: [f32; 3], near: f32) -> [Option<Piece>; 2] {
    // At most four corners, each with whether the edge that leaves it is one of the triangle's own.
    let mut polygon = [(corners[0], false); 4];
    let mut count = 0;
    let mut push = |corner, own| {
        polygon[count.min(3)] = (corner, own);
        count += 1;
    };
    for i in 0..3 {
        let j = (i + 1) % 3;
        let (begins, ends) = (away[i] >= near, away[j] >= near);
        if begins {
            push(corners[i], true);
        }
        if begins != ends {
            let share = (near - away[i]) / (away[j] - away[i]);
            push(between(&corners[i], &corners[j], share), ends);
        }
    }
    let at = |i: usize| polygon[i].0;
    let own = |i: usize| polygon[i].1;
    let first = (count >= 3).then(|| Piece {
        corners: [at(0), at(1), at(2)],
        own_edges: [own(1), count == 3 && own(2), own(0)],
    });
    let second = (count == 4).then(|| Piece {
        corners: [at(0), at(2), at(3)],
        own_edges: [own(2), own(3), false],
    });
    [first, second]
}

/// The place at a share of the way from one corner to another, with all it has.
fn between(one: &MeshVertex, other: &MeshVertex, share: f32) -> MeshVertex {
    let mixed = |a: f32, b: f32| a + (b - a) * share;
    let mixed_three = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|i| mixed(a[i], b[i]));
    MeshVertex {
        position: mixed_three(one.position, other.position),
        open: mixed(one.open, other.open),
        normal: mixed_three(one.normal, other.normal),
        sunlit: mixed(one.sunlit, other.sunlit),
        color: mixed_three(one.color, other.color),
        padding: 0.0,
    }
}

fn projected(frame: &Frame, corners: &[MeshVertex; 3]) -> Option<Projected> {
    let (mut x, mut y, mut near) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for (i, corner) in corners.iter().enumerate() {
        let seen = Vec3::from(corner.position) - Vec3::from(frame.eye);
        // A corner that was cut off lies on the near plane but for rounding.
        let away = seen.dot(Vec3::from(frame.forward)).max(0.999 * frame.near);
        let across = seen.dot(Vec3::from(frame.right)) / (away * frame.tan_x);
        let upward = seen.dot(Vec3::from(frame.up)) / (away * frame.tan_y);
        x[i] = (across + 1.0) * 0.5 * frame.size[0];
        y[i] = (1.0 - upward) * 0.5 * frame.size[1];
        near[i] = 1.0 / away;
    }
    let area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
    (area != 0.0).then(|| Projected {
        x,
        y,
        near,
        per_area: 1.0 / area,
    })
}

fn fill(frame: &Frame, piece: &Piece, triangle: &Projected, band: &mut Band<'_>) {
    let range = |values: &[f32; 3], low: u32, high: u32| {
        let least = values.iter().copied().fold(f32::INFINITY, f32::min);
        let most = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        let first = least.clamp(low as f32, high as f32) as u32;
        first..((most + 1.0).clamp(low as f32, high as f32) as u32)
    };
    let columns = range(&triangle.x, 0, band.width);
    for row in range(&triangle.y, band.rows.0, band.rows.1) {
        for column in columns.clone() {
            let Some(flat) = triangle.shares(column as f32 + 0.5, row as f32 + 0.5) else {
                continue;
            };
            let near: f32 = (0..3).map(|i| flat[i] * triangle.near[i]).sum();
            let depth = frame.near * near;
            if !band.shows(column, row, depth) {
                continue;
            }
            let shares = std::array::from_fn(|i| flat[i] * triangle.near[i] / near);
            let edge = triangle.edge_distance(flat, piece.own_edges);
            let light = seen(frame, &piece.corners, shares, edge, 1.0 / near);
            band.put(column, row, depth, [light.x, light.y, light.z, 1.0]);
        }
    }
}

impl Projected {
    /// The shares of the corners at a place of the screen; `None` outside.
    fn shares(&self, x: f32, y: f32) -> Option<[f32; 3]> {
        let part = |i: usize, j: usize| {
            let (dx, dy) = (self.x[j] - self.x[i], self.y[j] - self.y[i]);
            (dx * (y - self.y[i]) - dy * (x - self.x[i])) * self.per_area
        };
        let shares = [part(1, 2), part(2, 0), part(0, 1)];
        shares.iter().all(|&share| share >= 0.0).then_some(shares)
    }

    /// Distance to the nearest edge that counts, samples.
    fn edge_distance(&self, shares: [f32; 3], counts: [bool; 3]) -> f32 {
        let distance = |i: usize| {
            if !counts[i] {
                return f32::INFINITY;
            }
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            let (dx, dy) = (self.x[k] - self.x[j], self.y[k] - self.y[j]);
            (shares[i] / self.per_area).abs() / (dx * dx + dy * dy).sqrt().max(1e-6)
        };
        distance(0).min(distance(1)).min(distance(2))
    }
}

fn seen(frame: &Frame, corners: &[MeshVertex; 3], shares: [f32; 3], edge: f32, away: f32) -> Vec3 {
    let mixed = |value: fn(&MeshVertex) -> Vec3| -> Vec3 {
        value(&corners[0]) * shares[0]
            + value(&corners[1]) * shares[1]
            + value(&corners[2]) * shares[2]
    };
    let normal = mixed(|corner| Vec3::from(corner.normal));
    let normal = normal * (1.0 / normal.dot(normal).sqrt().max(1e-12));
    let albedo = mixed(|corner| Vec3::from(corner.color));
    match frame.view {
        1 | 4 => return Vec3::ZERO,
        2 => return normal * 0.5 + Vec3::splat(0.5),
        3 => return Vec3::splat(1.0 / (1.0 + away)),
        5 if edge < LINE => return Vec3::ZERO,
        _ => {}
    }
    let light = mixed(|corner| Vec3::new(corner.open, corner.sunlit, 0.0));
    let shaded = shaded(
        frame,
        &Place {
            albedo,
            normal,
            open: light.x,
            sunlit: light.y,
            height: light.x,
            depth: 1.0,
            ray: Vec3::ZERO,
            thin: 0.0,
        },
    );
    if frame.view == 5 {
        shaded.min(Vec3::ONE)
    } else {
        shaded
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;

    /// Corners at these distances, each with its colour as red, green or blue.
    fn triangle() -> [MeshVertex; 3] {
        std::array::from_fn(|i| {
            let mut corner = MeshVertex::zeroed();
            corner.color[i] = 1.0;
            corner
        })
    }

    #[test]
    fn what_lies_before_the_eye_is_a_triangle_or_two() {
        let pieces = before_eye(&triangle(), [3.0, -1.0, -1.0], 1.0);
        let [Some(tip), None] = pieces else {
            panic!("one corner leaves one triangle");
        };
        assert_eq!(tip.corners[1].color, [0.5, 0.5, 0.0]);
        assert_eq!(tip.corners[2].color, [0.5, 0.0, 0.5]);
        // The edge between the two cuts is none of its own.
        assert_eq!(tip.own_edges, [false, true, true]);
        let [Some(one), Some(other)] = before_eye(&triangle(), [3.0, 3.0, -1.0], 1.0) else {
            panic!("two corners leave two triangles");
        };
        assert_eq!(one.corners[2].color, [0.0, 0.5, 0.5]);
        assert_eq!(one.own_edges, [true, false, true]);
        assert_eq!(other.corners[2].color, [0.5, 0.0, 0.5]);
        assert_eq!(other.own_edges, [false, true, false]);
    }

    #[test]
    fn nothing_is_left_of_a_triangle_behind_the_eye() {
        let pieces = before_eye(&triangle(), [0.5, -1.0, 0.0], 1.0);
        assert!(pieces.iter().all(Option::is_none));
    }
}
