//! The picture under way: sRGB colours in 0..255 with fractions, and the camera that made it.

use crate::raster::{Image, Straight};
use glam::Vec3;

/// An opaque picture of fractional colours.
pub(super) struct Frame {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) pixels: Vec<Vec3>,
}

/// A camera that looks level along −z over the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    /// Focal length in pixels.
    pub(super) focal_px: f32,
    /// Column that the camera looks at: x is 0 there.
    pub(super) middle_px: f32,
    /// Row of the horizon.
    pub(super) horizon_px: f32,
    /// Height above the ground in metres.
    pub(super) height_m: f32,
}

impl Camera {
    /// Column and row of a place at x metres to the right and y above the ground, `away_m` off.
    pub(super) fn pixel(&self, x: f32, y: f32, away_m: f32) -> (f32, f32) {
        let scale = self.focal_px / away_m;
        (
            self.middle_px + x * scale,
            self.horizon_px + (self.height_m - y) * scale,
        )
    }

    /// x and distance in metres of the ground that a pixel below the horizon shows.
    pub(super) fn ground(&self, column: f32, row: f32) -> (f32, f32) {
        let away_m = self.height_m * self.focal_px / (row - self.horizon_px).max(0.05);
        ((column - self.middle_px) * away_m / self.focal_px, away_m)
    }
}

impl Frame {
    pub(super) fn new(width: u32, height: u32) -> Self {
        let (width, height) = (width as usize, height as usize);
        Self {
            width,
            height,
            pixels: vec![Vec3::ZERO; width * height],
        }
    }

    /// Lays `colour` over a pixel by `share`; nothing happens outside.
    pub(super) fn blend(&mut self, x: i64, y: i64, colour: Vec3, share: f32) {
        let inside = |value: i64, size: usize| usize::try_from(value).ok().filter(|&v| v < size);
        if let (Some(x), Some(y)) = (inside(x, self.width), inside(y, self.height)) {
            let pixel = &mut self.pixels[y * self.width + x];
            *pixel = pixel.lerp(colour, share.clamp(0.0, 1.0));
        }
    }

    /// Draws a cut-out picture with its upper left corner at `corner`.
    pub(super) fn draw(
        &mut self,
        image: &Image<Straight>,
        corner: (i64, i64),
        tint: impl Fn(Vec3) -> Vec3,
    ) {
        for y in 0..image.height() {
            for (x, pixel) in (0..).zip(image.row(y)) {
                let [r, g, b, alpha] = pixel.0;
                if alpha > 0 {
                    let colour = Vec3::from_array([r, g, b].map(f32::from));
                    let share = f32::from(alpha) / 255.0;
                    self.blend(corner.0 + x, corner.1 + i64::from(y), tint(colour), share);
                }
            }
        }
    }

    /// A Gaussian blur of standard deviation `sigma` pixels.
    pub(super) fn blur(&mut self, sigma: f32) {
        let reach = libm::ceilf(2.5 * sigma) as usize;
        let weight = |i: usize| libm::expf(-((i * i) as f32) / (2.0 * sigma * sigma));
        let weights: Vec<f32> = (0..=reach).map(weight).collect();
        let sum = 2.0 * weights.iter().sum::<f32>() - weights[0];
        let weights: Vec<f32> = weights.iter().map(|w| w / sum).collect();
        let (width, height) = (self.width, self.height);
        self.blur_lines(&weights, (height, width), (width, 1));
        self.blur_lines(&weights, (width, height), (1, width));
    }

    /// Blurs `lines.0` lines of `lines.1` pixels: `steps` lead from line to line, pixel to pixel.
    fn blur_lines(&mut self, weights: &[f32], lines: (usize, usize), steps: (usize, usize)) {
        let mut line = vec![Vec3::ZERO; lines.1];
        for start in (0..lines.0).map(|index| index * steps.0) {
            for (i, pixel) in line.iter_mut().enumerate() {
                *pixel = self.pixels[start + i * steps.1];
            }
            for i in 0..lines.1 {
                let mut sum = line[i] * weights[0];
                for (apart, &weight) in weights.iter().enumerate().skip(1) {
                    let (low, high) = (i.saturating_sub(apart), (i + apart).min(lines.1 - 1));
                    sum += (line[low] + line[high]) * weight;
                }
                self.pixels[start + i * steps.1] = sum;
            }
        }
    }

    /// The picture in whole colours.
    pub(super) fn image(&self) -> Image<Straight> {
        let pixels = self.pixels.iter().map(|pixel| {
            let [r, g, b] = pixel.to_array().map(|c| (c + 0.5).clamp(0.0, 255.0) as u8);
            Straight([r, g, b, 255])
        });
        Image::from_pixels(self.width as u32, self.height as u32, pixels.collect())
    }
}
