//! The sky: paler towards the horizon and the sun, with clouds in layers.

use super::Scene;
use super::frame::Frame;
use crate::branches::light::Daylight;
use crate::branches::noise::{noise3, ramp};
use glam::Vec3;

/// The sky over a scene.
pub(super) struct Sky {
    pub(super) daylight: Daylight,
    softness: f32,
}

impl Sky {
    pub(super) fn new(daylight: Daylight, softness: f32) -> Self {
        Self { daylight, softness }
    }

    /// Colour of the air in the distance, sRGB.
    pub(super) fn haze(&self) -> Vec3 {
        Vec3::new(188.0, 203.0, 219.0).lerp(Vec3::new(208.0, 212.0, 216.0), self.softness)
    }

    /// Colour of what is `away_m` off: aerial perspective.
    pub(super) fn through_air(&self, colour: Vec3, away_m: f32) -> Vec3 {
        colour.lerp(self.haze(), 1.0 - libm::expf(-away_m / 900.0))
    }

    /// The clear sky at the sine `up` of the height above the horizon.
    fn clear(&self, up: f32) -> Vec3 {
        let zenith =
            Vec3::new(92.0, 137.0, 192.0).lerp(Vec3::new(150.0, 168.0, 190.0), self.softness);
        let low = Vec3::new(205.0, 219.0, 232.0);
        let share = 1.0 - libm::expf(-3.2 * up.max(0.0));
        low.lerp(zenith, share)
    }
}

/// Paints the sky over the whole frame.
pub(super) fn paint(frame: &mut Frame, scene: &Scene) {
    let salt = scene.seed.derive("clouds", 0).0 as u32;
    let camera = &scene.camera;
    let cover = 0.06 - 0.45 * scene.sky.softness;
    for y in 0..frame.height {
        let up = (camera.horizon_px - y as f32) / camera.focal_px;
        for x in 0..frame.width {
            let aside = (x as f32 - camera.middle_px) / camera.focal_px;
            let mut colour = scene.sky.clear(up / (1.0 + up * up).sqrt());
            if up > 0.0 {
                // Clouds lie on a plane far above: they grow small towards the horizon.
                let far = 1.0 / (up + 0.16);
                let (u, v) = (aside * far * 1.5, far * 1.9);
                let thick = clouds(u, v, salt);
                let share = ramp(cover, cover + 0.42, thick) * ramp(0.0, 0.10, up);
                let lit = clouds(u - 0.10, v - 0.10, salt);
                let under = ramp(0.0, 0.55, thick + 1.6 * (thick - lit));
                let grey = 249.0 - 44.0 * under;
                let cloud = Vec3::new(grey, grey + 1.0, grey + 4.0).min(Vec3::splat(250.0));
                colour = colour.lerp(cloud, 0.88 * share);
            }
            frame.pixels[y * frame.width + x] = colour;
        }
    }
}

/// Thickness of the clouds, about −0.7..0.7.
fn clouds(u: f32, v: f32, salt: u32) -> f32 {
    let mut sum = 0.0;
    let mut weight = 0.5;
    let mut scale = 0.55;
    for octave in 0..6u32 {
        sum += weight * noise3(u * scale, v * scale, octave as f32 * 3.7, salt);
        weight *= 0.55;
        scale *= 2.1;
    }
    sum
}
