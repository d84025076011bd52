//! Broad-leaved habits: a crown of leafy lobes inside a species envelope, reached by colonisation.
//!
//! The envelope is a body of revolution given by its outline. Attraction points are not spread
//! evenly in it: they fill lobes, flattened balls set apart from each other near its surface, for
//! real crowns are bunches of boughs that have each won a window to the light. The lobes are what
//! the shading later shows as bright tops above dark undersides.

use super::individual::Stance;
use super::noise::noise3;
use super::skeleton::{GOLDEN_ANGLE, Reach, Skeleton, colonise, random_in_ball};
use crate::base::{Cancel, Cancelled, Random};
use glam::Vec3;

/// The habit of a broad-leaved tree or shrub. Shares are of the tree's height.
#[derive(Debug, Clone, Copy)]
pub struct Crown {
    /// Height of the crown's lower edge, 0..1.
    pub base: f32,
    /// Outline: (height inside the crown 0..1, radius as a share of the tree's height), rising.
    pub outline: &'static [(f32, f32)],
    /// Number of lobes that are tried; those too near to others are dropped.
    pub lobes: u32,
    /// Smallest and largest lobe radius, shares of the height.
    pub lobe: (f32, f32),
    /// Height of a lobe against its width; below 1 it is a cushion.
    pub flatness: f32,
    /// Share of the points that lie anywhere in the envelope, 0..1: fills the gaps.
    pub loose: f32,
    /// Distance between attraction points in metres: fineness of the branching.
    pub spacing_m: f32,
    /// Height the first stem reaches by itself; high for trees with one leader.
    pub leader: f32,
    /// Stems that leave the ground; more than one makes a shrub.
    pub stems: u32,
    /// How crooked stem and limbs are; 0.1 calm, 0.5 gnarled.
    pub crook: f32,
    /// How strongly limbs rise; −0.2 hangs, 0.5 strives up.
    pub rise: f32,
    /// Mean length of hanging strands at the tips in metres; 0 for none.
    pub strands_m: f32,
}

/// Radius of an outline at `t`, piecewise linear; 0 outside.
pub(super) fn outline_radius(outline: &[(f32, f32)], t: f32) -> f32 {
    outline
        .windows(2)
        .find(|pair| (pair[0].0..=pair[1].0).contains(&t))
        .map_or(0.0, |pair| {
            let share = (t - pair[0].0) / (pair[1].0 - pair[0].0);
            pair[0].1 + (pair[1].1 - pair[0].1) * share
        })
}

/// Grows the skeleton of a tree with this habit.
///
/// # Errors
/// [`Cancelled`].
pub fn crown_skeleton(
    crown: &Crown,
    stance: &Stance,
    random: &mut Random,
    cancel: &Cancel,
) -> Result<Skeleton, Cancelled> {
    let height_m = stance.height_m;
    let envelope = Envelope::new(crown, stance, random);
    let attractors = attractors(&envelope, random);
    let mut skeleton = Skeleton::default();
    stems(&mut skeleton, crown, height_m, random);
    let step_m = 0.55 * crown.spacing_m;
    let reach = Reach {
        step_m,
        kill_m: 0.95 * crown.spacing_m,
        influence_m: 0.6 * height_m,
        tropism: Vec3::Y * crown.rise,
        bare_m: (1.1 * crown.base).min(0.94 * reach_of(crown)) * height_m,
        crook: crown.crook,
    };
    colonise(&mut skeleton, &attractors, &reach, random, cancel)?;
    skeleton.relax(3);
    lean(&mut skeleton, stance);
    if crown.strands_m > 0.0 {
        hang_strands(&mut skeleton, crown, 0.8 * crown.base * height_m, random);
    }
    Ok(skeleton)
}

/// Leans the whole tree: most low on the stem, for stems turn back to the light.
fn lean(skeleton: &mut Skeleton, stance: &Stance) {
    for node in &mut skeleton.nodes {
        let share = (node.position.y / stance.height_m).clamp(0.0, 1.0);
        let aside = stance.lean * node.position.y * (1.35 - 0.5 * share);
        node.position += Vec3::new(aside.x, 0.0, aside.y);
    }
}

