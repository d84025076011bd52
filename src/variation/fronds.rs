//! Another individual of a palm: its fronds stand elsewhere, reach farther or less far, hang more or less.
//!
//! A palm's crown is a few large leaves about one heart, the top of its stem. Cut into cells, as other
//! crowns are (`individual`), they would lie about in pieces. So the picture is turned about the heart
//! instead, in polar coordinates: fronds close up or open out like a fan whose order stays (the turn grows
//! with the angle, so nothing folds), each with a length and a droop of its own. A second layer, the same
//! crown mirrored and turned otherwise, stands partly before the first and partly behind it: of two fronds
//! the lighter is in front. Where the crown is not alike on both sides (twin palms) it is left out.
//!
//! Limits: one heart, the top of the stem's label; a frond that crosses straight below the heart stays.

use super::Tree;
use super::noise::Noise;
use super::sway::between_pixels;
use crate::base::{Cancel, Cancelled, Random};
use crate::raster::{Image, Mask, Straight, dilated, smoothed_within};
use crate::segment::Label;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};

/// Words in names of pictures by which palms, and what grows like them, are known.
const WORDS: [&str; 12] = [
    "palm",
    "palme",
    "palmier",
    "phoenix",
    "cocos",
    "coconut",
    "washingtonia",
    "trachycarpus",
    "cycad",
    "cycas",
    "dracaena",
    "yucca",
];

/// Directions that are told apart about a heart.
const DIRECTIONS: usize = 720;

/// Waves around the heart: how fronds close up, reach, hang, and which layer is in front.
const WAVES: [f64; 4] = [4.0, 6.0, 4.0, 5.0];

/// How much fronds close up or open out: logarithm of the density, at full strength and at most.
const CLOSER: f64 = 0.7;
const CLOSEST: f64 = 0.36;

/// How much farther or less far fronds reach, as a share.
const REACH: f64 = 0.15;

/// How much shorter the second layer is: fewer of its fronds stand out.
const SHORTER: f64 = 0.18;

/// How much all fronds hang more or less, and each by itself, radians at their tips.
const DROOP: f64 = 0.22;
const OWN_DROOP: f64 = 0.12;

/// Share of the crown's reach within which the turn grows from nothing: stalks do not swirl.
const HEARTWOOD: f64 = 0.6;

/// How much the light of a frond counts for its being in front, against the waves'.
const LIGHT: f32 = 1.0;
const WAVE: f32 = 0.25;

/// Light of what lies behind.
const BEHIND: f32 = 0.8;

/// Standard deviation over which light is compared, as a share of the crown's reach.
const LEAFLET: f64 = 0.012;

/// Least likeness (intersection over union) of a crown with its mirror image for a second layer.
const LEAST_LIKE: f64 = 0.6;

/// Width of a stem's soft edges, as a share of the picture's side.
const SOFT_EDGE: f64 = 0.006;

/// Width of the directions about straight down that stay, radians, and how softly.
const STEM: f64 = 0.25;
const SOFT: f64 = 0.55;

/// Whether the name of a picture says that its tree's crown is of fronds.
///
/// ```
/// use boscage::variation::has_fronds;
/// assert!(has_fronds("twin_palm_04.png") && has_fronds("Phoenix canariensis.webp"));
/// assert!(!has_fronds("maple_palmate.png"));
/// ```
pub fn has_fronds(name: &str) -> bool {
    let name = name.to_lowercase();
    let mut words = name.split(|c: char| !c.is_alphabetic());
    words.any(|word| {
        WORDS.contains(&word.strip_suffix('s').unwrap_or(word)) || WORDS.contains(&word)
    })
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
    let frame = [tree.image.width(), tree.image.height()].map(|side| f64::from(side) - 1.0);
    let [first, second] = [0.0, SHORTER].map(|shorter| {
        let fan = Fan::new(shorter, strength, random);
        fan.within(&heart, frame)
    });
    let order = Noise::new(random);
    let stem = stem(tree);
    let fronds = without(&tree.image, &stem);
    let light = light(&fronds, LEAFLET * heart.reach, cancel)?;
    let has_second = heart.likeness(&fronds) >= LEAST_LIKE;
    let width = tree.image.width() as usize;
    let below = tree.clone();
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
                    let wave = (on_circle(&order, WAVES[3], at[1]) * strength) as f32;
                    // Without strength the first hides the second.
                    let ahead = WAVE * wave - (1.0 - strength) as f32;
                    if LIGHT * (other_light - own_light) + ahead > 0.0 {
                        over(other, dimmed(own))
                    } else {
                        over(own, dimmed_by(other, strength))
                    }
                } else {
                    own
                };
                let (x, y) = (x as u32, y as u32);
                let behind = match stem.at(x, y) {
                    true => below.image.at(x, y),
                    false => Straight([0; 4]),
                };
                let is_stem = below.labels.at(x, y) == Label::Trunk;
                *pixel = over(crown, behind);
                *label = match (crown.alpha() >= 96, is_stem) {
                    (true, _) => Label::Crown,
                    (false, true) => Label::Trunk,
                    (false, false) => Label::Background,
                };
            }
            Ok(())
        })?;
    Ok(true)
}

