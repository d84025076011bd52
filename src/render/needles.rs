//! Pictures of twigs full of needles, for conifers: [`crate::branches::twigs`] stamps whole leaves,
//! and a stamp of needles is too coarse to show one.
//!
//! Shoots point away from the middle of the picture, from anywhere near it: all from one point would
//! be a star, which the eye finds again all over a crown. Those of a spruce carry side shoots and
//! short needles all along; those of a pine carry fans of long ones. Needles are drawn one by one,
//! those of later shoots above, and lighter. All of it keeps within the disc that touches the
//! picture's edges, so that a twig may be turned by any angle.
//!
//! Limit: needles are thrice as thick as real ones, or a crown would need ten times the twigs.

use super::shoot::{Shoot, direction};
use crate::base::{Random, Seed};
use crate::branches::twig_canvas::{Canvas, TwigTexel};
use crate::raster::Image;
use glam::DVec2;

/// How needles stand on their shoots.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Needles {
    /// Short, along both sides of every shoot: spruce, fir, redwood.
    Comb,
    /// Long, in fans: pine.
    Fan,
}

/// Shoots of a twig.
const SHOOTS: u32 = 10;

/// How far from the middle shoots begin at most, and how far off their own direction, radians.
const SPREAD: f64 = 0.42;
const ASIDE: f64 = 1.4;

/// How far from the middle anything reaches; the picture's edge is at 1.
const REACH: f64 = 0.97;

/// Brightness of the wood of a shoot.
const WOOD: f64 = 84.0;

/// `count` different twigs, `size` × `size` texels each.
pub(super) fn needle_twigs(
    needles: Needles,
    size: u32,
    count: u32,
    seed: Seed,
) -> Vec<Image<TwigTexel>> {
    let twig = |index: u32| {
        let mut random = seed.derive("needle twig", u64::from(index)).random();
        let mut canvas = Canvas::new(size);
        let turn = random.between(0.0, std::f64::consts::TAU);
        for shoot in 0..SHOOTS {
            // Neighbours are not drawn one after the other: none lies wholly above the next.
            let place = f64::from(shoot * 3 % SHOOTS) / f64::from(SHOOTS);
            let angle = turn + std::f64::consts::TAU * place + random.between(-0.3, 0.3);
            let base = direction(angle + random.between(-ASIDE, ASIDE)) * (SPREAD * random.unit());
            let room = 0.9 - base.dot(direction(angle));
            let shoot = Shoot {
                base,
                angle,
                length: room * random.between(0.62, 1.0),
                bend: random.between(-0.5, 0.5),
                light: 0.66 + 0.34 * f64::from(shoot) / f64::from(SHOOTS - 1),
            };
            match needles {
                Needles::Comb => shoot.draw_comb(&mut canvas, &mut random),
                Needles::Fan => shoot.draw_fans(&mut canvas, &mut random),
            }
        }
        canvas.reduced(128)
    };
    (0..count).map(twig).collect()
}

/// Distance of needles along a spruce's shoot, their length and half their thickness.
const COMB_STEP: f64 = 0.028;
const COMB_LENGTH: f64 = 0.105;
const COMB_HALF: f64 = 0.0065;

/// Fans of a pine's shoot, needles of a fan, their length and half their thickness.
const FANS: u32 = 3;
const FAN_NEEDLES: u32 = 24;
const FAN_LENGTH: f64 = 0.27;
const FAN_HALF: f64 = 0.0075;

impl Shoot {
    /// Side shoots first, then the shoot above them.
    fn draw_comb(&self, canvas: &mut Canvas, random: &mut Random) {
        for index in 0..5 {
            let share = 0.22 + 0.13 * f64::from(index);
            let hand = if index % 2 == 0 { 1.0 } else { -1.0 };
            let (base, angle) = self.at(share + random.between(-0.04, 0.04));
            Self {
                base,
                angle: angle + hand * random.between(0.6, 0.85),
                length: (1.0 - share) * 0.6 * self.length,
                bend: -0.4 * hand,
                light: 0.92 * self.light,
            }
            .draw_combed(canvas, random);
        }
        self.draw_combed(canvas, random);
    }

