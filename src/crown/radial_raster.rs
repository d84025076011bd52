//! One face of a radius cubemap: for every texel the farthest point of a mesh along the ray through
//! the texel's centre.
//!
//! Rays of a cube's face are (u, v, 1) in the frame of the face, so the three determinants that tell
//! on which side of a triangle's edges a ray passes are linear in u and v: triangles are filled
//! like on a screen, without clipping those that reach behind the centre.
//!
//! This work is based on: M. Olano, T. Greer, *Triangle scan conversion using 2D homogeneous
//! coordinates*, 1997.
//!
//! Neighbouring triangles compute the determinant of their common edge with exactly opposite signs,
//! and rays on an edge count as hits: a closed surface leaves no pinhole.

use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Image};
use glam::DVec3;

/// The farthest distance from the origin to the triangles of `corners` along the ray of each texel;
/// 0 where a ray meets none.
pub(super) fn farthest(
    corners: &[DVec3],
    triangles: &[[u32; 3]],
    face: CubeFace,
    size: u32,
    cancel: &Cancel,
) -> Result<Image<f32>, Cancelled> {
    /// Triangles between two looks at the cancellation: about a millisecond.
    const STRIDE: usize = 8192;
    let [right, down, out] = face.axes();
    let framed: Vec<Corner> = corners
        .iter()
        .map(|&p| Corner::new(DVec3::new(p.dot(right), p.dot(down), p.dot(out))))
        .collect();
    let mut image = Image::filled(size, size, 0.0);
    for batch in triangles.chunks(STRIDE) {
        cancel.check()?;
        for triangle in batch {
            fill(&mut image, triangle.map(|i| &framed[i as usize]));
        }
    }
    Ok(image)
}

/// A vertex in the frame of a face.
struct Corner {
    point: DVec3,
    /// Where its ray goes through the face's plane; without meaning behind the centre.
    place: [f64; 2],
    length_squared: f64,
    /// Which of the four planes of the face's pyramid it lies outside of.
    outside: u8,
}

impl Corner {
    fn new(point: DVec3) -> Self {
        let DVec3 { x, y, z } = point;
        let bits = [x > z, -x > z, y > z, -y > z];
        let outside = bits.iter().fold(0, |code, &bit| code << 1 | u8::from(bit));
        let place = if z > 0.0 { [x / z, y / z] } else { [0.0; 2] };
        Self {
            point,
            place,
            length_squared: point.length_squared(),
            outside,
        }
    }
}

fn fill(image: &mut Image<f32>, corners: [&Corner; 3]) {
    if corners[0].outside & corners[1].outside & corners[2].outside != 0 {
        return;
    }
    let Some([left, right, top, bottom]) = texel_bounds(corners, image.width()) else {
        return;
    };
    let points = corners.map(|corner| corner.point);
    let [a, b, c] = points;
    let normals = [b.cross(c), c.cross(a), a.cross(b)];
    let volume = a.dot(normals[0]);
    if volume == 0.0 {
        // Seen from its edge: its neighbours have the same points.
        return;
    }
    let normals = normals.map(|normal| normal * volume.signum());
    let volume = volume.abs();
    // No point of a triangle is farther than its corners; rounding might say otherwise.
    let longest = corners.iter().map(|corner| corner.length_squared);
    let longest = longest.fold(0.0, f64::max).sqrt();
    let size = f64::from(image.width());
    let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / size - 1.0;
    for y in top..=bottom {
        let v = centre(y);
        let offsets = normals.map(|normal| normal.y * v + normal.z);
        let row = &mut image.row_mut(y)[left as usize..=right as usize];
        for (x, texel) in (left..).zip(row) {
            let u = centre(x);
            let sides = [0, 1, 2].map(|i| normals[i].x * u + offsets[i]);
            // In this order a triangle and its mirror image have one sum.
            let sum = sides[0] + (sides[1] + sides[2]);
            if sides.iter().all(|&side| side >= 0.0) && sum > 0.0 {
                let ray = (u * u + v * v + 1.0).sqrt();
                let distance = (volume / sum * ray).min(longest);
                *texel = texel.max(distance as f32);
            }
        }
    }
}

/// First and last column and row of the texels whose rays a triangle may meet.
fn texel_bounds(corners: [&Corner; 3], size: u32) -> Option<[u32; 4]> {
    if corners.iter().all(|corner| corner.point.z > 0.0) {
        return bounds_of(corners.iter().map(|corner| corner.place), size);
    }
    let polygon = clipped(&corners.map(|corner| corner.point));
    // At the centre itself every direction is possible.
    let has_centre = polygon.iter().any(|point| point.z <= 0.0);
    let ends = [[-1.0; 2], [1.0; 2]].into_iter().filter(|_| has_centre);
    let places = polygon.iter().filter(|point| point.z > 0.0);
    let places = places.map(|point| [point.x / point.z, point.y / point.z]);
    bounds_of(places.chain(ends), size)
}

/// The texels around `places`, −1 … 1 from left and top.
fn bounds_of(places: impl Iterator<Item = [f64; 2]>, size: u32) -> Option<[u32; 4]> {
    /// Texels by which a bound may be off through rounding.
    const MARGIN: f64 = 1e-6;
    let (mut low, mut high) = ([1.0f64; 2], [-1.0f64; 2]);
    for place in places {
        for i in 0..2 {
            low[i] = low[i].min(place[i].max(-1.0));
            high[i] = high[i].max(place[i].min(1.0));
        }
    }
    let n = f64::from(size);
    let texel = |u: f64| ((u + 1.0) * n - 1.0) / 2.0;
    let first = low.map(|u| (texel(u) - MARGIN).ceil().max(0.0));
    let last = high.map(|u| (texel(u) + MARGIN).floor().min(n - 1.0));
    let any = first[0] <= last[0] && first[1] <= last[1];
    any.then(|| [first[0], last[0], first[1], last[1]].map(|texel| texel as u32))
}

/// The part of a triangle within the face's pyramid (Sutherland & Hodgman): at most seven corners.
fn clipped(points: &[DVec3; 3]) -> Vec<DVec3> {
    let planes: [fn(&DVec3) -> f64; 4] =
        [|p| p.z - p.x, |p| p.z + p.x, |p| p.z - p.y, |p| p.z + p.y];
    planes.iter().fold(points.to_vec(), |polygon, depth| {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        for (i, point) in polygon.iter().enumerate() {
            let next = &polygon[(i + 1) % polygon.len()];
            let (here, there) = (depth(point), depth(next));
            if here >= 0.0 {
                kept.push(*point);
            }
            if (here >= 0.0) != (there >= 0.0) {
                kept.push(*point + (*next - *point) * (here / (here - there)));
            }
        }
        kept
    })
}
