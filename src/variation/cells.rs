//! A crown cut into cells, each of which takes what another place of the crown shows.
//!
//! Of many tries that place is taken that fits best what is around. Between cells the leaf that is lighter,
//! in front, wins, so that seams run along leaves; after V. Kwatra et al., *Graphcut Textures* (2003), with
//! that rule in the place of the cut, which costs no solver and keeps alpha. Gaps move with their cells. The stem and
//! the thick limbs that show between leaves ([`super::wood`]) stay: in pieces they would hang about the crown.

use super::Tree;
use super::habit::Habit;
use super::rounded::Rounded;
use super::seams::{CLEAR, Rags, front, lifted, mixed, over};
use super::wood;
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::raster::{Image, Mask, Rect, Straight};
use crate::segment::{Label, Labels};
use rayon::prelude::*;

/// Cells across a square as large as the crown.
const CELLS_ACROSS: f64 = 8.0;

/// Places that are tried for a cell.
const TRIES: usize = 140;

/// The same in what stands straight, whose places are all alike: with more, all individuals would find the
/// same one.
const TRIES_STRAIGHT: usize = 30;

/// Places that are looked at for them: a cell on the outline takes only such as lie on the outline, that runs
/// there as it does about the cell.
const LOOKS: usize = 1500;

/// Standard deviation of the Gaussian that rounds the outline for that, in cell sizes; how much the depths that it
/// tells may differ, and what they rise by.
const ROUNDED: f64 = 0.5;
const SAME_DEPTH: f64 = 0.1;
const SAME_RISE: f64 = 0.09;

/// Samples around and in a cell that places are compared by.
const SAMPLES: usize = 56;

/// What wood counts in a place, against a gap where leaves should be: its leaves hang around it.
const WOOD: f64 = 2.0;

/// How far up or down a cell's foliage may come from, as a share of the crown's height: light and size
/// of leaves change with height.
const REACH: f64 = 0.3;

/// How far, in cell sizes, a fully light leaf reaches over its cell's border.
const OVERLAP: f32 = 0.34;

/// How far in front sky counts: without, leaves of the cells about a gap would close it.
const SKY: f32 = 0.15;

/// In what stands straight a cell's foliage comes from about as far out on a bough, up to this share of the
/// boughs' length: it must hang as boughs do there.
const ALONG_BOUGH: f64 = 0.5;

/// Tips whose half width is less than this many cell sizes stay as they are.
const TIP: f64 = 0.6;

/// How softly a cell's border ends, pixels.
const SOFT: f32 = 2.0;

/// How much less claim, at most, what is seen behind the edges of a cell's leaves has.
const BEHIND: f32 = 0.3;

/// The foliage of a tree with every cell from where it fits best, `strength` saying how many change.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn regrown(
    both: Both<'_>,
    grid: &Grid,
    strength: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<Tree, Cancelled> {
    // What stands straight keeps its outline.
    let depths = match both.habit.is_straight() {
        true => None,
        false => Some(Depths::of(both, grid.side, cancel)?),
    };
    let patches = (0..grid.cells.len()).into_par_iter().map(|cell| {
        cancel.check()?;
        let mut random = seed.derive("cell", cell as u64).random();
        Ok(Patch::found(
            both,
            depths.as_ref(),
            (grid, cell),
            strength,
            &mut random,
        ))
    });
    let patches: Vec<Patch> = patches.collect::<Result<_, Cancelled>>()?;
    let (image, labels) = composed(both, grid, &patches);
    let mut grown = Tree { image, labels };
    wood::keep(both.wood[0], both.swayed, &mut grown);
    Ok(grown)
}

/// The size of a cell, pixels, in a crown of so many.
pub(super) fn cell_side(crown_pixels: usize) -> f64 {
    ((crown_pixels as f64).sqrt() / CELLS_ACROSS).max(4.0)
}

/// The cells of a crown: one point in each square of a grid; a pixel belongs to the nearest.
pub(super) struct Grid {
    /// Of the crown.
    bounds: Rect,
    left: f64,
    top: f64,
    /// Of a cell, pixels.
    pub(super) side: f64,
    columns: usize,
    rows: usize,
    cells: Vec<[f64; 2]>,
}

