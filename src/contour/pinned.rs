//! Contours of a fixed number of points that correspond between trees.

use super::Pins;
use crate::geometry::{Point, equal_chords};
use serde::{Deserialize, Serialize};

/// Share of the points that each side of the trunk gets: 200 of 2,000 (TV §4.5).
pub const TRUNK_SHARE: f64 = 0.1;

/// Share of the points that the crown gets: 1,600 of 2,000 (TV §4.5).
pub const CROWN_SHARE: f64 = 0.8;

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
