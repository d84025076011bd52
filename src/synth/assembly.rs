//! A cubemap of three textures, without a visible edge.
//!
//! As section 4.5.2 of the thesis: a wide texture becomes the four lateral faces; its two ends are
//! joined over a band of B columns; its first and last B rows are folded onto the top and the
//! bottom, where seams over the bands lead from them to two textures of their own. What lies on both
//! sides of an edge of the cube is thus one piece of texture. Where three faces meet, two bands of
//! one lid overlap: the later one keeps the outermost row of the earlier, and its seam finds its own
//! way from the corner inwards.
//!
//! Departures: the thesis's cube is a box here, [`Lattice`], as high as the crown is long from rim to
//! rim; [`super::wrapping`] lays it around the crown so that texels are as large everywhere, and only
//! then are the faces of a real cubemap read from it.

use super::seam::{Side, StepCost, seam};
use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Image, Straight};

/// The faces that one goes round at eye level to the right, as they lie in the lateral texture. Its
/// ends meet between the right and the back, out of the photograph's sight.
pub(super) const ROUND: [CubeFace; 4] = [
    CubeFace::NegZ,
    CubeFace::NegX,
    CubeFace::PosZ,
    CubeFace::PosX,
];

/// The size of a [`Lattice`], a box of texture; each side at least [`LatticeSize::LEAST`] texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LatticeSize {
    /// Texels across its front and back.
    pub width: u32,
    /// Texels across its left and right sides.
    pub depth: u32,
    /// Texels down all four.
    pub height: u32,
}

impl LatticeSize {
    /// Fewest texels of a side: bands need some.
    pub const LEAST: u32 = 16;

    /// The width of the bands in which seams are sought: an eighth of a face, as in the thesis.
    /// Narrower leaves seams no choice, wider shortens what the lids have of their own.
    pub fn band(self) -> u32 {
        self.width.min(self.depth) / 8
    }

    /// Width and height of the texture that becomes the lateral faces.
    pub fn lateral(self) -> [u32; 2] {
        [self.girth() + self.band(), self.height + 2 * self.band()]
    }

    /// Width and height of the texture that becomes a lid.
    pub fn lid(self) -> [u32; 2] {
        [self.width, self.depth]
    }

    /// Which texel of which face column `x` and row `y` of the lateral texture become; in the bands
    /// above and below that of the lid that they are folded onto. The last columns are those that
    /// are laid over the first.
    pub(super) fn lateral_texel(self, x: u32, y: u32) -> (CubeFace, u32, u32) {
        let column = x % self.girth();
        let mut index = ROUND.len() - 1;
        while self.first_column(index) > column {
            index -= 1;
        }
        let column = column - self.first_column(index);
        let (band, height) = (self.band(), self.height);
        let lid = |face: CubeFace, row: u32| {
            let fold = Fold {
                face,
                index,
                size: self,
            };
            let (x, y) = fold.place(column, row);
            (face, x, y)
        };
        match y {
            y if y < band => lid(CubeFace::PosY, band - 1 - y),
            y if y < band + height => (ROUND[index], column, y - band),
            _ => lid(CubeFace::NegY, y - band - height),
        }
    }

    /// Texels all around.
    fn girth(self) -> u32 {
        2 * (self.width + self.depth)
    }

    /// Texels across a lateral face, by its place in [`ROUND`].
    fn across(self, index: usize) -> u32 {
        [self.width, self.depth][index % 2]
    }

    /// The first column of a lateral face in the ring of all, by its place in [`ROUND`].
    fn first_column(self, index: usize) -> u32 {
        (0..index).map(|before| self.across(before)).sum()
    }
}

