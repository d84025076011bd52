//! Labels of a picture in tiles that are shared until they change.
//!
//! A picture of 8192² pixels has 4,096 tiles of 128². Copying a mask copies 4,096 small handles;
//! only the tiles that are then painted on cost memory of their own, and a tile of one label costs
//! none. Two masks of the same labels are always represented alike: a tile of one label is never
//! stored pixel by pixel, and a tile at the right or lower border holds no pixels outside.

use crate::base::{Digest, Hasher};
use crate::raster::{Image, Mask, Rect};
use crate::segment::{Label, Labels};
use std::fmt;
use std::sync::Arc;

/// Side of a tile in pixels. Half of it doubles the handles of a mask (64 KiB at 8192²), twice of it
/// makes a small stroke copy four times as much (16 KiB a tile).
pub const TILE: u32 = 128;

/// No part of the tree.
pub const BACKGROUND: u8 = 0;

/// Foliage.
pub const CROWN: u8 = 1;

/// Stem and main limbs below the foliage. Labels above it are sub-crowns.
pub const TRUNK: u8 = 2;

/// Labels of 128² pixels, fewer at the right and lower border.
#[derive(Clone, PartialEq, Eq)]
pub(super) enum Tile {
    /// All pixels have this label.
    Uniform(u8),
    /// At least two labels, row by row without gaps.
    Varied(Arc<[u8]>),
}

impl Tile {
    /// The tile of `pixels`, uniform when they are.
    pub(super) fn of(pixels: &[u8]) -> Self {
        match pixels.split_first() {
            Some((first, rest)) if rest.iter().all(|label| label == first) => Self::Uniform(*first),
            _ => Self::Varied(pixels.into()),
        }
    }

    /// Whether both are the same without looking at the pixels.
    pub(super) fn is_shared_with(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Uniform(a), Self::Uniform(b)) => a == b,
            (Self::Varied(a), Self::Varied(b)) => Arc::ptr_eq(a, b),
            _ => false,
        }
    }
}

/// What painting puts on pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Paint {
    /// The label to put; [`BACKGROUND`] erases.
    pub label: u8,
    /// Which pixels take it.
    pub over: Over,
}

impl Paint {
    /// `label` over everything.
    pub const fn of(label: u8) -> Self {
        Self {
            label,
            over: Over::Everything,
        }
    }

    /// The label after painting on `old`.
    #[inline]
    pub fn on(self, old: u8) -> u8 {
        let takes = match self.over {
            Over::Everything => true,
            Over::Background => old == BACKGROUND,
            Over::Tree => old != BACKGROUND,
            Over::Only(label) => old == label,
        };
        if takes { self.label } else { old }
    }

    /// Paints on all of `pixels`.
    #[inline]
    pub(super) fn on_all(self, pixels: &mut [u8]) {
        if self.over == Over::Everything {
            pixels.fill(self.label);
        } else {
            for pixel in pixels {
                *pixel = self.on(*pixel);
            }
        }
    }
}

/// Which pixels painting may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Over {
    /// All.
    #[default]
    Everything,
    /// Only background: what is labelled is protected.
    Background,
    /// Only what is labelled already.
    Tree,
    /// Only this label.
    Only(u8),
}

/// A label for each pixel of a picture; clones share what neither changes.
#[derive(Clone, PartialEq, Eq)]
pub struct TiledMask {
    width: u32,
    height: u32,
    tiles: Vec<Tile>,
}

impl TiledMask {
    /// A mask of one label.
    ///
    /// # Panics
    /// When a side is 0.
    pub fn filled(width: u32, height: u32, label: u8) -> Self {
        assert!(width > 0 && height > 0, "a mask has no empty side");
        let count = width.div_ceil(TILE) as usize * height.div_ceil(TILE) as usize;
        Self::from_tiles(width, height, vec![Tile::Uniform(label); count])
    }

    pub(super) fn from_tiles(width: u32, height: u32, tiles: Vec<Tile>) -> Self {
        Self {
            width,
            height,
            tiles,
        }
    }

    /// The labels of `image`, a byte a pixel.
    pub fn from_image(image: &Image<u8>) -> Self {
        Self::from_rows(image.width(), image.height(), |x, y, row| {
            row.copy_from_slice(&image.row(y)[x as usize..][..row.len()]);
        })
    }

