//! The distortion of a pair foreseen from outlines alone, in microseconds.
//!
//! *Idea.* Where a plain mean value map takes a point is linear in where the vertices of the cage go:
//! f(p) = Σ λₖ(p)·vₖ (see [`super::coordinates`]). So the derivative of the map, ∂f/∂p = Σ vₖ ⊗ ∇λₖ(p),
//! is a matrix of the exemplar's own cage times the vertices of the other's. [`Forecast::of`] keeps
//! ∇λ at some places inside an exemplar; each further exemplar costs one product with its cage.
//! Half way between two outlines the derivative is (1−t)·1 + t·J with t = ½, and seen from the other
//! end J is its inverse: one product foresees both directions.
//!
//! *Limits.* The real maps go in several steps and see the folds that a single step makes melt away;
//! what is foreseen is for putting pairs in order, not for measuring them. Nothing in it was fitted
//! to measured distortions. `tests/variations/compatibility.rs` prints how well the orders agree.

use super::distortion::{Distortion, sample_points};
use super::mean_value::{Cage, coordinates};
use super::{CageError, Shape};
use crate::base::{Kernel, with_level_of_cpu};
use crate::geometry::Point;

/// Places inside an exemplar at which its map is looked at: with half as many the order of the pairs
/// of real trees agrees less with the measured one, with twice as many no more.
const PLACES: usize = 96;

/// Distance of the points of a central difference from its centre, for pictures of 1,024 pixels.
const DIFFERENCE_AT_1024: f64 = 2.0;

/// One number for each place.
type AtPlaces = [f32; PLACES];

/// An exemplar from which the distortion of its pairs with others is foreseen.
#[derive(Debug, Clone)]
pub struct Forecast {
    /// For each vertex of the cage ∂λ/∂x and ∂λ/∂y at the places, per picture side.
    slopes: Vec<[AtPlaces; 2]>,
}

/// What a pair would do to the pictures of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foreseen {
    /// To the picture of the exemplar that looks.
    pub own: Distortion,
    /// To the picture of the other.
    pub other: Distortion,
}

impl Forecast {
    /// The view from `shape`.
    ///
    /// # Errors
    /// [`CageError`] when its cage has no area.
    pub fn of(shape: &Shape) -> Result<Self, CageError> {
        let cage = Cage::new(std::slice::from_ref(&shape.cage.points))?;
        let size = f64::from(shape.size);
        let step = DIFFERENCE_AT_1024 * size / 1024.0;
        let mut slopes = vec![[[0.0; PLACES]; 2]; shape.cage.points.len()];
        for (place, point) in places(&shape.cage.points).into_iter().enumerate() {
            for (axis, offset) in [Point::new(step, 0.0), Point::new(0.0, step)]
                .into_iter()
                .enumerate()
            {
                let before = coordinates(&cage, point - offset);
                let after = coordinates(&cage, point + offset);
                for (slopes, (a, b)) in slopes.iter_mut().zip(before.iter().zip(after)) {
                    slopes[axis][place] = ((b - a) * size / (2.0 * step)) as f32;
                }
            }
        }
        Ok(Self { slopes })
    }

    /// What mixing with `other` in equal shares would do.
    ///
    /// # Panics
    /// When the shapes were prepared with cages of different numbers of vertices.
    pub fn with(&self, other: &Shape) -> Foreseen {
        assert_eq!(
            self.slopes.len(),
            other.cage.points.len(),
            "cages of one space"
        );
        let jacobians = with_level_of_cpu(Derivatives {
            slopes: &self.slopes,
            vertices: &other.cage.points,
            scale: 1.0 / f64::from(other.size),
        });
        let at = |place: usize| jacobians.map(|entry| f64::from(entry[place]));
        let own: Vec<[f64; 4]> = (0..PLACES).map(|place| half_way(at(place))).collect();
        let other: Vec<[f64; 4]> = (0..PLACES)
            .map(|place| half_way(inverse(at(place))))
            .collect();
        Foreseen {
            own: Distortion::summed_up(&own),
            other: Distortion::summed_up(&other),
        }
    }
}

impl Foreseen {
    /// The worse of both in every respect.
    pub fn worst(&self) -> Distortion {
        self.own.worst(self.other)
    }
}

