//! Another individual of the same tree: its foliage grown anew from its own, its colours moved a little
//! within what the species has.
//!
//! A warp leaves every clump and gap where an eye finds it again. So the crown is cut into cells, and a
//! cell takes what another place of the same crown shows (mirrored or not), the one of many
//! tries that fits best what is around. Between cells the leaf that is lighter, in front, wins, so that
//! seams run along leaves; after V. Kwatra et al., *Graphcut Textures* (2003), with that rule in the place of
//! the cut, which costs no solver and keeps alpha. Gaps move with their cells; limbs sway and the outline
//! swells and shrinks by smooth noise (`sway`); near the outline alpha is that of the swayed tree, so that no cell's border shows against
//! the sky. Strength says how
//! many cells change and scales all else: more of it keeps all changes and adds to them.
//!
//! Limits: the trunk and the few limbs that cross the whole crown stay or are cut; a palm's fronds are
//! cut too, so trees whose crown is few large pieces should be varied gently.

use super::habit::Habit;
use super::noise::Noise;
use super::stem::rebarked;
use super::sway::{Boughs, swayed, without_gaps};
use super::{HslShift, Tree};
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::raster::{Image, Rect, Straight, labelled_components, opaque_bounds, smoothed_within};
use crate::segment::{Label, Labels};
use rayon::prelude::*;

/// Cells across a square as large as the crown.
const CELLS_ACROSS: f64 = 8.0;

/// Places that are tried for a cell.
const TRIES: usize = 140;

/// The same in what stands straight, whose places are all alike: with more, all individuals would find the
/// same one.
const TRIES_STRAIGHT: usize = 30;

/// Samples around and in a cell that places are compared by.
const SAMPLES: usize = 56;

/// How far up or down a cell's foliage may come from, as a share of the crown's height: light and size
/// of leaves change with height.
const REACH: f64 = 0.3;

/// How much of the usual jitter of hue, saturation and lightness: within one species.
const COLOR: f64 = 0.45;

/// The same for the difference of clumps as wide as this many cells.
const CLUMP_COLOR: f64 = 0.6;
const CLUMP: f64 = 1.6;

/// How far, in cell sizes, a fully light leaf reaches over its cell's border.
const OVERLAP: f32 = 0.34;

/// In what stands straight a cell's foliage comes from about as far out on a bough, up to this share of the
/// boughs' length: it must hang as boughs do there.
const ALONG_BOUGH: f64 = 0.5;

/// Tips whose half width is less than this many cell sizes stay as they are.
const TIP: f64 = 0.6;

/// Standard deviation of the Gaussian that tells how deep in the crown a pixel lies, in cell sizes; on the
/// outline it gives 0.5. Up to [`INSIDE`] leaves stand as they grew, below [`OUTSIDE`] is sky.
const BAND: f64 = 0.22;
const INSIDE: f32 = 0.88;
const OUTSIDE: f32 = 0.06;

/// How far out leaves may stand there: up to this, by noise of waves as long as these, in cell sizes.
const OUTERMOST: f32 = 0.85;
const REACHES: [f64; 2] = [0.4, 0.07];

/// The same from which on gaps in the new foliage are gaps of the tree.
const DEEP: f32 = 0.997;

/// Side of the largest square of leaves, in cell sizes, that hang in the air.
const LOOSE: f64 = 0.35;

/// How ragged the borders of cells are and how fine, in cell sizes: as leaves are.
const RAGGED: f32 = 0.3;
const RAG: f64 = 0.09;

