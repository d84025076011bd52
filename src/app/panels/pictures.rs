//! All pictures of the project, as small as stamps.

use super::super::action::Action;
use super::super::commands::Command;
use super::super::photos::Thumbnail;
use super::super::studio::Studio;
use super::super::theme::{GAP, THUMBNAIL, TIGHT, tokens};
use super::color_image;
use crate::base::Digest;
use crate::document::{Photo, PhotoId};
use egui::{Align2, FontId, Sense, TextureHandle, TextureOptions, Ui, pos2, vec2};
use std::collections::BTreeMap;

/// The strip of pictures.
#[derive(Default)]
pub(super) struct Pictures {
    textures: BTreeMap<Digest, TextureHandle>,
}

impl Pictures {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let content = studio.document().state().content();
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            if ui
                .button("Add…")
                .on_hover_text(Command::AddPhotos.row().help)
                .clicked()
            {
                actions.push(Action::Do(Command::AddPhotos));
            }
            ui.add_space(TIGHT);
            egui::ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| {
                    ui.horizontal_wrapped(|ui| {
                        ui.spacing_mut().item_spacing = vec2(GAP, GAP);
                        for (&id, photo) in &content.photos {
                            self.stamp(ui, studio, (id, photo), actions);
                        }
                    });
                });
        });
        self.textures
            .retain(|digest, _| content.photos.values().any(|photo| photo.digest == *digest));
    }

    fn stamp(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        (id, photo): (PhotoId, &Photo),
        actions: &mut Vec<Action>,
    ) {
        let size = vec2(THUMBNAIL + 2.0 * TIGHT, THUMBNAIL + 22.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click());
        let is_shown = studio.shown() == Some(id);
        response.widget_info(|| {
            egui::WidgetInfo::selected(egui::Role::Button, true, is_shown, &photo.name)
        });
        if response.clicked() {
            actions.push(Action::ShowPhoto(id));
        }
        let told = match studio.photos.thumbnail(photo.digest) {
            Some(Thumbnail::Failed(reason)) => reason.clone(),
            _ => format!("{}\n{} × {} px", photo.name, photo.width, photo.height),
        };
        let response = response.on_hover_text(told);
        if ui.is_rect_visible(rect) {
            let tokens = tokens(ui);
            let fill = match (is_shown, response.hovered()) {
                (true, _) => tokens.chosen,
                (false, true) => tokens.hovered,
                (false, false) => tokens.sunken,
            };
            ui.painter().rect_filled(rect, 4.0, fill);
            let picture = egui::Rect::from_min_size(
                rect.min + vec2(TIGHT, TIGHT),
                vec2(THUMBNAIL, THUMBNAIL - TIGHT),
            );
            self.picture(ui, studio, photo, picture);
            let color = if is_shown { tokens.strong } else { tokens.text };
            let text = elided(ui, &photo.name, rect.width() - 2.0 * TIGHT);
            let at = pos2(rect.center().x, rect.bottom() - 11.0);
            ui.painter().text(
                at,
                Align2::CENTER_CENTER,
                text,
                FontId::proportional(11.0),
                color,
            );
        }
        response.context_menu(|ui| {
            if ui.button("Remove").clicked() {
                actions.push(Action::ShowPhoto(id));
                actions.push(Action::Do(Command::RemovePhoto));
                ui.close();
            }
        });
    }

    fn picture(&mut self, ui: &Ui, studio: &Studio, photo: &Photo, place: egui::Rect) {
        match studio.photos.thumbnail(photo.digest) {
            Some(Thumbnail::Ready(image)) => {
                let texture = self.textures.entry(photo.digest).or_insert_with(|| {
                    ui.ctx()
                        .load_texture("thumbnail", color_image(image), TextureOptions::LINEAR)
                });
                let size = texture.size_vec2();
                let scale = (place.width() / size.x).min(place.height() / size.y);
                let rect = egui::Rect::from_center_size(place.center(), size * scale);
                let uv = egui::Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter()
                    .image(texture.id(), rect, uv, egui::Color32::WHITE);
            }
            Some(Thumbnail::Failed(_)) => {
                let (font, color) = (FontId::proportional(11.0), tokens(ui).error);
                ui.painter().text(
                    place.center(),
                    Align2::CENTER_CENTER,
                    "unreadable",
                    font,
                    color,
                );
            }
            Some(Thumbnail::Pending) | None => {}
        }
    }
}

/// `text` without its middle where it is wider than `width` points: ends of file names tell.
pub(super) fn elided(ui: &Ui, text: &str, width: f32) -> String {
    let wide = |text: &str| {
        let font = FontId::proportional(11.0);
        ui.fonts_mut(|fonts| {
            fonts
                .layout_no_wrap(text.to_owned(), font, egui::Color32::WHITE)
                .size()
                .x
        })
    };
    if wide(text) <= width {
        return text.to_owned();
    }
    let letters: Vec<char> = text.chars().collect();
    let mut kept = letters.len().min(40);
    loop {
        kept -= 1;
        let (front, back) = (kept.div_ceil(2), kept / 2);
        let start: String = letters[..front].iter().collect();
        let end: String = letters[letters.len() - back..].iter().collect();
        let short = format!("{start}…{end}");
        if kept <= 2 || wide(&short) <= width {
            return short;
        }
    }
}
