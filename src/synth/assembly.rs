//! A cubemap of three textures, without a visible edge.
//!
//! As section 4.5.2 of the thesis: a wide texture becomes the four lateral faces; its two ends are
//! joined over a band of B columns; its first and last B rows are folded onto the top and the
//! bottom, where seams over the bands lead from them to two textures of their own. What lies on both
//! sides of an edge of the cube is thus one piece of texture. Where three faces meet, two bands of
//! one lid overlap: the later one keeps the outermost row of the earlier, and its seam finds its own
//! way from the corner inwards.
//!
//! Departures: the thesis's cube is one of equal *angles* here ([`lattice`](even_angles)), and is
//! resampled to the texels of a real cubemap at the end. Texels of a cubemap are 1.27 times as wide
//! as the average in the middle of a face and 0.64 times at the middle of an edge, so without
//! this the leaves would swell and shrink twice around the crown.

use super::seam::{Side, StepCost, seam};
use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Cubemap, Image, Straight};
use rayon::prelude::*;

/// The faces that one goes round at eye level to the right, as they lie in the lateral texture. Its
/// ends meet between the right and the back, out of the photograph's sight.
pub(super) const ROUND: [CubeFace; 4] = [
    CubeFace::NegZ,
    CubeFace::NegX,
    CubeFace::PosZ,
    CubeFace::PosX,
];

/// The width of the bands in which seams are sought, for faces of `size` texels: an eighth, as in the
/// thesis. Narrower leaves seams no choice, wider shortens what the lids have of their own.
pub fn band(size: u32) -> u32 {
    (size / 8).max(2)
}

/// The textures that a cubemap of `size` texels is made of: width and height of the lateral one and
/// of each lid.
pub fn texture_sizes(size: u32) -> [[u32; 2]; 2] {
    let band = band(size);
    [[4 * size + band, size + 2 * band], [size, size]]
}

/// The cubemap made of `lateral`, `top` and `bottom`, pictures of the [`texture_sizes`] of the size of
/// `top`; texels are of equal angle, see [`even_angles`].
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
///
/// # Panics
/// When the pictures have other sizes, or are smaller than 16 × 16.
pub fn assembled(
    lateral: &Image<Straight>,
    top: &Image<Straight>,
    bottom: &Image<Straight>,
    cancel: &Cancel,
) -> Result<Cubemap<Straight>, Cancelled> {
    let size = top.width();
    assert!(size >= 16, "bands need some texels");
    let [sides, lid] = texture_sizes(size);
    assert_eq!(
        [lateral.width(), lateral.height()],
        sides,
        "the lateral texture"
    );
    assert_eq!([top.width(), top.height()], lid, "the top's texture");
    assert_eq!(
        [bottom.width(), bottom.height()],
        lid,
        "the bottom's texture"
    );
    let ring = closed_ring(lateral, band(size), cancel)?;
    let (top, bottom) = rayon::join(
        || joined_lid(&ring, top, CubeFace::PosY, cancel),
        || joined_lid(&ring, bottom, CubeFace::NegY, cancel),
    );
    let (top, bottom) = (top?, bottom?);
    Ok(Cubemap::from_faces(CubeFace::ALL.map(|face| match face {
        CubeFace::PosY => top.clone(),
        CubeFace::NegY => bottom.clone(),
        _ => {
            let place = ROUND.iter().position(|&other| other == face).unwrap_or(0);
            ring.cropped(place as u32 * size, band(size), size, size)
        }
    })))
}

/// `lateral` with its last `band` columns laid over its first: what is left tiles horizontally.
fn closed_ring(
    lateral: &Image<Straight>,
    band: u32,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let (width, height) = (lateral.width() - band, lateral.height());
    let end = lateral.cropped(width, 0, band, height);
    let begin = lateral.cropped(0, 0, band, height);
    let side = |x, _| match x {
        0 => Side::First,
        x if x == band - 1 => Side::Second,
        _ => Side::Either,
    };
    let seam = seam(&end, &begin, side, StepCost::Difference, cancel)?;
    let mut ring = lateral.cropped(0, 0, width, height);
    for y in 0..height {
        for x in 0..band {
            if !seam.from_second.at(x, y) {
                ring.set(x, y, end.at(x, y));
            }
        }
    }
    Ok(ring)
}

/// The texture of the lid `face` (top or bottom) with the bands of `ring` folded onto its four sides.
fn joined_lid(
    ring: &Image<Straight>,
    lid: &Image<Straight>,
    face: CubeFace,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let size = lid.width();
    let mut joined = lid.clone();
    for index in 0..ROUND.len() {
        let fold = Fold { face, index, size };
        let first = fold.band_of(ring);
        let second = fold.rows_of(&joined);
        let side = |column, row| fold.side(column, row);
        let seam = seam(&first, &second, side, StepCost::Difference, cancel)?;
        for row in 0..band(size) {
            for column in 0..size {
                if !seam.from_second.at(column, row) {
                    let (x, y) = fold.place(column, row);
                    joined.set(x, y, first.at(column, row));
                }
            }
        }
    }
    Ok(joined)
}