/// Makes `tree` another individual, `strength` (0: itself) to 1 far from what it was.
///
/// # Errors
/// [`Cancelled`].
pub fn make_individual(
    tree: &mut Tree,
    strength: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let crown = tree.labels.map(|label| *label == Label::Crown);
    let Some(bounds) = opaque_bounds(&crown).filter(|_| strength > 0.0) else {
        return Ok(());
    };
    let mut random = seed.derive("individual", 0).random();
    let shift = HslShift::drawn(COLOR * strength, &mut random);
    let of_clump = HslShift::drawn(CLUMP_COLOR * strength, &mut random);
    let grid = Grid::new(bounds, crown.count(), &mut random);
    let Some(habit) = Habit::of(tree) else {
        return Ok(());
    };
    rebarked(tree, grid.side, strength, &mut random);
    let boughs = Boughs::new(&mut seed.derive("boughs", 0).random());
    let stance = (&habit, &boughs);
    let outline = swayed(tree, stance, grid.side, strength, &mut random, cancel)?;
    let both = Both {
        swayed: &outline,
        tree,
        habit: &habit,
    };
    let patches: Vec<Patch> = (0..grid.cells.len())
        .into_par_iter()
        .map(|cell| {
            cancel.check()?;
            let mut random = seed.derive("cell", cell as u64).random();
            let patch = Patch::found(both, bounds, &grid, cell, strength, &mut random);
            Ok(patch)
        })
        .collect::<Result<_, Cancelled>>()?;
    let (image, labels) = composed(both, &grid, &patches);
    let grown = Tree { image, labels };
    let whole = (&outline, &habit);
    let (mut made, inside) = within_outline(whole, &grown, grid.side, &mut random, cancel)?;
    clear_loose_leaves(&mut made, &inside, grid.side);
    let Tree { mut image, labels } = made;
    let clumps = Noise::new(&mut random);
    let width = image.width() as usize;
    let rows = image.pixels_mut().par_chunks_mut(width);
    let rows = rows.zip(labels.pixels().par_chunks(width)).enumerate();
    rows.for_each(|(y, (pixels, labels))| {
        for (x, (pixel, label)) in pixels.iter_mut().zip(labels).enumerate() {
            if *label != Label::Trunk && pixel.alpha() > 0 {
                let at = [x, y].map(|along| along as f64 / (CLUMP * grid.side));
                let own = shift.between(&of_clump, clumps.at(at) - 0.5);
                *pixel = own.applied(*pixel);
            }
        }
    });
    *tree = Tree { image, labels };
    Ok(())
}

