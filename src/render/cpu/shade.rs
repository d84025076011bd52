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
    /// Unit vector from the eye.
    pub(super) ray: Vec3,
    /// 1 for leaves, 0 for what no light passes.
    pub(super) thin: f32,
}

/// How far the sun reaches around a tuft of leaves: 0 for a smooth surface, 1 for fog.
const WRAP: f32 = 0.35;

/// The tint of light that a leaf lets through: chlorophyll takes the blue.
const PASSED: Vec3 = Vec3::new(1.15, 1.25, 0.45);
/// How far that light reaches around to the side of the sun.
const PASSED_WRAP: f32 = 0.25;
/// The share of it that goes everywhere; the rest goes on as the sun shone, towards an eye that
/// looks into the sun.
const PASSED_EVEN: f32 = 0.15;
/// How strong it is: above 1.5 the rim of a back-lit crown burns out.
const PASSED_STRENGTH: f32 = 1.1;

/// The light that a place sends to the eye.
#[inline(always)]
pub(super) fn shaded(frame: &Frame, place: &Place) -> Vec3 {
    let upward = 0.5 + 0.5 * place.normal.y;
    let sky = Vec3::from(frame.ground) * (1.0 - upward) + Vec3::from(frame.sky) * upward;
    let facing = place.normal.dot(Vec3::from(frame.toward_sun));
    let wrapped = ((facing + WRAP) / (1.0 + WRAP)).max(0.0);
    let sun = Vec3::from(frame.sun);
    if frame.occlusion != 0 {
        let share = terms(place);
        return place.albedo * (sky * share + sun * (wrapped * share));
    }
    let light = sky * place.open + sun * (wrapped * place.sunlit);
    place.albedo * (light + passed(frame, place, facing))
}

/// The light of the sun that comes through leaves from behind.
#[inline(always)]
fn passed(frame: &Frame, place: &Place, facing: f32) -> Vec3 {
    let behind = ((PASSED_WRAP - facing) / (1.0 + PASSED_WRAP)).max(0.0);
    let ahead = place.ray.dot(Vec3::from(frame.toward_sun)).max(0.0);
    let lobe = PASSED_EVEN + (1.0 - PASSED_EVEN) * (ahead * ahead * ahead);
    let strength = PASSED_STRENGTH * place.thin * (behind * lobe * place.sunlit.sqrt());
    PASSED * Vec3::from(frame.sun) * strength
}

/// Height and radial depth as a factor (thesis §5.3).
#[inline(always)]
fn terms(place: &Place) -> f32 {
    let height = 0.55 + 0.45 * place.height.clamp(0.0, 1.0);
    let depth = ((place.depth - 0.55) / 0.55).clamp(0.0, 1.0);
    height * (0.35 + 0.65 * depth * depth)
}
