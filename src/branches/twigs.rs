//! Pictures of twigs full of leaves: what a renderer that cannot draw every leaf stamps in their
//! place.
//!
//! Some stems leave the middle of the picture in all directions, with leaves to both sides; those
//! that were drawn first lie below and are darker. The outline is ragged and stays within the disc
//! that touches the picture's edges, so that a twig may be turned by any angle. Leaves have the
//! shapes of [`super::sprite`].

use super::sprite::{LeafShape, Sprite};
use super::twig_canvas::{Canvas, TwigTexel};
use crate::base::{Random, Seed};
use crate::raster::Image;

/// Leaves of a twig, and their length, by shape: large leaves are few.
fn habit(shape: LeafShape) -> (u32, f64) {
    match shape {
        LeafShape::Ovate => (86, 0.165),
        LeafShape::Round => (70, 0.165),
        LeafShape::Lobed => (60, 0.20),
        LeafShape::Palmate => (48, 0.22),
        LeafShape::Lance => (140, 0.22),
        LeafShape::Brush => (60, 0.30),
        LeafShape::Tuft => (44, 0.34),
        LeafShape::Spray => (50, 0.34),
        LeafShape::Blade => (60, 0.55),
    }
}

/// `count` different twigs with leaves of `shape`, `size` × `size` texels each.
pub fn twigs(shape: LeafShape, size: u32, count: u32, seed: Seed) -> Vec<Image<TwigTexel>> {
    let sprite = Sprite::new(shape);
    let twig = |index: u32| {
        let mut random = seed.derive("twig", u64::from(index)).random();
        let mut canvas = Canvas::new(size);
        for leaf in leaves(shape, &mut random) {
            canvas.stamp(&sprite, shape, &leaf);
        }
        canvas.reduced(0)
    };
    (0..count).map(twig).collect()
}

/// A leaf of a twig, in a picture from −1 to 1.
struct Leaf {
    /// Where it is attached.
    base: (f64, f64),
    /// Unit vector along it.
    along: (f64, f64),
    length: f64,
    /// Factor on its brightness.
    light: f64,
}

/// The leaves of a twig, lowest first.
fn leaves(shape: LeafShape, random: &mut Random) -> Vec<Leaf> {
    let (count, length) = habit(shape);
    let stems = 5;
    let start = random.unit();
    (0..count)
        .map(|index| {
            let layer = f64::from(index) / f64::from(count);
            let turn = |share: f64| {
                let angle = share * std::f64::consts::TAU;
                (libm::cos(angle), libm::sin(angle))
            };
            let stem = start + f64::from(index % stems) / f64::from(stems);
            let bend = random.between(-0.07, 0.07);
            // Leaves keep to the outer part below, to the inner part above.
            let room = 0.94 - length;
            let out = room * (random.unit() * (1.0 - 0.45 * layer)).sqrt();
            let (x, y) = turn(stem + bend);
            let side = if index / stems % 2 == 0 { 0.11 } else { -0.11 };
            Leaf {
                base: (x * out, y * out),
                along: turn(stem + bend + side * random.between(0.4, 1.8)),
                length: length * random.between(0.75, 1.2),
                light: 0.62 + 0.38 * layer + random.between(-0.2, 0.2),
            }
        })
        .collect()
}

impl Canvas {
    fn stamp(&mut self, sprite: &Sprite, shape: LeafShape, leaf: &Leaf) {
        let half = f64::from(self.size) / 2.0;
        let width = leaf.length * f64::from(shape.aspect());
        let reach = leaf.length + width;
        let range = |middle: f64| {
            let low = ((middle - reach + 1.0) * half).max(0.0) as u32;
            let high = ((middle + reach + 1.0) * half).max(0.0) as u32;
            low..high.min(self.size)
        };
        let (columns, rows) = (range(leaf.base.0), range(leaf.base.1));
        for y in rows {
            for x in columns.clone() {
                let place = |i: u32| (f64::from(i) + 0.5) / half - 1.0;
                let (dx, dy) = (place(x) - leaf.base.0, place(y) - leaf.base.1);
                let along = (dx * leaf.along.0 + dy * leaf.along.1) / leaf.length;
                let across = (dy * leaf.along.0 - dx * leaf.along.1) / width + 0.5;
                if !(0.0..1.0).contains(&along) || !(0.0..1.0).contains(&across) {
                    continue;
                }
                let shade = sprite.shade(along as f32, across as f32);
                if shade > 0 {
                    let lit = (f64::from(shade) * leaf.light).clamp(1.0, 255.0);
                    self.shades[(y * self.size + x) as usize] = lit as u8;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn twigs_differ_fill_their_disc_and_leave_the_corners_clear() {
        for shape in [
            LeafShape::Ovate,
            LeafShape::Lobed,
            LeafShape::Brush,
            LeafShape::Tuft,
        ] {
            let twigs = twigs(shape, 64, 3, Seed(5));
            assert_ne!(twigs[0], twigs[1]);
            for twig in &twigs {
                let sum: u32 = twig.pixels().iter().map(|t| u32::from(t.coverage)).sum();
                let share = f64::from(sum) / (255.0 * 64.0 * 64.0);
                assert!((0.08..0.8).contains(&share), "{shape:?}: {share}");
                for (x, y) in [(0, 0), (63, 0), (0, 63), (63, 63)] {
                    assert_eq!(twig.at(x, y).coverage, 0);
                }
            }
        }
    }
}
