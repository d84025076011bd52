//! Six square pictures around a point: what is seen, or how far something is, in every direction.
//!
//! Faces, their order and their orientation are those of Vulkan, KTX and glTF, in the world frame
//! (right-handed, +Y up, the viewer at +Z). Seen from *outside* the cube no face is mirrored: going
//! round at eye level to the right, the lateral faces follow one another as +Z, +X, −Z, −X; the
//! bottom row of +Y and the top row of −Y touch +Z.

use super::Image;
use glam::DVec3;

/// A face of a cube, named after the axis that leaves through it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[repr(u8)]
pub enum CubeFace {
    /// +X: to the viewer's right.
    PosX,
    /// −X: to the viewer's left.
    NegX,
    /// +Y: up.
    PosY,
    /// −Y: down.
    NegY,
    /// +Z: towards the viewer.
    PosZ,
    /// −Z: away from the viewer.
    NegZ,
}

impl CubeFace {
    /// All faces, in the order of files and layers.
    pub const ALL: [Self; 6] = [
        Self::PosX,
        Self::NegX,
        Self::PosY,
        Self::NegY,
        Self::PosZ,
        Self::NegZ,
    ];

    /// The name of the face in files: `px`, `nx`, `py`, `ny`, `pz`, `nz`.
    pub fn name(self) -> &'static str {
        ["px", "nx", "py", "ny", "pz", "nz"][self as usize]
    }

    /// The axes of the face: to the right, down, and out through its middle, as seen from outside.
    pub fn axes(self) -> [DVec3; 3] {
        let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
        match self {
            Self::PosX => [-z, -y, x],
            Self::NegX => [z, -y, -x],
            Self::PosY => [x, z, y],
            Self::NegY => [x, -z, -y],
            Self::PosZ => [x, -y, z],
            Self::NegZ => [-x, -y, -z],
        }
    }

    /// The direction through (`u`, `v`) of the face, both −1 … 1 from left and top; not normalised:
    /// its longest component is 1. Beyond −1 … 1 the face's plane goes on past its edges.
    pub fn direction(self, u: f64, v: f64) -> DVec3 {
        let [right, down, out] = self.axes();
        right * u + down * v + out
    }

    /// The face that `direction` leaves through, and where: `u` and `v`, −1 … 1 from left and top.
    ///
    /// Ties at edges and corners go to X before Y before Z. `direction` must not be zero; it need
    /// not be normalised.
    pub fn of(direction: DVec3) -> (Self, f64, f64) {
        let size = direction.abs();
        let face = if size.x >= size.y && size.x >= size.z {
            if direction.x > 0.0 {
                Self::PosX
            } else {
                Self::NegX
            }
        } else if size.y >= size.z {
            if direction.y > 0.0 {
                Self::PosY
            } else {
                Self::NegY
            }
        } else if direction.z > 0.0 {
            Self::PosZ
        } else {
            Self::NegZ
        };
        let [right, down, out] = face.axes();
        let depth = direction.dot(out);
        (
            face,
            direction.dot(right) / depth,
            direction.dot(down) / depth,
        )
    }
}

/// Six faces of `size` × `size` texels each.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cubemap<P> {
    faces: [Image<P>; 6],
}

impl<P: Copy> Cubemap<P> {
    /// A cubemap from its faces, in the order of [`CubeFace::ALL`].
    ///
    /// # Panics
    /// When the faces are not squares of one size.
    pub fn from_faces(faces: [Image<P>; 6]) -> Self {
        let size = faces[0].width();
        let fits = |face: &Image<P>| face.width() == size && face.height() == size;
        assert!(faces.iter().all(fits), "faces are squares of one size");
        Self { faces }
    }

    /// A cubemap of one value.
    ///
    /// # Panics
    /// When `size` is 0.
    pub fn filled(size: u32, value: P) -> Self {
        Self::from_faces(std::array::from_fn(|_| Image::filled(size, size, value)))
    }

    /// A cubemap whose texels are made from the directions through their centres (longest
    /// component 1, see [`CubeFace::direction`]).
    pub fn from_directions(size: u32, mut value: impl FnMut(DVec3) -> P) -> Self {
        Self::from_faces(CubeFace::ALL.map(|face| {
            let texels = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
            let pixels = texels
                .map(|(x, y)| value(face.direction(texel_centre(x, size), texel_centre(y, size))))
                .collect();
            Image::from_pixels(size, size, pixels)
        }))
    }

    /// Texels along a side of a face.
    #[inline]
    pub fn size(&self) -> u32 {
        self.faces[0].width()
    }

    /// A face.
    #[inline]
    pub fn face(&self, face: CubeFace) -> &Image<P> {
        &self.faces[face as usize]
    }

