//! A linear system with one unknown a pixel and the same stencil at every one.
//!
//! The matrix is a principal submatrix of the operator on the endless grid, hence symmetric and
//! positive definite for every set of pixels. Values known outside the set (a boundary) go to the
//! right-hand side; [`GridSystem::spread`] brings them there.

use crate::raster::Mask;

/// Pixels around the frame that a stencil may reach.
const PAD: usize = 2;

/// Marks a pixel without an unknown.
pub(super) const NONE: u32 = u32::MAX;

/// The operator at every pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stencil {
    /// The negative Laplacian: 4 in the centre, −1 at the four neighbours.
    Laplacian,
    /// Its square, 13 points: 20, −8 at the neighbours, 2 at the diagonals, 1 two pixels away.
    Bilaplacian,
}

impl Stencil {
    /// Offsets (x, y) and coefficients, the centre first. They sum to zero.
    ///
    /// ```
    /// use boscage::solve::Stencil;
    /// for stencil in [Stencil::Laplacian, Stencil::Bilaplacian] {
    ///     assert_eq!(stencil.entries().iter().map(|entry| entry.2).sum::<f64>(), 0.0);
    /// }
    /// ```
    pub fn entries(self) -> &'static [(i32, i32, f64)] {
        match self {
            Self::Laplacian => &[
                (0, 0, 4.0),
                (0, -1, -1.0),
                (-1, 0, -1.0),
                (1, 0, -1.0),
                (0, 1, -1.0),
            ],
            Self::Bilaplacian => &[
                (0, 0, 20.0),
                (0, -2, 1.0),
                (-1, -1, 2.0),
                (0, -1, -8.0),
                (1, -1, 2.0),
                (-2, 0, 1.0),
                (-1, 0, -8.0),
                (1, 0, -8.0),
                (2, 0, 1.0),
                (-1, 1, 2.0),
                (0, 1, -8.0),
                (1, 1, 2.0),
                (0, 2, 1.0),
            ],
        }
    }

    /// How far the stencil reaches along an axis, in pixels.
    pub fn radius(self) -> u32 {
        match self {
            Self::Laplacian => 1,
            Self::Bilaplacian => 2,
        }
    }
}

/// One unknown for each pixel of a mask, numbered row by row, and the stencil between them.
#[derive(Debug, Clone)]
pub struct GridSystem {
    stencil: Stencil,
    width: u32,
    height: u32,
    pixels: Vec<(u32, u32)>,
    /// Number of the unknown at each pixel of the frame with [`PAD`] around it.
    numbers: Vec<u32>,
}

impl GridSystem {
    /// The system whose unknowns are the pixels of `unknown`; there may be none.
    pub fn new(unknown: &Mask, stencil: Stencil) -> Self {
        let (width, height) = (unknown.width(), unknown.height());
        let stride = width as usize + 2 * PAD;
        let mut numbers = vec![NONE; stride * (height as usize + 2 * PAD)];
        let mut pixels = Vec::new();
        for y in 0..height {
            for (x, _) in unknown.row(y).iter().enumerate().filter(|(_, is)| **is) {
                numbers[(y as usize + PAD) * stride + x + PAD] = pixels.len() as u32;
                pixels.push((x as u32, y));
            }
        }
        Self {
            stencil,
            width,
            height,
            pixels,
            numbers,
        }
    }

    /// The operator.
    pub fn stencil(&self) -> Stencil {
        self.stencil
    }

    /// Number of unknowns.
    pub fn len(&self) -> usize {
        self.pixels.len()
    }

    /// Whether there is nothing to solve.
    pub fn is_empty(&self) -> bool {
        self.pixels.is_empty()
    }

    /// The pixel (x, y) of each unknown, row by row.
    pub fn pixels(&self) -> &[(u32, u32)] {
        &self.pixels
    }

    /// Columns and rows of the frame.
    pub fn size(&self) -> (u32, u32) {
        (self.width, self.height)
    }

    /// The number of the unknown at (x, y), if there is one.
    pub fn number(&self, x: i64, y: i64) -> Option<usize> {
        let inside = |value: i64, side: u32| (0..i64::from(side)).contains(&value);
        if !inside(x, self.width) || !inside(y, self.height) {
            return None;
        }
        let number = self.numbers[self.place(x as u32, y as u32)];
        (number != NONE).then_some(number as usize)
    }

    fn place(&self, x: u32, y: u32) -> usize {
        (y as usize + PAD) * self.stride() + x as usize + PAD
    }

    fn stride(&self) -> usize {
        self.width as usize + 2 * PAD
    }

    /// Steps through `numbers` for the entries of the stencil, and their coefficients.
    fn steps(&self) -> impl Iterator<Item = (isize, f64)> + Clone + '_ {
        let stride = self.stride() as isize;
        let entries = self.stencil.entries().iter();
        entries.map(move |&(dx, dy, c)| (dy as isize * stride + dx as isize, c))
    }

    /// Row `unknown` of the matrix: (unknown, coefficient), the diagonal first.
    pub(super) fn row(&self, unknown: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let (x, y) = self.pixels[unknown];
        let place = self.place(x, y);
        self.steps().filter_map(move |(step, c)| {
            let number = self.numbers[place.wrapping_add_signed(step)];
            (number != NONE).then_some((number as usize, c))
        })
    }

    /// The matrix times `x`, one value an unknown.
    pub fn product(&self, x: &[f64]) -> Vec<f64> {
        assert_eq!(x.len(), self.len(), "one value an unknown");
        (0..self.len())
            .map(|i| self.row(i).map(|(j, c)| c * x[j]).sum())
            .collect()
    }

    /// Moves the known `value` of the pixel (x, y), which is no unknown, to the right-hand side:
    /// takes its coefficient times the value from each unknown that the stencil joins to it.
    pub fn spread(&self, x: i64, y: i64, value: f64, right: &mut [f64]) {
        for &(dx, dy, c) in self.stencil.entries() {
            if let Some(unknown) = self.number(x + i64::from(dx), y + i64::from(dy)) {
                right[unknown] -= c * value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    #[test]
    fn rows_far_from_the_border_annihilate_constants() {
        let mask = Image::filled(5, 5, true);
        for stencil in [Stencil::Laplacian, Stencil::Bilaplacian] {
            let system = GridSystem::new(&mask, stencil);
            assert_eq!(system.product(&[1.0; 25])[12], 0.0);
        }
    }

    #[test]
    fn the_bilaplacian_is_the_laplacian_twice() {
        let system = GridSystem::new(&Image::filled(9, 9, true), Stencil::Laplacian);
        let mut point = vec![0.0; 81];
        point[40] = 1.0;
        let twice = system.product(&system.product(&point));
        let square = GridSystem::new(&Image::filled(9, 9, true), Stencil::Bilaplacian);
        assert_eq!(square.product(&point), twice);
    }

    #[test]
    fn known_values_go_to_the_right_hand_side() {
        let mask = Image::from_pixels(2, 1, vec![true, false]);
        let system = GridSystem::new(&mask, Stencil::Laplacian);
        let mut right = vec![0.0];
        system.spread(1, 0, 3.0, &mut right);
        system.spread(-1, 0, 1.0, &mut right);
        assert_eq!(right, [4.0]);
    }
}
