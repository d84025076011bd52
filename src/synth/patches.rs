//! The coarsest level of a texture: square pieces of the exemplar, joined by graph cuts.
//!
//! Pieces are laid row by row on a slightly irregular grid so that they overlap by a third. For each,
//! some hundred blocks of the exemplar are compared with what lies there already and the best is
//! taken; where a block was used before counts against it, all the more the nearer that was, so that
//! nothing repeats in sight and all of the exemplar is used alike. A minimum cut decides which pixels
//! of the overlap become new (Kwatra, Schödl, Essa, Turk & Bobick 2003). A second round lays pieces
//! over the crossings of the grid, each bounded by a closed cut, and keeps those that leave less
//! visible seams than there were: it removes the grid.
//!
//! Departures: the comparison of blocks is plain and sampled, not by Fourier transforms; blocks may
//! have gaps where the photograph shows no foliage, which keep what was there or are filled from
//! their neighbours.

use super::canvas::Canvas;
use super::exemplar::Exemplar;
use super::level::{Color, Level};
use super::seam::{Side, StepCost, seam};
use super::similar::NOWHERE;
use crate::base::{Cancel, Cancelled, Random, Seed, Stage};
use crate::raster::{Image, Straight};
use rayon::prelude::*;
use std::ops::RangeInclusive;

/// Blocks that are compared for each piece: more find better seams but always the same blocks.
const COMPARED: usize = 320;

/// Side of the blocks from which on so many are compared; of smaller ones, of which more are laid,
/// fewer.
const COMPARED_SIDE: usize = 12;

/// How much a block that was used once counts against a difference equal to the exemplar's variance.
const REUSE: f32 = 0.4;

/// How much more it counts right beside where it was used, falling to nothing within
/// [`NEAR_PIECES`] pieces.
const NEARBY: f32 = 3.0;
const NEAR_PIECES: f32 = 5.0;

/// Smallest piece, pixels of the coarsest level: smaller ones hold no structure.
const SMALLEST: usize = 5;

/// Shares of foliage that a block must have, from the strictest, and the share of the exemplar's
/// pixels that must be corners of such blocks.
const FULL_ENOUGH: [f32; 3] = [0.95, 0.85, 0.7];
const ENOUGH_BLOCKS: f32 = 0.15;

/// Squares of the exemplar's coarsest level that pieces may be cut from.
#[derive(Debug)]
pub(super) struct Blocks<'a> {
    level: &'a Level,
    /// Side in pixels of the level.
    pub(super) side: usize,
    /// Upper left corners.
    corners: Vec<u32>,
    /// Mean squared distance from the mean colour.
    variance: f32,
}

impl<'a> Blocks<'a> {
    /// The blocks of at most `wanted` pixels a side: smaller ones when the crown is too small or too
    /// thin for those.
    pub(super) fn new(level: &'a Level, wanted: usize) -> Self {
        let sums = sums(level);
        let usable = level.usable.iter().filter(|&&usable| usable).count();
        let enough = (usable as f32 * ENOUGH_BLOCKS).max(1.0) as usize;
        let wanted = wanted.max(SMALLEST);
        let mut best = (SMALLEST, Vec::new());
        let mut largest = wanted;
        while largest >= SMALLEST {
            // Rather gaps than small pieces, within limits.
            let smallest = (largest * 2 / 3).max(SMALLEST);
            for share in FULL_ENOUGH {
                let blocks = |side| corners(level, &sums, side, share);
                let found = largest_with(smallest..=largest, |side| blocks(side).len() >= enough);
                let (side, is_enough) = found.map_or((smallest, false), |side| (side, true));
                let corners = blocks(side);
                if is_enough {
                    return Self::of(level, side, corners);
                }
                if corners.len() > best.1.len() {
                    best = (side, corners);
                }
            }
            largest = smallest - 1;
        }
        Self::of(level, best.0, best.1)
    }

    fn of(level: &'a Level, side: usize, corners: Vec<u32>) -> Self {
        Self {
            level,
            side,
            corners,
            variance: variance(level),
        }
    }
}

