//! Likelihoods at full size → labels of a tree: one trunk that stands on the ground, crown above it.
//!
//! A network looks at each place by itself; a tree hangs together. In a picture with clear ground the
//! alpha says what is tree. In a photograph the tree is the largest connected piece that looks like one.
//!
//! What is bark the network and the rules ([`Classical`], on the tree cut out) decide together, as two
//! witnesses: the odds of the one are multiplied by what the word of the other is worth. The rules know
//! nothing of trees but follow a stem to the pixel; the network knows trees but sees them small.
//!
//! The trunk is the largest piece that looks like bark among those that reach down to the foot; what
//! else looks like bark is a limb in the crown. Small pieces of crown beside the lower half of the trunk
//! are grass or doubt: trunk.

use super::super::{Classical, Label, Labels, SegmentError, Segmenter as _};
use super::again::TREE;
use super::guided::PLANES;
use super::likelihood::{CROWN, TRUNK};
use crate::base::Cancel;
use crate::raster::{Image, Mask, Rect, Straight, labelled_components};

/// Alpha from which on a pixel belongs to the tree.
pub(super) const OPAQUE: u8 = 128;

/// What the rules' opinion of a pixel is worth.
#[derive(Clone, Copy)]
struct Worth {
    /// How many times likelier it is bark when they say so.
    word: f32,
    /// And when they do not.
    silence: f32,
    /// Smallest trunk, as part of the tree's pixels. The smallest of the hand-labelled ones has 0.6 %.
    least_trunk: f64,
}

/// With clear ground: on 245 drawn trees that the rules were not made for, they name 85 % of the bark
/// and 0.3 % of the rest, which is 280 and 0.15 if the two witnesses erred apart. On the hand-labelled
/// pictures, which the rules were made for, anything from 20 and 0.4 on is better than the network
/// alone, and nothing worse than the rules alone from here on.
const OF_CUT_OUT: Worth = Worth {
    word: 55.0,
    silence: 0.05,
    least_trunk: 0.002,
};

/// In a photograph the rules follow a tree that the network has cut out, roughly.
const OF_PHOTO: Worth = Worth {
    word: 10.0,
    silence: 0.5,
    // Slivers of ground and fence below a tree are about as large as very thin trunks.
    least_trunk: 0.005,
};

/// Least likelihood of either: no network is surer than that.
const LEAST: f32 = 1e-3;

/// Part of the tree's height, from the ground, that a trunk must reach down to.
///
/// Hanging branches reach below the foot by 9 % (willows). With much more, a limb that is seen through
/// a gap of a low crown would be a trunk.
const BAND: f64 = 0.12;

/// A further piece that reaches the ground is a trunk too when it has this part of the largest one's
/// pixels: trees of several stems.
const FURTHER: f64 = 0.3;

/// Pieces of a photograph's tree that are apart from the largest one and smaller than this part of it
/// are other plants.
const LEAST_PIECE: f64 = 0.25;

/// Pieces of crown up to this part of the trunk's pixels that lie below its middle become trunk. Larger
/// ones are branches that hang down.
const ISLET: f64 = 0.1;

/// The tree in the part `crop` of a picture, and what the rules say of it.
pub(super) struct CutOut {
    tree: Mask,
    rules: Labels,
    worth: Worth,
}

impl CutOut {
    /// The tree is what is opaque.
    pub(super) fn by_alpha(
        picture: &Image<Straight>,
        crop: Rect,
        cancel: &Cancel,
    ) -> Result<Self, SegmentError> {
        Self::ruled(picture, crop, opaque(picture, crop), OF_CUT_OUT, cancel)
    }

    /// The tree is what `likelihoods`, of the pixels of `crop`, say.
    pub(super) fn by_likelihood(
        picture: &Image<Straight>,
        crop: Rect,
        likelihoods: &Image<[f32; PLANES]>,
        cancel: &Cancel,
    ) -> Result<Self, SegmentError> {
        let tree = both(&opaque(picture, crop), likelihoods, |own| {
            own[TRUNK] + own[CROWN] > TREE
        });
        Self::ruled(picture, crop, main_pieces(&tree), OF_PHOTO, cancel)
    }

    fn ruled(
        picture: &Image<Straight>,
        crop: Rect,
        tree: Mask,
        worth: Worth,
        cancel: &Cancel,
    ) -> Result<Self, SegmentError> {
        let mut cut = picture.cropped(crop.x, crop.y, crop.width, crop.height);
        for (pixel, &in_tree) in cut.pixels_mut().iter_mut().zip(tree.pixels()) {
            pixel.0[3] = if in_tree { 255 } else { 0 };
        }
        let rules = Classical.segment(&cut, cancel)?;
        Ok(Self { tree, rules, worth })
    }
}

