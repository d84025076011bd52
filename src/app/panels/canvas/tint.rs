//! Labels in colour over the photograph, in tiles, and the lines around them.
//!
//! After each step of a brush the tiles of the mask whose handles are new are told from the others,
//! and only their part of each texture is made again. What is made stays the same whatever the zoom:
//! each texel is the mean of the colours of all labels under it.

use super::camera::Camera;
use super::photo_tiles::{Key, SAMPLING, SIDE, UV, covered, premultiplied_image, visible_tiles};
use crate::paint::{MOST_REDUCED, TiledMask, changed_tiles, mean_colors, pixel_borders};
use crate::raster::{Image, Premultiplied, Rect};
use egui::{Color32, Mesh, Painter, Pos2, TextureHandle, Vec2, pos2, vec2};
use std::collections::HashMap;

/// Tiles that are kept.
const MOST_KEPT: usize = 256;

/// Changed tiles of the mask above which all textures are made anew.
const MANY: usize = 1024;

/// Pixels of the screen for one of the photograph from which on lines get a dark edge.
const EDGE_FROM: f32 = 3.0;

/// Coverage of the tint, 0 to 255: the photograph stays clear.
const OPACITY: u8 = 100;

struct Tile {
    /// `None` where nothing is labelled.
    texture: Option<TextureHandle>,
    /// With a row and a column of the neighbours, for the lines between.
    texels: Image<Premultiplied>,
    /// Where the texels are in their level.
    place: Rect,
    /// Around what is labelled, in texels; `None` before they are needed.
    lines: Option<Vec<[(u32, u32); 2]>>,
    /// Whether there may be something to see that no texture shows.
    is_new: bool,
    seen: u64,
}

/// The textures of a mask.
pub(super) struct TintTiles {
    colors: Box<[Premultiplied; 256]>,
    mask: Option<TiledMask>,
    tiles: HashMap<Key, Tile>,
    frame: u64,
}

impl TintTiles {
    /// A mask is drawn in the colours that `color` tells for its labels; `None` is clear.
    pub(super) fn new(color: impl Fn(u8) -> Option<Color32>) -> Self {
        let premultiplied = |label: usize| match color(label as u8) {
            Some(color) => {
                let scaled = |c: u8| (u16::from(c) * u16::from(OPACITY) / 255) as u8;
                Premultiplied([
                    scaled(color.r()),
                    scaled(color.g()),
                    scaled(color.b()),
                    OPACITY,
                ])
            }
            None => Premultiplied([0; 4]),
        };
        Self {
            colors: Box::new(std::array::from_fn(premultiplied)),
            mask: None,
            tiles: HashMap::new(),
            frame: 0,
        }
    }

    /// Brings the textures up to date with `mask`.
    pub(super) fn follow(&mut self, mask: &TiledMask) {
        self.frame += 1;
        let Some(before) = self.mask.as_ref().filter(|own| own.rect() == mask.rect()) else {
            self.tiles.clear();
            self.mask = Some(mask.clone());
            return;
        };
        let changed = changed_tiles(before, mask);
        if changed.is_empty() {
            return;
        }
        self.mask = Some(mask.clone());
        if changed.len() > MANY {
            self.tiles.clear();
            return;
        }
        for (&(level, ..), tile) in &mut self.tiles {
            for &rect in &changed {
                tile.refresh(mask, level, rect, &self.colors);
            }
        }
    }

    /// Nothing to show: forgets all.
    pub(super) fn clear(&mut self) {
        self.mask = None;
        self.tiles.clear();
    }

    /// Draws the tint.
    pub(super) fn draw(&mut self, painter: &Painter, camera: &Camera, size: Vec2) {
        for key in self.made_visible(painter, camera, size) {
            let Some(tile) = self.tiles.get(&key) else {
                continue;
            };
            if let Some(texture) = &tile.texture {
                let place = camera.rect_on_screen(covered(key, texture.size()));
                painter.image(texture.id(), place, UV, Color32::WHITE);
            }
        }
    }