/// The largest of `sides` that is `fine`, found by halving: where one is, smaller ones are too, or
/// nearly always. `None` when the smallest is not.
fn largest_with(sides: RangeInclusive<usize>, fine: impl Fn(usize) -> bool) -> Option<usize> {
    let (mut low, mut high) = (*sides.start(), *sides.end());
    if !fine(low) {
        return None;
    }
    while low < high {
        let middle = (low + high).div_ceil(2);
        match fine(middle) {
            true => low = middle,
            false => high = middle - 1,
        }
    }
    Some(low)
}

/// Numbers of usable pixels above and left of each pixel of the stack.
fn sums(level: &Level) -> Vec<u32> {
    let stride = level.stride;
    let mut sums = vec![0u32; level.usable.len()];
    for index in 0..sums.len() {
        let left = if index % stride > 0 {
            sums[index - 1]
        } else {
            0
        };
        let above = if index >= stride {
            sums[index - stride]
        } else {
            0
        };
        let corner = match index % stride > 0 && index >= stride {
            true => sums[index - stride - 1],
            false => 0,
        };
        sums[index] = left + above - corner + u32::from(level.usable[index]);
    }
    sums
}

/// Corners of the squares of `side` pixels with at least this `share` of foliage.
fn corners(level: &Level, sums: &[u32], side: usize, share: f32) -> Vec<u32> {
    let (width, height) = level.size();
    let reach = (side - 1) * level.step;
    let least = (share * (side * side) as f32).ceil() as u32;
    let mut corners = Vec::new();
    for y in 0..height.saturating_sub(reach) {
        for x in 0..width.saturating_sub(reach) {
            let corner = level.index(x, y);
            // The pixel before the first and the last: borders keep both inside.
            let (before, last) = (
                corner - level.stride - 1,
                corner + (side - 1) * level.stride,
            );
            let last = last + side - 1;
            let span = side;
            let count = sums[last] + sums[before] - sums[last - span] - sums[before + span];
            if count >= least {
                corners.push(corner as u32);
            }
        }
    }
    corners
}

fn variance(level: &Level) -> f32 {
    let usable = || {
        level
            .colors
            .iter()
            .zip(&level.usable)
            .filter(|(_, usable)| **usable)
    };
    let (mut sums, mut squares, mut count) = ([0i64; 3], 0i64, 0i64);
    for (color, _) in usable() {
        for (sum, &value) in sums.iter_mut().zip(color) {
            *sum += i64::from(value);
            squares += i64::from(value) * i64::from(value);
        }
        count += 1;
    }
    let count = count.max(1) as f64;
    let means: f64 = sums
        .iter()
        .map(|&sum| (sum as f64 / count) * (sum as f64 / count))
        .sum();
    (squares as f64 / count - means).max(1.0) as f32
}

/// Number of pieces that [`laid`] lays, for progress.
pub(super) fn piece_count(canvas: &Canvas, side: usize) -> u64 {
    (2 * slots(canvas, side, 0).len()) as u64
}

/// Corners of the grid of pieces that covers the canvas, moved by `shift` pixels.
fn slots(canvas: &Canvas, side: usize, shift: i64) -> Vec<(i64, i64)> {
    let step = (side - overlap(side)).max(1);
    let ahead = (overlap(side) / 2) as i64;
    let mut slots = Vec::new();
    for y in 0..canvas.height.div_ceil(step) + 1 {
        for x in 0..canvas.width.div_ceil(step) + 1 {
            let corner = |i: usize| (i * step) as i64 - ahead + shift;
            if corner(x) < canvas.width as i64 && corner(y) < canvas.height as i64 {
                slots.push((corner(x), corner(y)));
            }
        }
    }
    slots
}

fn overlap(side: usize) -> usize {
    (side / 3).max(2)
}

/// Fills the empty pixels of `canvas`, which is at the coarsest level of `exemplar`.
pub(super) fn laid(
    canvas: &mut Canvas,
    blocks: &Blocks<'_>,
    seed: Seed,
    stage: &Stage<'_>,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let mut layer = Layer {
        canvas,
        blocks,
        used: Vec::new(),
        cancel,
    };
    let side = blocks.side;
    let mut random = seed.random();
    if !blocks.corners.is_empty() {
        let wobble = overlap(side) / 4;
        for (x, y) in slots(layer.canvas, side, 0) {
            let (x, y) = (
                x + jitter(&mut random, wobble),
                y + jitter(&mut random, wobble),
            );
            layer.lay(x, y, &mut random)?;
            stage.advance();
        }
        for (x, y) in slots(layer.canvas, side, (side / 2) as i64) {
            let (x, y) = (
                x + jitter(&mut random, side / 4),
                y + jitter(&mut random, side / 4),
            );
            layer.mend(x, y, &mut random)?;
            stage.advance();
        }
    }
    Ok(())
}

