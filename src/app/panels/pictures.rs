//! All pictures of the project, as small as stamps.

use super::super::action::Action;
use super::super::commands::Command;
use super::super::dock::Pane;
use super::super::photos::Thumbnail;
use super::super::studio::Studio;
use super::super::theme::{GAP, THUMBNAIL, TIGHT, tokens};
use super::grid;
use super::search::Search;
use super::thumbnails::Thumbnails;
use crate::document::{Photo, PhotoId};
use egui::{Align2, Color32, FontId, Sense, Ui, Vec2, pos2, vec2};

/// The strip of pictures.
pub(super) struct Pictures {
    thumbnails: Thumbnails,
    search: Search,
}

impl Default for Pictures {
    fn default() -> Self {
        Self {
            thumbnails: Thumbnails::new(Pane::Pictures),
            search: Search::default(),
        }
    }
}

impl Pictures {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let photos = &studio.document().state().content().photos;
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            ui.horizontal_wrapped(|ui| {
                let help = Command::AddPhotos.row().help;
                if ui.button("Add…").on_hover_text(help).clicked() {
                    actions.push(Action::Do(Command::AddPhotos));
                }
                self.search.field(ui, studio);
                let found = self.search.found(studio).len();
                if found < photos.len() {
                    ui.weak(format!("{found} of {}", photos.len()));
                }
            });
            ui.add_space(TIGHT);
            let size = vec2(THUMBNAIL + 2.0 * TIGHT, THUMBNAIL + 22.0);
            let columns = |room: f32| ((room + GAP) / (size.x + GAP)) as usize;
            let found = self.search.found(studio);
            let layout = |room: f32| (columns(room), size);
            grid::show(ui, found.len(), layout, |ui, index, _| {
                if let Some((&id, photo)) = photos.get_key_value(&found[index]) {
                    self.stamp(ui, studio, (id, photo), size, actions);
                }
            });
        });
        self.thumbnails.end_frame(ui, actions);
    }

    fn stamp(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        (id, photo): (PhotoId, &Photo),
        size: Vec2,
        actions: &mut Vec<Action>,
    ) {
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
            let fill = tokens.stamp(is_shown, response.hovered());
            ui.painter().rect_filled(rect, 4.0, fill);
            let picture = egui::Rect::from_min_size(
                rect.min + vec2(TIGHT, TIGHT),
                vec2(THUMBNAIL, THUMBNAIL - TIGHT),
            );
            self.thumbnails
                .draw(ui, studio, (id, photo), picture, Color32::WHITE);
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
}

/// `text` without its middle where it is wider than `width` points: ends of file names tell.
pub(super) fn elided(ui: &Ui, text: &str, width: f32) -> String {
    let wide = |text: &str| {
        let font = FontId::proportional(11.0);
        ui.fonts_mut(|fonts| {
            fonts
                .layout_no_wrap(text.to_owned(), font, Color32::WHITE)
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