/// One side of a lid, seen from the lateral face that it touches: columns as on that face, rows away
/// from the edge.
struct Fold {
    /// The lid.
    face: CubeFace,
    /// Which lateral face, in the order of [`ROUND`].
    index: usize,
    size: u32,
}

impl Fold {
    /// Where on the lid a texel of this side lies.
    fn place(&self, column: u32, row: u32) -> (u32, u32) {
        let [right, _, out] = ROUND[self.index].axes();
        let size = f64::from(self.size);
        let along = (2.0 * f64::from(column) + 1.0) / size - 1.0;
        let inwards = 1.0 - (2.0 * f64::from(row) + 1.0) / size;
        let position = right * along + out * inwards;
        let [lid_right, lid_down, _] = self.face.axes();
        let texel = |u: f64| ((u + 1.0) / 2.0 * size) as u32;
        (
            texel(position.dot(lid_right)),
            texel(position.dot(lid_down)),
        )
    }

    /// The band of the ring beyond this edge, its row 0 next to the face.
    fn band_of(&self, ring: &Image<Straight>) -> Image<Straight> {
        let first = self.index as u32 * self.size;
        let at = |column, row| {
            let y = match self.face {
                CubeFace::PosY => band(self.size) - 1 - row,
                _ => band(self.size) + self.size + row,
            };
            ring.at(first + column, y)
        };
        self.picture(at)
    }

    /// What the lid has there now.
    fn rows_of(&self, lid: &Image<Straight>) -> Image<Straight> {
        self.picture(|column, row| {
            let (x, y) = self.place(column, row);
            lid.at(x, y)
        })
    }

    fn picture(&self, at: impl Fn(u32, u32) -> Straight) -> Image<Straight> {
        let rows = band(self.size);
        let texels = (0..rows).flat_map(|row| (0..self.size).map(move |column| (column, row)));
        let pixels = texels.map(|(column, row)| at(column, row)).collect();
        Image::from_pixels(self.size, rows, pixels)
    }

    /// The outermost row is the band's, the innermost the lid's, and so are the outermost columns
    /// where the side before (and for the last the first one) put its own band.
    fn side(&self, column: u32, row: u32) -> Side {
        let last = self.size - 1;
        // To the right the lateral faces follow one another, so the side before is on the left.
        let is_neighbours =
            (self.index > 0 && column == 0) || (self.index == ROUND.len() - 1 && column == last);
        match row {
            0 => Side::First,
            _ if row == band(self.size) - 1 || is_neighbours => Side::Second,
            _ => Side::Either,
        }
    }
}

