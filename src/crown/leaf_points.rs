//! Where the leaves of a crown are: points of the unit ball, ordered so that any first few of them
//! cover it well.
//!
//! Source: the thesis, §5.2. Each cell of the first levels of an octree over the ball gives a point,
//! its centre moved at random by up to the cell's side along each axis; what leaves the ball is
//! dropped.
//!
//! Departures. The thesis puts next the point with the largest sum of distances to those before,
//! which takes points of the hull first and neighbours among them; we take the one that is farthest
//! from its nearest predecessor (Gonzalez 1985), which makes every beginning of the list a
//! blue-noise set. Three levels give the thesis' 320 points; a fourth is there for close views.

use crate::base::{Random, Seed};
use glam::DVec3;

/// Points that the thesis draws: those of three levels.
pub const LEAF_POINTS: usize = 320;

/// Levels of the octree that candidates are taken from. The last one has four times as many points
/// as are ever used: there is something to choose from.
const LEVELS: u32 = 4;

/// The `count` first points of the unit ball, best prefix first.
///
/// Fewer when there are not as many candidates: about 2,400.
///
/// ```
/// use boscage::{base::Seed, crown::{leaf_points, LEAF_POINTS}};
/// let points = leaf_points(LEAF_POINTS, Seed(1));
/// assert_eq!(points.len(), 320);
/// assert!(points.iter().all(|point| point.length() <= 1.0));
/// assert_eq!(leaf_points(50, Seed(1)), points[..50]);
/// ```
pub fn leaf_points(count: usize, seed: Seed) -> Vec<DVec3> {
    let candidates = candidates(seed);
    let mut nearest = vec![f64::INFINITY; candidates.len()];
    let mut points = Vec::with_capacity(count.min(candidates.len()));
    let mut next = 0;
    for _ in 0..count.min(candidates.len()) {
        let point = candidates[next];
        points.push(point);
        let mut farthest = -1.0;
        for (index, (candidate, nearest)) in candidates.iter().zip(&mut nearest).enumerate() {
            *nearest = nearest.min(point.distance_squared(*candidate));
            if *nearest > farthest {
                farthest = *nearest;
                next = index;
            }
        }
    }
    points
}

/// The moved centres of all cells, coarse ones first, that lie in the unit ball.
fn candidates(seed: Seed) -> Vec<DVec3> {
    let mut random = seed.derive("leaf points", 0).random();
    let mut points = Vec::new();
    for level in 1..=LEVELS {
        let cells = 1u32 << level;
        let side = 2.0 / f64::from(cells);
        for cell in 0..cells * cells * cells {
            let index = [cell % cells, cell / cells % cells, cell / cells / cells];
            let centre = DVec3::from(index.map(|i| (f64::from(i) + 0.5) * side - 1.0));
            let point = centre + moved(&mut random, side);
            if point.length_squared() <= 1.0 {
                points.push(point);
            }
        }
    }
    points
}

/// A random step of up to `side` along each axis.
fn moved(random: &mut Random, side: f64) -> DVec3 {
    DVec3::from([(); 3].map(|()| random.between(-side, side)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spacing(points: &[DVec3]) -> f64 {
        let nearest = |i: usize| {
            let others = points.iter().enumerate().filter(|(j, _)| *j != i);
            let distances = others.map(|(_, other)| points[i].distance(*other));
            distances.fold(f64::INFINITY, f64::min)
        };
        (0..points.len()).map(nearest).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn every_beginning_is_spread_out() {
        let points = leaf_points(1280, Seed(3));
        assert_eq!(points.len(), 1280);
        for count in [10usize, 40, 160, 320, 1280] {
            // A dense packing of balls has a spacing of 1.8 n^(-1/3).
            let ideal = 1.8 / (count as f64).cbrt();
            let found = spacing(&points[..count]);
            assert!(found > 0.5 * ideal, "{count}: {found} of {ideal}");
        }
    }

    #[test]
    fn all_of_the_ball_is_covered() {
        let points = leaf_points(LEAF_POINTS, Seed(0));
        let mut octants = [0; 8];
        for point in &points {
            let bit = |x: f64| usize::from(x > 0.0);
            octants[bit(point.x) + 2 * bit(point.y) + 4 * bit(point.z)] += 1;
        }
        assert!(
            octants.iter().all(|&count| (28..=52).contains(&count)),
            "{octants:?}"
        );
    }
}
