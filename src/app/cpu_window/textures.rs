//! Textures in memory, as egui hands them over.

use super::pixel::{between, pixel};
use egui::epaint::{ImageData, ImageDelta};
use egui::{TextureFilter, TextureId, TextureOptions, TextureWrapMode, TexturesDelta};
use std::collections::HashMap;

/// A texel, in the coordinates of a texture: 32 bits behind the point.
pub(super) const TEXEL: i64 = 1 << 32;

/// All textures that meshes may show.
#[derive(Default)]
pub struct Textures {
    by_id: HashMap<TextureId, Texture>,
    changes: u64,
}

/// From a place to where the texel left of or above it is in the middle, and to the nearest share of 256.
const TO_MIDDLE: i64 = TEXEL / 512 - TEXEL / 2;

/// One texture.
pub(super) struct Texture {
    width: usize,
    height: usize,
    texels: Vec<u32>,
    options: TextureOptions,
    /// Differs whenever the texels do.
    pub(super) version: u64,
}

impl Textures {
    /// Takes up what is new and changed. What is to be freed stays until [`Textures::free`]: the frame
    /// that comes with `delta` may still show it.
    pub fn set(&mut self, delta: &mut TexturesDelta) {
        for (id, images) in delta.set.drain() {
            for image in images {
                self.changes += 1;
                self.set_one(id, &image);
            }
        }
    }

    /// Forgets what no later frame shows.
    pub fn free(&mut self, delta: &mut TexturesDelta) {
        for id in delta.free.drain() {
            self.by_id.remove(&id);
        }
    }

    pub(super) fn get(&self, id: TextureId) -> Option<&Texture> {
        self.by_id
            .get(&id)
            .filter(|texture| !texture.texels.is_empty())
    }

    fn set_one(&mut self, id: TextureId, delta: &ImageDelta) {
        let ImageData::Color(image) = &delta.image;
        let [width, height] = image.size;
        let texels = image.pixels.iter().map(|color| pixel(*color));
        let Some([left, top]) = delta.pos else {
            let texture = Texture {
                width,
                height,
                texels: texels.collect(),
                options: delta.options,
                version: self.changes,
            };
            self.by_id.insert(id, texture);
            return;
        };
        let Some(whole) = self.by_id.get_mut(&id) else {
            return;
        };
        if left + width > whole.width || top + height > whole.height || width == 0 {
            return;
        }
        let rows = whole.texels.chunks_exact_mut(whole.width).skip(top);
        for (row, colors) in rows.zip(image.pixels.chunks_exact(width)) {
            for (texel, color) in row[left..].iter_mut().zip(colors) {
                *texel = pixel(*color);
            }
        }
        whole.options = delta.options;
        whole.version = self.changes;
    }
}

impl Texture {
    /// Columns and rows.
    pub(super) fn size(&self) -> (f64, f64) {
        (self.width as f64, self.height as f64)
    }

    /// How texels are joined where a pixel's width is `texels` of them.
    pub(super) fn filter(&self, texels: f64) -> TextureFilter {
        if texels > 1.0 + 1e-6 {
            self.options.minification
        } else {
            self.options.magnification
        }
    }

    /// The texel at a place.
    #[inline(always)]
    pub(super) fn nearest(&self, u: i64, v: i64) -> u32 {
        self.at(u >> 32, v >> 32)
    }

    /// The four texels around a place, mixed.
    #[inline(always)]
    pub(super) fn linear(&self, u: i64, v: i64) -> u32 {
        let (u, v) = (u.wrapping_add(TO_MIDDLE), v.wrapping_add(TO_MIDDLE));
        let (column, row) = (u >> 32, v >> 32);
        let across = (u >> 24) as u32 & 0xff;
        let down = (v >> 24) as u32 & 0xff;
        let upper = between(self.at(column, row), self.at(column + 1, row), across);
        let lower = between(
            self.at(column, row + 1),
            self.at(column + 1, row + 1),
            across,
        );
        between(upper, lower, down)
    }

    #[inline(always)]
    fn at(&self, column: i64, row: i64) -> u32 {
        let mode = self.options.wrap_mode;
        self.texels
            [wrapped(row, self.height, mode) * self.width + wrapped(column, self.width, mode)]
    }

