//! Laying texture around a crown so that leaves are as large everywhere.
//!
//! A cubemap divides directions, not surface: its texels cover 1.27 times the average width in the
//! middle of a face and 0.64 times at the middle of an edge, and around a crown three times as high as
//! wide those near the poles are drawn out to needles. So each direction is first sent to the surface
//! it meets, taken as half an ellipsoid above the crown's centre and half one below, and from there to
//! the box of texture ([`Lattice`]) by lengths measured on that surface:
//!
//! - around the crown, equal lengths along the equator, an ellipse;
//! - up and down the lateral faces, equal lengths along the meridian; rows follow the circles of
//!   latitude, and bend towards the lids' edges near them;
//! - on the lids, equal lengths along the meridian through the middles of the edges, blending into
//!   those along the equator at the edges, where the lid has to fit the lateral faces.
//!
//! A lid ends where it is as long from the pole as half a face is wide, so that it is square on the
//! surface too: on a sphere at 45°, near the tip of a tall crown. For a sphere all of this is the
//! equal-angle cube.
//!
//! Limits: the real crown deviates from the ellipsoids as far as it deviates; texture is stretched
//! where it does.

use super::assembly::{Lattice, LatticeSize};
use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Cubemap, Image, Straight};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// How far a crown reaches from its centre, pixels of the photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// To the left and right.
    pub across: f64,
    /// Towards the viewer and away.
    pub depth: f64,
    /// Upwards.
    pub up: f64,
    /// Downwards.
    pub down: f64,
}

impl Extent {
    /// Of a ball.
    pub fn ball(radius: f64) -> Self {
        Self {
            across: radius,
            depth: radius,
            up: radius,
            down: radius,
        }
    }

    /// Of the surface at `radius` (any unit) from the centre: half of what it measures from left to
    /// right and from front to back, and how far it reaches up and down.
    pub fn of_surface(radius: &Cubemap<f32>) -> Self {
        let size = radius.size();
        let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
        let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
        for face in CubeFace::ALL {
            for y in 0..size {
                for x in 0..size {
                    let direction = face.direction(centre(x), centre(y)).normalize();
                    let point = direction * f64::from(radius.face(face).at(x, y));
                    (low, high) = (low.min(point), high.max(point));
                }
            }
        }
        Self {
            across: (high.x - low.x) / 2.0,
            depth: (high.z - low.z) / 2.0,
            up: high.y,
            down: -low.y,
        }
    }
}

/// Largest ratio of one half-axis to another: beyond, a crown is no
/// crown, and the box of texture would become a stick or a sheet.
const LONGEST: f64 = 6.0;

/// Intervals in which lengths along a meridian are measured; interpolated, they are right to 1e-5.
const INTERVALS: usize = 512;

/// Most samples a texel is averaged from, along a side.
const MOST_SAMPLES: f64 = 4.0;

/// How texture is laid around a crown.
#[derive(Debug, Clone)]
pub struct Wrapping {
    across: f64,
    depth: f64,
    /// Along the equator, from the front and from the side.
    quarters: [Quarter; 2],
    /// Above, then below.
    halves: [Half; 2],
    size: LatticeSize,
    texels_per_pixel: f64,
}

impl Wrapping {
    /// For a crown of `extent` and a cubemap of `size` texels a face: the box of texture has about as
    /// many texels as the cubemap.
    pub fn new(extent: Extent, size: u32) -> Self {
        let across = extent.across.max(0.5);
        let like = |length: f64| length.clamp(across / LONGEST, across * LONGEST);
        let depth = like(extent.depth);
        let quarters = [Quarter::new(across, depth), Quarter::new(depth, across)];
        let halves = [extent.up, extent.down].map(|up| Half::new(across, depth, like(up)));
        let [width, side] = [0, 1].map(|i| 2.0 * quarters[i].to_corner);
        let height = halves[0].rim_from_equator() + halves[1].rim_from_equator();
        let area = 2.0 * (width + side) * height + 2.0 * width * side;
        let scale = libm::sqrt(6.0 * f64::from(size) * f64::from(size) / area);
        let texels = |length: f64| (libm::round(length * scale) as u32).max(LatticeSize::LEAST);
        Self {
            across,
            depth,
            quarters,
            halves,
            size: LatticeSize {
                width: texels(width),
                depth: texels(side),
                height: texels(height),
            },
            texels_per_pixel: scale,
        }
    }

