//! Where the boughs lie of what stands about one straight stem: their slopes, how far they reach, the gaps between.
//!
//! A place is told by its height and by how far it is from the axis; the height at which its bough leaves the axis
//! follows from the slope there.

use super::Tree;
use super::habit::Habit;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, smoothed};
use crate::segment::Label;
use rayon::prelude::*;

/// Share of the crown's half width about the stem in which no bough begins.
pub(super) const CORE: f64 = 0.22;

/// Share of the rows in which gaps between boughs reach deeper than any that is let in where there was none, and
/// from how much cover on, of 1, there was none.
const DEEPER: f64 = 0.12;
const COVERED: f32 = 0.55;

/// Standard deviation over which cover is told, in strips.
const COVER: f64 = 0.22;

/// Widest gap in a bough, as a share of its length.
const GAP: f64 = 0.05;

/// Steepest boughs, as a slope.
const STEEPEST: f64 = 1.2;

/// The crown of what stands about one straight stem, in strips along its boughs.
pub(super) struct Spire<'a> {
    pub(super) tree: &'a Tree,
    pub(super) habit: &'a Habit,
    /// Where wood shows in it.
    pub(super) wood: &'a Mask,
    /// Of a strip, pixels.
    pub(super) strip: f64,
    /// The slope of boughs, row by row: how far they fall with each pixel outwards.
    pub(super) slopes: Vec<f64>,
    /// How far boughs reach out from the axis that leave it in each row, on the left and on the right, pixels.
    reaches: [Vec<f64>; 2],
    /// The lowest leaf about so far from the axis on either side, pixels.
    lowest: Vec<f64>,
    /// How much leaves cover about each pixel, 0 to 1.
    cover: Image<f32>,
    /// Share of the crown's half width within which no new gap is let in.
    pub(super) filled: f64,
}

impl<'a> Spire<'a> {
    /// That of `tree`, which has that habit and shows wood there, in strips so many pixels wide.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(super) fn of(
        tree: &'a Tree,
        (habit, wood): (&'a Habit, &'a Mask),
        strip: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let cover = tree.image.map(|pixel| f32::from(pixel.alpha()) / 255.0);
        let mut crown = Self {
            tree,
            habit,
            wood,
            strip,
            slopes: slopes(tree, habit, strip),
            reaches: [0; 2].map(|_| vec![0.0; tree.image.height() as usize]),
            lowest: vec![0.0; tree.image.width() as usize + 1],
            cover: smoothed(&cover, COVER * strip, cancel)?,
            filled: 0.0,
        };
        let width = tree.image.width() as usize;
        let leaves = tree.image.pixels().iter().zip(tree.labels.pixels());
        for (i, (pixel, label)) in leaves.enumerate() {
            if *label != Label::Crown || pixel.alpha() < 96 {
                continue;
            }
            let (x, y) = ((i % width) as f64, (i / width) as f64);
            let out = x - habit.axis(y);
            let row = crown.row(crown.leaves_axis(out.abs(), y));
            let reach = &mut crown.reaches[usize::from(out >= 0.0)][row];
            *reach = reach.max(out.abs());
            let lowest = &mut crown.lowest[(out.abs() as usize).min(width)];
            *lowest = lowest.max(y);
        }
        let about = (0.5 * strip) as usize;
        crown.lowest = (0..=width)
            .map(|out| out.saturating_sub(about)..(out + about).min(width) + 1)
            .map(|near| crown.lowest[near].iter().copied().fold(0.0, f64::max))
            .collect();
        crown.filled = crown.gaps_end();
        Ok(crown)
    }

    /// How near to the stem the crown's own gaps reach but for the deepest, as a share of its half width.
    fn gaps_end(&self) -> f64 {
        let top = self.habit.top();
        let rows = 0..self.habit.height() as u32;
        let ends = rows.flat_map(|row| {
            let y = top + f64::from(row);
            let half = self.habit.half(y).max(1.0);
            [-1.0, 1.0].map(|side| {
                let is_gap = |out: &u32| {
                    let x = self.habit.axis(y) + side * f64::from(*out);
                    !self.is_covered([(x + 0.5).floor() as i64, y as i64])
                };
                let first = (CORE * half) as u32..half as u32;
                first
                    .into_iter()
                    .find(is_gap)
                    .map_or(1.0, |out| f64::from(out) / half)
            })
        });
        let mut ends: Vec<f64> = ends.collect();
        ends.sort_by(f64::total_cmp);
        ends.get((DEEPER * ends.len() as f64) as usize)
            .copied()
            .unwrap_or(1.0)
    }

    /// The lowest leaf about so far from the axis.
    pub(super) fn lowest(&self, out: f64) -> f64 {
        self.lowest[(out.max(0.0) as usize).min(self.lowest.len() - 1)]
    }

    pub(super) fn row(&self, y: f64) -> usize {
        (y.max(0.0) as usize).min(self.slopes.len() - 1)
    }

    /// The height at which the bough leaves the axis that is at height `y` so far out.
    pub(super) fn leaves_axis(&self, out: f64, y: f64) -> f64 {
        // The slope is that at the height which is sought: near enough after two steps.
        let first = y - self.slopes[self.row(y)] * out;
        y - self.slopes[self.row(first)] * out
    }

    /// How far boughs reach that leave the axis about height `y` on a side.
    pub(super) fn reach(&self, y: f64, side: f64) -> f64 {
        let near = self.row(y - 0.5 * self.strip)..=self.row(y + 0.5 * self.strip);
        let reaches = &self.reaches[usize::from(side >= 0.0)][near];
        reaches.iter().copied().fold(0.0, f64::max)
    }

    /// Whether leaves cover what is about there.
    pub(super) fn is_covered(&self, [u, v]: [i64; 2]) -> bool {
        self.cover.get(u, v).is_some_and(|cover| cover >= COVERED)
    }

    /// Whether a bough shows that leaves the axis at height `from` on a side, from the stem to its tip, with no gap of more than [`GAP`].
    pub(super) fn is_whole(&self, from: f64, slope: f64, side: f64) -> bool {
        let (half, reach) = (self.habit.half(from), self.reach(from, side));
        let shows = |out: f64| {
            let middle = from + slope * out;
            let rows = (middle - 0.5 * self.strip) as i64..=(middle + 0.5 * self.strip) as i64;
            rows.into_iter().any(|y| {
                let x = self.habit.axis(y as f64) + side * out;
                let pixel = self.tree.image.get((x + 0.5).floor() as i64, y);
                pixel.is_some_and(|pixel| pixel.alpha() >= 96)
            })
        };
        let (mut gap, mut widest) = (0.0f64, 0.0f64);
        let first = (CORE * half) as u32;
        for out in first..reach as u32 {
            gap = if shows(f64::from(out)) {
                0.0
            } else {
                gap + 1.0
            };
            widest = widest.max(gap);
        }
        widest <= (GAP * reach).max(2.0)
    }
}

