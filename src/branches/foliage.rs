//! Leaves: where on the twigs they sit, how they turn, and what tone each has.
//!
//! Every node of the skeleton that carries few enough tips bears short leafy twigs. Leaves follow
//! the species' phyllotaxis along them (successive leaves turn by the golden angle, stand opposite
//! in crossed pairs, or lie in two rows) and then turn their blades to the light, up and out of
//! their bough. Needles come as cards: a piece of clothed twig or a tuft, turned to the viewer,
//! for a brush looks the same from every side.

use super::limbs::Girth;
use super::noise::noise3;
use super::skeleton::{GOLDEN_ANGLE, Skeleton, random_in_ball};
use super::sprite::LeafShape;
use crate::base::Random;
use glam::Vec3;
use std::f32::consts::{FRAC_PI_2, PI, TAU};

/// How leaves follow each other along a twig.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phyllotaxis {
    /// One leaf at a time, each turned by the golden angle.
    Spiral,
    /// Pairs, each crossed to the one before.
    Opposite,
    /// Two rows left and right.
    Rows,
    /// No single leaves: the twig itself is a card (brushes, tufts).
    Cards,
}

/// The foliage of a species.
#[derive(Debug, Clone, Copy)]
pub struct Foliage {
    /// Shape of the leaf.
    pub shape: LeafShape,
    /// Mean length of a leaf or card in metres.
    pub leaf_m: f32,
    /// Order of the leaves.
    pub phyllotaxis: Phyllotaxis,
    /// Mean number of twigs of a bearing node.
    pub twigs: f32,
    /// Length of a twig in metres.
    pub twig_m: f32,
    /// Leaves of a twig.
    pub leaves: u32,
    /// A node with more tips above it than this bears nothing.
    pub bearing_tips: u32,
    /// How far leaves hang: 0 stretched out, 1 limp.
    pub droop: f32,
}

/// sRGB colours of foliage: reflectances, before light and shade.
#[derive(Debug, Clone, Copy)]
pub struct LeafTint {
    /// Most leaves.
    pub main: [u8; 3],
    /// The other end of the variation: younger, yellower, or turned by autumn.
    pub other: [u8; 3],
    /// Light that has passed a leaf.
    pub through: [u8; 3],
    /// Share of `other` on average, 0..1.
    pub share: f32,
    /// How patchy the mixture is, 0 (leaf by leaf) to 1 (whole boughs).
    pub patchy: f32,
}

impl LeafTint {
    /// The tint of another tree of the kind: `warmth` and `depth` in 0..1, both 0.5 for no change.
    pub fn changed(&self, warmth: f32, depth: f32) -> Self {
        let (warm, deep) = (warmth - 0.5, depth - 0.5);
        let change = |colour: [u8; 3]| {
            let [r, g, b] = colour.map(f32::from);
            let light = 1.0 - 0.22 * deep;
            let grey = 0.3 * r + 0.6 * g + 0.1 * b;
            let shown = |c: f32, tilt: f32| {
                let colourful = grey + (c - grey) * (1.0 + 0.25 * deep);
                (colourful * light * (1.0 + tilt * warm)).clamp(0.0, 255.0) as u8
            };
            [shown(r, 0.20), shown(g, 0.03), shown(b, -0.22)]
        };
        Self {
            main: change(self.main),
            other: change(self.other),
            through: change(self.through),
            ..*self
        }
    }
}

/// One leaf or card in place.
#[derive(Debug, Clone, Copy)]
pub struct Leaf {
    /// Where its stalk ends, in metres.
    pub base: Vec3,
    /// From base to tip, in metres.
    pub along: Vec3,
    /// Across the blade, from the left edge to the right, in metres.
    pub across: Vec3,
    /// Unit normal of the blade.
    pub normal: Vec3,
    /// Unit direction out of its bough: the normal of the clump that it belongs to.
    pub outward: Vec3,
    /// 0 the tint's main colour, 1 the other.
    pub tone: f32,
    /// Factor on its brightness, about 1.
    pub light: f32,
}

/// A leafy twig, straight: drawn as thin wood.
#[derive(Debug, Clone, Copy)]
pub struct Twig {
    /// Where it leaves the limb.
    pub from: Vec3,
    /// Its tip.
    pub to: Vec3,
}

/// All leaves and the twigs that bear them.
#[derive(Debug, Clone, Default)]
pub struct Leafage {
    /// In the order of the nodes that bear them.
    pub leaves: Vec<Leaf>,
    /// Twigs, not part of the skeleton.
    pub twigs: Vec<Twig>,
}

/// Foliage on a skeleton.
pub fn leafage(
    skeleton: &Skeleton,
    girth: &Girth,
    foliage: &Foliage,
    tint: &LeafTint,
    random: &mut Random,
) -> Leafage {
    let boughs = bough_middles(skeleton, girth);
    let mut leafage = Leafage::default();
    let salt = random.bits() as u32;
    for (index, node) in skeleton.nodes.iter().enumerate() {
        if girth.tips[index] > foliage.bearing_tips || node.parent.is_none() {
            continue;
        }
        let outward = (node.position - boughs[index]).normalize_or(Vec3::Y);
        let mut bearer = Bearer {
            foliage,
            tint,
            salt,
            outward,
            random,
            into: &mut leafage,
        };
        let direction = skeleton.direction(index as u32);
        let whole = foliage.twigs as u32;
        let more = bearer.random.unit() < f64::from(foliage.twigs - whole as f32);
        for twig in 0..whole + u32::from(more) {
            bearer.bear(node.position, direction, twig);
        }
    }
    leafage
}