/// [`PLACES`] points spread evenly over the inside of `cage`.
fn places(cage: &[Point]) -> Vec<Point> {
    let points = sample_points(&[cage]);
    if points.is_empty() {
        return Vec::new();
    }
    (0..PLACES)
        .map(|place| points[(2 * place + 1) * points.len() / (2 * PLACES)])
        .collect()
}

/// The derivative half way from doing nothing to `full`.
fn half_way([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    [0.5 + 0.5 * a, 0.5 * b, 0.5 * c, 0.5 + 0.5 * d]
}

/// The inverse of the matrix [a, b; c, d]; that of a fold is a fold.
fn inverse([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    /// Determinants nearer to 0 are taken for this: a place that is squeezed to nothing.
    const LEAST: f64 = 1e-3;
    let determinant = a * d - b * c;
    let safe = determinant.abs().max(LEAST).copysign(determinant);
    [d / safe, -b / safe, -c / safe, a / safe]
}

/// [∂x/∂x′, ∂x/∂y′, ∂y/∂x′, ∂y/∂y′] at all places when the cage's vertices go to `vertices`.
struct Derivatives<'a> {
    slopes: &'a [[AtPlaces; 2]],
    vertices: &'a [Point],
    scale: f64,
}

impl Kernel for Derivatives<'_> {
    type Output = [AtPlaces; 4];

    #[inline(always)]
    fn run(self) -> [AtPlaces; 4] {
        let mut sums = [[0.0f32; PLACES]; 4];
        for ([along_x, along_y], vertex) in self.slopes.iter().zip(self.vertices) {
            let (x, y) = (
                (vertex.x * self.scale) as f32,
                (vertex.y * self.scale) as f32,
            );
            for place in 0..PLACES {
                sums[0][place] += x * along_x[place];
                sums[1][place] += x * along_y[place];
                sums[2][place] += y * along_x[place];
                sums[3][place] += y * along_y[place];
            }
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::{PinnedContour, Pins};

    /// A rectangle of this size that stands on row 100, in 100 points.
    fn rectangle(width: f64, height: f64) -> Shape {
        let corners = [
            (0.0, 0.0),
            (width / 2.0, 0.0),
            (width / 2.0, -height),
            (-width / 2.0, -height),
            (-width / 2.0, 0.0),
        ];
        let outline: Vec<Point> = corners
            .iter()
            .map(|&(x, y)| Point::new(64.0 + x, 110.0 + y))
            .collect();
        let contour = PinnedContour::resampled(&outline, Pins::without_trunk(0), 100);
        Shape {
            size: 128,
            cage: contour.clone(),
            contour,
            baseline_y: None,
            density: 1.0,
            fullness: 1.0,
            straight: 0.0,
            texture: 0.01,
            gaps: Vec::new(),
        }
    }

    #[test]
    fn a_tree_foresees_no_distortion_with_itself() {
        let shape = rectangle(60.0, 90.0);
        let found = Forecast::of(&shape).unwrap().with(&shape).worst();
        assert!(found.stretch < 1.01, "{found:?}");
        assert_eq!((found.folded, found.smeared), (0.0, 0.0));
    }

    #[test]
    fn the_forecast_is_the_measured_one_where_maps_are_affine() {
        // Corners meet corners only when both have the same proportions of their sides; so squeeze
        // the points themselves.
        let tall = rectangle(60.0, 90.0);
        let mut wide = tall.clone();
        for contour in [&mut wide.contour, &mut wide.cage] {
            for point in &mut contour.points {
                point.x = 64.0 + (point.x - 64.0) * 1.6;
            }
        }
        let layout = super::super::Layout::new(&[(&tall, 0.5, 1.0), (&wide, 0.5, 0.0)]).unwrap();
        let found = Forecast::of(&tall).unwrap().with(&wide);
        let measured = layout.distortion.stretch;
        assert!(
            (found.own.stretch - measured).abs() < 0.02,
            "{found:?} {measured}"
        );
        assert!(
            (found.other.stretch - (1.6f64 / 1.3).sqrt()).abs() < 0.02,
            "{found:?}"
        );
    }
}