/// The slope of boughs in each row, from the edges in the outer part of the crown about it: that along which
/// alpha and light change least.
fn slopes(tree: &Tree, habit: &Habit, strip: f64) -> Vec<f64> {
    /// Where boughs stand out, as shares of the crown's half width.
    const OUTER: std::ops::Range<f64> = 0.35..1.25;
    let light = |x: i64, y: i64| {
        let pixel = tree.image.get(x, y).unwrap_or_default();
        f64::from(pixel.alpha()) / 255.0 * (0.5 + 0.5 * f64::from(pixel.luma()) / 255.0)
    };
    let (width, height) = (
        i64::from(tree.image.width()),
        i64::from(tree.image.height()),
    );
    let of_row = |y: i64| {
        let (mut mixed, mut steep) = (0.0, 0.0);
        for x in 0..width {
            let out = x as f64 - habit.axis(y as f64);
            if !OUTER.contains(&(out.abs() / habit.half(y as f64).max(1.0))) {
                continue;
            }
            let across = out.signum() * (light(x + 1, y) - light(x - 1, y));
            let down = light(x, y + 1) - light(x, y - 1);
            mixed += across * down;
            steep += down * down;
        }
        [mixed, steep]
    };
    let rows: Vec<[f64; 2]> = (0..height).into_par_iter().map(of_row).collect();
    let sigma = (1.5 * strip).max(1.0);
    let slope = |y: i64| {
        let reach = (2.0 * sigma) as i64;
        let (mut mixed, mut steep) = (0.0, 0.0);
        for row in (y - reach).max(0)..=(y + reach).min(height - 1) {
            let apart = (row - y) as f64 / sigma;
            let share = libm::exp(-0.5 * apart * apart);
            mixed += share * rows[row as usize][0];
            steep += share * rows[row as usize][1];
        }
        (-mixed / steep.max(1e-9)).clamp(-STEEPEST, STEEPEST)
    };
    (0..height).into_par_iter().map(slope).collect()
}