/// Where fronds grow from: the top of the stem.
struct Heart {
    /// Pixels.
    at: [f64; 2],
    /// How far fronds reach, pixels: nearly all and, direction by direction, all.
    reach: f64,
    outline: Vec<f64>,
}

impl Heart {
    /// That of `tree`; `None` without a stem or fronds.
    fn of(tree: &Tree) -> Option<Self> {
        let width = tree.image.width() as usize;
        let seen = |wanted: Label| {
            let places = tree
                .labels
                .pixels()
                .iter()
                .zip(tree.image.pixels())
                .enumerate();
            let places =
                places.filter(move |(_, (label, pixel))| **label == wanted && pixel.alpha() >= 96);
            places.map(move |(i, _)| [(i % width) as f64, (i / width) as f64])
        };
        // Row by row from the top: the first few of a hundred are the stem's end.
        let stem: Vec<[f64; 2]> = seen(Label::Trunk).collect();
        let top = stem[..].get(stem.len() / 50)?[1];
        let end: Vec<f64> = stem
            .iter()
            .filter(|place| place[1] <= top)
            .map(|place| place[0])
            .collect();
        let at = [end.iter().sum::<f64>() / end.len() as f64, top];
        let mut heart = Self {
            at,
            reach: 0.0,
            outline: vec![0.0; DIRECTIONS],
        };
        let mut lengths = Vec::new();
        for place in seen(Label::Crown) {
            let [length, angle] = heart.polar(place);
            let direction = &mut heart.outline[direction(angle) as usize % DIRECTIONS];
            *direction = direction.max(length);
            lengths.push(length);
        }
        let most = lengths.len() * 97 / 100;
        (!lengths.is_empty()).then(|| {
            heart.reach = lengths
                .select_nth_unstable_by(most, f64::total_cmp)
                .1
                .max(1.0);
            heart
        })
    }

    /// Distance and angle of a place, pixels and radians from straight up, clockwise.
    fn polar(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.at[0], y - self.at[1]);
        [dx.hypot(dy), libm::atan2(dx, -dy)]
    }

    /// The place there, `side` -1 in the mirror.
    fn place(&self, [length, angle]: [f64; 2], side: f64) -> [f64; 2] {
        [
            self.at[0] + side * length * libm::sin(angle),
            self.at[1] - length * libm::cos(angle),
        ]
    }

    /// The farthest that fronds reach about as far round as `angle`.
    fn reach_near(&self, angle: f64) -> f64 {
        /// Directions on either side.
        const NEAR: usize = DIRECTIONS / 30;
        let middle = direction(angle) as usize + DIRECTIONS;
        let near = (middle - NEAR..=middle + NEAR).map(|at| self.outline[at % DIRECTIONS]);
        near.fold(1.0, f64::max)
    }

    /// Intersection over union of the crown and its mirror image.
    fn likeness(&self, fronds: &Image<Straight>) -> f64 {
        let is_leaf = |x: i64, y: i64| fronds.get(x, y).is_some_and(|pixel| pixel.alpha() >= 96);
        let twice = (2.0 * self.at[0] + 0.5).floor() as i64;
        let (mut both, mut any) = (0u64, 0u64);
        for y in 0..i64::from(fronds.height()) {
            for x in 0..i64::from(fronds.width()) {
                let (own, other) = (is_leaf(x, y), is_leaf(twice - x, y));
                both += u64::from(own && other);
                any += u64::from(own || other);
            }
        }
        both as f64 / any.max(1) as f64
    }
}

/// How a layer of fronds is turned, direction by direction.
struct Fan {
    /// The angle that each comes from, and how many times as far from the heart.
    angle: Vec<f64>,
    farther: Vec<f64>,
    /// How much it hangs, radians at the tip.
    droop: Vec<f64>,
}

impl Fan {
    fn new(shorter: f64, strength: f64, random: &mut Random) -> Self {
        let [closer, reach, droop] = [0; 3].map(|_| Noise::new(random));
        let all_hang = DROOP * random.between(-1.0, 1.0);
        let each = |i: usize| TAU * i as f64 / DIRECTIONS as f64 - PI;
        let density = |i: usize| {
            let angle = each(i);
            let wave = strength * CLOSER * on_circle(&closer, WAVES[0], angle);
            libm::exp(wave.clamp(-CLOSEST, CLOSEST) * free(angle))
        };
        let mut sums = vec![0.0];
        for i in 0..DIRECTIONS {
            sums.push(sums[i] + 0.5 * (density(i) + density(i + 1)));
        }
        let whole = sums[DIRECTIONS];
        let farther = |i: usize| {
            let wave = strength * REACH * on_circle(&reach, WAVES[1], each(i));
            1.0 + (1.0 / (1.0 - shorter + wave) - 1.0) * free(each(i))
        };
        let hangs = |i: usize| {
            let own = OWN_DROOP * on_circle(&droop, WAVES[2], each(i));
            strength * (all_hang * libm::sin(each(i)) + own) * free(each(i))
        };
        Self {
            angle: sums.iter().map(|sum| TAU * sum / whole - PI).collect(),
            farther: (0..=DIRECTIONS).map(farther).collect(),
            droop: (0..=DIRECTIONS).map(hangs).collect(),
        }
    }

