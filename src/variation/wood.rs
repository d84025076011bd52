//! The wood that shows in a crown: the stem's upper part and its thick limbs.
//!
//! Labels call it crown, since leaves hang around it; an eye follows it from the foot to the top. It is told from
//! leaves by the colours of the bark below ([`BarkLikelihood`]), smoothed, since both are speckled, with two thresholds
//! as edges are followed (J. Canny, *A computational approach to edge detection*, 1986): what is surely bark, and what
//! is likely bark and hangs together with that.
//!
//! Limits: where leaves have the colours of bark, as on bare trees and under snow, none is told; a clump of leaves in
//! deep shade may be taken for a dark bough, and stays.

use super::Tree;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, dilated, labelled_components, smoothed};
use crate::segment::{BarkLikelihood, Label};

/// Fewest pixels of a trunk that tell the colours of its bark.
const LEAST_TRUNK: usize = 30;

/// How far one pixel counts for or against bark, in natural logarithms; what is no tree counts against it.
const VOICE: f32 = 2.0;
const SKY: f32 = -1.0;

/// Standard deviation of the Gaussian that smooths those, in cell sizes.
const SMOOTHED: f64 = 0.035;

/// From which the mean is surely bark, and likely.
const SURE: f32 = 0.6;
const LIKELY: f32 = 0.15;

/// Least length of a piece's sure part, across or down, in cell sizes: leaves are shorter.
const SHORTEST: f64 = 0.35;

/// How far the soft edges of wood reach, in cell sizes.
const EDGE: f64 = 0.02;

/// Where wood shows in the crown of `tree`, its soft edges included; `side` is the size of a cell, pixels.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn wood(tree: &Tree, side: f64, cancel: &Cancel) -> Result<Mask, Cancelled> {
    let Some(bark) = bark_of(tree) else {
        return Ok(tree.labels.map(|_| false));
    };
    let pixels = tree.image.pixels().iter().zip(tree.labels.pixels());
    let voices = pixels.map(|(&pixel, label)| match label {
        Label::Crown if pixel.alpha() >= 128 => bark.of(pixel).clamp(-VOICE, VOICE),
        // What goes on above the trunk is wood.
        Label::Trunk => VOICE,
        _ => SKY,
    });
    let (width, height) = (tree.image.width(), tree.image.height());
    let voices = Image::from_pixels(width, height, voices.collect());
    let told = smoothed(&voices, SMOOTHED * side, cancel)?;
    let likely = told.pixels().iter().zip(tree.labels.pixels());
    let likely = likely.map(|(&voice, label)| voice > LIKELY && *label == Label::Crown);
    let likely = Image::from_pixels(width, height, likely.collect());
    let kept = long_enough(&likely, &told, SHORTEST * side);
    Ok(dilated(&kept, (EDGE * side).ceil().min(60.0) as u8))
}

/// Lays the `wood` of `tree` over what was `made` of it.
pub(super) fn keep(wood: &Mask, tree: &Tree, made: &mut Tree) {
    let own = tree.image.pixels().iter().zip(tree.labels.pixels());
    let new = made
        .image
        .pixels_mut()
        .iter_mut()
        .zip(made.labels.pixels_mut());
    for ((is_wood, own), new) in wood.pixels().iter().zip(own).zip(new) {
        // Soft edges that stayed would become harder.
        if *is_wood && *own.0 != *new.0 {
            *new.0 = own.0.over(*new.0);
            *new.1 = if own.0.alpha() >= 128 { *own.1 } else { *new.1 };
        }
    }
}

/// Whether the colours of its trunk tell wood from leaves in the crown of `tree`.
pub(super) fn tells_bark(tree: &Tree) -> bool {
    bark_of(tree).is_some()
}

/// What the colours of the trunk tell; `None` where they tell nothing.
fn bark_of(tree: &Tree) -> Option<BarkLikelihood> {
    let of = |wanted: Label| {
        let pixels = tree.image.pixels().iter().zip(tree.labels.pixels());
        let of_label =
            pixels.filter(move |(pixel, label)| **label == wanted && pixel.alpha() >= 128);
        of_label.map(|(pixel, _)| *pixel)
    };
    if of(Label::Trunk).take(LEAST_TRUNK).count() < LEAST_TRUNK {
        return None;
    }
    let bark = BarkLikelihood::learned(of(Label::Trunk), of(Label::Crown));
    bark.is_distinct().then_some(bark)
}

/// The pieces of `likely` whose sure part is at least so long.
fn long_enough(likely: &Mask, told: &Image<f32>, shortest: f64) -> Mask {
    let pieces = labelled_components(likely);
    let count = pieces.pixels().iter().copied().max().unwrap_or(0) as usize;
    // Left, top, right, bottom of the sure part.
    let mut boxes = vec![[u32::MAX, u32::MAX, 0, 0]; count + 1];
    for y in 0..likely.height() {
        for (x, (&piece, &voice)) in (0..).zip(pieces.row(y).iter().zip(told.row(y))) {
            if voice > SURE {
                let [left, top, right, bottom] = &mut boxes[piece as usize];
                (*left, *top) = ((*left).min(x), (*top).min(y));
                (*right, *bottom) = ((*right).max(x + 1), (*bottom).max(y + 1));
            }
        }
    }
    let is_long = |&[left, top, right, bottom]: &[u32; 4]| {
        let longer = right.saturating_sub(left).max(bottom.saturating_sub(top));
        f64::from(longer) >= shortest
    };
    let is_kept: Vec<bool> = boxes.iter().map(is_long).collect();
    pieces.map(|&piece| piece > 0 && is_kept[piece as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Straight;

    const BARK: Straight = Straight([110, 80, 60, 255]);
    const LEAF: Straight = Straight([50, 120, 40, 255]);

    /// A trunk below a crown of this colour, in which the leader and a brown leaf show.
    fn tree(leaves: Straight) -> Tree {
        let (mut image, mut labels) = (
            Image::filled(128, 128, Straight([0; 4])),
            Image::filled(128, 128, Label::Background),
        );
        for y in 0..128u32 {
            for x in 0..128u32 {
                let is_stem = (60..68).contains(&x);
                let (pixel, label) = match y {
                    100.. if is_stem => (BARK, Label::Trunk),
                    100.. => continue,
                    40..80 if is_stem => (BARK, Label::Crown),
                    30..34 if (20..24).contains(&x) => (BARK, Label::Crown),
                    _ => (leaves, Label::Crown),
                };
                image.set(x, y, pixel);
                labels.set(x, y, label);
            }
        }
        Tree { image, labels }
    }

    #[test]
    fn the_leader_is_wood_and_leaves_are_not() {
        let found = wood(&tree(LEAF), 16.0, &Cancel::new()).unwrap();
        assert!((42..78).all(|y| (60..68).all(|x| found.at(x, y))));
        assert!(!found.at(50, 60) && !found.at(64, 90) && !found.at(22, 32));
        assert!(!found.at(64, 110), "labels tell the trunk");
    }

    #[test]
    fn nothing_is_told_where_leaves_have_the_colours_of_bark() {
        let found = wood(&tree(BARK), 16.0, &Cancel::new()).unwrap();
        assert_eq!(found.count(), 0);
        let mut shrub = tree(LEAF);
        shrub.labels = shrub.labels.map(|label| match label {
            Label::Trunk => Label::Crown,
            other => *other,
        });
        assert_eq!(wood(&shrub, 16.0, &Cancel::new()).unwrap().count(), 0);
    }
}