    /// Draws the line around what is labelled.
    pub(super) fn draw_lines(
        &mut self,
        painter: &Painter,
        camera: &Camera,
        size: Vec2,
        (color, shade): (Color32, Color32),
    ) {
        let (mut light, mut dark) = (Mesh::default(), Mesh::default());
        // From afar foliage is all outline: there the line has no edge and is as thin as can be.
        let has_edge = camera.scale() >= EDGE_FROM;
        let half = if has_edge {
            0.6
        } else {
            0.5 / camera.pixels_per_point
        };
        for key in self.made_visible(painter, camera, size) {
            let Some(tile) = self.tiles.get_mut(&key) else {
                continue;
            };
            let texels = &tile.texels;
            let lines = tile.lines.get_or_insert_with(|| {
                pixel_borders(&texels.map(|texel| texel.alpha() > OPACITY / 2))
            });
            let texel = (1 << key.0) as f32;
            let place = |(x, y): (u32, u32)| {
                let corner = pos2((tile.place.x + x) as f32, (tile.place.y + y) as f32);
                camera.on_screen(corner * texel)
            };
            for &[from, to] in lines.iter() {
                let (from, to) = (place(from), place(to));
                if has_edge {
                    dark.add_colored_rect(thick(from, to, 1.2), shade);
                }
                light.add_colored_rect(thick(from, to, half), color);
            }
        }
        painter.add(dark);
        painter.add(light);
    }

    /// Makes the tiles that can be seen; their keys.
    fn made_visible(&mut self, painter: &Painter, camera: &Camera, size: Vec2) -> Vec<Key> {
        let Some(mask) = &self.mask else {
            return Vec::new();
        };
        let level = camera.level(MOST_REDUCED);
        let keys: Vec<Key> = visible_tiles(camera, size, level).collect();
        for &key in &keys {
            let new = || Tile::new(mask, key, &self.colors);
            let tile = self.tiles.entry(key).or_insert_with(new);
            tile.seen = self.frame;
            if tile.is_new && tile.texture.is_none() {
                tile.upload(painter.ctx());
            }
            tile.is_new = false;
        }
        if self.tiles.len() > MOST_KEPT {
            let frame = self.frame;
            self.tiles.retain(|_, tile| tile.seen == frame);
        }
        keys
    }
}

impl Tile {
    fn new(mask: &TiledMask, (level, column, row): Key, colors: &[Premultiplied; 256]) -> Self {
        let whole = mask.rect_at(level);
        let (x, y) = (column * SIDE, row * SIDE);
        let place = Rect {
            x,
            y,
            width: (SIDE + 1).min(whole.width - x),
            height: (SIDE + 1).min(whole.height - y),
        };
        Self {
            texture: None,
            texels: mean_colors(mask, level, place, colors),
            place,
            lines: None,
            is_new: true,
            seen: 0,
        }
    }

    /// The texels that are on the texture.
    fn core(&self) -> Rect {
        Rect {
            x: 0,
            y: 0,
            width: self.place.width.min(SIDE),
            height: self.place.height.min(SIDE),
        }
    }

    /// Makes the texture, if there is anything to see.
    fn upload(&mut self, ctx: &egui::Context) {
        if self.texels.pixels().iter().any(|texel| texel.alpha() > 0) {
            let Rect { width, height, .. } = self.core();
            let image = premultiplied_image(&self.texels.cropped(0, 0, width, height));
            self.texture = Some(ctx.load_texture("mask tile", image, SAMPLING));
        }
    }

    /// Makes again what shows of `changed`, pixels of the mask.
    fn refresh(
        &mut self,
        mask: &TiledMask,
        level: u32,
        changed: Rect,
        colors: &[Premultiplied; 256],
    ) {
        let Some(part) = shared(reduced(changed, level), self.place) else {
            return;
        };
        let texels = mean_colors(mask, level, part, colors);
        let (left, top) = (part.x - self.place.x, part.y - self.place.y);
        for y in 0..part.height {
            let row = &mut self.texels.row_mut(top + y)[left as usize..];
            row[..part.width as usize].copy_from_slice(texels.row(y));
        }
        self.lines = None;
        self.is_new = true;
        let within = Rect {
            x: left,
            y: top,
            ..part
        };
        let visible = shared(within, self.core());
        if let (Some(texture), Some(visible)) = (&mut self.texture, visible) {
            let image = premultiplied_image(&texels.cropped(0, 0, visible.width, visible.height));
            texture.set_partial([left as usize, top as usize], image, SAMPLING);
        }
    }
}

/// The pixels of `level` that `rect` touches.
fn reduced(rect: Rect, level: u32) -> Rect {
    let (x, y) = (rect.x >> level, rect.y >> level);
    Rect {
        x,
        y,
        width: ((rect.x + rect.width - 1) >> level) + 1 - x,
        height: ((rect.y + rect.height - 1) >> level) + 1 - y,
    }
}

/// What both rectangles cover.
fn shared(a: Rect, b: Rect) -> Option<Rect> {
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

/// A line along an axis, `half` points to each side.
fn thick(from: Pos2, to: Pos2, half: f32) -> egui::Rect {
    egui::Rect::from_two_pos(from, to).expand2(vec2(half, half))
}
