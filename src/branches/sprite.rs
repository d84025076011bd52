//! Pictures of a single leaf, of a twig with needles, of a tuft: drawn once, stamped many times.
//!
//! A sprite holds coverage and a shade, no colour: the painter gives each stamp its own. Paths are
//! filled without antialiasing at `FINENESS` times the size and averaged here in whole numbers,
//! so that the result does not depend on the vector unit tiny-skia was compiled for.

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
}

/// A stamp: coverage and shade over leaf coordinates.
#[derive(Debug, Clone)]
pub struct Sprite {
    /// Width against length of the leaf.
    pub aspect: f32,
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
        let size = ((WIDTH * FINENESS) as u32, (LENGTH * FINENESS) as u32);
        let mut pixmap = Pixmap::new(size.0, size.1).expect("the size is not empty");
        let mut pen = Pen {
            pixmap: &mut pixmap,
        };
        let aspect = match shape {
            LeafShape::Ovate => pen.ovate(0.62, 0.40),
            LeafShape::Round => pen.ovate(0.92, 0.42),
            LeafShape::Lobed => pen.lobed(),
            LeafShape::Palmate => pen.palmate(),
            LeafShape::Lance => pen.ovate(0.24, 0.38),
            LeafShape::Brush => pen.brush(),
            LeafShape::Tuft => pen.tuft(),
        };
        Self {
            aspect,
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

    fn ovate(&mut self, aspect: f32, widest: f32) -> f32 {
        let mut path = PathBuilder::new();
        path.move_to(0.0, 0.0);
        path.cubic_to(0.75, 0.02, 1.25, widest, 0.72, 0.66);
        path.quad_to(0.35, 0.88, 0.0, 1.0);
        path.quad_to(-0.35, 0.88, -0.72, 0.66);
        path.cubic_to(-1.25, widest, -0.75, 0.02, 0.0, 0.0);
        path.close();
        self.fill(path.finish(), 122);
        self.veins(5, 0.6);
        aspect
    }

    fn lobed(&mut self) -> f32 {
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
        0.66
    }

    fn palmate(&mut self) -> f32 {
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
        0.98
    }

    fn brush(&mut self) -> f32 {
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
        0.62
    }

    fn tuft(&mut self) -> f32 {
        for needle in 0..19u32 {
            let turn = ((needle * 8) % 19) as f32 / 9.0 - 1.0;
            let long = 0.74 + 0.065 * ((needle * 5) % 5) as f32;
            let grey = 74 + 17 * ((needle * 7) % 6) as u8;
            let tip = (turn * long, long * (1.0 - 0.45 * turn * turn));
            let root = 0.12 * ((needle * 3) % 4) as f32;
            self.vein((turn * 0.05, root), tip, 0.042, grey);
        }
        0.95
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
        ] {
            let sprite = Sprite::new(shape);
            let coverage = sprite.coverage();
            assert!((0.1..0.9).contains(&coverage), "{shape:?}: {coverage}");
            assert!(sprite.shade(0.3, 0.5) > 0, "{shape:?}");
        }
    }
}
