//! A shoot with needles, in a picture from −1 to 1: an arc that turns evenly.

use glam::DVec2;

/// A shoot; who draws it adds how ([`super::needles`], [`super::boughs`]).
pub(super) struct Shoot {
    pub(super) base: DVec2,
    /// Where it sets out to, from x towards y, radians.
    pub(super) angle: f64,
    pub(super) length: f64,
    /// How far it has turned at its end, radians.
    pub(super) bend: f64,
    /// Factor on the brightness.
    pub(super) light: f64,
}

impl Shoot {
    /// The place and the direction at a share of the length.
    pub(super) fn at(&self, share: f64) -> (DVec2, f64) {
        // The chord of an arc that turns evenly.
        let middle = self.angle + 0.5 * self.bend * share;
        let place = self.base + direction(middle) * (self.length * share);
        (place, self.angle + self.bend * share)
    }
}

/// The unit vector at `angle` from x towards y.
pub(super) fn direction(angle: f64) -> DVec2 {
    DVec2::new(libm::cos(angle), libm::sin(angle))
}
