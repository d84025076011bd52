//! Closed polygons given by their vertices; the last one joins the first.

use super::Point;

/// A closed polygon: its vertices in order, without repeating the first at the end.
pub type Polygon = Vec<Point>;

/// Area of `polygon`, positive when its vertices run **counter-clockwise as seen on screen**
/// (y points down), negative when clockwise; parts run round twice count twice.
///
/// ```
/// use boscage::geometry::{Point, signed_area};
/// // Right along the bottom (larger y), then up: counter-clockwise on screen.
/// let square = [(0.0, 2.0), (2.0, 2.0), (2.0, 0.0), (0.0, 0.0)].map(Point::from);
/// assert_eq!(signed_area(&square), 4.0);
/// ```
pub fn signed_area(polygon: &[Point]) -> f64 {
    let twice: f64 = edges(polygon).map(|(a, b)| b.perp_dot(a)).sum();
    twice / 2.0
}

/// Length of the closed boundary.
pub fn perimeter(polygon: &[Point]) -> f64 {
    edges(polygon).map(|(a, b)| a.distance(b)).sum()
}

/// Whether `point` is inside `polygon` by the even–odd rule; on the boundary either may be said.
pub fn contains(polygon: &[Point], point: Point) -> bool {
    edges(polygon)
        .filter(|(a, b)| (a.y > point.y) != (b.y > point.y))
        .filter(|(a, b)| point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x)
        .count()
        % 2
        == 1
}

/// Whether the segments `a`–`b` and `c`–`d` cross in a point inside both.
pub fn segments_cross(a: Point, b: Point, c: Point, d: Point) -> bool {
    let side = |p: Point, q: Point, r: Point| (q - p).perp_dot(r - p);
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

/// Number of pairs of edges that cross: 0 for a simple polygon. Quadratic; for cages of some
/// hundred vertices.
pub fn self_crossings(polygon: &[Point]) -> usize {
    let edges: Vec<_> = edges(polygon).collect();
    (0..edges.len())
        .flat_map(|i| (i + 2..edges.len()).map(move |j| (i, j)))
        .filter(|&(i, j)| segments_cross(edges[i].0, edges[i].1, edges[j].0, edges[j].1))
        .count()
}

/// The edges of `polygon`, the closing one last.
fn edges(polygon: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    polygon
        .iter()
        .zip(polygon.iter().cycle().skip(1))
        .map(|(&a, &b)| (a, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bow_tie_crosses_itself_once_and_has_no_area() {
        let bow = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)].map(Point::from);
        assert_eq!(self_crossings(&bow), 1);
        assert!(signed_area(&bow).abs() < 1e-12);
    }

    #[test]
    fn inside_and_outside_of_a_notched_square() {
        let notched = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)].map(Point::from);
        assert!(contains(&notched, Point::new(0.5, 2.0)));
        assert!(!contains(&notched, Point::new(2.0, 3.0)));
        assert_eq!(self_crossings(&notched), 0);
    }

    #[test]
    fn perimeter_closes_the_loop() {
        let square = [(0.0, 0.0), (3.0, 0.0), (3.0, 4.0)].map(Point::from);
        assert_eq!(perimeter(&square), 12.0);
    }
}
