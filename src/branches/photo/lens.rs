//! What a lens and a sensor do to a picture: softness, dark corners, noise.

use super::Scene;
use super::frame::Frame;
use crate::base::Random;
use glam::Vec3;

/// Turns the painted frame into what a small camera would have kept.
pub(super) fn expose(frame: &mut Frame, scene: &Scene) {
    let unit = frame.height.max(frame.width) as f32 / 1440.0;
    frame.blur(0.62 * unit.max(0.6));
    darken_corners(frame);
    add_noise(frame, &mut scene.seed.derive("noise", 0).random());
}

fn darken_corners(frame: &mut Frame) {
    let (half_w, half_h) = (0.5 * frame.width as f32, 0.5 * frame.height as f32);
    let longest = half_w * half_w + half_h * half_h;
    for y in 0..frame.height {
        for x in 0..frame.width {
            let (dx, dy) = (x as f32 - half_w, y as f32 - half_h);
            let out = (dx * dx + dy * dy) / longest;
            frame.pixels[y * frame.width + x] *= 1.0 - 0.11 * out * out - 0.03 * out;
        }
    }
}

/// Noise of light and of colour, blotchy as after a raw converter; more in the dark.
fn add_noise(frame: &mut Frame, random: &mut Random) {
    let mut noise = Frame::new(frame.width as u32, frame.height as u32);
    for pixel in &mut noise.pixels {
        *pixel = Vec3::new(bell(random), bell(random), bell(random));
    }
    noise.blur(0.6);
    for (pixel, noise) in frame.pixels.iter_mut().zip(&noise.pixels) {
        let light = noise.x;
        let colour = Vec3::new(noise.y, -0.3 * (noise.y + noise.z), noise.z) * 0.55;
        let strength = 5.2 - 2.6 * (pixel.y / 255.0);
        *pixel += (Vec3::splat(light) + colour) * strength;
    }
}

/// A number of mean 0 and deviation 1, nearly normal.
fn bell(random: &mut Random) -> f32 {
    let sum: f64 = (0..4).map(|_| random.unit()).sum();
    ((sum - 2.0) * 1.732) as f32
}