    /// What a row of pixels shows whose v is the same.
    pub(super) fn row(&self, v: i64) -> TexelRow<'_> {
        let mode = self.options.wrap_mode;
        let of =
            |row: i64| &self.texels[wrapped(row, self.height, mode) * self.width..][..self.width];
        let upper = v.wrapping_add(TO_MIDDLE);
        TexelRow {
            nearest: of(v >> 32),
            upper: of(upper >> 32),
            lower: of((upper >> 32) + 1),
            down: (upper >> 24) as u32 & 0xff,
            mode,
        }
    }
}

/// The rows of texels that a row of pixels lies between.
pub(super) struct TexelRow<'a> {
    nearest: &'a [u32],
    upper: &'a [u32],
    lower: &'a [u32],
    /// Share of the lower one, of 256.
    down: u32,
    mode: TextureWrapMode,
}

impl<'a> TexelRow<'a> {
    /// As [`Texture::nearest`].
    #[inline(always)]
    pub(super) fn nearest(&self, u: i64) -> u32 {
        self.nearest[wrapped(u >> 32, self.nearest.len(), self.mode)]
    }

    /// As [`Texture::linear`].
    #[inline(always)]
    pub(super) fn linear(&self, u: i64) -> u32 {
        let u = u.wrapping_add(TO_MIDDLE);
        let left = wrapped(u >> 32, self.upper.len(), self.mode);
        let right = wrapped((u >> 32) + 1, self.upper.len(), self.mode);
        self.between(left, right, u)
    }

    /// As [`TexelRow::linear`], where the texels left and right of `u` are ones of the row.
    #[inline(always)]
    pub(super) fn linear_inside(&self, u: i64) -> u32 {
        let u = u.wrapping_add(TO_MIDDLE);
        let left = (u >> 32) as usize;
        self.between(left, left + 1, u)
    }

    /// Whether the texels left and right of places between these two are ones of the row.
    pub(super) fn is_inside(&self, one: i64, other: i64) -> bool {
        let columns = 0..self.upper.len() as i64 - 1;
        [one, other]
            .map(|u| u.wrapping_add(TO_MIDDLE) >> 32)
            .iter()
            .all(|left| columns.contains(left))
    }

    #[inline(always)]
    fn between(&self, left: usize, right: usize, u: i64) -> u32 {
        let (a, b) = (self.upper[left], self.upper[right]);
        let (c, d) = (self.lower[left], self.lower[right]);
        // Much of a cut-out tree is nothing, much of other pictures all alike.
        if a == b && a == c && a == d {
            return a;
        }
        let across = (u >> 24) as u32 & 0xff;
        between(between(a, b, across), between(c, d, across), self.down)
    }

    /// The texels themselves, if `count` pixels from `u` on, `step` apart, show them one by one
    /// (text does): as good as exactly in their middles.
    pub(super) fn exact(&self, u: i64, step: i64, count: usize) -> Option<&'a [u32]> {
        let near = TEXEL / 512;
        let drift = (step - TEXEL).abs().saturating_mul(count as i64);
        let column = u >> 32;
        let is_middle = (u - (column << 32) - TEXEL / 2).abs() < near;
        let is_row = self.down == 0 || std::ptr::eq(self.upper, self.lower);
        if drift > near || !is_middle || !is_row || column < 0 {
            return None;
        }
        self.upper.get(column as usize..column as usize + count)
    }
}

/// The texel of `count` that is shown at `index`.
#[inline(always)]
fn wrapped(index: i64, count: usize, mode: TextureWrapMode) -> usize {
    let last = count as i64 - 1;
    let inside = match mode {
        TextureWrapMode::ClampToEdge => index.clamp(0, last),
        // A division takes longer than all else about a pixel.
        TextureWrapMode::Repeat if count.is_power_of_two() => index & last,
        TextureWrapMode::Repeat => index.rem_euclid(last + 1),
        TextureWrapMode::MirroredRepeat => {
            let phase = index.rem_euclid(2 * (last + 1));
            phase.min(2 * last + 1 - phase)
        }
    };
    inside as usize
}