    /// For a round crown: texels of equal angle.
    pub fn round(size: u32) -> Self {
        Self::new(Extent::ball(1.0), size)
    }

    /// The size of the box of texture that this wants.
    pub fn size(&self) -> LatticeSize {
        self.size
    }

    /// How many texels of that box lie on one pixel of the photograph: what the photograph is
    /// resized by before it becomes an exemplar, so that leaves keep their size.
    pub fn texels_per_pixel(&self) -> f64 {
        self.texels_per_pixel
    }

    /// Where in the box a direction lies: face, column and row, texel centres at whole numbers.
    pub fn place(&self, direction: DVec3) -> (CubeFace, f64, f64) {
        let half = &self.halves[usize::from(direction.y < 0.0)];
        let squashed = DVec3::new(
            direction.x,
            direction.y * half.squash,
            direction.z * self.across / self.depth,
        );
        let (face, u, v) = CubeFace::of(squashed);
        let texel = |share: f64, size: u32| (share + 1.0) / 2.0 * f64::from(size) - 0.5;
        let LatticeSize { width, depth, .. } = self.size;
        let [front, side] = &self.quarters;
        let rows = |v: f64| {
            let up = self.halves[0].rim_from_equator();
            let rows = f64::from(self.size.height) / (up + self.halves[1].rim_from_equator());
            let from_equator = half
                .length_from_equator(along_latitude(u, v.abs()))
                .copysign(v);
            (up + from_equator) * rows - 0.5
        };
        match face {
            CubeFace::PosY | CubeFace::NegY => {
                let x = half.on_lid(u, v, front.share(u));
                let y = half.on_lid(v, u, side.share(v));
                (face, texel(x, width), texel(y, depth))
            }
            CubeFace::PosZ | CubeFace::NegZ => (face, texel(front.share(u), width), rows(v)),
            CubeFace::PosX | CubeFace::NegX => (face, texel(side.share(u), depth), rows(v)),
        }
    }

    /// The direction of a place in the box: the inverse of [`Wrapping::place`] on one face.
    pub(super) fn direction(&self, face: CubeFace, x: f64, y: f64) -> DVec3 {
        let share =
            |texel: f64, size: u32| ((2.0 * texel + 1.0) / f64::from(size) - 1.0).clamp(-1.0, 1.0);
        let LatticeSize { width, depth, .. } = self.size;
        let [front, side] = &self.quarters;
        let (u, v) = match face {
            CubeFace::PosY | CubeFace::NegY => {
                let half = &self.halves[usize::from(face == CubeFace::NegY)];
                half.from_lid([share(x, width), share(y, depth)], [front, side])
            }
            CubeFace::PosZ | CubeFace::NegZ => self.from_rows(front.tangent(share(x, width)), y),
            CubeFace::PosX | CubeFace::NegX => self.from_rows(side.tangent(share(x, depth)), y),
        };
        let squashed = face.direction(u, v);
        let half = &self.halves[usize::from(squashed.y < 0.0)];
        DVec3::new(
            squashed.x,
            squashed.y / half.squash,
            squashed.z * self.depth / self.across,
        )
    }

    /// The squashed place on a lateral face whose column is at `u`, for the row `y`.
    fn from_rows(&self, u: f64, y: f64) -> (f64, f64) {
        let up = self.halves[0].rim_from_equator();
        let down = self.halves[1].rim_from_equator();
        let from_equator = (y + 0.5) / f64::from(self.size.height) * (up + down) - up;
        let half = &self.halves[usize::from(from_equator > 0.0)];
        let level = half.level_at(from_equator.abs()).min(1.0);
        (u, across_latitude(u, level).copysign(from_equator))
    }

