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
        let (column, row) = (x.floor(), y.floor());
        let smooth = |t: f64| t * t * (3.0 - 2.0 * t);
        let (s, t) = (smooth(x - column), smooth(y - row));
        let knot = |dx: i64, dy: i64| {
            let (x, y) = (column as i64 + dx, row as i64 + dy);
            let place = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
                ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
            Seed(self.salt ^ place).random().unit()
        };
        let upper = knot(0, 0) + (knot(1, 0) - knot(0, 0)) * s;
        let lower = knot(0, 1) + (knot(1, 1) - knot(0, 1)) * s;
        upper + (lower - upper) * t
    }
}