/// The foliage of `grown` in the tree `tree`. Along the outline leaves stand as they grew, more or less far
/// out from place to place, and the tips of `tree`'s own twigs stay; a little deeper a cell may show sky
/// that belongs beyond it, and there `tree` fills it.
fn within_outline(
    (tree, habit): (&Tree, &Habit),
    grown: &Tree,
    side: f64,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<(Tree, Image<f32>), Cancelled> {
    let alpha = without_gaps(&tree.image, side).map(|&inside| f32::from(u8::from(inside)));
    let everywhere = alpha.map(|_| true);
    let inside = smoothed_within(&alpha, &everywhere, BAND * side, cancel)?;
    let reach = Noise::new(random);
    let width = inside.width() as usize;
    let mut result = tree.clone();
    let rows = result.image.pixels_mut().par_chunks_mut(width);
    let rows = rows.zip(result.labels.pixels_mut().par_chunks_mut(width));
    let grown = grown
        .image
        .pixels()
        .par_chunks(width)
        .zip(grown.labels.pixels().par_chunks(width));
    let rows = rows
        .zip(grown)
        .zip(inside.pixels().par_chunks(width))
        .enumerate();
    rows.for_each(
        |(y, (((pixels, labels), (foliage, foliage_labels)), inside))| {
            let reached = outermost(habit, y, side);
            for x in 0..width {
                if labels[x] == Label::Trunk || foliage_labels[x] == Label::Trunk {
                    continue;
                }
                let depth = inside[x];
                let is_leaf = foliage[x].alpha() >= 128;
                let takes = if depth < 0.5 {
                    let at = |wave: f64| reach.at([x, y].map(|along| along as f64 / (wave * side)));
                    let [wide, fine] = REACHES.map(at);
                    let least = OUTERMOST * (0.65 * wide + 0.35 * fine) as f32;
                    is_leaf && depth > reached.max(least)
                } else {
                    is_leaf || !(INSIDE..DEEP).contains(&depth)
                };
                if takes {
                    (pixels[x], labels[x]) = (foliage[x], foliage_labels[x]);
                }
            }
        },
    );
    Ok((result, inside))
}

/// The depth from which leaves may stand out in row `y`: about a slender tip none stand far out.
fn outermost(habit: &Habit, y: usize, side: f64) -> f32 {
    let room = (habit.half(y as f64) / (1.5 * side)).min(1.0);
    let kept = (habit.straight() * (1.0 - room)) as f32;
    OUTSIDE + kept * (0.45 - OUTSIDE)
}

/// Clears what hangs in the air beyond the outline: leaves of a cell whose twig lies in another.
fn clear_loose_leaves(tree: &mut Tree, inside: &Image<f32>, side: f64) {
    let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= 48));
    let count = parts.pixels().iter().copied().max().unwrap_or(0) as usize;
    let mut found = vec![(0u32, 0.0f32); count + 1];
    for (&part, &inside) in parts.pixels().iter().zip(inside.pixels()) {
        let (area, deepest) = &mut found[part as usize];
        *area += 1;
        *deepest = deepest.max(inside);
    }
    let largest = LOOSE * side * LOOSE * side;
    let is_loose = |part: u32| {
        let (area, deepest) = found[part as usize];
        part == 0 || (f64::from(area) < largest && deepest < 0.5)
    };
    let pixels = tree.image.pixels_mut().iter_mut();
    let places = parts.pixels().iter().zip(inside.pixels());
    for ((pixel, label), (&part, &inside)) in pixels.zip(tree.labels.pixels_mut()).zip(places) {
        if inside < 0.5 && is_loose(part) && *label != Label::Trunk {
            (*pixel, *label) = (Straight([0; 4]), Label::Background);
        }
    }
}

/// `tree` seen in a mirror.
pub fn mirrored(tree: &Tree) -> Tree {
    fn flipped<P: Copy>(image: &Image<P>) -> Image<P> {
        let rows = (0..image.height()).flat_map(|y| image.row(y).iter().rev().copied());
        Image::from_pixels(image.width(), image.height(), rows.collect())
    }
    Tree {
        image: flipped(&tree.image),
        labels: flipped(&tree.labels),
    }
}

/// The cells of a crown: one point in each square of a grid; a pixel belongs to the nearest.
struct Grid {
    left: f64,
    top: f64,
    side: f64,
    columns: usize,
    rows: usize,
    cells: Vec<[f64; 2]>,
}

