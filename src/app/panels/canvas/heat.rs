//! k all over the crown, in colours: what a formula gives, before and while the crown is made.

use super::super::super::k_field::{KField, MOST_K};
use super::super::super::studio::Studio;
use super::super::super::theme::{GAP, heat, tokens};
use super::camera::Camera;
use super::overlay::lettered;
use crate::document::Tangent;
use crate::geometry::Point;
use crate::paint::{MOST_REDUCED, TiledMask, mean_colors};
use crate::pipeline::{Silhouette, is_crown};
use crate::raster::{Premultiplied, Rect};
use egui::{
    Align2, Color32, ColorImage, Painter, Pos2, TextureHandle, TextureOptions, Ui, pos2, vec2,
};
use std::sync::Arc;

/// Most texels along a side.
const MOST_TEXELS: u32 = 96;

/// How much of the photograph the colours cover, 0 to 255.
const OPACITY: f32 = 150.0;

/// Points of a silhouette that are searched for the nearest one: k changes slowly along it.
const SEARCHED: usize = 160;

/// The colours and what they were made from.
#[derive(Default)]
pub(super) struct HeatMap {
    ground: Option<Ground>,
    painted: Option<(KField, TextureHandle)>,
}

/// Where k is asked for; it stays while k changes.
struct Ground {
    mask: TiledMask,
    silhouette: Arc<Silhouette>,
    /// The texels in pixels of the photograph.
    place: egui::Rect,
    size: [usize; 2],
    /// For each texel what it shows of the crown, 0 to 1, the nearest t, and i and j.
    texels: Vec<(f32, f64, [f64; 2])>,
}

impl HeatMap {
    /// Draws k over the crown, and the scale of the colours in the panel's corner.
    pub(super) fn draw(&mut self, ui: &Ui, painter: &Painter, camera: &Camera, studio: &Studio) {
        // The scale may stand beside the photograph.
        let mut panel = painter.clone();
        panel.set_clip_rect(camera.panel);
        let Some((field, silhouette)) = field_of(studio) else {
            return;
        };
        let Some(mask) = studio.shown_mask() else {
            return;
        };
        let is_same =
            |ground: &Ground| Arc::ptr_eq(&ground.silhouette, &silhouette) && ground.mask == *mask;
        if !self.ground.as_ref().is_some_and(is_same) {
            self.ground = Ground::new(mask, &silhouette);
            self.painted = None;
        }
        let Some(ground) = &self.ground else { return };
        if self.painted.as_ref().is_none_or(|(of, _)| *of != field) {
            let image = ground.image(&field);
            let texture = ui.ctx().load_texture("k", image, TextureOptions::LINEAR);
            self.painted = Some((field.clone(), texture));
        }
        if let Some((_, texture)) = &self.painted {
            let uv = egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let place = camera.rect_on_screen(ground.place);
            painter.image(texture.id(), place, uv, Color32::WHITE);
        }
        scale(ui, &panel, camera, ground.range(&field));
    }
}

/// The k of the shown crown and its silhouette.
fn field_of(studio: &Studio) -> Option<(KField, Arc<Silhouette>)> {
    let photo = studio.shown()?;
    let shown = studio.live.shown.as_deref();
    let shown = shown.filter(|shown| shown.photo == photo)?;
    let settings = studio.document().state().content().crowns.get(&photo)?;
    let field = KField::of(&settings.k, shown.k.map(|[k, _]| k))?;
    let has_line = !shown.silhouette.points.is_empty();
    let is_along_line = matches!(settings.k, Tangent::Profile(_));
    (has_line || !is_along_line).then(|| (field, Arc::clone(&shown.silhouette)))
}

