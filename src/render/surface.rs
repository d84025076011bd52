//! The surface that a radius cubemap stands for: |p| = r(p / |p|).

use super::packed_cube::PackedCube;
use glam::Vec3;

/// Two unit vectors at right angles to `direction` (a unit vector) and to each other.
///
/// Source: T. Duff et al., *Building an Orthonormal Basis, Revisited*, 2017.
#[inline(always)]
pub(crate) fn tangents(direction: Vec3) -> (Vec3, Vec3) {
    let Vec3 { x, y, z } = direction;
    let sign = if z >= 0.0 { 1.0 } else { -1.0 };
    let a = -1.0 / (sign + z);
    let b = x * y * a;
    (
        Vec3::new(1.0 + sign * x * x * a, sign * b, -sign * x),
        Vec3::new(b, sign + y * y * a, -y),
    )
}

/// The outward unit normal of the surface in `direction` (a unit vector).
///
/// The gradient of |p| − r(p/|p|) is d − ∇r / r, ∇r taken on the unit sphere by central differences
/// over one texel each way, which hides that a bilinear radius has creases.
#[inline(always)]
pub(crate) fn normal(radius: &PackedCube<f32>, direction: Vec3, level: u32) -> Vec3 {
    normal_from(radius, direction, radius.sampled(direction, level), level)
}

/// The same where the radius in `direction` is known to be `here`.
#[inline(always)]
pub(crate) fn normal_from(
    radius: &PackedCube<f32>,
    direction: Vec3,
    here: f32,
    level: u32,
) -> Vec3 {
    let step = 2.0 / (radius.size() >> level) as f32;
    let (right, up) = tangents(direction);
    let across = radius.sampled(direction + right * step, level)
        - radius.sampled(direction - right * step, level);
    let along =
        radius.sampled(direction + up * step, level) - radius.sampled(direction - up * step, level);
    let outward = direction * (here * (2.0 * step)) - right * across - up * along;
    outward * (1.0 / outward.dot(outward).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Cubemap;
    use glam::DVec3;

    /// The distance from the origin to an ellipsoid with these half-axes.
    fn ellipsoid(direction: DVec3, axes: DVec3) -> f64 {
        1.0 / (direction.normalize() / axes).length()
    }

    #[test]
    fn an_ellipsoid_has_its_normals() {
        let axes = DVec3::new(1.0, 1.5, 0.8);
        let map = Cubemap::from_directions(128, |d| ellipsoid(d, axes) as f32);
        let mean = |four: [f32; 4]| four.iter().sum::<f32>() * 0.25;
        let packed = PackedCube::new(map, mean, |x| x);
        for i in 0..500 {
            let angle = f64::from(i) * 2.399;
            let z = f64::from(i) / 250.0 - 0.999;
            let flat = (1.0 - z * z).max(0.0).sqrt();
            let direction = DVec3::new(libm::cos(angle) * flat, z, libm::sin(angle) * flat);
            let point = direction * ellipsoid(direction, axes);
            let expected = (point / (axes * axes)).normalize();
            let found = normal(&packed, direction.normalize().as_vec3(), 0).as_dvec3();
            let error = libm::acos(found.dot(expected).min(1.0)).to_degrees();
            assert!(error < 1.0, "{direction}: {error}°");
        }
    }

    #[test]
    fn tangents_are_a_frame() {
        for direction in [Vec3::X, Vec3::Z, Vec3::NEG_Z, Vec3::new(0.6, -0.48, 0.64)] {
            let (right, up) = tangents(direction);
            assert!(right.cross(up).distance(direction) < 1e-6);
        }
    }
}