fn opaque(picture: &Image<Straight>, crop: Rect) -> Mask {
    let columns = crop.x as usize..(crop.x + crop.width) as usize;
    let pixels = (crop.y..crop.y + crop.height)
        .flat_map(|y| &picture.row(y)[columns.clone()])
        .map(|pixel| pixel.alpha() >= OPAQUE);
    Image::from_pixels(crop.width, crop.height, pixels.collect())
}

/// The labels of `picture`, given the likelihoods of the pixels of `crop`; the rest is background.
pub(super) fn labelled(
    picture: &Image<Straight>,
    crop: Rect,
    cut: &CutOut,
    likelihoods: &Image<[f32; PLANES]>,
) -> Labels {
    let tree = &cut.tree;
    let bark = bark(tree, likelihoods, &cut.rules, &cut.worth);
    let trunk = trunk(tree, &bark, cut.worth.least_trunk);
    let mut labels = Image::filled(picture.width(), picture.height(), Label::Background);
    for y in 0..crop.height {
        let from = crop.x as usize..(crop.x + crop.width) as usize;
        let row = &mut labels.row_mut(crop.y + y)[from];
        for ((label, &in_tree), &in_trunk) in row.iter_mut().zip(tree.row(y)).zip(trunk.row(y)) {
            *label = match (in_tree, in_trunk) {
                (false, _) => Label::Background,
                (true, true) => Label::Trunk,
                (true, false) => Label::Crown,
            };
        }
    }
    labels
}

/// The pixels of `tree` that are bark to the network and the rules together.
fn bark(tree: &Mask, likelihoods: &Image<[f32; PLANES]>, rules: &Labels, worth: &Worth) -> Mask {
    let pixels = tree.pixels().iter().zip(likelihoods.pixels());
    let pixels = pixels.zip(rules.pixels());
    let pixels = pixels.map(|((&in_tree, own), &rule)| {
        let odds = match rule {
            Label::Trunk => worth.word,
            _ => worth.silence,
        };
        in_tree && own[TRUNK].max(LEAST) * odds > own[CROWN].max(LEAST)
    });
    Image::from_pixels(tree.width(), tree.height(), pixels.collect())
}

/// The pixels of `mask` whose likelihoods are as `wanted`.
fn both(
    mask: &Mask,
    likelihoods: &Image<[f32; PLANES]>,
    wanted: impl Fn(&[f32; PLANES]) -> bool,
) -> Mask {
    let pixels = mask.pixels().iter().zip(likelihoods.pixels());
    let pixels = pixels.map(|(&inside, own)| inside && wanted(own));
    Image::from_pixels(mask.width(), mask.height(), pixels.collect())
}

/// A connected piece of a mask.
#[derive(Debug, Clone, Copy)]
struct Piece {
    count: usize,
    /// The first and the last of its rows.
    top: u32,
    bottom: u32,
}

/// The piece of each pixel (0: none), and the pieces, of which the first is none.
fn pieces(mask: &Mask) -> (Image<u32>, Vec<Piece>) {
    let numbers = labelled_components(mask);
    let mut pieces = vec![
        Piece {
            count: 0,
            top: u32::MAX,
            bottom: 0,
        };
        1
    ];
    for y in 0..mask.height() {
        for &number in numbers.row(y).iter().filter(|&&number| number > 0) {
            let number = number as usize;
            if pieces.len() <= number {
                pieces.resize(number + 1, pieces[0]);
            }
            let piece = &mut pieces[number];
            piece.count += 1;
            piece.top = piece.top.min(y);
            piece.bottom = y;
        }
    }
    (numbers, pieces)
}

/// The largest piece, and others nearly as large.
fn main_pieces(tree: &Mask) -> Mask {
    let (numbers, pieces) = pieces(tree);
    let largest = pieces.iter().map(|piece| piece.count).max().unwrap_or(0);
    let least = (LEAST_PIECE * largest as f64).max(1.0);
    numbers.map(|&number| pieces[number as usize].count as f64 >= least)
}

