//! The pictures that new trees are mixed of, ticked or not, with what was found in them.

use super::super::act_vary::VaryAction;
use super::super::action::Action;
use super::super::commands::Command;
use super::super::dock::Pane;
use super::super::studio::Studio;
use super::super::theme::{GAP, TIGHT, tokens};
use super::super::vary::Prepared;
use super::grid;
use super::icon::{self, Icon};
use super::pin_editor::PinEditor;
use super::search::Search;
use super::thumbnails::Thumbnails;
use crate::base::{Digest, Hasher};
use crate::document::{Photo, PhotoId};
use crate::raster::{Image, Straight};
use crate::segment::{Provenance, Source};
use crate::variation::Shape;
use egui::{Align2, Color32, FontId, Rect, Sense, Ui, pos2, vec2};
use std::collections::BTreeSet;

/// Smallest width of a stamp, points.
const STAMP: f32 = 92.0;

/// The panel.
pub(super) struct Exemplars {
    thumbnails: Thumbnails,
    search: Search,
    pins: PinEditor,
}

impl Default for Exemplars {
    fn default() -> Self {
        Self {
            thumbnails: Thumbnails::new(Pane::Exemplars),
            search: Search::default(),
            pins: PinEditor::default(),
        }
    }
}

impl Exemplars {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let content = studio.document().state().content();
        let mix = studio.vary.mix(&content.variation);
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            ui.horizontal(|ui| {
                let help = Command::AddPhotos.row().help;
                if ui.button("Add…").on_hover_text(help).clicked() {
                    actions.push(Action::Do(Command::AddPhotos));
                }
                ui.weak(format!("{} of {}", mix.len(), content.photos.len()))
                    .on_hover_text("Exemplars that trees are drawn from.");
                self.search.field(ui, studio);
            });
            ui.add_space(TIGHT);
            let found = self.search.found(studio);
            let layout = |room: f32| {
                let columns = (((room + GAP) / (STAMP + GAP)) as usize).max(1);
                let side = (room + GAP) / columns as f32 - GAP;
                (columns, vec2(side, side + 34.0))
            };
            let mixed: BTreeSet<PhotoId> = mix.iter().map(|part| part.photo).collect();
            grid::show(ui, found.len(), layout, |ui, index, size| {
                if let Some((&id, photo)) = content.photos.get_key_value(&found[index]) {
                    let look = (mixed.contains(&id), size.x);
                    self.stamp(ui, studio, (id, photo), look, actions);
                }
            });
        });
        self.pins
            .show(ui.ctx(), studio, self.thumbnails.textures(), actions);
        self.thumbnails.end_frame(ui, actions);
    }

    fn stamp(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        (id, photo): (PhotoId, &Photo),
        (is_on, side): (bool, f32),
        actions: &mut Vec<Action>,
    ) {
        let (rect, response) =
            ui.allocate_exact_size(vec2(side, side + 34.0), Sense::click_and_drag());
        let prepared = studio.vary.prepared.as_ref();
        let refused = prepared.and_then(|prepared| prepared.refused.get(&id));
        let can = refused.is_none();
        response.widget_info(|| {
            let name = format!("Exemplar {}", photo.name);
            egui::WidgetInfo::selected(egui::Role::CheckBox, can, is_on, name)
        });
        if response.clicked() && can {
            actions.push(Action::Vary(VaryAction::Toggle(id)));
        }
        response.dnd_set_drag_payload(id);
        if ui.is_rect_visible(rect) {
            let tokens = tokens(ui);
            let fill = if response.hovered() {
                tokens.hovered
            } else {
                tokens.sunken
            };
            ui.painter().rect_filled(rect, 4.0, fill);
            let place = Rect::from_min_size(
                rect.min + vec2(TIGHT, TIGHT),
                vec2(side, side) - vec2(TIGHT, TIGHT) * 2.0,
            );
            let entry = prepared.and_then(|prepared| prepared.entry(id));
            match entry {
                Some((entry, small)) => {
                    let key = Hasher::new("exemplar").with(entry.digest.bytes()).finish();
                    self.prepared(ui, (key, small, &entry.shape), place, is_on);
                }
                None => {
                    let faint = Color32::from_white_alpha(90);
                    self.thumbnails.draw(ui, studio, (id, photo), place, faint);
                }
            }
            if can {
                tick(ui, rect, is_on);
            }
            caption(ui, photo, rect, &badge(studio, prepared, id));
            if entry.is_some() {
                let by_hand = studio.document().state().content().pins.contains_key(&id);
                self.pin_button(ui, photo, (id, by_hand), rect);
            }
        }
        response.context_menu(|ui| {
            if ui
                .add_enabled(can, egui::Button::new("Set Pins…"))
                .clicked()
            {
                self.pins.open(id);
                ui.close();
            }
        });
        let told = told(studio, id, photo, refused);
        response.on_hover_text(told);
    }

    /// Opens the editor of the pins.
    fn pin_button(&mut self, ui: &Ui, photo: &Photo, (id, by_hand): (PhotoId, bool), rect: Rect) {
        let tokens = tokens(ui);
        let corner = rect.right_bottom() - vec2(icon::SIDE + 2.0, icon::SIDE + 2.0);
        let place = Rect::from_min_size(corner, vec2(icon::SIDE, icon::SIDE));
        let name = format!("Pins of {}", photo.name);
        let colors = [tokens.accent, tokens.weak];
        let button = icon::button(ui, (place, Icon::Pin), by_hand, &name, colors);
        let help = "Sets foot and tops of the trunk by hand.";
        if button.on_hover_text(help).clicked() {
            self.pins.open(id);
        }
    }

    /// The normalised picture with its pins.
    fn prepared(
        &mut self,
        ui: &Ui,
        (key, small, shape): (Digest, &Image<Straight>, &Shape),
        place: Rect,
        is_on: bool,
    ) {
        let texture = self.thumbnails.textures().of(ui.ctx(), key, small);
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        let tint = Color32::from_white_alpha(if is_on { 255 } else { 90 });
        ui.painter().image(texture.id(), place, uv, tint);
        let scale = place.width() / shape.size as f32;
        let contour = &shape.contour;
        let mut pins = vec![contour.bottom()];
        if contour.pins.has_trunk() {
            pins.extend([contour.left(), contour.right()]);
        }
        for pin in pins.into_iter().filter(|_| is_on) {
            let at = place.min + vec2(pin.x as f32, pin.y as f32) * scale;
            ui.painter().circle_filled(at, 3.0, tokens(ui).sunken);
            ui.painter().circle_filled(at, 2.0, tokens(ui).accent);
        }
    }
}