    /// `label` where `mask` is true, background elsewhere.
    pub fn from_mask(mask: &Mask, label: u8) -> Self {
        Self::from_rows(mask.width(), mask.height(), |x, y, row| {
            let inside = &mask.row(y)[x as usize..];
            for (pixel, &inside) in row.iter_mut().zip(inside) {
                *pixel = if inside { label } else { BACKGROUND };
            }
        })
    }

    /// What a segmenter found.
    pub fn from_labels(labels: &Labels) -> Self {
        Self::from_image(&labels.map(|label| match label {
            Label::Background => BACKGROUND,
            Label::Crown => CROWN,
            Label::Trunk => TRUNK,
        }))
    }

    /// A mask whose pieces of rows `write` fills, given the first pixel's column and row.
    fn from_rows(width: u32, height: u32, mut write: impl FnMut(u32, u32, &mut [u8])) -> Self {
        let mut mask = Self::filled(width, height, BACKGROUND);
        let mut pixels = Vec::new();
        for index in 0..mask.tiles.len() {
            let rect = mask.tile_rect(index);
            pixels.resize(area(rect), BACKGROUND);
            for (y, row) in (rect.y..).zip(pixels.chunks_exact_mut(rect.width as usize)) {
                write(rect.x, y, row);
            }
            mask.tiles[index] = Tile::of(&pixels);
        }
        mask
    }

    /// The labels as an image, a byte a pixel.
    pub fn image(&self) -> Image<u8> {
        self.window(0, 0, self.width, self.height, BACKGROUND)
    }

    /// Where the label fulfils `wanted`.
    pub fn mask(&self, wanted: impl Fn(u8) -> bool) -> Mask {
        self.image().map(|&label| wanted(label))
    }

    /// The labels as segmenters give them: sub-crowns are crown.
    pub fn labels(&self) -> Labels {
        self.image().map(|&label| match label {
            BACKGROUND => Label::Background,
            TRUNK => Label::Trunk,
            _ => Label::Crown,
        })
    }

    /// Pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// All of the mask.
    pub fn rect(&self) -> Rect {
        Rect {
            x: 0,
            y: 0,
            width: self.width,
            height: self.height,
        }
    }

    /// All of the mask at 1/2^`level` of its size.
    pub fn rect_at(&self, level: u32) -> Rect {
        Rect {
            width: self.width.div_ceil(1 << level),
            height: self.height.div_ceil(1 << level),
            ..self.rect()
        }
    }

    /// The label at (x, y), which must be inside.
    pub fn at(&self, x: u32, y: u32) -> u8 {
        assert!(x < self.width && y < self.height, "({x}, {y}) is outside");
        let index = (y / TILE * self.across() + x / TILE) as usize;
        match &self.tiles[index] {
            Tile::Uniform(label) => *label,
            Tile::Varied(pixels) => {
                let rect = self.tile_rect(index);
                pixels[((y - rect.y) * rect.width + x - rect.x) as usize]
            }
        }
    }

    /// Number of pixels whose label fulfils `wanted`.
    pub fn count(&self, wanted: impl Fn(u8) -> bool) -> u64 {
        let counts = self
            .tiles
            .iter()
            .enumerate()
            .map(|(index, tile)| match tile {
                Tile::Uniform(label) if wanted(*label) => area(self.tile_rect(index)) as u64,
                Tile::Uniform(_) => 0,
                Tile::Varied(pixels) => {
                    pixels.iter().filter(|&&label| wanted(label)).count() as u64
                }
            });
        counts.sum()
    }

    /// The smallest rectangle around the pixels whose label fulfils `wanted`.
    pub fn bounds(&self, wanted: impl Fn(u8) -> bool) -> Option<Rect> {
        let mut bounds = None;
        for (index, tile) in self.tiles.iter().enumerate() {
            let rect = self.tile_rect(index);
            match tile {
                Tile::Uniform(label) if wanted(*label) => bounds = joined(bounds, Some(rect)),
                Tile::Uniform(_) => {}
                Tile::Varied(pixels) => {
                    let none = vec![false; pixels.len()];
                    let found: Vec<bool> = pixels.iter().map(|&label| wanted(label)).collect();
                    bounds = joined(bounds, difference(&none, &found, rect));
                }
            }
        }
        bounds
    }

