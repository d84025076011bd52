//! What is behind the trees: `shaders/backdrop.wgsl` on the processor.

use super::Band;
use crate::render::frame::Frame;
use glam::Vec3;

/// Fills a band with what is behind everything.
pub(super) fn draw(frame: &Frame, band: &mut Band<'_>) {
    for y in band.rows.0..band.rows.1 {
        for x in 0..band.width {
            let light = if frame.view != 0 || frame.backdrop == 0 {
                [0.0; 4]
            } else {
                let ray = frame.ray(x as f32 + 0.5, y as f32 + 0.5);
                let light = behind(frame, ray);
                [light.x, light.y, light.z, 1.0]
            };
            band.put_behind(x, y, light);
        }
    }
}

/// The light from the direction `ray`.
#[inline(always)]
fn behind(frame: &Frame, ray: Vec3) -> Vec3 {
    if frame.backdrop == 1 {
        // Paper that is lit from above and curves up behind.
        let upward = (0.5 + 0.5 * ray.y).clamp(0.0, 1.0);
        return Vec3::new(0.50, 0.51, 0.52) + Vec3::new(0.34, 0.35, 0.37) * upward;
    }
    let upward = ray.y.max(0.0);
    let haze = 1.0 / (1.0 + 9.0 * upward);
    Vec3::new(0.20, 0.38, 0.72) * (1.0 - haze) + Vec3::new(0.80, 0.88, 0.96) * haze
}
