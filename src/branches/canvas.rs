//! The painter's canvas: colour, depth and meaning for several samples a pixel.
//!
//! A depth buffer instead of a sorted list: at [`FINENESS`]² opaque samples a pixel every stamp
//! either covers a sample or not, so the order of painting does not matter, coverage at edges is
//! exact to a ninth, and no stamp bleeds through another.

use crate::raster::{Image, Straight};

/// Samples of a pixel in each direction.
pub const FINENESS: usize = 3;

/// What a sample shows; the numbers are those of label images.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub enum Part {
    /// Nothing.
    Background = 0,
    /// Stem and main limbs below the lowest foliage.
    Trunk = 128,
    /// Leaves, twigs, and the limbs among them.
    Crown = 255,
}

/// Colour, depth and part of every sample.
pub struct Canvas {
    width: usize,
    height: usize,
    colour: Vec<[u8; 4]>,
    depth: Vec<f32>,
}

impl Canvas {
    /// An empty canvas for an image of `width` × `height` pixels.
    pub fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize * FINENESS, height as usize * FINENESS);
        Self {
            width,
            height,
            colour: vec![[0; 4]; width * height],
            depth: vec![f32::NEG_INFINITY; width * height],
        }
    }

    /// Samples in a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Rows of samples.
    pub fn height(&self) -> usize {
        self.height
    }

    /// Paints a sample, which must be inside, unless something nearer is there.
    #[inline]
    pub fn put(&mut self, x: usize, y: usize, depth: f32, colour: [u8; 3], part: Part) {
        let index = y * self.width + x;
        if depth > self.depth[index] {
            self.depth[index] = depth;
            self.colour[index] = [colour[0], colour[1], colour[2], part as u8];
        }
    }

    /// Whether a sample, which must be inside, is nearer than what is there.
    #[inline]
    pub fn sees(&self, x: usize, y: usize, depth: f32) -> bool {
        depth > self.depth[y * self.width + x]
    }

    /// The picture: colours are means over the covered samples, alpha is their share.
    ///
    /// Colours keep six bits: among leaves nobody sees the step, and files lose a third.
    pub fn image(&self) -> Image<Straight> {
        self.reduced(|samples| {
            let mut sum = [0u32; 3];
            let mut covered = 0;
            for sample in samples {
                if sample[3] != Part::Background as u8 {
                    covered += 1;
                    for (sum, &channel) in sum.iter_mut().zip(sample) {
                        *sum += u32::from(channel);
                    }
                }
            }
            if covered == 0 {
                return Straight([0; 4]);
            }
            let [r, g, b] = sum.map(|sum| six_bits((sum + covered / 2) / covered));
            let all = (FINENESS * FINENESS) as u32;
            Straight([r, g, b, ((covered * 255 + all / 2) / all) as u8])
        })
    }

    /// The labels: the part most of a pixel's covered samples show, where at least half are.
    pub fn labels(&self) -> Image<u8> {
        self.reduced(|samples| {
            let count = |part: Part| samples.iter().filter(|s| s[3] == part as u8).count();
            let (trunk, crown) = (count(Part::Trunk), count(Part::Crown));
            if (trunk + crown) * 2 < FINENESS * FINENESS {
                Part::Background as u8
            } else if trunk > crown {
                Part::Trunk as u8
            } else {
                Part::Crown as u8
            }
        })
    }

    fn reduced<P: Copy>(&self, pixel: impl Fn(&[[u8; 4]; FINENESS * FINENESS]) -> P) -> Image<P> {
        let (width, height) = (self.width / FINENESS, self.height / FINENESS);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let mut samples = [[0; 4]; FINENESS * FINENESS];
                for row in 0..FINENESS {
                    let start = (y * FINENESS + row) * self.width + x * FINENESS;
                    samples[row * FINENESS..(row + 1) * FINENESS]
                        .copy_from_slice(&self.colour[start..start + FINENESS]);
                }
                pixels.push(pixel(&samples));
            }
        }
        Image::from_pixels(width as u32, height as u32, pixels)
    }
}

/// The nearest multiple of 4, at most 252.
fn six_bits(channel: u32) -> u8 {
    ((channel + 2) & !3).min(252) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearer_sample_stays_and_alpha_counts_samples() {
        let mut canvas = Canvas::new(1, 1);
        canvas.put(0, 0, 1.0, [90, 0, 0], Part::Crown);
        canvas.put(0, 0, 0.0, [0, 90, 0], Part::Trunk);
        assert_eq!(canvas.image().at(0, 0), Straight([92, 0, 0, 28]));
        assert_eq!(canvas.labels().at(0, 0), 0);
        for i in 1..6 {
            canvas.put(i % 3, i / 3, 0.0, [0, 90, 0], Part::Trunk);
        }
        assert_eq!(canvas.labels().at(0, 0), 128);
    }
}
