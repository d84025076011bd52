//! Pictures of a palm's fronds: one feathered leaf fills a picture, from its stalk at the lower edge to its
//! tip at the upper one, straight and flat. Whoever draws it gives it its length, its width and its droop.
//!
//! A frond is [`FROND_SLENDER`] times as wide as long; the picture is square, so it is drawn stretched. Leaflets
//! stand on both sides of the rib, longest before the middle, ever more forward towards the tip, some torn off
//! as the wind does.

use super::ribs::FROND_SLENDER;
use crate::base::{Random, Seed};
use crate::branches::twig_canvas::{Canvas, TwigTexel};
use crate::raster::Image;
use glam::DVec2;

/// Leaflets on each side of a frond, and half their thickness at the root, in halves of the picture.
const LEAFLETS: u32 = 46;
const THICK: f64 = 0.021;

/// Where the rib begins and ends in the picture: its edges are clear, and leaflets go on beyond its end.
const ROOT: f64 = 0.95;
const TIP: f64 = -0.84;

/// Share of the length that is bare stalk.
const STALK: f64 = 0.1;

/// Longest leaflet, in halves of the frond's length.
const LONGEST: f64 = 0.34;

/// Angle between leaflets and the rib at the stalk and at the tip, radians.
const OPEN: [f64; 2] = [1.15, 0.35];

/// Share of the leaflets that are missing.
const TORN: f64 = 0.06;

/// `count` different fronds, `size` × `size` texels each.
pub(crate) fn fronds(size: u32, count: u32, seed: Seed) -> Vec<Image<TwigTexel>> {
    let frond = |index: u32| {
        let mut random = seed.derive("frond", u64::from(index)).random();
        let mut canvas = Canvas::new(size);
        for leaflet in 0..LEAFLETS {
            let share = f64::from(leaflet) / f64::from(LEAFLETS - 1);
            for hand in [-1.0, 1.0] {
                if random.unit() >= TORN {
                    draw_leaflet(&mut canvas, share, hand, &mut random);
                }
            }
        }
        // The rib in pieces: it grows thin.
        const PIECES: u32 = 8;
        for piece in 0..PIECES {
            let [from, to] = [piece, piece + 1].map(|i| f64::from(i) / f64::from(PIECES));
            let half = 0.03 * (1.0 - from) + 0.008;
            let ends = [from, to].map(|share| DVec2::new(0.0, ROOT - (ROOT - TIP) * share));
            canvas.stroke(ends, half, 150.0 * light(from));
        }
        canvas.reduced(128)
    };
    (0..count).map(frond).collect()
}

/// Factor on the brightness at a share of the length: it is dark about the heart.
fn light(share: f64) -> f64 {
    0.6 + 0.45 * share.min(0.8)
}

/// A leaflet at `share` of the feathered part, to one side; it hangs back a little towards its end.
fn draw_leaflet(canvas: &mut Canvas, share: f64, hand: f64, random: &mut Random) {
    let along = STALK + (1.0 - STALK) * share + random.between(-0.006, 0.006);
    let open = OPEN[0] + (OPEN[1] - OPEN[0]) * share + random.between(-0.12, 0.12);
    // Longest before the middle, short at both ends.
    let profile = (0.45 + 2.2 * share).min(1.0) * (1.0 - 0.62 * share * share);
    let length = LONGEST * profile * random.between(0.82, 1.0);
    let shade = 128.0 * light(along) * random.between(0.8, 1.2);
    let mut place = DVec2::new(0.0, ROOT - (ROOT - TIP) * along);
    const PIECES: u32 = 3;
    for piece in 0..PIECES {
        let turned = open + 0.16 * f64::from(piece);
        let step = length / f64::from(PIECES);
        let next = place
            + DVec2::new(
                hand * libm::sin(turned) * step / f64::from(FROND_SLENDER),
                -libm::cos(turned) * step,
            );
        let half = THICK * profile.max(0.5) * (1.0 - 0.3 * f64::from(piece));
        canvas.stroke([place, next], half, shade);
        place = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::leaf_pictures::is_clear_at_the_edges;

    #[test]
    fn fronds_differ_are_feathered_and_end_within_their_picture() {
        let size = 256;
        let fronds = fronds(size, 3, Seed(2));
        assert_ne!(fronds[0], fronds[1]);
        for frond in &fronds {
            let covered = |x: u32, y: u32| frond.at(x, y).coverage >= 128;
            let row = |y: u32| (0..size).filter(|&x| covered(x, y)).count();
            let share = (0..size).map(row).sum::<usize>() as f64 / f64::from(size * size);
            assert!((0.2..0.6).contains(&share), "{share}");
            assert!(is_clear_at_the_edges(frond));
            // Nothing but the stalk near the lower edge.
            assert!((1..20).contains(&row(size - 10)), "{}", row(size - 10));
            assert!(row(size / 2) > 4 * row(16));
        }
    }
}