/// For each node the place from which its bough's clump spreads: the last node on its way to the
/// root that carries a good number of tips, lowered a little.
fn bough_middles(skeleton: &Skeleton, girth: &Girth) -> Vec<Vec3> {
    /// Tips that make a bough: one clump of the size the eye groups.
    const BOUGH_TIPS: u32 = 28;
    let mut middles: Vec<Vec3> = Vec::with_capacity(skeleton.nodes.len());
    for (index, node) in skeleton.nodes.iter().enumerate() {
        let own = girth.tips[index] >= BOUGH_TIPS;
        let middle = match node.parent {
            Some(parent) if !own => middles[parent as usize],
            _ => node.position - Vec3::Y * 0.15,
        };
        middles.push(middle);
    }
    middles
}

/// Bears the twigs of one node.
struct Bearer<'a> {
    foliage: &'a Foliage,
    tint: &'a LeafTint,
    salt: u32,
    outward: Vec3,
    random: &'a mut Random,
    into: &'a mut Leafage,
}

impl Bearer<'_> {
    fn bear(&mut self, from: Vec3, limb: Vec3, twig: u32) {
        if self.foliage.phyllotaxis == Phyllotaxis::Cards {
            self.card(from, limb);
            return;
        }
        let turned = random_in_ball(self.random) * 0.9 + self.outward * 0.45;
        let stays = if twig == 0 { 0.9 } else { 0.35 };
        let direction =
            (limb * stays + turned - Vec3::Y * self.foliage.droop * 0.5).normalize_or(limb);
        let long = self.foliage.twig_m * self.random.between(0.5, 1.3) as f32;
        let to = from + direction * long;
        self.into.twigs.push(Twig { from, to });
        let roll = self.random.between(0.0, 1.0) as f32 * TAU;
        for leaf in 0..self.foliage.leaves {
            let share = (leaf as f32 + 0.7) / self.foliage.leaves as f32;
            let (angle, share) = match self.foliage.phyllotaxis {
                Phyllotaxis::Opposite => {
                    let pair = (leaf / 2) as f32;
                    let half = (leaf % 2) as f32 * PI;
                    (
                        pair * FRAC_PI_2 + half,
                        (pair * 2.0 + 1.4) / self.foliage.leaves as f32,
                    )
                }
                Phyllotaxis::Rows => ((leaf % 2) as f32 * PI, share),
                _ => (leaf as f32 * GOLDEN_ANGLE, share),
            };
            self.leaf(from.lerp(to, share.min(1.0)), direction, roll + angle);
        }
    }

    fn leaf(&mut self, base: Vec3, twig: Vec3, angle: f32) {
        let side = twig.any_orthonormal_vector();
        let other = twig.cross(side);
        let radial = side * libm::cosf(angle) + other * libm::sinf(angle);
        let hang = self.foliage.droop * self.random.between(0.5, 1.4) as f32;
        let jitter = random_in_ball(self.random) * 0.35;
        let along = (twig * 0.55 + radial * 0.8 + jitter - Vec3::Y * hang).normalize_or(twig);
        let to_light =
            Vec3::new(-0.15, 0.55, 0.25) + self.outward * 0.55 + random_in_ball(self.random) * 0.75;
        let across = along.cross(to_light).normalize_or(side);
        let length = self.foliage.leaf_m * self.random.between(0.7, 1.25) as f32;
        self.put(base, along, across, length);
    }

    /// A card lies along the limb, or leaves it at a slant, broad side to the viewer.
    fn card(&mut self, from: Vec3, limb: Vec3) {
        let tuft = self.foliage.shape == LeafShape::Tuft;
        let loose = if tuft { 1.15 } else { 0.42 };
        let lift = if tuft { 0.35 } else { 0.0 };
        let along = (limb
            + random_in_ball(self.random) * loose
            + Vec3::Y * (lift - 0.3 * self.foliage.droop))
            .normalize_or(limb);
        let across = along
            .cross(Vec3::Z + random_in_ball(self.random) * 0.45)
            .normalize_or(Vec3::X);
        let length = self.foliage.leaf_m * self.random.between(0.75, 1.2) as f32;
        // A card that points at the viewer still shows a brush's length of needles.
        let flat = Vec3::new(along.x, along.y, along.z * 0.55).normalize_or(along);
        self.put(from - flat * length * 0.15, flat, across, length);
    }

    fn put(&mut self, base: Vec3, along: Vec3, across: Vec3, length: f32) {
        let tint = self.tint;
        let patch = noise3(base.x * 0.9, base.y * 0.9, base.z * 0.9, self.salt);
        let single = self.random.unit() as f32 - 0.5;
        let spread = patch * tint.patchy * 0.9 + single * (1.0 - 0.6 * tint.patchy);
        self.into.leaves.push(Leaf {
            base,
            along: along * length,
            across: across * length * self.foliage.shape.aspect(),
            normal: across.cross(along).normalize_or(Vec3::Z),
            outward: self.outward,
            tone: (tint.share + spread).clamp(0.0, 1.0),
            light: 1.0 + 0.18 * self.random.between(-1.0, 1.0) as f32,
        });
    }
}
