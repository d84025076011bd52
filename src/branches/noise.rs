//! Smooth noise and cells from hashed lattices: for bark, for crooked limbs, for patches of colour.
//!
//! Only products, sums and whole-number hashes: the same bits on every machine.

use glam::Vec3;

/// Noise in [−1, 1] that changes over a distance of about 1; `salt` chooses another field.
pub(super) fn noise3(x: f32, y: f32, z: f32, salt: u32) -> f32 {
    let (x0, tx) = cell(x);
    let (y0, ty) = cell(y);
    let (z0, tz) = cell(z);
    let at = |dx: i32, dy: i32, dz: i32| lattice(x0 + dx, y0 + dy, z0 + dz, salt);
    let layer = |dz: i32| {
        mix(
            mix(at(0, 0, dz), at(1, 0, dz), tx),
            mix(at(0, 1, dz), at(1, 1, dz), tx),
            ty,
        )
    };
    mix(layer(0), layer(1), tz)
}

/// Where a place lies among cells of about unit size.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cell {
    /// How much farther the second nearest cell is than the nearest: 0 on the border between them.
    pub(super) gap: f32,
    /// A number in 0..1 that belongs to the nearest cell.
    pub(super) own: f32,
}

/// The cells around a place.
pub(super) fn cells(place: Vec3, salt: u32) -> Cell {
    let floor = [place.x, place.y, place.z].map(|c| libm::floorf(c) as i32);
    let (mut first, mut second, mut own) = (f32::INFINITY, f32::INFINITY, 0.0);
    for near in 0..27i32 {
        let at = [
            floor[0] + near % 3 - 1,
            floor[1] + near / 3 % 3 - 1,
            floor[2] + near / 9 - 1,
        ];
        let h = hash(at[0], at[1], at[2], salt);
        let part = |shift: u32| ((h >> shift) & 1023) as f32 * (1.0 / 1024.0);
        let centre = Vec3::new(
            at[0] as f32 + part(0),
            at[1] as f32 + part(10),
            at[2] as f32 + part(20),
        );
        let distance = centre.distance_squared(place);
        if distance < first {
            second = first;
            first = distance;
            own = (h >> 22) as f32 * (1.0 / 1024.0);
        } else if distance < second {
            second = distance;
        }
    }
    Cell {
        gap: second.sqrt() - first.sqrt(),
        own,
    }
}

/// `a` at 0, `b` at 1.
pub(super) fn mix(a: f32, b: f32, t: f32) -> f32 {
    a + (b - a) * t
}

/// 0 below `low`, 1 above `high`, a smooth ramp between.
pub(super) fn ramp(low: f32, high: f32, value: f32) -> f32 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

fn cell(x: f32) -> (i32, f32) {
    let floor = libm::floorf(x);
    let t = x - floor;
    (floor as i32, t * t * (3.0 - 2.0 * t))
}

fn lattice(x: i32, y: i32, z: i32, salt: u32) -> f32 {
    (hash(x, y, z, salt) >> 8) as f32 * (2.0 / 16_777_216.0) - 1.0
}

fn hash(x: i32, y: i32, z: i32, salt: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x9e37_79b1)
        ^ (y as u32).wrapping_mul(0x85eb_ca77)
        ^ (z as u32).wrapping_mul(0xc2b2_ae3d)
        ^ salt.wrapping_mul(0x27d4_eb2f);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    h ^ (h >> 15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_bounded_continuous_and_salted() {
        for i in 0..500 {
            let x = i as f32 * 0.37 - 90.0;
            let value = noise3(x, 0.3 * x, -x, 5);
            assert!((-1.0..=1.0).contains(&value));
            assert!((noise3(x, 2.0, 0.5, 1) - noise3(x + 1e-3, 2.0, 0.5, 1)).abs() < 0.01);
            let cell = cells(Vec3::new(x, 0.3 * x, -x), 5);
            assert!(cell.gap >= 0.0 && (0.0..1.0).contains(&cell.own));
        }
        assert_ne!(noise3(0.0, 0.0, 0.0, 1), noise3(0.0, 0.0, 0.0, 2));
    }
}
