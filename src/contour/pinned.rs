//! Contours of a fixed number of points that correspond between trees.

use super::Pins;
use crate::geometry::{Point, equal_chords};
use serde::{Deserialize, Serialize};

/// Share of the points that each side of the trunk gets: 200 of 2,000 (TV §4.5).
pub const TRUNK_SHARE: f64 = 0.1;

/// Share of the points that the crown gets: 1,600 of 2,000 (TV §4.5).
pub const CROWN_SHARE: f64 = 0.8;

/// Share of the points of a trunk's side that lie under its foot, see
/// [`PinnedContour::with_feet`]: 3 of the 10 that a cage has there.
pub const FOOT_SHARE: f64 = 0.3;

/// A contour resampled between its pins: point i of one tree matches point i of every other.
///
/// Order: B, right side of the trunk up to R, crown from R over the top to L, left side of the
/// trunk down to B; counter-clockwise as seen on screen. Inside each of the three parts the points
/// are equally far apart (straight-line distance, to 1 %).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PinnedContour {
    /// The points; the first is B.
    pub points: Vec<Point>,
    /// Indices of B (always 0), L and R in `points`.
    pub pins: Pins,
}

impl PinnedContour {
    /// `contour` (counter-clockwise as seen on screen) as `count` points.
    ///
    /// A tree without a trunk gives all points to the crown, as the paper has it. Combined with a
    /// tree that has one, crown points then match trunk points: random choice avoids such pairs.
    pub fn resampled(contour: &[Point], pins: Pins, count: usize) -> Self {
        if !pins.has_trunk() {
            let points = equal_chords(&arc(contour, pins.bottom, pins.bottom), count);
            return Self {
                points,
                pins: Pins::without_trunk(0),
            };
        }
        let side = ((count as f64 * TRUNK_SHARE).round() as usize).max(1);
        let crown = count - 2 * side;
        let mut points = equal_chords(&arc(contour, pins.bottom, pins.right), side);
        points.extend(equal_chords(&arc(contour, pins.right, pins.left), crown));
        points.extend(equal_chords(&arc(contour, pins.left, pins.bottom), side));
        Self {
            points,
            pins: Pins {
                bottom: 0,
                left: side + crown,
                right: side,
            },
        }
    }

    /// Like [`PinnedContour::resampled`], with the corners of the trunk's foot among the points:
    /// [`FOOT_SHARE`] of each side goes from B to the corner, the rest up the trunk.
    ///
    /// Departure from the paper: with a hundred points a corner is met at another index on a short
    /// trunk than on a tall one, and every combination of the two stands on a point.
    pub fn with_feet(contour: &[Point], pins: Pins, count: usize) -> Self {
        let mut resampled = Self::resampled(contour, pins, count);
        let side = resampled.pins.right;
        let foot = (side as f64 * FOOT_SHARE).round() as usize;
        if !pins.has_trunk() || foot == 0 {
            return resampled;
        }
        let right = arc(contour, pins.bottom, pins.right);
        let left = arc(contour, pins.left, pins.bottom);
        if let Some(corner) = corner(&right, |p| p.x + p.y) {
            let mut points = equal_chords(&right[..=corner], foot);
            points.extend(equal_chords(&right[corner..], side - foot));
            resampled.points[..side].copy_from_slice(&points);
        }
        if let Some(corner) = corner(&left, |p| p.y - p.x) {
            let mut points = equal_chords(&left[..=corner], side - foot);
            points.extend(equal_chords(&left[corner..], foot));
            resampled.points[count - side..].copy_from_slice(&points);
        }
        resampled
    }

    /// The contour Σ wᵢ·cᵢ of several contours of the same number of points (TV §5.1); its pins
    /// are those of the first one that has a trunk.
    ///
    /// # Panics
    /// When there are none, or they differ in their number of points.
    pub fn combined(parts: &[(&Self, f64)]) -> Self {
        let count = parts[0].0.points.len();
        let mut points = vec![Point::ZERO; count];
        for (contour, weight) in parts {
            assert_eq!(contour.points.len(), count, "contours of one space");
            for (sum, point) in points.iter_mut().zip(&contour.points) {
                *sum += *point * *weight;
            }
        }
        let with_trunk = parts.iter().find(|(contour, _)| contour.pins.has_trunk());
        Self {
            points,
            pins: with_trunk.unwrap_or(&parts[0]).0.pins,
        }
    }

