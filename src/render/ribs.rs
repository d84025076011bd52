//! Long leaves that go out along a rib: fronds of palms, from the heart of the crown to its surface, and boughs
//! of conifers, from about the axis of the crown to its surface.
//!
//! Whoever draws them turns their pictures ([`super::leaf_pictures`]) along the rib, as long as it is, and bends
//! them by an arch.

use crate::branches::leaf_name::LeafName;
use glam::Vec3;

/// Fronds of a palm.
const FRONDS: usize = 96;
/// Boughs of a conifer.
const BOUGHS: usize = 1536;

/// Width of fronds and boughs by their length.
pub(super) const FROND_SLENDER: f32 = 0.36;
pub(super) const BOUGH_SLENDER: f32 = 0.4;

/// Height of the arch, as a share of how far a rib reaches aside.
const FROND_ARCH: f32 = 0.21;
const BOUGH_ARCH: f32 = 0.09;

/// How boughs rise, by how far they reach aside, at the foot of the crown and at its top: those below hang.
const RISES: [f32; 2] = [-0.3, 0.95];
/// How far below the surface the boughs next to the top leave the axis, in mean radii: they are the leader.
const LEADER: f32 = 0.45;

/// Share of a bough, from the axis, that is hidden and not drawn.
const HIDDEN: f32 = 0.4;

/// How much wider long leaves are at most where there are fewer.
pub(crate) const WIDEST: f64 = 1.6;
/// Share of a bough's width that all boughs of a crown have.
pub(crate) const EVEN: f64 = 0.18;
/// How much less far from the axis the innermost boughs reach.
pub(crate) const INNER: f64 = 0.4;

/// How many tiers boughs stand in between the foot of a crown and its top, and how near to them halfway up:
/// those next to the top and the foot are not to leave a gap.
const TIERS: f32 = 15.0;
const TIERED: f32 = 0.6;

/// Long leaves of a kind.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Ribs {
    pub(crate) from: RibsFrom,
    /// Leaves that are to be had.
    pub(crate) count: usize,
    /// Width by length.
    pub(crate) slender: f32,
    /// Height of the arch by how far a rib reaches aside.
    pub(crate) arch: f32,
}

/// Where ribs begin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(crate) enum RibsFrom {
    /// At the centre of the crown.
    Heart = 1,
    /// Next to the crown's axis, at any height.
    Axis = 2,
}

impl Ribs {
    /// Those of `leaf`, if it is long.
    pub(crate) fn of(leaf: LeafName) -> Option<Self> {
        match leaf {
            LeafName::Frond => Some(Self {
                from: RibsFrom::Heart,
                count: FRONDS,
                slender: FROND_SLENDER,
                arch: FROND_ARCH,
            }),
            LeafName::Bough => Some(Self {
                from: RibsFrom::Axis,
                count: BOUGHS,
                slender: BOUGH_SLENDER,
                arch: BOUGH_ARCH,
            }),
            _ => None,
        }
    }
}

/// Where the bough whose tip is at `tip` begins, from the centre of the crown, which reaches `radius` at most and
/// `mean_radius` on the average.
#[inline(always)]
pub(crate) fn bough_root(tip: Vec3, radius: f32, mean_radius: f32) -> Vec3 {
    let height = (tip.y / radius).clamp(-1.0, 1.0);
    let rise = RISES[0] + (RISES[1] - RISES[0]) * (0.5 + 0.5 * height);
    let aside = (tip.x * tip.x + tip.z * tip.z).sqrt();
    let upper = height.max(0.0);
    let below = aside * rise + LEADER * mean_radius * (upper * upper);
    let axis = Vec3::new(0.0, tip.y - below, 0.0);
    axis + (tip - axis) * HIDDEN
}

/// The unit vector along `point`, drawn towards the tier it is next to.
pub(crate) fn in_tiers(point: Vec3) -> Vec3 {
    let direction = point * (1.0 / point.dot(point).sqrt().max(1e-6));
    let step = 2.0 / TIERS;
    let tier = (libm::floorf((direction.y + 1.0) / step) + 0.5) * step - 1.0;
    let near = TIERED * (1.0 - direction.y * direction.y);
    let height = direction.y + (tier - direction.y) * near;
    let aside = (direction.x * direction.x + direction.z * direction.z).sqrt();
    let wide = (1.0 - height * height).max(0.0).sqrt() / aside.max(1e-6);
    Vec3::new(direction.x * wide, height, direction.z * wide)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boughs_hang_below_and_rise_above_and_have_a_leader() {
        let root = |x: f32, y: f32| bough_root(Vec3::new(x, y, 0.0), 2.0, 1.5).y;
        assert!(root(1.0, -1.8) > -1.8);
        assert!(root(1.0, 1.5) < 1.2);
        assert!(root(0.0, 2.0) < 1.75);
        let within = bough_root(Vec3::new(0.6, 0.1, 0.8), 2.0, 1.5);
        assert!((within.x - 0.6 * HIDDEN).abs() < 1e-6);
    }

    #[test]
    fn points_in_tiers_keep_their_turn_and_stand_closer() {
        let mut between = 0;
        for i in 0..200 {
            let (turn, y) = (i as f32 * 2.4, i as f32 / 100.0 - 0.995);
            let wide = (1.0 - y * y).sqrt();
            let point = Vec3::new(libm::cosf(turn) * wide, y, libm::sinf(turn) * wide);
            let tiered = in_tiers(point * 0.7);
            assert!((tiered.dot(tiered) - 1.0).abs() < 1e-5);
            let turned = tiered.x * point.z - tiered.z * point.x;
            assert!(turned.abs() < 1e-5, "{turned}");
            let step = 2.0 / TIERS;
            let within = (tiered.y + 1.0) / step;
            between += usize::from((within - within.floor() - 0.5).abs() > 0.25);
        }
        // Half of them without tiers.
        assert!((10..70).contains(&between), "{between}");
    }
}
