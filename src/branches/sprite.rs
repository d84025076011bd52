//! Pictures of a single leaf, of a twig with needles, a tuft, a blossom: drawn once, stamped many
//! times.
//!
//! A sprite holds coverage and a shade, no colour: the painter gives each stamp its own. Paths are
//! filled without antialiasing at `FINENESS` times the size and averaged here in whole numbers,
//! so that the result does not depend on the vector unit tiny-skia was compiled for.

use super::ornament::OrnamentKind;
use tiny_skia::{Color, FillRule, Paint, Path, PathBuilder, Pixmap, Transform};

/// The kinds of leaf there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeafShape {
    /// Egg-shaped with a drawn-out tip: birch, apple, many shrubs.
    Ovate,
    /// Round, nearly as wide as long: aspen, lime.
    Round,
    /// Wavy lobes: oak.
    Lobed,
    /// Five pointed fingers: maple.
    Palmate,
    /// Long and narrow: willow.
    Lance,
    /// A piece of twig with short needles on both sides: spruce, fir.
    Brush,
    /// A fan of long needles: pine.
    Tuft,
    /// A plume of scaly twiglets: cypress.
    Spray,
    /// A long, narrow leaflet: palm.
    Blade,
}

impl LeafShape {
    /// Width against length.
    pub fn aspect(self) -> f32 {
        match self {
            Self::Ovate | Self::Brush => 0.62,
            Self::Round => 0.92,
            Self::Lobed => 0.66,
            Self::Palmate => 0.98,
            Self::Lance => 0.24,
            Self::Tuft => 0.95,
            Self::Spray => 0.5,
            Self::Blade => 0.075,
        }
    }
}

/// A stamp: coverage and shade over leaf coordinates.
#[derive(Debug, Clone)]
pub struct Sprite {
    /// [`LENGTH`] × [`WIDTH`] texels, from the base of the leaf (first row) to its tip: shade
    /// 1..=255 (128 keeps the colour), 0 where there is no leaf.
    texels: Vec<u8>,
}

/// Texels along a leaf.
pub const LENGTH: usize = 48;
/// Texels across a leaf.
pub const WIDTH: usize = 32;
/// Samples of a texel in each direction when it is drawn.
const FINENESS: usize = 4;

impl Sprite {
    /// Draws the sprite of a shape.
    ///
    /// # Panics
    /// Never: the size is fixed and not empty.
    pub fn new(shape: LeafShape) -> Self {
        Self::drawn(|pen| match shape {
            LeafShape::Ovate => pen.ovate(0.40),
            LeafShape::Round => pen.ovate(0.42),
            LeafShape::Lobed => pen.lobed(),
            LeafShape::Palmate => pen.palmate(),
            LeafShape::Lance => pen.ovate(0.38),
            LeafShape::Brush => pen.brush(),
            LeafShape::Tuft => pen.tuft(),
            LeafShape::Spray => pen.spray(),
            LeafShape::Blade => pen.blade(),
        })
    }

    /// The sprite of blossom or fruit.
    pub fn ornament(kind: OrnamentKind) -> Self {
        Self::drawn(|pen| match kind {
            OrnamentKind::Blossom => pen.blossom(),
            OrnamentKind::Fruit => pen.fruit(),
        })
    }

    fn drawn(draw: impl FnOnce(&mut Pen<'_>)) -> Self {
        let size = ((WIDTH * FINENESS) as u32, (LENGTH * FINENESS) as u32);
        let mut pixmap = Pixmap::new(size.0, size.1).expect("the size is not empty");
        draw(&mut Pen {
            pixmap: &mut pixmap,
        });
        Self {
            texels: averaged(&pixmap),
        }
    }

    /// The shade at (`along`, `across`), each 0..1 of the leaf; 0 where there is none.
    #[inline]
    pub fn shade(&self, along: f32, across: f32) -> u8 {
        let row = ((along * LENGTH as f32) as usize).min(LENGTH - 1);
        let column = ((across * WIDTH as f32) as usize).min(WIDTH - 1);
        self.texels[row * WIDTH + column]
    }

    /// Share of the sprite's rectangle that is leaf.
    pub fn coverage(&self) -> f32 {
        let leaf = self.texels.iter().filter(|&&shade| shade > 0).count();
        leaf as f32 / self.texels.len() as f32
    }
}

/// Texels from fine pixels: leaf where at least a third is leaf, with their mean grey.
fn averaged(pixmap: &Pixmap) -> Vec<u8> {
    let mut texels = vec![0; LENGTH * WIDTH];
    for (index, texel) in texels.iter_mut().enumerate() {
        let (row, column) = (index / WIDTH, index % WIDTH);
        let (mut grey, mut covered) = (0u32, 0u32);
        for fine in 0..FINENESS * FINENESS {
            let x = column * FINENESS + fine % FINENESS;
            let y = row * FINENESS + fine / FINENESS;
            let pixel = pixmap.pixels()[y * WIDTH * FINENESS + x];
            if pixel.alpha() > 0 {
                covered += 1;
                grey += u32::from(pixel.red());
            }
        }
        if covered * 3 >= (FINENESS * FINENESS) as u32 {
            *texel = (grey / covered).clamp(1, 255) as u8;
        }
    }
    texels
}

/// Draws in leaf coordinates: x −1..1 across, y 0..1 from the base to the tip.
struct Pen<'a> {
    pixmap: &'a mut Pixmap,
}

