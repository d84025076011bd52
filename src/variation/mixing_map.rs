//! A map to mix exemplars on: they stand on the corners of a regular polygon, and a point between them
//! says how much of each.
//!
//! The weights are the point's mean value coordinates (see [`super::coordinates`]): on a corner that
//! exemplar alone, on an edge its two ends, in the middle all alike. They reproduce the point, so the
//! map needs no memory: [`MixingMap::point`] finds it again from the weights.
//!
//! Limits: with more than a handful of corners a point inside always mixes all of them.

use super::mean_value::{Cage, coordinates};
use crate::geometry::Point;

/// The map of a number of exemplars, within the unit circle; y points down, the first corner up.
#[derive(Debug, Clone, PartialEq)]
pub struct MixingMap {
    corners: Vec<Point>,
}

impl MixingMap {
    /// The map of `count` exemplars; two stand left and right.
    pub fn new(count: usize) -> Self {
        let turn = if count == 2 { 0.5 } else { 0.25 };
        let corner = |index: usize| {
            let share = index as f64 / count as f64 - turn;
            let angle = std::f64::consts::TAU * share;
            Point::new(libm::cos(angle), libm::sin(angle))
        };
        Self {
            corners: (0..count).map(corner).collect(),
        }
    }

    /// Where the exemplars stand.
    pub fn corners(&self) -> &[Point] {
        &self.corners
    }

    /// Where the given weights lie; the middle when all are 0.
    ///
    /// # Panics
    /// When there is not one weight for each corner.
    pub fn point(&self, weights: &[f64]) -> Point {
        assert_eq!(weights.len(), self.corners.len(), "one for each corner");
        let sum: f64 = weights.iter().sum();
        if sum <= 0.0 {
            return Point::ZERO;
        }
        let weighted = self.corners.iter().zip(weights);
        weighted
            .map(|(corner, weight)| *corner * (weight / sum))
            .sum()
    }

    /// The weights of the point of the map nearest to `point`: not negative, of sum 1.
    pub fn weights(&self, point: Point) -> Vec<f64> {
        match self.corners.as_slice() {
            [] => Vec::new(),
            [_] => vec![1.0],
            [a, b] => {
                let share = (point - *a).dot(*b - *a) / a.distance_squared(*b);
                let share = share.clamp(0.0, 1.0);
                vec![1.0 - share, share]
            }
            corners => {
                let cage = Cage::new(std::slice::from_ref(&corners.to_vec()));
                let cage = cage.unwrap_or_else(|_| unreachable!("a regular polygon has an area"));
                let weights = coordinates(&cage, nearest_inside(corners, point));
                let weights: Vec<f64> = weights.iter().map(|weight| weight.max(0.0)).collect();
                let sum: f64 = weights.iter().sum();
                weights.iter().map(|weight| weight / sum).collect()
            }
        }
    }
}

/// The point of the convex polygon `corners` that is nearest to `point`.
fn nearest_inside(corners: &[Point], point: Point) -> Point {
    let edges = || {
        let next = corners.iter().cycle().skip(1);
        corners.iter().copied().zip(next.copied())
    };
    // The corners run clockwise on screen (y down), so the inside lies to the same side of all.
    let is_inside = edges().all(|(a, b)| (b - a).perp_dot(point - a) >= 0.0);
    if is_inside {
        return point;
    }
    let on_edge = |(a, b): (Point, Point)| {
        let share = (point - a).dot(b - a) / a.distance_squared(b);
        a + (b - a) * share.clamp(0.0, 1.0)
    };
    let distance = |candidate: &Point| candidate.distance_squared(point);
    edges()
        .map(on_edge)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap_or(point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn corners_give_one_exemplar_and_the_middle_all() {
        for count in 1..9 {
            let map = MixingMap::new(count);
            for (index, corner) in map.corners().iter().enumerate() {
                let weights = map.weights(*corner);
                assert!((weights[index] - 1.0).abs() < 1e-9, "{count}: {weights:?}");
            }
            for weight in map.weights(Point::ZERO) {
                assert!((weight - 1.0 / count as f64).abs() < 1e-9);
            }
        }
    }

    proptest! {
        #[test]
        fn weights_are_convex_and_lead_back_to_the_point(
            count in 1usize..9, x in -2.0..2.0f64, y in -2.0..2.0f64,
        ) {
            let map = MixingMap::new(count);
            let weights = map.weights(Point::new(x, y));
            prop_assert!(weights.iter().all(|weight| *weight >= 0.0));
            prop_assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
            let on_map = map.point(&weights);
            let again = map.weights(on_map);
            for (a, b) in weights.iter().zip(&again) {
                prop_assert!((a - b).abs() < 1e-6, "{weights:?} {again:?}");
            }
        }
    }
}