/// The pixels of the trunk: what of `bark` is connected and stands on the ground, holes filled.
///
/// None when that is less than the share `least` of the tree.
fn trunk(tree: &Mask, bark: &Mask, least: f64) -> Mask {
    let none = || tree.map(|_| false);
    let is_occupied = |y: &u32| tree.row(*y).contains(&true);
    let rows = || 0..tree.height();
    let (Some(top), Some(foot)) = (rows().find(is_occupied), rows().rfind(is_occupied)) else {
        return none();
    };
    let (numbers, pieces) = pieces(bark);
    let ground = f64::from(foot) - BAND * f64::from(foot - top + 1);
    let stands = |piece: &Piece| f64::from(piece.bottom) >= ground;
    let counts = pieces.iter().filter(|p| stands(p)).map(|p| p.count);
    let largest = counts.max().unwrap_or(0) as f64;
    if largest < least * tree.count() as f64 || largest == 0.0 {
        return none();
    }
    let kept = |number: &u32| {
        let piece = &pieces[*number as usize];
        *number > 0 && stands(piece) && piece.count as f64 >= FURTHER * largest
    };
    with_islets(tree, numbers.map(kept))
}

/// `trunk` with the small pieces of crown beside and below it.
fn with_islets(tree: &Mask, mut trunk: Mask) -> Mask {
    let pixels = tree.pixels().iter().zip(trunk.pixels());
    let crown = pixels.map(|(&tree, &trunk)| tree && !trunk).collect();
    let (numbers, pieces) = pieces(&Image::from_pixels(tree.width(), tree.height(), crown));
    let (mut count, mut rows) = (0, 0);
    for y in 0..trunk.height() {
        let own = trunk.row(y).iter().filter(|&&inside| inside).count();
        count += own;
        rows += own as u64 * u64::from(y);
    }
    let middle = rows as f64 / count.max(1) as f64;
    let is_islet =
        |piece: &Piece| piece.count as f64 <= ISLET * count as f64 && f64::from(piece.top) > middle;
    for (inside, &number) in trunk.pixels_mut().iter_mut().zip(numbers.pixels()) {
        *inside |= number > 0 && is_islet(&pieces[number as usize]);
    }
    trunk
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Likelihoods drawn in characters: `|` bark, `#` foliage, `.` neither.
    fn drawn(rows: &[&str]) -> Image<[f32; PLANES]> {
        let pixels = rows.iter().flat_map(|row| row.bytes()).map(|b| match b {
            b'|' => [0.99, 0.01],
            b'#' => [0.01, 0.99],
            _ => [0.1, 0.1],
        });
        Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels.collect())
    }

    fn of(rows: &[&str], has_alpha: bool) -> Vec<String> {
        let likelihoods = drawn(rows);
        let picture = likelihoods.map(|own| {
            let is_clear = has_alpha && own[TRUNK] + own[CROWN] < 0.5;
            Straight([90, 90, 90, if is_clear { 0 } else { 255 }])
        });
        let crop = picture.rect();
        let cancel = Cancel::new();
        let cut = if has_alpha {
            CutOut::by_alpha(&picture, crop, &cancel)
        } else {
            CutOut::by_likelihood(&picture, crop, &likelihoods, &cancel)
        };
        let labels = labelled(&picture, crop, &cut.unwrap(), &likelihoods);
        let rows = (0..labels.height()).map(|y| {
            let row = labels.row(y).iter();
            row.map(|label| match label {
                Label::Background => '.',
                Label::Trunk => '|',
                Label::Crown => '#',
            })
            .collect()
        });
        rows.collect()
    }

    #[test]
    fn bark_in_the_crown_is_no_trunk() {
        let rows = ["##|##", "#####", "..|..", "..|.."];
        assert_eq!(of(&rows, true), ["#####", "#####", "..|..", "..|.."]);
    }

    #[test]
    fn grass_at_the_foot_is_trunk() {
        let rows = [
            "#######", "#######", "#######", "..|||..", "..|||..", "..|||..", "..|||..", ".#|||..",
        ];
        assert_eq!(of(&rows, true)[7], ".||||..");
        assert_eq!(of(&rows, true)[2], "#######");
    }

    #[test]
    fn a_photograph_keeps_one_tree() {
        let rows = ["####...", "####...", ".||...#", ".||...|"];
        assert_eq!(
            of(&rows, false),
            ["####...", "####...", ".||....", ".||...."]
        );
    }

    #[test]
    fn two_stems_on_the_ground_are_both_trunk() {
        let rows = ["######", "######", ".|..|.", ".|..|."];
        assert_eq!(of(&rows, true)[3], ".|..|.");
    }

    #[test]
    fn pictures_without_tree_or_trunk_are_no_trouble() {
        assert_eq!(of(&["...", "..."], false), ["...", "..."]);
        assert_eq!(of(&["###", "###"], true), ["###", "###"]);
    }
}
