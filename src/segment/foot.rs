//! Where trunks stand on the ground.

use super::colour::BarkLikelihood;
use super::sketch::{Sketch, Span};
use super::stem::{Guide, stem};

/// Part of the tree's height, from the ground, in which a foot is looked for.
///
/// Drooping branches reach below the foot by a few percent, the strands of a willow by 9 %. With
/// much more, the clear gap between two layers of branches would count as a trunk.
const BAND: f64 = 0.1;

/// Widest foot, as part of the tree's width. The stout palm has 0.14; at 0.3 the lowest layer of a
/// spruce's branches is a candidate.
const WIDEST: f64 = 0.18;

/// Narrowest foot, as part of the tree's longest side. The thinnest trunk has 0.018; what is much
/// narrower is a blade of grass or a hanging leaf.
const NARROWEST: f64 = 0.015;

/// How far from the crown's middle, as part of the tree's width, a foot counts half.
///
/// Most trunks stand within 0.1. Smaller, and leaning trees are lost; larger, and a branch that
/// touches the ground competes with the trunk.
const ASIDE: f64 = 0.2;

/// Number of feet that are looked at closely: learning the colours costs a pass over the sketch.
const CLOSE_LOOKS: usize = 4;

/// A foot this many times wider than what it stands on is a branch.
const STEP: f64 = 1.3;

/// Least score of a trunk, in units of the longest side to the power 1.5.
///
/// In our pictures lobes of foliage reach 0.0016 and the worst trunk that was found rightly has
/// 0.0028. Lower, and such lobes become trunks; higher, and the short stubs of trunks under
/// conifers become crown.
const LEAST_SCORE: f64 = 0.002;

/// A further foot of this part of the best one's score is a trunk too.
///
/// Only two photographs bear on it: the second stem of a group of trees has between 0.4 and 0.5,
/// a hanging branch beside a trunk between 0.3 and 0.4. Forked trunks with one foot do not need it.
const FURTHER: f64 = 0.4;

/// A place where a trunk stands.
pub(super) struct Foot {
    /// A run of the trunk near the ground.
    pub(super) span: Span,
    /// What the colours of its stem tell.
    pub(super) bark: BarkLikelihood,
    score: f64,
}

/// The feet of all trunks, the surest first; none when nothing looks like a trunk.
pub(super) fn feet(sketch: &Sketch) -> Vec<Foot> {
    let mut feet: Vec<Foot> = candidates(sketch)
        .into_iter()
        .take(CLOSE_LOOKS)
        .map(|(shape_score, span)| {
            let bark = likelihood(sketch, &stem(sketch, span, Guide::Width));
            // Other colours than the crown's count up to six times as much as the same ones.
            let score = shape_score * (1.2 - bark.overlap());
            Foot { span, bark, score }
        })
        .collect();
    feet.sort_by(|a, b| b.score.total_cmp(&a.score));
    let longest = f64::from(sketch.width().max(sketch.height()));
    let best = feet.first().map_or(0.0, |foot| foot.score);
    let enough = (LEAST_SCORE * longest * longest.sqrt()).max(FURTHER * best);
    feet.retain(|foot| foot.score >= enough);
    feet
}

/// Runs near the ground that may be feet and how much their shape speaks for it, best first; no
/// two share a column.
fn candidates(sketch: &Sketch) -> Vec<(f64, Span)> {
    let top = sketch.height() - 1 - (BAND * f64::from(sketch.height())) as u32;
    let near_ground = sketch.runs[top as usize..].iter().rev().flatten();
    let middle = middle_column(sketch);
    let mut found: Vec<(f64, Span)> = near_ground
        .filter(|&&run| may_be_foot(sketch, run))
        .map(|&run| (shape_score(sketch, run, middle), run))
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut apart: Vec<(f64, Span)> = Vec::new();
    for (score, run) in found {
        if !apart.iter().any(|(_, other)| other.meets(run)) {
            apart.push((score, run));
        }
    }
    apart
}

fn may_be_foot(sketch: &Sketch, run: Span) -> bool {
    let longest = f64::from(sketch.width().max(sketch.height()));
    let widths = NARROWEST * longest..=WIDEST * f64::from(sketch.width());
    widths.contains(&f64::from(run.width())) && !stands_on_thinner(sketch, run)
}

/// Whether the run is a branch: between half its width and its whole width further down there is
/// a thinner trunk.
///
/// Nearer to the run, the rounded lower end of a cut-out trunk would look like that too.
fn stands_on_thinner(sketch: &Sketch, run: Span) -> bool {
    let rows = run.y + run.width() / 2..=run.y + run.width();
    rows.filter_map(|y| sketch.runs.get(y as usize))
        .any(|below| {
            let under = below.iter().filter(|other| other.meets(run));
            let width: u32 = under.map(|other| other.width()).sum();
            width > 0 && f64::from(width) * STEP < f64::from(run.width())
        })
}

/// High, stout and under the middle of the crown, in pixels to the power 1.5.
fn shape_score(sketch: &Sketch, run: Span, middle: f64) -> f64 {
    let spans = stem(sketch, run, Guide::Width);
    let top = spans.iter().map(|span| span.y).min().unwrap_or(run.y);
    let aside = (run.centre() - middle) / (ASIDE * f64::from(sketch.width()));
    f64::from(run.y - top + 1) * f64::from(run.width()).sqrt() / (1.0 + aside * aside)
}

/// The mean column of the tree's pixels.
fn middle_column(sketch: &Sketch) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for run in sketch.runs.iter().flatten() {
        sum += run.centre() * f64::from(run.width());
        count += f64::from(run.width());
    }
    sum / count
}

fn likelihood(sketch: &Sketch, stem: &[Span]) -> BarkLikelihood {
    let in_stem = sketch.covered(stem);
    let opaque = || {
        let pixels = sketch.image.pixels().iter().zip(in_stem.pixels());
        let inside = pixels.zip(sketch.mask.pixels()).filter(|&(_, &m)| m);
        inside.map(|((&pixel, &in_stem), _)| (pixel, in_stem))
    };
    BarkLikelihood::learned(
        opaque().filter(|p| p.1).map(|p| p.0),
        opaque().filter(|p| !p.1).map(|p| p.0),
    )
}

/// What is below `foot` and hangs together with it: flaring roots and the rest of the trunk.
///
/// Runs more than three times as wide are not roots but a strip of ground.
pub(super) fn roots(sketch: &Sketch, foot: Span) -> Vec<Span> {
    let mut roots = Vec::new();
    let mut last = vec![foot];
    for runs in &sketch.runs[foot.y as usize + 1..] {
        let connected = |run: &&Span| last.iter().any(|above| above.meets(**run));
        let here: Vec<Span> = runs
            .iter()
            .filter(connected)
            .filter(|run| run.width() < 3 * foot.width())
            .copied()
            .collect();
        roots.extend_from_slice(&here);
        last = here;
    }
    roots
}
