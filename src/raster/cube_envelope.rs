//! The least map above another that is nowhere steeper than allowed: a height field's gaps filled as
//! if cones stood on their walls.
//!
//! Source: P. Felzenszwalb, D. Huttenlocher, *Distance Transforms of Sampled Functions*, 2012 (the
//! lower envelope of cones; here upside down), computed by sweeps over the eight neighbours:
//! cones are octagons, up to 8 % too narrow between their corners.

use super::cube_grid::framed;
use super::{CubeFace, Cubemap, Image};
use rayon::prelude::*;

/// Rounds of sweeps at most. One carries a cone over a whole face; some more carry it round the
/// cube. Beyond there is nothing left to carry unless cones reach over more than half the cube.
const MOST_ROUNDS: usize = 8;

/// The least map that is nowhere below `map` and changes by at most `steepest` for each radian
/// between directions.
///
/// Peaks keep their height, walls lean, gaps too narrow for leaning walls become shallow.
///
/// ```
/// use boscage::raster::{CubeFace, Cubemap, cube_upper_envelope};
/// let mut map = Cubemap::filled(16, 0.0);
/// map.face_mut(CubeFace::PosZ).set(8, 8, 1.0);
/// let cone = cube_upper_envelope(&map, 2.0);
/// assert_eq!(cone.face(CubeFace::PosZ).at(8, 8), 1.0);
/// // A texel in the middle of a face is 2/16 radians wide.
/// assert!((cone.face(CubeFace::PosZ).at(9, 8) - 0.75).abs() < 0.01);
/// assert_eq!(cone.face(CubeFace::NegZ).at(8, 8), 0.0);
/// ```
pub fn cube_upper_envelope(map: &Cubemap<f32>, steepest: f32) -> Cubemap<f32> {
    let falls = Falls::new(map.size(), steepest);
    let mut map = map.clone();
    for _ in 0..MOST_ROUNDS {
        let faces: Vec<Image<f32>> = CubeFace::ALL
            .into_par_iter()
            .map(|face| swept(framed(&map, face), &falls))
            .collect();
        let next = Cubemap::from_faces(faces.try_into().expect("a cube has six faces"));
        if next == map {
            break;
        }
        map = next;
    }
    map
}

/// How far a value may fall from a texel to its neighbours; the same on every face.
struct Falls {
    /// To the left or right.
    across: Image<f32>,
    /// Up or down.
    along: Image<f32>,
    /// To the corner where both coordinates grow, or both fall.
    down: Image<f32>,
    /// To the corner where one grows and the other falls.
    up: Image<f32>,
}

impl Falls {
    fn new(size: u32, steepest: f32) -> Self {
        let width = 2.0 / size as f32;
        let place = |i: u32| (i as f32 + 0.5) * width - 1.0;
        let each = |fall: &dyn Fn(f32, f32) -> f32| {
            let texels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
            let falls = texels.map(|(x, y)| steepest * width * fall(place(x), place(y)));
            Image::from_pixels(size, size, falls.collect())
        };
        // The angle that a step (du, dv) makes at (u, v) of a face at distance 1: off the middle the
        // texels are sheared, so that the two diagonals differ.
        let angle = |u: f32, v: f32, du: f32, dv: f32| {
            let square = 1.0 + u * u + v * v;
            let turn = u * dv - v * du;
            (du * du + dv * dv + turn * turn).sqrt() / square
        };
        Self {
            across: each(&|u, v| angle(u, v, 1.0, 0.0)),
            along: each(&|u, v| angle(u, v, 0.0, 1.0)),
            down: each(&|u, v| angle(u, v, 1.0, 1.0)),
            up: each(&|u, v| angle(u, v, 1.0, -1.0)),
        }
    }

    #[inline]
    fn of(&self, x: u32, y: u32) -> [f32; 4] {
        [&self.across, &self.along, &self.down, &self.up].map(|image| image.at(x, y))
    }
}

/// The face within `frame`, raised by one sweep from the top left and one back.
fn swept(mut frame: Image<f32>, falls: &Falls) -> Image<f32> {
    let size = frame.width() - 2;
    for y in 0..size {
        for x in 0..size {
            let [across, along, down, up] = falls.of(x, y);
            let above = frame.row(y);
            let at = x as usize;
            let reached = (above[at + 1] - along)
                .max(above[at] - down)
                .max(above[at + 2] - up)
                .max(frame.row(y + 1)[at] - across);
            let texel = &mut frame.row_mut(y + 1)[at + 1];
            *texel = texel.max(reached);
        }
    }
    for y in (0..size).rev() {
        for x in (0..size).rev() {
            let [across, along, down, up] = falls.of(x, y);
            let below = frame.row(y + 2);
            let at = x as usize;
            let reached = (below[at + 1] - along)
                .max(below[at] - up)
                .max(below[at + 2] - down)
                .max(frame.row(y + 1)[at + 2] - across);
            let texel = &mut frame.row_mut(y + 1)[at + 1];
            *texel = texel.max(reached);
        }
    }
    frame.cropped(1, 1, size, size)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn a_cone_on_an_edge_goes_on_over_it_and_is_round() {
        let mut map = Cubemap::filled(64, 0.0f32);
        let top = CubeFace::PosZ.direction(0.98, 0.3);
        map.face_mut(CubeFace::PosZ).set(63, 41, 1.0);
        let cone = cube_upper_envelope(&map, 2.0);
        let exact = Cubemap::from_directions(64, |d| {
            let angle = d.normalize().angle_between(top.normalize());
            (1.0 - 2.0 * angle as f32).max(0.0)
        });
        for (cone, exact) in cone.faces().iter().zip(exact.faces()) {
            for (cone, exact) in cone.pixels().iter().zip(exact.pixels()) {
                assert!((cone - exact).abs() < 0.12, "{cone} for {exact}");
            }
        }
    }

    #[test]
    fn nothing_falls_and_what_is_gentle_stays() {
        let gentle = Cubemap::from_directions(32, |d: DVec3| (d.normalize().x * 0.4) as f32);
        assert_eq!(cube_upper_envelope(&gentle, 0.5), gentle);
        let rough = Cubemap::from_directions(32, |d| libm::sin(90.0 * d.x + 70.0 * d.y) as f32);
        let raised = cube_upper_envelope(&rough, 1.0);
        let pairs = raised.faces().iter().zip(rough.faces());
        for (raised, rough) in pairs {
            assert!(
                raised
                    .pixels()
                    .iter()
                    .zip(rough.pixels())
                    .all(|(a, b)| a >= b)
            );
        }
    }
}
