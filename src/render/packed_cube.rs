//! Cubemaps as both renderers read them: every level of detail of a face in one rectangle, each
//! with a border of texels from its neighbours.
//!
//! With the border a bilinear sample needs no other face, so that the same four reads and the same
//! arithmetic serve on a graphics card and on the processor, and no step shows at the cube's edges.
//! Hardware cubemaps filter in 8 bits of weight, and not at all for 32-bit floats.
//!
//! Level 0 of size N stands at the left, N + 2 texels a side; the levels of N/2, N/4, … stand in a
//! column to the right of it, which is never longer.

use crate::raster::{CubeFace, Cubemap};
use glam::Vec3;

/// Texels around each level.
const BORDER: u32 = 1;

/// Least size of a level.
const LEAST: u32 = 8;

/// Six faces, each with its levels of detail in one rectangle.
#[derive(Debug, Clone, PartialEq)]
pub struct PackedCube<T> {
    size: u32,
    levels: u32,
    texels: Vec<T>,
}

/// Where a level begins in the rectangle of a face of size `size`: its border's corner.
fn corner(size: u32, level: u32) -> (u32, u32) {
    if level == 0 {
        return (0, 0);
    }
    let above = size - (size >> (level - 1)) + 2 * BORDER * (level - 1);
    (size + 2 * BORDER, above)
}

impl<T: Copy + Default> PackedCube<T> {
    /// Packs `base` and the levels that `coarser` makes of it, each the half of the one before.
    ///
    /// Levels go on while the size is even and not below 16; a size of 2ⁿ gives n − 2 of them.
    pub fn new<S: Copy>(
        base: Cubemap<S>,
        coarser: impl Fn([S; 4]) -> S,
        packed: impl Fn(S) -> T,
    ) -> Self {
        let size = base.size();
        let (width, height) = rectangle(size);
        let mut cube = Self {
            size,
            levels: 0,
            texels: vec![T::default(); (6 * width * height) as usize],
        };
        let mut level = base;
        loop {
            cube.put(&level, &packed);
            cube.levels += 1;
            if level.size() % 2 == 1 || level.size() / 2 < LEAST {
                return cube;
            }
            level = halved(&level, &coarser);
        }
    }

    /// Writes the next level.
    fn put<S: Copy>(&mut self, level: &Cubemap<S>, packed: &impl Fn(S) -> T) {
        let (left, top) = corner(self.size, self.levels);
        let side = level.size() + 2 * BORDER;
        for face in CubeFace::ALL {
            for y in 0..side {
                let start = self.index(face as u32, left, top + y);
                let row = &mut self.texels[start..][..side as usize];
                let is_inside = (BORDER..side - BORDER).contains(&y);
                if is_inside {
                    let inner = &mut row[BORDER as usize..(side - BORDER) as usize];
                    let from = level.face(face).row(y - BORDER);
                    for (texel, from) in inner.iter_mut().zip(from) {
                        *texel = packed(*from);
                    }
                }
                for x in (0..side).filter(|&x| !is_inside || x == 0 || x == side - BORDER) {
                    row[x as usize] = packed(bordered(level, face, x, y));
                }
            }
        }
    }
}

impl<T: Copy> PackedCube<T> {
    /// Texels along a side of a face at level 0, without borders.
    pub fn size(&self) -> u32 {
        self.size
    }

    /// Number of levels, ≥ 1.
    pub fn levels(&self) -> u32 {
        self.levels
    }

    /// Width and height of the rectangle of a face.
    pub fn rectangle(&self) -> (u32, u32) {
        rectangle(self.size)
    }

    /// All texels: rectangle after rectangle in the order of the faces, each in rows.
    pub fn texels(&self) -> &[T] {
        &self.texels
    }

    #[inline(always)]
    fn index(&self, face: u32, x: u32, y: u32) -> usize {
        let (width, height) = rectangle(self.size);
        ((face * height + y) * width + x) as usize
    }

    /// The four texels around the place where `direction` goes through level `level`, from the
    /// left and top, and the shares of the right and the lower ones.
    #[inline(always)]
    pub fn around(&self, direction: Vec3, level: u32) -> ([T; 4], f32, f32) {
        let (face, u, v) = face_of(direction);
        let (left, top) = corner(self.size, level);
        let size = self.size >> level;
        let half = size as f32 * 0.5;
        // The centre of texel 0 lies one border to the right, and half a texel.
        let x = (u + 1.0) * half + 0.5;
        let y = (v + 1.0) * half + 0.5;
        let column = (x as u32).min(size);
        let row = (y as u32).min(size);
        let index = self.index(face, left + column, top + row);
        let below = index + rectangle(self.size).0 as usize;
        let texels = [
            self.texels[index],
            self.texels[index + 1],
            self.texels[below],
            self.texels[below + 1],
        ];
        (texels, x - column as f32, y - row as f32)
    }
}

impl PackedCube<f32> {
    /// The value in `direction` (any length but 0) at a level, bilinear.
    #[inline(always)]
    pub fn sampled(&self, direction: Vec3, level: u32) -> f32 {
        let ([a, b, c, d], right, down) = self.around(direction, level);
        let upper = a + (b - a) * right;
        let lower = c + (d - c) * right;
        upper + (lower - upper) * down
    }
}

