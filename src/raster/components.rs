//! Which pixels of a mask hang together.
//!
//! By runs: neighbours in a row are one piece to begin with, and runs of two rows that touch are joined
//! (union by the lowest number). That takes memory for the runs, not for the pixels, and a look at each
//! pixel: He, Chao & Suzuki, *A run-based two-scan labeling algorithm* (IEEE TIP 2008). (imageproc's takes ten
//! times as long, on what every preview and every segmentation waits for, and panics at a single pixel.)

use super::{Image, Mask};
use std::ops::Range;

/// Pixels in a row that belong.
struct Run {
    columns: Range<usize>,
    /// A run of lower number in the same component, or itself.
    parent: usize,
}

/// Number of the 8-connected component of each pixel that belongs: 1, 2, … in the order of their
/// first pixel from the top; 0 where nothing belongs.
pub fn labelled_components(mask: &Mask) -> Image<u32> {
    let (mut runs, rows) = joined_runs(mask);
    let mut numbers = vec![0; runs.len()];
    let mut count = 0;
    let mut labels = Image::filled(mask.width(), mask.height(), 0);
    for (y, row) in rows.into_iter().enumerate() {
        for run in row {
            let root = root(&mut runs, run);
            if root == run {
                count += 1;
                numbers[run] = count;
            }
            labels.row_mut(y as u32)[runs[run].columns.clone()].fill(numbers[root]);
        }
    }
    labels
}

/// All runs, each with a way to the first of its component, and which of them are in each row.
fn joined_runs(mask: &Mask) -> (Vec<Run>, Vec<Range<usize>>) {
    let mut runs: Vec<Run> = Vec::new();
    let mut rows: Vec<Range<usize>> = Vec::with_capacity(mask.height() as usize);
    for y in 0..mask.height() {
        let (row, first) = (mask.row(y), runs.len());
        let mut x = 0;
        while let Some(start) = row[x..].iter().position(|&inside| inside) {
            let start = x + start;
            let length = row[start..].iter().position(|&inside| !inside);
            x = length.map_or(row.len(), |length| start + length);
            let parent = runs.len();
            let columns = start..x;
            runs.push(Run { columns, parent });
        }
        let above = rows.last().cloned().unwrap_or(0..0);
        join(&mut runs, above, first);
        rows.push(first..runs.len());
    }
    (runs, rows)
}

/// Joins the runs `above` with those from number `below` on where they touch, at corners too.
fn join(runs: &mut [Run], above: Range<usize>, below: usize) {
    let mut upper = above.start;
    for lower in below..runs.len() {
        let Range { start, end } = runs[lower].columns;
        while upper < above.end && runs[upper].columns.end < start {
            upper += 1;
        }
        let mut touching = upper;
        while touching < above.end && runs[touching].columns.start <= end {
            let (one, other) = (root(runs, touching), root(runs, lower));
            runs[one.max(other)].parent = one.min(other);
            touching += 1;
        }
    }
}

/// The first run of the component that `run` is in.
fn root(runs: &mut [Run], mut run: usize) -> usize {
    while runs[run].parent != run {
        // Halves the way for whoever comes next.
        runs[run].parent = runs[runs[run].parent].parent;
        run = runs[run].parent;
    }
    run
}

/// How many pixels each of `components` has, which are numbered as by [`labelled_components`]; first those
/// of none.
pub fn component_sizes(components: &Image<u32>) -> Vec<usize> {
    let last = components.pixels().iter().max().copied().unwrap_or(0);
    let mut sizes = vec![0; last as usize + 1];
    for &component in components.pixels() {
        sizes[component as usize] += 1;
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::super::mask;
    use super::*;
    use crate::base::Seed;
    use imageproc::region_labelling::{Connectivity, connected_components};

    #[test]
    fn components_touch_at_corners() {
        let labels = labelled_components(&mask(&["#..", ".#.", "..."]));
        assert_eq!(labels.at(0, 0), labels.at(1, 1));
        let labels = labelled_components(&mask(&["#.#"]));
        assert_eq!(labels.pixels(), &[1, 0, 2]);
        assert_eq!(labelled_components(&mask(&["#"])).pixels(), &[1]);
    }

    #[test]
    fn arms_that_meet_below_are_one() {
        let labels = labelled_components(&mask(&["#.#.#", "#.#.#", "#####", ".....", "#.#.."]));
        let expected = [
            1, 0, 1, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0, 2, 0, 3, 0, 0,
        ];
        assert_eq!(labels.pixels(), expected);
        assert_eq!(component_sizes(&labels), [12, 11, 1, 1]);
    }

    #[test]
    fn components_are_those_of_imageproc() {
        let mut random = Seed(5).random();
        for (width, height, share) in [(64, 48, 0.5), (97, 31, 0.3), (5, 90, 0.6), (200, 2, 0.4)] {
            let pixels = (0..width * height).map(|_| random.unit() < share).collect();
            let mask = Mask::from_pixels(width, height, pixels);
            let black = image::Luma([0u8]);
            let theirs = connected_components(&mask.gray_image(), Connectivity::Eight, black);
            assert_eq!(labelled_components(&mask).pixels(), &theirs.into_raw()[..]);
        }
    }
}
