//! Limbs grown into the outline of a crown that is to be bare.
//!
//! They grow by space colonisation ([`crate::branches::skeleton`]) towards points in the crown, which is taken to be
//! as deep as it is wide. The trunk that the picture shows goes on as their stem: from where it goes up into the
//! crown, as thick as it is there and in its direction.
//!
//! Limits: of several trunks the thickest goes on.

use super::leaves::Leaves;
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::branches::skeleton::{Reach, Skeleton, colonise};
use crate::raster::{Rect, row_ends};
use crate::segment::Label;
use crate::variation::Tree;
use glam::{Vec2, Vec3};

/// Height of a crown in metres: only proportions count.
pub(super) const CROWN_M: f32 = 10.0;

/// Points that want a twig.
const POINTS: usize = 1700;

/// Length of a step of growth.
const STEP_M: f32 = 0.2;

/// A trunk goes up to where it is this share of as wide as it is for most of its length.
const AS_WIDE: f32 = 0.8;

/// How many times its width below that limbs' stem begins, behind it.
const OVERLAP: f32 = 1.5;

/// What a stem keeps of its lean from step to step.
const LEAN_KEPT: f32 = 0.93;

/// Where limbs begin.
pub(super) struct Stem {
    /// Pixels of a metre.
    pub(super) scale: f32,
    /// The place in the picture where it begins, behind the trunk.
    pub(super) foot: Vec2,
    /// Where it comes out of the trunk, in metres from the foot.
    neck: Vec2,
    /// Of the stem there.
    pub(super) radius_m: f32,
    /// The lowest limb, in metres above the foot.
    bare_m: f32,
    /// How far above the neck the stem goes straight on, in metres.
    leader_m: f32,
}

impl Stem {
    pub(super) fn of(tree: &Tree, leaves: &Leaves) -> Self {
        let bounds = leaves.bounds;
        let scale = bounds.height as f32 / CROWN_M;
        let trunk = trunk(tree, bounds);
        let neck = neck(&trunk).unwrap_or_else(|| Run {
            x: bounds.x as f32 + 0.5 * bounds.width as f32,
            y: (bounds.y + bounds.height) as f32,
            width: bounds.height as f32 / 22.0,
        });
        let below = |run: &&Run| run.y - neck.y <= OVERLAP * neck.width;
        let foot = trunk.iter().rev().find(below).filter(|run| run.y > neck.y);
        let foot = foot.map_or(Vec2::new(neck.x, neck.y + 2.0), |run| {
            Vec2::new(run.x, run.y)
        });
        let slender = bounds.height as f32 / bounds.width as f32;
        let above = (neck.y - bounds.y as f32) / scale;
        let neck_m = Vec2::new(neck.x - foot.x, foot.y - neck.y) / scale;
        Self {
            scale,
            foot,
            neck: neck_m,
            radius_m: (0.49 * neck.width / scale).clamp(0.05, 0.8),
            bare_m: neck_m.y + 0.04 * above,
            leader_m: above * if slender > 1.5 { 0.8 } else { 0.3 },
        }
    }

    /// The place in the picture, pixels, of one in metres from the foot, y up.
    pub(super) fn pixel_from_tree(&self, p: Vec3) -> Vec2 {
        self.foot + Vec2::new(p.x, -p.y) * self.scale
    }

    /// How far above the neck a place in metres from the foot is, in metres.
    pub(super) fn above_neck_m(&self, p: Vec3) -> f32 {
        p.y - self.neck.y
    }
}

/// The trunk in a row of the picture, pixels.
#[derive(Clone, Copy)]
struct Run {
    /// Of its middle.
    x: f32,
    y: f32,
    width: f32,
}

/// The thickest part of the trunk in each row below the middle of the crown that shows one, from the top.
fn trunk(tree: &Tree, crown: Rect) -> Vec<Run> {
    let row = |y: u32| {
        let is_trunk = tree
            .labels
            .row(y)
            .iter()
            .map(|label| *label == Label::Trunk);
        let (mut best, mut from) = (0..0, None);
        for (x, is_trunk) in is_trunk.chain([false]).enumerate() {
            match (is_trunk, from) {
                (true, None) => from = Some(x),
                (false, Some(first)) => {
                    if x - first > best.len() {
                        best = first..x;
                    }
                    from = None;
                }
                _ => {}
            }
        }
        (!best.is_empty()).then(|| Run {
            x: 0.5 * (best.start + best.end - 1) as f32,
            y: y as f32,
            width: best.len() as f32,
        })
    };
    let rows = crown.y + crown.height / 2..tree.labels.height();
    rows.filter_map(row).collect()
}

/// Where `trunk` goes up into the crown.
fn neck(trunk: &[Run]) -> Option<Run> {
    let mut widths: Vec<f32> = trunk.iter().map(|run| run.width).collect();
    widths.sort_by(f32::total_cmp);
    let usual = *widths.get(widths.len() / 2)?;
    let is_whole = |run: &&Run| run.width >= AS_WIDE * usual;
    let top = trunk.iter().find(is_whole)?;
    // Limbs that leave it and leaves before it make single rows wider or narrower.
    let width = top.width.min(1.1 * usual);
    let near = trunk.iter().filter(is_whole);
    let near =
        near.filter(|run| run.width <= 1.25 * usual && (0.0..width).contains(&(run.y - top.y)));
    let (sum, count) = near.fold((0.0, 0.0), |(sum, count), run| (sum + run.x, count + 1.0));
    let x = if count > 0.0 { sum / count } else { top.x };
    Some(Run { x, width, ..*top })
}

