//! What stands along the outline of a tree whose foliage was grown anew, and bits that hang in the air.
//!
//! The cells there show an outline of their own, which runs as the tree's does. In what stands straight alpha is
//! that of the swayed tree, so that no cell's border shows against the sky.

use super::Tree;
use super::habit::Habit;
use super::rounded::without_gaps;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight, component_sizes, dilated, labelled_components, smoothed};
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
const LOOSE: f64 = 0.6;

/// Largest piece that is torn off, as a share of the tree.
const TORN: f64 = 0.002;

/// Alpha from which pixels hang together, and how far fainter ones lie around them, pixels.
const SEEN: u8 = 48;
const SOFT_EDGE: u8 = 3;

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

/// Clears what hangs in the air, leaves of a cell whose twig lies in another: beyond the outline, and within it what is
/// larger than anything that hung so in `before`.
pub(super) fn clear_loose_leaves(tree: &mut Tree, before: &Tree, inside: &Image<f32>, side: f64) {
    let hung = largest_hanging(&before.image, |pixel| pixel.alpha());
    let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= SEEN));
    let sizes = component_sizes(&parts);
    let mut deepest = vec![0.0f32; sizes.len()];
    for (&part, &inside) in parts.pixels().iter().zip(inside.pixels()) {
        deepest[part as usize] = deepest[part as usize].max(inside);
    }
    let most = LOOSE * side * LOOSE * side;
    let is_loose = |part: u32| {
        let size = sizes[part as usize];
        (size as f64) < most && (deepest[part as usize] < 0.5 || size > hung)
    };
    clear_all(tree, &parts, is_loose);
}

/// Clears what a warp tears off: bits of stem beside it, and leaves in pieces of more pixels than hung in the air
/// before.
pub(super) fn clear_torn(tree: &mut Tree, hung: usize) {
    let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= SEEN));
    let sizes = component_sizes(&parts);
    let mut of_crown = vec![0usize; sizes.len()];
    for (&part, label) in parts.pixels().iter().zip(tree.labels.pixels()) {
        of_crown[part as usize] += usize::from(*label == Label::Crown);
    }
    let most = TORN * sizes.iter().skip(1).sum::<usize>() as f64;
    let is_torn = |part: u32| {
        let (size, of_crown) = (sizes[part as usize], of_crown[part as usize]);
        (size as f64) < most && (2 * of_crown < size || size > hung)
    };
    if (1..sizes.len() as u32).any(is_torn) {
        clear_all(tree, &parts, is_torn);
    }
}

/// Pixels of the largest piece of `image` that hangs in the air.
pub(super) fn largest_hanging<P: Copy>(image: &Image<P>, alpha: impl Fn(&P) -> u8) -> usize {
    let parts = labelled_components(&image.map(|pixel| alpha(pixel) >= SEEN));
    let mut sizes = component_sizes(&parts)[1..].to_vec();
    sizes.sort_unstable();
    sizes.iter().rev().nth(1).copied().unwrap_or(0)
}

/// Clears the parts, whatever their labels, of which `is_loose` says so, and what is faint and not about others.
fn clear_all(tree: &mut Tree, parts: &Image<u32>, is_loose: impl Fn(u32) -> bool) {
    let stays = parts.map(|&part| part > 0 && !is_loose(part));
    let soft = dilated(&stays, SOFT_EDGE);
    clear(tree, parts, |place, part, _| match part {
        0 => !soft.pixels()[place],
        _ => is_loose(part),
    });
}

/// Clears what hangs in the air and did not stand there in `before`, up to so many pixels a piece.
pub(super) fn clear_new_loose(made: &mut Tree, before: &Tree, most: f64) {
    let parts = labelled_components(&made.image.map(|pixel| pixel.alpha() >= SEEN));
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
    clear(made, &parts, |_, part, label| {
        is_loose(part) && label != Label::Trunk
    });
}

/// Clears the pixels of which `is_loose` says so by their index, their part and their label.
fn clear(tree: &mut Tree, parts: &Image<u32>, is_loose: impl Fn(usize, u32, Label) -> bool) {
    let pixels = tree.image.pixels_mut().iter_mut();
    let pixels = pixels.zip(tree.labels.pixels_mut()).zip(parts.pixels());
    for (place, ((pixel, label), &part)) in pixels.enumerate() {
        if is_loose(place, part, *label) {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Rect;

    const LEAF: Straight = Straight([50, 120, 40, 255]);
    const FAINT: Straight = Straight([50, 120, 40, 20]);

    fn fill(tree: &mut Tree, place: Rect, pixel: Straight, label: Label) {
        for y in place.y..place.y + place.height {
            for x in place.x..place.x + place.width {
                tree.image.set(x, y, pixel);
                tree.labels.set(x, y, label);
            }
        }
    }

    fn square(x: u32, y: u32, side: u32) -> Rect {
        Rect {
            x,
            y,
            width: side,
            height: side,
        }
    }

    #[test]
    fn nothing_hangs_in_the_air_that_did_not() {
        let mut before = Tree {
            image: Image::filled(100, 100, Straight([0; 4])),
            labels: Image::filled(100, 100, Label::Background),
        };
        fill(&mut before, square(10, 10, 60), LEAF, Label::Crown);
        // A leaf that hung in the air.
        fill(&mut before, square(80, 20, 3), LEAF, Label::Crown);
        let mut made = before.clone();
        // One that did not, with its soft edge, part of which is called trunk; and the soft edge of the crown.
        fill(&mut made, square(78, 48, 9), FAINT, Label::Background);
        fill(&mut made, square(80, 50, 5), LEAF, Label::Crown);
        fill(&mut made, square(80, 50, 2), LEAF, Label::Trunk);
        fill(&mut made, square(70, 30, 2), FAINT, Label::Crown);
        let deep = made.image.map(|_| 1.0);
        clear_loose_leaves(&mut made, &before, &deep, 20.0);
        fill(&mut before, square(70, 30, 2), FAINT, Label::Crown);
        assert_eq!(made, before);
        // Beyond the outline not even that.
        clear_loose_leaves(&mut made, &before, &deep.map(|_| 0.0), 20.0);
        assert_eq!(made.image.at(81, 21).alpha(), 0);
        assert_eq!(made.image.at(20, 20), LEAF);
    }

    #[test]
    fn what_a_warp_tears_off_goes() {
        let mut tree = Tree {
            image: Image::filled(200, 200, Straight([0; 4])),
            labels: Image::filled(200, 200, Label::Background),
        };
        fill(&mut tree, square(20, 10, 120), LEAF, Label::Crown);
        fill(&mut tree, square(150, 20, 4), LEAF, Label::Crown);
        let whole = tree.clone();
        fill(&mut tree, square(170, 150, 2), LEAF, Label::Trunk);
        fill(&mut tree, square(160, 60, 5), LEAF, Label::Crown);
        assert_eq!(largest_hanging(&whole.image, |pixel| pixel.alpha()), 16);
        clear_torn(&mut tree, 16);
        assert_eq!(tree, whole);
        // A second tree is none of that.
        fill(&mut tree, square(150, 100, 40), LEAF, Label::Crown);
        let both = tree.clone();
        clear_torn(&mut tree, 0);
        assert_eq!(tree.image.at(160, 120), both.image.at(160, 120));
        assert_eq!(tree.image.at(151, 21).alpha(), 0);
    }
}
