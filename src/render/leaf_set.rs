//! What leaf crowns are drawn with: places in the unit ball, and pictures of twigs.

use super::leaf_atlas::LeafAtlas;
use crate::base::{Digest, Hasher, Seed};
use crate::branches::sprite::LeafShape;
use crate::crown::leaf_points;

/// Places of a set: six times those of the thesis, for close views.
pub(crate) const MOST_POINTS: usize = 2048;

/// Fronds of a palm.
pub(crate) const FRONDS: usize = 96;

/// Places and pictures of leaves, the same for all crowns of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafSet {
    /// In the unit ball, best prefix first; the fourth number is not used.
    pub(crate) points: Vec<[f32; 4]>,
    pub(crate) atlas: LeafAtlas,
    /// Whether each picture is a frond, which goes from the crown's heart to its surface.
    pub(crate) is_of_fronds: bool,
    pub(crate) digest: Digest,
}

impl LeafSet {
    /// A set with leaves of `shape`; takes about 60 ms. Blades make fronds.
    pub fn new(shape: LeafShape, seed: Seed) -> Self {
        let is_of_fronds = shape == LeafShape::Blade;
        let count = if is_of_fronds { FRONDS } else { MOST_POINTS };
        let place = |point: &glam::DVec3| [point.x as f32, point.y as f32, point.z as f32, 0.0];
        let points: Vec<[f32; 4]> = leaf_points(count, seed).iter().map(place).collect();
        let atlas = LeafAtlas::new(shape, seed);
        let digest = Hasher::new("boscage leaf set")
            .with(bytemuck::cast_slice(&points))
            .with(bytemuck::cast_slice(&atlas.texels(0)))
            .finish();
        Self {
            points,
            atlas,
            is_of_fronds,
            digest,
        }
    }
}

impl Default for LeafSet {
    /// Oval leaves, which most broad-leaved trees have.
    fn default() -> Self {
        Self::new(LeafShape::Ovate, Seed(0))
    }
}