/// Limbs that fill the crown.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn grown(
    leaves: &Leaves,
    stem: &Stem,
    seed: Seed,
    cancel: &Cancel,
) -> Result<Skeleton, Cancelled> {
    let mut random = seed.derive("limbs", 0).random();
    let points = points(leaves, stem, &mut random);
    let mut skeleton = Skeleton::default();
    let mut last = skeleton.grow(Vec3::ZERO, None);
    let neck = stem.neck.extend(0.0);
    let steps = (neck.length() / STEP_M).ceil().max(1.0);
    for i in 1..=steps as usize {
        last = skeleton.grow(neck * (i as f32 / steps), Some(last));
    }
    let mut lean = (stem.neck.x / stem.neck.y.max(0.1)).clamp(-0.3, 0.3);
    let mut position = neck;
    for _ in 0..(stem.leader_m / STEP_M) as usize {
        let mut crook = || random.between(-0.03, 0.03) as f32;
        position += Vec3::new(lean + crook(), 1.0, crook()) * STEP_M;
        lean *= LEAN_KEPT;
        last = skeleton.grow(position, Some(last));
    }
    let reach = Reach {
        step_m: STEP_M,
        kill_m: 0.32,
        influence_m: 6.0,
        tropism: Vec3::new(0.0, 0.12, 0.0),
        bare_m: stem.bare_m,
        crook: 0.26,
    };
    colonise(&mut skeleton, &points, &reach, &mut random, cancel)?;
    skeleton.relax(2);
    twigs(&mut skeleton, &mut random);
    Ok(skeleton)
}

/// Points in the crown, more of them near its surface.
fn points(leaves: &Leaves, stem: &Stem, random: &mut Random) -> Vec<Vec3> {
    let bounds = leaves.bounds;
    let rows: Vec<Option<[f32; 2]>> = (bounds.y..bounds.y + bounds.height)
        .map(|y| {
            let ends = row_ends(leaves.share.row(y), |share| *share > 0.0)?;
            Some(ends.map(|x| x as f32))
        })
        .collect();
    let mut points = Vec::with_capacity(POINTS);
    for _ in 0..40 * POINTS {
        if points.len() == POINTS {
            break;
        }
        let x = bounds.x + random.below(bounds.width as usize) as u32;
        let y = bounds.y + random.below(bounds.height as usize) as u32;
        let (deep, wish) = (random.between(-1.0, 1.0) as f32, random.unit() as f32);
        let Some([first, last]) = rows[(y - bounds.y) as usize] else {
            continue;
        };
        if leaves.share.at(x, y) <= 0.0 {
            continue;
        }
        let half = (0.5 * (last - first)).max(1.0);
        let aside = (x as f32 - 0.5 * (first + last)) / half;
        let depth = deep * (1.0 - aside * aside).max(0.0).sqrt();
        let outside = aside * aside + depth * depth;
        if wish > 0.25 + 0.75 * outside {
            continue;
        }
        let point = Vec3::new(
            (x as f32 - stem.foot.x) / stem.scale,
            (stem.foot.y - y as f32) / stem.scale,
            depth * half / stem.scale,
        );
        // What hangs below the lowest limb is reached from afar or not at all: no brush at its height.
        if point.y > stem.bare_m + 0.12 * Vec2::new(point.x, point.z).length() {
            points.push(point);
        }
    }
    points
}

/// Lets fine twigs grow from every tip, and again from those.
fn twigs(skeleton: &mut Skeleton, random: &mut Random) {
    for (count, length) in [(3, 0.42), (3, 0.26)] {
        let children = skeleton.children();
        let tips: Vec<u32> = (0..children.len() as u32)
            .filter(|&node| children[node as usize].is_empty())
            .collect();
        for tip in tips {
            let from = skeleton.nodes[tip as usize].position;
            let along = skeleton.direction(tip);
            for _ in 0..count {
                let mut side = || random.between(-0.9, 0.9) as f32;
                let aside = Vec3::new(side(), 0.6 * side() + 0.2, side());
                let direction = (along + aside).normalize_or(along);
                let reach = length * random.between(0.6, 1.1) as f32;
                let middle = skeleton.grow(from + direction * (0.5 * reach), Some(tip));
                let bend = Vec3::new(0.0, 0.08 * reach, 0.0);
                skeleton.grow(from + direction * reach + bend, Some(middle));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trunk_goes_up_to_where_limbs_leave_it() {
        let run = |y: u32, width: f32| Run {
            x: 50.0,
            y: y as f32,
            width,
        };
        // A twig in a gap of the crown, a fork, the trunk, its roots.
        let widths = [(0..10, 3.0), (12..14, 30.0), (14..60, 20.0), (60..64, 34.0)];
        let trunk = widths.into_iter();
        let trunk: Vec<Run> = trunk
            .flat_map(|(rows, width)| rows.map(move |y| run(y, width)))
            .collect();
        let neck = neck(&trunk).unwrap();
        assert_eq!((neck.y, neck.width), (12.0, 22.0));
        assert!(super::neck(&[]).is_none());
    }
}
