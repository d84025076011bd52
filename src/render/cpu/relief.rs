//! The relief crown: `shaders/relief.wgsl` on the processor.
//!
//! A ray that comes nearer to the centre than R_max is followed from where it enters that sphere:
//! linear steps until a point lies inside the radius of its direction, then halvings. The search
//! ends where the ray enters the sphere of R_min, since everything in there is inside.

use super::crown::{level_for, radius_in_samples, smooth_level, sunlit_at, surface_between};
use super::dither::pattern;
use super::shade::{Place, shaded};
use super::{Band, Drawn};
use crate::render::frame::{Frame, InstanceNumbers};
use crate::render::surface::normal_from;
use glam::Vec3;

/// Distance of the corners of the icosahedron around the unit ball: without shortcuts rays are
/// marched through the ball around these.
const PROXY: f32 = 1.258_409;

/// Numbers of an instance that do not change from ray to ray.
struct March {
    /// The eye, in the frame of the crown, in its metres.
    eye: Vec3,
    /// Linear steps through the diameter.
    steps: f32,
    /// Level of the radius cubemap, and of the colours (with the share of the next).
    radius_level: u32,
    surface_level: f32,
}

/// What a ray found.
struct Hit {
    /// Along the ray, metres of the crown.
    distance: f32,
    /// From the centre of the crown.
    point: Vec3,
    /// Reads of the radius cubemap.
    reads: u32,
}

/// Draws an instance into a band.
pub(super) fn draw(frame: &Frame, drawn: &Drawn<'_>, band: &mut Band<'_>) {
    let Some((columns, rows)) = reach(frame, drawn, band) else {
        return;
    };
    let march = March::new(frame, drawn);
    let InstanceNumbers { fade, dither, .. } = drawn.instance;
    for y in rows.0..rows.1 {
        for x in columns.0..columns.1 {
            if pattern(x, y, dither) < fade {
                continue;
            }
            let world = frame.ray(x as f32 + 0.5, y as f32 + 0.5);
            let ray = drawn.instance.local(world);
            let Some(hit) = march.hit(frame, drawn, ray) else {
                continue;
            };
            let along = hit.distance * drawn.instance.scale * world.dot(Vec3::from(frame.forward));
            let depth = frame.near / along;
            if depth > 1.0 || !band.shows(x, y, depth) {
                continue;
            }
            let light = march.seen(frame, drawn, &hit, world);
            band.put(x, y, depth, [light.x, light.y, light.z, 1.0]);
        }
    }
}

/// Columns and rows of the band that the R_max sphere can reach: first, and one after the last.
fn reach(frame: &Frame, drawn: &Drawn<'_>, band: &Band<'_>) -> Option<((u32, u32), (u32, u32))> {
    let offset = Vec3::from(drawn.instance.center) - Vec3::from(frame.eye);
    let radius = drawn.numbers.radius_range[1] * drawn.instance.scale;
    let away = offset.dot(Vec3::from(frame.forward));
    if away < -radius {
        return None;
    }
    let all = ((0, band.width), band.rows);
    if away <= radius * 1.001 {
        return Some(all);
    }
    // The sphere lies within the cone of its corner box's nearest plane.
    let near = away - radius;
    let span = |axis: [f32; 3], tan: f32, size: f32| {
        let at = offset.dot(Vec3::from(axis));
        let ends = [at - radius, at + radius].map(|end| {
            let nearest = (end / near).abs().max((end / (away + radius)).abs());
            nearest.copysign(end) / tan
        });
        let low = ((ends[0] + 1.0) * 0.5 * size - 1.0).max(0.0);
        let high = ((ends[1] + 1.0) * 0.5 * size + 2.0).clamp(0.0, size);
        (low as u32, high as u32)
    };
    let columns = span(frame.right, frame.tan_x, frame.size[0]);
    let upward = span(frame.up, frame.tan_y, frame.size[1]);
    let height = frame.size[1] as u32;
    let rows = (
        band.rows.0.max(height.saturating_sub(upward.1)),
        band.rows.1.min(height - upward.0.min(height)),
    );
    (columns.0 < columns.1 && rows.0 < rows.1).then_some((columns, rows))
}