/// A cubemap whose texels divide each face's 90° into equal angles, resampled to one whose texels
/// divide the cube's edges into equal lengths, as renderers read it. Texture of even density becomes
/// texture of even density on the sphere.
///
/// Catmull–Rom; the middle of a face is reduced by 1.27 at most and the rest enlarged by at most 1.57,
/// so nothing aliases that shows.
pub fn even_angles(lattice: &Cubemap<Straight>) -> Cubemap<Straight> {
    let size = lattice.size();
    let taps: Vec<(i64, [f32; 4])> = (0..size)
        .map(|i| {
            let u = (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
            let angle = libm::atan(u) / std::f64::consts::FRAC_PI_4;
            let place = (angle + 1.0) / 2.0 * f64::from(size) - 0.5;
            let first = libm::floor(place);
            (first as i64 - 1, catmull_rom((place - first) as f32))
        })
        .collect();
    let faces: Vec<Image<Straight>> = CubeFace::ALL
        .par_iter()
        .map(|&face| resampled(lattice, face, &taps))
        .collect();
    let face = |i: usize| faces[i].clone();
    Cubemap::from_faces(std::array::from_fn(face))
}

/// How many texels beyond an edge [`even_angles`] reads.
const BEYOND: u32 = 2;

fn resampled(
    lattice: &Cubemap<Straight>,
    face: CubeFace,
    taps: &[(i64, [f32; 4])],
) -> Image<Straight> {
    let size = lattice.size();
    let wide = size + 2 * BEYOND;
    let texels = (0..wide).flat_map(|y| (0..wide).map(move |x| (x, y)));
    let shifted = |i: u32| i64::from(i) - i64::from(BEYOND);
    let padded: Vec<[f32; 3]> = texels
        .map(|(x, y)| {
            let Straight([r, g, b, _]) = lattice.beyond(face, shifted(x), shifted(y));
            [r, g, b].map(f32::from)
        })
        .collect();
    // Across, then down.
    let mut narrow = vec![[0f32; 3]; (size * wide) as usize];
    for (out, row) in narrow
        .chunks_mut(size as usize)
        .zip(padded.chunks(wide as usize))
    {
        for (out, (first, weights)) in out.iter_mut().zip(taps) {
            let at = (first + i64::from(BEYOND)) as usize;
            *out = weighted(weights, |k| row[at + k]);
        }
    }
    let pixels = (0..size as usize).flat_map(|y| {
        let (first, weights) = &taps[y];
        let at = (first + i64::from(BEYOND)) as usize;
        let narrow = &narrow;
        (0..size as usize).map(move |x| {
            let sum = weighted(weights, |k| narrow[(at + k) * size as usize + x]);
            let [r, g, b] = sum.map(|value| (value + 0.5).clamp(0.0, 255.0) as u8);
            Straight([r, g, b, 255])
        })
    });
    Image::from_pixels(size, size, pixels.collect())
}

#[inline]
fn weighted(weights: &[f32; 4], at: impl Fn(usize) -> [f32; 3]) -> [f32; 3] {
    let mut sum = [0f32; 3];
    for (k, weight) in weights.iter().enumerate() {
        for (sum, value) in sum.iter_mut().zip(at(k)) {
            *sum += weight * value;
        }
    }
    sum
}

/// The weights of the four texels around a place `t` (0 … 1) after the second of them.
fn catmull_rom(t: f32) -> [f32; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [
        -0.5 * t + t2 - 0.5 * t3,
        1.0 - 2.5 * t2 + 1.5 * t3,
        0.5 * t + 2.0 * t2 - 1.5 * t3,
        -0.5 * t2 + 0.5 * t3,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A texture in which each texel can be told by its colour.
    fn numbered(width: u32, height: u32, blue: u8) -> Image<Straight> {
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        let number = |(x, y): (u32, u32)| Straight([(x % 251) as u8, (y % 251) as u8, blue, 255]);
        Image::from_pixels(width, height, pixels.map(number).collect())
    }

    #[test]
    fn what_lies_on_both_sides_of_an_edge_is_one_piece_of_texture() {
        let size = 32;
        let [[width, height], _] = texture_sizes(size);
        let lateral = numbered(width, height, 0);
        let lids = [numbered(size, size, 200), numbered(size, size, 100)];
        let cube = assembled(&lateral, &lids[0], &lids[1], &Cancel::new()).unwrap();
        for i in 0..size - 1 {
            let front = cube.face(CubeFace::PosZ);
            let (above, below) = (cube.face(CubeFace::PosY), cube.face(CubeFace::NegY));
            let [x, y, ..] = front.at(i, 0).0;
            // The corner itself may be the neighbour's.
            if i > 0 {
                assert_eq!(above.at(i, size - 1).0, [x, y - 1, 0, 255]);
                let [x, y, ..] = front.at(i, size - 1).0;
                assert_eq!(below.at(i, 0).0, [x, y + 1, 0, 255]);
            }
            let [x, y, ..] = cube.face(CubeFace::PosX).at(0, i).0;
            assert_eq!(front.at(size - 1, i).0, [x - 1, y, 0, 255]);
            // Around the back the two ends meet: there too a texel's neighbour is its neighbour.
            let [x, y, ..] = cube.face(CubeFace::PosX).at(size - 1, i).0;
            assert_eq!(cube.face(CubeFace::NegZ).at(0, i).0, [x + 1, y, 0, 255]);
        }
        // The lids keep what is their own.
        assert_eq!(cube.face(CubeFace::PosY).at(16, 16).0, [16, 16, 200, 255]);
        assert_eq!(cube.face(CubeFace::NegY).at(16, 16).0, [16, 16, 100, 255]);
    }

    #[test]
    fn bands_are_folded_over_the_edge_that_they_touch() {
        for face in [CubeFace::PosY, CubeFace::NegY] {
            for (index, lateral) in ROUND.iter().enumerate() {
                let fold = Fold {
                    face,
                    index,
                    size: 16,
                };
                for column in 0..16 {
                    let (x, y) = fold.place(column, 0);
                    let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / 16.0 - 1.0;
                    let edge = lateral.direction(
                        centre(column),
                        if face == CubeFace::PosY { -1.0 } else { 1.0 },
                    );
                    assert!((face.direction(centre(x), centre(y)) - edge).length() < 0.07);
                }
            }
        }
    }

    #[test]
    fn equal_angles_keep_flat_and_smooth_colours() {
        let flat = Cubemap::filled(24, Straight([90, 120, 30, 255]));
        assert_eq!(even_angles(&flat), flat);
    }
}
