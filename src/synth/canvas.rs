//! A texture in the making, at one level of detail: for each pixel a place in the exemplar.

use super::exemplar::Exemplar;
use super::level::{Color, Level, blurred};
use super::similar::NOWHERE;
use crate::raster::{Image, Straight};

/// Pixels of a texture that are settled before it is made; `None` is to be filled.
pub type Known = Image<Option<[u8; 3]>>;

/// A texture at one level: pixel (x, y) stands for pixel (x · step, y · step) of the finest level.
#[derive(Debug, Clone)]
pub(super) struct Canvas {
    pub(super) width: usize,
    pub(super) height: usize,
    /// Whether the right edge continues at the left one.
    pub(super) tiles_x: bool,
    /// Indices into the exemplar's level; [`NOWHERE`] for pixels that are given or still empty.
    pub(super) places: Vec<u32>,
    /// The colours of those places, or the given ones.
    pub(super) colors: Vec<Color>,
    /// Which pixels are given.
    pub(super) given: Vec<bool>,
}

impl Canvas {
    /// An empty canvas at the level of `step` for a texture of `size` pixels.
    pub(super) fn empty(size: [u32; 2], step: usize, tiles_x: bool, given: Option<&Given>) -> Self {
        let [width, height] = size.map(|side| (side as usize).div_ceil(step));
        let mut canvas = Self {
            width,
            height,
            tiles_x,
            places: vec![NOWHERE; width * height],
            colors: vec![[0; 4]; width * height],
            given: vec![false; width * height],
        };
        if let Some(given) = given {
            canvas.colors.copy_from_slice(&given.colors);
            canvas.given.copy_from_slice(&given.flags);
        }
        canvas
    }

    /// Which pixel (x, y) is, if there is one.
    #[inline]
    pub(super) fn at(&self, x: i64, y: i64) -> Option<usize> {
        let (width, height) = (self.width as i64, self.height as i64);
        let x = if self.tiles_x { x.rem_euclid(width) } else { x };
        let inside = (0..width).contains(&x) && (0..height).contains(&y);
        inside.then_some((y * width + x) as usize)
    }

    /// Whether pixel `at` has a colour yet.
    #[inline]
    pub(super) fn is_set(&self, at: usize) -> bool {
        self.given[at] || self.places[at] != NOWHERE
    }

    /// Gives pixel `at` the place `index` of `level`.
    #[inline]
    pub(super) fn set(&mut self, at: usize, index: u32, level: &Level) {
        self.places[at] = index;
        self.colors[at] = level.colors[index as usize];
    }

    /// The canvas of the next finer level `number`, for a texture of `size`: each pixel becomes four
    /// that lie next to one another in the exemplar as well; where one would not be foliage, the
    /// nearest that is.
    pub(super) fn refined(
        &self,
        exemplar: &Exemplar,
        number: usize,
        size: [u32; 2],
        given: Option<&Given>,
    ) -> Self {
        let (coarse, fine) = (&exemplar.levels[number + 1], &exemplar.levels[number]);
        let mut canvas = Self::empty(size, fine.step, self.tiles_x, given);
        for y in 0..canvas.height {
            for x in 0..canvas.width {
                let at = y * canvas.width + x;
                if canvas.given[at] {
                    continue;
                }
                let index = match self.places[y / 2 * self.width + x / 2] {
                    NOWHERE => exemplar.usable_near(number, 0, 0),
                    parent => {
                        let (u, v) = coarse.place(parent as usize);
                        let step = fine.step as i64;
                        let (dx, dy) = ((x % 2) as i64 * step, (y % 2) as i64 * step);
                        exemplar.usable_near(number, u + dx, v + dy)
                    }
                };
                canvas.set(at, index, fine);
            }
        }
        canvas
    }

    /// The colours as an opaque picture.
    pub(super) fn picture(&self) -> Image<Straight> {
        let opaque = |&[r, g, b, _]: &Color| Straight([r as u8, g as u8, b as u8, 255]);
        let pixels = self.colors.iter().map(opaque).collect();
        Image::from_pixels(self.width as u32, self.height as u32, pixels)
    }
}

/// The given pixels at one level.
#[derive(Debug, Clone)]
pub(super) struct Given {
    colors: Vec<Color>,
    flags: Vec<bool>,
}

impl Given {
    /// The given pixels at `levels` levels from the finest, blurred as an exemplar's are; what is
    /// not given has no part in the blur.
    pub(super) fn levels(known: &Known, levels: usize) -> Vec<Self> {
        let width = known.width() as usize;
        let flag = |pixel: &Option<[u8; 3]>| f32::from(u8::from(pixel.is_some()));
        let mut weights: Vec<[f32; 3]> = known.pixels().iter().map(|p| [flag(p); 3]).collect();
        let color = |pixel: &Option<[u8; 3]>| pixel.unwrap_or_default().map(f32::from);
        let mut colors: Vec<[f32; 3]> = known.pixels().iter().map(color).collect();
        let mut given = Vec::new();
        for number in 0..levels {
            if number > 0 {
                weights = blurred(&weights, width, 1 << (number - 1));
                colors = blurred(&colors, width, 1 << (number - 1));
            }
            given.push(Self::level(known, &colors, &weights, 1 << number));
        }
        given
    }

    fn level(known: &Known, colors: &[[f32; 3]], weights: &[[f32; 3]], step: usize) -> Self {
        let mut level = Self {
            colors: Vec::new(),
            flags: Vec::new(),
        };
        for y in (0..known.height() as usize).step_by(step) {
            for x in (0..known.width() as usize).step_by(step) {
                let at = y * known.width() as usize + x;
                let is_given = known.pixels()[at].is_some();
                let [r, g, b] = [0, 1, 2].map(|c| {
                    let value = colors[at][c] / weights[at][c].max(1e-6);
                    (value + 0.5).min(255.0) as i16
                });
                level.flags.push(is_given);
                level
                    .colors
                    .push(if is_given { [r, g, b, 0] } else { [0; 4] });
            }
        }
        level
    }
}
