//! The painter's canvas: colour, depth, meaning and, if asked, direction for several samples a
//! pixel.
//!
//! A depth buffer instead of a sorted list: at [`FINENESS`]² opaque samples a pixel every stamp
//! either covers a sample or not, so the order of painting does not matter, coverage at edges is
//! exact to a ninth, and no stamp bleeds through another.

use crate::raster::{Image, Straight};
use glam::Vec3;

/// Samples of a pixel in each direction.
pub const FINENESS: usize = 3;

/// Samples of a pixel.
const ALL: usize = FINENESS * FINENESS;

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

/// What is painted on a sample.
#[derive(Debug, Clone, Copy)]
pub struct Dab {
    /// sRGB.
    pub colour: [u8; 3],
    /// What it belongs to.
    pub part: Part,
    /// Unit normal, towards the viewer.
    pub normal: Vec3,
}

/// Colour, depth and part of every sample.
pub struct Canvas {
    width: usize,
    height: usize,
    colour: Vec<[u8; 4]>,
    depth: Vec<f32>,
    /// Empty unless normals are kept.
    normals: Vec<[i8; 3]>,
}

/// Depth of a picture in whole steps.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthImage {
    /// 0 where there is nothing, else 1 for the farthest place and more for nearer ones.
    pub steps: Image<u16>,
    /// z, towards the viewer from the stem's foot, of step 0 in metres.
    pub offset_m: f32,
    /// Metres of z in a step.
    pub step_m: f32,
}

impl Canvas {
    /// An empty canvas for an image of `width` × `height` pixels, with or without normals.
    pub fn new(width: u32, height: u32, with_normals: bool) -> Self {
        let (width, height) = (width as usize * FINENESS, height as usize * FINENESS);
        let normals = if with_normals { width * height } else { 0 };
        Self {
            width,
            height,
            colour: vec![[0; 4]; width * height],
            depth: vec![f32::NEG_INFINITY; width * height],
            normals: vec![[0; 3]; normals],
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
    pub fn put(&mut self, x: usize, y: usize, depth: f32, dab: &Dab) {
        let index = y * self.width + x;
        if depth > self.depth[index] {
            self.depth[index] = depth;
            let [r, g, b] = dab.colour;
            self.colour[index] = [r, g, b, dab.part as u8];
            if let Some(normal) = self.normals.get_mut(index) {
                *normal = (dab.normal * 127.0).to_array().map(|c| c as i8);
            }
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
        self.reduced(|canvas, samples| {
            let mut sum = [0u32; 3];
            let mut covered = 0;
            for sample in samples.map(|index| canvas.colour[index]) {
                if sample[3] != Part::Background as u8 {
                    covered += 1;
                    for (sum, channel) in sum.iter_mut().zip(sample) {
                        *sum += u32::from(channel);
                    }
                }
            }
            if covered == 0 {
                return Straight([0; 4]);
            }
            let [r, g, b] = sum.map(|sum| six_bits((sum + covered / 2) / covered));
            let all = ALL as u32;
            Straight([r, g, b, ((covered * 255 + all / 2) / all) as u8])
        })
    }

    /// The labels: the part most of a pixel's covered samples show, where at least half are.
    pub fn labels(&self) -> Image<u8> {
        self.reduced(|canvas, samples| {
            let parts = samples.map(|index| canvas.colour[index][3]);
            let count = |part: Part| parts.iter().filter(|&&p| p == part as u8).count();
            let (trunk, crown) = (count(Part::Trunk), count(Part::Crown));
            if (trunk + crown) * 2 < ALL {
                Part::Background as u8
            } else if trunk > crown {
                Part::Trunk as u8
            } else {
                Part::Crown as u8
            }
        })
    }

    /// Depth of the nearest sample of each pixel.
    pub fn depth(&self) -> DepthImage {
        let nearest = self.reduced(|canvas, samples| {
            let depths = samples.map(|index| canvas.depth[index]);
            depths.into_iter().fold(f32::NEG_INFINITY, f32::max)
        });
        let seen = || nearest.pixels().iter().copied().filter(|z| z.is_finite());
        let (far, near) = (seen().fold(0.0, f32::min), seen().fold(0.0, f32::max));
        let step_m = ((near - far) / 65_534.0).max(1e-6);
        let offset_m = far - step_m;
        let steps = nearest.map(|&z| {
            if z.is_finite() {
                ((z - offset_m) / step_m + 0.5).clamp(1.0, 65_535.0) as u16
            } else {
                0
            }
        });
        DepthImage {
            steps,
            offset_m,
            step_m,
        }
    }

    /// Mean normals of the covered samples, x right, y up, z to the viewer, 128 for 0; alpha as in
    /// [`Canvas::image`]. All clear on a canvas without normals.
    pub fn normals(&self) -> Image<Straight> {
        self.reduced(|canvas, samples| {
            let mut sum = Vec3::ZERO;
            let mut covered = 0u32;
            for index in samples {
                if canvas.colour[index][3] != Part::Background as u8 {
                    let normal = canvas.normals.get(index).copied().unwrap_or_default();
                    sum += Vec3::from_array(normal.map(f32::from));
                    covered += 1;
                }
            }
            if covered == 0 || canvas.normals.is_empty() {
                return Straight([0; 4]);
            }
            let mean = sum.normalize_or(Vec3::Z) * 127.0 + Vec3::splat(128.5);
            let [x, y, z] = mean.to_array().map(|c| c as u8);
            Straight([x, y, z, (covered * 255 / ALL as u32) as u8])
        })
    }

    fn reduced<P: Copy>(&self, pixel: impl Fn(&Self, [usize; ALL]) -> P) -> Image<P> {
        let (width, height) = (self.width / FINENESS, self.height / FINENESS);
        let mut pixels = Vec::with_capacity(width * height);
        for y in 0..height {
            for x in 0..width {
                let corner = y * FINENESS * self.width + x * FINENESS;
                let samples: [usize; ALL] =
                    std::array::from_fn(|i| corner + i / FINENESS * self.width + i % FINENESS);
                pixels.push(pixel(self, samples));
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

    fn dab(colour: [u8; 3], part: Part) -> Dab {
        Dab {
            colour,
            part,
            normal: Vec3::Z,
        }
    }

    #[test]
    fn the_nearer_sample_stays_and_alpha_counts_samples() {
        let mut canvas = Canvas::new(1, 1, true);
        canvas.put(0, 0, 1.0, &dab([92, 4, 4], Part::Crown));
        canvas.put(0, 0, 0.0, &dab([0, 90, 0], Part::Trunk));
        assert_eq!(canvas.image().at(0, 0), Straight([92, 4, 4, 28]));
        assert_eq!(canvas.labels().at(0, 0), 0);
        for i in 1..6 {
            canvas.put(i % 3, i / 3, 0.0, &dab([0, 90, 0], Part::Trunk));
        }
        assert_eq!(canvas.labels().at(0, 0), 128);
        assert_eq!(canvas.normals().at(0, 0).0[..3], [128, 128, 255]);
        let depth = canvas.depth();
        let z = depth.offset_m + f32::from(depth.steps.at(0, 0)) * depth.step_m;
        assert!((z - 1.0).abs() < 1e-3, "{z}");
    }
}
