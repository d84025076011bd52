//! How much a warp stretches and folds the picture that it pulls into a new shape.
//!
//! Measured on the Jacobian of the map from target to source pixels, by central differences on a
//! coarse grid inside the target's outline. Folds (a determinant that is not positive) show as
//! mirrored fans, strong stretching as smeared leaves (Argudo, Andújar & Chica 2017, *Tree
//! Variations*, Fig. 15).

use super::mean_value::{LANES, Lanes};
use super::warp::Warp;
use crate::geometry::Point;
use serde::{Deserialize, Serialize};

/// Samples across the side of the target's bounding box: 40 find every fold that is larger than
/// 2.5 % of the tree, and cost half a millisecond.
const SAMPLES_ACROSS: usize = 40;

/// Distance of the points of a central difference from its centre, in pixels.
const DIFFERENCE_PX: f32 = 2.0;

/// Part of the samples that [`Distortion::stretch`] leaves out as outliers: near the cage's
/// vertices single samples say nothing.
const OUTLIERS: f64 = 0.05;

/// What a warp does to a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Distortion {
    /// Share of the tree's area, 0 to 1, where the map turns the picture over.
    pub folded: f64,
    /// How many times longer or shorter a leaf gets in its worst direction, compared with the
    /// tree as a whole, in all but the worst 5 % of the area; 1 is none.
    pub stretch: f64,
    /// The same at the median of the area.
    pub stretch_median: f64,
    /// Share of the area, 0 to 1, where a leaf gets more than three times as long as wide.
    pub smeared: f64,
}

impl Distortion {
    /// No distortion at all.
    pub const NONE: Self = Self {
        folded: 0.0,
        stretch: 1.0,
        stretch_median: 1.0,
        smeared: 0.0,
    };

    /// The distortion of `warp` inside the closed outline `contour` of the target.
    pub fn of(warp: &Warp, contour: &[Point]) -> Self {
        Self::within(warp, &[contour])
    }

    /// The distortion of `warp` inside the first of `polygons` and outside of the others, its gaps.
    pub(super) fn within(warp: &Warp, polygons: &[&[Point]]) -> Self {
        Self::summed_up(&jacobians(warp, &sample_points(polygons)))
    }

    /// The worse of the two in every respect.
    #[must_use]
    pub fn worst(self, other: Self) -> Self {
        Self {
            folded: self.folded.max(other.folded),
            stretch: self.stretch.max(other.stretch),
            stretch_median: self.stretch_median.max(other.stretch_median),
            smeared: self.smeared.max(other.smeared),
        }
    }

    /// The distortion of a map with these derivatives, [∂x/∂x′, ∂x/∂y′, ∂y/∂x′, ∂y/∂y′], at places of
    /// equal area.
    pub(super) fn summed_up(jacobians: &[[f64; 4]]) -> Self {
        if jacobians.is_empty() {
            return Self::NONE;
        }
        let count = jacobians.len() as f64;
        let values: Vec<(f64, f64)> = jacobians.iter().map(|j| singular_values(*j)).collect();
        let folded = jacobians
            .iter()
            .filter(|j| j[0] * j[3] - j[1] * j[2] <= 0.0)
            .count();
        let smeared = values
            .iter()
            .filter(|(large, small)| *large > 3.0 * small)
            .count();
        // A tree that is larger than its exemplar as a whole is not distorted by that.
        let mut areas: Vec<f64> = values.iter().map(|(large, small)| large * small).collect();
        areas.sort_by(f64::total_cmp);
        let scale = areas[areas.len() / 2].sqrt().max(1e-6);
        let mut stretches: Vec<f64> = values
            .iter()
            .map(|(large, small)| (large / scale).max(scale / small.max(1e-6)))
            .collect();
        stretches.sort_by(f64::total_cmp);
        let quantile = |q: f64| stretches[((stretches.len() - 1) as f64 * q) as usize];
        Self {
            folded: folded as f64 / count,
            stretch: quantile(1.0 - OUTLIERS),
            stretch_median: quantile(0.5),
            smeared: smeared as f64 / count,
        }
    }
}

