//! The photograph on the screen, in tiles.
//!
//! Only tiles that can be seen, at the level of the pyramid that the zoom needs, are textures; others
//! go when too many have gathered. Few new ones are made a frame, so that no frame takes long; until
//! all are there the thumbnail shows through.

use super::super::super::photos::{Photos, Thumbnail};
use super::super::color_image;
use super::camera::Camera;
use crate::base::Digest;
use crate::raster::{Image, Premultiplied, Straight};
use egui::{
    Color32, ColorImage, Painter, Pos2, Rect, TextureHandle, TextureOptions, Vec2, pos2, vec2,
};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

/// Side of a tile, texels: small enough for a frame's work, large enough for few draws.
pub(super) const SIDE: u32 = 256;

/// New tiles in a frame at most: some milliseconds.
const MOST_NEW: usize = 12;

/// Tiles that are kept: 100 MiB of textures.
const MOST_KEPT: usize = 400;

/// Sharp pixels when near, smooth ones when far.
pub(super) const SAMPLING: TextureOptions = TextureOptions {
    magnification: egui::TextureFilter::Nearest,
    ..TextureOptions::LINEAR
};

/// Level, column and row of a tile.
pub(super) type Key = (u32, u32, u32);

struct Tile {
    texture: TextureHandle,
    seen: u64,
}

/// What could be drawn of what can be seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Drawn {
    All,
    /// The next frame makes more.
    MoreToMake,
    /// A job makes what is missing, and wakes the window then.
    Waiting,
}

/// The textures of a photograph.
#[derive(Default)]
pub(super) struct PhotoTiles {
    of: Option<Digest>,
    thumbnail: Option<TextureHandle>,
    checks: Option<(bool, TextureHandle)>,
    tiles: HashMap<Key, Tile>,
    frame: u64,
}

impl PhotoTiles {
    /// Draws what can be seen of the photograph.
    pub(super) fn draw(
        &mut self,
        painter: &Painter,
        camera: &Camera,
        photos: &Photos,
        digest: Digest,
        size: Vec2,
    ) {
        if self.of != Some(digest) {
            *self = Self {
                of: Some(digest),
                checks: self.checks.take(),
                ..Self::default()
            };
        }
        self.frame += 1;
        let place = camera.rect_on_screen(Rect::from_min_size(Pos2::ZERO, size));
        let painter = painter.with_clip_rect(painter.clip_rect().intersect(place));
        let before = self.draw_tiles(&painter, camera, photos, digest, size);
        if before == Drawn::All {
            return;
        }
        self.draw_thumbnail(&painter, photos, digest, place);
        // Once more over it: those that are there already.
        let now = self.draw_tiles(&painter, camera, photos, digest, size);
        if before == Drawn::MoreToMake || now == Drawn::MoreToMake {
            painter.ctx().request_repaint();
        }
    }

    /// A pattern that shows through what is clear in the picture.
    pub(super) fn draw_checks(&mut self, painter: &Painter, place: Rect, colors: [Color32; 2]) {
        let is_dark = painter.ctx().theme() == egui::Theme::Dark;
        if self.checks.as_ref().is_none_or(|(of, _)| *of != is_dark) {
            let [a, b] = colors;
            let image = ColorImage::new([2, 2], vec![a, b, b, a]);
            let options = TextureOptions::NEAREST_REPEAT;
            let texture = painter.ctx().load_texture("checks", image, options);
            self.checks = Some((is_dark, texture));
        }
        if let Some((_, texture)) = &self.checks {
            let uv = Rect::from_min_size(Pos2::ZERO, place.size() / 16.0);
            painter.image(texture.id(), place, uv, Color32::WHITE);
        }
    }