impl Ground {
    fn new(mask: &TiledMask, silhouette: &Arc<Silhouette>) -> Option<Self> {
        let bounds = mask.bounds(is_crown)?;
        let longer = bounds.width.max(bounds.height);
        let level = (0..MOST_REDUCED).find(|level| longer >> level <= MOST_TEXELS);
        let level = level.unwrap_or(MOST_REDUCED);
        let whole = mask.rect_at(level);
        let (x, y) = (bounds.x >> level, bounds.y >> level);
        let place = Rect {
            x,
            y,
            width: (((bounds.x + bounds.width - 1) >> level) + 1).min(whole.width) - x,
            height: (((bounds.y + bounds.height - 1) >> level) + 1).min(whole.height) - y,
        };
        let cover = |label: usize| Premultiplied([if is_crown(label as u8) { 255 } else { 0 }; 4]);
        let colors = Box::new(std::array::from_fn(cover));
        let shares = mean_colors(mask, level, place, &colors);
        let texel = f64::from(1u32 << level);
        let step = (silhouette.points.len() / SEARCHED).max(1);
        let searched: Vec<_> = silhouette.points.iter().step_by(step).collect();
        let of_texel = |(index, share): (usize, &Premultiplied)| {
            let column = place.x as usize + index % place.width as usize;
            let row = place.y as usize + index / place.width as usize;
            let middle = Point::new(column as f64 + 0.5, row as f64 + 0.5) * texel - 0.5;
            let distance = |at: &Point| at.distance_squared(middle);
            let nearest = searched
                .iter()
                .min_by(|(_, a), (_, b)| distance(a).total_cmp(&distance(b)));
            let t = nearest.map_or(0.0, |(t, _)| *t);
            let share = f32::from(share.alpha()) / 255.0;
            (share, t, silhouette.shares(middle))
        };
        let corner = pos2((place.x << level) as f32, (place.y << level) as f32);
        let side = |length: u32| (length << level) as f32;
        Some(Self {
            mask: mask.clone(),
            silhouette: Arc::clone(silhouette),
            place: egui::Rect::from_min_size(corner, vec2(side(place.width), side(place.height))),
            size: [place.width as usize, place.height as usize],
            texels: shares.pixels().iter().enumerate().map(of_texel).collect(),
        })
    }

    fn image(&self, field: &KField) -> ColorImage {
        let color = |&(share, t, shares): &(f32, f64, [f64; 2])| {
            let color = heat((field.value(t, shares) / MOST_K) as f32);
            let alpha = (share * OPACITY) as u8;
            Color32::from_rgba_unmultiplied(color.r(), color.g(), color.b(), alpha)
        };
        ColorImage::new(self.size, self.texels.iter().map(color).collect())
    }

    /// The least and the largest k that is shown.
    fn range(&self, field: &KField) -> [f64; 2] {
        let seen = self.texels.iter().filter(|(share, ..)| *share > 0.0);
        let values = seen.map(|(_, t, shares)| field.value(*t, *shares));
        let values = values.filter(|k| k.is_finite());
        values.fold([f64::INFINITY, 0.0], |[least, most], k| {
            [least.min(k), most.max(k)]
        })
    }
}

/// The colours of k from 0 up, and the least and largest k there is.
fn scale(ui: &Ui, painter: &Painter, camera: &Camera, [least, most]: [f64; 2]) {
    let size = vec2(132.0, 8.0);
    let corner = camera.panel.left_top() + vec2(2.0 * GAP, 2.0 * GAP);
    let bar = egui::Rect::from_min_size(corner, size);
    let ground = bar.expand2(vec2(GAP, GAP)).with_max_y(bar.max.y + 22.0);
    painter.rect_filled(ground, 4.0, tokens(ui).raised.gamma_multiply(0.9));
    let parts = 33;
    for part in 0..parts {
        let share = part as f32 / parts as f32;
        let from = pos2(bar.left() + share * size.x, bar.top());
        let cell = egui::Rect::from_min_size(from, vec2(size.x / parts as f32 + 0.5, size.y));
        painter.rect_filled(cell, 0.0, heat(share));
    }
    let at = |k: f64| bar.left() + size.x * (k / MOST_K).clamp(0.0, 1.0) as f32;
    if least.is_finite() {
        for k in [least, most] {
            let ends = [
                pos2(at(k), bar.top() - 3.0),
                pos2(at(k), bar.bottom() + 3.0),
            ];
            painter.line_segment(ends, (1.5, tokens(ui).strong));
        }
    }
    let text = if !least.is_finite() {
        String::new()
    } else if most - least < 0.01 {
        format!("k {least:.2}")
    } else {
        format!("k {least:.2} to {most:.2}")
    };
    let font = egui::FontId::proportional(12.0);
    let foot = pos2(bar.left(), bar.bottom() + 4.0);
    painter.text(foot, Align2::LEFT_TOP, text, font, tokens(ui).text);
}

/// A small map of the formula for its panel: k over the square that i and j go over.
pub(in super::super) fn swatch(painter: &Painter, rect: egui::Rect, field: &KField) {
    let cells = 24;
    let size = rect.size() / cells as f32;
    for row in 0..cells {
        for column in 0..cells {
            let share = |cell: i32| (f64::from(cell) + 0.5) / f64::from(cells);
            let k = field.value(0.0, [share(column), share(row)]);
            let from: Pos2 = rect.min + vec2(column as f32 * size.x, row as f32 * size.y);
            let cell = egui::Rect::from_min_size(from, size + vec2(0.5, 0.5));
            painter.rect_filled(cell.intersect(rect), 0.0, heat((k / MOST_K) as f32));
        }
    }
    lettered(
        painter,
        rect.left_top() + vec2(5.0, 3.0),
        Align2::LEFT_TOP,
        "i, j = 0",
    );
}