    /// A copy of `width` × `height` labels from (x, y) on, which may lie outside: there they are
    /// `outside`.
    ///
    /// # Panics
    /// When a side is 0.
    pub fn window(&self, x: i64, y: i64, width: u32, height: u32, outside: u8) -> Image<u8> {
        let mut image = Image::filled(width, height, outside);
        let Some(rect) = self.clipped(x, y, i64::from(width), i64::from(height)) else {
            return image;
        };
        for index in self.tiles_of(rect) {
            let own = self.tile_rect(index);
            let Some(part) = intersection(own, rect) else {
                continue;
            };
            for row_y in part.y..part.y + part.height {
                let to = (i64::from(part.x) - x) as usize;
                let row = &mut image.row_mut((i64::from(row_y) - y) as u32)[to..];
                let row = &mut row[..part.width as usize];
                match &self.tiles[index] {
                    Tile::Uniform(label) => row.fill(*label),
                    Tile::Varied(pixels) => {
                        let from = (row_y - own.y) * own.width + part.x - own.x;
                        row.copy_from_slice(&pixels[from as usize..][..row.len()]);
                    }
                }
            }
        }
        image
    }

    /// Lets `change` change the pieces of rows within `rect`, each given with its first pixel's
    /// column and row; returns the smallest rectangle around what is different afterwards.
    ///
    /// Pieces come in no order to rely on. What `rect` has outside is left out.
    pub fn edit(
        &mut self,
        rect: Rect,
        mut change: impl FnMut(u32, u32, &mut [u8]),
    ) -> Option<Rect> {
        let rect = intersection(rect, self.rect())?;
        let mut changed = None;
        let mut scratch = Vec::new();
        for index in self.tiles_of(rect) {
            let own = self.tile_rect(index);
            let Some(part) = intersection(own, rect) else {
                continue;
            };
            scratch.clear();
            match &self.tiles[index] {
                Tile::Uniform(label) => scratch.resize(area(own), *label),
                Tile::Varied(pixels) => scratch.extend_from_slice(pixels),
            }
            for y in part.y..part.y + part.height {
                let from = ((y - own.y) * own.width + part.x - own.x) as usize;
                change(part.x, y, &mut scratch[from..][..part.width as usize]);
            }
            changed = joined(changed, self.store(index, &scratch));
        }
        changed
    }

    /// Makes `pixels` the content of tile `index`; the rectangle around what is different.
    fn store(&mut self, index: usize, pixels: &[u8]) -> Option<Rect> {
        let own = self.tile_rect(index);
        let changed = match &self.tiles[index] {
            Tile::Uniform(label) => difference(&vec![*label; pixels.len()], pixels, own)?,
            Tile::Varied(before) => difference(before, pixels, own)?,
        };
        self.tiles[index] = Tile::of(pixels);
        Some(changed)
    }

    /// The digest of size and labels: equal for equal masks, however they came about.
    pub fn digest(&self) -> Digest {
        let sides = [self.width.to_le_bytes(), self.height.to_le_bytes()].concat();
        let mut hasher = Hasher::new("boscage mask").with(&sides);
        for tile in &self.tiles {
            hasher = match tile {
                Tile::Uniform(label) => hasher.with(&[*label]),
                Tile::Varied(pixels) => hasher.with(pixels),
            };
        }
        hasher.finish()
    }

    /// Bytes in memory, counting tiles that are shared with other masks.
    pub fn memory_bytes(&self) -> usize {
        let varied = self.tiles.iter().map(|tile| match tile {
            Tile::Uniform(_) => 0,
            Tile::Varied(pixels) => pixels.len(),
        });
        varied.sum::<usize>() + self.tiles.len() * size_of::<Tile>()
    }

    /// Whether no tile of one label is stored pixel by pixel and all have their right size: what
    /// every function here keeps true.
    pub fn is_canonical(&self) -> bool {
        let expected = self.across() as usize * self.height.div_ceil(TILE) as usize;
        self.tiles.len() == expected
            && self
                .tiles
                .iter()
                .enumerate()
                .all(|(index, tile)| match tile {
                    Tile::Uniform(_) => true,
                    Tile::Varied(pixels) => {
                        pixels.len() == area(self.tile_rect(index))
                            && pixels.iter().any(|label| *label != pixels[0])
                    }
                })
    }

    /// Whether tile `index` of both is the same, by handle where that suffices.
    pub(super) fn has_same_tile(&self, other: &Self, index: usize) -> bool {
        let (a, b) = (&self.tiles[index], &other.tiles[index]);
        a.is_shared_with(b) || a == b
    }

