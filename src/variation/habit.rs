//! How a crown stands about its axis: how wide it is at each height, and whether it is a spire.
//!
//! Spruces and firs grow round one straight stem: they narrow to a point, their boughs lie in tiers, one
//! side is much like the other. Poplars and cypresses keep the stem and are columns. Round crowns have
//! none of that: what makes them vary would make a spire blunt and crooked.

use crate::raster::{Mask, opaque_bounds, row_ends};
use crate::segment::{Label, Labels, crown_baseline};

use super::Tree;

/// Mean width of a crown's upper quarter, as a share of its largest, up to which it is a spire and from
/// which it is not. Of the 39 real trees conifers have 0.09 to 0.32, round crowns 0.39 and more.
const POINTED: [f64; 2] = [0.32, 0.38];

/// Height by width of a crown below which one is no spire, though a twig stands out of its top, and from which
/// it may be. Real conifers have 1.07 and more.
const UPRIGHT: [f64; 2] = [0.92, 1.04];

/// Height by width of a crown from which it begins to be a column, and is one.
const SLENDER: [f64; 2] = [2.6, 3.4];

/// Rows over which widths are averaged, as a share of the crown's height: tiers are no narrowing.
const SMOOTHED: f64 = 0.06;

/// A crown about its axis, pixels.
#[derive(Debug, Clone)]
pub(super) struct Habit {
    top: f64,
    /// x of the axis in the top row, and how far it moves with each row.
    apex: f64,
    slope: f64,
    /// Half the width of the crown, row by row from the top.
    half: Vec<f64>,
    /// The largest of those.
    widest: f64,
    straight: f64,
}

impl Habit {
    /// That of `tree`; `None` when no crown shows.
    pub(super) fn of(tree: &Tree) -> Option<Self> {
        Self::seen(&tree.image.map(|pixel| pixel.alpha() >= 96), &tree.labels)
    }

    /// That of the tree which is opaque where `seen` says so; `None` when no crown shows.
    pub(super) fn seen(seen: &Mask, labels: &Labels) -> Option<Self> {
        let mut crown = seen.clone();
        for (is_crown, label) in crown.pixels_mut().iter_mut().zip(labels.pixels()) {
            *is_crown &= *label == Label::Crown;
        }
        let bounds = opaque_bounds(&crown)?;
        let ends = |y: u32| {
            let ends = row_ends(crown.row(y), |&is| is)?;
            Some(ends.map(|x| x as f64))
        };
        let rows: Vec<Option<[f64; 2]>> = (bounds.y..bounds.y + bounds.height).map(ends).collect();
        let width = |ends: &Option<[f64; 2]>| ends.map_or(0.0, |[left, right]| right - left + 1.0);
        let widths: Vec<f64> = rows.iter().map(width).collect();
        let half: Vec<f64> = smoothed(&widths).into_iter().map(|w| 0.5 * w).collect();
        let widest = 2.0 * half.iter().copied().fold(0.5, f64::max);
        let quarter = &widths[..widths.len().div_ceil(4)];
        let upper = quarter.iter().sum::<f64>() / quarter.len() as f64 / widest;
        let aspect = widths.len() as f64 / widest;
        let pointed = ramp(aspect, UPRIGHT) * (1.0 - ramp(upper, POINTED));
        let slender = ramp(aspect, SLENDER);
        let top = f64::from(bounds.y);
        let (apex, foot) = (apex(&rows)?, foot(labels, top, &rows));
        let below = (foot[1] - top).max(1.0);
        Some(Self {
            top,
            apex,
            slope: (foot[0] - apex) / below,
            half,
            widest: 0.5 * widest,
            straight: pointed.max(slender),
        })
    }

    /// Whether the crown stands about one straight stem: 0 not at all, 1 a spire or a column.
    pub(super) fn straight(&self) -> f64 {
        self.straight
    }

    /// Whether it is more of that than not.
    pub(super) fn is_straight(&self) -> bool {
        self.straight >= 0.5
    }

    /// x of the axis at height `y`.
    pub(super) fn axis(&self, y: f64) -> f64 {
        self.apex + self.slope * (y - self.top)
    }

