//! Another individual of the same tree: its foliage grown anew from its own, its colours moved a little
//! within what the species has.
//!
//! A warp leaves every clump and gap where an eye finds it again. So the crown is cut into cells, and a
//! cell takes what another place of the same crown shows (mirrored or not), the one of many
//! tries that fits best what is around. Between cells the leaf that is lighter, in front, wins, so that
//! seams run along leaves; after V. Kwatra et al., *Graphcut Textures* (2003), with that rule in the place of
//! the cut, which costs no solver and keeps alpha. Gaps move with their cells; limbs and outline sway by
//! smooth noise; near the outline alpha is that of the swayed tree, so that no cell's border shows against
//! the sky. Strength is the share
//! of cells that change, and scales the colours' move: more of it keeps all changes and adds to them.
//!
//! Limits: the trunk and the few limbs that cross the whole crown stay or are cut; a palm's fronds are
//! cut too, so trees whose crown is few large pieces should be varied gently.

use super::noise::Noise;
use super::{HslShift, Tree};
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::raster::{
    Image, Mask, Rect, Straight, dilated, flooded_from_outside, opaque_bounds, smoothed_within,
};
use crate::segment::{Label, Labels, crown_baseline};
use rayon::prelude::*;

/// Cells across a square as large as the crown.
const CELLS_ACROSS: f64 = 8.0;

/// Places that are tried for a cell.
const TRIES: usize = 140;

/// Samples around and in a cell that places are compared by.
const SAMPLES: usize = 56;

/// How far up or down a cell's foliage may come from, as a share of the crown's height: light and size
/// of leaves change with height.
const REACH: f64 = 0.3;

/// How much of the usual jitter of hue, saturation and lightness: within one species.
const COLOR: f64 = 0.45;

/// How far, in cell sizes, a fully light leaf reaches over its cell's border.
const OVERLAP: f32 = 0.34;

/// Wavelength and height of the waves in which limbs sway, in cell sizes.
const WAVE: f64 = 2.4;
const SWAY: f64 = 0.5;

/// Width of the band along the outline that keeps its alpha, in cell sizes, and the smoothed alpha that
/// it ends at.
const BAND: f64 = 0.22;
const INSIDE: f32 = 0.84;

/// Smoothed alpha from which gaps in the new foliage are gaps of the tree.
const DEEP: f32 = 0.997;

/// Gaps up to twice this wide, in cell sizes, belong to the inside although the sky reaches into them.
const CLOSED: f64 = 0.16;

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
    let grid = Grid::new(bounds, crown.count(), &mut random);
    let patches: Vec<Patch> = (0..grid.cells.len())
        .into_par_iter()
        .map(|cell| {
            cancel.check()?;
            let mut random = seed.derive("cell", cell as u64).random();
            Ok(Patch::found(
                tree,
                bounds,
                &grid,
                cell,
                strength,
                &mut random,
            ))
        })
        .collect::<Result<_, Cancelled>>()?;
    let outline = swayed(tree, &grid, strength, &mut random);
    let (image, labels) = composed(tree, &grid, &patches);
    let grown = Tree { image, labels };
    let Tree { mut image, labels } = within_outline(&outline, &grown, grid.side, cancel)?;
    for (pixel, label) in image.pixels_mut().iter_mut().zip(labels.pixels()) {
        if *label != Label::Trunk {
            *pixel = shift.applied(*pixel);
        }
    }
    *tree = Tree { image, labels };
    Ok(())
}

