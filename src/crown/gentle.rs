//! Taking the steepest walls out of a radius cubemap.
//!
//! Colours lie on a crown by direction. On a wall that runs nearly along the rays from the centre (the
//! side of a spur, a waist below a wide top) one texel is drawn out over many times its width, and
//! leaves become streaks. So the radius may change by no more than a share of itself for each radian:
//! what stands out is taken down and what lies deep is raised, by the same factor, which is the least
//! change that does it.
//!
//! The logarithm of the radius has the slope in question. Of all functions that rise no faster than
//! allowed, the mean of the least one above it and the greatest one below it is the nearest in the
//! largest difference (McShane 1934).

use crate::raster::{CubeCones, Cubemap, per_face};

/// `radius`, positive, changed where it rises or falls by more than `steepest` of itself for each radian
/// between directions; elsewhere it stays.
///
/// ```
/// use boscage::{crown::without_steep_walls, raster::{CubeFace, Cubemap}};
/// let mut radius = Cubemap::filled(16, 1.0);
/// radius.face_mut(CubeFace::PosX).set(8, 8, 4.0);
/// let gentle = without_steep_walls(&radius, 2.0);
/// assert!(gentle.face(CubeFace::PosX).at(8, 8) < 2.5);
/// assert!(gentle.face(CubeFace::PosX).at(9, 8) > 1.5);
/// assert!((gentle.face(CubeFace::NegX).at(8, 8) - 1.0).abs() < 1e-6);
/// ```
pub fn without_steep_walls(radius: &Cubemap<f32>, steepest: f64) -> Cubemap<f32> {
    let logarithm = per_face(|face| radius.face(face).map(|&radius| libm::logf(radius)));
    let cones = CubeCones::new(radius.size(), steepest as f32);
    let (above, below) = rayon::join(
        || cones.above(&logarithm),
        || cones.above(&logarithm.map(|value| -value)),
    );
    per_face(|face| {
        let mut gentle = radius.face(face).clone();
        let bounds = above.face(face).pixels().iter();
        let bounds = bounds.zip(below.face(face).pixels());
        for (radius, (&above, &below)) in gentle.pixels_mut().iter_mut().zip(bounds) {
            // Equal where nothing is too steep; then not even rounding changes it.
            if above > -below {
                *radius = libm::expf((above - below) / 2.0);
            }
        }
        gentle
    })
}
