//! The three points that match on all trees: foot, and where the trunk enters the crown.

use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// Indices into a contour of its pin points (TV §4.4). All three are equal when no trunk shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Pins {
    /// B, the foot of the tree.
    pub bottom: usize,
    /// L, where the left side of the trunk meets the crown.
    pub left: usize,
    /// R, where the right side of the trunk meets the crown.
    pub right: usize,
}

impl Pins {
    /// Pins of a tree whose outline is all crown.
    pub fn without_trunk(bottom: usize) -> Self {
        Self {
            bottom,
            left: bottom,
            right: bottom,
        }
    }

    /// Whether a trunk shows.
    pub fn has_trunk(&self) -> bool {
        self.left != self.bottom && self.right != self.bottom
    }
}

/// Pins that somebody set by hand, where the segmenter erred: shares of the sides of the picture, 0 … 1
/// from left and top.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HandPins {
    /// B.
    pub bottom: [f64; 2],
    /// L.
    pub left: [f64; 2],
    /// R.
    pub right: [f64; 2],
}

impl HandPins {
    /// Whether all lie in the picture.
    pub fn is_sound(&self) -> bool {
        let all = [self.bottom, self.left, self.right];
        all.as_flattened()
            .iter()
            .all(|share| (0.0..=1.0).contains(share))
    }

