//! Which trees go together: a distance between exemplars, and the graph of the nearest.
//!
//! Argudo, Andújar & Chica 2017, *Tree Variations*, §7, leave this to the future: "compute which
//! subset of trees are sufficiently compatible for their combination, storing this information in a
//! graph". The distance joins what an eye compares (outline, proportions, height of the trunk, how
//! full and how fine the foliage is) with what a mix would do to the pictures, foreseen from the
//! outlines ([`Forecast`]). Each difference is measured in a unit that was chosen by looking at pairs;
//! at a distance of 1 two trees could be of one species, beyond 3 a mix is a fantasy.
//!
//! *Cost.* A few microseconds a pair, some hundred for each exemplar that looks. In large libraries
//! only the [`CANDIDATES`] whose traits are nearest are foreseen: 10,000 exemplars take seconds.
//!
//! *Limits.* Colour plays no part: palettes can be matched afterwards.

use super::forecast::{Forecast, Foreseen};
use super::{Distortion, Shape};
use crate::geometry::Point;
use rayon::prelude::*;

/// Neighbours of an exemplar in the graph: enough that random choice does not go round in circles,
/// few enough that each is a good match.
pub(super) const NEIGHBOURS: usize = 10;

/// Exemplars whose distortion is foreseen from one: those with the nearest traits.
const CANDIDATES: usize = 64;

/// Largest difference in density, 0 to 1, of trees of a kind: a bare tree (0.6) is not mixed with a
/// dense one (0.9), sparse foliage (0.75) is.
const DENSITY_RANGE: f64 = 0.2;

/// Largest difference in fullness, 0 to 1, of trees of a kind: thin trees (0.2) poured into a thick
/// outline (0.8) are the paper's Fig. 15.
const FULLNESS_RANGE: f64 = 0.3;

/// Largest difference in how straight, 0 to 1, trees of a kind stand: a spire mixed with a round crown is
/// neither.
const STRAIGHT_RANGE: f64 = 0.6;

/// Whether two trees are of a kind: both with or both without a trunk, about as dense, about as full, and both
/// spires or both round. Only such are mixed at random.
pub fn are_of_a_kind(a: &Shape, b: &Shape) -> bool {
    // A cage may lose the trunk that the outline has: between strands that hang to the ground.
    a.contour.pins.has_trunk() == b.contour.pins.has_trunk()
        && a.cage.pins.has_trunk() == b.cage.pins.has_trunk()
        && (a.density - b.density).abs() <= DENSITY_RANGE
        && (a.fullness - b.fullness).abs() <= FULLNESS_RANGE
        && (a.straight - b.straight).abs() <= STRAIGHT_RANGE
}

/// Every so many vertices of the cage one is compared.
const OUTLINE_STEP: usize = 4;

/// Differences that count as one.
mod unit {
    /// Root mean square distance of corresponding points, as a share of the picture's side.
    pub(super) const OUTLINE: f64 = 0.08;
    /// Logarithm of width by height.
    pub(super) const ASPECT: f64 = 0.4;
    /// Share of the height below the crown.
    pub(super) const TRUNK: f64 = 0.15;
    /// Share of the outline that is opaque.
    pub(super) const DENSITY: f64 = 0.1;
    /// Share of the crown's hull that is opaque.
    pub(super) const FULLNESS: f64 = 0.15;
    /// Logarithm of the size of leaves.
    pub(super) const TEXTURE: f64 = 0.7;
    /// Penalty of the foreseen distortion above that of none.
    pub(super) const DISTORTION: f64 = 1.0;
}

/// What an eye compares of a tree.
#[derive(Debug, Clone)]
pub(super) struct Traits {
    /// Some points of the cage from the middle of its foot, per picture side.
    outline: Vec<Point>,
    /// Each divided by its unit: aspect, trunk, density, fullness, texture.
    scalars: [f64; 5],
}

impl Traits {
    /// The traits of `shape`.
    pub(super) fn of(shape: &Shape) -> Self {
        let size = f64::from(shape.size);
        let contour = &shape.contour;
        let (low, high) = bounds(&contour.points);
        let (width, height) = ((high.x - low.x).max(1.0), (high.y - low.y).max(1.0));
        let trunk = match contour.pins.has_trunk() {
            true => contour.bottom().y - 0.5 * (contour.left().y + contour.right().y),
            false => 0.0,
        };
        let foot = Point::new(0.5 * (low.x + high.x), high.y);
        let points = shape.cage.points.iter().step_by(OUTLINE_STEP);
        Self {
            outline: points.map(|point| (*point - foot) / size).collect(),
            scalars: [
                libm::log(width / height) / unit::ASPECT,
                trunk / height / unit::TRUNK,
                shape.density / unit::DENSITY,
                shape.fullness / unit::FULLNESS,
                libm::log(shape.texture.max(1e-4)) / unit::TEXTURE,
            ],
        }
    }

