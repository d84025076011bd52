//! What leaf crowns are drawn with: places in the unit ball, and pictures of twigs.

use super::leaf_atlas::LeafAtlas;
use super::ribs::{Ribs, RibsFrom, in_tiers};
use crate::base::{Digest, Hasher, Seed};
use crate::branches::leaf_name::LeafName;
use crate::crown::leaf_points;
use glam::Vec3;

/// Places of a set: six times those of the thesis, for close views.
pub(crate) const MOST_POINTS: usize = 2048;

/// Places and pictures of leaves, the same for all crowns of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafSet {
    /// In the unit ball, best prefix first; the fourth number is not used.
    pub(crate) points: Vec<[f32; 4]>,
    pub(crate) atlas: LeafAtlas,
    /// How leaves go out along ribs, if they do.
    pub(crate) ribs: Option<Ribs>,
    pub(crate) digest: Digest,
}

impl LeafSet {
    /// The set of `leaf`; takes about 60 ms, with thin leaves 250 ms.
    pub fn new(leaf: LeafName, seed: Seed) -> Self {
        let ribs = Ribs::of(leaf);
        let count = ribs.map_or(MOST_POINTS, |ribs| ribs.count);
        let is_tiered = ribs.is_some_and(|ribs| ribs.from == RibsFrom::Axis);
        let place = |point: &glam::DVec3| {
            let point = point.as_vec3();
            let Vec3 { x, y, z } = if is_tiered { in_tiers(point) } else { point };
            [x, y, z, 0.0]
        };
        let points: Vec<[f32; 4]> = leaf_points(count, seed).iter().map(place).collect();
        let atlas = LeafAtlas::new(leaf, seed);
        let digest = Hasher::new("boscage leaf set")
            .with(bytemuck::cast_slice(&points))
            .with(bytemuck::cast_slice(&atlas.texels(0)))
            .finish();
        Self {
            points,
            atlas,
            ribs,
            digest,
        }
    }
}

impl Default for LeafSet {
    /// Oval leaves, which most broad-leaved trees have.
    fn default() -> Self {
        Self::new(LeafName::Ovate, Seed(0))
    }
}
