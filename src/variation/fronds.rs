//! Another individual of a palm: its fronds stand elsewhere, reach farther or less far, hang more or less.
//!
//! A palm's crown is a few large leaves about one heart, the top of its stem. Cut into cells, as other
//! crowns are (`individual`), they would lie about in pieces. So the picture is turned about the heart
//! instead, in polar coordinates: fronds close up or open out like a fan whose order stays (the turn grows
//! with the angle, so nothing folds), each with a length and a droop of its own. A second layer, the same
//! crown mirrored and turned otherwise, stands before the first in some directions and behind it in others;
//! where both could be, the lighter frond is in front. Where the crown is not alike on both sides (twin
//! palms) it is left out, and about another stem's end fronds stay where they are.
//!
//! Limits: one heart, the top of the stem's label; a frond that crosses straight below the heart stays.

use super::fan::{Fan, Heart, on_circle};
use super::joint::Behind;
use super::noise::Noise;
use super::sway::between_pixels;
use super::{Tree, named};
use crate::base::{Cancel, Cancelled, Random};
use crate::raster::{Image, Mask, Straight, smoothed};
use crate::segment::Label;
use rayon::prelude::*;

/// Words in names of pictures by which palms, and what grows like them, are known.
const WORDS: [(&str, bool); 10] = [
    // Leaves like hands.
    ("palmate", false),
    ("palm", true),
    ("phoenix", true),
    ("cocos", true),
    ("coconut", true),
    ("washingtonia", true),
    ("trachycarpus", true),
    ("cyca", true),
    ("dracaena", true),
    ("yucca", true),
];

/// Waves around the heart in which one layer or the other is in front.
const WAVES: f64 = 5.0;

/// How much shorter the second layer is: fewer of its fronds stand out.
const SHORTER: f64 = 0.18;

/// How much the light of a frond counts for its being in front, against the wave's height of 1: less, or
/// bright tips of a layer lie about as islands.
const LIGHT: f32 = 0.7;

/// Light of what lies behind.
const BEHIND: f32 = 0.8;

/// Standard deviation over which light is compared, as a share of the crown's reach.
const LEAFLET: f64 = 0.02;

/// Least likeness (intersection over union) of a crown with its mirror image for a second layer.
const LEAST_LIKE: f64 = 0.6;

/// Whether the name of a picture says that its tree's crown is of fronds.
///
/// ```
/// use boscage::variation::has_fronds;
/// assert!(has_fronds("twin_palm_04.png") && has_fronds("Phoenix canariensis.webp"));
/// assert!(!has_fronds("maple_palmate.png"));
/// ```
pub fn has_fronds(name: &str) -> bool {
    named(name, &WORDS).unwrap_or(false)
}

/// Turns the fronds of `tree` about its heart; whether it has one. The same draws are made whatever the
/// strength.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn turned(
    tree: &mut Tree,
    strength: f64,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<bool, Cancelled> {
    let Some(heart) = Heart::of(tree) else {
        return Ok(false);
    };
    let behind = Behind::of(tree, heart.top());
    let held: Vec<f64> = behind
        .others
        .iter()
        .map(|end| heart.polar(*end)[1])
        .collect();
    let frame = [tree.image.width(), tree.image.height()].map(|side| f64::from(side) - 1.0);
    let [first, second] = [0.0, SHORTER].map(|shorter| {
        let fan = Fan::new(shorter, strength, &held, random);
        fan.within(&heart, frame)
    });
    let order = Noise::new(random);
    let fronds = without(&tree.image, &behind.stem);
    let light = light(&fronds, LEAFLET * heart.reach, cancel)?;
    let has_second = heart.likeness(&fronds) >= LEAST_LIKE;
    // From a quarter of the strength on all of it.
    let second_share = (4.0 * strength).min(1.0);
    let width = tree.image.width() as usize;
    let rows = tree.image.pixels_mut().par_chunks_mut(width);
    rows.zip(tree.labels.pixels_mut().par_chunks_mut(width))
        .enumerate()
        .try_for_each(|(y, (pixels, labels))| {
            cancel.check()?;
            for (x, (pixel, label)) in pixels.iter_mut().zip(labels).enumerate() {
                let at = heart.polar([x as f64, y as f64]);
                let seen = |fan: &Fan, side: f64| {
                    let [u, v] = heart.place(fan.source(&heart, at), side);
                    let near = |value: f64| (value + 0.5).floor() as i64;
                    let light = light.get(near(u), near(v)).unwrap_or(0.0);
                    (between_pixels(&fronds, u, v), light)
                };
                let (own, own_light) = seen(&first, 1.0);
                let crown = if has_second {
                    let (other, other_light) = seen(&second, -1.0);
                    let wave = on_circle(&order, WAVES, at[1]) as f32;
                    // Without strength the first hides the second.
                    let ahead = wave + LIGHT * (other_light - own_light);
                    if ahead > 1.0 - strength as f32 {
                        other.over(dimmed(own, 1.0))
                    } else {
                        own.over(dimmed(other, second_share))
                    }
                } else {
                    own
                };
                let (x, y) = (x as u32, y as u32);
                *pixel = crown.over(behind.image.at(x, y));
                *label = match (crown.alpha() >= 96, behind.is_stem.at(x, y)) {
                    (true, _) => Label::Crown,
                    (false, true) => Label::Trunk,
                    (false, false) => Label::Background,
                };
            }
            Ok(())
        })?;
    Ok(true)
}