    /// A face, to be changed; it must keep its size.
    #[inline]
    pub fn face_mut(&mut self, face: CubeFace) -> &mut Image<P> {
        &mut self.faces[face as usize]
    }

    /// All faces, in the order of [`CubeFace::ALL`].
    #[inline]
    pub fn faces(&self) -> &[Image<P>; 6] {
        &self.faces
    }

    /// The cubemap with `change` applied to each texel.
    pub fn map<Q: Copy>(&self, mut change: impl FnMut(&P) -> Q) -> Cubemap<Q> {
        Cubemap::from_faces(std::array::from_fn(|i| self.faces[i].map(&mut change)))
    }

    /// The texel that `direction` goes through.
    pub fn nearest(&self, direction: DVec3) -> P {
        let (face, u, v) = CubeFace::of(direction);
        let size = self.size();
        self.face(face).at(texel_of(u, size), texel_of(v, size))
    }

    /// The texel (`x`, `y`) of `face`, where up to one row or column beyond the edge is found on the
    /// neighbouring face: what filters that must not show the cube's edges read.
    ///
    /// Beyond a corner there is no texel; the one next to it on a neighbouring face is taken.
    pub fn beyond(&self, face: CubeFace, x: i64, y: i64) -> P {
        match self.face(face).get(x, y) {
            Some(texel) => texel,
            None => {
                let size = f64::from(self.size());
                let centre = |i: i64| (2.0 * i as f64 + 1.0) / size - 1.0;
                self.nearest(face.direction(centre(x), centre(y)))
            }
        }
    }
}

impl Cubemap<f32> {
    /// The value in `direction`, bilinear and without a step at the cube's edges.
    pub fn sampled(&self, direction: DVec3) -> f32 {
        let (face, u, v) = CubeFace::of(direction);
        let half = f64::from(self.size()) / 2.0;
        let (x, y) = ((u + 1.0) * half - 0.5, (v + 1.0) * half - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right, down) = ((x - left) as f32, (y - top) as f32);
        let at = |dx: i64, dy: i64| self.beyond(face, left as i64 + dx, top as i64 + dy);
        let upper = at(0, 0) * (1.0 - right) + at(1, 0) * right;
        let lower = at(0, 1) * (1.0 - right) + at(1, 1) * right;
        upper * (1.0 - down) + lower * down
    }
}

/// Where the centre of texel `i` of `size` lies, −1 … 1.
fn texel_centre(i: u32, size: u32) -> f64 {
    (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0
}

/// The texel that holds `u`, −1 … 1.
fn texel_of(u: f64, size: u32) -> u32 {
    let texel = ((u + 1.0) / 2.0 * f64::from(size)).floor();
    texel.clamp(0.0, f64::from(size - 1)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_finds_its_face_and_place_again() {
        for face in CubeFace::ALL {
            for (u, v) in [(0.0, 0.0), (0.3, -0.7), (-0.99, 0.98)] {
                let (found, found_u, found_v) = CubeFace::of(3.0 * face.direction(u, v));
                assert_eq!(found, face);
                assert!((found_u - u).abs() < 1e-12 && (found_v - v).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn faces_are_not_mirrored_from_outside_and_follow_one_another() {
        for face in CubeFace::ALL {
            let [right, down, out] = face.axes();
            // To the right × up = towards whoever looks at the face from outside.
            assert_eq!(right.cross(-down), out);
        }
        let round = [
            CubeFace::PosZ,
            CubeFace::PosX,
            CubeFace::NegZ,
            CubeFace::NegX,
        ];
        for (i, face) in round.iter().enumerate() {
            let next = round[(i + 1) % 4];
            assert_eq!(face.direction(1.0, 0.5), next.direction(-1.0, 0.5));
        }
        let front = CubeFace::PosZ;
        assert_eq!(
            CubeFace::PosY.direction(0.5, 1.0),
            front.direction(0.5, -1.0)
        );
        assert_eq!(
            CubeFace::NegY.direction(0.5, -1.0),
            front.direction(0.5, 1.0)
        );
    }

    #[test]
    fn a_smooth_function_is_sampled_without_a_step_at_the_edges() {
        let smooth = |d: DVec3| {
            let d = d.normalize();
            (1.0 + d.x * 0.3 + d.y * d.z) as f32
        };
        let map = Cubemap::from_directions(32, smooth);
        for step in 0..200 {
            let angle = f64::from(step) / 200.0 * std::f64::consts::TAU;
            let direction = DVec3::new(angle.sin(), 0.9, angle.cos());
            assert!((map.sampled(direction) - smooth(direction)).abs() < 0.02);
        }
    }
}
