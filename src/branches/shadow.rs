//! Which places the sun sees: leaf by leaf, where [`super::light::LightGrid`] knows only means.
//!
//! A shadow map (Williams, *Casting Curved Shadows on Curved Surfaces*, 1978): a picture of the
//! tree from the sun that holds, for every cell, how far the nearest leaf reaches to the sun.
//! Lookups average a few cells, so that edges are soft, as the sun is no point.

use super::light::Daylight;
use glam::Vec3;

/// The tree as the sun sees it.
#[derive(Debug, Clone)]
pub struct ShadowMap {
    right: Vec3,
    up: Vec3,
    to_sun: Vec3,
    cell_m: f32,
    left_m: f32,
    bottom_m: f32,
    width: usize,
    height: usize,
    /// Distance towards the sun of what is nearest to it, in metres.
    nearest_m: Vec<f32>,
}

impl ShadowMap {
    /// An empty map around the box from `low` to `high`.
    pub fn new(daylight: &Daylight, low: Vec3, high: Vec3, cell_m: f32) -> Self {
        let to_sun = daylight.to_sun;
        let right = Vec3::Y.cross(to_sun).normalize_or(Vec3::X);
        let up = to_sun.cross(right);
        let mut bounds = [
            f32::INFINITY,
            f32::NEG_INFINITY,
            f32::INFINITY,
            f32::NEG_INFINITY,
        ];
        for corner in 0..8 {
            let pick =
                |bit: u32, low: f32, high: f32| if corner >> bit & 1 == 0 { low } else { high };
            let point = Vec3::new(
                pick(0, low.x, high.x),
                pick(1, low.y, high.y),
                pick(2, low.z, high.z),
            );
            let (x, y) = (point.dot(right), point.dot(up));
            bounds = [
                bounds[0].min(x),
                bounds[1].max(x),
                bounds[2].min(y),
                bounds[3].max(y),
            ];
        }
        let cells = |low: f32, high: f32| ((high - low) / cell_m) as usize + 3;
        let (width, height) = (cells(bounds[0], bounds[1]), cells(bounds[2], bounds[3]));
        Self {
            right,
            up,
            to_sun,
            cell_m,
            left_m: bounds[0] - cell_m,
            bottom_m: bounds[2] - cell_m,
            width,
            height,
            nearest_m: vec![f32::NEG_INFINITY; width * height],
        }
    }

    /// Lets a disc of `radius_m` at `centre` throw a shadow.
    pub fn cover(&mut self, centre: Vec3, radius_m: f32) {
        let (x, y) = self.place(centre);
        let reach = radius_m / self.cell_m;
        let distance = centre.dot(self.to_sun);
        let range = |middle: f32, size: usize| {
            let low = libm::floorf(middle - reach + 0.5).max(0.0) as usize;
            let high = libm::floorf(middle + reach + 0.5).max(0.0) as usize;
            low..high.max(low + 1).min(size)
        };
        for row in range(y, self.height) {
            for column in range(x, self.width) {
                let cell = &mut self.nearest_m[row * self.width + column];
                *cell = cell.max(distance);
            }
        }
    }

    /// Share of the sun, 0..1, that reaches `position`; what is nearer to it than `bias_m` does not
    /// count.
    pub fn lit(&self, position: Vec3, bias_m: f32) -> f32 {
        let (x, y) = self.place(position);
        let own = position.dot(self.to_sun) + bias_m;
        let (column, row) = (libm::floorf(x) as i64, libm::floorf(y) as i64);
        let (tx, ty) = (x - libm::floorf(x), y - libm::floorf(y));
        // Three cells each way, the outer ones by how far the place reaches into them.
        let across = [1.0 - tx, 1.0, tx];
        let along = [1.0 - ty, 1.0, ty];
        let mut sum = 0.0;
        for (dy, weight_y) in (-1i64..).zip(along) {
            for (dx, weight_x) in (-1i64..).zip(across) {
                if self.nearest(column + dx, row + dy) <= own {
                    sum += weight_x * weight_y;
                }
            }
        }
        sum * 0.25
    }

    /// Column and row of a place, with fractions.
    fn place(&self, position: Vec3) -> (f32, f32) {
        (
            (position.dot(self.right) - self.left_m) / self.cell_m,
            (position.dot(self.up) - self.bottom_m) / self.cell_m,
        )
    }

    fn nearest(&self, column: i64, row: i64) -> f32 {
        let inside = |value: i64, size: usize| usize::try_from(value).ok().filter(|&v| v < size);
        match (inside(column, self.width), inside(row, self.height)) {
            (Some(column), Some(row)) => self.nearest_m[row * self.width + column],
            _ => f32::NEG_INFINITY,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_leaf_shades_what_the_sun_sees_behind_it() {
        let daylight = Daylight::new(-30.0, 50.0, 0.0);
        let mut map = ShadowMap::new(&daylight, Vec3::splat(-3.0), Vec3::splat(3.0), 0.05);
        map.cover(Vec3::ZERO, 0.3);
        assert!(map.lit(-daylight.to_sun, 0.1) < 0.05);
        assert!(map.lit(Vec3::ZERO, 0.1) > 0.95);
        assert!(map.lit(daylight.to_sun, 0.1) > 0.95);
        assert!(map.lit(Vec3::new(2.0, 0.0, 2.0), 0.1) > 0.95);
        assert!(map.lit(Vec3::splat(50.0), 0.1) > 0.95);
    }
}