impl Grid {
    fn new(bounds: Rect, crown_pixels: usize, random: &mut Random) -> Self {
        let side = ((crown_pixels as f64).sqrt() / CELLS_ACROSS).max(4.0);
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
struct Both<'a> {
    swayed: &'a Tree,
    tree: &'a Tree,
    habit: &'a Habit,
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
        bounds: Rect,
        grid: &Grid,
        cell: usize,
        strength: f64,
        random: &mut Random,
    ) -> Self {
        let own = Self::own(grid.cells[cell]);
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
        let tries = if is_straight { TRIES_STRAIGHT } else { TRIES };
        for _ in 0..tries {
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
            if let Some((cost, lift)) = patch.cost(both, &ring)
                && best.is_none_or(|(least, _)| cost < least)
            {
                best = Some((cost, Self { lift, ..patch }));
            }
        }
        best.map_or(own, |(_, patch)| patch)
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
    fn cost(&self, Both { swayed, tree, .. }: Both<'_>, ring: &[[f64; 2]]) -> Option<(f64, f32)> {
        let (mut own_light, mut other_light, mut lit) = (0.0f64, 0.0, 0.0f64);
        let (mut alpha, mut color) = (0.0, 0.0);
        for offset in ring {
            let (x, y) = (self.to[0] + offset[0], self.to[1] + offset[1]);
            let (u, v) = self.source(x, y);
            let (x, y) = ((x + 0.5).floor() as i64, (y + 0.5).floor() as i64);
            let is_trunk = |of: &Tree, x, y| of.labels.get(x, y) == Some(Label::Trunk);
            if is_trunk(swayed, x, y) || is_trunk(tree, u, v) {
                return None;
            }
            let at = |of: &Tree, x, y| of.image.get(x, y).unwrap_or(Straight([0; 4]));
            let (own, other) = (at(swayed, x, y), at(tree, u, v));
            let (a, b) = (f64::from(own.alpha()), f64::from(other.alpha()));
            alpha += (a - b).abs() / 255.0;
            if a.min(b) > 128.0 {
                lit += 1.0;
                own_light += f64::from(light(own));
                other_light += f64::from(light(other));
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
        let cost = 1.2 * alpha / count + color / lit.max(1.0) + 1.5 * lift.abs() / 255.0;
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

/// The share of cells that change at this strength: at 0.7 nearly all, for every clump that stays is
/// found again.
fn share_changed(strength: f64) -> f64 {
    let rest = 1.0 - strength.clamp(0.0, 1.0);
    1.0 - rest * rest * rest
}

fn light(pixel: Straight) -> f32 {
    let [r, g, b, _] = pixel.0.map(f32::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The picture and its labels with every cell from where its patch says.
fn composed(
    Both { swayed, tree, .. }: Both<'_>,
    grid: &Grid,
    patches: &[Patch],
) -> (Image<Straight>, Labels) {
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
                for cell in grid.near(fx, fy) {
                    let patch = &patches[cell];
                    let [cx, cy] = patch.to;
                    let distance = ((fx - cx) * (fx - cx) + (fy - cy) * (fy - cy)).sqrt() as f32;
                    let (u, v) = patch.source(fx, fy);
                    let from = if patch.is_own { swayed } else { tree };
                    let other = from.image.get(u, v).unwrap_or(Straight([0; 4]));
                    let other_label = from.labels.get(u, v).unwrap_or_default();
                    if other_label == Label::Trunk {
                        continue;
                    }
                    let shown = f32::from(other.alpha()) / 255.0;
                    let front = shown * (0.25 + 0.75 * (light(other) + patch.lift) / 255.0);
                    let claim = OVERLAP * front - distance / side + rags.at(cell, x, y);
                    if claim > best.0 {
                        best = (claim, lifted(other, patch.lift), other_label);
                    }
                }
                (*pixel, *label) = (best.1, best.2);
            }
        });
    (image, labels)
}

/// What makes the borders of cells ragged: a tile of noise, of which each cell sees another part.
struct Rags {
    tile: Vec<f32>,
    /// Pixels of the tile for one of the picture.
    scale: f32,
}

impl Rags {
    const SIDE: usize = 128;

    fn new(side: f64) -> Self {
        /// Pixels of the tile in a wave.
        const WAVE: f64 = 4.0;
        let noise = Noise::new(&mut Seed(0).random());
        let at = |i: usize| [i % Self::SIDE, i / Self::SIDE].map(|along| along as f64 / WAVE);
        let value = |i| RAGGED * (noise.at(at(i)) as f32 - 0.5);
        Self {
            tile: (0..Self::SIDE * Self::SIDE).map(value).collect(),
            scale: (WAVE / (RAG * side)) as f32,
        }
    }

    fn at(&self, cell: usize, x: usize, y: usize) -> f32 {
        let place = |along: usize, offset: usize| {
            ((along as f32 * self.scale) as usize + cell * offset) % Self::SIDE
        };
        self.tile[place(y, 47) * Self::SIDE + place(x, 29)]
    }
}

/// The pixel with its light moved.
fn lifted(pixel: Straight, lift: f32) -> Straight {
    let [r, g, b, alpha] = pixel.0;
    // By a factor: shade keeps its colour.
    let own = light(pixel).max(8.0);
    let factor = ((own + lift) / own).clamp(0.6, 1.6);
    let scaled = |value: u8| (f32::from(value) * factor + 0.5).min(255.0) as u8;
    Straight([scaled(r), scaled(g), scaled(b), alpha])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::variation::Look;
    use crate::variation::maker::grown as sample;

    fn individual(tree: &Tree, strength: f64) -> Tree {
        let mut tree = tree.clone();
        make_individual(&mut tree, strength, Seed(3), &Cancel::new()).unwrap();
        tree
    }

    /// Mean difference of premultiplied colours.
    fn difference(a: &Tree, b: &Tree) -> f64 {
        let pixels = a.image.pixels().iter().zip(b.image.pixels());
        let sum: f64 = pixels
            .map(|(a, b)| {
                let (a, b) = (a.premultiplied().0, b.premultiplied().0);
                (0..4).map(|c| f64::from(a[c].abs_diff(b[c]))).sum::<f64>()
            })
            .sum();
        sum / a.image.pixels().len() as f64
    }

    #[test]
    fn no_strength_is_the_tree_and_more_goes_farther() {
        for name in ["oak", "spruce"] {
            let tree = sample(name);
            assert_eq!(individual(&tree, 0.0), tree);
            let steps = [0.0, 0.1, 0.35, 1.0].map(|s| difference(&tree, &individual(&tree, s)));
            assert!(steps.is_sorted(), "{name}: {steps:?}");
            assert!(steps[3] > 4.0, "{name}: {steps:?}");
        }
    }

    #[test]
    fn an_eye_knows_it_less_and_less() {
        let tree = sample("maple");
        let look = |tree: &Tree| {
            Look::of(&tree.image.premultiplied(), &Cancel::new())
                .unwrap()
                .unwrap()
        };
        let own = look(&tree);
        let likeness = [0.1, 0.35, 0.7].map(|s| own.likeness(&look(&individual(&tree, s))).score());
        assert!(likeness[0] > likeness[2], "{likeness:?}");
        assert!(likeness[1] >= likeness[2], "{likeness:?}");
        assert!(likeness[2] < 0.5, "{likeness:?}");
    }

    #[test]
    fn the_species_keeps_its_colours_its_mass_and_its_trunk() {
        let tree = sample("linden");
        let other = individual(&tree, 1.0);
        let seen = |tree: &Tree| {
            tree.image
                .pixels()
                .iter()
                .filter(|p| p.alpha() > 127)
                .count() as f64
        };
        assert!((0.85..1.2).contains(&(seen(&other) / seen(&tree))));
        let mean = |tree: &Tree, c: usize| {
            let pixels = tree.image.pixels().iter().filter(|p| p.alpha() > 127);
            pixels.map(|p| f64::from(p.0[c])).sum::<f64>() / seen(tree)
        };
        for c in 0..3 {
            assert!((mean(&tree, c) - mean(&other, c)).abs() < 22.0);
        }
        // The stem winds a little; it stands where it stood, as thick as it was.
        let row = |tree: &Tree, y: u32| {
            let labels = tree.labels.row(y).iter().enumerate();
            let trunk = labels.filter(|(_, label)| **label == Label::Trunk);
            let columns: Vec<f64> = trunk.map(|(x, _)| x as f64).collect();
            (
                columns.iter().sum::<f64>() / columns.len() as f64,
                columns.len(),
            )
        };
        let foot = tree.image.height() - 4;
        let (own, new) = (row(&tree, foot), row(&other, foot));
        assert!((own.0 - new.0).abs() < 2.5, "{own:?} {new:?}");
        assert!(own.1.abs_diff(new.1) <= 3, "{own:?} {new:?}");
    }

    #[test]
    fn a_mirror_twice_is_the_tree() {
        let tree = sample("birch");
        assert_ne!(mirrored(&tree), tree);
        assert_eq!(mirrored(&mirrored(&tree)), tree);
    }
}
