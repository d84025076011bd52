//! A library as a map: trees that go together stand side by side, lines join the best matches.

use super::paint::{Canvas, Rgba, open};
use super::scene::tree_bounds;
use crate::geometry::Point;
use crate::raster::{Image, Premultiplied, Straight, resized};

const GROUND: Rgba = [206, 204, 200, 255];

/// Lines of the closest and of the least close pairs.
const NEAR: [f64; 3] = [38.0, 96.0, 58.0];
const FAR: [f64; 3] = [176.0, 170.0, 160.0];

/// Distance of two trees from which on a line is as pale as it gets.
const PALE: f64 = 3.0;

/// The map of `trees` at `places` in the unit square, with lines between the pairs `(a, b, distance)`,
/// the closer the darker. Each tree fits into a square of `tree_px`; the map is `side_px` square.
///
/// # Panics
/// When there is not one place for each tree, or an edge names one that is not there.
pub fn map_sheet(
    trees: &[&Image<Premultiplied>],
    places: &[Point],
    edges: &[(usize, usize, f64)],
    side_px: u32,
    tree_px: u32,
) -> Image<Straight> {
    assert_eq!(trees.len(), places.len(), "a place for each tree");
    let mut canvas = Canvas::new(side_px, side_px, GROUND);
    let margin = 0.65 * f64::from(tree_px);
    let room = f64::from(side_px) - 2.0 * margin;
    let at = |index: usize| places[index] * room + margin;
    // The darkest last, on top.
    let mut lines = edges.to_vec();
    lines.sort_by(|a, b| b.2.total_cmp(&a.2));
    for (a, b, distance) in lines {
        let pale = (distance / PALE).min(1.0);
        let [red, green, blue] =
            [0, 1, 2].map(|i| (NEAR[i] + (FAR[i] - NEAR[i]) * pale).round() as u8);
        let width = 1.0 + 3.0 * (1.0 - pale);
        canvas.stroke(
            open(&[at(a), at(b)]).as_ref(),
            width,
            [red, green, blue, 255],
        );
    }
    // From the back to the front, so that what overlaps does so as trees in a field do.
    let mut order: Vec<usize> = (0..trees.len()).collect();
    order.sort_by(|&a, &b| places[a].y.total_cmp(&places[b].y).then(a.cmp(&b)));
    for index in order {
        let Some(bounds) = tree_bounds(trees[index]) else {
            continue;
        };
        let scale = f64::from(tree_px) / f64::from(bounds.width.max(bounds.height));
        let side = |length: u32| ((f64::from(length) * scale).round() as u32).max(1);
        let (width, height) = (side(bounds.width), side(bounds.height));
        let small = resized(trees[index], bounds, width, height);
        let corner = at(index) - Point::new(f64::from(width), f64::from(height)) / 2.0;
        canvas.lay(
            &small,
            corner.x.round() as i64,
            corner.y.round() as i64,
            1.0,
        );
    }
    canvas.into_image()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn trees_stand_where_they_belong_and_lines_join_them() {
        let tree = Image::filled(8, 8, Premultiplied([0, 200, 0, 255]));
        let places = [Point::new(0.0, 0.5), Point::new(1.0, 0.5)];
        let map = map_sheet(&[&tree, &tree], &places, &[(0, 1, 0.1)], 200, 20);
        assert_eq!(map.at(13, 100).0, [0, 200, 0, 255]);
        assert_eq!(map.at(187, 100).0, [0, 200, 0, 255]);
        let middle = map.at(100, 100).0;
        assert!(middle[1] > middle[0] && middle[0] < 80, "{middle:?}");
        assert_eq!(map.at(100, 40).0, GROUND);
    }
}