/// The box of texture made of `lateral`, `top` and `bottom`, pictures of the sizes that `size` asks
/// for.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
///
/// # Panics
/// When the pictures have other sizes, or are smaller than [`LatticeSize::LEAST`].
pub fn assembled(
    lateral: &Image<Straight>,
    top: &Image<Straight>,
    bottom: &Image<Straight>,
    size: LatticeSize,
    cancel: &Cancel,
) -> Result<Lattice, Cancelled> {
    let is = |image: &Image<Straight>, sides| [image.width(), image.height()] == sides;
    assert!(
        size.width.min(size.depth).min(size.height) >= LatticeSize::LEAST,
        "bands need some texels"
    );
    assert!(
        is(lateral, size.lateral()),
        "the lateral texture has another size"
    );
    assert!(
        is(top, size.lid()) && is(bottom, size.lid()),
        "a lid has another size"
    );
    let ring = closed_ring(lateral, size.band(), cancel)?;
    let (top, bottom) = rayon::join(
        || joined_lid(&ring, top, CubeFace::PosY, size, cancel),
        || joined_lid(&ring, bottom, CubeFace::NegY, size, cancel),
    );
    Ok(Lattice {
        lids: [top?, bottom?],
        ring,
        size,
    })
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
    size: LatticeSize,
    cancel: &Cancel,
) -> Result<Image<Straight>, Cancelled> {
    let mut joined = lid.clone();
    for index in 0..ROUND.len() {
        let fold = Fold { face, index, size };
        let first = fold.band_of(ring);
        let second = fold.rows_of(&joined);
        let side = |column, row| fold.side(column, row);
        let seam = seam(&first, &second, side, StepCost::Difference, cancel)?;
        for row in 0..size.band() {
            for column in 0..size.across(index) {
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
    size: LatticeSize,
}

impl Fold {
    /// Where on the lid a texel of this side lies.
    fn place(&self, column: u32, row: u32) -> (u32, u32) {
        let [right, _, out] = ROUND[self.index].axes();
        let centre = |i: u32, size: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
        let along = centre(column, self.size.across(self.index));
        let inwards = -centre(row, self.size.across(self.index + 1));
        let position = right * along + out * inwards;
        let [lid_right, lid_down, _] = self.face.axes();
        let texel = |u: f64, size: u32| ((u + 1.0) / 2.0 * f64::from(size)) as u32;
        (
            texel(position.dot(lid_right), self.size.width),
            texel(position.dot(lid_down), self.size.depth),
        )
    }

    /// The band of the ring beyond this edge, its row 0 next to the face.
    fn band_of(&self, ring: &Image<Straight>) -> Image<Straight> {
        let first = self.size.first_column(self.index);
        let at = |column, row| {
            let y = match self.face {
                CubeFace::PosY => self.size.band() - 1 - row,
                _ => self.size.band() + self.size.height + row,
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
        let (columns, rows) = (self.size.across(self.index), self.size.band());
        let texels = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let pixels = texels.map(|(column, row)| at(column, row)).collect();
        Image::from_pixels(columns, rows, pixels)
    }

    /// The outermost row is the band's, the innermost the lid's, and so are the outermost columns
    /// where the side before (and for the last the first one) put its own band.
    fn side(&self, column: u32, row: u32) -> Side {
        let last = self.size.across(self.index) - 1;
        // To the right the lateral faces follow one another, so the side before is on the left.
        let is_neighbours =
            (self.index > 0 && column == 0) || (self.index == ROUND.len() - 1 && column == last);
        match row {
            0 => Side::First,
            _ if row == self.size.band() - 1 || is_neighbours => Side::Second,
            _ => Side::Either,
        }
    }
}

/// What a cubemap is read from: a box of texture without a visible edge.
#[derive(Debug, Clone)]
pub struct Lattice {
    /// The lateral faces in the order of [`ROUND`], their bands above and below them.
    ring: Image<Straight>,
    /// Top, then bottom.
    lids: [Image<Straight>; 2],
    size: LatticeSize,
}

impl Lattice {
    /// Its width, depth and height.
    pub fn size(&self) -> LatticeSize {
        self.size
    }

    /// The texture of `face`.
    pub fn face(&self, face: CubeFace) -> Image<Straight> {
        let size = self.size;
        match round_of(face) {
            Some(index) => {
                let (first, across) = (size.first_column(index), size.across(index));
                self.ring.cropped(first, size.band(), across, size.height)
            }
            None => self.lids[usize::from(face == CubeFace::NegY)].clone(),
        }
    }

    /// The texel (`x`, `y`) of `face`; what lies beyond an edge, up to a band's width, is found where
    /// it goes on.
    #[inline]
    fn texel(&self, face: CubeFace, x: i64, y: i64) -> Straight {
        match round_of(face) {
            Some(index) => {
                let last = i64::from(self.ring.height()) - 1;
                let row = (y + i64::from(self.size.band())).clamp(0, last);
                let column = i64::from(self.size.first_column(index)) + x;
                let column = column.rem_euclid(i64::from(self.ring.width()));
                self.ring.at(column as u32, row as u32)
            }
            None => {
                let lid = &self.lids[usize::from(face == CubeFace::NegY)];
                lid.get(x, y).unwrap_or_else(|| self.below_lid(face, x, y))
            }
        }
    }

    /// The texel beyond the edge of a lid: on the lateral face there; beyond a corner the nearest.
    fn below_lid(&self, face: CubeFace, x: i64, y: i64) -> Straight {
        let [width, depth] = self.size.lid().map(i64::from);
        let (inner_x, inner_y) = (x.clamp(0, width - 1), y.clamp(0, depth - 1));
        let [beyond_x, beyond_y] = [x - inner_x, y - inner_y];
        let centre = |i: i64, size: i64| (2 * i + 1) as f64 / size as f64 - 1.0;
        let [right, down, _] = face.axes();
        // Across the edge that was left farther behind.
        let (along, out) = if beyond_x.abs() >= beyond_y.abs() {
            (
                down * centre(inner_y, depth),
                right * beyond_x.signum() as f64,
            )
        } else {
            (
                right * centre(inner_x, width),
                down * beyond_y.signum() as f64,
            )
        };
        let is_there = |lateral: &CubeFace| lateral.axes()[2] == out;
        let index = ROUND.iter().position(is_there).unwrap_or(0);
        let across = f64::from(self.size.across(index));
        let column = ((along.dot(ROUND[index].axes()[0]) + 1.0) / 2.0 * across) as i64;
        let below = beyond_x.abs().max(beyond_y.abs()) - 1;
        let row = match face {
            CubeFace::PosY => below,
            _ => i64::from(self.size.height) - 1 - below,
        };
        self.texel(ROUND[index], column, row)
    }

    /// The colour at (`x`, `y`) of `face`, texel centres at whole numbers: Catmull–Rom over 4 × 4
    /// texels, those beyond an edge included.
    #[inline]
    pub(super) fn sampled(&self, face: CubeFace, x: f64, y: f64) -> [f32; 3] {
        let (left, top) = (libm::floor(x), libm::floor(y));
        let across = catmull_rom((x - left) as f32);
        let down = catmull_rom((y - top) as f32);
        let mut sum = [0f32; 3];
        for (j, down) in down.iter().enumerate() {
            let row = top as i64 - 1 + j as i64;
            for (i, across) in across.iter().enumerate() {
                let texel = self.texel(face, left as i64 - 1 + i as i64, row);
                let weight = across * down;
                for (sum, value) in sum.iter_mut().zip(texel.0) {
                    *sum += weight * f32::from(value);
                }
            }
        }
        sum
    }
}

/// Which of [`ROUND`] a face is; `None` for lids.
#[inline]
fn round_of(face: CubeFace) -> Option<usize> {
    match face {
        CubeFace::NegZ => Some(0),
        CubeFace::NegX => Some(1),
        CubeFace::PosZ => Some(2),
        CubeFace::PosX => Some(3),
        CubeFace::PosY | CubeFace::NegY => None,
    }
}

/// The weights of the four texels around a place `t` (0 … 1) after the second of them: the
/// interpolating cubic of Catmull and Rom (1974).
#[inline]
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
        let size = LatticeSize {
            width: 32,
            depth: 32,
            height: 32,
        };
        let [width, height] = size.lateral();
        let lateral = numbered(width, height, 0);
        let lids = [numbered(32, 32, 200), numbered(32, 32, 100)];
        let cube = assembled(&lateral, &lids[0], &lids[1], size, &Cancel::new()).unwrap();
        let front = cube.face(CubeFace::PosZ);
        let (above, below) = (cube.face(CubeFace::PosY), cube.face(CubeFace::NegY));
        let size = 32;
        for i in 0..size - 1 {
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
                let size = LatticeSize {
                    width: 16,
                    depth: 16,
                    height: 40,
                };
                let fold = Fold { face, index, size };
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
    fn texels_beyond_an_edge_are_where_the_texture_goes_on() {
        let size = LatticeSize {
            width: 16,
            depth: 24,
            height: 30,
        };
        let [width, height] = size.lateral();
        let lids = [numbered(16, 24, 200), numbered(16, 24, 100)];
        let lateral = numbered(width, height, 0);
        let lattice = assembled(&lateral, &lids[0], &lids[1], size, &Cancel::new()).unwrap();
        // Right of the front is the right; above it the top's last row; beyond the top's last row
        // the front again.
        let (front, right, top) = (CubeFace::PosZ, CubeFace::PosX, CubeFace::PosY);
        assert_eq!(lattice.texel(front, 16, 5), lattice.texel(right, 0, 5));
        assert_eq!(lattice.texel(front, 7, -1), lattice.texel(top, 7, 23));
        for row in 0..2 {
            assert_eq!(
                lattice.texel(top, 7, 24 + row),
                lattice.texel(front, 7, row)
            );
            assert_eq!(
                lattice.texel(top, 16 + row, 7),
                lattice.texel(right, 16, row)
            );
            let below = lattice.texel(CubeFace::NegY, 16 + row, 7);
            assert_eq!(below, lattice.texel(right, 7, 29 - row));
        }
        let [r, g, b] = lattice.sampled(front, 4.0, 6.0);
        assert_eq!(
            Straight([r as u8, g as u8, b as u8, 255]),
            lattice.texel(front, 4, 6)
        );
    }
}
