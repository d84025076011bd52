//! A silhouette on the screen: where handles along it stand, and what is near the pointer.

use crate::pipeline::Silhouette;
use egui::{Pos2, Rect, Vec2, vec2};

/// A silhouette on the screen.
pub(super) struct Outline {
    /// Place along it, and where; at least [`Outline::FEWEST`].
    points: Vec<(f64, Pos2)>,
}

impl Outline {
    /// Fewer points are no outline.
    const FEWEST: usize = 9;

    /// `points` of a silhouette, t and where; `None` when they are too few.
    pub(super) fn new(points: impl Iterator<Item = (f64, Pos2)>) -> Option<Self> {
        let points: Vec<(f64, Pos2)> = points.collect();
        (points.len() >= Self::FEWEST).then_some(Self { points })
    }

    /// `silhouette` as large as fits in `rect`.
    pub(super) fn within(silhouette: &Silhouette, rect: Rect) -> Option<Self> {
        let [from, to] = silhouette.bounds;
        let (size, middle) = (to - from, (from + to) / 2.0);
        let fits = f64::from(rect.width()) / size.x;
        let scale = fits.min(f64::from(rect.height()) / size.y);
        let points = silhouette.points.iter().map(|&(t, at)| {
            let from_middle = (at - middle) * scale;
            (
                t,
                rect.center() + vec2(from_middle.x as f32, from_middle.y as f32),
            )
        });
        Self::new(points)
    }

    /// All points, t and where.
    pub(super) fn points(&self) -> &[(f64, Pos2)] {
        &self.points
    }

    /// The point at `t` and the direction outwards.
    pub(super) fn at(&self, t: f64) -> (Pos2, Vec2) {
        let count = self.points.len();
        let index = self.points.partition_point(|(at, _)| *at < t) % count;
        // Over a stretch, for pixels have corners.
        let reach = (count / 40).max(1);
        let along =
            self.points[(index + reach) % count].1 - self.points[(index + count - reach) % count].1;
        // The way is counter-clockwise on the screen, where y points down: outside is on the right.
        (self.points[index].1, vec2(-along.y, along.x).normalized())
    }

    /// The t nearest to a place on the screen, and how far it is.
    pub(super) fn nearest(&self, to: Pos2) -> (f64, f32) {
        let distances = self.points.iter().map(|(t, at)| (*t, at.distance(to)));
        let nearest = distances.min_by(|a, b| a.1.total_cmp(&b.1));
        nearest.unwrap_or((0.0, f32::INFINITY))
    }
}

/// The handle at `places` that is nearest to `pointer`, within `reach` points.
pub(super) fn handle_at(places: &[Pos2], pointer: Pos2, reach: f32) -> Option<usize> {
    let distance = |i: &usize| places[*i].distance(pointer);
    let nearest = (0..places.len()).min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    (distance(&nearest) < reach).then_some(nearest)
}

/// Where along the silhouette handle `index` of `points` may be: between its neighbours.
pub(super) fn between_neighbours(points: &[(f64, f64)], index: usize, t: f64) -> f64 {
    /// Least way between two handles, as a share of the silhouette.
    const APART: f64 = 0.01;
    let least = index.checked_sub(1).map_or(0.0, |i| points[i].0 + APART);
    let next = points.get(index + 1);
    let most = next.map_or(1.0 - APART, |next| next.0 - APART);
    t.clamp(least, most.max(least))
}