/// The body in which the crown grows.
struct Envelope<'a> {
    crown: &'a Crown,
    height_m: f32,
    breadth: f32,
    /// Chooses in which directions it bulges.
    salt: u32,
}

impl<'a> Envelope<'a> {
    fn new(crown: &'a Crown, stance: &Stance, random: &mut Random) -> Self {
        Self {
            crown,
            height_m: stance.height_m,
            breadth: stance.breadth,
            salt: random.bits() as u32,
        }
    }

    /// Radius at the height `t` of the crown, as a share of the tree's height, without bulges.
    fn radius(&self, t: f32) -> f32 {
        outline_radius(self.crown.outline, t) * self.breadth
    }

    /// Whether a place, (x, z) as shares of the tree's height and `t` of the crown's, is inside.
    ///
    /// No crown is round: it bulges to one side here, to another there.
    fn contains(&self, x: f32, t: f32, z: f32) -> bool {
        let allowed = self.radius(t);
        let out = (x * x + z * z).sqrt().max(1e-4);
        let bulge = 1.0 + 0.30 * noise3(1.3 * x / out, 2.6 * t, 1.3 * z / out, self.salt);
        out <= allowed * bulge.min(1.15)
    }

    /// A random place inside, drawn in to the middle by `scale`, in metres.
    fn point(&self, scale: f32, random: &mut Random) -> Vec3 {
        let outline = self.crown.outline.iter();
        let widest = 1.15 * self.breadth * outline.map(|point| point.1).fold(0.0, f32::max);
        loop {
            let side = |random: &mut Random| random.between(-1.0, 1.0) as f32 * widest;
            let (x, z) = (side(random), side(random));
            let t = random.between(0.0, 1.0) as f32;
            if self.contains(x, t, z) {
                let base = self.crown.base;
                let y = base + (1.0 - base) * t;
                let middle = base + 0.45 * (1.0 - base);
                let place = Vec3::new(x * scale, middle + (y - middle) * scale, z * scale);
                return place * self.height_m;
            }
        }
    }
}

/// Share of the height that the stem reaches by itself: into the crown at least.
fn reach_of(crown: &Crown) -> f32 {
    crown.leader.max(1.12 * crown.base)
}

/// The stems from the ground to where the crown takes over.
fn stems(skeleton: &mut Skeleton, crown: &Crown, height_m: f32, random: &mut Random) {
    let root = skeleton.grow(Vec3::ZERO, None);
    let step_m = 0.55 * crown.spacing_m;
    for stem in 0..crown.stems {
        let salt = random.bits() as u32;
        let lean = match crown.stems {
            1 => random_in_ball(random) * 0.03,
            _ => {
                let angle = stem as f32 * GOLDEN_ANGLE + random.unit() as f32;
                Vec3::new(libm::cosf(angle), 0.0, libm::sinf(angle))
                    * random.between(0.2, 0.9) as f32
            }
        };
        let mut direction = (Vec3::Y + lean).normalize();
        let mut position = Vec3::ZERO;
        // Stems of a shrub are of unequal length; a single one is as long as it should be.
        let reach_m = reach_of(crown) * height_m * (1.0 - 0.25 * (stem as f32 * 0.37).fract());
        let mut last = root;
        while position.y < reach_m {
            let sway = |axis: f32| noise3(0.35 * position.y, axis, 0.0, salt) * 0.5 * crown.crook;
            direction =
                (direction * 3.0 + Vec3::Y * 0.7 + Vec3::new(sway(0.0), 0.0, sway(7.0)) * 1.3)
                    .normalize();
            position += direction * step_m;
            last = skeleton.grow(position, Some(last));
        }
    }
}

/// A flattened ball of leaves.
struct Lobe {
    center: Vec3,
    radius_m: f32,
}

