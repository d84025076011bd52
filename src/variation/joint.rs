//! What is seen behind a palm's fronds once they stand elsewhere: its stems, and what goes on above them.
//!
//! Above the stem whose top is the heart that is the crown as it was: stalks that stay. Another palm's stem, whose
//! fronds turn about a heart that is not its own, is drawn on in the direction it has, with the bark that it has.
//!
//! Limits: how far that stem goes is not known; it ends behind fronds or not at all far from them.

use super::Tree;
use super::stem::{Stretch, stretches};
use super::sway::between_pixels;
use crate::raster::{Image, Mask, Straight, dilated};
use crate::segment::Label;

/// Width of a stem's soft edges, as a share of the picture's side.
const SOFT_EDGE: f64 = 0.006;

/// How far a stem goes on above its label behind the fronds, as a share of the picture's side: fronds that hid it
/// may stand elsewhere.
const REACH: f64 = 0.1;

/// Length of the stem's end that tells where it goes, and the part of that which fronds may half hide, likewise.
const END: f64 = 0.08;
const HIDDEN: f64 = 0.03;

/// How far another's stem is drawn on, likewise, and how much narrower and darker it becomes on its way: an end that
/// no frond hides is a thin one.
const DRAWN: f64 = 0.05;
const NARROWER: f64 = 0.6;
const DARKER: f32 = 0.8;

/// What lies behind the fronds of a palm.
pub(super) struct Behind {
    /// Stems, and what goes on above them.
    pub(super) image: Image<Straight>,
    /// The stem with its soft edges, as it was.
    pub(super) stem: Mask,
    /// Where stems are now, seen or not.
    pub(super) is_stem: Mask,
    /// The ends of stems that are not the heart's, pixels.
    pub(super) others: Vec<[f64; 2]>,
}

impl Behind {
    /// What lies behind the fronds of `tree`, whose heart is in that row.
    pub(super) fn of(tree: &Tree, heart: f64) -> Self {
        let stem = stem(tree);
        let mut joint = joint(tree);
        let side = f64::from(tree.image.width());
        let ends = stretches(&tree.labels, 0, END * side);
        let is_other = |stretch: &&Stretch| {
            let hangs = f64::from(stretch.first) > heart + HIDDEN * side;
            hangs && stretch.goes_on_above(&tree.labels)
        };
        let mut image = tree.image.map(|_| Straight([0; 4]));
        let mut others = Vec::new();
        for stretch in ends.iter().filter(is_other) {
            let [left, right] = stretch.ends[0];
            for y in 0..stretch.first {
                (left..=right).for_each(|x| joint.set(x, y, false));
            }
            stretch.draw_on(&mut image, tree);
            others.push([0.5 * f64::from(left + right), f64::from(stretch.first)]);
        }
        let mut is_stem = image.map(|pixel| pixel.alpha() >= 96);
        let shown = stem.pixels().iter().zip(joint.pixels());
        let own = tree.image.pixels().iter().zip(tree.labels.pixels());
        let all = image.pixels_mut().iter_mut().zip(is_stem.pixels_mut());
        for ((pixel, is_stem), ((stem, joint), (own, label))) in all.zip(shown.zip(own)) {
            if *stem || *joint {
                *pixel = own.over(*pixel);
            }
            *is_stem |= *joint || *label == Label::Trunk;
        }
        Self {
            image,
            stem,
            is_stem,
            others,
        }
    }
}

impl Stretch {
    /// Whether fronds hide where it goes on: a fork does not.
    fn goes_on_above(&self, labels: &Image<Label>) -> bool {
        let [left, right] = self.ends[0];
        let above = i64::from(self.first) - 1;
        let row = (left..=right).filter_map(|x| labels.get(i64::from(x), above));
        let row: Vec<Label> = row.collect();
        row.contains(&Label::Crown) && !row.contains(&Label::Trunk)
    }

    /// Draws it on above its end.
    fn draw_on(&self, image: &mut Image<Straight>, tree: &Tree) {
        let side = f64::from(image.width());
        let [hidden, end] = [HIDDEN, END].map(|share| (share * side) as usize);
        let rows = self.rows(hidden / 2);
        let (from, last) = (hidden.min(rows.len() - 2), end.min(rows.len() - 1));
        let [middle, half] = rows[from];
        let slope = (middle - rows[last][0]) / (last - from).max(1) as f64;
        let count = from + (DRAWN * side) as usize;
        for above in 0..count.min(self.first as usize) {
            let y = (self.first as usize + from - above) as u32;
            let share = above as f64 / count as f64;
            let half_here = half * (1.0 - NARROWER * share);
            let middle_here = middle + slope * above as f64;
            // Bark has no upper and no lower end: back and forth along what is seen.
            let period = 2 * (last - from).max(1);
            let row = above % period;
            let row = from + row.min(period - row);
            let [from_middle, from_half] = rows[row];
            let first = (middle_here - half_here - 1.0).max(0.0) as u32;
            let end = (middle_here + half_here + 2.0).clamp(0.0, side) as u32;
            for x in first..end {
                let across = (f64::from(x) - middle_here) / half_here;
                let edge = (half_here * (1.0 - across.abs()) + 0.5).clamp(0.0, 1.0);
                let from_x = from_middle + across.clamp(-0.9, 0.9) * from_half;
                let bark = between_pixels(&tree.image, from_x, f64::from(self.first) + row as f64);
                if bark.alpha() >= 128 && edge > 0.0 {
                    let dark = 1.0 - (1.0 - DARKER) * share as f32;
                    let [r, g, b, _] = bark.0.map(|value| (f32::from(value) * dark + 0.5) as u8);
                    let alpha = (255.0 * edge + 0.5) as u8;
                    image.set(x, y, Straight([r, g, b, alpha]));
                }
            }
        }
    }
}

/// The stem with its soft edges.
fn stem(tree: &Tree) -> Mask {
    let edge = (SOFT_EDGE * f64::from(tree.image.width())).ceil().min(60.0) as u8;
    let mut stem = dilated(&tree.labels.map(|label| *label == Label::Trunk), edge);
    for (is_stem, label) in stem.pixels_mut().iter_mut().zip(tree.labels.pixels()) {
        *is_stem &= *label != Label::Crown;
    }
    stem
}

/// What shows of the crown straight above stems, where they go on.
fn joint(tree: &Tree) -> Mask {
    let (width, height) = (tree.labels.width(), tree.labels.height());
    let reach = (REACH * f64::from(width)).ceil() as u32;
    let mut joint = tree.labels.map(|_| false);
    for x in 0..width {
        let mut above = None;
        for y in (0..height).rev() {
            match tree.labels.at(x, y) {
                Label::Trunk => above = Some(y),
                Label::Crown => joint.set(x, y, above.is_some_and(|stem| stem - y <= reach)),
                Label::Background => above = None,
            }
        }
    }
    joint
}
