//! The shadow of a crown on the ground: `shaders/ground.wgsl` on the processor.

use super::{Band, Drawn};
use crate::render::frame::Frame;
use glam::Vec3;

/// The lowest sun that casts a shadow, as a sine.
const LOWEST: f32 = 0.12;
/// How far the ground beneath the crown is darker, in radii.
const BENEATH: f32 = 1.7;
/// Most steps through the crown.
const STEPS: u32 = 20;

/// Darkens the ground of a band.
pub(super) fn draw(frame: &Frame, drawn: &Drawn<'_>, band: &mut Band<'_>) {
    let (instance, numbers) = (&drawn.instance, &drawn.numbers);
    let ground = instance.center[1] - numbers.center_height * instance.scale;
    if frame.view != 0 || frame.backdrop == 0 || frame.eye[1] <= ground {
        return;
    }
    for y in band.rows.0..band.rows.1 {
        for x in 0..band.width {
            let ray = frame.ray(x as f32 + 0.5, y as f32 + 0.5);
            let distance = (ground - frame.eye[1]) / ray.y;
            if distance <= 0.0 || !distance.is_finite() {
                continue;
            }
            let world = Vec3::from(frame.eye) + ray * distance - Vec3::from(instance.center);
            if is_near(frame, drawn, world) {
                band.darken(x, y, left(frame, drawn, world));
            }
        }
    }
}

/// Whether a place of the ground, from the crown's centre, lies in the rectangle that is drawn.
fn is_near(frame: &Frame, drawn: &Drawn<'_>, world: Vec3) -> bool {
    let most = drawn.numbers.radius_range[1] * drawn.instance.scale;
    let high = drawn.numbers.center_height * drawn.instance.scale;
    let rise = frame.toward_sun[1].max(LOWEST);
    let (sun_x, sun_z) = (frame.toward_sun[0], frame.toward_sun[2]);
    let length = (sun_x * sun_x + sun_z * sun_z).sqrt();
    let (along_x, along_z) = (sun_x / length.max(1e-6), sun_z / length.max(1e-6));
    let shift = -length / rise * high;
    let forth = world.x * along_x + world.z * along_z;
    let aside = world.z * along_x - world.x * along_z;
    let low = (-BENEATH * most).min(shift - most / rise);
    let end = (BENEATH * most).max(shift + most / rise);
    (low..end).contains(&forth) && aside.abs() < BENEATH * most
}

/// The share of the ground's light that is left at a place, from the crown's centre.
fn left(frame: &Frame, drawn: &Drawn<'_>, world: Vec3) -> f32 {
    let numbers = &drawn.numbers;
    let point = drawn.instance.local(world) * (1.0 / drawn.instance.scale);
    let (most, mean) = (numbers.radius_range[1], numbers.mean_radius);
    let lit = if frame.toward_sun[1] >= LOWEST {
        let toward = drawn.instance.local(Vec3::from(frame.toward_sun));
        sun_below(frame, drawn, point, toward).min(sun_beside_stem(drawn, point, toward))
    } else {
        1.0
    };
    let flat = (point.x * point.x + point.z * point.z).sqrt();
    let window = ((BENEATH - flat / most) / (BENEATH - 0.8)).clamp(0.0, 1.0);
    let far = point.dot(point);
    let covered = (mean * mean * numbers.center_height / (far * far.sqrt())).min(1.0) * window;
    let foot = flat / (0.09 * mean);
    let beside = window / (1.0 + foot * foot);
    (1.0 - 0.52 * (1.0 - lit)) * (1.0 - 0.45 * covered) * (1.0 - 0.5 * beside)
}

/// The share of the sun that reaches a point of the crown's frame below the crown.
fn sun_below(frame: &Frame, drawn: &Drawn<'_>, point: Vec3, toward: Vec3) -> f32 {
    let most = drawn.numbers.radius_range[1];
    let level = (drawn.numbers.radius_levels - 1).min(1);
    let along = point.dot(toward);
    let nearest = point - toward * along;
    let room = most * most - nearest.dot(nearest);
    let half = room.max(0.0).sqrt();
    let start = (-along - half).max(0.0);
    let end = half - along;
    if room <= 0.0 || end <= start {
        return 1.0;
    }
    let mut lit = 1.0f32;
    let steps = (2 * frame.shadow_steps).clamp(4, STEPS);
    for i in 0..steps {
        let distance = start + (end - start) * ((i as f32 + 0.5) / steps as f32);
        let there = point + toward * distance;
        let above = there.dot(there).sqrt() - drawn.crown.radius.sampled(there, level);
        let width = 0.05 * distance + 0.02 * most;
        lit = lit.min((0.5 + above / width).clamp(0.0, 1.0));
    }
    lit
}

/// The share of the sun that the stem lets by: from how near the way to the sun comes to its axis.
fn sun_beside_stem(drawn: &Drawn<'_>, point: Vec3, toward: Vec3) -> f32 {
    let [x, y, z, radius] = drawn.numbers.stem;
    if radius <= 0.0 {
        return 1.0;
    }
    // The axis goes from the foot to the centre, the origin.
    let foot = Vec3::new(x, y, z);
    let high = foot.dot(foot);
    let from_foot = point - foot;
    let slant = -toward.dot(foot);
    let up = -foot.dot(from_foot);
    let ahead = toward.dot(from_foot);
    let room = (high - slant * slant).max(1e-4 * high);
    let along = (slant * up - high * ahead) / room;
    let share = ((up + slant * along) / high).clamp(0.0, 1.0);
    let axis = foot * (1.0 - share);
    let distance = (axis - point).dot(toward).max(0.0);
    let apart = point + toward * distance - axis;
    let thick = radius * (1.0 - 0.5 * share);
    let width = 0.02 * distance + 0.3 * radius;
    (0.5 + (apart.dot(apart).sqrt() - thick) / width).clamp(0.0, 1.0)
}