    pub(super) fn tiles(&self) -> &[Tile] {
        &self.tiles
    }

    pub(super) fn set_tile(&mut self, index: usize, tile: Tile) {
        self.tiles[index] = tile;
    }

    /// Tiles in a row of tiles.
    pub(super) fn across(&self) -> u32 {
        self.width.div_ceil(TILE)
    }

    /// The pixels of tile `index`.
    pub(super) fn tile_rect(&self, index: usize) -> Rect {
        let (column, row) = (index as u32 % self.across(), index as u32 / self.across());
        let (x, y) = (column * TILE, row * TILE);
        Rect {
            x,
            y,
            width: TILE.min(self.width - x),
            height: TILE.min(self.height - y),
        }
    }

    /// Indices of the tiles that `rect`, which is inside, touches, in ascending order.
    pub(super) fn tiles_of(&self, rect: Rect) -> impl Iterator<Item = usize> + use<> {
        let across = self.across();
        let columns = rect.x / TILE..(rect.x + rect.width).div_ceil(TILE);
        let rows = rect.y / TILE..(rect.y + rect.height).div_ceil(TILE);
        rows.flat_map(move |row| {
            let columns = columns.clone();
            columns.map(move |column| (row * across + column) as usize)
        })
    }

    /// The part of the rectangle that is inside.
    pub(super) fn clipped(&self, x: i64, y: i64, width: i64, height: i64) -> Option<Rect> {
        let (left, top) = (x.max(0), y.max(0));
        let right = (x + width).min(i64::from(self.width));
        let bottom = (y + height).min(i64::from(self.height));
        (left < right && top < bottom).then(|| Rect {
            x: left as u32,
            y: top as u32,
            width: (right - left) as u32,
            height: (bottom - top) as u32,
        })
    }
}

impl fmt::Debug for TiledMask {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "TiledMask({}×{}, {:?})",
            self.width,
            self.height,
            self.digest()
        )
    }
}

/// Paints where `selection` is not 0; returns the rectangle around what changed.
///
/// ```
/// use boscage::paint::{CROWN, Paint, TiledMask, painted};
/// use boscage::raster::{Image, Rect};
/// let mut mask = TiledMask::filled(3, 2, 0);
/// let selection = TiledMask::from_image(&Image::from_pixels(3, 2, vec![0, 1, 1, 0, 0, 0]));
/// let changed = painted(&mut mask, &selection, Paint::of(CROWN));
/// assert_eq!(changed, Some(Rect { x: 1, y: 0, width: 2, height: 1 }));
/// ```
///
/// # Panics
/// When both differ in size.
pub fn painted(mask: &mut TiledMask, selection: &TiledMask, paint: Paint) -> Option<Rect> {
    assert_eq!(
        (mask.width, mask.height),
        (selection.width, selection.height),
        "a selection has the size of its mask"
    );
    let mut changed = None;
    for index in 0..selection.tiles.len() {
        let rect = selection.tile_rect(index);
        let part = match &selection.tiles[index] {
            Tile::Uniform(0) => None,
            Tile::Uniform(_) => mask.edit(rect, |_, _, row| paint.on_all(row)),
            Tile::Varied(selected) => mask.edit(rect, |_, y, row| {
                let from = ((y - rect.y) * rect.width) as usize;
                for (pixel, &selected) in row.iter_mut().zip(&selected[from..]) {
                    if selected != 0 {
                        *pixel = paint.on(*pixel);
                    }
                }
            }),
        };
        changed = joined(changed, part);
    }
    changed
}

/// The smallest rectangle around both.
pub fn joined(a: Option<Rect>, b: Option<Rect>) -> Option<Rect> {
    let (Some(a), Some(b)) = (a, b) else {
        return a.or(b);
    };
    let (x, y) = (a.x.min(b.x), a.y.min(b.y));
    Some(Rect {
        x,
        y,
        width: (a.x + a.width).max(b.x + b.width) - x,
        height: (a.y + a.height).max(b.y + b.height) - y,
    })
}

/// What both share.
pub(super) fn intersection(a: Rect, b: Rect) -> Option<Rect> {
    let (x, y) = (a.x.max(b.x), a.y.max(b.y));
    let right = (a.x + a.width).min(b.x + b.width);
    let bottom = (a.y + a.height).min(b.y + b.height);
    (x < right && y < bottom).then(|| Rect {
        x,
        y,
        width: right - x,
        height: bottom - y,
    })
}

