//! The relief of a whole crown: the height cubemap h of the thesis (§4.6) from the colours around.
//!
//! Luminance and pyramid are those of the relief of a photograph; smoothing goes round the cube
//! ([`smoothed_cubemap`]), so that no edge of the cube can be found in the relief.

use super::luminance::{Stretch, luminance};
use super::pyramid::{ReliefSettings, summed};
use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Cubemap, Straight, cube_upper_envelope, per_face, smoothed_cubemap};

/// Share of the texels at either end that may be flattened to 0 or 1.
const TAIL: f64 = 0.01;

/// Widths of a crown that the side of a cube's face stands for: 90° of a circle, π/4 of its
/// diameter.
const WIDTHS_OF_FACE: f64 = std::f64::consts::FRAC_PI_4;

/// The relief of foliage around a crown: 0 deep between the leaves, 1 far out. The darkest and the
/// lightest 1 % are 0 and 1; one colour all around gives 0.5.
///
/// ```
/// use boscage::{base::Cancel, crown::{ReliefSettings, height_cubemap}, raster::{Cubemap, Straight}};
/// let color = Cubemap::from_directions(16, |d| {
///     let light = if d.x > 0.4 { 200 } else { 40 };
///     Straight([light, light, light, 255])
/// });
/// let settings = ReliefSettings { even_light: 0.0, ..Default::default() };
/// let height = height_cubemap(&color, &settings, &Cancel::new()).unwrap();
/// assert!(height.nearest(glam::DVec3::X) > height.nearest(glam::DVec3::NEG_X));
/// ```
///
/// # Errors
/// [`Cancelled`].
pub fn height_cubemap(
    color: &Cubemap<Straight>,
    settings: &ReliefSettings,
    cancel: &Cancel,
) -> Result<Cubemap<f32>, Cancelled> {
    let light = color.map(|&pixel| luminance(pixel));
    let width = f64::from(color.size()) / WIDTHS_OF_FACE;
    let smoothed = |map: &Cubemap<f32>, sigma: f64| {
        cancel.check()?;
        Ok(smoothed_cubemap(map, sigma))
    };
    let height = summed(&light, settings, width, smoothed, add)?;
    let texels = height.faces().iter().flat_map(|face| face.pixels());
    let stretch = Stretch::of(texels.copied().collect(), TAIL);
    Ok(height.map(|&height| stretch.apply(height).clamp(0.0, 1.0)))
}

fn add(sum: &mut Cubemap<f32>, map: &Cubemap<f32>, weight: f32) {
    for (face, image) in CubeFace::ALL.into_iter().zip(map.faces()) {
        let texels = sum.face_mut(face).pixels_mut().iter_mut();
        for (sum, texel) in texels.zip(image.pixels()) {
            *sum += weight * texel;
        }
    }
}