    /// The point of the surface in `direction`, pixels of the photograph from the centre.
    fn surface(&self, direction: DVec3) -> DVec3 {
        let vertical = self.halves[usize::from(direction.y < 0.0)].vertical;
        let unit = DVec3::new(
            direction.x / self.across,
            direction.y / vertical,
            direction.z / self.depth,
        );
        direction / unit.length()
    }

    /// How many samples along each side a texel (from u, v as far as `step`) is averaged from.
    fn samples(&self, face: CubeFace, u: f64, v: f64, step: f64) -> u32 {
        let here = self.surface(face.direction(u, v));
        let across = self.surface(face.direction(u + step, v)).distance(here);
        let down = self.surface(face.direction(u, v + step)).distance(here);
        let extent = across.max(down) * self.texels_per_pixel;
        // Up to 1.3 texels one sample of the cubic is crisper and does not alias yet.
        libm::ceil((extent - 0.3).clamp(1.0, MOST_SAMPLES)) as u32
    }
}

/// The cubemap of `size` texels a face for which `lattice` lies around the crown as `wrapping` says.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
pub fn wrapped(
    lattice: &Lattice,
    wrapping: &Wrapping,
    size: u32,
    cancel: &Cancel,
) -> Result<Cubemap<Straight>, Cancelled> {
    let step = 2.0 / f64::from(size);
    let row = |face: CubeFace, y: u32| {
        cancel.check()?;
        let top = f64::from(y) * step - 1.0;
        let texels = (0..size).map(|x| {
            let left = f64::from(x) * step - 1.0;
            let count = wrapping.samples(face, left, top, step);
            let part = step / f64::from(count);
            let mut sum = [0f32; 3];
            for sample in 0..count * count {
                let u = left + part * (f64::from(sample % count) + 0.5);
                let v = top + part * (f64::from(sample / count) + 0.5);
                let (from, column, row) = wrapping.place(face.direction(u, v));
                for (sum, value) in sum.iter_mut().zip(lattice.sampled(from, column, row)) {
                    *sum += value;
                }
            }
            let share = 1.0 / (count * count) as f32;
            let [r, g, b] = sum.map(|value| (value * share + 0.5).clamp(0.0, 255.0) as u8);
            Straight([r, g, b, 255])
        });
        Ok(texels.collect::<Vec<_>>())
    };
    let rows: Vec<Vec<Straight>> = (0..6 * size)
        .into_par_iter()
        .map(|index| row(CubeFace::ALL[(index / size) as usize], index % size))
        .collect::<Result<_, Cancelled>>()?;
    let faces = std::array::from_fn(|face| {
        let first = face * size as usize;
        Image::from_pixels(size, size, rows[first..first + size as usize].concat())
    });
    Ok(Cubemap::from_faces(faces))
}

/// A quarter of an ellipse, measured.
#[derive(Debug, Clone)]
struct Quarter {
    /// Lengths from the point (0, `upright`), at equal steps of the angle t of the point
    /// (`flat` · sin t, `upright` · cos t).
    lengths: Vec<f64>,
    /// The length as far as t = 45°, where a face ends.
    to_corner: f64,
}

impl Quarter {
    fn new(flat: f64, upright: f64) -> Self {
        let point = |i: usize| {
            let (sine, cosine) = libm::sincos(FRAC_PI_2 * i as f64 / INTERVALS as f64);
            DVec2::new(flat * sine, upright * cosine)
        };
        let mut lengths = vec![0.0];
        for i in 1..=INTERVALS {
            lengths.push(lengths[i - 1] + point(i).distance(point(i - 1)));
        }
        let to_corner = lengths[INTERVALS / 2];
        Self { lengths, to_corner }
    }

