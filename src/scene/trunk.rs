//! The stem that carries a crown.

use super::{Crown, StemLook};
use glam::DVec3;

/// A tapered, slightly curved stem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trunk {
    /// Middle of its foot, metres.
    pub base_m: DVec3,
    /// Where it ends within the crown, metres.
    pub top_m: DVec3,
    /// Radius above the root flare, metres.
    pub base_radius_m: f64,
    /// Radius at its end, metres.
    pub top_radius_m: f64,
    /// How far it bows out half-way, metres.
    pub bow_m: DVec3,
    /// What a picture shows of it, if one does.
    pub look: Option<StemLook>,
}

/// Cover below which one sees the stem within the crown, and how far up it then stands, as a share of the
/// crown's radius above its centre.
const OPEN: f32 = 0.8;
const UPWARDS: f64 = 0.6;

/// Radius of a stem of the height 1: that of an oak that stands alone.
const SLENDERNESS: f64 = 0.022;

impl Trunk {
    /// A stem from the tree's base into the middle of `crown`, through most of a sparse one, as its picture
    /// shows it, or as stout as the tree's height asks for.
    pub fn under(crown: &Crown) -> Self {
        let (middle, _) = crown.tree_bounds();
        let height = 2.0 * middle.y;
        let usual = SLENDERNESS * height;
        let base_radius_m = crown.stem.map_or(usual, |stem| stem.base_radius_m);
        let foot = DVec3::new(0.0, 0.0, crown.center_m.z);
        let is_open = crown.cover < OPEN;
        let above = match is_open {
            true => UPWARDS * f64::from(crown.radius_m.sampled(DVec3::Y)),
            false => 0.0,
        };
        let thin = if is_open { 0.12 } else { 0.45 } * base_radius_m;
        let top_radius_m = crown.stem.map_or(thin, |stem| match is_open {
            // Where it ends in sight it is thin, whatever it is below the crown.
            true => stem.top_radius_m.min(thin),
            false => stem.top_radius_m,
        });
        Self {
            base_m: foot,
            top_m: crown.center_m + DVec3::Y * above,
            base_radius_m,
            top_radius_m,
            bow_m: DVec3::new(0.5, 0.0, 0.3) * usual,
            look: crown.stem,
        }
    }

    /// The axis at the share `along`, 0 … 1, of the height.
    pub fn axis_m(&self, along: f64) -> DVec3 {
        self.base_m.lerp(self.top_m, along) + self.bow_m * (4.0 * along * (1.0 - along))
    }

    /// The radius at the share `along`, metres, with the flare of the roots.
    pub fn radius_m(&self, along: f64) -> f64 {
        let height = self.top_m.y - self.base_m.y;
        let above = along * height / (1.6 * self.base_radius_m);
        let taper = self.base_radius_m + (self.top_radius_m - self.base_radius_m) * along;
        taper * (1.0 + 0.55 * libm::exp(-above))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stem_tapers_from_its_foot_to_the_crown() {
        let trunk = Trunk {
            base_m: DVec3::ZERO,
            top_m: DVec3::new(0.2, 6.0, 0.0),
            base_radius_m: 0.3,
            top_radius_m: 0.1,
            bow_m: DVec3::X * 0.1,
            look: None,
        };
        assert_eq!(trunk.axis_m(0.0), trunk.base_m);
        assert_eq!(trunk.axis_m(1.0), trunk.top_m);
        let radii: Vec<f64> = (0..=10)
            .map(|i| trunk.radius_m(f64::from(i) / 10.0))
            .collect();
        assert!(radii.is_sorted_by(|a, b| a > b));
    }
}
