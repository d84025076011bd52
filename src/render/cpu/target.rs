//! What the passes draw into: light and depth of every sample.

use crate::raster::Image;
use rayon::prelude::*;

/// Rows that are drawn together.
const BAND: u32 = 16;

/// Light (linear, premultiplied by coverage) and depth (near / distance, 0 where nothing is).
pub(super) struct Target {
    width: u32,
    height: u32,
    light: Vec<[f32; 4]>,
    depth: Vec<f32>,
}

/// Some rows of a [`Target`].
pub(super) struct Band<'a> {
    pub(super) width: u32,
    /// First row, and the one after the last.
    pub(super) rows: (u32, u32),
    light: &'a mut [[f32; 4]],
    depth: &'a mut [f32],
}

impl Target {
    pub(super) fn new([width, height]: [u32; 2]) -> Self {
        let count = width as usize * height as usize;
        Self {
            width,
            height,
            light: vec![[0.0; 4]; count],
            depth: vec![0.0; count],
        }
    }

    pub(super) fn band_count(&self) -> u64 {
        u64::from(self.height.div_ceil(BAND))
    }

    /// Calls `draw` for every band, on all threads.
    pub(super) fn for_bands(&mut self, draw: impl Fn(&mut Band<'_>) + Sync) {
        let (width, height) = (self.width, self.height);
        let count = (width * BAND) as usize;
        let light = self.light.par_chunks_mut(count);
        let depth = self.depth.par_chunks_mut(count);
        light
            .zip(depth)
            .enumerate()
            .for_each(|(i, (light, depth))| {
                let top = i as u32 * BAND;
                draw(&mut Band {
                    width,
                    rows: (top, height.min(top + BAND)),
                    light,
                    depth,
                });
            });
    }

    pub(super) fn width(&self) -> u32 {
        self.width
    }

    /// The depth of all samples.
    pub(super) fn depth(&self) -> Image<f32> {
        Image::from_pixels(self.width, self.height, self.depth.clone())
    }

    pub(super) fn light(&self, x: u32, y: u32) -> [f32; 4] {
        self.light[y as usize * self.width as usize + x as usize]
    }
}

impl Band<'_> {
    #[inline(always)]
    fn index(&self, x: u32, y: u32) -> usize {
        ((y - self.rows.0) * self.width + x) as usize
    }

    /// Whether something at `depth` would be seen at (x, y).
    #[inline(always)]
    pub(super) fn shows(&self, x: u32, y: u32, depth: f32) -> bool {
        depth > self.depth[self.index(x, y)]
    }

    /// Puts opaque `light` at (x, y) if it is nearer than what is there.
    #[inline(always)]
    pub(super) fn put(&mut self, x: u32, y: u32, depth: f32, light: [f32; 4]) {
        let index = self.index(x, y);
        if depth > self.depth[index] {
            self.depth[index] = depth;
            self.light[index] = light;
        }
    }

    /// Leaves a share of the light at (x, y).
    #[inline(always)]
    pub(super) fn darken(&mut self, x: u32, y: u32, share: f32) {
        let index = self.index(x, y);
        let [r, g, b, alpha] = self.light[index];
        self.light[index] = [r * share, g * share, b * share, alpha];
    }

    /// Puts what is behind everything.
    #[inline(always)]
    pub(super) fn put_behind(&mut self, x: u32, y: u32, light: [f32; 4]) {
        let index = self.index(x, y);
        self.light[index] = light;
    }
}