    /// The length of the whole quarter.
    fn whole(&self) -> f64 {
        self.lengths[INTERVALS]
    }

    /// The length as far as the angle t.
    fn to(&self, angle: f64) -> f64 {
        let place = (angle / FRAC_PI_2).clamp(0.0, 1.0) * INTERVALS as f64;
        let before = (place as usize).min(INTERVALS - 1);
        let within = place - before as f64;
        self.lengths[before] * (1.0 - within) + self.lengths[before + 1] * within
    }

    /// The angle at `length`.
    fn angle_at(&self, length: f64) -> f64 {
        let after = self.lengths.partition_point(|&other| other < length);
        let after = after.clamp(1, INTERVALS);
        let step = self.lengths[after] - self.lengths[after - 1];
        let within = ((length - self.lengths[after - 1]) / step).min(1.0);
        FRAC_PI_2 * (after as f64 - 1.0 + within) / INTERVALS as f64
    }

    /// The tangent, −1 … 1, of a place among equal lengths as far as the corners.
    fn tangent(&self, share: f64) -> f64 {
        libm::tan(self.angle_at(share.abs() * self.to_corner)).copysign(share)
    }

    /// The place, −1 … 1, of the tangent `u`, −1 … 1, among equal lengths as far as the corners.
    fn share(&self, u: f64) -> f64 {
        (self.to(libm::atan(u.abs())) / self.to_corner).copysign(u)
    }
}

/// `v`, 0 … 1, of a lateral face, bent so that rows follow circles of latitude around the equator and
/// the lid's straight edge at `v` = 1. Rows that were straight on the face would have a kink at each
/// upright edge of the cube: boughs that hang level would form chevrons there.
fn along_latitude(u: f64, v: f64) -> f64 {
    let latitude = 1.0 / libm::sqrt(1.0 + u * u);
    v * (latitude + (1.0 - latitude) * v * v)
}

/// The inverse of [`along_latitude`] for 0 … 1.
fn across_latitude(u: f64, level: f64) -> f64 {
    let latitude = 1.0 / libm::sqrt(1.0 + u * u);
    let mut v = level;
    // Newton's method: convex and rising on 0 … 1, and `level` lies below the root.
    for _ in 0..6 {
        let excess = v * (latitude + (1.0 - latitude) * v * v) - level;
        v -= excess / (latitude + 3.0 * (1.0 - latitude) * v * v);
    }
    v
}

/// The upper or the lower half of a crown: half an ellipsoid. Lengths along its meridians are those of
/// the half whose equator is a circle of as large an area.
#[derive(Debug, Clone)]
struct Half {
    vertical: f64,
    /// What heights are multiplied by so that the edge of the lid comes to 45°, where the equator is
    /// a circle as wide as the crown.
    squash: f64,
    /// `squash` · vertical / across: from tangents there to those of the angle t.
    tangent: f64,
    /// From the pole.
    meridian: Quarter,
    /// The length from the pole to the lid's edge.
    rim: f64,
}

impl Half {
    fn new(across: f64, depth: f64, vertical: f64) -> Self {
        let mean = libm::sqrt(across * depth);
        let meridian = Quarter::new(mean, vertical);
        // As long as half a face is wide.
        let rim = mean * FRAC_PI_4;
        let tangent = libm::tan(meridian.angle_at(rim));
        Self {
            vertical,
            squash: tangent * across / vertical,
            tangent,
            meridian,
            rim,
        }
    }

    /// The length along the meridian from the equator to the lid's edge.
    fn rim_from_equator(&self) -> f64 {
        self.meridian.whole() - self.rim
    }

    /// The length from the equator of the place `v`, 0 … 1, on a squashed lateral face.
    fn length_from_equator(&self, v: f64) -> f64 {
        let angle = libm::atan2(self.tangent, v);
        self.meridian.whole() - self.meridian.to(angle)
    }

