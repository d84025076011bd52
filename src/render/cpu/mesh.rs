//! Triangles: `shaders/mesh.wgsl` on the processor.
//!
//! Limit: a triangle that reaches behind the near plane is not drawn at all.

use super::Band;
use super::shade::{Place, shaded};
use crate::render::frame::Frame;
use crate::render::mesh::{MeshVertex, PreparedMesh};
use glam::Vec3;

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
        if let Some(triangle) = projected(frame, corners) {
            fill(frame, corners, &triangle, band);
        }
    }
}

fn projected(frame: &Frame, corners: &[MeshVertex; 3]) -> Option<Projected> {
    let (mut x, mut y, mut near) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    for (i, corner) in corners.iter().enumerate() {
        let seen = Vec3::from(corner.position) - Vec3::from(frame.eye);
        let away = seen.dot(Vec3::from(frame.forward));
        if away < frame.near {
            return None;
        }
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

fn fill(frame: &Frame, corners: &[MeshVertex; 3], triangle: &Projected, band: &mut Band<'_>) {
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
            let edge = triangle.edge_distance(flat);
            let light = seen(frame, corners, shares, edge, 1.0 / near);
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

    /// Distance to the nearest edge, samples.
    fn edge_distance(&self, shares: [f32; 3]) -> f32 {
        let distance = |i: usize| {
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
        },
    );
    if frame.view == 5 {
        shaded.min(Vec3::ONE)
    } else {
        shaded
    }
}
