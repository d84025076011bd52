//! Following a trunk from the ground upwards.
//!
//! A trunk is what stands on the ground, is narrow, and keeps its width: from a run of opaque
//! pixels at the foot we step to the runs above it, row by row. Where the run gets suddenly wider,
//! crown has joined it; where it splits, the sides are limbs or twigs. With a colour model the
//! stem is also followed a little way between foliage that touches it from the sides.
//!
//! Limits: a trunk that grows wider steadily (a cone standing on its tip) is followed to its top;
//! one that leans more than its own width per row is lost, as is one behind a hanging branch.

use super::colour::BarkLikelihood;
use super::sketch::{Sketch, Span};

/// A run this many times wider than the stem so far is no longer stem alone: crown touches it.
///
/// From 1.2 to 1.3 nothing changes on our pictures; from 1.4 on the lowest branches of dense
/// spruces are taken for trunk (the mean overlap with the hand labels falls from 0.87 to 0.81).
/// Near 1, the ragged edge of a trunk would end it.
const JUMP: f64 = 1.3;

/// A side of a fork of this part of the stem's width is a limb, a thinner one a twig.
///
/// Anything from 0.2 to 0.3 gives the same on our pictures; from 0.4 on, limbs of forked trees are
/// lost; at 0 every twig in the clear would be trunk.
const LIMB: f64 = 0.25;

/// Over how much height, in stem widths, the expected width follows the measured one.
///
/// With 0.3, a crown that widens gently is followed as if it were a trunk; far above 1, the foot
/// of a buttressed trunk decides how wide its top may be.
const LAG: f64 = 1.0;

/// How far, in stem widths, bark is followed between foliage that touches it.
///
/// 0 ends the trunk at the first leaf beside it (the overlap falls by 0.02 on billboards, by 0.09
/// on photographs); far above 2, the stem seen between the branches of a conifer becomes trunk,
/// which the labels call crown.
const REACH: f64 = 2.0;

/// By how much bark between foliage may grow to each side, pixels per row: limbs leaning by 45°.
const SLACK: u32 = 1;

/// Part of the stem's width that must look like bark between foliage; less is a glimpse.
const GLIMPSE: f64 = 0.5;

/// How far one pixel counts for or against bark, in natural logarithms.
///
/// Foliage and bark are both speckled; without a bound a single black pixel would decide a row.
const VOICE: f32 = 2.0;

/// What the stem is followed by.
#[derive(Clone, Copy)]
pub(super) enum Guide<'a> {
    /// Width alone; forks are followed. For a first look, from which colours are learned.
    Width,
    /// Width, and colour where foliage touches the stem; forks are followed.
    Bark(&'a BarkLikelihood),
    /// Width alone; the first fork ends the stem, because the picture shows a tree whose crown is
    /// branches of the same colour.
    Bare,
}

impl Guide<'_> {
    fn allows_forks(self) -> bool {
        !matches!(self, Self::Bare)
    }
}

/// The upper end of a stem that is still followed.
#[derive(Clone, Copy)]
struct Tip {
    span: Span,
    /// The expected width, pixels.
    width: f64,
    /// Number of rows since foliage began to touch the stem.
    covered: u32,
}

/// The spans of the stem that begins with `foot`, from the foot upwards.
pub(super) fn stem(sketch: &Sketch, foot: Span, guide: Guide) -> Vec<Span> {
    let mut spans = Vec::new();
    let mut tips = vec![Tip {
        span: foot,
        width: f64::from(foot.width()),
        covered: 0,
    }];
    while !tips.is_empty() {
        spans.extend(tips.iter().map(|tip| tip.span));
        let above = tips.iter().flat_map(|&tip| tips_above(sketch, tip, guide));
        tips = joined(above.collect());
    }
    spans
}

fn tips_above(sketch: &Sketch, tip: Tip, guide: Guide) -> Vec<Tip> {
    let Some(y) = tip.span.y.checked_sub(1) else {
        return Vec::new();
    };
    let is_limb = |run: &&Span| run.meets(tip.span) && f64::from(run.width()) >= LIMB * tip.width;
    let limbs: Vec<Span> = sketch.runs[y as usize]
        .iter()
        .filter(is_limb)
        .copied()
        .collect();
    let forked = limbs.len() > 1;
    if forked && !guide.allows_forks() {
        return Vec::new();
    }
    limbs
        .into_iter()
        .filter_map(|run| {
            if f64::from(run.width()) <= JUMP * tip.width {
                Some(tip_in_the_clear(tip, run, forked))
            } else {
                tip_in_foliage(sketch, tip, run, guide)
            }
        })
        .collect()
}