    /// Half the width of the crown at height `y`: above it that of its top, below that of its lower end.
    pub(super) fn half(&self, y: f64) -> f64 {
        let row = (y - self.top).clamp(0.0, self.half.len() as f64 - 1.0);
        self.half[row as usize]
    }

    /// How far down the crown height `y` is: 0 its top, 1 its lower end.
    pub(super) fn share(&self, y: f64) -> f64 {
        ((y - self.top) / self.half.len() as f64).clamp(0.0, 1.0)
    }

    /// The place on the ellipse about the crown that is seen from its middle in the direction of a place; about the
    /// middle itself less far out, so that it changes smoothly.
    pub(super) fn on_outline(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        /// As a share of the way out.
        const MIDDLE: f64 = 0.3;
        let radii = [self.widest, 0.5 * self.height()];
        let middle_y = self.top + radii[1];
        let middle = [self.axis(middle_y), middle_y];
        let [u, v] = [0, 1].map(|of| ([x, y][of] - middle[of]) / radii[of].max(1.0));
        let out = (u * u + v * v).sqrt().max(MIDDLE);
        [
            middle[0] + radii[0] * u / out,
            middle[1] + radii[1] * v / out,
        ]
    }

    /// Of the crown, pixels.
    pub(super) fn height(&self) -> f64 {
        self.half.len() as f64
    }

    /// The row of the crown's topmost pixel.
    pub(super) fn top(&self) -> f64 {
        self.top
    }
}

/// Whether the crown of `tree` stands about one straight stem, as those of spruces and poplars do.
pub fn stands_straight(tree: &Tree) -> bool {
    Habit::of(tree).is_some_and(|habit| habit.is_straight())
}

/// Means over [`SMOOTHED`] of all rows around each; at the ends of fewer, so that a tip stays one.
fn smoothed(widths: &[f64]) -> Vec<f64> {
    let reach = (0.5 * SMOOTHED * widths.len() as f64) as usize;
    let mean = |at: usize| {
        let reach = reach.min(at).min(widths.len() - 1 - at);
        let around = &widths[at - reach..=at + reach];
        around.iter().sum::<f64>() / around.len() as f64
    };
    (0..widths.len()).map(mean).collect()
}

/// Where the tip is: the middle of the topmost rows.
fn apex(rows: &[Option<[f64; 2]>]) -> Option<f64> {
    let tip = rows.iter().take((rows.len() / 40).max(1)).flatten();
    let middles: Vec<f64> = tip.map(|[left, right]| 0.5 * (left + right)).collect();
    (!middles.is_empty()).then(|| middles.iter().sum::<f64>() / middles.len() as f64)
}

/// Where the stem stands; without one the middle of the crown's lower half.
fn foot(labels: &Labels, top: f64, rows: &[Option<[f64; 2]>]) -> [f64; 2] {
    let bare = crown_baseline(labels).unwrap_or(0);
    let trunk = labels.pixels().iter().enumerate();
    let trunk = trunk.filter(|(_, label)| **label == Label::Trunk);
    let width = labels.width() as usize;
    let places = trunk.map(|(i, _)| [(i % width) as f64, (i / width) as f64]);
    let places: Vec<[f64; 2]> = places.filter(|place| place[1] > f64::from(bare)).collect();
    if !places.is_empty() {
        let mean = |axis: usize| places.iter().map(|p| p[axis]).sum::<f64>() / places.len() as f64;
        return [mean(0), mean(1)];
    }
    let lower = rows[rows.len() / 2..].iter().flatten();
    let middles: Vec<f64> = lower.map(|[left, right]| 0.5 * (left + right)).collect();
    let x = middles.iter().sum::<f64>() / middles.len().max(1) as f64;
    [x, top + 0.75 * rows.len() as f64]
}

/// 0 up to the first of `ends`, 1 from the second on, straight between.
fn ramp(value: f64, [low, high]: [f64; 2]) -> f64 {
    ((value - low) / (high - low)).clamp(0.0, 1.0)
}