/// The points that want leaves: the lobes', and some loose ones anywhere in the envelope.
fn attractors(envelope: &Envelope<'_>, random: &mut Random) -> Vec<Vec3> {
    let (crown, height_m) = (envelope.crown, envelope.height_m);
    let lobes = lobes(envelope, random);
    let salt = random.bits() as u32;
    let mut points = Vec::new();
    let volume = crown.spacing_m * crown.spacing_m * crown.spacing_m;
    for lobe in &lobes {
        // 4.19: volume of the unit ball.
        let ball = 4.19 * lobe.radius_m * lobe.radius_m * lobe.radius_m * crown.flatness;
        for _ in 0..(ball / volume) as usize {
            let offset = random_in_ball(random) * Vec3::new(1.0, crown.flatness, 1.0);
            let ragged = 1.0 + 0.35 * noise3(offset.x * 1.7, offset.y * 1.7, offset.z * 1.7, salt);
            let point = lobe.center + offset * lobe.radius_m * ragged;
            if point.y > 0.3 * crown.base * height_m {
                points.push(point);
            }
        }
    }
    let loose = (points.len() as f32 * crown.loose / (1.0 - crown.loose).max(0.05)) as usize;
    for _ in 0..loose {
        points.push(envelope.point(1.0, random));
    }
    points
}

/// Lobes near the envelope's surface, none deep inside another.
fn lobes(envelope: &Envelope<'_>, random: &mut Random) -> Vec<Lobe> {
    let (crown, height_m) = (envelope.crown, envelope.height_m);
    let mut lobes: Vec<Lobe> = Vec::new();
    for _ in 0..crown.lobes {
        let wanted_m = random.between(crown.lobe.0.into(), crown.lobe.1.into()) as f32 * height_m;
        let center = envelope.point(0.9, random);
        let t = (center.y / height_m - crown.base) / (1.0 - crown.base);
        let room_m = (0.85 * envelope.radius(t) + 0.015) * height_m;
        let radius_m = wanted_m.min(room_m);
        let crowded = lobes.iter().any(|other| {
            let apart = (other.center - center) / Vec3::new(1.0, crown.flatness, 1.0);
            apart.length() < 0.62 * (other.radius_m + radius_m)
        });
        if !crowded {
            lobes.push(Lobe { center, radius_m });
        }
    }
    lobes
}

/// Lets strands hang from the tips and limbs above `bare_m`: they leave in the limb's direction and
/// bend down.
fn hang_strands(skeleton: &mut Skeleton, crown: &Crown, bare_m: f32, random: &mut Random) {
    /// Distance between the nodes of a strand in metres.
    const STEP_M: f32 = 0.16;
    let children = skeleton.children();
    for (index, grown) in children.iter().enumerate() {
        let strands = match grown.len() {
            0 => 2,
            1 if random.unit() < 0.38 => 1,
            _ => 0,
        };
        for _ in 0..strands {
            let start = skeleton.nodes[index].position;
            if start.y < bare_m {
                continue;
            }
            let length_m = crown.strands_m * random.between(0.45, 1.25) as f32;
            let outward = Vec3::new(start.x, 0.0, start.z).normalize_or_zero();
            let mut direction =
                (skeleton.direction(index as u32) + outward * 0.5 + random_in_ball(random) * 0.7)
                    .normalize_or(Vec3::X);
            let mut position = start;
            let mut last = index as u32;
            for _ in 0..(length_m / STEP_M) as usize {
                direction =
                    (direction - Vec3::Y * 0.34 + random_in_ball(random) * 0.06).normalize();
                position += direction * STEP_M;
                if position.y < 0.25 {
                    break;
                }
                last = skeleton.grow(position, Some(last));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outlines_are_linear_between_their_points() {
        let outline = [(0.0, 0.1), (0.5, 0.3), (1.0, 0.0)];
        assert!((outline_radius(&outline, 0.25) - 0.2).abs() < 1e-6);
        assert!((outline_radius(&outline, 1.0)).abs() < 1e-6);
        assert!(outline_radius(&outline, 1.1) == 0.0);
    }
}
