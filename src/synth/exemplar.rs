//! The exemplar: the foliage of a photograph, prepared once for any number of textures.

use super::SynthesisError;
use super::flatten::Light;
use super::foliage::foliage;
use super::level::{Level, blurred};
use super::similar::{SIMILAR, similar};
use super::unique::unique;
use crate::base::{Cancel, Seed};
use crate::geometry::Point;
use crate::raster::{Image, Mask, Rect, Straight, opaque_bounds};

/// How an exemplar is prepared.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ExemplarSettings {
    /// Pixels taken off the mask's edge: there leaves and background are mixed. 0 … 255.
    pub erosion: u8,
    /// Whether sky that shows through the crown is left out.
    pub without_sky: bool,
    /// How much of the large-scale light is taken out: 0 nothing, 1 all.
    pub flatten: f32,
    /// Whether what occurs only once (a sign, a flower) is left out: it would be seen to repeat.
    pub without_unique: bool,
    /// Levels of detail: the coarsest has steps of 2^(levels − 1) pixels. 1 … [`MOST_LEVELS`].
    pub levels: u32,
}

impl Default for ExemplarSettings {
    fn default() -> Self {
        Self {
            erosion: 1,
            without_sky: true,
            without_unique: true,
            flatten: 0.6,
            levels: 3,
        }
    }
}

/// Most levels of detail: steps of 16 pixels, beyond which no structure of foliage is left.
pub const MOST_LEVELS: u32 = 5;

/// Fewest pixels of foliage that an exemplar may have: twice a window of 7×7 in each direction.
/// Below, a texture would be one spot repeated.
pub const FEWEST_PIXELS: usize = 200;

/// The level at which what occurs only once is looked for: windows of 14 pixels hold a flower or a
/// sign; larger ones hold a bit of everything, and every one is unique.
const UNIQUE_LEVEL: usize = 1;

/// The foliage of a photograph: its pixels at several levels of blur, which of them may be used, and
/// which look alike. Knows nothing of the size of textures.
#[derive(Debug, Clone)]
pub struct Exemplar {
    /// From the finest.
    pub(super) levels: Vec<Level>,
    /// For each pixel of each level those most like it.
    pub(super) similar: Vec<Vec<[u32; SIMILAR]>>,
    /// For each pixel of the crop the nearest usable one, as index into its rows.
    nearest: Vec<u32>,
    foliage: Mask,
    bounds: Rect,
    /// The light that was taken out, over the crop.
    light: Light,
}

impl Exemplar {
    /// Prepares the pixels of `photo` inside `mask` (of the same size).
    ///
    /// # Errors
    /// [`SynthesisError::SizesDiffer`] and [`SynthesisError::TooLittleFoliage`] for pictures that
    /// cannot be used; [`SynthesisError::Cancelled`].
    pub fn new(
        photo: &Image<Straight>,
        mask: &Mask,
        settings: &ExemplarSettings,
        cancel: &Cancel,
    ) -> Result<Self, SynthesisError> {
        if (photo.width(), photo.height()) != (mask.width(), mask.height()) {
            return Err(SynthesisError::SizesDiffer {
                photo: [photo.width(), photo.height()],
                mask: [mask.width(), mask.height()],
            });
        }
        let whole = foliage(photo, mask, settings.erosion, settings.without_sky);
        let pixels = whole.count();
        let Some(bounds) = opaque_bounds(&whole).filter(|_| pixels >= FEWEST_PIXELS) else {
            return Err(SynthesisError::TooLittleFoliage { pixels });
        };
        cancel.check()?;
        let Rect {
            x,
            y,
            width,
            height,
        } = bounds;
        let usable = whole.cropped(x, y, width, height);
        let photo = photo.cropped(x, y, width, height);
        let nearest = nearest(&usable);
        let mut colors: Vec<[f32; 3]> = photo
            .pixels()
            .iter()
            .map(|pixel| [0, 1, 2].map(|channel| f32::from(pixel.0[channel])))
            .collect();
        let light = Light::of(&colors, &usable, settings.flatten);
        light.even_out(&mut colors, width as usize);
        // What is not foliage has the colour of the nearest leaf, for windows at the edge.
        let mut colors: Vec<[f32; 3]> = nearest.iter().map(|&at| colors[at as usize]).collect();
        let size = (width as usize, height as usize);
        let mut levels: Vec<Level> = Vec::new();
        let mut tables = Vec::new();
        let mut distances = Vec::new();
        for number in 0..settings.levels.clamp(1, MOST_LEVELS) {
            cancel.check()?;
            if number > 0 {
                colors = blurred(&colors, size.0, 1 << (number - 1));
            }
            let level = Level::new(&colors, usable.pixels(), size, 1 << number);
            let found = similar(&level, Seed(u64::from(number)), cancel)?;
            tables.push(found.places);
            distances.push(found.distances);
            levels.push(level);
        }
        let mut exemplar = Self {
            levels,
            similar: tables,
            nearest,
            foliage: whole,
            bounds,
            light,
        };
        if settings.without_unique {
            let number = UNIQUE_LEVEL.min(exemplar.levels.len() - 1);
            let odd = unique(&exemplar.levels[number], &distances[number]);
            exemplar.leave_out(&odd);
        }
        Ok(exemplar)
    }

