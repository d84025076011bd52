//! The boughs of what stands about one straight stem, each in the place of another.
//!
//! An eye knows a spruce by the few boughs that stand out of its outline, and those a warp leaves what they are.
//! So each side of the crown is cut into strips that lie along its boughs, from the stem to the tips, and a
//! strip takes what the crown shows at another height or on the other side: lengthened or shortened to the
//! crown's width at its new place, with the slope that boughs have there. Between strips the leaf that is
//! lighter, in front, wins, as between the cells of foliage ([`super::cells`]). About the stem the crown stays,
//! and its tip, and wherever the stem shows ([`super::wood`]).
//!
//! Limits: one slope for all boughs of a height; curved boughs are cut where they leave their strip.

use super::Tree;
use super::cells::share_changed;
use super::habit::Habit;
use super::rim::clear_new_loose;
use super::seams::{Rags, front, lifted};
use super::spire::{CORE, Spire};
use super::wood;
use crate::base::{Cancel, Cancelled, Random};
use crate::raster::{Mask, Straight};
use crate::segment::Label;
use rayon::prelude::*;

/// Width of a strip, in cell sizes.
const STRIP: f64 = 1.3;

/// How far up or down a strip comes from, as a share of the crown's height: boughs age downwards.
const REACH: f64 = 0.3;

/// Places that are tried for a strip.
const TRIES: usize = 24;

/// How many times as long or as short boughs become.
const LONGER: f64 = 1.35;

/// How far boughs reach at least and at most, as shares of the mean of the crown's half width and of what reached
/// out there: so the crown keeps its taper and its balance.
const REACHING: [f64; 2] = [0.86, 1.14];

/// Rows above which nothing is moved have a half width below this, in cell sizes.
const TIP: f64 = 0.5;

/// How far a fully light leaf reaches over its strip's border, in strips.
const OVERLAP: f32 = 0.3;

/// How softly the crown stays that is about the stem, in cell sizes.
const SOFT_CORE: f64 = 0.6;

/// How far ragged the border of what stays filled is, in cell sizes times the raggedness there.
const RAGGED: f64 = 1.0;

/// How much lower than the crown did new boughs may hang here and there, in cell sizes times the raggedness there.
const HANGING: f64 = 2.5;

/// Largest part, in squares of a cell, that does not hang together with the rest and is cleared.
const LOOSE: f64 = 4.0;

/// `tree`, which stands straight and whose crown shows wood there, with other boughs, `strength` saying how many
/// change. The same draws are made whatever the strength.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn retiered(
    tree: &Tree,
    (habit, stem): (&Habit, &Mask),
    side: f64,
    strength: f64,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<Tree, Cancelled> {
    let crown = Spire::of(tree, (habit, stem), STRIP * side, cancel)?;
    let strips = [-1.0, 1.0].map(|of| crown.strips(of, side, strength, random));
    let rags = Rags::new(side);
    let width = tree.image.width() as usize;
    let mut made = tree.clone();
    let rows = made.image.pixels_mut().par_chunks_mut(width);
    rows.zip(made.labels.pixels_mut().par_chunks_mut(width))
        .enumerate()
        .try_for_each(|(y, (pixels, labels))| {
            cancel.check()?;
            for (x, (pixel, label)) in pixels.iter_mut().zip(labels).enumerate() {
                if *label == Label::Trunk {
                    continue;
                }
                let out = x as f64 - habit.axis(y as f64);
                let strips = &strips[usize::from(out >= 0.0)];
                let shown = crown.shown(strips, [x, y], side, &rags);
                if let Some((other, of)) = shown {
                    (*pixel, *label) = (other, of);
                }
            }
            Ok(())
        })?;
    wood::keep(stem, tree, &mut made);
    clear_new_loose(&mut made, tree, LOOSE * side * side);
    Ok(made)
}

/// What a strip shows.
#[derive(Clone, Copy)]
struct Strip {
    /// The height at which its middle leaves the axis, and the slope there.
    to: f64,
    slope: f64,
    /// The same of where it comes from, and the side of the axis, −1 left.
    from: f64,
    from_slope: f64,
    from_side: f64,
    /// How many times as far out it lies there.
    longer: f64,
    /// Added to each channel, so that light and shade of the crown stay.
    lift: f32,
    is_own: bool,
}