    /// Draws the tiles that can be seen.
    fn draw_tiles(
        &mut self,
        painter: &Painter,
        camera: &Camera,
        photos: &Photos,
        digest: Digest,
        size: Vec2,
    ) -> Drawn {
        let (whole, pyramid) = (photos.whole(digest), photos.pyramid(digest));
        let level = camera.level(pyramid.map_or(0, |pyramid| pyramid.levels()));
        let reduced = pyramid.and_then(|pyramid| pyramid.level(level));
        if pyramid.is_none() && camera.level(1) > 0 {
            return Drawn::Waiting;
        }
        let (mut new, mut drawn) = (0, Drawn::All);
        for key in visible_tiles(camera, size, level) {
            let tile = match self.tiles.entry(key) {
                Entry::Occupied(tile) => tile.into_mut(),
                Entry::Vacant(place) => {
                    if new == MOST_NEW {
                        drawn = Drawn::MoreToMake;
                        continue;
                    }
                    let Some(image) = texels(whole, reduced, key) else {
                        drawn = Drawn::Waiting;
                        continue;
                    };
                    new += 1;
                    let texture = painter.ctx().load_texture("photo tile", image, SAMPLING);
                    place.insert(Tile { texture, seen: 0 })
                }
            };
            tile.seen = self.frame;
            let place = camera.rect_on_screen(covered(key, tile.texture.size()));
            painter.image(tile.texture.id(), place, UV, Color32::WHITE);
        }
        if self.tiles.len() > MOST_KEPT {
            let frame = self.frame;
            self.tiles.retain(|_, tile| tile.seen == frame);
        }
        drawn
    }

    fn draw_thumbnail(&mut self, painter: &Painter, photos: &Photos, digest: Digest, place: Rect) {
        if self.thumbnail.is_none()
            && let Some(Thumbnail::Ready(image)) = photos.thumbnail(digest)
        {
            let image = color_image(image);
            let options = TextureOptions::LINEAR;
            self.thumbnail = Some(painter.ctx().load_texture("photo afar", image, options));
        }
        if let Some(texture) = &self.thumbnail {
            painter.image(texture.id(), place, UV, Color32::WHITE);
        }
    }
}

/// All of a texture.
pub(super) const UV: Rect = Rect {
    min: pos2(0.0, 0.0),
    max: pos2(1.0, 1.0),
};

/// The tiles of `level` that can be seen.
pub(super) fn visible_tiles(
    camera: &Camera,
    size: Vec2,
    level: u32,
) -> impl Iterator<Item = Key> + use<> {
    let seen = camera.visible(size);
    let side = (SIDE << level) as f32;
    let range = |from: f32, to: f32| {
        let first = (from / side).floor().max(0.0) as u32;
        let end = (to / side).ceil().max(0.0) as u32;
        first..end
    };
    let is_seen = seen.is_positive();
    let columns = if is_seen {
        range(seen.min.x, seen.max.x)
    } else {
        0..0
    };
    let rows = range(seen.min.y, seen.max.y);
    rows.flat_map(move |row| columns.clone().map(move |column| (level, column, row)))
}

/// What a tile of `texels` covers of the photograph; at the border a little more than there is.
pub(super) fn covered(key: Key, texels: [usize; 2]) -> Rect {
    let (level, column, row) = key;
    let texel = (1 << level) as f32;
    let corner = pos2((column * SIDE) as f32, (row * SIDE) as f32) * texel;
    Rect::from_min_size(corner, vec2(texels[0] as f32, texels[1] as f32) * texel)
}

/// Column, row, width and height of a tile in its level.
fn part((_, column, row): Key, width: u32, height: u32) -> (u32, u32, u32, u32) {
    let (x, y) = (column * SIDE, row * SIDE);
    (x, y, SIDE.min(width - x), SIDE.min(height - y))
}

/// What is on a tile: of the level, or of the photograph itself where that is level 0.
fn texels(
    whole: Option<&Arc<Image<Straight>>>,
    level: Option<&Image<Premultiplied>>,
    key: Key,
) -> Option<ColorImage> {
    if let Some(level) = level {
        let (x, y, width, height) = part(key, level.width(), level.height());
        return Some(premultiplied_image(&level.cropped(x, y, width, height)));
    }
    let whole = whole.filter(|_| key.0 == 0)?;
    let (x, y, width, height) = part(key, whole.width(), whole.height());
    Some(color_image(&whole.cropped(x, y, width, height)))
}

/// A picture as egui takes it.
pub(super) fn premultiplied_image(image: &Image<Premultiplied>) -> ColorImage {
    let size = [image.width() as usize, image.height() as usize];
    let bytes: &[[u8; 4]] = bytemuck::cast_slice(image.pixels());
    ColorImage::from_rgba_premultiplied(size, bytes.as_flattened())
}
