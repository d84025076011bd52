//! Leaves that fall, and the limbs behind them.
//!
//! Leaves vanish in the order in which they turn; what is wood by its colour stays, but for specks
//! and what hangs on nothing. Behind it stand limbs grown into the crown's own outline
//! ([`super::growth`]), in the colours of the trunk ([`super::bark`]).

use super::bark::{Bark, paint};
use super::colors;
use super::growth::{Stem, grown};
use super::leaves::{Leaves, is_green_leaf};
use crate::base::{Cancel, Cancelled, Seed};
use crate::raster::{Image, Straight, component_sizes, labelled_components};
use crate::segment::Label;
use crate::variation::Tree;
use crate::variation::wood::tells_bark;

/// Smallest remaining speck, as a share of the crown's pixels: smaller ones fall with the leaves.
const SPECK: f64 = 0.0004;

/// Largest piece, as such a share, that falls when it hangs on no limb: a few leaves as long as there are many, and
/// clumps when all fall.
const LOOSE: f64 = 0.004;
const LOOSE_CLUMP: f64 = 0.02;

/// Share of fallen leaves from which the twigs between them go, too, where bark can be told from leaves: what is seen
/// of them is bits, which the limbs behind do not hold.
const TWIGS_FALL: f64 = 0.85;

/// Alpha from which on a pixel is a part of something, and from which on it is seen at all: many a
/// picture's ground has a few units.
const SEEN: u8 = 72;
const FAINT: u8 = 9;

/// Takes the leaves off `tree`, that share of them.
pub(super) fn undress(
    tree: &mut Tree,
    leaves: &Leaves,
    amount: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let stem = Stem::of(tree, leaves);
    let bark = Bark::of(tree, &stem);
    let skeleton = grown(leaves, &stem, seed, cancel)?;
    let mut limbs = Image::filled(tree.image.width(), tree.image.height(), Straight([0; 4]));
    paint(&mut limbs, &skeleton, &stem, &bark, seed, cancel)?;
    if amount < 1.0 {
        colors::turn(tree, leaves, super::Season::Autumn, 1.0, None, seed, cancel)?;
    }
    drop_leaves(tree, leaves, amount, seed, cancel)?;
    uncover(tree, &stem, amount);
    for (pixel, limb) in tree.image.pixels_mut().iter_mut().zip(limbs.pixels()) {
        *pixel = pixel.over(*limb);
    }
    for (label, pixel) in tree.labels.pixels_mut().iter_mut().zip(tree.image.pixels()) {
        if *label == Label::Background && pixel.alpha() >= 128 {
            *label = Label::Crown;
        }
    }
    clear_loose(tree, leaves, amount);
    Ok(())
}

/// Makes leaves clear in the order in which they turn, then the specks that are left.
fn drop_leaves(
    tree: &mut Tree,
    leaves: &Leaves,
    amount: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let fallen = colors::turned_shares(tree, leaves, amount, seed, cancel)?;
    let twigs = match amount > TWIGS_FALL && tells_bark(tree) {
        true => (amount - TWIGS_FALL) / (1.0 - TWIGS_FALL),
        false => 0.0,
    };
    let pixels = tree.image.pixels_mut().iter_mut().zip(&fallen);
    let shares = leaves.share.pixels().iter().zip(tree.labels.pixels());
    for ((pixel, fallen), (share, label)) in pixels.zip(shares) {
        let leaf = ((f64::from(*share) - 0.12) / 0.3).clamp(0.0, 1.0);
        let leaf = match label {
            Label::Crown => leaf.max(twigs),
            _ => leaf,
        };
        pixel.0[3] = (f64::from(pixel.alpha()) * (1.0 - fallen * leaf) + 0.5) as u8;
    }
    let seen = tree.image.map(|pixel| pixel.alpha() >= SEEN);
    let parts = labelled_components(&seen);
    let sizes = component_sizes(&parts);
    let least = least_piece(leaves);
    let labels = tree.labels.pixels().iter();
    let parts = parts.pixels().iter().zip(seen.pixels()).zip(labels);
    for (pixel, ((part, seen), label)) in tree.image.pixels_mut().iter_mut().zip(parts) {
        let is_speck = !seen || sizes[*part as usize] < least;
        if *label != Label::Trunk && is_speck {
            pixel.0[3] = 0;
        }
    }
    Ok(())
}

/// Takes the leaves off the trunk where the limbs' stem stands behind it.
fn uncover(tree: &mut Tree, stem: &Stem, amount: f64) {
    let width = tree.image.width() as usize;
    let rows = 0..(stem.foot.y.max(0.0) as usize * width).min(tree.image.pixels().len());
    let pixels = &mut tree.image.pixels_mut()[rows.clone()];
    for (pixel, label) in pixels.iter_mut().zip(&tree.labels.pixels()[rows]) {
        if *label == Label::Trunk && is_green_leaf(*pixel) {
            pixel.0[3] = (f64::from(pixel.alpha()) * (1.0 - amount) + 0.5) as u8;
        }
    }
}

