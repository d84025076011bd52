//! Lasso and polygon: the pixels inside a closed line.

use super::tiled::TiledMask;
use crate::geometry::Point;
use crate::raster::Rect;

/// What counts as inside where a line crosses itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum FillRule {
    /// Inside what the line goes round an odd number of times: loops cut holes.
    #[default]
    EvenOdd,
    /// Inside whatever the line goes round at all: a lasso drawn hastily has no holes.
    NonZero,
}

/// The pixels of a `width` × `height` picture whose centres lie in the closed `polygon`, the last
/// vertex joining the first. Of two polygons that share an edge no pixel belongs to both.
///
/// Vertices that are not finite are left out.
///
/// ```
/// use boscage::geometry::Point;
/// use boscage::paint::{FillRule, polygon_selection};
/// let square = [(0.5, 0.5), (2.5, 0.5), (2.5, 2.5), (0.5, 2.5)].map(Point::from);
/// let inside = polygon_selection(4, 4, &square, FillRule::EvenOdd);
/// assert_eq!(inside.count(|label| label == 1), 4);
/// ```
///
/// # Panics
/// When a side is 0.
pub fn polygon_selection(width: u32, height: u32, polygon: &[Point], rule: FillRule) -> TiledMask {
    let mut selection = TiledMask::filled(width, height, 0);
    let vertices: Vec<Point> = polygon.iter().copied().filter(|p| p.is_finite()).collect();
    let Some((top, rows)) = crossings(&vertices, height) else {
        return selection;
    };
    let spans: Vec<Vec<(f64, f64)>> = rows.into_iter().map(|row| inside(row, rule)).collect();
    let rect = Rect {
        x: 0,
        y: top,
        width,
        height: spans.len() as u32,
    };
    selection.edit(rect, |first, y, row| {
        for &(left, right) in &spans[(y - top) as usize] {
            // Centres in [left, right).
            let column =
                |x: f64| (x.ceil() - f64::from(first)).clamp(0.0, row.len() as f64) as usize;
            let (start, end) = (column(left), column(right));
            if start < end {
                row[start..end].fill(1);
            }
        }
    });
    selection
}

/// Where a line of pixel centres is crossed, and whether downwards (1) or upwards (−1).
type Crossing = (f64, i32);

/// The crossings of each row from the first row crossed on; `None` when no row is.
fn crossings(vertices: &[Point], height: u32) -> Option<(u32, Vec<Vec<Crossing>>)> {
    let low = vertices.iter().map(|p| p.y).min_by(f64::total_cmp)?;
    let high = vertices.iter().map(|p| p.y).max_by(f64::total_cmp)?;
    let rows_below = |y: f64| y.ceil().clamp(0.0, f64::from(height)) as u32;
    let (top, end) = (rows_below(low), rows_below(high));
    let mut rows = vec![Vec::new(); (end - top) as usize];
    for (i, &p) in vertices.iter().enumerate() {
        let q = vertices[(i + 1) % vertices.len()];
        let (upper, lower, turn) = if p.y <= q.y { (p, q, 1) } else { (q, p, -1) };
        for y in rows_below(upper.y)..rows_below(lower.y) {
            let t = (f64::from(y) - upper.y) / (lower.y - upper.y);
            rows[(y - top) as usize].push((upper.x + (lower.x - upper.x) * t, turn));
        }
    }
    (!rows.is_empty()).then_some((top, rows))
}

/// The intervals of a row that are inside.
fn inside(mut row: Vec<Crossing>, rule: FillRule) -> Vec<(f64, f64)> {
    row.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut winding = 0;
    let pairs = row.windows(2);
    pairs
        .filter_map(|pair| {
            winding += pair[0].1;
            let is_inside = match rule {
                FillRule::EvenOdd => winding % 2 != 0,
                FillRule::NonZero => winding != 0,
            };
            is_inside.then_some((pair[0].0, pair[1].0))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::contains;
    use proptest::prelude::*;

    /// Times that `polygon` goes round `p`.
    fn winding(polygon: &[Point], p: Point) -> i32 {
        let edges = (0..polygon.len()).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
        edges
            .map(|(a, b)| {
                let left = (b - a).perp_dot(p - a);
                match (a.y <= p.y, b.y <= p.y) {
                    (true, false) if left > 0.0 => 1,
                    (false, true) if left < 0.0 => -1,
                    _ => 0,
                }
            })
            .sum()
    }

    proptest! {
        #[test]
        fn pixels_are_those_whose_centres_are_inside(
            points in prop::collection::vec((-9.0..30.0, -9.0..30.0), 0..9),
        ) {
            let polygon: Vec<Point> = points.into_iter().map(Point::from).collect();
            let odd = polygon_selection(20, 17, &polygon, FillRule::EvenOdd);
            let any = polygon_selection(20, 17, &polygon, FillRule::NonZero);
            for y in 0..17 {
                for x in 0..20 {
                    let centre = Point::new(f64::from(x), f64::from(y));
                    prop_assert_eq!(odd.at(x, y) == 1, contains(&polygon, centre));
                    prop_assert_eq!(any.at(x, y) == 1, winding(&polygon, centre) != 0);
                }
            }
        }

        #[test]
        fn neighbours_share_no_pixel(x in 2.0..18.0f64, slant in -3.0..3.0f64) {
            let (up, down) = (Point::new(x, -1.0), Point::new(x + slant, 21.0));
            let left = [up, down, Point::new(-1.0, 21.0), Point::new(-1.0, -1.0)];
            let right = [up, down, Point::new(21.0, 21.0), Point::new(21.0, -1.0)];
            let count = |p: &[Point]| polygon_selection(20, 20, p, FillRule::NonZero).count(|l| l == 1);
            prop_assert_eq!(count(&left) + count(&right), 400);
        }
    }
}