/// The points of a regular grid over the first of `polygons` that are inside of them, by the even–odd
/// rule.
pub(super) fn sample_points(polygons: &[&[Point]]) -> Vec<Point> {
    let contour = polygons.first().copied().unwrap_or_default();
    let low = contour
        .iter()
        .copied()
        .reduce(Point::min)
        .unwrap_or_default();
    let high = contour
        .iter()
        .copied()
        .reduce(Point::max)
        .unwrap_or_default();
    let step = ((high - low).max_element() / SAMPLES_ACROSS as f64).max(1.0);
    let columns = ((high.x - low.x) / step) as usize + 1;
    let rows = ((high.y - low.y) / step) as usize + 1;
    let mut points = Vec::new();
    for row in 0..rows {
        let y = low.y + (row as f64 + 0.5) * step;
        let crossings: Vec<f64> = polygons.iter().flat_map(|p| crossings(p, y)).collect();
        for column in 0..columns {
            let x = low.x + (column as f64 + 0.5) * step;
            let right = crossings.iter().filter(|&&crossing| x < crossing).count();
            if right % 2 == 1 {
                points.push(Point::new(x, y));
            }
        }
    }
    points
}

/// Where the closed `contour` crosses the horizontal line at `y`.
fn crossings(contour: &[Point], y: f64) -> Vec<f64> {
    let edges = contour.iter().zip(contour.iter().cycle().skip(1));
    edges
        .filter(|(a, b)| (a.y > y) != (b.y > y))
        .map(|(a, b)| (b.x - a.x) * (y - a.y) / (b.y - a.y) + a.x)
        .collect()
}

/// [∂x/∂x′, ∂x/∂y′, ∂y/∂x′, ∂y/∂y′] at each of `points`.
fn jacobians(warp: &Warp, points: &[Point]) -> Vec<[f64; 4]> {
    const OFFSETS: [(f32, f32); 4] = [
        (-DIFFERENCE_PX, 0.0),
        (DIFFERENCE_PX, 0.0),
        (0.0, -DIFFERENCE_PX),
        (0.0, DIFFERENCE_PX),
    ];
    // The four ends of both central differences of a quarter of LANES points.
    let groups = points.chunks(LANES / 4);
    let mut ends: Vec<(Lanes, Lanes)> = groups
        .map(|group| {
            let centre = |lane: usize| group[(lane / 4).min(group.len() - 1)];
            (
                std::array::from_fn(|lane| centre(lane).x as f32 + OFFSETS[lane % 4].0),
                std::array::from_fn(|lane| centre(lane).y as f32 + OFFSETS[lane % 4].1),
            )
        })
        .collect();
    warp.map(&mut ends);
    let slope = |values: &Lanes, lane: usize| {
        f64::from(values[lane + 1] - values[lane]) / f64::from(2.0 * DIFFERENCE_PX)
    };
    (0..points.len())
        .map(|index| {
            let (x, y) = &ends[index / (LANES / 4)];
            let lane = index % (LANES / 4) * 4;
            [
                slope(x, lane),
                slope(x, lane + 2),
                slope(y, lane),
                slope(y, lane + 2),
            ]
        })
        .collect()
}

/// The larger and the smaller singular value of the matrix [a, b; c, d].
fn singular_values([a, b, c, d]: [f64; 4]) -> (f64, f64) {
    let sum = Point::new(a + d, b - c).length();
    let difference = Point::new(a - d, b + c).length();
    ((sum + difference) / 2.0, (sum - difference).abs() / 2.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variation::Cage;

    fn rectangle(width: f64, height: f64) -> Cage {
        let corners = [(0.0, height), (width, height), (width, 0.0), (0.0, 0.0)];
        Cage::new(&[corners.map(Point::from).to_vec()]).unwrap()
    }

    #[test]
    fn a_larger_copy_is_not_distorted() {
        let (target, source) = (rectangle(100.0, 200.0), rectangle(50.0, 100.0));
        let warp = Warp::new(&target, &source, 1).unwrap();
        let found = Distortion::of(&warp, target.points());
        assert!(found.stretch < 1.01, "{found:?}");
        assert_eq!((found.folded, found.smeared), (0.0, 0.0));
    }

    #[test]
    fn pulling_one_way_stretches() {
        let (target, source) = (rectangle(400.0, 100.0), rectangle(100.0, 100.0));
        let warp = Warp::new(&target, &source, 1).unwrap();
        let found = Distortion::of(&warp, target.points());
        // Four times as wide: √4 to either side of the tree as a whole.
        assert!((found.stretch - 2.0).abs() < 0.05, "{found:?}");
        assert!(found.smeared > 0.9);
    }

    #[test]
    fn a_mirrored_cage_is_all_fold() {
        let target = rectangle(100.0, 100.0);
        let mirrored = target
            .points()
            .iter()
            .map(|p| Point::new(100.0 - p.x, p.y))
            .collect();
        let warp = Warp::new(&target, &target.moved(mirrored).unwrap(), 1).unwrap();
        assert!(Distortion::of(&warp, target.points()).folded > 0.99);
    }
}