/// Between −`most` and `most`.
fn jitter(random: &mut Random, most: usize) -> i64 {
    random.below(2 * most + 1) as i64 - most as i64
}

/// Fills what pieces with gaps left empty: with what continues a neighbour, or its nearest foliage.
pub(super) fn filled(canvas: &mut Canvas, exemplar: &Exemplar, number: usize, seed: Seed) {
    let level = &exemplar.levels[number];
    let (width, height) = level.size();
    let mut random = seed.random();
    let (columns, rows) = (canvas.width as i64, canvas.height as i64);
    for (x, y) in (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y))) {
        let Some(at) = canvas.at(x, y).filter(|&at| !canvas.is_set(at)) else {
            continue;
        };
        let neighbour = [(-1, 0), (0, -1), (1, 0), (0, 1)]
            .into_iter()
            .find_map(|(dx, dy)| {
                let place = canvas.places[canvas.at(x + dx, y + dy)?];
                (place != NOWHERE).then(|| {
                    let (u, v) = level.place(place as usize);
                    let step = level.step as i64;
                    (u - dx * step, v - dy * step)
                })
            });
        let (u, v) =
            neighbour.unwrap_or_else(|| (random.below(width) as i64, random.below(height) as i64));
        canvas.set(at, exemplar.usable_near(number, u, v), level);
    }
}

/// A piece that was laid: where from (pixels of the photograph) and where to (of the canvas).
struct Use {
    from: (i64, i64),
    to: (i64, i64),
}

struct Layer<'a, 'b> {
    canvas: &'a mut Canvas,
    blocks: &'a Blocks<'b>,
    used: Vec<Use>,
    cancel: &'a Cancel,
}

impl Layer<'_, '_> {
    /// Lays a piece with its corner at (x, y) unless there is nothing to fill.
    fn lay(&mut self, x: i64, y: i64, random: &mut Random) -> Result<(), Cancelled> {
        self.cancel.check()?;
        let side = self.blocks.side as i64;
        let cells = || (0..side * side).map(move |i| (i % side, i / side));
        let is_empty = |canvas: &Canvas, (dx, dy): (i64, i64)| {
            canvas
                .at(x + dx, y + dy)
                .is_some_and(|at| !canvas.is_set(at))
        };
        if !cells().any(|cell| is_empty(self.canvas, cell)) {
            return Ok(());
        }
        let corner = self.best(x, y, |_, _| true, random);
        let sides = self.sides(x, y, corner, |canvas, dx, dy| {
            let outside = |dx: i64, dy: i64| {
                let beyond = !(0..side).contains(&dx) || !(0..side).contains(&dy);
                beyond
                    && canvas
                        .at(x + dx, y + dy)
                        .is_some_and(|at| canvas.is_set(at))
            };
            let steps = [(1, 0), (-1, 0), (0, 1), (0, -1)];
            match steps.iter().any(|(u, v)| outside(dx + u, dy + v)) {
                true => Side::First,
                false => Side::Either,
            }
        });
        self.join(x, y, corner, &sides)?;
        self.remember(x, y, corner);
        Ok(())
    }

    /// Lays a piece inside a closed seam around the middle of its square, if less is seen of seams
    /// there afterwards.
    fn mend(&mut self, x: i64, y: i64, random: &mut Random) -> Result<(), Cancelled> {
        self.cancel.check()?;
        let side = self.blocks.side as i64;
        let before = self.mismatch(x, y);
        let depth = |dx: i64, dy: i64| dx.min(dy).min(side - 1 - dx).min(side - 1 - dy);
        let corner = self.best(x, y, |dx, dy| depth(dx, dy) < side / 3, random);
        let sides = self.sides(x, y, corner, |_, dx, dy| match depth(dx, dy) {
            0 => Side::First,
            depth if depth >= (side - 1) / 2 => Side::Second,
            _ => Side::Either,
        });
        let square = (0..side * side).filter_map(|i| self.canvas.at(x + i % side, y + i / side));
        let covered: Vec<(usize, u32)> = square.map(|at| (at, self.canvas.places[at])).collect();
        self.join(x, y, corner, &sides)?;
        if self.mismatch(x, y) < before {
            self.remember(x, y, corner);
        } else {
            for (at, index) in covered.into_iter().filter(|(_, index)| *index != NOWHERE) {
                self.canvas.set(at, index, self.blocks.level);
            }
        }
        Ok(())
    }