/// The picture clear where `mask` is.
fn without(image: &Image<Straight>, mask: &Mask) -> Image<Straight> {
    let mut image = image.clone();
    for (pixel, _) in image
        .pixels_mut()
        .iter_mut()
        .zip(mask.pixels())
        .filter(|(_, is)| **is)
    {
        *pixel = Straight([0; 4]);
    }
    image
}

/// How light fronds are, 0 to 1, smoothed; where there are none 0.
fn light(fronds: &Image<Straight>, sigma: f64, cancel: &Cancel) -> Result<Image<f32>, Cancelled> {
    let light = fronds.map(|pixel| pixel.luma() / 255.0 * f32::from(pixel.alpha()) / 255.0);
    smoothed(&light, sigma, cancel)
}

/// As it is behind another frond, `share` of it seen.
fn dimmed(pixel: Straight, share: f64) -> Straight {
    let [r, g, b, alpha] = pixel.0;
    let scaled = |value: u8| (f32::from(value) * BEHIND + 0.5) as u8;
    let alpha = (f64::from(alpha) * share + 0.5) as u8;
    Straight([scaled(r), scaled(g), scaled(b), alpha])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use crate::raster::labelled_components;
    use crate::variation::maker::grown as sample;

    fn individual(tree: &Tree, strength: f64, seed: u64) -> Tree {
        let mut tree = tree.clone();
        let mut random = Seed(seed).random();
        assert!(turned(&mut tree, strength, &mut random, &Cancel::new()).unwrap());
        tree
    }

    fn leaves(tree: &Tree) -> f64 {
        let leaves = tree.image.pixels().iter().zip(tree.labels.pixels());
        leaves
            .filter(|(pixel, label)| pixel.alpha() >= 96 && **label == Label::Crown)
            .count() as f64
    }

    /// Share of the tree that hangs in the air.
    fn loose(tree: &Tree) -> f64 {
        let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= 48));
        let mut areas = vec![0u32; 1 + parts.pixels().iter().copied().max().unwrap() as usize];
        parts
            .pixels()
            .iter()
            .for_each(|&part| areas[part as usize] += 1);
        let all: u32 = areas[1..].iter().sum();
        1.0 - f64::from(*areas[1..].iter().max().unwrap()) / f64::from(all)
    }

    #[test]
    fn fronds_stay_whole_and_stand_elsewhere() {
        let palm = sample("palm");
        let (before, own_loose) = (leaves(&palm), loose(&palm));
        for seed in 0..4 {
            let other = individual(&palm, 0.7, seed);
            let changed = palm.image.pixels().iter().zip(other.image.pixels());
            let changed = changed
                .filter(|(a, b)| a.alpha().abs_diff(b.alpha()) > 128)
                .count() as f64;
            assert!(changed > 0.2 * before, "{seed}: {changed} of {before}");
            let share = leaves(&other) / before;
            assert!((0.85..1.9).contains(&share), "{seed}: {share}");
            assert!(
                loose(&other) <= own_loose + 0.02,
                "{seed}: {} {own_loose}",
                loose(&other)
            );
        }
    }

    #[test]
    fn little_strength_changes_little() {
        let palm = sample("palm");
        let far = |strength| {
            let other = individual(&palm, strength, 5);
            let pixels = palm.image.pixels().iter().zip(other.image.pixels());
            pixels
                .map(|(a, b)| f64::from(a.alpha().abs_diff(b.alpha())))
                .sum::<f64>()
        };
        let steps = [0.0, 0.1, 0.4, 1.0].map(far);
        assert!(steps.is_sorted(), "{steps:?}");
    }
}