/// The radius with the relief in it: base · (1 + ρ (h − 0.5)), thesis §4.6, at the size of `base`.
/// Positive for ρ below 2.
///
/// Departure from the thesis: gaps are filled until no wall is steeper than `steepest` (see
/// [`ReliefSettings::steepest`]); what stands out keeps its height. `height` is sampled where it has
/// another size.
pub fn radius_with_relief(
    base: &Cubemap<f32>,
    height: &Cubemap<f32>,
    rho: f64,
    steepest: f64,
) -> Cubemap<f32> {
    let factor = |height: f32| 1.0 + rho as f32 * (height - 0.5);
    let factors = if base.size() == height.size() {
        per_face(|face| height.face(face).map(|&height| factor(height)))
    } else {
        Cubemap::from_directions(base.size(), |direction| factor(height.sampled(direction)))
    };
    let factors = cube_upper_envelope(&factors, steepest as f32);
    per_face(|face| {
        let mut radius = base.face(face).clone();
        let texels = radius.pixels_mut().iter_mut();
        for (radius, factor) in texels.zip(factors.face(face).pixels()) {
            *radius *= factor;
        }
        radius
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn grey(value: f64) -> Straight {
        let value = (255.0 * value.clamp(0.0, 1.0)).round() as u8;
        Straight([value, value, value, 255])
    }

    fn foliage(size: u32) -> Cubemap<Straight> {
        Cubemap::from_directions(size, |d| {
            let d = d.normalize();
            grey(
                0.5 + 0.2 * (libm::sin(21.0 * d.x) * libm::cos(17.0 * d.y) + libm::sin(19.0 * d.z)),
            )
        })
    }

    #[test]
    fn heights_fill_their_range_and_follow_the_light() {
        let settings = ReliefSettings::default();
        let height = height_cubemap(&foliage(64), &settings, &Cancel::new()).unwrap();
        let texels: Vec<f32> = height
            .faces()
            .iter()
            .flat_map(|f| f.pixels())
            .copied()
            .collect();
        assert!(texels.iter().all(|h| (0.0..=1.0).contains(h)));
        let at_ends = texels.iter().filter(|h| **h == 0.0 || **h == 1.0).count();
        assert!(at_ends > 0 && at_ends as f64 <= 0.025 * texels.len() as f64);
        let flat = Cubemap::filled(8, grey(0.3));
        let flat = height_cubemap(&flat, &settings, &Cancel::new()).unwrap();
        assert!(
            flat.faces()
                .iter()
                .flat_map(|f| f.pixels())
                .all(|h| (h - 0.5).abs() < 1e-3)
        );
    }

    #[test]
    fn a_brighter_spot_is_nowhere_deeper_under_it() {
        let plain = foliage(32);
        let settings = ReliefSettings::default();
        for face in CubeFace::ALL {
            for (x, y) in [(0, 0), (31, 12), (16, 16)] {
                let mut lit = plain.clone();
                let Straight([r, g, b, _]) = lit.face(face).at(x, y);
                let [r, g, b] = [r, g, b].map(|channel| channel.saturating_add(60));
                lit.face_mut(face).set(x, y, Straight([r, g, b, 255]));
                let [before, after] = [&plain, &lit]
                    .map(|map| height_cubemap(map, &settings, &Cancel::new()).unwrap());
                assert!(after.face(face).at(x, y) >= before.face(face).at(x, y));
            }
        }
    }

    /// The mean step between texels on both sides of the cube's edges against that inside.
    #[test]
    fn the_cubes_edges_are_not_in_the_relief() {
        let height =
            height_cubemap(&foliage(64), &ReliefSettings::default(), &Cancel::new()).unwrap();
        let n = 64;
        let (mut across, mut inside) = (0.0, 0.0);
        for face in CubeFace::ALL {
            for i in 0..n {
                let (there, x, y) = crate::raster::folded(face, i64::from(n), i64::from(i), n);
                let step = height.face(face).at(n - 1, i) - height.face(there).at(x, y);
                across += step.abs();
                let step = height.face(face).at(n - 1, i) - height.face(face).at(n - 2, i);
                inside += step.abs();
            }
        }
        assert!(across < 1.15 * inside, "{across} across, {inside} inside");
    }

    #[test]
    fn the_relief_moves_the_surface_by_half_of_rho_at_most() {
        let base = Cubemap::filled(4, 2.0);
        let height = Cubemap::from_directions(8, |d| if d.y > 0.0 { 1.0 } else { 0.0 });
        let radius = radius_with_relief(&base, &height, 0.5, 20.0);
        assert_eq!(radius.nearest(DVec3::Y), 2.5);
        assert_eq!(radius.nearest(DVec3::NEG_Y), 1.5);
        let gentle = radius_with_relief(&base, &height, 0.5, 0.1);
        assert_eq!(gentle.nearest(DVec3::Y), 2.5);
        assert!(gentle.nearest(DVec3::NEG_Y) > 2.1);
    }
}
