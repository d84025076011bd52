//! The strongest peak of the normalised cross-correlation of two trees, over shifts, small scales
//! and mirrored too.
//!
//! First on small views over all shifts, then on fine ones around the best few places. Correlation
//! is not normalised by overlap: what does not overlap counts as unlike.

use super::view::{TREE_PX, View};
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Premultiplied};

/// Scales that are tried: an eye sees through a fifth more or less; each step is 9 %.
const SCALES: [f64; 5] = [0.84, 0.917, 1.0, 1.09, 1.19];

/// Longer side of a tree in a coarse view.
const COARSE_PX: u32 = TREE_PX / 2;

/// Largest shift in a coarse view, in pixels: an eighth of the tree.
const COARSE_SHIFT: i32 = 4;

/// Largest shift around a coarse peak in a fine view.
const FINE_SHIFT: i32 = 2;

/// Coarse peaks that are looked at finely.
const CANDIDATES: usize = 3;

/// A tree's views, ready to be compared.
#[derive(Debug, Clone)]
pub(super) struct Views {
    coarse: Scaled,
    fine: Scaled,
}

#[derive(Debug, Clone)]
struct Scaled {
    /// At scale 1, and mirrored.
    own: [View; 2],
    /// At each of [`SCALES`].
    scaled: Vec<View>,
}

/// Where two trees are most alike.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak {
    /// −1 to 1; 1 for a copy.
    pub(super) height: f64,
    /// Whether one of the two is mirrored.
    pub(super) is_mirrored: bool,
    /// How much larger the second has to be drawn.
    pub(super) scale: f64,
}

impl Views {
    pub(super) fn of(tree: &Image<Premultiplied>, cancel: &Cancel) -> Result<Self, Cancelled> {
        let scaled = |tree_px: u32| -> Result<Scaled, Cancelled> {
            let own = View::of(tree, tree_px, 1.0, cancel)?;
            let scaled = SCALES
                .iter()
                .map(|&scale| View::of(tree, tree_px, scale, cancel));
            Ok(Scaled {
                scaled: scaled.collect::<Result<_, _>>()?,
                own: [own.clone(), own.mirrored()],
            })
        };
        Ok(Self {
            coarse: scaled(COARSE_PX)?,
            fine: scaled(TREE_PX)?,
        })
    }
}

/// A place to look at more closely.
#[derive(Clone, Copy)]
struct Candidate {
    height: f64,
    mirror: usize,
    scale: usize,
    shift: [i32; 2],
}

/// The strongest peak of two trees.
pub(super) fn peak(a: &Views, b: &Views) -> Peak {
    let mut candidates = Vec::with_capacity(2 * SCALES.len());
    for mirror in 0..2 {
        for scale in 0..SCALES.len() {
            let (own, other) = (&a.coarse.own[mirror], &b.coarse.scaled[scale]);
            let best = strongest(own, other, [0, 0], COARSE_SHIFT);
            candidates.push(Candidate {
                height: best.0,
                mirror,
                scale,
                shift: best.1,
            });
        }
    }
    candidates.sort_by(|a, b| b.height.total_cmp(&a.height));
    let fine = candidates.iter().take(CANDIDATES).map(|candidate| {
        let own = &a.fine.own[candidate.mirror];
        let other = &b.fine.scaled[candidate.scale];
        let around = candidate.shift.map(|shift| 2 * shift);
        Peak {
            height: strongest(own, other, around, FINE_SHIFT).0,
            is_mirrored: candidate.mirror == 1,
            scale: SCALES[candidate.scale],
        }
    });
    fine.max_by(|a, b| a.height.total_cmp(&b.height))
        .unwrap_or_else(|| unreachable!("there are scales"))
}

/// The largest correlation of `a` with `b` moved by `around` and up to `reach` more, and that shift.
fn strongest(a: &View, b: &View, around: [i32; 2], reach: i32) -> (f64, [i32; 2]) {
    let mut best = (f64::NEG_INFINITY, around);
    for dy in around[1] - reach..=around[1] + reach {
        for dx in around[0] - reach..=around[0] + reach {
            let height = correlation(a, b, [dx, dy]);
            if height > best.0 {
                best = (height, [dx, dy]);
            }
        }
    }
    best
}

/// The mean over both channels of the correlation of `a` with `b` moved by `shift`.
fn correlation(a: &View, b: &View, [dx, dy]: [i32; 2]) -> f64 {
    let side = a.side as i32;
    let columns = (side - dx.abs()).max(0) as usize;
    let (from_a, from_b) = (dx.max(0) as usize, (-dx).max(0) as usize);
    let mut sum = 0.0;
    for y in dy.max(0)..(side + dy).min(side) {
        let (row_a, row_b) = (y as usize * a.side, (y - dy) as usize * a.side);
        for (a, b) in a.channels.iter().zip(&b.channels) {
            let a = &a[row_a + from_a..row_a + from_a + columns];
            let b = &b[row_b + from_b..row_b + from_b + columns];
            sum += f64::from(dot(a, b));
        }
    }
    0.5 * sum
}

/// Σ aᵢ·bᵢ in eight sums, which vector units like and which is the same everywhere.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    const LANES: usize = 8;
    let mut sums = [0.0f32; LANES];
    let (whole_a, whole_b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = whole_a.remainder().iter().zip(whole_b.remainder());
    let rest: f32 = rest.map(|(a, b)| a * b).sum();
    for (a, b) in whole_a.zip(whole_b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (b + f)) + ((c + g) + (d + h)) + rest
}
