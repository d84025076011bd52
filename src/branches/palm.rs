//! The habit of a palm: one stem of even girth under a head of feathered fronds.
//!
//! Fronds leave the top by the golden angle, the youngest upright in the middle, the oldest hanging
//! and dry. Each is a midrib that bends under its weight, with leaflets in two rows that are
//! longest before its middle.

use super::foliage::{Leaf, Leafage};
use super::individual::Stance;
use super::limbs::Girth;
use super::skeleton::{GOLDEN_ANGLE, Skeleton, random_in_ball};
use super::sprite::LeafShape;
use crate::base::Random;
use glam::Vec3;

/// The habit of a palm.
#[derive(Debug, Clone, Copy)]
pub struct Palm {
    /// Number of fronds.
    pub fronds: f32,
    /// Length of a frond in metres.
    pub frond_m: f32,
    /// Leaflets in each of a frond's rows.
    pub leaflets: u32,
    /// How strongly fronds bend down: 0.5 stiff, 1.5 limp.
    pub bend: f32,
    /// Share of the fronds that are dry and hang along the stem.
    pub dry: f32,
    /// How much the stem's base is thicker.
    pub bulge: f32,
}

/// What grows of a palm.
pub(super) struct GrownPalm {
    pub(super) skeleton: Skeleton,
    pub(super) girth: Girth,
    pub(super) leafage: Leafage,
}

/// Distance between the nodes of a stem, and of a midrib, in metres.
const STEM_STEP_M: f32 = 0.25;
const RIB_STEP_M: f32 = 0.12;

/// Grows a palm with a stem of `stem_m` radius; `leaflet_m` is the length of its longest leaflets.
pub(super) fn palm(
    habit: &Palm,
    stance: &Stance,
    stem_m: f32,
    leaflet_m: f32,
    random: &mut Random,
) -> GrownPalm {
    let mut palm = GrownPalm {
        skeleton: Skeleton::default(),
        girth: Girth {
            radius_m: Vec::new(),
            tips: Vec::new(),
            path_m: Vec::new(),
        },
        leafage: Leafage::default(),
    };
    let top = palm.stem(habit, stance, stem_m);
    let fronds = habit.fronds.max(3.0) as u32;
    let start = random.unit() as f32;
    for frond in 0..fronds {
        // 0 the youngest, 1 the oldest.
        let age = (frond as f32 + random.unit() as f32) / fronds as f32;
        let azimuth = (frond as f32 + start) * GOLDEN_ANGLE + random.between(-0.2, 0.2) as f32;
        palm.frond(
            habit,
            top,
            &Frond {
                age,
                azimuth,
                leaflet_m,
                stem_m,
            },
            random,
        );
    }
    palm
}

/// One frond to be.
struct Frond {
    age: f32,
    azimuth: f32,
    leaflet_m: f32,
    stem_m: f32,
}

impl GrownPalm {
    fn node(&mut self, position: Vec3, parent: Option<u32>, radius_m: f32, tips: u32) -> u32 {
        let before = parent.map(|p| (self.skeleton.nodes[p as usize].position, p));
        let path_m = before.map_or(0.0, |(from, p)| {
            self.girth.path_m[p as usize] + from.distance(position)
        });
        self.girth.radius_m.push(radius_m);
        self.girth.tips.push(tips);
        self.girth.path_m.push(path_m);
        self.skeleton.grow(position, parent)
    }

    /// The stem; returns its top.
    fn stem(&mut self, habit: &Palm, stance: &Stance, stem_m: f32) -> u32 {
        let length_m = (stance.height_m - 0.62 * habit.frond_m).max(0.35);
        let steps = libm::ceilf(length_m / STEM_STEP_M) as u32;
        let mut last = self.node(Vec3::ZERO, None, stem_m * (1.0 + habit.bulge), 1 << 20);
        for step in 1..=steps {
            let y = length_m * step as f32 / steps as f32;
            // A leaning palm rises again: the lean is won low on the stem.
            let share = y / length_m;
            let aside = stance.lean * length_m * (share * (1.7 - 0.7 * share));
            let base = libm::expf(-y / (4.0 * stem_m));
            let collar = libm::expf((y - length_m) / (1.5 * stem_m));
            let radius_m = stem_m * (1.0 + habit.bulge * base + 0.25 * collar - 0.1 * share);
            last = self.node(
                Vec3::new(aside.x, y, aside.y),
                Some(last),
                radius_m,
                1 << 20,
            );
        }
        last
    }