    /// Point B, the foot.
    pub fn bottom(&self) -> Point {
        self.points[self.pins.bottom]
    }

    /// Point L, where the left side of the trunk meets the crown.
    pub fn left(&self) -> Point {
        self.points[self.pins.left]
    }

    /// Point R, where the right side of the trunk meets the crown.
    pub fn right(&self) -> Point {
        self.points[self.pins.right]
    }
}

/// Index of the point of `path` that lies furthest out; `None` when that is one of its ends.
fn corner(path: &[Point], outwards: impl Fn(Point) -> f64) -> Option<usize> {
    let furthest =
        (0..path.len()).max_by(|&a, &b| outwards(path[a]).total_cmp(&outwards(path[b])))?;
    (0 < furthest && furthest + 1 < path.len()).then_some(furthest)
}

/// The part of a closed contour from index `from` to index `to`, both included; the whole of it,
/// closed, when they are equal.
fn arc(contour: &[Point], from: usize, to: usize) -> Vec<Point> {
    let count = contour.len();
    let steps = if from == to {
        count
    } else {
        (to + count - from) % count
    };
    (0..=steps)
        .map(|step| contour[(from + step) % count])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Point> {
        [(0.0, 8.0), (4.0, 8.0), (4.0, 0.0), (-4.0, 0.0), (-4.0, 8.0)]
            .map(Point::from)
            .to_vec()
    }

    #[test]
    fn parts_get_their_share_and_start_at_their_pins() {
        let pins = Pins {
            bottom: 0,
            right: 1,
            left: 4,
        };
        let contour = PinnedContour::resampled(&square(), pins, 100);
        assert_eq!(contour.points.len(), 100);
        assert_eq!(contour.bottom(), Point::new(0.0, 8.0));
        assert_eq!(contour.right(), Point::new(4.0, 8.0));
        assert_eq!(contour.left(), Point::new(-4.0, 8.0));
        assert_eq!((contour.pins.right, contour.pins.left), (10, 90));
    }

    #[test]
    fn the_corners_of_the_foot_are_kept() {
        // A trunk of 8 by 20 under a crown of 40 by 20.
        let outline = [
            (0.0, 40.0),
            (4.0, 40.0),
            (4.0, 20.0),
            (20.0, 20.0),
            (20.0, 0.0),
            (-20.0, 0.0),
            (-20.0, 20.0),
            (-4.0, 20.0),
            (-4.0, 40.0),
        ]
        .map(Point::from);
        let pins = Pins {
            bottom: 0,
            right: 2,
            left: 7,
        };
        let contour = PinnedContour::with_feet(&outline, pins, 100);
        assert_eq!(contour.points.len(), 100);
        assert_eq!(contour.points[3], Point::new(4.0, 40.0));
        assert_eq!(contour.points[97], Point::new(-4.0, 40.0));
        assert_eq!(contour.right(), Point::new(4.0, 20.0));
    }

    #[test]
    fn without_trunk_all_points_go_round_the_crown() {
        let contour = PinnedContour::resampled(&square(), Pins::without_trunk(0), 64);
        assert_eq!(contour.points.len(), 64);
        let chords: Vec<f64> = contour
            .points
            .windows(2)
            .map(|pair| pair[0].distance(pair[1]))
            .collect();
        assert!(
            chords
                .iter()
                .all(|chord| (chord / chords[0] - 1.0).abs() < 0.01)
        );
    }

    #[test]
    fn combining_with_weight_one_changes_nothing() {
        let one = PinnedContour::resampled(&square(), Pins::without_trunk(0), 20);
        let other = PinnedContour::resampled(&square(), Pins::without_trunk(3), 20);
        assert_eq!(PinnedContour::combined(&[(&one, 1.0), (&other, 0.0)]), one);
    }
}
