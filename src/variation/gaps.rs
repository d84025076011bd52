//! Gaps between branches as further polygons of a map.
//!
//! Argudo, Andújar & Chica 2017, *Tree Variations*, §7: mean value coordinates "allow multiple polygons
//! as long as the source and target polygon-sets are topologically equivalent", so that see-through
//! parts could be kept where they belong (Hormann & Floater 2006 define them for sets of polygons).
//!
//! *Idea.* An exemplar keeps its largest gaps as polygons of [`VERTICES`] points. Where all trees of a
//! mix have a gap at the same place, seen through the map between their cages, and of about the same
//! size, the gaps correspond: the mix has one between them and it stays open, also where colours of
//! several trees are laid over each other. A gap that the others lack is no polygon: it comes and
//! goes with the pictures' alpha.
//!
//! *Limits.* Bays that open outwards belong to the outline. The mix's maps must not get worse: where
//! they do, [`super::Layout`] leaves the gaps out.

use super::mean_value::{Cage, mapped_exactly};
use crate::contour::{filled, outlines};
use crate::geometry::{Point, Polygon, equal_chords, signed_area};
use crate::raster::{Mask, component_sizes, dilated, labelled_components, opaque_bounds};

/// Vertices of a gap: each costs as much as one of the cage's hundred.
const VERTICES: usize = 12;

/// Most gaps of a tree.
const MOST: usize = 8;

/// Smallest gap, as a share of the picture's area: some 40 pixels square of 1,024.
const LEAST_AREA: f64 = 0.0015;

/// Twigs and leaves stay this far from a gap, and gaps this far from the cage, for pictures of 1,024
/// pixels: a polygon that touches the cage pinches the map between them.
const CLEARANCE_AT_1024: f64 = 3.0;
const FROM_CAGE_AT_1024: f64 = 14.0;

/// How far apart matching gaps may be, by the root of their mean area.
const FARTHEST: f64 = 1.6;

/// How many times larger one of two matching gaps may be.
const LARGEST_RATIO: f64 = 8.0;

/// The largest gaps in `mask` within the cage `cage`, the largest first, in pixels of the picture; each
/// counter-clockwise as seen on screen from its topmost point on.
pub(super) fn gaps(cage: &[Point], mask: &Mask) -> Vec<Polygon> {
    let size = mask.width();
    let scaled = |at_1024: f64| (at_1024 * f64::from(size) / 1024.0).round().max(1.0) as u8;
    let outside = filled(cage, Point::ZERO, size, size).map(|inside| !inside);
    let near_cage = dilated(&outside, scaled(FROM_CAGE_AT_1024));
    let near_tree = dilated(mask, scaled(CLEARANCE_AT_1024));
    let mut free = near_cage;
    for (free, taken) in free.pixels_mut().iter_mut().zip(near_tree.pixels()) {
        *free = !*free && !taken;
    }
    let parts = labelled_components(&free);
    let areas = component_sizes(&parts);
    let least = LEAST_AREA * f64::from(size) * f64::from(size);
    let mut large: Vec<usize> = (1..areas.len())
        .filter(|&part| areas[part] as f64 >= least)
        .collect();
    large.sort_by_key(|&part| (std::cmp::Reverse(areas[part]), part));
    let polygons = large.into_iter().take(MOST);
    let polygons = polygons.map(|part| polygon(&parts.map(|&own| own as usize == part)));
    polygons.flatten().collect()
}

/// The outline of the one part of `mask` in few points.
fn polygon(mask: &Mask) -> Option<Polygon> {
    let bounds = opaque_bounds(mask)?;
    let part = mask.cropped(bounds.x, bounds.y, bounds.width, bounds.height);
    let mut border = outlines(&part).longest_exterior()?;
    let top = |a: &Point, b: &Point| a.y.total_cmp(&b.y).then(a.x.total_cmp(&b.x));
    let (first, _) = border.iter().enumerate().min_by(|a, b| top(a.1, b.1))?;
    border.rotate_left(first);
    border.push(border[0]);
    let offset = Point::new(f64::from(bounds.x), f64::from(bounds.y));
    let points = equal_chords(&border, VERTICES);
    let polygon: Polygon = points.into_iter().map(|point| point + offset).collect();
    (polygon.len() == VERTICES && signed_area(&polygon) > 0.0).then_some(polygon)
}

