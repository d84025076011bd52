//! The least map above another that is nowhere steeper than allowed: a height field's gaps filled as
//! if cones stood on their walls.
//!
//! Source: P. Felzenszwalb, D. Huttenlocher, *Distance Transforms of Sampled Functions*, 2012 (the
//! lower envelope of cones; here upside down), computed by sweeps over the eight neighbours:
//! cones are octagons, up to 8 % too narrow between their corners.
//!
//! A sweep is one long chain, each texel waiting for the one before. All six faces fall alike, so they
//! are swept together, one in each lane of a vector.

use super::cube_grid::folded;
use super::{CubeFace, Cubemap, Image};
use glam::{BVec4A, Vec4};

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
    CubeCones::new(map.size(), steepest).above(map)
}

/// Cones of one steepness over cubemaps of one size, for more than one map.
pub struct CubeCones {
    falls: Vec<Vec4>,
    borders: Vec<Link>,
    size: usize,
}

impl CubeCones {
    /// Cones that fall by `steepest` for each radian.
    pub fn new(size: u32, steepest: f32) -> Self {
        Self {
            falls: falls(size, steepest),
            borders: borders(size),
            size: size as usize,
        }
    }

    /// See [`cube_upper_envelope`].
    ///
    /// # Panics
    /// When `map` has another size.
    pub fn above(&self, map: &Cubemap<f32>) -> Cubemap<f32> {
        assert_eq!(map.size() as usize, self.size, "cones of the map's size");
        let mut faces = Faces::of(map);
        for _ in 0..MOST_ROUNDS {
            faces.take_borders(&self.borders);
            let rose_down = faces.swept_down(&self.falls);
            let rose_up = faces.swept_up(&self.falls);
            if !(rose_down || rose_up) {
                break;
            }
        }
        faces.cubemap()
    }
}

/// How far a value may fall from each texel to its neighbours, the same on every face: to the left or
/// right; up or down; to the corner where both coordinates grow, or both fall; to the corner where one
/// grows and the other falls.
fn falls(size: u32, steepest: f32) -> Vec<Vec4> {
    // The angle that a step makes at (u, v) of a face at distance 1: off the middle the texels are
    // sheared, so that the two diagonals differ.
    let steps = [
        Vec4::new(1.0, 0.0, 1.0, 1.0),
        Vec4::new(0.0, 1.0, 1.0, -1.0),
    ];
    let width = 2.0 / size as f32;
    let place = |i: u32| (i as f32 + 0.5) * width - 1.0;
    let texels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
    let fall = |(x, y)| {
        let (u, v) = (place(x), place(y));
        let [du, dv] = steps;
        let square = 1.0 + u * u + v * v;
        let turn = u * dv - v * du;
        let angle = (du * du + dv * dv + turn * turn).sqrt() / square;
        steepest * width * angle
    };
    texels.map(fall).collect()
}

/// A texel of a border and the texel of another face that lies there: place and lane of each.
struct Link {
    to: usize,
    to_lane: usize,
    from: usize,
    from_lane: usize,
}

/// The borders of all faces but their corners.
fn borders(size: u32) -> Vec<Link> {
    let (end, side) = (i64::from(size), size as usize + 2);
    let place = |x: i64, y: i64| (y + 1) as usize * side + (x + 1) as usize;
    let mut links = Vec::with_capacity(24 * size as usize);
    for face in CubeFace::ALL {
        for i in 0..end {
            for (x, y) in [(-1, i), (end, i), (i, -1), (i, end)] {
                let (there, from_x, from_y) = folded(face, x, y, size);
                links.push(Link {
                    to: place(x, y),
                    to_lane: face as usize,
                    from: place(i64::from(from_x), i64::from(from_y)),
                    from_lane: there as usize,
                });
            }
        }
    }
    links
}

/// The texels of all faces at one place: six, and two that nobody reads.
type Texels = [Vec4; 2];

fn lane(texels: &mut Texels, lane: usize) -> &mut f32 {
    &mut texels[lane / 4][lane % 4]
}

/// All faces with a border of one texel, beside one another in each place.
struct Faces {
    /// Texels along a side, with the border.
    side: usize,
    texels: Vec<Texels>,
}

impl Faces {
    fn of(map: &Cubemap<f32>) -> Self {
        let side = map.size() as usize + 2;
        let mut texels = vec![[Vec4::ZERO; 2]; side * side];
        for y in 0..map.size() {
            let rows = CubeFace::ALL.map(|face| map.face(face).row(y));
            let start = (y as usize + 1) * side + 1;
            for (x, place) in texels[start..start + side - 2].iter_mut().enumerate() {
                let [a, b, c, d, e, f] = rows.map(|row| row[x]);
                *place = [Vec4::new(a, b, c, d), Vec4::new(e, f, 0.0, 0.0)];
            }
        }
        Self { side, texels }
    }