    fn remember(&mut self, x: i64, y: i64, corner: u32) {
        self.used.push(Use {
            from: self.blocks.level.place(corner as usize),
            to: (x, y),
        });
    }

    /// The corner of the block that fits best at (x, y), compared where `counts(dx, dy)`.
    fn best(&self, x: i64, y: i64, counts: impl Fn(i64, i64) -> bool, random: &mut Random) -> u32 {
        let blocks = self.blocks;
        let (side, stride) = (blocks.side as i64, blocks.level.stride as i64);
        let cells: Vec<(usize, Color)> = (0..side * side)
            .map(|i| (i % side, i / side))
            .filter(|&(dx, dy)| counts(dx, dy))
            .filter_map(|(dx, dy)| {
                let at = self.canvas.at(x + dx, y + dy)?;
                let offset = (dy * stride + dx) as usize;
                self.canvas
                    .is_set(at)
                    .then(|| (offset, self.canvas.colors[at]))
            })
            .collect();
        let count = COMPARED * blocks.side.min(COMPARED_SIDE) / COMPARED_SIDE;
        let compared: Vec<u32> = (0..count)
            .map(|_| blocks.corners[random.below(blocks.corners.len())])
            .collect();
        let costs: Vec<f32> = compared
            .par_iter()
            .with_min_len(32)
            .map(|&corner| {
                let difference = difference(blocks.level, corner as usize, &cells);
                difference / blocks.variance + self.reuse(corner, (x, y))
            })
            .collect();
        let mut best = 0;
        for (index, cost) in costs.iter().enumerate() {
            if *cost < costs[best] {
                best = index;
            }
        }
        compared[best]
    }

    /// What earlier uses of the block at `corner` count against laying it at `to`.
    fn reuse(&self, corner: u32, to: (i64, i64)) -> f32 {
        let level = self.blocks.level;
        let from = level.place(corner as usize);
        let (side, step) = (self.blocks.side as f32, level.step as f32);
        let shared = |a: i64, b: i64| (1.0 - a.abs_diff(b) as f32 / (side * step)).max(0.0);
        let width = self.canvas.width as u64;
        let mut sum = 0.0;
        for used in &self.used {
            let share = shared(from.0, used.from.0) * shared(from.1, used.from.1);
            if share > 0.0 {
                let mut dx = to.0.abs_diff(used.to.0);
                if self.canvas.tiles_x {
                    dx = dx.min(width.saturating_sub(dx));
                }
                let apart = dx.max(to.1.abs_diff(used.to.1)) as f32 / side;
                sum += share * (1.0 + NEARBY * (1.0 - apart / NEAR_PIECES).max(0.0));
            }
        }
        sum * REUSE
    }

    /// Which picture each pixel of a piece must come from: what is given or cannot be had from the
    /// block stays, what is empty becomes new, and `otherwise` decides about the rest.
    fn sides(
        &self,
        x: i64,
        y: i64,
        corner: u32,
        otherwise: impl Fn(&Canvas, i64, i64) -> Side,
    ) -> Vec<Side> {
        let side = self.blocks.side as i64;
        let decide = |i: i64| {
            let (dx, dy) = (i % side, i / side);
            let Some(at) = self.canvas.at(x + dx, y + dy) else {
                return Side::Either;
            };
            let set = self.canvas.is_set(at);
            let usable = self.blocks.level.usable[self.offset(corner, dx, dy)];
            match (set, usable) {
                (true, false) => Side::First,
                (true, true) if self.canvas.given[at] => Side::First,
                (true, true) => otherwise(self.canvas, dx, dy),
                (false, true) => Side::Second,
                (false, false) => Side::Either,
            }
        };
        (0..side * side).map(decide).collect()
    }

    fn offset(&self, corner: u32, dx: i64, dy: i64) -> usize {
        corner as usize + dy as usize * self.blocks.level.stride + dx as usize
    }