/// The gaps that all trees of a mix have: for each tree its polygons, in the same order. `cages` are
/// the trees' cages, which correspond; `gaps` their gaps.
pub(super) fn common_gaps(cages: &[Cage], gaps: &[&[Polygon]]) -> Vec<Vec<Polygon>> {
    let mut common = vec![Vec::new(); cages.len()];
    let mut taken: Vec<Vec<bool>> = gaps.iter().map(|own| vec![false; own.len()]).collect();
    let Some((first, others)) = gaps.split_first() else {
        return common;
    };
    for gap in *first {
        let found: Option<Vec<usize>> = others
            .iter()
            .enumerate()
            .map(|(i, own)| {
                let expected = mapped_exactly(&cages[0], &cages[i + 1], middle(gap));
                nearest_like(gap, expected, own, &taken[i + 1])
            })
            .collect();
        if let Some(found) = found {
            common[0].push(gap.clone());
            for (i, at) in found.into_iter().enumerate() {
                taken[i + 1][at] = true;
                common[i + 1].push(others[i][at].clone());
            }
        }
    }
    common
}

/// The gap of `others` nearest to `expected` that could be `gap` and is not `taken`.
fn nearest_like(
    gap: &Polygon,
    expected: Point,
    others: &[Polygon],
    taken: &[bool],
) -> Option<usize> {
    let area = signed_area(gap);
    let distance = |i: &usize| middle(&others[*i]).distance(expected);
    let is_like = |i: &usize| {
        let other = signed_area(&others[*i]);
        let ratio = (area / other).max(other / area);
        ratio <= LARGEST_RATIO && distance(i) <= FARTHEST * (0.5 * (area + other)).sqrt()
    };
    let free = (0..others.len()).filter(|&i| !taken[i]);
    free.filter(is_like)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

fn middle(polygon: &[Point]) -> Point {
    polygon.iter().copied().sum::<Point>() / polygon.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    fn square(x: f64, y: f64, side: f64) -> Polygon {
        [(0.0, 0.0), (0.0, side), (side, side), (side, 0.0)]
            .map(|(dx, dy)| Point::new(x + dx, y + dy))
            .to_vec()
    }

    #[test]
    fn a_window_is_found_and_a_bay_is_not() {
        let mut mask = Image::filled(256, 256, true);
        for (x, y) in (0..60).flat_map(|x| (0..60).map(move |y| (x, y))) {
            mask.set(100 + x, 80 + y, false);
            mask.set(x, 180 + y, false);
        }
        let found = gaps(&square(-2.0, -2.0, 260.0), &mask);
        let inner = found.iter().filter(|gap| middle(gap).x > 90.0).count();
        assert_eq!(inner, 1, "{found:?}");
        let window = &found.iter().find(|gap| middle(gap).x > 90.0).unwrap();
        assert!(middle(window).distance(Point::new(129.5, 109.5)) < 4.0);
        assert!((signed_area(window).sqrt() - 58.0).abs() < 8.0);
    }

    #[test]
    fn gaps_match_by_place_and_size() {
        let cages = [square(0.0, 0.0, 100.0), square(0.0, 0.0, 200.0)];
        let cages = cages.map(|cage| Cage::new(&[cage]).unwrap());
        let one = [square(20.0, 20.0, 10.0), square(70.0, 70.0, 10.0)];
        let other = [square(120.0, 20.0, 20.0), square(138.0, 142.0, 20.0)];
        let common = common_gaps(&cages, &[&one, &other]);
        assert_eq!(common[0], [one[1].clone()]);
        assert_eq!(common[1], [other[1].clone()]);
    }
}
