//! The ground: grass blade by blade, a street, and the shadow that ties the tree to it.

use super::Scene;
use super::frame::Frame;
use super::shown;
use crate::branches::noise::{noise3, ramp};
use crate::branches::tree::{GrownTree, Tree};
use crate::raster::{Image, row_ends};
use glam::Vec3;

/// Length of the longest grass in metres.
const GRASS_M: f32 = 0.16;

/// Distance behind the tree up to which single blades are drawn, against that of the tree.
const BLADES_TO: f32 = 0.9;

/// Where a street begins and ends behind the tree, in metres.
const STREET_M: (f32, f32) = (3.2, 9.8);

/// The tree's shadow on the ground: its picture, thrown along the sun's rays.
pub(super) struct Shadow {
    alpha: Image<u8>,
    pixels_of_metre: f32,
    distance_m: f32,
    to_sun: Vec3,
    /// Half the width of the crown in metres.
    half_m: f32,
}

impl Shadow {
    pub(super) fn new(picture: &GrownTree, tree: &Tree, scene: &Scene) -> Self {
        let extent = tree.extent_m();
        Self {
            alpha: picture.image.map(|pixel| pixel.alpha()),
            pixels_of_metre: picture.pixels_of_metre,
            distance_m: scene.distance_m,
            to_sun: scene.sky.daylight.to_sun,
            half_m: 0.5 * (extent.y - extent.x),
        }
    }

    /// Share of the sun, 0..1, that reaches the ground at `x`, `away_m` off.
    fn sun(&self, x: f32, away_m: f32) -> f32 {
        // The crown as a disc facing the sun's azimuth: each ray meets it where it passes the stem.
        let flat = Vec3::new(self.to_sun.x, 0.0, self.to_sun.z).normalize_or(Vec3::Z);
        let along = x * flat.x + (self.distance_m - away_m) * flat.z;
        let across = x * flat.z - (self.distance_m - away_m) * flat.x;
        if along > 0.15 * self.half_m {
            return 1.0;
        }
        let level = (1.0 - self.to_sun.y * self.to_sun.y).sqrt().max(0.05);
        let height = -along * self.to_sun.y / level;
        let soft = 0.04 + 0.02 * height;
        let mut hidden = 0.0;
        for (dx, dy) in [
            (0.0, 0.0),
            (1.0, 0.4),
            (-1.0, -0.4),
            (0.4, -1.0),
            (-0.4, 1.0),
        ] {
            hidden += self.cover(across + dx * soft, height + dy * soft);
        }
        1.0 - 0.2 * hidden
    }

    /// Share of the sky, 0..1, that the tree leaves free over the ground.
    fn sky(&self, x: f32, away_m: f32) -> f32 {
        let dz = away_m - self.distance_m;
        let out = (x * x + dz * dz).sqrt();
        let under = ramp(1.15 * self.half_m, 0.25 * self.half_m, out);
        let stem = ramp(0.9, 0.1, out);
        (1.0 - 0.42 * under) * (1.0 - 0.45 * stem)
    }

    fn cover(&self, x: f32, y: f32) -> f32 {
        let column = 0.5 * self.alpha.width() as f32 + x * self.pixels_of_metre;
        let row = self.alpha.height() as f32 - y * self.pixels_of_metre;
        let alpha = self
            .alpha
            .get(libm::floorf(column) as i64, libm::floorf(row) as i64);
        f32::from(alpha.unwrap_or(0)) / 255.0
    }

    /// Linear light that falls on level ground.
    fn light(&self, scene: &Scene, x: f32, away_m: f32) -> Vec3 {
        let daylight = &scene.sky.daylight;
        let sun = self.sun(x, away_m) * daylight.to_sun.y.max(0.0);
        daylight.sun * sun + daylight.sky * (0.9 * self.sky(x, away_m))
    }
}

/// Rows of the picture that grass in front of the tree's foot may cover.
pub(super) fn grass_px(scene: &Scene) -> f32 {
    0.6 * GRASS_M * scene.camera.focal_px / scene.distance_m
}

