//! The outline of a twig's picture: the smallest octagon of fixed directions around what shows.
//!
//! A card with this outline instead of the whole square has about half its area, so half as many
//! clear texels are drawn. A path tracer profits most: it follows a ray through a fixed number of
//! clear surfaces (eight in Blender) and takes what comes after for black.

use crate::raster::Mask;
use glam::DVec2;

/// Texels around what shows that are kept inside, for filters.
const MARGIN_PX: f64 = 1.0;

/// The corners of the octagon around `visible`, counter-clockwise; the picture is the square from −1
/// to 1, y up. All of it when nothing shows.
pub(super) fn octagon(visible: &Mask) -> [DVec2; 8] {
    let size = DVec2::new(f64::from(visible.width()), f64::from(visible.height()));
    let texel = 2.0 / size;
    // How far the figure reaches along the eight directions, from +x on.
    let along: [DVec2; 8] = std::array::from_fn(|eighth| {
        let step = |eighth: usize| [1.0, 1.0, 0.0, -1.0, -1.0, -1.0, 0.0, 1.0][eighth % 8];
        DVec2::new(step(eighth), step(eighth + 6))
    });
    let mut reach = [f64::NEG_INFINITY; 8];
    for y in 0..visible.height() {
        for x in (0..visible.width()).filter(|&x| visible.at(x, y)) {
            let center = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let at = DVec2::new(center.x, size.y - center.y) * texel - 1.0;
            for (reach, along) in reach.iter_mut().zip(along) {
                *reach = reach.max(at.dot(along));
            }
        }
    }
    if reach[0] == f64::NEG_INFINITY {
        reach = along.map(|along| along.abs().element_sum());
    } else {
        for (reach, along) in reach.iter_mut().zip(along) {
            *reach += (0.5 + MARGIN_PX) * texel.dot(along.abs());
        }
    }
    // Each corner is where two neighbouring sides meet.
    std::array::from_fn(|i| {
        let (a, b) = (along[i], along[(i + 1) % 8]);
        let (p, q) = (reach[i], reach[(i + 1) % 8]);
        DVec2::new(p * b.y - q * a.y, q * a.x - p * b.x) / a.perp_dot(b)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    #[test]
    fn the_octagon_of_a_disc_holds_it_and_is_small() {
        let disc = Image::from_pixels(
            64,
            64,
            (0..64 * 64)
                .map(|i| f64::hypot(f64::from(i % 64) - 40.0, f64::from(i / 64) - 20.0) < 16.0)
                .collect(),
        );
        let corners = octagon(&disc);
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let area: f64 = sides.clone().map(|(a, b)| a.perp_dot(*b)).sum::<f64>() / 2.0;
        let of_disc = std::f64::consts::PI * 0.25;
        assert!(area > of_disc && area < 1.3 * of_disc, "{area}");
        for (&from, &to) in sides {
            for turn in 0..32 {
                let angle = f64::from(turn) / 32.0 * std::f64::consts::TAU;
                let center = DVec2::new(40.5 / 32.0 - 1.0, 1.0 - 20.5 / 32.0);
                let rim = center + DVec2::from_angle(angle) * 0.5;
                assert!((to - from).perp_dot(rim - from) >= 0.0, "{from} {turn}");
            }
        }
    }

    #[test]
    fn nothing_has_the_whole_square() {
        let corners = octagon(&Image::filled(4, 4, false));
        let reach = corners.map(|corner| corner.abs().max_element());
        assert_eq!(reach, [1.0; 8]);
    }
}