impl Pen<'_> {
    fn fill(&mut self, path: Option<Path>, grey: u8) {
        let Some(path) = path else { return };
        let mut paint = Paint::default();
        paint.set_color(Color::from_rgba8(grey, grey, grey, 255));
        paint.anti_alias = false;
        let (half, long) = ((WIDTH * FINENESS) as f32 / 2.0, (LENGTH * FINENESS) as f32);
        let to_pixels = Transform::from_row(half, 0.0, 0.0, long, half, 0.0);
        self.pixmap
            .fill_path(&path, &paint, FillRule::Winding, to_pixels, None);
    }

    /// A thin wedge from `from` to `to`, `width` wide at its start.
    fn vein(&mut self, from: (f32, f32), to: (f32, f32), width: f32, grey: u8) {
        let mut path = PathBuilder::new();
        path.move_to(from.0 - width, from.1);
        path.line_to(from.0 + width, from.1 + width * 0.3);
        path.line_to(to.0, to.1);
        path.close();
        self.fill(path.finish(), grey);
    }

    fn veins(&mut self, pairs: u32, reach: f32) {
        for pair in 0..pairs {
            let y = 0.12 + 0.62 * pair as f32 / pairs as f32;
            for hand in [-1.0, 1.0] {
                self.vein((0.0, y), (hand * reach, y + 0.16), 0.03, 142);
            }
        }
        self.vein((0.0, 0.0), (0.0, 0.96), 0.07, 156);
    }

    fn ovate(&mut self, widest: f32) {
        let mut path = PathBuilder::new();
        path.move_to(0.0, 0.0);
        path.cubic_to(0.75, 0.02, 1.25, widest, 0.72, 0.66);
        path.quad_to(0.35, 0.88, 0.0, 1.0);
        path.quad_to(-0.35, 0.88, -0.72, 0.66);
        path.cubic_to(-1.25, widest, -0.75, 0.02, 0.0, 0.0);
        path.close();
        self.fill(path.finish(), 122);
        self.veins(5, 0.6);
    }

    fn lobed(&mut self) {
        // Half-widths from base to tip; curves between them make the lobes.
        const EDGE: [(f32, f32); 9] = [
            (0.10, 0.10),
            (0.48, 0.20),
            (0.26, 0.31),
            (0.82, 0.44),
            (0.42, 0.54),
            (0.98, 0.68),
            (0.50, 0.77),
            (0.62, 0.90),
            (0.0, 1.0),
        ];
        let mut path = PathBuilder::new();
        path.move_to(0.0, 0.0);
        let mut last = (0.0, 0.0);
        for &(x, y) in &EDGE {
            path.quad_to(x.max(last.0), (last.1 + y) * 0.5 - 0.02, x, y);
            last = (x, y);
        }
        for &(x, y) in EDGE.iter().rev().skip(1) {
            path.quad_to(-x.max(last.0), (last.1 + y) * 0.5 + 0.02, -x, y);
            last = (x, y);
        }
        path.close();
        self.fill(path.finish(), 122);
        self.veins(4, 0.7);
    }

    fn palmate(&mut self) {
        const EDGE: [(f32, f32); 10] = [
            (0.10, 0.14),
            (0.62, 0.08),
            (0.50, 0.22),
            (1.00, 0.36),
            (0.80, 0.46),
            (0.88, 0.66),
            (0.46, 0.60),
            (0.36, 0.66),
            (0.34, 0.82),
            (0.0, 1.0),
        ];
        let mut path = PathBuilder::new();
        path.move_to(0.0, 0.0);
        for &(x, y) in &EDGE {
            path.line_to(x, y);
        }
        for &(x, y) in EDGE.iter().rev().skip(1) {
            path.line_to(-x, y);
        }
        path.close();
        self.fill(path.finish(), 122);
        for hand in [-1.0, 1.0] {
            self.vein((0.0, 0.12), (hand * 0.9, 0.37), 0.05, 148);
            self.vein((0.0, 0.14), (hand * 0.8, 0.62), 0.05, 148);
        }
        self.vein((0.0, 0.0), (0.0, 0.95), 0.06, 156);
    }

    fn brush(&mut self) {
        for needle in 0..26u32 {
            let y = 0.01 + 0.70 * needle as f32 / 26.0;
            let hand = if needle % 2 == 0 { 1.0 } else { -1.0 };
            // Needles of unequal length and light, by a fixed pattern.
            let long = 0.72 + 0.09 * ((needle * 5) % 4) as f32;
            let grey = 98 + 12 * ((needle * 7) % 5) as u8;
            self.vein((0.0, y), (hand * long, y + 0.24), 0.085, grey);
        }
        self.vein((0.0, 0.55), (0.0, 1.0), 0.12, 140);
        self.vein((0.0, 0.0), (0.0, 0.85), 0.08, 92);
    }

    fn tuft(&mut self) {
        for needle in 0..23u32 {
            let turn = ((needle * 9) % 23) as f32 / 11.0 - 1.0;
            let long = 0.66 + 0.085 * ((needle * 5) % 5) as f32;
            let grey = 70 + 18 * ((needle * 7) % 6) as u8;
            let tip = (turn * long, long * (1.0 - 0.62 * turn * turn));
            let root = 0.1 * ((needle * 3) % 4) as f32;
            self.vein((turn * 0.03, root), tip, 0.03, grey);
        }
    }

    /// Twiglets in pairs that carry shorter ones, all of them scaly and slender.
    fn spray(&mut self) {
        for pair in 0..9u32 {
            let y = 0.04 + 0.085 * pair as f32;
            let long = 0.95 - 0.075 * pair as f32;
            for hand in [-1.0, 1.0] {
                let shift = if hand > 0.0 { 0.03 } else { 0.0 };
                let grey = 104 + 13 * ((pair * 5 + u32::from(hand > 0.0)) % 4) as u8;
                let tip = (hand * long * 0.9, (y + shift + 0.34).min(1.0));
                self.vein((0.0, y + shift), tip, 0.11, grey);
                let fork = (hand * long * 0.4, y + shift + 0.12);
                self.vein(
                    fork,
                    (hand * long * 0.38, (fork.1 + 0.22).min(1.0)),
                    0.09,
                    grey + 10,
                );
            }
        }
        self.vein((0.0, 0.0), (0.0, 1.0), 0.13, 118);
    }

    fn blade(&mut self) {
        let mut path = PathBuilder::new();
        path.move_to(-0.35, 0.0);
        path.quad_to(-1.35, 0.35, 0.0, 1.0);
        path.quad_to(1.35, 0.35, 0.35, 0.0);
        path.close();
        self.fill(path.finish(), 124);
        self.vein((0.0, 0.0), (0.0, 0.95), 0.16, 150);
    }

    fn blossom(&mut self) {
        for petal in 0..5u32 {
            let angle = petal as f32 * std::f32::consts::TAU / 5.0 + 0.3;
            let (x, y) = (libm::cosf(angle), libm::sinf(angle));
            let grey = 118 + 5 * (petal * 2 % 5) as u8;
            self.ball((x * 0.55, 0.5 + y * 0.275), 0.42, grey);
        }
        self.ball((0.0, 0.5), 0.16, 92);
    }

    /// A ball, lit from the upper left as everything here; its stalk end is the base.
    fn fruit(&mut self) {
        for (shift, radius, grey) in [
            (0.0, 0.92, 84),
            (0.08, 0.80, 112),
            (0.18, 0.62, 132),
            (0.30, 0.36, 150),
            (0.36, 0.14, 200),
        ] {
            self.ball((-shift, 0.5 - shift * 0.5), radius, grey);
        }
    }

    /// A disc in a square leaf: `radius` and the x of `centre` in half-widths, its y in lengths.
    fn ball(&mut self, centre: (f32, f32), radius: f32, grey: u8) {
        /// Control points of a quarter circle by a cubic.
        const ROUND: f32 = 0.5523;
        let (x, y) = centre;
        let (rx, ry) = (radius, radius * 0.5);
        let (cx, cy) = (rx * ROUND, ry * ROUND);
        let mut path = PathBuilder::new();
        path.move_to(x + rx, y);
        path.cubic_to(x + rx, y + cy, x + cx, y + ry, x, y + ry);
        path.cubic_to(x - cx, y + ry, x - rx, y + cy, x - rx, y);
        path.cubic_to(x - rx, y - cy, x - cx, y - ry, x, y - ry);
        path.cubic_to(x + cx, y - ry, x + rx, y - cy, x + rx, y);
        path.close();
        self.fill(path.finish(), grey);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_covers_a_fair_share_and_is_attached_at_its_base() {
        for shape in [
            LeafShape::Ovate,
            LeafShape::Round,
            LeafShape::Lobed,
            LeafShape::Palmate,
            LeafShape::Lance,
            LeafShape::Brush,
            LeafShape::Tuft,
            LeafShape::Spray,
            LeafShape::Blade,
        ] {
            let sprite = Sprite::new(shape);
            let coverage = sprite.coverage();
            assert!((0.1..0.9).contains(&coverage), "{shape:?}: {coverage}");
            assert!(sprite.shade(0.3, 0.5) > 0, "{shape:?}");
        }
    }
}