/// Reflectance of grass at a place, linear.
fn turf(scene: &Scene, x: f32, away_m: f32) -> Vec3 {
    let salt = scene.seed.derive("turf", 0).0 as u32;
    let wide = noise3(x * 0.11, away_m * 0.11, 0.0, salt);
    let patch = noise3(x * 0.7, away_m * 0.7, 1.0, salt);
    let fine = noise3(x * 5.0, away_m * 5.0, 2.0, salt);
    let dry = ramp(-0.1, 0.75, 0.6 * wide + 0.5 * patch);
    let green = Vec3::new(0.060, 0.098, 0.026);
    let straw = Vec3::new(0.150, 0.140, 0.055);
    green.lerp(straw, 0.6 * dry) * (1.0 + 0.25 * patch + 0.22 * fine)
}

/// Whether a place belongs to the street, and how far into it, in metres.
fn street(scene: &Scene, away_m: f32) -> f32 {
    let behind_m = away_m - scene.distance_m;
    (behind_m - STREET_M.0).min(STREET_M.1 - behind_m)
}

/// Paints all ground, without the tree's shadow.
pub(super) fn paint_far(frame: &mut Frame, scene: &Scene) {
    let daylight = &scene.sky.daylight;
    let light = daylight.sun * daylight.to_sun.y.max(0.0) + daylight.sky * 0.9;
    let start = libm::ceilf(scene.camera.horizon_px).max(0.0) as usize;
    for y in start..frame.height {
        for x in 0..frame.width {
            let (at, away_m) = scene.camera.ground(x as f32 + 0.5, y as f32 + 0.5);
            frame.pixels[y * frame.width + x] = ground(scene, at, away_m, light);
        }
    }
}

/// Paints the ground around the tree anew, in its shadow and in focus, up to what stands behind it.
pub(super) fn paint_near(frame: &mut Frame, scene: &Scene, shadow: &Shadow) {
    let start = libm::ceilf(scene.camera.horizon_px).max(0.0) as usize;
    for y in start..frame.height {
        let away_m = scene.camera.ground(0.0, y as f32 + 0.5).1;
        let share = ramp(scene.clear_m, 0.8 * scene.clear_m, away_m);
        if share <= 0.0 {
            continue;
        }
        for x in 0..frame.width {
            let (at, away_m) = scene.camera.ground(x as f32 + 0.5, y as f32 + 0.5);
            let colour = ground(scene, at, away_m, shadow.light(scene, at, away_m));
            frame.blend(x as i64, y as i64, colour, share);
        }
    }
}

/// The shown colour of the ground at a place, with `light` on it.
fn ground(scene: &Scene, x: f32, away_m: f32, light: Vec3) -> Vec3 {
    let into = street(scene, away_m);
    let albedo = if scene.with_street && into > 0.0 {
        paving(x, away_m, into, scene.seed.0 as u32)
    } else {
        turf(scene, x, away_m) * 0.8
    };
    scene.sky.through_air(shown(albedo * light), away_m)
}

/// Reflectance of a street `into` metres from its edge: kerb, then asphalt.
fn paving(x: f32, away_m: f32, into: f32, salt: u32) -> Vec3 {
    let grain = noise3(x * 14.0, away_m * 14.0, 0.0, salt);
    let stain = noise3(x * 0.5, away_m * 0.9, 1.0, salt);
    if into < 0.16 {
        let stone = noise3(libm::floorf(x), 3.0, 0.0, salt);
        return Vec3::new(0.27, 0.26, 0.24) * (1.0 + 0.15 * stone + 0.1 * grain);
    }
    Vec3::new(0.105, 0.105, 0.108) * (1.0 + 0.14 * grain + 0.2 * stain)
}

