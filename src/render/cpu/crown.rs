//! The crown as all passes read it: `shaders/shared/crown.wgsl` on the processor.

use super::Drawn;
use crate::render::color::linear_table;
use crate::render::frame::{CrownNumbers, Frame};
use crate::render::packed_cube::PackedCube;
use glam::Vec3;
use std::sync::LazyLock;

static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(linear_table);

/// The level, as a number, at which a sample has a texel at least.
#[inline(always)]
pub(super) fn level_for(size: u32, levels: u32, radius_samples: f32) -> f32 {
    // A face spans a quarter turn: π/2 of the radius.
    let texels = size as f32 * std::f32::consts::FRAC_2_PI / radius_samples;
    libm::log2f(texels.max(1.0)).min((levels - 1) as f32)
}

/// The radius of a crown in samples, seen from its surface rather than its centre; `eye` in the
/// frame of the crown.
#[inline(always)]
pub(super) fn radius_in_samples(frame: &Frame, crown: &CrownNumbers, eye: Vec3) -> f32 {
    let most = crown.radius_range[1];
    let distance = (eye.dot(eye).sqrt() - most * 0.5).max(most * 0.05);
    most / (distance * frame.sample_size)
}

/// The level of smooth shape, without leaves.
#[inline(always)]
pub(super) fn smooth_level(crown: &CrownNumbers) -> u32 {
    crown.radius_levels.max(2) - 2
}

/// Linear colour and openness in a direction between levels.
#[inline(always)]
pub(super) fn surface_between(
    surface: &PackedCube<[u8; 4]>,
    direction: Vec3,
    level: f32,
) -> (Vec3, f32) {
    let whole = level as u32;
    let (near_color, near_open) = surface_at(surface, direction, whole);
    let next = (whole + 1).min(surface.levels() - 1);
    let (far_color, far_open) = surface_at(surface, direction, next);
    let share = level - whole as f32;
    (
        near_color + (far_color - near_color) * share,
        near_open + (far_open - near_open) * share,
    )
}

/// Linear colour and openness at a level, bilinear.
#[inline(always)]
pub(super) fn surface_at(
    surface: &PackedCube<[u8; 4]>,
    direction: Vec3,
    level: u32,
) -> (Vec3, f32) {
    let (texels, right, down) = surface.around(direction, level);
    let table = &*LINEAR;
    let lights = texels
        .map(|[r, g, b, _]| Vec3::new(table[r as usize], table[g as usize], table[b as usize]));
    let opens = texels.map(|texel| f32::from(texel[3]) / 255.0);
    let upper = lights[0] + (lights[1] - lights[0]) * right;
    let lower = lights[2] + (lights[3] - lights[2]) * right;
    let upper_open = opens[0] + (opens[1] - opens[0]) * right;
    let lower_open = opens[2] + (opens[3] - opens[2]) * right;
    (
        upper + (lower - upper) * down,
        upper_open + (lower_open - upper_open) * down,
    )
}

/// The share of the sun, 0 … 1, that reaches a point of the crown's frame through the crown.
///
/// Points further along the way to the sun may be deeper below the surface before they shade all:
/// the sun shines through leaves, and a penumbra widens.
#[inline(always)]
pub(super) fn sunlit_at(frame: &Frame, drawn: &Drawn<'_>, from: Vec3, level: u32) -> f32 {
    let toward = drawn.instance.local(Vec3::from(frame.toward_sun));
    let most = drawn.numbers.radius_range[1];
    let mut lit = 1.0f32;
    let mut distance = 0.03 * most;
    for _ in 0..frame.shadow_steps {
        let point = from + toward * distance;
        let out = point.dot(point).sqrt();
        if out > most {
            break;
        }
        let above = out - drawn.crown.radius.sampled(point, level);
        lit = lit.min((0.5 + above / (0.3 * distance)).clamp(0.0, 1.0));
        distance *= frame.shadow_growth;
    }
    lit
}
