//! Conifer habits: one straight stem with boughs in whorls, each bough a flat spray of twigs.
//!
//! Spruces and firs do not compete for light point by point; their plan is fixed: a leader, every
//! year a whorl of boughs around it, every bough a herringbone. So these trees are laid out by rule
//! and varied by chance: azimuths turn by the golden angle, lengths follow the outline, boughs
//! rise near the top, sink with age and lift their tips.

use super::crown::outline_radius;
use super::individual::Stance;
use super::skeleton::{GOLDEN_ANGLE, Skeleton, random_in_ball};
use crate::base::Random;
use glam::Vec3;

/// The habit of a spruce or a fir. Shares are of the tree's height.
#[derive(Debug, Clone, Copy)]
pub struct Whorls {
    /// Height of the lowest boughs, 0..1.
    pub base: f32,
    /// Outline as in [`Crown`](super::crown::Crown).
    pub outline: &'static [(f32, f32)],
    /// Distance between whorls in metres.
    pub interval_m: f32,
    /// Boughs of a whorl.
    pub boughs: u32,
    /// Slope (rise over run) with which boughs leave the stem at the crown's base and at its top.
    pub slope: (f32, f32),
    /// How far a bough sinks below that slope at its tip, as a share of its length.
    pub sink: f32,
    /// How much its last third lifts again, as a share of its length.
    pub lift: f32,
    /// Length of side twigs against the rest of the bough ahead of them.
    pub spread: f32,
    /// How much side twigs hang: 0 flat sprays, 1 curtains.
    pub hang: f32,
    /// Distance between side twigs in metres.
    pub twig_step_m: f32,
}

/// Lays out the skeleton of a conifer.
pub fn whorl_skeleton(habit: &Whorls, stance: &Stance, random: &mut Random) -> Skeleton {
    let height_m = stance.height_m;
    let mut skeleton = Skeleton::default();
    let stem = stem(&mut skeleton, stance, random);
    let mut azimuth = random.between(0.0, 1.0) as f32 * std::f32::consts::TAU;
    let mut y = habit.base * height_m;
    while y < 0.97 * height_m {
        let t = (y / height_m - habit.base) / (1.0 - habit.base);
        let boughs = (habit.boughs as f32 * (1.0 - 0.6 * t)) as u32;
        let weak = random.between(0.86, 1.08) as f32;
        for bough in 0..boughs {
            azimuth += GOLDEN_ANGLE + random.between(-0.25, 0.25) as f32;
            // Every other bough stands a little above its whorl.
            let up =
                habit.interval_m * random.between(0.0, 0.5 + 0.3 * f64::from(bough % 2)) as f32;
            let long = outline_radius(habit.outline, t) * stance.breadth * height_m * weak;
            let length_m = long * random.between(0.66, 1.14) as f32 + 0.05;
            let at = stem[(((y + up) / height_m * stem.len() as f32) as usize).min(stem.len() - 1)];
            add_bough(&mut skeleton, habit, at, azimuth, length_m, t, random);
        }
        y += habit.interval_m * (1.0 - 0.45 * t) * random.between(0.8, 1.2) as f32;
    }
    skeleton
}

/// The stem's nodes, evenly spaced from the ground to the top.
fn stem(skeleton: &mut Skeleton, stance: &Stance, random: &mut Random) -> Vec<u32> {
    /// Distance between the nodes of the stem in metres.
    const STEP_M: f32 = 0.12;
    let height_m = stance.height_m;
    let sway = random_in_ball(random) * 0.008;
    let lean = Vec3::new(stance.lean.x + sway.x, 0.0, stance.lean.y + sway.z);
    let steps = (height_m / STEP_M) as u32;
    let mut nodes = vec![skeleton.grow(Vec3::ZERO, None)];
    for step in 1..=steps {
        let y = height_m * step as f32 / steps as f32;
        let parent = nodes.last().copied();
        nodes.push(skeleton.grow(Vec3::new(lean.x * y, y, lean.z * y), parent));
    }
    nodes
}

fn add_bough(
    skeleton: &mut Skeleton,
    habit: &Whorls,
    at: u32,
    azimuth: f32,
    length_m: f32,
    t: f32,
    random: &mut Random,
) {
    let outward = Vec3::new(libm::cosf(azimuth), 0.0, libm::sinf(azimuth));
    let side = Vec3::new(-outward.z, 0.0, outward.x);
    let slope =
        habit.slope.0 + (habit.slope.1 - habit.slope.0) * t + random.between(-0.1, 0.1) as f32;
    let bend = random.between(-0.12, 0.12) as f32;
    let start = skeleton.nodes[at as usize].position;
    let sink = habit.sink * (1.0 - 0.7 * t);
    let curve = |u: f32| {
        let rise = slope * u - sink * u * u + habit.lift * u * u * u * u;
        start + (outward * u + side * bend * u * u + Vec3::Y * rise) * length_m
    };
    let steps = ((length_m / habit.twig_step_m) as u32).max(2);
    let mut last = at;
    let mut before = start;
    for step in 1..=steps {
        let u = step as f32 / steps as f32;
        let mut position = curve(u);
        position.y = position.y.max(0.12);
        let ahead = (position - before).normalize_or(outward);
        before = position;
        last = skeleton.grow(position, Some(last));
        if u < 0.12 {
            continue;
        }
        let left = if step % 2 == 0 { 1.0 } else { -1.0 };
        for hand in [left, -left * 0.8] {
            let widest = habit.spread * length_m * (1.0 - u) + 0.10f32.min(0.2 * length_m);
            let twig_m = widest.min(0.42 * length_m).min(u * length_m * 1.4)
                * random.between(0.7, 1.2) as f32;
            let direction = ahead * 0.75 + side * hand + random_in_ball(random) * 0.22;
            add_twig(skeleton, last, direction, twig_m, habit.hang);
        }
    }
}

fn add_twig(skeleton: &mut Skeleton, from: u32, direction: Vec3, length_m: f32, hang: f32) {
    /// Distance between the nodes of a twig in metres: one card of needles each.
    const STEP_M: f32 = 0.11;
    let steps = ((length_m / STEP_M) as u32).max(1);
    let mut direction = direction.normalize_or(Vec3::X);
    let mut position = skeleton.nodes[from as usize].position;
    let mut last = from;
    for _ in 0..steps {
        direction = (direction - Vec3::Y * 0.22 * hang).normalize();
        position += direction * (length_m / steps as f32);
        position.y = position.y.max(0.10);
        last = skeleton.grow(position, Some(last));
    }
}
