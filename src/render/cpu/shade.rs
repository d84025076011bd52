//! Light on a surface: `shaders/shared/shade.wgsl` on the processor.

use crate::render::frame::Frame;
use glam::Vec3;

/// A lit place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Colour, linear.
    pub(super) albedo: Vec3,
    /// Unit normal, world.
    pub(super) normal: Vec3,
    /// Share of the light from all around that arrives, 0 … 1.
    pub(super) open: f32,
    /// Share of the sun that arrives, 0 … 1.
    pub(super) sunlit: f32,
    /// Height in the crown, 0 … 1.
    pub(super) height: f32,
    /// Distance to the centre as a share of the smooth crown's radius in that direction.
    pub(super) depth: f32,
}

/// How far the sun reaches around a tuft of leaves: 0 for a smooth surface, 1 for fog.
const WRAP: f32 = 0.35;

/// The light that a place sends to the eye.
#[inline(always)]
pub(super) fn shaded(frame: &Frame, place: &Place) -> Vec3 {
    let upward = 0.5 + 0.5 * place.normal.y;
    let sky = Vec3::from(frame.ground) * (1.0 - upward) + Vec3::from(frame.sky) * upward;
    let facing = place.normal.dot(Vec3::from(frame.toward_sun));
    let wrapped = ((facing + WRAP) / (1.0 + WRAP)).max(0.0);
    let (open, sunlit) = if frame.occlusion == 0 {
        (place.open, place.sunlit)
    } else {
        let by_terms = terms(place);
        (by_terms, by_terms)
    };
    let light = sky * open + Vec3::from(frame.sun) * (wrapped * sunlit);
    place.albedo * light
}

/// Height and radial depth as a factor (thesis §5.3).
#[inline(always)]
fn terms(place: &Place) -> f32 {
    let height = 0.55 + 0.45 * place.height.clamp(0.0, 1.0);
    let depth = ((place.depth - 0.55) / 0.55).clamp(0.0, 1.0);
    height * (0.35 + 0.65 * depth * depth)
}
