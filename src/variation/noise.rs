//! Smooth noise for what changes from clump to clump.

use crate::base::{Random, Seed};

/// Smooth noise in the plane, 0 to 1, that changes over a distance of about 1: value noise of a hashed
/// lattice.
pub(super) struct Noise {
    salt: u64,
}

impl Noise {
    pub(super) fn new(random: &mut Random) -> Self {
        Self {
            salt: random.bits(),
        }
    }

    pub(super) fn at(&self, [x, y]: [f64; 2]) -> f64 {
        self.row(y).at(x)
    }

    /// The noise along the row `y` of the plane.
    pub(super) fn row(&self, y: f64) -> Row<'_> {
        Row {
            noise: self,
            row: y.floor(),
            t: smooth(y - y.floor()),
            column: f64::NAN,
            knots: [[0.0; 2]; 2],
        }
    }

    fn knot(&self, x: i64, y: i64) -> f64 {
        let place = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
            ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
        Seed(self.salt ^ place).random().unit()
    }
}

/// Noise along a row: places that follow each other in one cell of the lattice share its knots.
pub(super) struct Row<'a> {
    noise: &'a Noise,
    row: f64,
    t: f64,
    column: f64,
    /// The knots of the cell, above and below, from the left.
    knots: [[f64; 2]; 2],
}

impl Row<'_> {
    pub(super) fn at(&mut self, x: f64) -> f64 {
        let column = x.floor();
        if column != self.column {
            self.column = column;
            let (left, top) = (column as i64, self.row as i64);
            self.knots = [0, 1].map(|dy| [0, 1].map(|dx| self.noise.knot(left + dx, top + dy)));
        }
        let s = smooth(x - column);
        let [upper, lower] = self.knots.map(|[left, right]| left + (right - left) * s);
        upper + (lower - upper) * self.t
    }
}

fn smooth(t: f64) -> f64 {
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_one_along_a_row_and_place_by_place() {
        let noise = Noise::new(&mut Seed(1).random());
        let mut row = noise.row(-3.3);
        for x in (-40..40).chain([-7, 12, 12]).map(|x| f64::from(x) * 0.37) {
            let value = row.at(x);
            assert_eq!(value, noise.at([x, -3.3]));
            assert!((0.0..=1.0).contains(&value));
            // No step between neighbours, also across the border of a cell.
            assert!((noise.at([x + 1e-6, -3.3]) - value).abs() < 1e-5);
        }
    }
}