    /// The wood, and needles on both sides of it.
    fn draw_combed(&self, canvas: &mut Canvas, random: &mut Random) {
        self.draw_wood(canvas, 0.010);
        let count = (self.length / COMB_STEP).ceil() as u32;
        for index in 0..=count {
            let share = f64::from(index) / f64::from(count);
            let (place, angle) = self.at(share);
            // Shorter and more forward towards the tip.
            let length = COMB_LENGTH * (1.0 - 0.45 * share * share);
            for hand in [-1.0, 1.0] {
                let lean = 1.0 - 0.65 * share + random.between(-0.18, 0.18);
                let tip =
                    place + direction(angle + hand * lean) * (length * random.between(0.8, 1.15));
                let shade = 128.0 * self.light * random.between(0.78, 1.22);
                stroke(canvas, [place, tip], COMB_HALF, shade);
            }
        }
    }

    fn draw_fans(&self, canvas: &mut Canvas, random: &mut Random) {
        self.draw_wood(canvas, 0.014);
        for fan in 0..FANS {
            let share = (f64::from(fan) + 0.9) / f64::from(FANS) * 0.78;
            let (place, angle) = self.at(share);
            for index in 0..FAN_NEEDLES {
                let across =
                    2.0 * f64::from(index * 11 % FAN_NEEDLES) / f64::from(FAN_NEEDLES) - 1.0;
                let lean = 1.35 * across + random.between(-0.12, 0.12);
                let root = place - direction(angle) * (0.05 * random.unit());
                let length = FAN_LENGTH * random.between(0.75, 1.1);
                let shade = 128.0 * self.light * random.between(0.75, 1.25);
                let ends = [root, root + direction(angle + lean) * length];
                stroke(canvas, ends, FAN_HALF, shade);
            }
        }
    }

    fn draw_wood(&self, canvas: &mut Canvas, half: f64) {
        const PIECES: u32 = 8;
        let place = |i: u32| self.at(0.96 * f64::from(i) / f64::from(PIECES)).0;
        for i in 0..PIECES {
            stroke(canvas, [place(i), place(i + 1)], half, WOOD * self.light);
        }
    }
}

/// Draws a line; nothing of one that would leave the disc.
fn stroke(canvas: &mut Canvas, ends: [DVec2; 2], half: f64, shade: f64) {
    if ends[0].length().max(ends[1].length()) + half <= REACH {
        canvas.stroke(ends, half, shade);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: u32 = 256;

    #[test]
    fn twigs_differ_keep_within_their_disc_and_show_needles() {
        for needles in [Needles::Comb, Needles::Fan] {
            let twigs = needle_twigs(needles, SIZE, 2, Seed(3));
            assert_ne!(twigs[0], twigs[1]);
            for twig in &twigs {
                let covered = |x: u32, y: u32| twig.at(x, y).coverage >= 128;
                let mut count = 0;
                let mut edges = 0;
                for y in 0..SIZE {
                    for x in 0..SIZE {
                        let half = f64::from(SIZE) / 2.0;
                        let (dx, dy) = (f64::from(x) + 0.5 - half, f64::from(y) + 0.5 - half);
                        if dx * dx + dy * dy > half * half {
                            assert_eq!(twig.at(x, y).coverage, 0);
                        }
                        count += usize::from(covered(x, y));
                        edges += usize::from(x > 0 && covered(x, y) != covered(x - 1, y));
                    }
                }
                let share = count as f64 / f64::from(SIZE * SIZE);
                assert!((0.12..0.6).contains(&share), "{needles:?}: {share}");
                // Thin things have many edges for what they cover.
                assert!(edges * 7 > count, "{needles:?}: {edges} {count}");
            }
        }
    }
}
