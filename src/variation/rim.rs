//! What stands along the outline of a tree whose foliage was grown anew.
//!
//! The cells there show an outline of their own, which runs as the tree's does. In what stands straight alpha is
//! that of the swayed tree, so that no cell's border shows against the sky.

use super::Tree;
use super::habit::Habit;
use super::rounded::without_gaps;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight, labelled_components, smoothed};
use crate::segment::Label;
use rayon::prelude::*;

/// Standard deviation of the Gaussian that tells how deep in the crown a pixel lies, in cell sizes; on the
/// outline it gives 0.5. Below [`OUTSIDE`] is sky.
const BAND: f64 = 0.22;
const OUTSIDE: f32 = 0.06;

/// In what stands straight the depth up to which sky stays sky and a bough a bough: they end in tips, with
/// gaps between.
const KEPT: f32 = 0.97;

/// Side of the largest square of leaves, in cell sizes, that hang in the air.
const LOOSE: f64 = 0.35;

/// The foliage of `grown` in the tree `tree`, and how deep in the crown each pixel lies: 0 to 1. What stands
/// straight keeps its outline.
pub(super) fn within_outline(
    (tree, habit): (&Tree, &Habit),
    grown: &Tree,
    side: f64,
    cancel: &Cancel,
) -> Result<(Tree, Image<f32>), Cancelled> {
    let alpha = without_gaps(&tree.image, side).map(|&inside| f32::from(u8::from(inside)));
    let inside = smoothed(&alpha, BAND * side, cancel)?;
    let width = inside.width() as usize;
    let mut result = tree.clone();
    let rows = result.image.pixels_mut().par_chunks_mut(width);
    let rows = rows.zip(result.labels.pixels_mut().par_chunks_mut(width));
    let grown = grown
        .image
        .pixels()
        .par_chunks(width)
        .zip(grown.labels.pixels().par_chunks(width));
    let rows = rows
        .zip(grown)
        .zip(inside.pixels().par_chunks(width))
        .enumerate();
    rows.for_each(
        |(y, (((pixels, labels), (foliage, foliage_labels)), inside))| {
            let reached = outermost(habit, y, side);
            for x in 0..width {
                if labels[x] == Label::Trunk || foliage_labels[x] == Label::Trunk {
                    continue;
                }
                let is_kept = habit.is_straight() && inside[x] < KEPT;
                let takes = match is_kept {
                    true => foliage[x].alpha() >= 128 && pixels[x].alpha() >= 96,
                    false => inside[x] > reached,
                };
                if takes {
                    (pixels[x], labels[x]) = (foliage[x], foliage_labels[x]);
                }
            }
        },
    );
    Ok((result, inside))
}

/// The depth from which leaves may stand out in row `y`: about a slender tip none stand far out.
fn outermost(habit: &Habit, y: usize, side: f64) -> f32 {
    let room = (habit.half(y as f64) / (1.5 * side)).min(1.0);
    let kept = (habit.straight() * (1.0 - room)) as f32;
    OUTSIDE + kept * (0.45 - OUTSIDE)
}

/// Clears what hangs in the air beyond the outline: leaves of a cell whose twig lies in another.
pub(super) fn clear_loose_leaves(tree: &mut Tree, inside: &Image<f32>, side: f64) {
    let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= 48));
    let count = parts.pixels().iter().copied().max().unwrap_or(0) as usize;
    let mut found = vec![(0u32, 0.0f32); count + 1];
    for (&part, &inside) in parts.pixels().iter().zip(inside.pixels()) {
        let (area, deepest) = &mut found[part as usize];
        *area += 1;
        *deepest = deepest.max(inside);
    }
    let largest = LOOSE * side * LOOSE * side;
    let is_loose = |part: u32| {
        let (area, deepest) = found[part as usize];
        part == 0 || (f64::from(area) < largest && deepest < 0.5)
    };
    clear(tree, &parts, |place, part| {
        inside.pixels()[place] < 0.5 && is_loose(part)
    });
}

/// Clears what hangs in the air and did not stand there in `before`, up to so many pixels a piece.
pub(super) fn clear_new_loose(made: &mut Tree, before: &Tree, most: f64) {
    let parts = labelled_components(&made.image.map(|pixel| pixel.alpha() >= 48));
    let count = parts.pixels().iter().copied().max().unwrap_or(0) as usize;
    let mut found = vec![(0u32, false); count + 1];
    let pixels = made.image.pixels().iter().zip(before.image.pixels());
    for (&part, (new, old)) in parts.pixels().iter().zip(pixels) {
        let (area, is_changed) = &mut found[part as usize];
        *area += 1;
        *is_changed |= new != old;
    }
    let largest = found[1..].iter().map(|part| part.0).max().unwrap_or(0);
    let is_loose = |part: u32| {
        let (area, is_changed) = found[part as usize];
        part > 0 && is_changed && area < largest && f64::from(area) < most
    };
    clear(made, &parts, |_, part| is_loose(part));
}

/// Clears the pixels, but those of the stem, of which `is_loose` says so by their index and their part.
fn clear(tree: &mut Tree, parts: &Image<u32>, is_loose: impl Fn(usize, u32) -> bool) {
    let pixels = tree.image.pixels_mut().iter_mut();
    let pixels = pixels.zip(tree.labels.pixels_mut()).zip(parts.pixels());
    for (place, ((pixel, label), &part)) in pixels.enumerate() {
        if is_loose(place, part) && *label != Label::Trunk {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
}