/// Number of pixels.
pub(super) fn area(rect: Rect) -> usize {
    rect.width as usize * rect.height as usize
}

/// The smallest rectangle around the pixels of `rect` that differ.
fn difference<P: PartialEq>(before: &[P], after: &[P], rect: Rect) -> Option<Rect> {
    let width = rect.width as usize;
    let rows = || before.chunks_exact(width).zip(after.chunks_exact(width));
    let top = rows().position(|(b, a)| b != a)?;
    let bottom = rows().rposition(|(b, a)| b != a)?;
    let (mut left, mut right) = (width, 0);
    for (b, a) in rows().take(bottom + 1).skip(top) {
        if b == a {
            continue;
        }
        let differs = |(b, a): (&P, &P)| b != a;
        left = left.min(b.iter().zip(a).position(differs).unwrap_or(width));
        right = right.max(b.iter().zip(a).rposition(differs).unwrap_or(0));
    }
    Some(Rect {
        x: rect.x + left as u32,
        y: rect.y + top as u32,
        width: (right + 1 - left) as u32,
        height: (bottom + 1 - top) as u32,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_large_mask_of_one_label_costs_almost_nothing() {
        let mask = TiledMask::filled(8192, 8192, CROWN);
        assert!(mask.memory_bytes() < 100_000);
        assert_eq!(mask.count(|label| label == CROWN), 8192 * 8192);
    }

    #[test]
    fn images_and_labels_survive_the_tiles() {
        let image = Image::from_pixels(
            300,
            131,
            (0..300 * 131).map(|i| (i / 977 % 3) as u8).collect(),
        );
        let mask = TiledMask::from_image(&image);
        assert_eq!(mask.image(), image);
        assert_eq!(TiledMask::from_labels(&mask.labels()), mask);
        let crown = mask.mask(|label| label == CROWN);
        assert_eq!(
            TiledMask::from_mask(&crown, CROWN).count(|l| l == CROWN),
            crown.count() as u64
        );
        assert!(mask.is_canonical());
    }

    #[test]
    fn an_edit_that_ends_where_it_began_changes_nothing() {
        let mut mask = TiledMask::filled(200, 200, CROWN);
        let before = mask.clone();
        assert_eq!(mask.edit(mask.rect(), |_, _, row| row.fill(CROWN)), None);
        mask.edit(mask.rect(), |_, _, row| row.fill(TRUNK));
        mask.edit(mask.rect(), |_, _, row| row.fill(CROWN));
        assert_eq!(mask, before);
        assert_eq!(mask.digest(), before.digest());
    }

    #[test]
    fn windows_reach_outside() {
        let mask = TiledMask::filled(2, 2, 5);
        let window = mask.window(-1, 1, 3, 2, 9);
        assert_eq!(window.pixels(), &[9, 5, 5, 9, 9, 9]);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        /// Rectangles on tiles against rectangles on a plain image: the same labels, the exact
        /// rectangle of change, clones untouched.
        #[test]
        fn edits_match_those_of_a_plain_image(
            edits in prop::collection::vec((0u32..300, 0u32..300, 1u32..200, 1u32..200, 0u8..3), 1..8),
        ) {
            let mut mask = TiledMask::filled(290, 270, 0);
            let mut plain = Image::filled(290, 270, 0u8);
            for (x, y, width, height, label) in edits {
                let (kept, kept_plain) = (mask.clone(), plain.clone());
                let changed = mask.edit(Rect { x, y, width, height }, |_, _, row| row.fill(label));
                for py in y..(y + height).min(270) {
                    for px in x..(x + width).min(290) {
                        plain.set(px, py, label);
                    }
                }
                let whole = mask.rect();
                prop_assert_eq!(changed, difference(kept_plain.pixels(), plain.pixels(), whole));
                prop_assert_eq!(mask.image(), plain.clone());
                prop_assert_eq!(kept.image(), kept_plain);
                prop_assert!(mask.is_canonical());
                prop_assert_eq!(&mask, &TiledMask::from_image(&plain));
                let slow = crate::raster::opaque_bounds(&plain.map(|&l| l == 1));
                prop_assert_eq!(mask.bounds(|l| l == 1), slow);
            }
        }
    }
}