    /// The place, 0 … 1, on a squashed lateral face at `length` from the equator.
    fn level_at(&self, length: f64) -> f64 {
        let angle = self.meridian.angle_at(self.meridian.whole() - length);
        self.tangent / libm::tan(angle)
    }

    /// The squashed place on the lid of `shares` of its two sides, of which the edges are `quarters`.
    fn from_lid(&self, shares: [f64; 2], quarters: [&Quarter; 2]) -> (f64, f64) {
        let place = |i: usize, u: f64, other: f64| self.on_lid(u, other, quarters[i].share(u));
        let mut at = shares;
        // The two ways hardly depend on each other, and each is nearly straight: a few steps of
        // the secant's method settle both.
        for _ in 0..8 {
            for i in 0..2 {
                let (here, other) = (at[i], at[1 - i]);
                let ahead = here - 1e-3_f64.copysign(here);
                let slope = (place(i, here, other) - place(i, ahead, other)) / (here - ahead);
                let missing = shares[i] - place(i, here, other);
                at[i] = (here + missing / slope.max(0.1)).clamp(-1.0, 1.0);
            }
        }
        (at[0], at[1])
    }

    /// The place on the lid, −1 … 1, of `u` on the squashed face, `other` being the other way, where
    /// the lid's edge has it at `edge`.
    fn on_lid(&self, u: f64, other: f64, edge: f64) -> f64 {
        let length = self.meridian.to(libm::atan(u.abs() * self.tangent));
        let even = (length / self.rim).min(1.0).copysign(u);
        even + (edge - even) * other * other
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even_angle(u: f64) -> f64 {
        libm::atan(u) / FRAC_PI_4
    }

    #[test]
    fn a_sphere_gives_the_cube_of_equal_angles() {
        let wrapping = Wrapping::round(64);
        assert_eq!(
            wrapping.size(),
            LatticeSize {
                width: 64,
                depth: 64,
                height: 64
            }
        );
        for face in CubeFace::ALL {
            for (u, v) in [(0.0, 0.0), (0.3, -0.8), (-0.9, 0.5), (0.99, 0.98)] {
                let (found, x, y) = wrapping.place(face.direction(u, v));
                let expected = |u| (even_angle(u) + 1.0) * 32.0 - 0.5;
                assert_eq!(found, face);
                assert!((x - expected(u)).abs() < 0.01, "{x} {}", expected(u));
                let is_lid = matches!(face, CubeFace::PosY | CubeFace::NegY);
                let row = if is_lid {
                    v
                } else {
                    along_latitude(u, v.abs()).copysign(v)
                };
                assert!((y - expected(row)).abs() < 0.01, "{y} {}", expected(row));
            }
        }
        // As many texels on a pixel as there are in a quarter turn of the mean radius.
        let photo = Extent::ball(100.0);
        let scale = Wrapping::new(photo, 256).texels_per_pixel();
        assert!((scale - 256.0 / (100.0 * FRAC_PI_2)).abs() < 1e-3);
    }

    #[test]
    fn directions_and_places_are_inverse() {
        let tall = Extent {
            across: 40.0,
            depth: 30.0,
            up: 90.0,
            down: 50.0,
        };
        for wrapping in [Wrapping::round(64), Wrapping::new(tall, 128)] {
            let LatticeSize {
                width,
                depth,
                height,
            } = wrapping.size();
            for face in CubeFace::ALL {
                let [columns, rows] = match face {
                    CubeFace::PosY | CubeFace::NegY => [width, depth],
                    CubeFace::PosZ | CubeFace::NegZ => [width, height],
                    CubeFace::PosX | CubeFace::NegX => [depth, height],
                };
                for x in 0..columns {
                    for y in 0..rows {
                        let (x, y) = (f64::from(x), f64::from(y));
                        let (found, u, v) = wrapping.place(wrapping.direction(face, x, y));
                        assert_eq!(found, face);
                        assert!(
                            (u - x).abs() < 0.01 && (v - y).abs() < 0.01,
                            "{x} {y} {u} {v}"
                        );
                    }
                }
            }
        }
    }

    /// Texels in the box for a step on the surface of one texel's size, along `along`.
    fn density(wrapping: &Wrapping, direction: DVec3, along: DVec3) -> Option<f64> {
        let [here, there] = [direction - along * 1e-3, direction + along * 1e-3];
        let length = wrapping.surface(here).distance(wrapping.surface(there));
        let ((a, x0, y0), (b, x1, y1)) = (wrapping.place(here), wrapping.place(there));
        let texels = libm::hypot(x1 - x0, y1 - y0);
        (a == b).then_some(texels / (length * wrapping.texels_per_pixel()))
    }

    #[test]
    fn texels_are_of_even_size_on_tall_and_flat_crowns() {
        let shapes = [
            (1.0, 1.0, 1.0),
            (1.0, 3.0, 1.5),
            (1.0, 0.5, 0.7),
            (1.0, 5.0, 5.0),
            (0.4, 1.0, 1.2),
        ];
        for (depth, up, down) in shapes {
            let wrapping = Wrapping::new(
                Extent {
                    across: 1.0,
                    depth,
                    up,
                    down,
                },
                256,
            );
            let (mut least, mut most) = (f64::INFINITY, 0f64);
            for i in 0..4000 {
                // Evenly over the surface's height and around, poles included.
                let angle = f64::from(i) * 2.399_963;
                let height = 1.0 - (2.0 * f64::from(i) + 1.0) / 4000.0;
                let ring = libm::sqrt(1.0 - height * height);
                let vertical = if height > 0.0 { up } else { down };
                let (sine, cosine) = libm::sincos(angle);
                let direction =
                    DVec3::new(ring * sine, height * vertical, ring * cosine * depth).normalize();
                let sideways = direction.any_orthonormal_vector();
                for along in [sideways, direction.cross(sideways)] {
                    if let Some(density) = density(&wrapping, direction, along) {
                        (least, most) = (least.min(density), most.max(density));
                    }
                }
            }
            assert!(
                least > 0.5 && most < 2.5,
                "{depth} {up} {down}: {least} … {most}"
            );
        }
    }

    #[test]
    fn the_extent_of_a_surface_is_that_of_what_it_encloses() {
        let egg = Cubemap::from_directions(32, |d| {
            let d = d.normalize();
            let vertical = if d.y > 0.0 { 30.0 } else { 12.0 };
            (1.0 / DVec3::new(d.x / 10.0, d.y / vertical, d.z / 7.0).length()) as f32
        });
        let extent = Extent::of_surface(&egg);
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.02;
        assert!(
            near(extent.across, 10.0) && near(extent.depth, 7.0),
            "{extent:?}"
        );
        assert!(
            near(extent.up, 30.0) && near(extent.down, 12.0),
            "{extent:?}"
        );
    }

    #[test]
    fn faces_meet_at_their_edges() {
        let extent = Extent {
            across: 1.0,
            depth: 0.6,
            up: 2.5,
            down: 1.2,
        };
        let wrapping = Wrapping::new(extent, 128);
        let (depth, height) = (
            f64::from(wrapping.size().depth),
            f64::from(wrapping.size().height),
        );
        for i in -9..10 {
            let u = f64::from(i) / 10.0;
            let half = &wrapping.halves[0];
            let at = |y: f64| wrapping.place(DVec3::new(u, y / half.squash, 0.6));
            let ((above, x0, y0), (below, x1, y1)) = (at(1.0 + 1e-9), at(1.0 - 1e-9));
            assert_eq!((above, below), (CubeFace::PosY, CubeFace::PosZ));
            assert!((x0 - x1).abs() < 1e-4, "{x0} {x1}");
            assert!(
                (y0 - (depth - 0.5)).abs() < 1e-3 && (y1 + 0.5).abs() < 1e-3,
                "{y0} {y1} {height}"
            );
        }
    }
}
