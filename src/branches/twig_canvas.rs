//! A picture of a twig while it is drawn, in fine samples: [`super::twigs`] stamps leaves on it, and who draws
//! needles and fronds lines.

use crate::raster::Image;
use glam::DVec2;

/// A texel of a twig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TwigTexel {
    /// Brightness: 128 keeps the colour that the twig is given.
    pub shade: u8,
    /// How much of the texel is leaf, 0 … 255.
    pub coverage: u8,
}

/// Samples along a side of a texel.
const FINENESS: u32 = 3;

/// A picture from −1 to 1 in both directions, in fine samples; 0: nothing.
pub(crate) struct Canvas {
    /// Samples along a side.
    pub(super) size: u32,
    pub(super) shades: Vec<u8>,
}

impl Canvas {
    /// A clear canvas for a picture of `texels` × `texels`.
    pub(crate) fn new(texels: u32) -> Self {
        let size = texels * FINENESS;
        Self {
            size,
            shades: vec![0; (size * size) as usize],
        }
    }

    /// Draws a straight line of an even shade with round ends; later lines lie above.
    pub(crate) fn stroke(&mut self, [from, to]: [DVec2; 2], half: f64, shade: f64) {
        let middle = f64::from(self.size) / 2.0;
        let range = |a: f64, b: f64| {
            let low = ((a.min(b) - half + 1.0) * middle).max(0.0) as u32;
            let high = ((a.max(b) + half + 1.0) * middle) as u32 + 1;
            low..high.min(self.size)
        };
        let along = to - from;
        let per_length = 1.0 / along.length_squared().max(1e-12);
        for y in range(from.y, to.y) {
            for x in range(from.x, to.x) {
                let place = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5) / middle - 1.0;
                let share = ((place - from).dot(along) * per_length).clamp(0.0, 1.0);
                if (from + along * share).distance(place) <= half {
                    self.shades[(y * self.size + x) as usize] = shade.clamp(1.0, 255.0) as u8;
                }
            }
        }
    }

    /// The mean of the samples of each texel; those without any have the shade `clear`.
    pub(crate) fn reduced(&self, clear: u8) -> Image<TwigTexel> {
        let size = self.size / FINENESS;
        let texels = (0..size * size).map(|i| {
            let (left, top) = (i % size * FINENESS, i / size * FINENESS);
            let (mut sum, mut covered) = (0u32, 0u32);
            for sample in 0..FINENESS * FINENESS {
                let (x, y) = (left + sample % FINENESS, top + sample / FINENESS);
                let shade = self.shades[(y * self.size + x) as usize];
                sum += u32::from(shade);
                covered += u32::from(shade > 0);
            }
            TwigTexel {
                shade: sum.checked_div(covered).map_or(clear, |shade| shade as u8),
                coverage: (covered * 255 / (FINENESS * FINENESS)) as u8,
            }
        });
        Image::from_pixels(size, size, texels.collect())
    }
}