/// Clears what hangs on nothing, and what is faint of leaves before the trunk.
fn clear_loose(tree: &mut Tree, leaves: &Leaves, amount: f64) {
    let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= SEEN));
    let sizes = component_sizes(&parts);
    let largest = (1..sizes.len()).max_by_key(|&part| sizes[part]);
    let most = LOOSE_CLUMP.min(LOOSE / (1.0 - amount).max(1e-3)) * leaves.count() as f64;
    let pixels = tree.image.pixels_mut().iter_mut().zip(parts.pixels());
    for ((pixel, &part), label) in pixels.zip(tree.labels.pixels_mut()) {
        let is_loose = match part as usize {
            0 => *label == Label::Trunk,
            part => Some(part) != largest && sizes[part] as f64 <= most,
        };
        if is_loose && (*label != Label::Trunk || is_green_leaf(*pixel)) {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
    clear_crumbs(tree, least_piece(leaves));
}

/// Clears what is left of that: pieces, with all that is faint about them, of which fewer than `least`
/// pixels are seen.
fn clear_crumbs(tree: &mut Tree, least: usize) {
    let pieces = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= FAINT));
    let mut seen = vec![0; component_sizes(&pieces).len()];
    for (pixel, &piece) in tree.image.pixels().iter().zip(pieces.pixels()) {
        seen[piece as usize] += usize::from(pixel.alpha() >= SEEN);
    }
    let pixels = tree.image.pixels_mut().iter_mut().zip(pieces.pixels());
    for ((pixel, &piece), label) in pixels.zip(tree.labels.pixels_mut()) {
        if piece > 0 && seen[piece as usize] < least {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
}

/// Pixels of a piece that is more than a speck.
fn least_piece(leaves: &Leaves) -> usize {
    ((SPECK * leaves.count() as f64) as usize).max(12)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crumbs_go_and_what_touches_a_limb_stays() {
        let rows = ["###+....", "###...#.", "###.....", ".....++."];
        let pixels = rows.iter().flat_map(|row| row.bytes()).map(|b| match b {
            b'#' => Straight([90, 80, 70, 255]),
            b'+' => Straight([90, 80, 70, 40]),
            _ => Straight([0, 0, 0, 5]),
        });
        let image = Image::from_pixels(8, 4, pixels.collect());
        let labels = image.map(|_| Label::Trunk);
        let mut tree = Tree { image, labels };
        clear_crumbs(&mut tree, 4);
        let alpha: Vec<u8> = tree.image.pixels().iter().map(|p| p.alpha()).collect();
        assert_eq!(alpha[..8], [255, 255, 255, 40, 5, 5, 5, 5]);
        assert_eq!((alpha[14], alpha[29], alpha[30]), (0, 0, 0));
        assert_eq!(tree.labels.at(6, 1), Label::Background);
    }

    #[test]
    fn fruit_and_bits_of_twigs_fall_with_the_last_leaves() {
        let [fruit, twig] = [[200, 30, 40, 255], [90, 60, 45, 255]].map(Straight);
        let mut tree = Tree {
            image: Image::filled(96, 128, Straight([0; 4])),
            labels: Image::filled(96, 128, Label::Background),
        };
        for y in 4..128u32 {
            for x in 8..88u32 {
                let is_stem = (44..52).contains(&x);
                let (pixel, label) = match y {
                    84.. if is_stem => (twig, Label::Trunk),
                    84.. => continue,
                    _ if x % 20 < 8 && y % 20 < 8 => (fruit, Label::Crown),
                    _ if x % 20 >= 14 && y % 20 >= 14 => (twig, Label::Crown),
                    _ => (
                        Straight([60, 130 - (x + y) as u8 % 20, 40, 255]),
                        Label::Crown,
                    ),
                };
                tree.image.set(x, y, pixel);
                tree.labels.set(x, y, label);
            }
        }
        let cancel = Cancel::new();
        let leaves = Leaves::of(&tree, &cancel).unwrap().unwrap();
        let left = |amount: f64| {
            let mut bare = tree.clone();
            undress(&mut bare, &leaves, amount, Seed(1), &cancel).unwrap();
            let seen = bare
                .image
                .pixels()
                .iter()
                .filter(|pixel| pixel.alpha() >= 128);
            seen.filter(|pixel| pixel.0[0] > 150 && pixel.0[1] < 80)
                .count()
        };
        assert!(left(0.5) > 0);
        assert_eq!(left(1.0), 0);
    }
}
