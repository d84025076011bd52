//! A library laid out in the plane: trees that go together lie side by side.
//!
//! Classical multidimensional scaling (Torgerson 1952): the two leading eigenvectors of the doubly
//! centred squared distances. Of a large library only some landmarks are laid out so, the others are
//! placed by their distances to those (landmark MDS: de Silva & Tenenbaum, *Sparse multidimensional
//! scaling using landmark points*, 2004). Deterministic: landmarks are the farthest from all before,
//! eigenvectors come from a fixed start and have a fixed sign.

use super::Shape;
use super::compatibility::{Traits, joined_distance};
use super::forecast::Forecast;
use crate::geometry::Point;
use rayon::prelude::*;

/// Most exemplars that are laid out by all their distances.
const LANDMARKS: usize = 128;

/// Rounds of the power iteration: directions whose eigenvalues differ by 5 % are then told apart.
const ROUNDS: usize = 300;

/// Places of `shapes` in the unit square, in their order; the longer side is filled.
pub fn library_places(shapes: &[&Shape]) -> Vec<Point> {
    let traits: Vec<Traits> = shapes.iter().map(|shape| Traits::of(shape)).collect();
    let forecasts = |of: usize| Forecast::of(shapes[of]).ok();
    let row = |from: usize| -> Vec<f64> {
        let forecast = forecasts(from);
        let to = |i: usize| match &forecast {
            _ if i == from => 0.0,
            Some(forecast) => joined_distance(&traits[from], &traits[i], &forecast.with(shapes[i])),
            None => traits[from].distance(&traits[i]),
        };
        (0..shapes.len()).into_par_iter().map(to).collect()
    };
    in_unit_square(scaled(shapes.len(), row))
}

/// Places of `count` things of which `row` gives the distances of one to all.
fn scaled(count: usize, row: impl Fn(usize) -> Vec<f64>) -> Vec<Point> {
    if count == 0 {
        return Vec::new();
    }
    let (landmarks, rows) = landmarks(count, row);
    let size = landmarks.len();
    // Seen from either end a pair may differ: the mean of both.
    let squared: Vec<Vec<f64>> = (0..size)
        .map(|a| {
            let distance = |b: usize| 0.5 * (rows[a][landmarks[b]] + rows[b][landmarks[a]]);
            (0..size).map(|b| distance(b) * distance(b)).collect()
        })
        .collect();
    let means: Vec<f64> = squared.iter().map(|row| mean(row)).collect();
    let all = mean(&means);
    let centred: Vec<Vec<f64>> = (0..size)
        .map(|a| {
            let entry = |b: usize| -0.5 * (squared[a][b] - means[a] - means[b] + all);
            (0..size).map(entry).collect()
        })
        .collect();
    let first = leading(&centred, None);
    let second = leading(&centred, Some(&first));
    let place = |i: usize| {
        let along = |(vector, value): &(Vec<f64>, f64)| {
            if *value <= 0.0 {
                return 0.0;
            }
            let sum: f64 = (0..size)
                .map(|a| vector[a] * (means[a] - rows[a][i] * rows[a][i]))
                .sum();
            0.5 * sum / value.sqrt()
        };
        Point::new(along(&first), along(&second))
    };
    (0..count).map(place).collect()
}

/// Landmarks, each the farthest from those before, and the distances from each to all.
fn landmarks(count: usize, row: impl Fn(usize) -> Vec<f64>) -> (Vec<usize>, Vec<Vec<f64>>) {
    let mut landmarks = vec![0];
    let mut rows = vec![row(0)];
    let mut nearest = rows[0].clone();
    while landmarks.len() < LANDMARKS.min(count) {
        let is_new = |i: &usize| !landmarks.contains(i);
        let farthest = (0..count)
            .filter(is_new)
            .max_by(|&a, &b| nearest[a].total_cmp(&nearest[b]).then(b.cmp(&a)));
        let Some(next) = farthest else { break };
        let distances = row(next);
        for (nearest, distance) in nearest.iter_mut().zip(&distances) {
            *nearest = nearest.min(*distance);
        }
        landmarks.push(next);
        rows.push(distances);
    }
    (landmarks, rows)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The eigenvector of the largest eigenvalue of a symmetric matrix, of length 1 with its largest entry
/// positive, and the eigenvalue; of those at right angles to `but`, if given.
fn leading(matrix: &[Vec<f64>], but: Option<&(Vec<f64>, f64)>) -> (Vec<f64>, f64) {
    // Negative eigenvalues (the distances are not quite Euclidean) must not win: shift them away.
    let bound = |row: &Vec<f64>| row.iter().map(|entry| entry.abs()).sum::<f64>();
    let shift = matrix.iter().map(bound).fold(0.0, f64::max) * 0.5;
    let mut vector: Vec<f64> = (0..matrix.len())
        .map(|i| 1.0 + 0.37 * ((i * 7919) % 101) as f64)
        .collect();
    for _ in 0..ROUNDS {
        let mut next: Vec<f64> = matrix
            .iter()
            .zip(&vector)
            .map(|(row, own)| dot(row, &vector) + shift * own)
            .collect();
        if let Some((other, _)) = but {
            let share = dot(&next, other);
            next.iter_mut()
                .zip(other)
                .for_each(|(a, b)| *a -= share * b);
        }
        let length = dot(&next, &next).sqrt();
        if length <= f64::MIN_POSITIVE {
            return (vec![0.0; matrix.len()], 0.0);
        }
        next.iter_mut().for_each(|entry| *entry /= length);
        vector = next;
    }
    let largest = vector.iter().copied().fold(0.0, |best: f64, entry| {
        if entry.abs() > best.abs() + 1e-9 {
            entry
        } else {
            best
        }
    });
    if largest < 0.0 {
        vector.iter_mut().for_each(|entry| *entry = -*entry);
    }
    let product: Vec<f64> = matrix.iter().map(|row| dot(row, &vector)).collect();
    let value = dot(&product, &vector);
    (vector, value)
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The same places moved and scaled so that they just fit into the unit square, in its middle.
fn in_unit_square(places: Vec<Point>) -> Vec<Point> {
    let low = places
        .iter()
        .copied()
        .reduce(Point::min)
        .unwrap_or_default();
    let high = places
        .iter()
        .copied()
        .reduce(Point::max)
        .unwrap_or_default();
    let side = (high - low).max_element();
    if side <= 0.0 {
        return vec![Point::splat(0.5); places.len()];
    }
    let middle = (low + high) / 2.0;
    places
        .into_iter()
        .map(|place| (place - middle) / side + 0.5)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_plane_are_found_again() {
        let truth: Vec<Point> = (0..300)
            .map(|i| Point::new(f64::from(i * 37 % 101), 0.4 * f64::from(i * 53 % 97)))
            .collect();
        let row = |from: usize| truth.iter().map(|p| p.distance(truth[from])).collect();
        let found = scaled(truth.len(), row);
        for (i, j) in [(0, 1), (5, 200), (150, 299), (42, 77)] {
            let (real, ours) = (truth[i].distance(truth[j]), found[i].distance(found[j]));
            assert!((real - ours).abs() < 1e-3 * (1.0 + real), "{real} {ours}");
        }
    }

    #[test]
    fn few_things_have_a_place_too() {
        assert!(scaled(0, |_| Vec::new()).is_empty());
        assert_eq!(
            in_unit_square(scaled(1, |_| vec![0.0])),
            [Point::splat(0.5)]
        );
        let two = in_unit_square(scaled(2, |from| vec![from as f64, 1.0 - from as f64]));
        assert!((two[0].distance(two[1]) - 1.0).abs() < 1e-9);
    }
}