/// Width and height of the rectangle of a face of `size`.
#[inline(always)]
fn rectangle(size: u32) -> (u32, u32) {
    (size + size / 2 + 4 * BORDER, size + 2 * BORDER)
}

/// The face that `direction` leaves through and where, −1 … 1; ties as [`CubeFace::of`].
#[inline(always)]
fn face_of(direction: Vec3) -> (u32, f32, f32) {
    let Vec3 { x, y, z } = direction;
    let (wide, high, deep) = (x.abs(), y.abs(), z.abs());
    if wide >= high && wide >= deep {
        let u = if x > 0.0 { -z } else { z };
        (u32::from(x <= 0.0), u / wide, -y / wide)
    } else if high >= deep {
        let v = if y > 0.0 { z } else { -z };
        (2 + u32::from(y <= 0.0), x / high, v / high)
    } else {
        let u = if z > 0.0 { x } else { -x };
        (4 + u32::from(z <= 0.0), u / deep, -y / deep)
    }
}

/// The texel (`x`, `y`) of `face` with its border.
///
/// There is no texel beyond a corner. All three faces that meet there take the same one, that of
/// the X face, or a step would show along the last half texel of their edges.
fn bordered<S: Copy>(level: &Cubemap<S>, face: CubeFace, x: u32, y: u32) -> S {
    let last = level.size() + BORDER;
    let end = |i: u32| if i == 0 { -1.0 } else { 1.0 };
    if (x == 0 || x == last) && (y == 0 || y == last) {
        return level.nearest(face.direction(end(x), end(y)));
    }
    let border = i64::from(BORDER);
    level.beyond(face, i64::from(x) - border, i64::from(y) - border)
}

/// The next level: each texel made of four.
fn halved<S: Copy>(level: &Cubemap<S>, coarser: impl Fn([S; 4]) -> S) -> Cubemap<S> {
    let size = level.size() / 2;
    Cubemap::from_faces(CubeFace::ALL.map(|face| {
        let from = level.face(face);
        let texels = (0..size).flat_map(|y| (0..size).map(move |x| (2 * x, 2 * y)));
        let pixels = texels
            .map(|(x, y)| {
                coarser([
                    from.at(x, y),
                    from.at(x + 1, y),
                    from.at(x, y + 1),
                    from.at(x + 1, y + 1),
                ])
            })
            .collect();
        crate::raster::Image::from_pixels(size, size, pixels)
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean(four: [f32; 4]) -> f32 {
        (four[0] + four[1] + four[2] + four[3]) * 0.25
    }

    #[test]
    fn samples_are_those_of_the_cubemap() {
        let wavy = Cubemap::from_directions(32, |d| {
            let d = d.normalize();
            (2.0 + libm::sin(5.0 * d.x) * d.y + d.z) as f32
        });
        let cube = PackedCube::new(wavy.clone(), mean, |x| x);
        for i in 0..2000 {
            let angle = f64::from(i) * 0.618;
            let height = f64::from(i) / 1000.0 - 1.0;
            let direction = glam::DVec3::new(libm::cos(angle), height, libm::sin(angle));
            let expected = wavy.sampled(direction);
            let found = cube.sampled(direction.as_vec3(), 0);
            assert!((found - expected).abs() < 2e-5, "{direction}");
        }
    }

    #[test]
    fn levels_fit_and_keep_a_constant() {
        for size in [8, 16, 20, 64, 256] {
            let cube = PackedCube::new(Cubemap::filled(size, 3.0f32), mean, |x| x);
            let (width, height) = cube.rectangle();
            for level in 0..cube.levels() {
                let (left, top) = corner(size, level);
                let side = (size >> level) + 2;
                assert!(
                    left + side <= width && top + side <= height,
                    "{size} {level}"
                );
                for direction in [Vec3::X, Vec3::NEG_Y, Vec3::new(1.0, 1.0, -1.0)] {
                    assert_eq!(cube.sampled(direction, level), 3.0);
                }
            }
        }
        assert_eq!(
            PackedCube::new(Cubemap::filled(256, 0f32), mean, |x| x).levels(),
            6
        );
    }

    #[test]
    fn no_step_shows_at_an_edge_of_the_cube() {
        let noise = Cubemap::from_directions(16, |d| {
            let hash = libm::sin(d.x * 913.0 + d.y * 717.0 + d.z * 501.0) * 4371.0;
            (hash - hash.floor()) as f32
        });
        let cube = PackedCube::new(noise, mean, |x| x);
        for i in 0..200 {
            let along = i as f32 / 100.0 - 1.0;
            for level in 0..cube.levels() {
                let one = cube.sampled(Vec3::new(1.0, along, 1.0 - 1e-6), level);
                let other = cube.sampled(Vec3::new(1.0 - 1e-6, along, 1.0), level);
                assert!((one - other).abs() < 1e-3, "{along} {level}");
            }
        }
    }
}
