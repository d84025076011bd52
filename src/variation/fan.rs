//! The fronds of a palm about its heart, in polar coordinates, and how they may stand otherwise.

use super::Tree;
use super::noise::Noise;
use crate::base::Random;
use crate::raster::{Image, Straight};
use crate::segment::Label;
use std::f64::consts::{PI, TAU};

/// Directions that are told apart about a heart.
const DIRECTIONS: usize = 720;

/// Waves around the heart: how fronds close up, reach and hang.
const WAVES: [f64; 3] = [4.0, 6.0, 4.0];

/// How much fronds close up or open out: logarithm of the density, by waves and on one side against the other (which
/// turns those between), at full strength, and at most.
const CLOSER: f64 = 0.7;
const TURN: f64 = 0.5;
const CLOSEST: f64 = 0.5;

/// How much farther or less far fronds reach, as a share.
const REACH: f64 = 0.2;

/// How many times as short fronds become at most, that the frame may not cut them.
const SHORTEST: f64 = 1.25;

/// How much all fronds hang more or less, and each by itself, radians at their tips.
const DROOP: f64 = 0.26;
const OWN_DROOP: f64 = 0.2;

/// Share of the crown's reach within which the turn grows from nothing: stalks do not swirl.
const HEARTWOOD: f64 = 0.6;

/// Width of the directions about straight down that stay, radians, and how softly.
const STEM: f64 = 0.25;
const SOFT: f64 = 0.55;

/// Width of the directions about another stem's end that stay where they are, radians: the fronds there are its own.
const HELD: f64 = 0.3;

/// Where fronds grow from: the top of the stem.
pub(super) struct Heart {
    /// Pixels.
    at: [f64; 2],
    /// How far fronds reach, pixels: nearly all and, direction by direction, all.
    pub(super) reach: f64,
    outline: Vec<f64>,
}

impl Heart {
    /// That of `tree`; `None` without a stem or fronds.
    pub(super) fn of(tree: &Tree) -> Option<Self> {
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

    /// The row it is in.
    pub(super) fn top(&self) -> f64 {
        self.at[1]
    }

    /// Distance and angle of a place, pixels and radians from straight up, clockwise.
    pub(super) fn polar(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x - self.at[0], y - self.at[1]);
        [dx.hypot(dy), libm::atan2(dx, -dy)]
    }

    /// The place there, `side` -1 in the mirror.
    pub(super) fn place(&self, [length, angle]: [f64; 2], side: f64) -> [f64; 2] {
        [
            self.at[0] + side * length * libm::sin(angle),
            self.at[1] - length * libm::cos(angle),
        ]
    }

    /// The farthest that fronds reach about as far round as `angle`.
    fn reach_near(&self, angle: f64) -> f64 {
        /// Directions on either side.
        const NEAR: usize = DIRECTIONS / 20;
        let middle = direction(angle) as usize + DIRECTIONS;
        let near = (middle - NEAR..=middle + NEAR).map(|at| self.outline[at % DIRECTIONS]);
        near.fold(1.0, f64::max)
    }

    /// Intersection over union of the crown and its mirror image.
    pub(super) fn likeness(&self, fronds: &Image<Straight>) -> f64 {
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
pub(super) struct Fan {
    /// The angle that each comes from, and how many times as far from the heart.
    angle: Vec<f64>,
    farther: Vec<f64>,
    /// How much it hangs, radians at the tip.
    droop: Vec<f64>,
}

impl Fan {
    /// A fan that is drawn; the directions `held` stay, radians.
    pub(super) fn new(shorter: f64, strength: f64, held: &[f64], random: &mut Random) -> Self {
        let [closer, reach, droop] = [0; 3].map(|_| Noise::new(random));
        let all_hang = DROOP * random.between(-1.0, 1.0);
        let all_turn = TURN * random.between(-1.0, 1.0);
        let each = |i: usize| TAU * i as f64 / DIRECTIONS as f64 - PI;
        let free = |angle: f64| {
            let away = |held: &f64| 1.0 - libm::exp(-((angle - held) / HELD).powi(2));
            free(angle) * held.iter().map(away).product::<f64>()
        };
        let density = |i: usize| {
            let angle = each(i);
            let wave = CLOSER * on_circle(&closer, WAVES[0], angle);
            let wave = strength * (wave + all_turn * libm::sin(angle));
            libm::exp(wave.clamp(-CLOSEST, CLOSEST) * free(angle))
        };
        let mut sums = vec![0.0];
        for i in 0..DIRECTIONS {
            sums.push(sums[i] + 0.5 * (density(i) + density(i + 1)));
        }
        let farther = |i: usize| {
            let wave = strength * REACH * on_circle(&reach, WAVES[1], each(i));
            1.0 + (1.0 / (1.0 - shorter + wave) - 1.0) * free(each(i))
        };
        let hangs = |i: usize| {
            let own = OWN_DROOP * on_circle(&droop, WAVES[2], each(i));
            strength * (all_hang * libm::sin(each(i)) + own) * free(each(i))
        };
        Self {
            angle: held_at(&sums, held),
            farther: (0..=DIRECTIONS).map(farther).collect(),
            droop: (0..=DIRECTIONS).map(hangs).collect(),
        }
    }

    /// The fan with fronds no longer than the picture has room for.
    pub(super) fn within(mut self, heart: &Heart, [right, bottom]: [f64; 2]) -> Self {
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
            self.farther[i] = self.farther[i].max((needed / room).min(SHORTEST));
        }
        self
    }

    /// Where a place of the new crown comes from; both as distance and angle.
    pub(super) fn source(&self, heart: &Heart, [length, angle]: [f64; 2]) -> [f64; 2] {
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

/// The angles that directions come from whose densities add up to `sums`, those `held` from themselves.
fn held_at(sums: &[f64], held: &[f64]) -> Vec<f64> {
    let mut stays: Vec<usize> = held.iter().map(|held| direction(*held) as usize).collect();
    stays.extend([0, DIRECTIONS]);
    stays.sort_unstable();
    stays.dedup();
    let each = |i: usize| TAU * i as f64 / DIRECTIONS as f64 - PI;
    let mut angles = vec![-PI];
    for ends in stays.windows(2) {
        let [first, last] = [ends[0], ends[1]];
        let width = (each(last) - each(first)) / (sums[last] - sums[first]);
        angles.extend((first + 1..=last).map(|i| each(first) + (sums[i] - sums[first]) * width));
    }
    angles
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
pub(super) fn on_circle(noise: &Noise, waves: f64, angle: f64) -> f64 {
    let radius = waves / PI;
    2.0 * noise.at([radius * libm::cos(angle), radius * libm::sin(angle)]) - 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    #[test]
    fn fans_keep_their_order() {
        for seed in 0..20 {
            let fan = Fan::new(0.0, 1.0, &[0.8], &mut Seed(seed).random());
            assert!(fan.angle.is_sorted());
            let held = direction(0.8);
            assert!((between(&fan.angle, held.floor()) - 0.8).abs() < TAU / DIRECTIONS as f64);
            assert!((fan.angle[0] + PI).abs() < 1e-9 && (fan.angle[DIRECTIONS] - PI).abs() < 1e-9);
        }
    }
}
