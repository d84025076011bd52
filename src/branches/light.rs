//! How much of sun and sky reaches a place in the crown.
//!
//! Leaf area is counted in voxels; light falls off along a ray by Beer and Lambert's law. For every
//! voxel one ray goes to the sun and a few to the sky; places between voxels interpolate. This makes
//! the bright tops, the dark undersides and the depth of a crown; single leaves add their
//! own tilt in `paint`, and their shadows in [`super::shadow`].

use crate::base::{Cancel, Cancelled};
use glam::Vec3;

/// Sun and sky over one tree, linear.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Daylight {
    /// Unit direction to the sun.
    pub to_sun: Vec3,
    /// Light of the sun, a little warm.
    pub sun: Vec3,
    /// Light of the whole sky, a little blue.
    pub sky: Vec3,
    /// Light that has wandered through the crown: keeps the deepest shade from being black.
    pub stray: Vec3,
}

impl Daylight {
    /// The light with the sun at `azimuth_deg` (0 behind the viewer, negative to the left) and
    /// `elevation_deg`; `softness` 0 is a clear sky, 1 an overcast one.
    pub fn new(azimuth_deg: f32, elevation_deg: f32, softness: f32) -> Self {
        let (azimuth, elevation) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        let flat = libm::cosf(elevation);
        Self {
            to_sun: Vec3::new(
                libm::sinf(azimuth) * flat,
                libm::sinf(elevation),
                libm::cosf(azimuth) * flat,
            ),
            sun: Vec3::new(3.02, 2.66, 2.04) * (1.0 - 0.62 * softness),
            sky: Vec3::new(0.52, 0.64, 0.80) * (1.0 + 0.95 * softness),
            stray: Vec3::new(0.030, 0.037, 0.022) * (1.0 + 0.5 * softness),
        }
    }
}

/// Directions to the sky and their weights of sum 1: overhead, four slanted, one to the viewer.
const TO_SKY: [(Vec3, f32); 6] = [
    (Vec3::new(0.0, 1.0, 0.0), 0.26),
    (Vec3::new(0.75, 0.60, 0.28), 0.16),
    (Vec3::new(-0.75, 0.60, 0.28), 0.16),
    (Vec3::new(0.05, 0.55, 0.83), 0.20),
    (Vec3::new(-0.05, 0.60, -0.80), 0.10),
    (Vec3::new(0.0, 0.05, 1.0), 0.12),
];

/// Extinction of a ray for each unit of leaf area density. One half for leaves of any direction;
/// more here, for single leaves that stand for several must still shade like them.
const EXTINCTION: f32 = 0.8;

/// Something that stops light: a leaf of `area_m2` at `position`.
#[derive(Debug, Clone, Copy)]
pub struct Blocker {
    /// Where, in metres.
    pub position: Vec3,
    /// One-sided area in square metres.
    pub area_m2: f32,
}

/// Shares of sun and sky, 0..1, that reach a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// Of the sun.
    pub sun: f32,
    /// Of the sky.
    pub sky: f32,
}

/// Light inside and around one tree.
#[derive(Debug, Clone)]
pub struct LightGrid {
    origin: Vec3,
    voxel_m: f32,
    size: [usize; 3],
    reached: Vec<Reached>,
    to_sun: Vec3,
}

