//! Pictures of a conifer's boughs: one bough fills a picture, from its stalk at the lower edge to its tip at the
//! upper one, straight and flat. Whoever draws it gives it its length, its width and its arch.
//!
//! A bough is [`BOUGH_SLENDER`] times as wide as long; the picture is square, so it is drawn stretched. Side
//! shoots leave the wood to both sides, longest a third of the way out, each with needles all along and a few
//! shoots of its own; those nearer the tip lie above, and lighter.

use super::ribs::BOUGH_SLENDER;
use super::shoot::{Shoot, direction};
use crate::base::{Random, Seed};
use crate::branches::twig_canvas::{Canvas, TwigTexel};
use crate::raster::Image;
use glam::DVec2;

/// Side shoots on each side of a bough.
const SHOOTS: u32 = 9;

/// Where the wood begins and ends in the picture, halves of its side from the middle.
const ROOT: f64 = 0.96;
const TIP: f64 = -0.88;

/// Share of the length without shoots.
const STALK: f64 = 0.1;

/// Angle between shoots and the wood, radians, next to the stalk and to the tip.
const OPEN: [f64; 2] = [1.0, 0.6];

/// Distance of needles along a shoot, their length and half their thickness, in halves of the bough's length.
const STEP: f64 = 0.024;
const NEEDLE: f64 = 0.062;
const HALF: f64 = 0.0055;

/// Where the wood goes to: from x towards y, which is down.
const UPWARDS: f64 = -std::f64::consts::FRAC_PI_2;

/// Share of the shoots that are missing.
const LOST: f64 = 0.08;

/// `count` different boughs, `size` × `size` texels each.
pub(super) fn boughs(size: u32, count: u32, seed: Seed) -> Vec<Image<TwigTexel>> {
    let bough = |index: u32| {
        let mut random = seed.derive("bough", u64::from(index)).random();
        let mut canvas = Canvas::new(size);
        let wood = Shoot {
            base: DVec2::new(0.0, ROOT),
            angle: UPWARDS,
            length: ROOT - TIP,
            bend: random.between(-0.12, 0.12),
            light: 1.0,
        };
        for index in 0..SHOOTS {
            for hand in [-1.0, 1.0] {
                if random.unit() >= LOST {
                    wood.side(index, hand, &mut random)
                        .draw_with_sides(&mut canvas, &mut random);
                }
            }
        }
        wood.draw_tapering_wood(&mut canvas, 0.016);
        let end = wood.part(0.72);
        end.draw_needles(&mut canvas, &mut random);
        canvas.reduced(128)
    };
    (0..count).map(bough).collect()
}

/// In a frame where a bough is [`BOUGH_SLENDER`] as wide as long.
impl Shoot {
    /// What is left of it beyond a share of its length.
    fn part(&self, share: f64) -> Self {
        let (base, angle) = self.at(share);
        Self {
            base,
            angle,
            length: self.length * (1.0 - share),
            bend: self.bend * (1.0 - share),
            light: self.light,
        }
    }

    /// Side shoot `index` of a bough's wood, to one side.
    fn side(&self, index: u32, hand: f64, random: &mut Random) -> Self {
        let place = f64::from(index) / f64::from(SHOOTS - 1);
        let share = STALK + (0.95 - STALK) * place + random.between(-0.02, 0.02);
        let (base, angle) = self.at(share);
        let open = OPEN[0] + (OPEN[1] - OPEN[0]) * place + random.between(-0.15, 0.15);
        // Short at the stalk, longest at a third, shorter and shorter towards the tip.
        let profile = (0.5 + 1.6 * place).min(1.0) * (1.0 - 0.8 * place * place);
        let room = f64::from(BOUGH_SLENDER) / libm::sin(open);
        Self {
            base,
            angle: angle + hand * open,
            length: room * profile * random.between(0.7, 0.95),
            bend: -0.35 * hand,
            light: 0.5 + 0.55 * place,
        }
    }

    /// Its own side shoots first, then the shoot above them.
    fn draw_with_sides(&self, canvas: &mut Canvas, random: &mut Random) {
        for index in 0..3 {
            let share = 0.3 + 0.2 * f64::from(index) + random.between(-0.05, 0.05);
            let hand = if index % 2 == 0 { 1.0 } else { -1.0 };
            let (base, angle) = self.at(share);
            let side = Self {
                base,
                angle: angle + hand * random.between(0.5, 0.8),
                length: (1.0 - share) * 0.6 * self.length,
                bend: -0.3 * hand,
                light: 0.9 * self.light,
            };
            side.draw_needles(canvas, random);
        }
        self.draw_needles(canvas, random);
    }

    /// The wood, and needles on both sides of it, lighter towards the end: that has grown last.
    fn draw_needles(&self, canvas: &mut Canvas, random: &mut Random) {
        self.draw_tapering_wood(canvas, 0.006);
        let count = (self.length / STEP).ceil() as u32;
        for index in 0..=count {
            let share = f64::from(index) / f64::from(count.max(1));
            let (place, angle) = self.at(share);
            for hand in [-1.0, 1.0] {
                let lean = 0.95 - 0.6 * share + random.between(-0.2, 0.2);
                let length = NEEDLE * (1.0 - 0.35 * share * share) * random.between(0.8, 1.15);
                let tip = place + direction(angle + hand * lean) * length;
                let shade = 145.0 * self.light * (0.6 + 0.7 * share) * random.between(0.8, 1.2);
                stroke(canvas, [place, tip], HALF, shade);
            }
        }
    }

    fn draw_tapering_wood(&self, canvas: &mut Canvas, half: f64) {
        const PIECES: u32 = 6;
        for piece in 0..PIECES {
            let [from, to] = [piece, piece + 1].map(|i| 0.97 * f64::from(i) / f64::from(PIECES));
            let ends = [self.at(from).0, self.at(to).0];
            stroke(canvas, ends, half * (1.0 - 0.7 * from), 70.0 * self.light);
        }
    }
}

/// Draws a line; nothing of one that would leave the picture.
fn stroke(canvas: &mut Canvas, ends: [DVec2; 2], half: f64, shade: f64) {
    let stretched = ends.map(|at| DVec2::new(at.x / f64::from(BOUGH_SLENDER), at.y));
    let reach = stretched.map(|at| at.x.abs().max(at.y.abs()));
    if reach[0].max(reach[1]) + half <= 0.985 {
        canvas.stroke(stretched, half, shade);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::leaf_pictures::is_clear_at_the_edges;

    #[test]
    fn boughs_differ_are_wide_below_the_middle_and_end_within_their_picture() {
        let size = 256;
        let boughs = boughs(size, 3, Seed(2));
        assert_ne!(boughs[0], boughs[1]);
        for bough in &boughs {
            let covered = |x: u32, y: u32| bough.at(x, y).coverage >= 128;
            let row = |y: u32| (0..size).filter(|&x| covered(x, y)).count();
            let share = (0..size).map(row).sum::<usize>() as f64 / f64::from(size * size);
            assert!((0.18..0.6).contains(&share), "{share}");
            assert!(is_clear_at_the_edges(bough));
            let band = |part: u32| {
                (part * size / 8..(part + 1) * size / 8)
                    .map(row)
                    .sum::<usize>()
            };
            assert!(2 * band(5) > 3 * band(0), "{} {}", band(5), band(0));
            assert!(row(size - 6) < size as usize / 4);
        }
    }
}