    /// The fan with fronds no longer than the picture has room for.
    fn within(mut self, heart: &Heart, [right, bottom]: [f64; 2]) -> Self {
        for i in 0..=DIRECTIONS {
            let angle = TAU * i as f64 / DIRECTIONS as f64 - PI;
            let (sin, cos) = (libm::sin(angle), libm::cos(angle));
            let [x, y] = heart.at;
            let across = if sin > 0.0 {
                (right - x) / sin
            } else {
                x / (-sin).max(1e-9)
            };
            let down = if cos > 0.0 {
                y / cos
            } else {
                (bottom - y) / (-cos).max(1e-9)
            };
            let room = across.min(down).max(1.0);
            let needed = heart
                .reach_near(self.angle[i])
                .max(heart.reach_near(-self.angle[i]));
            // What reaches the frame already may stay as it is.
            let needed = (needed / room).min(1.0);
            self.farther[i] = self.farther[i].max(needed);
        }
        self
    }

    /// Where a place of the new crown comes from; both as distance and angle.
    fn source(&self, heart: &Heart, [length, angle]: [f64; 2]) -> [f64; 2] {
        let out = length / heart.reach;
        let share = (out / HEARTWOOD).min(1.0);
        let share = share * share * (3.0 - 2.0 * share);
        let at = direction(angle);
        let turn = between(&self.angle, at) - angle;
        let hangs = between(&self.droop, at) * out.min(1.3) * out.min(1.3);
        [
            length * between(&self.farther, at),
            angle + share * turn - hangs,
        ]
    }
}

/// How free fronds are to move in a direction: not straight down, where the stem is.
fn free(angle: f64) -> f64 {
    ((PI - STEM - angle.abs()) / SOFT).clamp(0.0, 1.0)
}

/// The direction of an angle, 0 (straight down) to [`DIRECTIONS`].
fn direction(angle: f64) -> f64 {
    ((angle + PI) / TAU * DIRECTIONS as f64).clamp(0.0, DIRECTIONS as f64)
}

/// The value between those of two directions.
fn between(values: &[f64], at: f64) -> f64 {
    let first = (at as usize).min(DIRECTIONS - 1);
    values[first] + (values[first + 1] - values[first]) * (at - first as f64)
}

/// Noise around a circle, -1 to 1, of about so many waves.
fn on_circle(noise: &Noise, waves: f64, angle: f64) -> f64 {
    let radius = waves / PI;
    2.0 * noise.at([radius * libm::cos(angle), radius * libm::sin(angle)]) - 1.0
}

/// The stem with its soft edges.
fn stem(tree: &Tree) -> Mask {
    let edge = (SOFT_EDGE * f64::from(tree.image.width())).ceil().min(60.0) as u8;
    let mut stem = dilated(&tree.labels.map(|label| *label == Label::Trunk), edge);
    for (is_stem, label) in stem.pixels_mut().iter_mut().zip(tree.labels.pixels()) {
        *is_stem &= *label != Label::Crown;
    }
    stem
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
    let light = fronds.map(|pixel| {
        let [r, g, b, a] = pixel.0.map(|value| f32::from(value) / 255.0);
        (0.2126 * r + 0.7152 * g + 0.0722 * b) * a
    });
    smoothed_within(&light, &light.map(|_| true), sigma, cancel)
}

/// `front` over `back`.
fn over(front: Straight, back: Straight) -> Straight {
    let (front, back) = (front.premultiplied().0, back.premultiplied().0);
    let clear = 255 - u32::from(front[3]);
    let sum = |c: usize| u32::from(front[c]) + (u32::from(back[c]) * clear + 127) / 255;
    crate::raster::Premultiplied([0, 1, 2, 3].map(|c| sum(c).min(255) as u8)).straight()
}

/// As it is behind another frond.
fn dimmed(pixel: Straight) -> Straight {
    let [r, g, b, alpha] = pixel.0;
    let scaled = |value: u8| (f32::from(value) * BEHIND + 0.5) as u8;
    Straight([scaled(r), scaled(g), scaled(b), alpha])
}

/// The same, seen as much as `strength` says.
fn dimmed_by(pixel: Straight, strength: f64) -> Straight {
    let Straight([r, g, b, alpha]) = dimmed(pixel);
    // From a quarter of the strength on all of it.
    let share = (4.0 * strength).min(1.0);
    Straight([r, g, b, (f64::from(alpha) * share + 0.5) as u8])
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

    #[test]
    fn fans_keep_their_order() {
        for seed in 0..20 {
            let fan = Fan::new(0.0, 1.0, &mut Seed(seed).random());
            assert!(fan.angle.is_sorted());
            assert!((fan.angle[0] + PI).abs() < 1e-9 && (fan.angle[DIRECTIONS] - PI).abs() < 1e-9);
        }
    }
}
