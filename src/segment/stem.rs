//! Following a trunk from the ground upwards.

use super::colour::Likelihood;
use super::sketch::{Sketch, Span};

/// A run this many times wider than the stem so far is no longer stem alone: crown touches it.
const JUMP: f64 = 1.9;
/// A side of a fork this part of the stem's width is a limb, a thinner one a twig.
const LIMB: f64 = 0.35;
/// How far, in stem widths, the expected width lags behind the measured one.
const LAG: f64 = 0.5;
/// How far, in stem widths, bark is followed between foliage that touches it.
const REACH: f64 = 1.5;
/// Slack per row of each side of a stem inside foliage, pixels.
const SLACK: u32 = 1;

/// A trunk: its spans, from the foot upwards; forks follow one another.
#[derive(Default)]
pub(super) struct Stem {
    pub(super) spans: Vec<Span>,
}

impl Stem {
    pub(super) fn area(&self) -> u32 {
        self.spans.iter().map(|s| s.width()).sum()
    }

    pub(super) fn top(&self) -> u32 {
        self.spans.iter().map(|s| s.y).min().unwrap_or(0)
    }
}

#[derive(Clone, Copy)]
struct Tip {
    span: Span,
    width: f64,
    covered: u32,
}

/// How to follow.
#[derive(Clone, Copy)]
pub(super) struct Follow<'a> {
    pub(super) bark: Option<&'a Likelihood>,
    pub(super) forks: bool,
}

pub(super) fn followed(sketch: &Sketch, foot: Span, follow: Follow) -> Stem {
    let mut stem = Stem::default();
    let mut tips = vec![Tip {
        span: foot,
        width: f64::from(foot.width()),
        covered: 0,
    }];
    while let Some(tip) = tips.pop() {
        stem.spans.push(tip.span);
        tips.extend(next(sketch, tip, follow));
    }
    stem
}

fn next(sketch: &Sketch, tip: Tip, follow: Follow) -> Vec<Tip> {
    let Some(y) = tip.span.y.checked_sub(1) else {
        return Vec::new();
    };
    let runs = &sketch.runs[y as usize];
    let above: Vec<Span> = runs.iter().copied().filter(|r| r.meets(tip.span)).collect();
    let limbs = above
        .iter()
        .filter(|r| f64::from(r.width()) >= LIMB * tip.width)
        .count();
    if limbs > 1 && !follow.forks {
        return Vec::new();
    }
    above
        .into_iter()
        .filter(|r| f64::from(r.width()) >= LIMB * tip.width)
        .filter_map(|run| {
            let narrow = f64::from(run.width()) <= JUMP * tip.width;
            if narrow {
                let measured = f64::from(run.width());
                let width = if limbs > 1 {
                    measured
                } else {
                    tip.width + (measured - tip.width) * (1.0 / (LAG * tip.width)).min(1.0)
                };
                return Some(Tip {
                    span: run,
                    width,
                    covered: 0,
                });
            }
            let bark = follow.bark?;
            if f64::from(tip.covered) >= REACH * tip.width {
                return None;
            }
            let span = bark_span(sketch, tip, run, bark)?;
            Some(Tip {
                span,
                width: tip.width,
                covered: tip.covered + 1,
            })
        })
        .collect()
}

fn bark_span(sketch: &Sketch, tip: Tip, run: Span, bark: &Likelihood) -> Option<Span> {
    let left = tip.span.left.saturating_sub(SLACK).max(run.left);
    let right = (tip.span.right + SLACK).min(run.right);
    let y = run.y;
    let row = sketch.image.row(y);
    // longest stretch of positive smoothed ratio = maximum sum
    let mut best = (0.0f32, 0, 0);
    let (mut sum, mut start) = (0.0f32, left);
    for x in left..right {
        sum += bark.of(row[x as usize]).clamp(-2.0, 2.0);
        if sum <= 0.0 {
            sum = 0.0;
            start = x + 1;
        } else if sum > best.0 {
            best = (sum, start, x + 1);
        }
    }
    let span = Span {
        y,
        left: best.1,
        right: best.2,
    };
    (best.0 > 0.0 && f64::from(span.right - span.left) >= 0.5 * tip.width).then_some(span)
}
