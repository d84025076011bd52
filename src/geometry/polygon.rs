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

/// Whether `point` is inside `polygon` by the even–odd rule; on the boundary either may be said.
pub fn contains(polygon: &[Point], point: Point) -> bool {
    edges(polygon)
        .filter(|(a, b)| (a.y > point.y) != (b.y > point.y))
        .filter(|(a, b)| point.x < (b.x - a.x) * (point.y - a.y) / (b.y - a.y) + a.x)
        .count()
        % 2
        == 1
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
    fn a_bow_tie_has_no_area() {
        let bow = [(0.0, 0.0), (2.0, 2.0), (2.0, 0.0), (0.0, 2.0)].map(Point::from);
        assert!(signed_area(&bow).abs() < 1e-12);
    }

    #[test]
    fn inside_and_outside_of_a_notched_square() {
        let notched = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)].map(Point::from);
        assert!(contains(&notched, Point::new(0.5, 2.0)));
        assert!(!contains(&notched, Point::new(2.0, 3.0)));
    }
}