impl Grid {
    /// That of a crown in `bounds`, of so many pixels.
    pub(super) fn new(bounds: Rect, crown_pixels: usize, random: &mut Random) -> Self {
        let side = cell_side(crown_pixels);
        // A ring of squares outside: leaves may come to stand there.
        let (left, top) = (f64::from(bounds.x) - side, f64::from(bounds.y) - side);
        let count = |pixels: u32| (f64::from(pixels) / side).ceil() as usize + 2;
        let (columns, rows) = (count(bounds.width), count(bounds.height));
        let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (column, row)));
        let cells = cells.map(|(column, row)| {
            let mut within = || random.between(0.15, 0.85);
            [
                left + (column as f64 + within()) * side,
                top + (row as f64 + within()) * side,
            ]
        });
        Self {
            bounds,
            left,
            top,
            side,
            columns,
            rows,
            cells: cells.collect(),
        }
    }

    /// The cells whose square lies within one of that of (x, y).
    fn near(&self, x: f64, y: f64) -> impl Iterator<Item = usize> + '_ {
        let at = |value: f64, low: f64, count: usize| {
            (((value - low) / self.side).floor().max(0.0) as usize).min(count - 1)
        };
        let (column, row) = (at(x, self.left, self.columns), at(y, self.top, self.rows));
        let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
        rows.flat_map(move |row| {
            let columns = column.saturating_sub(1)..(column + 2).min(self.columns);
            columns.map(move |column| row * self.columns + column)
        })
    }
}

/// The tree as it is to be, swayed, and as it was, whose leaves are not drawn out: patches come from there.
#[derive(Clone, Copy)]
pub(super) struct Both<'a> {
    pub(super) swayed: &'a Tree,
    pub(super) tree: &'a Tree,
    pub(super) habit: &'a Habit,
    /// Where wood shows in the crown of either, in that order: it stays, and none comes from elsewhere.
    pub(super) wood: [&'a Mask; 2],
}

/// How deep in the crown the places of both lie.
struct Depths {
    swayed: Rounded,
    tree: Rounded,
}

impl Depths {
    fn of(both: Both<'_>, side: f64, cancel: &Cancel) -> Result<Self, Cancelled> {
        let of = |tree: &Tree| Rounded::of(&tree.image, side, ROUNDED, cancel);
        Ok(Self {
            swayed: of(both.swayed)?,
            tree: of(both.tree)?,
        })
    }

    /// How unlike the outline, if any is near, runs by both ends of `patch`: up to 1 nobody sees it.
    fn difference(&self, patch: &Patch) -> f64 {
        let [own, own_across, own_down] = self.swayed.profile(patch.to[0], patch.to[1]);
        let [depth, across, down] = self.tree.profile(patch.from[0], patch.from[1]);
        let across = if patch.is_mirrored { -across } else { across };
        let rise = (own_across - across).hypot(own_down - down);
        ((own - depth).abs() / SAME_DEPTH).max(rise / SAME_RISE)
    }
}

/// Where a cell takes its foliage from.
#[derive(Clone, Copy)]
struct Patch {
    to: [f64; 2],
    from: [f64; 2],
    /// Whether the cell stays as it is in the swayed tree.
    is_own: bool,
    is_mirrored: bool,
    /// Added to each channel, so that light and shade of the crown stay.
    lift: f32,
}

impl Patch {
    /// A cell that stays as it is.
    fn own(at: [f64; 2]) -> Self {
        Self {
            to: at,
            from: at,
            is_own: true,
            is_mirrored: false,
            lift: 0.0,
        }
    }