impl March {
    fn new(frame: &Frame, drawn: &Drawn<'_>) -> Self {
        let instance = &drawn.instance;
        let offset = Vec3::from(frame.eye) - Vec3::from(instance.center);
        let eye = instance.local(offset) * (1.0 / instance.scale);
        let radius_samples = radius_in_samples(frame, &drawn.numbers, eye);
        let steps =
            (radius_samples * frame.steps_a_sample).clamp(frame.least_steps, frame.most_steps);
        let finest = drawn.instance.finest_level;
        let level = |size, levels: u32| {
            let fitting = level_for(size, levels, radius_samples);
            fitting.max(finest.min((levels - 1) as f32))
        };
        Self {
            eye,
            // A coarse level has no detail to step over.
            steps: (steps / (1.0 + finest)).max(frame.least_steps),
            radius_level: level(drawn.numbers.radius_size, drawn.numbers.radius_levels) as u32,
            surface_level: level(drawn.numbers.surface_size, drawn.numbers.surface_levels),
        }
    }

    /// Where a ray of the crown's frame meets the surface first.
    #[inline(always)]
    fn hit(&self, frame: &Frame, drawn: &Drawn<'_>, ray: Vec3) -> Option<Hit> {
        let [least, most] = drawn.numbers.radius_range;
        let along = self.eye.dot(ray);
        let nearest = self.eye - ray * along;
        let aside = nearest.dot(nearest);
        let reach = if frame.shortcut == 0 {
            most * PROXY
        } else {
            most
        };
        let room = reach * reach - aside;
        if room < 0.0 {
            return None;
        }
        let half = room.sqrt();
        let start = (-along - half).max(0.0);
        let mut end = half - along;
        if end <= start {
            return None;
        }
        let core = least * least - aside;
        let meets_core = core > 0.0 && frame.shortcut != 0;
        if meets_core {
            end = end.min((-along - core.sqrt()).max(start));
        }
        let radius = &drawn.crown.radius;
        let inside = |distance: f32| {
            let point = self.eye + ray * distance;
            point.dot(point).sqrt() < radius.sampled(point, self.radius_level)
        };
        let mut reads = 0;
        let mut low = start;
        let mut high = end;
        if !(meets_core && frame.shortcut == 2) {
            let count = ((end - start) / (2.0 * most) * self.steps).ceil().max(4.0);
            let step = (end - start) / count;
            let mut found = false;
            for i in 1..=count as u32 {
                let distance = start + step * i as f32;
                reads += 1;
                if inside(distance) {
                    high = distance;
                    low = distance - step;
                    found = true;
                    break;
                }
            }
            if !found && !meets_core {
                return None;
            }
            if !found {
                low = end - step;
            }
        }
        for _ in 0..frame.halvings {
            let middle = 0.5 * (low + high);
            reads += 1;
            if inside(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let distance = 0.5 * (low + high);
        Some(Hit {
            distance,
            point: self.eye + ray * distance,
            reads,
        })
    }

    /// What the eye sees of a hit: light, or what the debug view shows.
    fn seen(&self, frame: &Frame, drawn: &Drawn<'_>, hit: &Hit, ray: Vec3) -> Vec3 {
        let radius = &drawn.crown.radius;
        let distance = hit.point.dot(hit.point).sqrt();
        let direction = hit.point * (1.0 / distance);
        let normal_local = normal_from(radius, direction, distance, self.radius_level);
        let normal_world = drawn.instance.world(normal_local);
        match frame.view {
            1 => return Vec3::splat(hit.reads as f32 / (frame.most_steps + frame.halvings as f32)),
            2 => return normal_world * 0.5 + Vec3::splat(0.5),
            3 => return Vec3::splat(1.0 / (1.0 + hit.distance * drawn.instance.scale)),
            4 => {
                let error = (distance - radius.sampled(direction, self.radius_level)).abs();
                return Vec3::splat(error * 100.0 / drawn.numbers.radius_range[1]);
            }
            _ => {}
        }
        let (albedo, open) = surface_between(&drawn.crown.surface, direction, self.surface_level);
        let most = drawn.numbers.radius_range[1];
        let from = hit.point + normal_local * (0.02 * most);
        let shadow_level = (self.radius_level + 1).min(drawn.numbers.radius_levels - 1);
        shaded(
            frame,
            &Place {
                albedo: albedo * Vec3::from(drawn.instance.tint),
                normal: normal_world,
                open,
                sunlit: sunlit_at(frame, drawn, from, shadow_level),
                height: 0.5 + 0.5 * hit.point.y / most,
                depth: if frame.occlusion == 0 {
                    1.0
                } else {
                    distance / radius.sampled(direction, smooth_level(&drawn.numbers))
                },
                ray,
                thin: 1.0,
            },
        )
    }
}
