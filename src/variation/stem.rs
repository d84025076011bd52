//! Other bark on a bare stem: that of other places of the same one.
//!
//! A row of trees gives itself away by one stem with the same stains. Bark has no upper and no lower end, so
//! it may be turned upside down, mirrored and moved along the stem; the stem's own silhouette and light at
//! foot and crown stay, where both fade into each other.
//!
//! Limits: a stem that forks below the crown keeps its bark.

use super::Tree;
use super::sway::between_pixels;
use crate::base::Random;
use crate::raster::Straight;
use crate::segment::{Label, crown_baseline};

/// Shortest stem that is worth it, and the stretch at both ends over which bark fades, in cell sizes.
const SHORTEST: f64 = 0.8;
const FADE: f64 = 0.35;

/// Least part of the width of a stem that is bark, percent: a stem that forks has less.
const WHOLE: usize = 80;

/// Rows over which the stem's middle and width are smoothed, in cell sizes.
const SMOOTHED: f64 = 0.25;

/// Gives the stem of `tree` other bark; `side` is the size of a cell, pixels. The same draws are made
/// whatever the strength.
pub(super) fn rebarked(tree: &mut Tree, side: f64, strength: f64, random: &mut Random) {
    let (turn, mirror, shift) = (random.unit(), random.unit(), random.unit());
    let Some(stem) = Rows::of(tree, side).filter(|_| turn < 2.0 * strength) else {
        return;
    };
    let count = stem.rows.len();
    let mirror = if mirror < 0.5 { -1.0 } else { 1.0 };
    let before = tree.image.clone();
    for (row, &[middle, half]) in stem.rows.iter().enumerate() {
        let y = stem.first + row as u32;
        // Upside down, moved, and back at either end.
        let moved = (count - 1 - row) as f64 + shift * 0.6 * count as f64;
        let last = (count - 1) as f64;
        let moved = if moved > last {
            2.0 * last - moved
        } else {
            moved
        };
        let [from_middle, from_half] = stem.rows[(moved.max(0.0) as usize).min(count - 1)];
        let from_y = f64::from(stem.first) + moved.max(0.0);
        let end = (row as f64).min(last - row as f64);
        let share = (end / (FADE * side)).clamp(0.0, 1.0) as f32;
        for x in 0..before.width() {
            if tree.labels.at(x, y) != Label::Trunk {
                continue;
            }
            let across = (f64::from(x) - middle) / half;
            let from_x = from_middle + mirror * across * from_half;
            let other = between_pixels(&before, from_x, from_y);
            let own = before.at(x, y);
            if other.alpha() >= 128 {
                let mixed = |c: usize| {
                    let (a, b) = (f32::from(own.0[c]), f32::from(other.0[c]));
                    (a + share * (b - a) + 0.5) as u8
                };
                let pixel = Straight([mixed(0), mixed(1), mixed(2), own.alpha()]);
                tree.image.set(x, y, pixel);
            }
        }
    }
}

/// Middle and half width of a bare stem, row by row from the crown down.
struct Rows {
    first: u32,
    rows: Vec<[f64; 2]>,
}

impl Rows {
    /// Those of `tree`; `None` when hardly any stem is bare, or it forks there: what one arm takes from the
    /// other's height may be the gap between them.
    fn of(tree: &Tree, side: f64) -> Option<Self> {
        let first = crown_baseline(&tree.labels)?;
        let mut is_one = true;
        let of_row = |y: u32| {
            let row = tree.labels.row(y);
            let left = row.iter().position(|label| *label == Label::Trunk)?;
            let right = row.iter().rposition(|label| *label == Label::Trunk)?;
            let bark = row[left..=right]
                .iter()
                .filter(|label| **label == Label::Trunk);
            is_one &= bark.count() >= WHOLE * (right - left + 1) / 100;
            Some([0.5 * (left + right) as f64, 0.5 * (right - left + 1) as f64])
        };
        let rows: Vec<[f64; 2]> = (first..tree.image.height()).map_while(of_row).collect();
        if (rows.len() as f64) < SHORTEST * side || !is_one {
            return None;
        }
        let reach = (SMOOTHED * side) as usize;
        let smooth = |at: usize| {
            let around = &rows[at.saturating_sub(reach)..(at + reach + 1).min(rows.len())];
            let mean = |of: usize| around.iter().map(|row| row[of]).sum::<f64>();
            [0, 1].map(|of| mean(of) / around.len() as f64)
        };
        Some(Self {
            first,
            rows: (0..rows.len()).map(smooth).collect(),
        })
    }
}