    /// The best of many places for the cell, or its own.
    fn found(
        both: Both<'_>,
        depths: Option<&Depths>,
        (grid, cell): (&Grid, usize),
        strength: f64,
        random: &mut Random,
    ) -> Self {
        let (own, bounds) = (Self::own(grid.cells[cell]), grid.bounds);
        // All draws are made whatever the strength, so that more strength only adds changes.
        let habit = both.habit;
        let is_straight = habit.is_straight();
        let is_tip = is_straight && habit.half(own.to[1]) < TIP * grid.side;
        if random.unit() >= share_changed(strength) || is_tip {
            return own;
        }
        let ring: Vec<[f64; 2]> = (0..SAMPLES)
            .map(|i| {
                let turn = std::f64::consts::TAU * i as f64 * 0.381_966;
                let radius = grid.side * if i % 4 == 0 { 0.3 } else { 0.7 };
                [radius * libm::cos(turn), radius * libm::sin(turn)]
            })
            .collect();
        let mut best: Option<(f64, Self)> = None;
        // Where the outline runs as it does nowhere else: the place that is least unlike.
        let mut spare: Option<(f64, Self)> = None;
        let mut left = if is_straight { TRIES_STRAIGHT } else { TRIES };
        for _ in 0..LOOKS {
            if left == 0 {
                break;
            }
            let [across, down, side] = [0; 3].map(|_| random.unit());
            let y = own.to[1] + REACH * (2.0 * down - 1.0) * f64::from(bounds.height);
            let (x, is_mirrored) = if is_straight {
                along_bough(habit, own.to, y, across, side)
            } else {
                let x = f64::from(bounds.x) + across * f64::from(bounds.width);
                (x, side < 0.5)
            };
            let from = [x, y];
            let apart = (from[0] - own.to[0]).hypot(from[1] - own.to[1]);
            if apart < 1.1 * grid.side {
                continue;
            }
            let patch = Self {
                from,
                is_own: false,
                is_mirrored,
                ..own
            };
            let difference = depths.map_or(0.0, |depths| depths.difference(&patch));
            let fits = difference <= 1.0;
            left -= usize::from(fits);
            if !fits && spare.is_some_and(|(least, _)| difference >= least) {
                continue;
            }
            let Some((cost, lift)) = patch.cost(both, &ring) else {
                continue;
            };
            let kept = if fits { &mut best } else { &mut spare };
            let value = if fits { cost } else { difference };
            if kept.is_none_or(|(least, _)| value < least) {
                *kept = Some((value, Self { lift, ..patch }));
            }
        }
        best.or(spare).map_or(own, |(_, patch)| patch)
    }

    /// The place that pixel (x, y) of the new picture comes from.
    fn source(&self, x: f64, y: f64) -> (i64, i64) {
        let dx = x - self.to[0];
        let dx = if self.is_mirrored { -dx } else { dx };
        let round = |value: f64| (value + 0.5).floor() as i64;
        (
            round(self.from[0] + dx),
            round(self.from[1] + y - self.to[1]),
        )
    }

    /// How badly the patch fits, and the lift that makes its light that of its place; `None` where
    /// either shows trunk.
    fn cost(&self, both: Both<'_>, ring: &[[f64; 2]]) -> Option<(f64, f32)> {
        let Both { swayed, tree, .. } = both;
        let (mut own_light, mut other_light, mut lit) = (0.0f64, 0.0, 0.0f64);
        let (mut alpha, mut color, mut wood) = (0.0, 0.0, 0.0);
        for offset in ring {
            let (x, y) = (self.to[0] + offset[0], self.to[1] + offset[1]);
            let (u, v) = self.source(x, y);
            let (x, y) = ((x + 0.5).floor() as i64, (y + 0.5).floor() as i64);
            let is_trunk = |of: &Tree, x, y| of.labels.get(x, y) == Some(Label::Trunk);
            if is_trunk(swayed, x, y) || is_trunk(tree, u, v) {
                return None;
            }
            let at = |of: &Tree, x, y| of.image.get(x, y).unwrap_or(CLEAR);
            let (own, other) = (at(swayed, x, y), at(tree, u, v));
            let (a, b) = (f64::from(own.alpha()), f64::from(other.alpha()));
            alpha += (a - b).abs() / 255.0;
            wood += f64::from(u8::from(both.wood[1].get(u, v) == Some(true)));
            if a.min(b) > 128.0 {
                lit += 1.0;
                own_light += f64::from(own.luma());
                other_light += f64::from(other.luma());
                let difference = |c: usize| f64::from(own.0[c].abs_diff(other.0[c]));
                color += (difference(0) + difference(1) + difference(2)) / 765.0;
            }
        }
        let count = ring.len() as f64;
        let lift = if lit > 0.0 {
            (own_light - other_light) / lit
        } else {
            0.0
        };
        let cost =
            (1.2 * alpha + WOOD * wood) / count + color / lit.max(1.0) + 1.5 * lift.abs() / 255.0;
        Some((cost, (0.7 * lift) as f32))
    }
}