fn tip_in_the_clear(tip: Tip, run: Span, forked: bool) -> Tip {
    let measured = f64::from(run.width());
    let share = (1.0 / (LAG * tip.width)).min(1.0);
    Tip {
        span: run,
        width: if forked {
            measured
        } else {
            tip.width + (measured - tip.width) * share
        },
        covered: 0,
    }
}

fn tip_in_foliage(sketch: &Sketch, tip: Tip, run: Span, guide: Guide) -> Option<Tip> {
    let Guide::Bark(bark) = guide else {
        return None;
    };
    let within_reach = f64::from(tip.covered) < REACH * tip.width;
    let span = bark_span(sketch, tip.span, run, bark).filter(|_| within_reach)?;
    (f64::from(span.width()) >= GLIMPSE * tip.width).then_some(Tip {
        span,
        width: tip.width,
        covered: tip.covered + 1,
    })
}

/// The stretch of `run`, above `below`, that most looks like bark: the one of the largest sum of
/// log ratios (Bentley 1984, *Programming pearls: algorithm design techniques*).
fn bark_span(sketch: &Sketch, below: Span, run: Span, bark: &BarkLikelihood) -> Option<Span> {
    let left = below.left.saturating_sub(SLACK).max(run.left);
    let right = (below.right + SLACK).min(run.right);
    let (mut best, mut best_sum) = (None, 0.0);
    let (mut start, mut sum) = (left, 0.0);
    for x in left..right {
        sum += ratio_at(sketch, x, run.y, bark);
        if sum <= 0.0 {
            (start, sum) = (x + 1, 0.0);
        } else if sum > best_sum {
            best_sum = sum;
            best = Some(Span {
                y: run.y,
                left: start,
                right: x + 1,
            });
        }
    }
    best
}

/// The mean bounded log ratio of the pixel and its two vertical neighbours: bark runs upwards.
fn ratio_at(sketch: &Sketch, x: u32, y: u32, bark: &BarkLikelihood) -> f32 {
    let last = sketch.height() - 1;
    let rows = [y.saturating_sub(1), y, (y + 1).min(last)];
    let voices = rows.map(|y| bark.of(sketch.image.at(x, y)).clamp(-VOICE, VOICE));
    voices.iter().sum::<f32>() / 3.0
}

/// The tips of one row with those that share columns made one, so that limbs which cross do not
/// multiply.
fn joined(mut tips: Vec<Tip>) -> Vec<Tip> {
    tips.sort_by_key(|tip| (tip.span.left, tip.span.right));
    tips.dedup_by(|next, kept| {
        let shared = next.span.left < kept.span.right;
        if shared {
            kept.span.right = kept.span.right.max(next.span.right);
            kept.width = kept.width.max(next.width);
            kept.covered = kept.covered.min(next.covered);
        }
        shared
    });
    tips
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Image, Straight};

    fn sketch(rows: &[&str]) -> Sketch {
        let pixels = rows.iter().flat_map(|row| row.bytes());
        let pixels = pixels.map(|b| Straight([90, 60, 30, if b == b'#' { 255 } else { 0 }]));
        let width = rows[0].len() as u32;
        Sketch::of(&Image::from_pixels(
            width,
            rows.len() as u32,
            pixels.collect(),
        ))
        .unwrap()
    }

    #[test]
    fn a_stem_ends_where_the_run_jumps() {
        let sketch = sketch(&["#######", "#######", "..###..", "..###..", "..###.."]);
        let spans = stem(&sketch, sketch.runs[4][0], Guide::Width);
        assert_eq!(spans.iter().map(|s| s.y).collect::<Vec<_>>(), [4, 3, 2]);
    }

    #[test]
    fn forks_are_followed_unless_the_tree_is_bare() {
        let sketch = sketch(&["##...##", "##...##", ".##.##.", "..###..", "..###.."]);
        let foot = sketch.runs[4][0];
        assert_eq!(stem(&sketch, foot, Guide::Width).len(), 8);
        assert_eq!(stem(&sketch, foot, Guide::Bare).len(), 2);
    }

    #[test]
    fn limbs_that_cross_do_not_multiply() {
        let lattice: Vec<&str> = ["##.##", ".###."].into_iter().cycle().take(200).collect();
        let sketch = sketch(&lattice);
        let spans = stem(&sketch, sketch.runs[199][0], Guide::Width);
        assert!(spans.len() <= 300);
    }
}
