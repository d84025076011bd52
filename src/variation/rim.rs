//! What stands along the outline of a tree whose foliage was grown anew.
//!
//! Near the outline alpha is that of the swayed tree, so that no cell's border shows against the sky.

use super::Tree;
use super::habit::Habit;
use super::noise::Noise;
use super::sway::without_gaps;
use crate::base::{Cancel, Cancelled, Random};
use crate::raster::{Image, Straight, labelled_components, smoothed_within};
use crate::segment::Label;
use rayon::prelude::*;

/// Standard deviation of the Gaussian that tells how deep in the crown a pixel lies, in cell sizes; on the
/// outline it gives 0.5. Up to [`INSIDE`] leaves stand as they grew, below [`OUTSIDE`] is sky.
const BAND: f64 = 0.22;
const INSIDE: f32 = 0.88;
const OUTSIDE: f32 = 0.06;

/// How far out leaves may stand there: up to this, by noise of waves as long as these, in cell sizes.
const OUTERMOST: f32 = 0.85;
const REACHES: [f64; 2] = [0.4, 0.07];

/// How much farther out leaves stand that are twice as light as the mean, or none at all: so that what is in front
/// ends as leaves do, not along a line.
const LEAFY: f32 = 0.3;

/// The same from which on gaps in the new foliage are gaps of the tree.
const DEEP: f32 = 0.997;

/// In what stands straight the depth up to which sky stays sky and a bough a bough: they end in tips, with
/// gaps between.
const KEPT: f32 = 0.97;

/// Side of the largest square of leaves, in cell sizes, that hang in the air.
const LOOSE: f64 = 0.35;

/// The foliage of `grown` in the tree `tree`. Along the outline leaves stand as they grew, more or less far
/// out from place to place, and the tips of `tree`'s own twigs stay; a little deeper a cell may show sky
/// that belongs beyond it, and there `tree` fills it.
pub(super) fn within_outline(
    (tree, habit): (&Tree, &Habit),
    grown: &Tree,
    side: f64,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<(Tree, Image<f32>), Cancelled> {
    let alpha = without_gaps(&tree.image, side).map(|&inside| f32::from(u8::from(inside)));
    let everywhere = alpha.map(|_| true);
    let inside = smoothed_within(&alpha, &everywhere, BAND * side, cancel)?;
    let reach = Noise::new(random);
    let keeps_outline = habit.is_straight();
    let mean = mean_light(&grown.image);
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
                let depth = inside[x];
                let is_leaf = foliage[x].alpha() >= 128;
                let takes = if keeps_outline && depth < KEPT {
                    is_leaf && pixels[x].alpha() >= 96
                } else if depth < 0.5 {
                    let at = |wave: f64| reach.at([x, y].map(|along| along as f64 / (wave * side)));
                    let [wide, fine] = REACHES.map(at);
                    let least = OUTERMOST * (0.65 * wide + 0.35 * fine) as f32;
                    let leafy = LEAFY * (foliage[x].luma() / mean - 1.0).clamp(-1.0, 1.0);
                    is_leaf && depth > OUTSIDE && depth + leafy > reached.max(least)
                } else {
                    is_leaf || !(INSIDE..DEEP).contains(&depth)
                };
                if takes {
                    (pixels[x], labels[x]) = (foliage[x], foliage_labels[x]);
                }
            }
        },
    );
    Ok((result, inside))
}

/// The mean light of all that is opaque.
fn mean_light(image: &Image<Straight>) -> f32 {
    let opaque = || image.pixels().iter().filter(|pixel| pixel.alpha() >= 128);
    let sum: f64 = opaque().map(|pixel| f64::from(pixel.luma())).sum();
    (sum / opaque().count().max(1) as f64).max(1.0) as f32
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
    let pixels = tree.image.pixels_mut().iter_mut();
    let places = parts.pixels().iter().zip(inside.pixels());
    for ((pixel, label), (&part, &inside)) in pixels.zip(tree.labels.pixels_mut()).zip(places) {
        if inside < 0.5 && is_loose(part) && *label != Label::Trunk {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
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
    let pixels = made.image.pixels_mut().iter_mut();
    for ((pixel, label), &part) in pixels.zip(made.labels.pixels_mut()).zip(parts.pixels()) {
        if is_loose(part) && *label != Label::Trunk {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
}