    /// Takes back the pixels of `odd`, a mask of the crop.
    fn leave_out(&mut self, odd: &Mask) {
        let Rect {
            x,
            y,
            width,
            height,
        } = self.bounds;
        let mut usable = self.foliage.cropped(x, y, width, height);
        for (usable, odd) in usable.pixels_mut().iter_mut().zip(odd.pixels()) {
            *usable &= !odd;
        }
        if usable.count() < FEWEST_PIXELS {
            return;
        }
        for level in &mut self.levels {
            level.restrict(usable.pixels());
        }
        self.nearest = nearest(&usable);
        for row in 0..height {
            let target = self.foliage.row_mut(y + row);
            target[x as usize..(x + width) as usize].copy_from_slice(usable.row(row));
        }
    }

    /// The pixels of the photograph that textures are made of, a mask of the photograph's size.
    pub fn foliage(&self) -> &Mask {
        &self.foliage
    }

    /// What textures are made of: the part of the photograph around its foliage, its large-scale
    /// light evened out; clear where there is no foliage.
    pub fn picture(&self) -> Image<Straight> {
        let level = &self.levels[0];
        let (width, height) = level.size();
        let pixels = (0..width * height).map(|at| {
            let index = level.index(at % width, at / width);
            let [r, g, b, _] = level.colors[index].map(|value| value as u8);
            match level.usable[index] {
                true => Straight([r, g, b, 255]),
                false => Straight::default(),
            }
        });
        Image::from_pixels(width as u32, height as u32, pixels.collect())
    }

    /// Where [`Exemplar::picture`] lies in the photograph.
    pub fn bounds(&self) -> Rect {
        self.bounds
    }

    /// What colours of the photograph at `place` are multiplied by to take the large-scale light out.
    pub(super) fn gain(&self, place: Point) -> [f32; 3] {
        let from = |place: f64, first: u32| (place - f64::from(first)) as f32;
        self.light
            .gain(from(place.x, self.bounds.x), from(place.y, self.bounds.y))
    }

    /// The usable pixel at or nearest to (x, y) of the crop, as an index at level `number`.
    pub(super) fn usable_near(&self, number: usize, x: i64, y: i64) -> u32 {
        let (width, height) = self.levels[0].size();
        let x = x.clamp(0, width as i64 - 1) as usize;
        let y = y.clamp(0, height as i64 - 1) as usize;
        let at = self.nearest[y * width + x] as usize;
        self.levels[number].index(at % width, at / width) as u32
    }
}

/// For each pixel the index of a `usable` one near it: found by sweeping over the picture twice,
/// each pixel taking over the best that its neighbours know (Danielsson 1980); in rare cases
/// another pixel is nearer by a fraction of a pixel.
fn nearest(usable: &Mask) -> Vec<u32> {
    let (width, height) = (usable.width() as usize, usable.height() as usize);
    const UNKNOWN: u32 = u32::MAX;
    let mut nearest: Vec<u32> = (0u32..)
        .zip(usable.pixels())
        .map(|(index, &usable)| if usable { index } else { UNKNOWN })
        .collect();
    let distance = |from: usize, to: u32| {
        if to == UNKNOWN {
            return u64::MAX;
        }
        let to = to as usize;
        let (dx, dy) = (
            (from % width).abs_diff(to % width),
            (from / width).abs_diff(to / width),
        );
        (dx * dx + dy * dy) as u64
    };
    let take = |nearest: &mut Vec<u32>, at: usize, dx: i64, dy: i64| {
        let (x, y) = ((at % width) as i64 + dx, (at / width) as i64 + dy);
        if (0..width as i64).contains(&x) && (0..height as i64).contains(&y) {
            let theirs = nearest[y as usize * width + x as usize];
            if distance(at, theirs) < distance(at, nearest[at]) {
                nearest[at] = theirs;
            }
        }
    };
    // Down: from above and from both sides of the row; then up, likewise.
    for (rows, dy) in [
        ((0..height).collect::<Vec<_>>(), -1),
        ((0..height).rev().collect(), 1),
    ] {
        for y in rows {
            for x in 0..width {
                for (dx, dy) in [(-1, dy), (0, dy), (1, dy), (-1, 0)] {
                    take(&mut nearest, y * width + x, dx, dy);
                }
            }
            for x in (0..width).rev() {
                take(&mut nearest, y * width + x, 1, 0);
            }
        }
    }
    nearest
}