    fn cubemap(&self) -> Cubemap<f32> {
        let size = (self.side - 2) as u32;
        let face = |lane: usize| {
            let rows = (1..=size as usize).map(|y| &self.texels[y * self.side + 1..]);
            let texels = rows.flat_map(|row| &row[..size as usize]);
            let pixels = texels.map(|place| place[lane / 4][lane % 4]);
            Image::from_pixels(size, size, pixels.collect())
        };
        Cubemap::from_faces(std::array::from_fn(face))
    }

    /// Fills the borders from the neighbouring faces; the four corners, which do not exist, are the
    /// means of the texels on both their sides.
    fn take_borders(&mut self, links: &[Link]) {
        for link in links {
            let texel = *lane(&mut self.texels[link.from], link.from_lane);
            *lane(&mut self.texels[link.to], link.to_lane) = texel;
        }
        let (side, last) = (self.side, self.side - 1);
        for (x, beside_x) in [(0, 1), (last, last - 1)] {
            for (y, beside_y) in [(0, 1), (last, last - 1)] {
                let [across, along] = [y * side + beside_x, beside_y * side + x];
                let mean =
                    |half: usize| 0.5 * (self.texels[across][half] + self.texels[along][half]);
                self.texels[y * side + x] = [mean(0), mean(1)];
            }
        }
    }

    /// One sweep from the top left; whether anything rose.
    fn swept_down(&mut self, falls: &[Vec4]) -> bool {
        let (side, size) = (self.side, self.side - 2);
        let mut rose = [BVec4A::FALSE; 2];
        for y in 0..size {
            let (above, here) = self.texels[y * side..].split_at_mut(side);
            let here = &mut here[..side];
            let mut before = here[0];
            for (x, fall) in falls[y * size..][..size].iter().enumerate() {
                let [across, along, down, up] = fall.to_array();
                for half in 0..2 {
                    let reached = (above[x + 1][half] - along)
                        .max(above[x][half] - down)
                        .max(above[x + 2][half] - up)
                        .max(before[half] - across);
                    let texel = here[x + 1][half];
                    rose[half] |= reached.cmpgt(texel);
                    before[half] = reached.max(texel);
                }
                here[x + 1] = before;
            }
        }
        rose.iter().any(|rose| rose.any())
    }

    /// One sweep back from the bottom right.
    fn swept_up(&mut self, falls: &[Vec4]) -> bool {
        let (side, size) = (self.side, self.side - 2);
        let mut rose = [BVec4A::FALSE; 2];
        for y in (0..size).rev() {
            let (here, below) = self.texels[(y + 1) * side..].split_at_mut(side);
            let mut before = here[side - 1];
            for (x, fall) in falls[y * size..][..size].iter().enumerate().rev() {
                let [across, along, down, up] = fall.to_array();
                for half in 0..2 {
                    let reached = (below[x + 1][half] - along)
                        .max(below[x][half] - up)
                        .max(below[x + 2][half] - down)
                        .max(before[half] - across);
                    let texel = here[x + 1][half];
                    rose[half] |= reached.cmpgt(texel);
                    before[half] = reached.max(texel);
                }
                here[x + 1] = before;
            }
        }
        rose.iter().any(|rose| rose.any())
    }
}

#[cfg(test)]
mod tests {
    use super::super::cube_grid::framed;
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

    /// One face and one texel at a time.
    fn reference(map: &Cubemap<f32>, steepest: f32) -> Cubemap<f32> {
        let size = map.size();
        let falls = falls(size, steepest);
        let fall = |x: u32, y: u32| falls[(y * size + x) as usize].to_array();
        let swept = |mut frame: Image<f32>| {
            for y in 0..size {
                for x in 0..size {
                    let [across, along, down, up] = fall(x, y);
                    let reached = (frame.at(x + 1, y) - along)
                        .max(frame.at(x, y) - down)
                        .max(frame.at(x + 2, y) - up)
                        .max(frame.at(x, y + 1) - across);
                    frame.set(x + 1, y + 1, frame.at(x + 1, y + 1).max(reached));
                }
            }
            for y in (0..size).rev() {
                for x in (0..size).rev() {
                    let [across, along, down, up] = fall(x, y);
                    let reached = (frame.at(x + 1, y + 2) - along)
                        .max(frame.at(x, y + 2) - up)
                        .max(frame.at(x + 2, y + 2) - down)
                        .max(frame.at(x + 2, y + 1) - across);
                    frame.set(x + 1, y + 1, frame.at(x + 1, y + 1).max(reached));
                }
            }
            frame.cropped(1, 1, size, size)
        };
        let mut map = map.clone();
        for _ in 0..MOST_ROUNDS {
            map = Cubemap::from_faces(CubeFace::ALL.map(|face| swept(framed(&map, face))));
        }
        map
    }

    #[test]
    fn all_faces_at_once_are_each_by_itself() {
        let mut random = crate::base::Seed(11).random();
        for size in [1, 5, 16, 48] {
            let rough = Cubemap::from_directions(size, |_| random.between(-1.0, 1.0) as f32);
            for steepest in [0.2, 2.0, 20.0] {
                let all = cube_upper_envelope(&rough, steepest);
                assert_eq!(all, reference(&rough, steepest), "{size} {steepest}");
            }
        }
    }
}