    /// Cuts the block at `corner` into the canvas at (x, y).
    fn join(&mut self, x: i64, y: i64, corner: u32, sides: &[Side]) -> Result<(), Cancelled> {
        let side = self.blocks.side as i64;
        let level = self.blocks.level;
        let color = |[r, g, b, _]: Color| Straight([r as u8, g as u8, b as u8, 255]);
        let cells = || (0..side * side).map(|i| (i % side, i / side));
        let new: Vec<Straight> = cells()
            .map(|(dx, dy)| color(level.colors[self.offset(corner, dx, dy)]))
            .collect();
        // Where nothing is yet both pictures agree: a seam along it costs what it costs on one side.
        let old: Vec<Straight> = cells()
            .zip(&new)
            .map(|((dx, dy), &new)| match self.canvas.at(x + dx, y + dy) {
                Some(at) if self.canvas.is_set(at) => color(self.canvas.colors[at]),
                _ => new,
            })
            .collect();
        let picture = |pixels| Image::from_pixels(side as u32, side as u32, pixels);
        let side_of = |x: u32, y: u32| sides[(i64::from(y) * side + i64::from(x)) as usize];
        let seam = seam(
            &picture(old),
            &picture(new),
            side_of,
            StepCost::Difference,
            self.cancel,
        )?;
        for ((dx, dy), &from_new) in cells().zip(seam.from_second.pixels()) {
            let index = self.offset(corner, dx, dy);
            if from_new
                && level.usable[index]
                && let Some(at) = self.canvas.at(x + dx, y + dy)
                && !self.canvas.given[at]
            {
                self.canvas.set(at, index as u32, level);
            }
        }
        Ok(())
    }

    /// How much is seen of seams in the square at (x, y): over all neighbours in it that come from
    /// different pieces, how far each is from what its piece has there.
    fn mismatch(&self, x: i64, y: i64) -> i64 {
        let (side, level, canvas) = (self.blocks.side as i64, self.blocks.level, &*self.canvas);
        let towards = |from: usize, to: usize, dx: i32, dy: i32| -> i64 {
            if canvas.places[from] == NOWHERE {
                return 0;
            }
            match level.moved(canvas.places[from], dx, dy) {
                Some(index) if index == canvas.places[to] => 0,
                Some(index) => distance(level.colors[index as usize], canvas.colors[to]),
                None => distance(canvas.colors[from], canvas.colors[to]),
            }
        };
        let mut sum = 0;
        for (dx, dy) in (0..side * side).map(|i| (i % side, i / side)) {
            let Some(at) = canvas.at(x + dx, y + dy) else {
                continue;
            };
            for (u, v) in [(1, 0), (0, 1)] {
                if let Some(next) = canvas.at(x + dx + u, y + dy + v) {
                    sum += towards(at, next, u as i32, v as i32);
                    sum += towards(next, at, -u as i32, -v as i32);
                }
            }
        }
        sum
    }
}

/// Sum of the absolute differences of the channels.
#[inline]
fn distance(a: Color, b: Color) -> i64 {
    a.iter().zip(b).map(|(p, q)| i64::from((p - q).abs())).sum()
}

/// Mean squared difference of `cells` (offset from the corner, colour) from the block at `corner`.
fn difference(level: &Level, corner: usize, cells: &[(usize, Color)]) -> f32 {
    let mut sum = 0u64;
    for (offset, color) in cells {
        let there = level.colors[corner + offset];
        let squares = there.iter().zip(color).map(|(&p, &q)| {
            let d = i32::from(p) - i32::from(q);
            (d * d) as u32
        });
        sum += u64::from(squares.sum::<u32>());
    }
    sum as f32 / cells.len().max(1) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_side_is_found() {
        for most in 4..=40 {
            let found = largest_with(5..=31, |side| side <= most);
            assert_eq!(found, (most >= 5).then_some(most.min(31)));
        }
    }

    #[test]
    fn a_small_crown_gets_small_blocks_and_one_without_room_none() {
        let level = |side: usize| {
            let colors = vec![[9.0; 3]; side * side];
            Level::new(&colors, &vec![true; side * side], (side, side), 1)
        };
        let wide = level(40);
        assert_eq!(Blocks::new(&wide, 16).side, 16);
        // At least 15 % of the corners must fit: 16 of 40 a side.
        assert_eq!(Blocks::new(&wide, 1000).side, 25);
        assert!(Blocks::new(&level(3), 16).corners.is_empty());
    }
}