/// Where, at height `y`, boughs are about as far out as at `to`, and whether foliage from there is to be
/// mirrored: on the other side it is, next to the stem it may be. `share` and `side` are draws from 0 to 1.
fn along_bough(habit: &Habit, to: [f64; 2], y: f64, share: f64, side: f64) -> (f64, bool) {
    /// Share of a bough next to the stem.
    const INNER: f64 = 0.4;
    let out = (to[0] - habit.axis(to[1])) / habit.half(to[1]).max(1.0);
    let is_other = side < 0.5;
    let is_turned = out.abs() < INNER && (2.0 * side).fract() < 0.5;
    let out = out + ALONG_BOUGH * (2.0 * share - 1.0);
    let out = if is_other { -out } else { out };
    (habit.axis(y) + out * habit.half(y), is_other != is_turned)
}

/// Strength from which on all cells change: every clump that stays is found again, and is drawn out with the
/// outline.
const ALL_CHANGE: f64 = 0.7;

/// The share of cells that change at this strength.
pub(super) fn share_changed(strength: f64) -> f64 {
    let rest = 1.0 - (strength / ALL_CHANGE).clamp(0.0, 1.0);
    1.0 - rest * rest
}

/// The picture and its labels with every cell from where its patch says.
fn composed(both: Both<'_>, grid: &Grid, patches: &[Patch]) -> (Image<Straight>, Labels) {
    let Both { swayed, tree, .. } = both;
    let [_, shunned] = both.wood;
    let (mut image, mut labels) = (swayed.image.clone(), swayed.labels.clone());
    let width = image.width() as usize;
    let side = grid.side as f32;
    let rags = Rags::new(grid.side);
    let rows = image.pixels_mut().par_chunks_mut(width);
    rows.zip(labels.pixels_mut().par_chunks_mut(width))
        .enumerate()
        .for_each(|(y, (pixels, labels))| {
            let within = |value: f64, low: f64, count: usize| {
                value >= low && value < low + count as f64 * grid.side
            };
            if !within(y as f64, grid.top, grid.rows) {
                return;
            }
            for (x, (pixel, label)) in pixels.iter_mut().zip(labels).enumerate() {
                let (fx, fy) = (x as f64, y as f64);
                if *label == Label::Trunk || !within(fx, grid.left, grid.columns) {
                    continue;
                }
                let mut best = (f32::NEG_INFINITY, *pixel, *label);
                let mut second = (f32::NEG_INFINITY, CLEAR);
                for cell in grid.near(fx, fy) {
                    let patch = &patches[cell];
                    let [cx, cy] = patch.to;
                    let distance = ((fx - cx) * (fx - cx) + (fy - cy) * (fy - cy)).sqrt() as f32;
                    let (u, v) = patch.source(fx, fy);
                    let from = if patch.is_own { swayed } else { tree };
                    let other = from.image.get(u, v).unwrap_or(CLEAR);
                    let other_label = from.labels.get(u, v).unwrap_or_default();
                    let is_wood = !patch.is_own && shunned.get(u, v) == Some(true);
                    if other_label == Label::Trunk || is_wood {
                        continue;
                    }
                    let sky = SKY * (1.0 - f32::from(other.alpha()) / 255.0);
                    let front = front(other, patch.lift) + sky;
                    let claim = OVERLAP * front - distance / side + rags.at(cell, x, y);
                    let other = lifted(other, patch.lift);
                    if claim > best.0 {
                        second = (best.0, best.1);
                        best = (claim, other, other_label);
                    } else if claim > second.0 {
                        second = (claim, other);
                    }
                }
                let ahead = best.0 - second.0;
                let share = 0.5 + 0.5 * ahead * side / SOFT;
                let behind = if ahead < BEHIND { second.1 } else { CLEAR };
                (*pixel, *label) = (
                    mixed(over(best.1, behind), second.1, share.min(1.0)),
                    best.2,
                );
            }
        });
    (image, labels)
}