/// `tree` with its crown moved by smooth waves; the trunk and what is near it stay.
fn swayed(tree: &Tree, grid: &Grid, strength: f64, random: &mut Random) -> Tree {
    let (image, labels) = (&tree.image, &tree.labels);
    let low = crown_baseline(labels).map_or(f64::from(image.height()), f64::from);
    let waves = [0; 2].map(|_| Noise::new(random));
    let wave = WAVE * grid.side;
    let height = 2.0 * SWAY * grid.side * strength;
    let width = image.width();
    let mut swayed = tree.clone();
    let rows = swayed.image.pixels_mut().par_chunks_mut(width as usize);
    rows.zip(swayed.labels.pixels_mut().par_chunks_mut(width as usize))
        .enumerate()
        .for_each(|(y, (pixels, out))| {
            let y = y as f64;
            let free = ((low - y) / (2.0 * grid.side)).clamp(0.0, 1.0) * height;
            if free <= 0.0 {
                return;
            }
            for (x, (pixel, label)) in pixels.iter_mut().zip(out).enumerate() {
                let x = x as f64;
                let place = [x / wave, y / wave];
                let [dx, dy] = [0, 1].map(|axis| free * (waves[axis].at(place) - 0.5));
                let (u, v) = (x + dx, y + dy);
                *pixel = between_pixels(image, u, v);
                let near = |value: f64| (value + 0.5).floor() as i64;
                *label = labels.get(near(u), near(v)).unwrap_or_default();
            }
        });
    swayed
}

/// The colour of `image` at a place between its pixels: bilinear, weighted by alpha.
fn between_pixels(image: &Image<Straight>, x: f64, y: f64) -> Straight {
    let (left, top) = (x.floor(), y.floor());
    let (s, t) = (x - left, y - top);
    let mut sums = [0.0f64; 4];
    let corners = [
        (0, 0, 1.0 - s, 1.0 - t),
        (1, 0, s, 1.0 - t),
        (0, 1, 1.0 - s, t),
        (1, 1, s, t),
    ];
    for (dx, dy, across, down) in corners {
        let Some(pixel) = image.get(left as i64 + dx, top as i64 + dy) else {
            continue;
        };
        let share = across * down * f64::from(pixel.alpha());
        for (sum, value) in sums.iter_mut().zip(pixel.0) {
            *sum += share * f64::from(value);
        }
        sums[3] += share - share * f64::from(pixel.alpha());
    }
    let alpha = sums[3];
    let color = |c: usize| (sums[c] / alpha.max(1e-9) + 0.5).clamp(0.0, 255.0) as u8;
    let alpha = (alpha + 0.5).clamp(0.0, 255.0) as u8;
    if alpha == 0 {
        return Straight([0; 4]);
    }
    Straight([color(0), color(1), color(2), alpha])
}

/// Where the tree is, gaps between its leaves and boughs included: those of the new foliage take their
/// place.
fn without_gaps(image: &Image<Straight>, side: f64) -> Mask {
    let reach = (CLOSED * side).clamp(1.0, 60.0) as u8;
    let seen = image.map(|pixel| pixel.alpha() >= 96);
    let filled = flooded_from_outside(&dilated(&seen, reach));
    let outside = dilated(&filled.map(|inside| !inside), reach);
    outside.map(|outside| !outside)
}

