//! Baseline: a body from the silhouette as seen from the crown's centre (thesis §4.2).
//!
//! The silhouette becomes a radius r(φ) for every angle φ around the centre, φ = 0 pointing up; where
//! a ray crosses it several times the first or the last crossing counts. The body reaches, in a
//! direction at angle φ from the vertical and turned by α from the right-hand side,
//! (1 − |α|/π) r(φ) + |α|/π r(−φ): right and left half of the silhouette, mixed linearly.
//!
//! Departure: the printed φ is the angle of the direction's projection onto the picture, which jumps
//! for directions towards the viewer; the angle from the vertical agrees with it in the picture's
//! plane and turns the silhouette about the axis, as the thesis' Fig. 4.8 shows.
//!
//! Known weakness: rings around the axis, concave outlines filled by turning.

use super::center::crown_center;
use super::cube_sphere::cube_sphere;
use crate::base::{Cancel, Cancelled};
use crate::geometry::{Mesh, Point};
use crate::raster::{Cubemap, Mask};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Angles at which r is measured: at 256 pixels two of them are half a pixel apart.
const ANGLES: usize = 2048;

/// How far a ray goes between two looks at the mask, pixels.
const STEP_PX: f64 = 0.25;

/// The least radius, where the centre is not in the mask: half a pixel.
const LEAST_PX: f64 = 0.5;

/// Which crossing of ray and silhouette counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Crossing {
    /// The first: nothing outside the mask is added.
    First,
    /// The last: nothing inside the mask is lost (the thesis' choice).
    #[default]
    Last,
}

/// r(φ) of a mask.
#[derive(Debug, Clone, PartialEq)]
pub struct RadialSilhouette {
    center: Point,
    /// Pixels, at equal angles, clockwise on screen from up.
    radii: Vec<f64>,
}

impl RadialSilhouette {
    /// Measures `mask` about its [`crown_center`]; `None` when it is empty.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn new(
        mask: &Mask,
        crossing: Crossing,
        cancel: &Cancel,
    ) -> Result<Option<Self>, Cancelled> {
        let Some(center) = crown_center(mask) else {
            return Ok(None);
        };
        let mut radii = Vec::with_capacity(ANGLES);
        for i in 0..ANGLES {
            cancel.check()?;
            let (sine, cosine) = libm::sincos(TAU * i as f64 / ANGLES as f64);
            radii.push(crossed(mask, center, Point::new(sine, -cosine), crossing));
        }
        Ok(Some(Self { center, radii }))
    }

    /// The centre, mask pixels.
    pub fn center(&self) -> Point {
        self.center
    }

    /// r at `angle`, radians clockwise on screen from up; pixels.
    pub fn radius(&self, angle: f64) -> f64 {
        let place = angle / TAU * ANGLES as f64;
        let (floor, share) = (place.floor(), place - place.floor());
        let at = |offset: i64| {
            let index = (floor as i64 + offset).rem_euclid(ANGLES as i64);
            self.radii[index as usize]
        };
        at(0) * (1.0 - share) + at(1) * share
    }

    /// How far the body reaches in `direction` (of any length but 0), in the mask's frame: x to the
    /// right, y down, z towards the viewer.
    pub fn reach(&self, direction: DVec3) -> f64 {
        let DVec3 { x, y, z } = direction;
        let from_up = libm::atan2(libm::hypot(x, z), -y);
        let share = libm::fabs(libm::atan2(z, x)) / PI;
        self.radius(from_up) * (1.0 - share) + self.radius(-from_up) * share
    }

    /// The body as a watertight mesh in the mask's frame and pixels, see [`cube_sphere`].
    pub fn mesh(&self, cells: u32) -> Mesh {
        let radius = Cubemap::from_directions(2 * cells, |direction| self.reach(direction) as f32);
        cube_sphere(&radius, self.center.extend(0.0), cells).mesh
    }
}

/// Where the ray from `center` along `direction` leaves the mask.
fn crossed(mask: &Mask, center: Point, direction: Point, crossing: Crossing) -> f64 {
    let farthest = f64::from(mask.width()) + f64::from(mask.height());
    let mut left = None;
    for step in 0..=(farthest / STEP_PX) as u32 {
        let distance = f64::from(step) * STEP_PX;
        let place = center + direction * distance;
        let (x, y) = (libm::rint(place.x) as i64, libm::rint(place.y) as i64);
        let inside = mask.get(x, y) == Some(true);
        if inside {
            left = Some(distance + STEP_PX / 2.0);
        } else if left.is_some() && crossing == Crossing::First {
            break;
        }
    }
    left.unwrap_or(0.0).max(LEAST_PX)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Topology;
    use crate::raster::Image;

    fn drawn(side: i64, inside: impl Fn(i64, i64) -> bool) -> Mask {
        let pixels = (0..side * side).map(|i| inside(i % side - side / 2, i / side - side / 2));
        Image::from_pixels(side as u32, side as u32, pixels.collect())
    }

    fn measured(mask: &Mask, crossing: Crossing) -> RadialSilhouette {
        RadialSilhouette::new(mask, crossing, &Cancel::new())
            .unwrap()
            .unwrap()
    }

    #[test]
    fn a_disc_becomes_a_ball() {
        let mask = drawn(101, |x, y| x * x + y * y <= 40 * 40);
        let silhouette = measured(&mask, Crossing::Last);
        let mesh = silhouette.mesh(24);
        assert!(Topology::of(&mesh).is_watertight());
        for position in &mesh.positions {
            let distance = position.distance(silhouette.center().extend(0.0));
            assert!((distance - 40.5).abs() < 1.2, "{distance}");
        }
    }

    #[test]
    fn first_and_last_crossings_differ_behind_a_gap() {
        let mask = drawn(61, |x, y| x.abs() <= 20 && y.abs() <= 5 && x.abs() != 12);
        let to_the_right = std::f64::consts::FRAC_PI_2;
        let radius = |crossing| measured(&mask, crossing).radius(to_the_right);
        assert!((radius(Crossing::First) - 11.5).abs() < 0.3);
        assert!((radius(Crossing::Last) - 20.5).abs() < 0.3);
    }

    #[test]
    fn right_and_left_are_mixed_around_the_axis() {
        let silhouette = RadialSilhouette {
            center: Point::ZERO,
            radii: (0..ANGLES)
                .map(|i| if i < ANGLES / 2 { 3.0 } else { 1.0 })
                .collect(),
        };
        assert!((silhouette.reach(DVec3::X) - 3.0).abs() < 1e-9);
        assert!((silhouette.reach(-DVec3::X) - 1.0).abs() < 1e-9);
        assert!((silhouette.reach(DVec3::Z) - 2.0).abs() < 1e-9);
        assert!((silhouette.reach(-DVec3::Z) - 2.0).abs() < 1e-9);
    }

    #[test]
    fn an_empty_mask_has_no_silhouette() {
        let empty = Image::filled(3, 3, false);
        let found = RadialSilhouette::new(&empty, Crossing::Last, &Cancel::new());
        assert_eq!(found, Ok(None));
    }
}