    /// The points of `contour`, which runs counter-clockwise as seen on screen in a square picture of
    /// `size` pixels, that are nearest to them. L and R change places where a walk from B meets L
    /// first; two pins at one point are a tree without a trunk.
    ///
    /// # Panics
    /// When `contour` is empty.
    pub fn on(&self, contour: &[Point], size: f64) -> Pins {
        let nearest = |[x, y]: [f64; 2]| {
            let place = Point::new(x, y) * size;
            let distance = |i: &usize| contour[*i].distance_squared(place);
            let nearest = (0..contour.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.expect("a contour has points")
        };
        let bottom = nearest(self.bottom);
        let from_bottom = |i: usize| (i + contour.len() - bottom) % contour.len();
        let mut sides = [nearest(self.right), nearest(self.left)];
        sides.sort_by_key(|side| from_bottom(*side));
        let [right, left] = sides;
        if right == bottom || left == right {
            return Pins::without_trunk(bottom);
        }
        Pins {
            bottom,
            left,
            right,
        }
    }
}

/// The pins of `contour`, which runs counter-clockwise as seen on screen.
///
/// B is the lowest point (of several the median one); L and R are the first points at or above the
/// crown's `baseline_y` that a walk from B meets clockwise and counter-clockwise.
///
/// `on_trunk` says which points of the contour belong to the trunk. Departure from the paper: when
/// branches hang lower than the trunk's foot, B is the lowest point *of the trunk*, or a weeping
/// willow would stand on the tip of a twig. Likewise L and R stay at the trunk when a branch that
/// hangs below the baseline leads the walk away from it: then they are the last points of the trunk
/// on the way. Without a trunk (`baseline_y` is `None` or below B) L = R = B.
///
/// # Panics
/// When `contour` is empty.
pub fn pins(contour: &[Point], baseline_y: Option<f64>, on_trunk: impl Fn(Point) -> bool) -> Pins {
    let trunk: Vec<usize> = match baseline_y {
        Some(_) => (0..contour.len())
            .filter(|&i| on_trunk(contour[i]))
            .collect(),
        None => Vec::new(),
    };
    let all: Vec<usize> = (0..contour.len()).collect();
    let bottom = lowest(contour, if trunk.is_empty() { &all } else { &trunk });
    match baseline_y {
        Some(baseline_y) if contour[bottom].y > baseline_y => {
            let count = contour.len();
            let forward = (1..count).map(|step| (bottom + step) % count);
            let backward = (1..count).map(|step| (bottom + count - step) % count);
            let right = trunk_top(contour, forward, baseline_y, &on_trunk);
            let left = trunk_top(contour, backward, baseline_y, &on_trunk);
            match (right, left) {
                (Some(right), Some(left)) if left != right && left != bottom && right != bottom => {
                    Pins {
                        bottom,
                        left,
                        right,
                    }
                }
                _ => Pins::without_trunk(bottom),
            }
        }
        _ => Pins::without_trunk(bottom),
    }
}

/// How far the contour may have left the trunk when it crosses the baseline, as a share of the
/// trunk's height: labels end a few pixels early, a twig or a hanging branch reaches further and
/// would bulge the trunk of every mix.
const LARGEST_FLARE: f64 = 0.04;

/// Where a walk up one side of the trunk enters the crown.
fn trunk_top(
    contour: &[Point],
    walk: impl Iterator<Item = usize>,
    baseline_y: f64,
    on_trunk: &impl Fn(Point) -> bool,
) -> Option<usize> {
    let mut last_on_trunk = None;
    let mut foot_y: Option<f64> = None;
    for index in walk {
        let point = contour[index];
        let height = foot_y.get_or_insert(point.y).max(point.y) - baseline_y;
        if point.y <= baseline_y {
            let nearest = last_on_trunk.unwrap_or(index);
            let strayed = contour[nearest].distance(point) > LARGEST_FLARE * height + 3.0;
            return Some(if strayed { nearest } else { index });
        }
        if on_trunk(point) {
            last_on_trunk = Some(index);
        }
    }
    None
}

/// Of `candidates` the one with the largest y; of several the median in the order of the contour.
fn lowest(contour: &[Point], candidates: &[usize]) -> usize {
    let y = candidates
        .iter()
        .map(|&i| contour[i].y)
        .fold(f64::NEG_INFINITY, f64::max);
    let lowest: Vec<usize> = candidates
        .iter()
        .copied()
        .filter(|&i| contour[i].y == y)
        .collect();
    lowest[lowest.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mushroom: crown from y = 0 to 2, trunk from y = 3 to 5 at x = 2..=3.
    fn mushroom() -> Vec<Point> {
        [
            (2, 5),
            (3, 5),
            (3, 4),
            (3, 3),
            (4, 2),
            (5, 2),
            (5, 1),
            (4, 0),
            (3, 0),
            (2, 0),
            (1, 0),
            (0, 1),
            (0, 2),
            (1, 2),
            (2, 3),
            (2, 4),
        ]
        .map(|(x, y)| Point::new(f64::from(x), f64::from(y)))
        .to_vec()
    }

    #[test]
    fn the_trunk_is_pinned_at_the_baseline() {
        let contour = mushroom();
        let pins = pins(&contour, Some(2.0), |p| p.y > 2.0);
        assert_eq!(contour[pins.bottom].y, 5.0);
        assert_eq!(contour[pins.right], Point::new(4.0, 2.0));
        assert_eq!(contour[pins.left], Point::new(1.0, 2.0));
        assert!(pins.has_trunk());
    }

    #[test]
    fn pins_set_by_hand_are_the_nearest_points_in_their_order() {
        let contour = mushroom();
        let by_hand = HandPins {
            bottom: [0.27, 0.49],
            left: [0.42, 0.21],
            right: [0.08, 0.2],
        };
        // L and R were taken for one another.
        let pins = by_hand.on(&contour, 10.0);
        assert_eq!(contour[pins.bottom], Point::new(3.0, 5.0));
        assert_eq!(contour[pins.right], Point::new(4.0, 2.0));
        assert_eq!(contour[pins.left], Point::new(1.0, 2.0));
        let together = HandPins {
            left: by_hand.right,
            ..by_hand
        };
        assert!(!together.on(&contour, 10.0).has_trunk());
        assert!(by_hand.is_sound());
        let outside = HandPins {
            bottom: [0.2, f64::NAN],
            ..by_hand
        };
        assert!(!outside.is_sound());
    }

    #[test]
    fn without_a_trunk_all_pins_are_the_foot() {
        let contour = mushroom();
        for baseline_y in [None, Some(5.0), Some(9.0)] {
            let pins = pins(&contour, baseline_y, |_| false);
            assert_eq!((pins.left, pins.right), (pins.bottom, pins.bottom));
        }
    }

    #[test]
    fn a_hanging_branch_does_not_lead_the_pin_away() {
        let mut contour = mushroom();
        // Right of the trunk the crown hangs down to y = 4 before it rises.
        contour.splice(
            4..4,
            [(9, 4), (30, 4), (30, 1)].map(|(x, y)| Point::new(f64::from(x), f64::from(y))),
        );
        let pins = pins(&contour, Some(2.0), |p| p.y > 2.0 && p.x < 4.0);
        assert_eq!(contour[pins.right], Point::new(3.0, 3.0));
        assert_eq!(contour[pins.left], Point::new(1.0, 2.0));
    }

    #[test]
    fn a_branch_below_the_foot_is_not_the_foot() {
        let mut contour = mushroom();
        contour[5] = Point::new(5.0, 9.0);
        let pins = pins(&contour, Some(2.0), |p| p.y > 2.0 && p.x < 4.0);
        assert_eq!(contour[pins.bottom].y, 5.0);
    }
}