impl Spire<'_> {
    /// The strips of a side, from the top.
    fn strips(&self, side: f64, cell: f64, strength: f64, random: &mut Random) -> Vec<Strip> {
        let (top, height) = (self.habit.top(), self.habit.height());
        let mut strips: Vec<Strip> = Vec::new();
        let mut at = top + random.between(0.2, 0.8) * self.strip;
        while at < top + height {
            let is_tip = self.habit.half(at) < TIP * cell;
            let own = self.own(at, side);
            let changes = random.unit() < share_changed(strength) && !is_tip;
            let [least, most] = REACHING;
            let tries: Vec<[f64; 3]> = (0..TRIES)
                .map(|_| {
                    let share = random.between(least, most);
                    [random.between(-1.0, 1.0), random.unit(), share]
                })
                .collect();
            let usual = 0.5 * (self.habit.half(at) + self.reach(at, side));
            let tries = tries.into_iter().map(|[down, other, share]| {
                let from_side = if other < 0.5 { -side } else { side };
                let from = at + REACH * height * down;
                self.taken(own, [from, from_side], share * usual)
            });
            let is_fit = |strip: &Strip| self.is_fit(strip, side, &strips);
            let found = tries.into_iter().find(is_fit).filter(|_| changes);
            let strip = found.map_or(own, |strip| Strip {
                lift: self.lift(&strip, side),
                ..strip
            });
            strips.push(strip);
            at += random.between(0.8, 1.2) * self.strip;
        }
        strips
    }

    /// The strip about height `at` as it is.
    fn own(&self, at: f64, side: f64) -> Strip {
        let slope = self.slopes[self.row(at)];
        Strip {
            to: at,
            slope,
            from: at,
            from_slope: slope,
            from_side: side,
            longer: 1.0,
            lift: 0.0,
            is_own: true,
        }
    }

    /// The strip in the place of `own` that comes from another height and side, reaching out so far.
    fn taken(&self, own: Strip, [from, from_side]: [f64; 2], reach: f64) -> Strip {
        Strip {
            from,
            from_slope: self.slopes[self.row(from)],
            from_side,
            longer: self.reach(from, from_side) / reach.max(1.0),
            is_own: false,
            ..own
        }
    }

    /// Whether `strip` may stand on `side` below `above`.
    fn is_fit(&self, strip: &Strip, side: f64, above: &[Strip]) -> bool {
        let (top, height) = (self.habit.top(), self.habit.height());
        let is_within = (top..top + height).contains(&strip.from);
        let is_moved = strip.from_side != side || (strip.from - strip.to).abs() > self.strip;
        let is_new = above.iter().rev().take(3).all(|other| {
            other.from_side != strip.from_side || (other.from - strip.from).abs() > 0.9 * self.strip
        });
        let reach = self.reach(strip.from, strip.from_side) / strip.longer;
        let room = match side < 0.0 {
            true => self.habit.axis(strip.to),
            false => f64::from(self.tree.image.width()) - 1.0 - self.habit.axis(strip.to),
        };
        let is_of_length = (1.0 / LONGER..=LONGER).contains(&strip.longer);
        is_within
            && is_moved
            && is_new
            && is_of_length
            && reach <= room - 1.0
            && self.is_whole(strip.from, strip.from_slope, strip.from_side)
    }

    /// What makes the light of a strip that of its place.
    fn lift(&self, strip: &Strip, side: f64) -> f32 {
        const SAMPLES: usize = 48;
        let half = self.habit.half(strip.to);
        let (mut own, mut other, mut count) = (0.0f32, 0.0f32, 0.0f32);
        for i in 0..SAMPLES {
            let out = half * (0.15 + 0.8 * i as f64 / SAMPLES as f64);
            let down = self.strip * (0.37 * i as f64).fract() - 0.5 * self.strip;
            let y = strip.to + down + strip.slope * out;
            let x = self.habit.axis(y) + side * out;
            let near = |value: f64| (value + 0.5).floor() as i64;
            let here = self.tree.image.get(near(x), near(y));
            let source = self.source(strip, out, y);
            let (Some(here), Some((there, _))) = (here, self.seen(source)) else {
                continue;
            };
            if here.alpha().min(there.alpha()) > 128 {
                own += here.luma();
                other += there.luma();
                count += 1.0;
            }
        }
        0.7 * (own - other) / count.max(1.0)
    }

    /// The pixel that `strip` shows at height `y` so far from the axis.
    fn source(&self, strip: &Strip, out: f64, y: f64) -> [i64; 2] {
        let from_out = out * strip.longer;
        let v = strip.from + (y - strip.slope * out - strip.to) + strip.from_slope * from_out;
        let u = self.habit.axis(v) + strip.from_side * from_out;
        [u, v].map(|along| (along + 0.5).floor() as i64)
    }

    /// What is seen there; nothing where that is the stem.
    fn seen(&self, [u, v]: [i64; 2]) -> Option<(Straight, Label)> {
        let label = self.tree.labels.get(u, v).unwrap_or_default();
        let pixel = self.tree.image.get(u, v).unwrap_or_default();
        let is_stem = label == Label::Trunk || self.wood.get(u, v) == Some(true);
        (!is_stem).then_some((pixel, label))
    }

    /// What pixel (x, y) shows in a crown of these strips; `None` where it stays.
    fn shown(
        &self,
        strips: &[Strip],
        [x, y]: [usize; 2],
        cell: f64,
        rags: &Rags,
    ) -> Option<(Straight, Label)> {
        let row = y as f64;
        let out = (x as f64 - self.habit.axis(row)).abs();
        // Nothing hangs much lower than it did, or stands beside the stem; a straight edge would show.
        if row > self.lowest(out) + HANGING * cell * f64::from(rags.at(0, x, y)) {
            return None;
        }
        let from_axis = self.leaves_axis(out, row);
        let own = self.tree.image.at(x as u32, y as u32);
        let core = CORE * self.habit.half(row);
        let filled =
            self.filled * self.habit.half(row) + RAGGED * cell * f64::from(rags.at(1, x, y));
        let stays_filled = out < filled && self.is_covered([x as i64, y as i64]);
        let at_home = OVERLAP * front(own, 0.0) - ((out - core) / (SOFT_CORE * cell)) as f32;
        let mut best = (at_home, None);
        let first = strips.partition_point(|strip| strip.to < from_axis);
        let near = first.saturating_sub(3)..(first + 3).min(strips.len());
        for strip in &strips[near] {
            let apart = (row - strip.slope * out - strip.to).abs() / self.strip;
            let source = self.source(strip, out, row);
            let Some((pixel, label)) = self.seen(source) else {
                continue;
            };
            if stays_filled && !self.is_covered(source) {
                continue;
            }
            // Each strip sees another part of the noise.
            let number = (strip.to * 7.0) as usize;
            let claim = OVERLAP * front(pixel, strip.lift) - apart as f32 + rags.at(number, x, y);
            if claim > best.0 {
                let shown = match strip.is_own {
                    true => None,
                    false => Some((lifted(pixel, strip.lift), label)),
                };
                best = (claim, shown);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use crate::variation::cells::cell_side;
    use crate::variation::maker::grown as sample;

    fn crown(tree: &Tree) -> usize {
        let leaves = tree.image.pixels().iter().zip(tree.labels.pixels());
        leaves
            .filter(|(pixel, label)| pixel.alpha() >= 96 && **label == Label::Crown)
            .count()
    }

    fn other(tree: &Tree, strength: f64, seed: u64) -> Tree {
        let habit = Habit::of(tree).unwrap();
        let side = cell_side(crown(tree));
        let mut random = Seed(seed).random();
        let wood = wood::wood(tree, side, &Cancel::new()).unwrap();
        let stance = (&habit, &wood);
        retiered(tree, stance, side, strength, &mut random, &Cancel::new()).unwrap()
    }

    #[test]
    fn a_spruce_gets_other_boughs() {
        let spruce = sample("spruce");
        assert_eq!(other(&spruce, 0.0, 0), spruce);
        for seed in 0..4 {
            let new = other(&spruce, 0.7, seed);
            let pixels = spruce.image.pixels().iter().zip(new.image.pixels());
            let moved = pixels.filter(|(a, b)| a.alpha().abs_diff(b.alpha()) > 128);
            let (moved, all) = (moved.count() as f64, crown(&spruce) as f64);
            assert!(moved > 0.08 * all, "{seed}: {}", moved / all);
            let share = crown(&new) as f64 / all;
            assert!((0.85..1.2).contains(&share), "{seed}: {share}");
        }
    }

    #[test]
    fn stem_and_tip_stay() {
        let spruce = sample("spruce");
        let new = other(&spruce, 1.0, 1);
        let habit = Habit::of(&spruce).unwrap();
        let is_tip = |y: f64| habit.share(y) < 0.2 && habit.half(y) < 4.0;
        let is_kept =
            |x: u32, y: u32| spruce.labels.at(x, y) == Label::Trunk || is_tip(f64::from(y));
        for y in 0..spruce.image.height() {
            for x in (0..spruce.image.width()).filter(|&x| is_kept(x, y)) {
                assert_eq!(new.image.at(x, y), spruce.image.at(x, y), "{x} {y}");
            }
        }
    }
}
