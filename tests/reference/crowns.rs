//! Crowns by formula, for tests of what draws them.
#![allow(dead_code, reason = "each test needs a part of it")]

use boscage::geometry::Mesh;
use boscage::raster::{Cubemap, Straight};
use boscage::scene::Crown;
use glam::DVec3;

/// A crown about `center_m` with this radius, in metres, and colour in each direction (unit vectors); its
/// cubemaps are so many texels wide.
pub(crate) fn crown(
    size: u32,
    center_m: DVec3,
    radius: impl Fn(DVec3) -> f64,
    color: impl Fn(DVec3) -> [u8; 3],
) -> Crown {
    Crown {
        center_m,
        radius_m: Cubemap::from_directions(size, |d| radius(d.normalize()) as f32),
        color: Cubemap::from_directions(size, |d| {
            let [r, g, b] = color(d.normalize());
            Straight([r, g, b, 255])
        }),
        height: Cubemap::filled(size, 0.5),
        base_mesh: Mesh::default(),
        cover: 1.0,
        stem: None,
    }
}

/// A lumpy crown: waves of several lengths, darker where it is deep.
pub(crate) fn lumpy(center_m: DVec3) -> Crown {
    let relief = |d: DVec3| {
        let mut sum = 0.0;
        for (count, weight) in [(4.0, 0.5), (9.0, 0.3), (23.0, 0.2)] {
            let wave = |x: f64, phase: f64| libm::sin(x * count + phase);
            sum += weight * wave(d.x, 1.0) * wave(d.y, 2.0 + count) * wave(d.z, 4.0);
        }
        sum
    };
    crown(
        128,
        center_m,
        |d| 3.0 * (1.0 - 0.2 * d.y) * (1.0 + 0.5 * relief(d)),
        |d| {
            let light = 0.7 + 0.5 * relief(d);
            [90.0, 125.0, 50.0].map(|c| (c * light).clamp(0.0, 255.0) as u8)
        },
    )
}