    fn frond(&mut self, habit: &Palm, top: u32, frond: &Frond, random: &mut Random) {
        let outward = Vec3::new(libm::cosf(frond.azimuth), 0.0, libm::sinf(frond.azimuth));
        let side = Vec3::new(-outward.z, 0.0, outward.x);
        let is_dry = frond.age > 1.0 - habit.dry;
        // From upright to hanging.
        let rise = if is_dry { -1.5 } else { 2.3 - 2.9 * frond.age };
        let mut direction =
            (outward + Vec3::Y * rise + random_in_ball(random) * 0.12).normalize_or(Vec3::Y);
        let long = (0.62 + 0.38 * (frond.age * 3.0).min(1.0)) * random.between(0.88, 1.1) as f32;
        let length_m = habit.frond_m * long * if is_dry { 0.72 } else { 1.0 };
        let steps = libm::ceilf(length_m / RIB_STEP_M) as u32;
        let foot = self.skeleton.nodes[top as usize].position;
        let mut position =
            foot + outward * 0.35 * frond.stem_m - Vec3::Y * frond.stem_m * 1.4 * (frond.age - 0.4);
        let mut last = self.node(position, Some(top), 0.028, 1);
        let bow = random.between(-0.25, 0.25) as f32;
        for step in 1..=steps {
            let u = step as f32 / steps as f32;
            let pull = habit.bend * (0.35 + 0.9 * u) * (0.45 + 0.65 * frond.age) / steps as f32;
            direction = (direction - Vec3::Y * pull + side * (bow / steps as f32))
                .normalize_or(Vec3::NEG_Y);
            position += direction * (length_m / steps as f32);
            position.y = position.y.max(0.05);
            last = self.node(position, Some(last), 0.024 * (1.0 - u) + 0.004, 1);
            let count = (habit.leaflets * step / steps) - (habit.leaflets * (step - 1) / steps);
            if u > 0.14 {
                for _ in 0..count {
                    for hand in [-1.0, 1.0] {
                        self.leaflet(frond, is_dry, (position, direction, side * hand), u, random);
                    }
                }
            }
        }
    }

    fn leaflet(
        &mut self,
        frond: &Frond,
        is_dry: bool,
        (position, rib, side): (Vec3, Vec3, Vec3),
        u: f32,
        random: &mut Random,
    ) {
        let above = rib.cross(side).normalize_or(Vec3::Y);
        let above = if above.y < 0.0 { -above } else { above };
        let lift = random.between(-0.05, 0.4) as f32 * (1.0 - 0.8 * frond.age);
        let limp = if is_dry { 0.9 } else { 0.18 + 0.35 * frond.age };
        let along = (side * (0.95 - 0.45 * u) + rib * (0.35 + 0.75 * u) + above * lift
            - Vec3::Y * limp * random.between(0.4, 1.2) as f32
            + random_in_ball(random) * 0.14)
            .normalize_or(side);
        // Longest before the middle, short at both ends.
        let profile = (0.45 + 2.2 * u).min(1.0) * (1.0 - 0.65 * u * u);
        let length = frond.leaflet_m * profile * random.between(0.85, 1.1) as f32;
        let facing = above * 0.7 + Vec3::Z * 0.55 + random_in_ball(random) * 0.5;
        let across = along.cross(facing).normalize_or(Vec3::X);
        let jitter = rib * (RIB_STEP_M * (random.unit() as f32 - 0.5));
        let outward = (position - self.skeleton.nodes[0].position - Vec3::Y * position.y * 0.9)
            .normalize_or(Vec3::Y);
        let tone = if is_dry {
            1.0
        } else {
            0.04 + 0.28 * random.unit() as f32 * frond.age + 0.12 * u * u
        };
        self.leafage.leaves.push(Leaf {
            base: position + jitter,
            along: along * length,
            across: across * length * LeafShape::Blade.aspect(),
            normal: across.cross(along).normalize_or(Vec3::Z),
            outward,
            tone,
            light: 1.0 + 0.15 * random.between(-1.0, 1.0) as f32,
        });
    }
}