/// A tick box in the corner.
fn tick(ui: &Ui, rect: Rect, is_on: bool) {
    let tokens = tokens(ui);
    let area = Rect::from_min_size(rect.min + vec2(6.0, 6.0), vec2(14.0, 14.0));
    let fill = if is_on { tokens.accent } else { tokens.panel };
    ui.painter().rect_filled(area, 3.0, fill);
    if is_on {
        let points = [(3.0, 7.5), (6.0, 10.5), (11.0, 4.0)];
        let points = points.map(|(x, y)| area.min + vec2(x, y)).to_vec();
        let stroke = egui::Stroke::new(2.0, tokens.panel);
        ui.painter().add(egui::Shape::line(points, stroke));
    } else {
        let stroke = egui::Stroke::new(1.0, tokens.weak);
        ui.painter()
            .rect_stroke(area, 3.0, stroke, egui::StrokeKind::Inside);
    }
}

/// What was found in the picture, in two words.
fn badge(studio: &Studio, prepared: Option<&Prepared>, id: PhotoId) -> String {
    let Some(prepared) = prepared else {
        return "preparing".to_owned();
    };
    let by_hand = studio.document().state().content().pins.contains_key(&id);
    match prepared.entry(id) {
        Some(_) if by_hand => "pinned by hand".to_owned(),
        Some((entry, _)) => {
            let trunk = match entry.shape.contour.pins.has_trunk() {
                true => "trunk",
                false => "no trunk",
            };
            let Provenance {
                source, confidence, ..
            } = entry.provenance;
            match (source, confidence) {
                (Source::Learned, Some(confidence)) => {
                    let source = studio.model_name().unwrap_or(source.name());
                    format!("{source} {:.0} %, {trunk}", 100.0 * confidence)
                }
                _ => format!("{source}, {trunk}"),
            }
        }
        None if prepared.refused.contains_key(&id) => "not cut out".to_owned(),
        None => "preparing".to_owned(),
    }
}

fn caption(ui: &Ui, photo: &Photo, rect: Rect, badge: &str) {
    let tokens = tokens(ui);
    let room = rect.width() - 2.0 * TIGHT - icon::SIDE;
    let line = |text: &str, from_bottom: f32, size: f32, color| {
        let text = super::pictures::elided(ui, text, room);
        let at = pos2(rect.left() + TIGHT + 2.0, rect.bottom() - from_bottom);
        ui.painter().text(
            at,
            Align2::LEFT_CENTER,
            text,
            FontId::proportional(size),
            color,
        );
    };
    line(&photo.name, 25.0, 11.0, tokens.text);
    line(badge, 10.0, 10.0, tokens.weak);
}

fn told(studio: &Studio, id: PhotoId, photo: &Photo, refused: Option<&String>) -> String {
    if let Some(reason) = refused {
        return reason.clone();
    }
    let prepared = studio.vary.prepared.as_ref();
    match prepared.and_then(|prepared| prepared.entry(id)) {
        None => photo.name.clone(),
        Some((entry, _)) => {
            let shape = &entry.shape;
            let trunk = match shape.baseline_y {
                Some(_) => "a trunk was found",
                None => "no trunk shows",
            };
            let labelled = labelled(&entry.provenance, &studio.learned_title());
            format!(
                "{}\nCrown and trunk were told apart by {labelled}: {trunk}.\nThe crown is {:.0} % dense. Dots are the pins: foot and tops of the trunk.\nClick to take it in or leave it out; drag it to a colour well; right-click sets the pins.",
                photo.name,
                100.0 * shape.density,
            )
        }
    }
}

/// Who told crown and trunk apart, in a sentence's words.
fn labelled(provenance: &Provenance, learned: &str) -> String {
    let reason = provenance.reason.as_ref();
    match (provenance.source, provenance.confidence) {
        (Source::Learned, Some(confidence)) => {
            format!("{learned} ({:.0} % sure)", 100.0 * confidence)
        }
        (source, _) => match reason {
            Some(reason) => format!("the {source} segmenter ({reason})"),
            None => format!("the {source} segmenter"),
        },
    }
}
