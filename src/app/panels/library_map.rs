//! The exemplars as a map: those that go together lie side by side, lines join what random choice may
//! mix.
//!
//! A click takes an exemplar in or leaves it out; what the pointer is on shows its own lines and how
//! far each neighbour is.

use super::super::act_vary::VaryAction;
use super::super::action::{Action, Gesture};
use super::super::studio::Studio;
use super::super::theme::{GAP, TIGHT, tokens};
use super::super::vary::Prepared;
use super::textures::Textures;
use super::{changed_settings, empty};
use crate::base::Hasher;
use crate::document::{PhotoId, VariationSettings};
use crate::variation::Neighbour;
use egui::{Align2, Color32, FontId, Pos2, Rect, Sense, Stroke, Ui, pos2, vec2};
use std::collections::BTreeSet;

/// Side of an exemplar's picture, points: that of few, and the least of many.
const LARGEST: f32 = 64.0;
const SMALLEST: f32 = 26.0;

/// Distance from which on a line is as pale as it gets: beyond, trees are hardly related.
const PALE: f64 = 3.0;

/// The panel.
#[derive(Default)]
pub(super) struct LibraryMap {
    textures: Textures,
}

impl LibraryMap {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let settings = &studio.document().state().content().variation;
        let Some(prepared) = &studio.vary.prepared else {
            empty(
                ui,
                "No map yet",
                "Exemplars that go together lie side by side here.",
            );
            return;
        };
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            how_chosen(ui, studio, settings, actions);
            ui.add_space(TIGHT);
            self.map(ui, studio, prepared, actions);
        });
        self.textures.sweep(ui);
    }

    fn map(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        prepared: &Prepared,
        actions: &mut Vec<Action>,
    ) {
        let settings = &studio.document().state().content().variation;
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Map of trees that go together")
        });
        let tokens = tokens(ui);
        let painter = ui.painter_at(rect);
        painter.rect_filled(rect, 5.0, tokens.sunken);
        let count = prepared.places.len().max(1) as f32;
        let side = (0.9 * (rect.area() / count).sqrt()).clamp(SMALLEST, LARGEST);
        let places = on_screen(prepared, rect.shrink(0.5 * side + TIGHT));
        let is_near = |at: &Pos2| {
            let pointer = response.hover_pos();
            pointer.is_some_and(|pointer| (pointer - *at).abs().max_elem() < 0.5 * side)
        };
        // What is drawn last lies on top.
        let hovered = places.iter().rposition(is_near);
        let mix = studio.vary.mix(settings);
        let mixed: BTreeSet<PhotoId> = mix.iter().map(|part| part.photo).collect();
        let is_in = |index: usize| mixed.contains(&prepared.photos[index]);
        lines(
            &painter,
            prepared,
            &places,
            hovered,
            tokens.accent,
            settings.walks,
        );
        let own = hovered.map_or(&[][..], |at| &prepared.graph.neighbours[at]);
        for (index, at) in places.iter().enumerate() {
            let is_neighbour = own.iter().any(|near| near.exemplar == index);
            let is_shown = hovered.is_none_or(|on| on == index || is_neighbour);
            let strength = match (is_in(index), is_shown) {
                (true, true) => 255,
                (true, false) | (false, true) => 110,
                (false, false) => 50,
            };
            let place = Rect::from_center_size(*at, vec2(side, side));
            let digest = prepared.library.entries()[index].digest;
            let key = Hasher::new("exemplar").with(digest.bytes()).finish();
            let texture = self.textures.of(ui.ctx(), key, &prepared.small[index]);
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            let tint = Color32::from_white_alpha(strength);
            painter.image(texture.id(), place, uv, tint);
            if hovered == Some(index) {
                let stroke = Stroke::new(1.5, tokens.accent);
                painter.rect_stroke(place, 5.0, stroke, egui::StrokeKind::Inside);
            }
        }
        distances(&painter, own, &places, side, tokens.text);
        let Some(hovered) = hovered else { return };
        let photo = prepared.photos[hovered];
        if response.clicked() {
            actions.push(Action::Vary(VaryAction::Toggle(photo)));
        }
        let photos = &studio.document().state().content().photos;
        let name = photos.get(&photo).map_or("?", |photo| photo.name.as_str());
        let state = if is_in(hovered) {
            "Click leaves it out."
        } else {
            "Click takes it in."
        };
        let near = match own.len() {
            0 => "No tree goes with it: it is mixed with none unless any pair may be.".to_owned(),
            count => format!("{count} trees go with it; the smaller the number, the better."),
        };
        response.on_hover_text_at_pointer(format!("{name}\n{near}\n{state}"));
    }
}

/// Whether random choice walks the map.
fn how_chosen(
    ui: &mut Ui,
    studio: &Studio,
    settings: &VariationSettings,
    actions: &mut Vec<Action>,
) {
    ui.horizontal(|ui| {
        ui.weak("Chance");
        for (walks, title, help) in [
            (
                true,
                "Walks the Map",
                "From an exemplar to one that goes with it: new trees look grown.",
            ),
            (
                false,
                "Any Pair",
                "Mixes any exemplars, thin trees and thick ones too: bold shapes, and some that look stretched.",
            ),
        ] {
            let is_on = settings.walks == walks;
            let choice = ui.selectable_label(is_on, title);
            if choice.on_hover_text(help).clicked() && !is_on {
                let whole = Some(Gesture::Whole);
                changed_settings(actions, studio, "Chance", whole, |s| s.walks = walks);
            }
        }
    });
}

/// Where the exemplars stand on the screen: the map fills `rect` along both sides.
fn on_screen(prepared: &Prepared, rect: Rect) -> Vec<Pos2> {
    let places = || prepared.places.iter().map(|p| pos2(p.x as f32, p.y as f32));
    let bounds = Rect::from_points(&places().collect::<Vec<Pos2>>());
    let share = |value: f32, low: f32, length: f32| match length > 0.0 {
        true => (value - low) / length,
        false => 0.5,
    };
    let on_screen = |place: Pos2| {
        let x = share(place.x, bounds.left(), bounds.width());
        let y = share(place.y, bounds.top(), bounds.height());
        rect.min + vec2(x * rect.width(), y * rect.height())
    };
    places().map(on_screen).collect()
}

/// Lines between exemplars that go together, the better the stronger; those of what the pointer is on
/// before all.
fn lines(
    painter: &egui::Painter,
    prepared: &Prepared,
    places: &[Pos2],
    hovered: Option<usize>,
    color: Color32,
    walks: bool,
) {
    for (a, b, distance) in prepared.graph.edges() {
        let near = 1.0 - (distance / PALE).min(1.0) as f32;
        let is_own = hovered.is_some_and(|at| at == a || at == b);
        let strength = match (is_own, hovered.is_some(), walks) {
            (true, _, _) => 0.5 + 0.5 * near,
            (false, true, _) => 0.05,
            (false, false, true) => 0.08 + 0.4 * near,
            // Nobody walks them.
            (false, false, false) => 0.06,
        };
        let stroke = Stroke::new(1.0 + 1.5 * near, color.gamma_multiply(strength));
        painter.line_segment([places[a], places[b]], stroke);
    }
}

/// How far the neighbours are.
fn distances(
    painter: &egui::Painter,
    own: &[Neighbour],
    places: &[Pos2],
    side: f32,
    color: Color32,
) {
    for near in own {
        let at = places[near.exemplar] + vec2(0.0, 0.5 * side);
        let text = format!("{:.1}", near.distance);
        painter.text(
            at,
            Align2::CENTER_BOTTOM,
            text,
            FontId::proportional(10.0),
            color,
        );
    }
}
