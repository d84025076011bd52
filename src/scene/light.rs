//! What lights a scene and what stands behind it.

use glam::DVec3;

/// The sun and the sky as light; colours are linear, of Rec. 709 primaries.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Around the vertical axis, degrees, as [`super::Camera::yaw_deg`]: 0 shines from +Z.
    pub sun_yaw_deg: f64,
    /// Above the horizon, degrees.
    pub sun_pitch_deg: f64,
    /// Light of the sun on a surface that faces it.
    pub sun: [f32; 3],
    /// Light of the upper half of the sky on a surface that faces up.
    pub sky: [f32; 3],
    /// Light that comes back from the ground, on a surface that faces down.
    pub ground: [f32; 3],
    /// Factor before the tone curve.
    pub exposure: f32,
}

impl Light {
    /// A high, slightly warm sun from the left behind the viewer, under a pale blue sky.
    pub const DAY: Self = Self {
        sun_yaw_deg: -42.0,
        sun_pitch_deg: 48.0,
        sun: [1.55, 1.45, 1.26],
        sky: [0.62, 0.72, 0.86],
        ground: [0.26, 0.25, 0.20],
        exposure: 1.0,
    };
}

impl Default for Light {
    fn default() -> Self {
        Self::DAY
    }
}

impl Light {
    /// The unit vector towards the sun.
    pub fn toward_sun(&self) -> DVec3 {
        let (yaw, pitch) = (
            self.sun_yaw_deg.to_radians(),
            self.sun_pitch_deg.to_radians(),
        );
        let flat = libm::cos(pitch);
        DVec3::new(
            libm::sin(yaw) * flat,
            libm::sin(pitch),
            libm::cos(yaw) * flat,
        )
    }
}

/// What is seen where no tree is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Backdrop {
    /// Nothing: the picture is clear there, for compositing.
    Clear,
    /// A photographer's paper: light grey, the ground runs into the background without a horizon.
    #[default]
    Studio,
    /// A sky over open ground.
    Sky,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_stands_where_its_angles_say() {
        let light = Light {
            sun_yaw_deg: 90.0,
            sun_pitch_deg: 30.0,
            ..Light::default()
        };
        let expected = DVec3::new(0.75f64.sqrt(), 0.5, 0.0);
        assert!(light.toward_sun().distance(expected) < 1e-12);
    }
}
