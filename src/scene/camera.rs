//! The eye: an orbit around a target, as people turn a model in their hands.
//!
//! Angles are of the turntable kind: `yaw` goes round the vertical axis, `pitch` looks down from
//! above; there is no roll. Depth is reversed and infinite (1 at the near plane, 0 at infinity):
//! with 32-bit floats its error grows with the distance itself, so that one near plane does for a
//! leaf and for a forest.

use glam::DVec3;

/// Where a picture is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// The point that is looked at and orbited, metres.
    pub target_m: DVec3,
    /// From the eye to the target, metres, > 0.
    pub distance_m: f64,
    /// Around the vertical axis, degrees: 0 looks from +Z (where the photograph was taken from), 90
    /// from +X.
    pub yaw_deg: f64,
    /// Above the horizon, degrees, −90 … 90: 90 looks straight down.
    pub pitch_deg: f64,
    /// Angle between the lower and the upper edge of the picture, degrees, 0 … 180 exclusive.
    pub fov_y_deg: f64,
}

/// The axes of a view, in the world frame: unit vectors at right angles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewAxes {
    /// To the right of the picture.
    pub right: DVec3,
    /// To the top of the picture.
    pub up: DVec3,
    /// Into the picture.
    pub forward: DVec3,
}

/// Degrees of pitch that orbiting stops at: at 90 a turn of the yaw would spin the picture.
const STEEPEST_DEG: f64 = 89.9;

/// Share of the smaller half of the picture that [`Camera::framing`] lets the sphere fill.
const FRAMED_SHARE: f64 = 0.96;

/// The near plane as a share of the distance: nothing that one looks at is nearer.
const NEAR_SHARE: f64 = 0.01;

impl Camera {
    /// The default angle of view, degrees: that of a 50 mm lens, upright.
    pub const FOV_Y_DEG: f64 = 35.0;

    /// A view from (`yaw_deg`, `pitch_deg`) that shows a whole sphere in a picture of `aspect` =
    /// width / height.
    pub fn framing(
        center_m: DVec3,
        radius_m: f64,
        (yaw_deg, pitch_deg): (f64, f64),
        aspect: f64,
    ) -> Self {
        let half_y = (Self::FOV_Y_DEG / 2.0).to_radians();
        let tan = libm::tan(half_y) * FRAMED_SHARE * aspect.min(1.0);
        let sine = tan / (1.0 + tan * tan).sqrt();
        Self {
            target_m: center_m,
            distance_m: (radius_m / sine).max(f64::MIN_POSITIVE),
            yaw_deg,
            pitch_deg,
            fov_y_deg: Self::FOV_Y_DEG,
        }
    }

    /// The axes of the view.
    pub fn axes(&self) -> ViewAxes {
        let (yaw, pitch) = (self.yaw_deg.to_radians(), self.pitch_deg.to_radians());
        let (sin_yaw, cos_yaw) = (libm::sin(yaw), libm::cos(yaw));
        let (sin_pitch, cos_pitch) = (libm::sin(pitch), libm::cos(pitch));
        let backward = DVec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch);
        let right = DVec3::new(cos_yaw, 0.0, -sin_yaw);
        ViewAxes {
            right,
            up: backward.cross(right),
            forward: -backward,
        }
    }

    /// Where the eye is, metres.
    pub fn eye_m(&self) -> DVec3 {
        self.target_m - self.axes().forward * self.distance_m
    }

    /// Distance of the near plane, metres.
    pub fn near_m(&self) -> f64 {
        self.distance_m * NEAR_SHARE
    }

    /// Tangents of half the angle of view, across and up, for a picture of `aspect` = width /
    /// height.
    pub fn half_extent(&self, aspect: f64) -> (f64, f64) {
        let up = libm::tan((self.fov_y_deg / 2.0).to_radians());
        (up * aspect, up)
    }

    /// The view after a turn around the target, degrees; the pitch stops short of the poles.
    pub fn orbited(self, yaw_deg: f64, pitch_deg: f64) -> Self {
        let turned = (self.yaw_deg + yaw_deg).rem_euclid(360.0);
        let pitch = (self.pitch_deg + pitch_deg).clamp(-STEEPEST_DEG, STEEPEST_DEG);
        Self {
            yaw_deg: turned,
            pitch_deg: pitch,
            ..self
        }
    }

    /// The view with its target moved in the plane of the picture, in heights of the picture, so
    /// that what is at the target's distance follows the pointer.
    pub fn panned(self, right: f64, up: f64) -> Self {
        let axes = self.axes();
        let (_, half_up) = self.half_extent(1.0);
        let height_m = 2.0 * half_up * self.distance_m;
        let target_m = self.target_m + (axes.right * right + axes.up * up) * height_m;
        Self { target_m, ..self }
    }

    /// The view from `factor` times as far; `factor` > 0.
    pub fn zoomed(self, factor: f64) -> Self {
        let distance_m = (self.distance_m * factor).clamp(1e-3, 1e6);
        Self { distance_m, ..self }
    }

    /// View `index` of a turntable of `count` > 0 pictures.
    pub fn on_turntable(self, index: u32, count: u32) -> Self {
        self.orbited(360.0 * f64::from(index) / f64::from(count), 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            target_m: DVec3::new(1.0, 2.0, 3.0),
            distance_m: 10.0,
            yaw_deg: 0.0,
            pitch_deg: 0.0,
            fov_y_deg: 60.0,
        }
    }

    #[test]
    fn the_front_is_seen_from_positive_z_and_the_side_from_positive_x() {
        let front = camera();
        assert!(front.eye_m().distance(DVec3::new(1.0, 2.0, 13.0)) < 1e-12);
        assert!(front.axes().right.distance(DVec3::X) < 1e-12);
        assert!(front.axes().up.distance(DVec3::Y) < 1e-12);
        let side = front.orbited(90.0, 0.0);
        assert!(side.eye_m().distance(DVec3::new(11.0, 2.0, 3.0)) < 1e-12);
        assert!(side.axes().right.distance(-DVec3::Z) < 1e-12);
    }

    #[test]
    fn axes_are_a_frame_from_everywhere() {
        for (yaw, pitch) in [(0.0, 0.0), (30.0, 45.0), (200.0, -80.0), (359.0, 89.9)] {
            let axes = camera().orbited(yaw, pitch).axes();
            let lengths = [axes.right, axes.up, axes.forward].map(DVec3::length);
            assert!(lengths.iter().all(|length| (length - 1.0).abs() < 1e-12));
            assert!(axes.right.cross(axes.up).distance(-axes.forward) < 1e-12);
        }
    }

    #[test]
    fn a_framed_sphere_touches_the_edges_and_no_more() {
        for aspect in [0.5, 1.0, 2.0] {
            let view = Camera::framing(DVec3::ZERO, 3.0, (20.0, 10.0), aspect);
            let sine: f64 = 3.0 / view.distance_m;
            let tan = sine / (1.0 - sine * sine).sqrt();
            let (across, up) = view.half_extent(aspect);
            let smaller = across.min(up);
            assert!(tan < smaller && tan > 0.95 * smaller, "{aspect}");
        }
    }

    #[test]
    fn a_panned_view_moves_its_target_in_the_plane_of_the_picture() {
        let moved = camera().orbited(90.0, 0.0).panned(0.5, 0.0);
        let step = moved.target_m - camera().target_m;
        let height = 2.0 * libm::tan(30f64.to_radians()) * 10.0;
        assert!(step.distance(-DVec3::Z * 0.5 * height) < 1e-9);
    }
}