/// The foliage of `grown` in the outline of `tree`: along it alpha is `tree`'s, inside that of the foliage.
fn within_outline(
    tree: &Tree,
    grown: &Tree,
    side: f64,
    cancel: &Cancel,
) -> Result<Tree, Cancelled> {
    let alpha = without_gaps(&tree.image, side).map(|&inside| f32::from(u8::from(inside)));
    let everywhere = alpha.map(|_| true);
    let inside = smoothed_within(&alpha, &everywhere, BAND * side, cancel)?;
    let mut result = tree.clone();
    let pixels = result.image.pixels_mut().iter_mut();
    let both = pixels.zip(result.labels.pixels_mut());
    let grown = grown.image.pixels().iter().zip(grown.labels.pixels());
    for (((pixel, label), (foliage, foliage_label)), inside) in both.zip(grown).zip(inside.pixels())
    {
        if *label == Label::Trunk || *foliage_label == Label::Trunk {
            continue;
        }
        // Near the outline a cell may show sky that belongs beyond it.
        if *inside >= INSIDE && (foliage.alpha() >= 128 || *inside >= DEEP) {
            (*pixel, *label) = (*foliage, *foliage_label);
        } else if foliage.alpha() >= 128 && pixel.alpha() > 0 {
            let [r, g, b, _] = foliage.0;
            *pixel = Straight([r, g, b, pixel.alpha()]);
        }
    }
    Ok(result)
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

/// Where a cell takes its foliage from.
#[derive(Clone, Copy)]
struct Patch {
    to: [f64; 2],
    from: [f64; 2],
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
            is_mirrored: false,
            lift: 0.0,
        }
    }

    /// The best of many places for the cell, or its own.
    fn found(
        tree: &Tree,
        bounds: Rect,
        grid: &Grid,
        cell: usize,
        strength: f64,
        random: &mut Random,
    ) -> Self {
        let own = Self::own(grid.cells[cell]);
        // All draws are made whatever the strength, so that more strength only adds changes.
        if random.unit() >= strength {
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
        for _ in 0..TRIES {
            let [across, down, side] = [0; 3].map(|_| random.unit());
            let from = [
                f64::from(bounds.x) + across * f64::from(bounds.width),
                own.to[1] + REACH * (2.0 * down - 1.0) * f64::from(bounds.height),
            ];
            let apart = (from[0] - own.to[0]).hypot(from[1] - own.to[1]);
            if apart < 1.1 * grid.side {
                continue;
            }
            let patch = Self {
                from,
                is_mirrored: side < 0.5,
                ..own
            };
            if let Some((cost, lift)) = patch.cost(tree, &ring)
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
    fn cost(&self, tree: &Tree, ring: &[[f64; 2]]) -> Option<(f64, f32)> {
        let (mut own_light, mut other_light, mut lit) = (0.0f64, 0.0, 0.0f64);
        let (mut alpha, mut color) = (0.0, 0.0);
        for offset in ring {
            let (x, y) = (self.to[0] + offset[0], self.to[1] + offset[1]);
            let (u, v) = self.source(x, y);
            let (x, y) = ((x + 0.5).floor() as i64, (y + 0.5).floor() as i64);
            let is_trunk = |x, y| tree.labels.get(x, y) == Some(Label::Trunk);
            if is_trunk(x, y) || is_trunk(u, v) {
                return None;
            }
            let at = |x, y| tree.image.get(x, y).unwrap_or(Straight([0; 4]));
            let (own, other) = (at(x, y), at(u, v));
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

fn light(pixel: Straight) -> f32 {
    let [r, g, b, _] = pixel.0.map(f32::from);
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// The picture and its labels with every cell from where its patch says.
fn composed(tree: &Tree, grid: &Grid, patches: &[Patch]) -> (Image<Straight>, Labels) {
    let (mut image, mut labels) = (tree.image.clone(), tree.labels.clone());
    let width = image.width() as usize;
    let side = grid.side as f32;
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
                    let other = tree.image.get(u, v).unwrap_or(Straight([0; 4]));
                    let other_label = tree.labels.get(u, v).unwrap_or_default();
                    if other_label == Label::Trunk {
                        continue;
                    }
                    let shown = f32::from(other.alpha()) / 255.0;
                    let front = shown * (0.25 + 0.75 * (light(other) + patch.lift) / 255.0);
                    let claim = OVERLAP * front - distance / side;
                    if claim > best.0 {
                        best = (claim, lifted(other, patch.lift), other_label);
                    }
                }
                (*pixel, *label) = (best.1, best.2);
            }
        });
    (image, labels)
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
            let steps =
                [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(|s| difference(&tree, &individual(&tree, s)));
            assert!(steps.is_sorted(), "{name}: {steps:?}");
            assert!(steps[5] > 4.0, "{name}: {steps:?}");
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
        let likeness = [0.3, 0.65, 1.0].map(|s| own.likeness(&look(&individual(&tree, s))).score());
        assert!(
            likeness[0] > likeness[2] && likeness[1] >= likeness[2],
            "{likeness:?}"
        );
        assert!(likeness[2] < 0.8, "{likeness:?}");
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
        // Within the crown the stem sways with its limbs; below it stays.
        let low = crown_baseline(&tree.labels).unwrap();
        for y in low..tree.image.height() {
            for x in 0..tree.image.width() {
                if tree.labels.at(x, y) == Label::Trunk {
                    assert_eq!(tree.image.at(x, y), other.image.at(x, y), "{x}, {y}");
                }
            }
        }
    }

    #[test]
    fn a_mirror_twice_is_the_tree() {
        let tree = sample("birch");
        assert_ne!(mirrored(&tree), tree);
        assert_eq!(mirrored(&mirrored(&tree)), tree);
    }
}