/// Draws blades of grass behind the stem's foot, or before it.
pub(super) fn paint_grass(frame: &mut Frame, scene: &Scene, shadow: &Shadow, behind: bool) {
    let camera = &scene.camera;
    let name = if behind {
        "grass behind"
    } else {
        "grass before"
    };
    let mut random = scene.seed.derive(name, 0).random();
    let lawn_m = if scene.with_street {
        STREET_M.0
    } else {
        BLADES_TO * scene.distance_m
    };
    let far_m = (scene.distance_m + lawn_m).min(scene.clear_m);
    let far_row = camera.pixel(0.0, 0.0, far_m).1;
    let (top, bottom) = if behind {
        (far_row, scene.foot.1)
    } else {
        (scene.foot.1, frame.height as f32 + 24.0)
    };
    let area = (bottom - top).max(0.0) * frame.width as f32;
    let count = (area / 5.0) as u32;
    for blade in 0..count {
        // From far to near, row by row.
        let row = top + (bottom - top) * (blade as f32 + random.unit() as f32) / count as f32;
        let column = random.unit() as f32 * frame.width as f32;
        let (x, away_m) = camera.ground(column, row);
        let long_m = GRASS_M * random.between(0.25, 1.0) as f32;
        let lean = random.between(-0.6, 0.6) as f32;
        let albedo = turf(scene, x, away_m) * random.between(0.75, 1.75) as f32;
        let glow = Vec3::new(1.05, 1.0, 0.85);
        let light = shadow.light(scene, x, away_m) * glow;
        let colour = scene.sky.through_air(shown(albedo * light), away_m);
        draw_blade(
            frame,
            (column, row),
            long_m * camera.focal_px / away_m,
            lean,
            colour,
        );
    }
}

/// Draws the taller grass that no mower reaches, around the foot of the stem.
pub(super) fn paint_tuft(frame: &mut Frame, scene: &Scene, shadow: &Shadow) {
    let mut random = scene.seed.derive("tuft", 0).random();
    let alpha = &shadow.alpha;
    let foot = alpha.row(alpha.height() - 1);
    let Some([left, right]) = row_ends(foot, |&a| a > 127) else {
        return;
    };
    let start = scene.foot.0 - 0.5 * alpha.width() as f32;
    let middle = start + 0.5 * (left + right) as f32;
    let half = 0.5 * (right - left) as f32 + 2.0;
    let scale = scene.camera.focal_px / scene.distance_m;
    let count = (9.0 * half) as u32 + 20;
    for blade in 0..count {
        let aside = random.between(-1.0, 1.0) as f32 + random.between(-0.45, 0.45) as f32;
        // The foot is round: its middle stands nearer than its edges.
        let near = 0.22 * half * (1.0 - aside * aside).max(-0.6);
        let row = scene.foot.1 + near + 0.05 * half * (blade as f32 / count as f32);
        let column = middle + aside * half;
        let (x, away_m) = scene.camera.ground(column, row);
        let long_m = GRASS_M * random.between(0.5, 1.5) as f32;
        let albedo = turf(scene, x, away_m) * random.between(0.7, 1.6) as f32;
        let light = shadow.light(scene, x, away_m);
        let colour = scene.sky.through_air(shown(albedo * light), away_m);
        let lean = random.between(-0.7, 0.7) as f32;
        draw_blade(frame, (column, row), long_m * scale, lean, colour);
    }
}

/// A blade from `foot`, `long` pixels high, darker at its foot, thin at its tip.
fn draw_blade(frame: &mut Frame, foot: (f32, f32), long: f32, lean: f32, colour: Vec3) {
    let rows = libm::ceilf(long) as i64;
    let width = (0.085 * long).clamp(0.55, 2.6);
    for step in 0..rows {
        let t = step as f32 / rows as f32;
        let x = foot.0 + lean * long * t * t;
        let y = foot.1 as i64 - step;
        let thick = width * (1.0 - 0.8 * t);
        let shade = colour * (0.62 + 0.5 * t);
        let left = x - 0.5 * thick;
        let mut column = libm::floorf(left);
        while column < left + thick {
            let share = (column + 1.0).min(left + thick) - column.max(left);
            frame.blend(column as i64, y, shade, share);
            column += 1.0;
        }
    }
}
