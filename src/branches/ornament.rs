//! Blossom and fruit: what hangs among the leaves for a part of the year.

use super::foliage::{Leaf, Leafage};
use super::skeleton::random_in_ball;
use crate::base::Random;
use glam::Vec3;

/// Kinds of ornament.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OrnamentKind {
    /// Five open petals, set along the twigs.
    Blossom,
    /// A ball that hangs from the twig's end.
    Fruit,
}

/// The ornament of a species in a season.
#[derive(Debug, Clone, Copy)]
pub struct Ornament {
    /// What it is.
    pub kind: OrnamentKind,
    /// Diameter in metres.
    pub size_m: f32,
    /// Mean number on a leafy twig.
    pub per_twig: f32,
    /// sRGB colours between which single ones lie.
    pub colours: [[u8; 3]; 2],
}

/// The ornaments on the twigs of `leafage`, as leaves to be painted.
pub(super) fn ornaments(ornament: &Ornament, leafage: &Leafage, random: &mut Random) -> Vec<Leaf> {
    let mut made = Vec::new();
    for twig in &leafage.twigs {
        let whole = ornament.per_twig as u32;
        let more = random.unit() < f64::from(ornament.per_twig - whole as f32);
        for _ in 0..whole + u32::from(more) {
            let size = ornament.size_m * random.between(0.8, 1.15) as f32;
            let at = match ornament.kind {
                OrnamentKind::Blossom => twig.from.lerp(twig.to, random.unit() as f32),
                OrnamentKind::Fruit => twig.from.lerp(twig.to, 0.8) - Vec3::Y * 0.6 * size,
            };
            made.push(one(ornament.kind, at, size, random));
        }
    }
    made
}

fn one(kind: OrnamentKind, at: Vec3, size: f32, random: &mut Random) -> Leaf {
    let tilt = match kind {
        OrnamentKind::Blossom => 0.8,
        OrnamentKind::Fruit => 0.0,
    };
    let normal = (Vec3::new(-0.1, 0.3, 1.0) + random_in_ball(random) * tilt).normalize_or(Vec3::Z);
    let along = (Vec3::NEG_Y + random_in_ball(random) * tilt).normalize_or(Vec3::X);
    let across = along.cross(normal).normalize_or(Vec3::X);
    let outward = Vec3::new(at.x, 0.0, at.z).normalize_or(Vec3::Z);
    Leaf {
        base: at - along * 0.5 * size + outward * 0.4 * size,
        along: along * size,
        across: across * size,
        normal,
        outward,
        tone: random.unit() as f32,
        light: 1.0,
    }
}