impl LightGrid {
    /// The light among `blockers` with voxels of `voxel_m`; open air without any.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn new(
        blockers: &[Blocker],
        to_sun: Vec3,
        voxel_m: f32,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let (low, high) = blockers
            .iter()
            .fold((Vec3::ZERO, Vec3::ONE), |(low, high), blocker| {
                (low.min(blocker.position), high.max(blocker.position))
            });
        let origin = low - Vec3::splat(1.5 * voxel_m);
        let extent = (high - origin) / voxel_m + Vec3::splat(2.5);
        let size = extent.to_array().map(|side| side as usize + 1);
        let mut grid = Self {
            origin,
            voxel_m,
            size,
            reached: Vec::new(),
            to_sun,
        };
        let mut extinction = vec![0.0f32; size.iter().product()];
        let per_voxel = EXTINCTION / (voxel_m * voxel_m * voxel_m);
        for blocker in blockers {
            let cell = ((blocker.position - origin) / voxel_m)
                .to_array()
                .map(|c| c as usize);
            extinction[grid.index(cell)] += blocker.area_m2 * per_voxel;
        }
        for z in 0..size[2] {
            cancel.check()?;
            for y in 0..size[1] {
                for x in 0..size[0] {
                    let center = Vec3::new(x as f32, y as f32, z as f32) + Vec3::splat(0.5);
                    let reached = grid.reached_at(&extinction, center);
                    grid.reached.push(reached);
                }
            }
        }
        Ok(grid)
    }

    fn index(&self, cell: [usize; 3]) -> usize {
        (cell[2] * self.size[1] + cell[1]) * self.size[0] + cell[0]
    }

    fn reached_at(&self, extinction: &[f32], center: Vec3) -> Reached {
        let through = |direction| libm::expf(-self.depth(extinction, center, direction));
        Reached {
            sun: through(self.to_sun),
            sky: TO_SKY
                .iter()
                .map(|&(direction, weight)| weight * through(direction))
                .sum(),
        }
    }

    /// Optical depth from `start` (in voxels) out of the grid.
    fn depth(&self, extinction: &[f32], start: Vec3, direction: Vec3) -> f32 {
        /// Depth beyond which nothing is seen any more.
        const DARK: f32 = 5.0;
        let size = Vec3::new(
            self.size[0] as f32,
            self.size[1] as f32,
            self.size[2] as f32,
        );
        let mut depth = 0.25 * extinction[self.index(start.to_array().map(|c| c as usize))];
        let mut place = start + direction * 0.9;
        while place.min_element() >= 0.0 && place.cmplt(size).all() && depth < DARK {
            depth += extinction[self.index(place.to_array().map(|c| c as usize))] * self.voxel_m;
            place += direction;
        }
        depth
    }

    /// The light that reaches `position`, interpolated between voxels.
    pub fn at(&self, position: Vec3) -> Reached {
        let place = (position - self.origin) / self.voxel_m - Vec3::splat(0.5);
        let limit = |c: f32, size: usize| c.clamp(0.0, size as f32 - 1.001);
        let place = Vec3::new(
            limit(place.x, self.size[0]),
            limit(place.y, self.size[1]),
            limit(place.z, self.size[2]),
        );
        let cell = place.to_array().map(|c| c as usize);
        let t = place - Vec3::new(cell[0] as f32, cell[1] as f32, cell[2] as f32);
        let mut sum = Reached { sun: 0.0, sky: 0.0 };
        for corner in 0..8 {
            let step = [corner & 1, (corner >> 1) & 1, corner >> 2];
            let share = |axis: usize, t: f32| if step[axis] == 1 { t } else { 1.0 - t };
            let weight = share(0, t.x) * share(1, t.y) * share(2, t.z);
            let at = [0, 1, 2].map(|axis| (cell[axis] + step[axis]).min(self.size[axis] - 1));
            let reached = self.reached[self.index(at)];
            sum.sun += weight * reached.sun;
            sum.sky += weight * reached.sky;
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_roof_of_leaves_darkens_what_is_below_and_nothing_above() {
        let mut blockers = Vec::new();
        for i in 0..4000 {
            let (x, z) = ((i % 63) as f32 * 0.1 - 3.0, (i / 63) as f32 * 0.1 - 3.0);
            blockers.push(Blocker {
                position: Vec3::new(x, 3.0, z),
                area_m2: 0.03,
            });
        }
        let grid =
            LightGrid::new(&blockers, Vec3::new(-0.48, 0.76, 0.44), 0.3, &Cancel::new()).unwrap();
        let below = grid.at(Vec3::new(0.0, 1.5, 0.0));
        let above = grid.at(Vec3::new(0.0, 4.0, 0.0));
        assert!(below.sun < 0.4 && below.sky < 0.6, "{below:?}");
        assert!(above.sun > 0.95, "{above:?}");
    }
}