    /// The distance by traits alone, 0 for equals.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        let pairs = self.outline.iter().zip(&other.outline);
        let outline: f64 = pairs.map(|(a, b)| a.distance_squared(*b)).sum();
        let outline = outline / self.outline.len().max(1) as f64 / (unit::OUTLINE * unit::OUTLINE);
        let scalars = self.scalars.iter().zip(&other.scalars);
        let scalars: f64 = scalars.map(|(a, b)| (a - b) * (a - b)).sum();
        (outline + scalars).sqrt()
    }
}

fn bounds(points: &[Point]) -> (Point, Point) {
    let low = points.iter().copied().reduce(Point::min);
    let high = points.iter().copied().reduce(Point::max);
    (low.unwrap_or_default(), high.unwrap_or_default())
}

/// How one exemplar looks from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Neighbour {
    /// Which exemplar.
    pub exemplar: usize,
    /// How far it is: 0 the same, 1 very alike, beyond 3 hardly related.
    pub distance: f64,
    /// The distortion of a mix in equal shares, foreseen.
    pub foreseen: Foreseen,
    /// See [`are_of_a_kind`].
    pub is_of_a_kind: bool,
}

/// The distance of two exemplars with these traits.
pub(super) fn joined_distance(a: &Traits, b: &Traits, foreseen: &Foreseen) -> f64 {
    joined(a.distance(b), foreseen)
}

fn joined(traits: f64, foreseen: &Foreseen) -> f64 {
    let above = |found: &Distortion| found.penalty() - Distortion::NONE.penalty();
    // A logarithm: that a very bad pair is twice as bad as another tells nobody anything.
    let distortion = 0.5 * (above(&foreseen.own) + above(&foreseen.other));
    let distortion = libm::log1p(distortion.max(0.0)) / unit::DISTORTION;
    (traits * traits + distortion * distortion).sqrt()
}

/// Exemplars as seen from one of them, the nearest first: the [`CANDIDATES`] with the nearest traits.
/// Those that have no map to it are left out.
pub(super) fn seen_from(from: usize, shapes: &[&Shape], traits: &[Traits]) -> Vec<Neighbour> {
    let Ok(forecast) = Forecast::of(shapes[from]) else {
        return Vec::new();
    };
    let others = (0..shapes.len()).filter(|&i| i != from);
    let mut others: Vec<(f64, usize)> = others
        .map(|i| (traits[from].distance(&traits[i]), i))
        .collect();
    others.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let seen = others.into_iter().take(CANDIDATES).map(|(distance, i)| {
        let foreseen = forecast.with(shapes[i]);
        Neighbour {
            exemplar: i,
            distance: joined(distance, &foreseen),
            foreseen,
            is_of_a_kind: are_of_a_kind(shapes[from], shapes[i]),
        }
    });
    let mut seen: Vec<Neighbour> = seen.collect();
    seen.sort_by(|a, b| {
        let distance = a.distance.total_cmp(&b.distance);
        distance.then(a.exemplar.cmp(&b.exemplar))
    });
    seen
}

/// The graph of a library: from each exemplar to the ten nearest of its kind.
#[derive(Debug, Clone)]
pub struct CompatibilityGraph {
    /// For each exemplar those it goes with, the nearest first.
    pub neighbours: Vec<Vec<Neighbour>>,
}

impl CompatibilityGraph {
    /// The graph of `shapes`.
    pub fn of(shapes: &[&Shape]) -> Self {
        let traits: Vec<Traits> = shapes.iter().map(|shape| Traits::of(shape)).collect();
        let neighbours = (0..shapes.len())
            .into_par_iter()
            .map(|from| {
                let mut seen = seen_from(from, shapes, &traits);
                seen.retain(|neighbour| neighbour.is_of_a_kind);
                seen.truncate(NEIGHBOURS);
                seen
            })
            .collect();
        Self { neighbours }
    }

    /// Its edges, each once: two exemplars of which at least one is a neighbour of the other, and
    /// the smaller of their distances.
    pub fn edges(&self) -> Vec<(usize, usize, f64)> {
        let mut edges: Vec<(usize, usize, f64)> = Vec::new();
        for (from, neighbours) in self.neighbours.iter().enumerate() {
            for neighbour in neighbours {
                let (a, b) = (from.min(neighbour.exemplar), from.max(neighbour.exemplar));
                edges.push((a, b, neighbour.distance));
            }
        }
        edges.sort_by(|x, y| (x.0, x.1).cmp(&(y.0, y.1)).then(x.2.total_cmp(&y.2)));
        edges.dedup_by_key(|edge| (edge.0, edge.1));
        edges
    }
}
