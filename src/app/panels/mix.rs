//! A mix by hand: a point dragged between exemplars, and the tree that follows it.
//!
//! The tree is made beside the window and arrives a frame or two later, its outline with it.

use super::super::act_vary::VaryAction;
use super::super::action::{Action, Gesture};
use super::super::studio::Studio;
use super::super::theme::{GAP, TIGHT, tokens};
use super::super::vary::Prepared;
use super::textures::Textures;
use super::{empty, gesture_of};
use crate::base::Hasher;
use crate::document::{ExemplarWeight, PhotoId};
use crate::geometry::Point;
use crate::variation::{Drafts, MixingMap, are_of_a_kind};
use egui::{Color32, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};

/// Most exemplars on the map; beyond, corners are too close to aim at.
const MOST_CORNERS: usize = 8;

/// Corners that an untouched map shows.
const USUAL_CORNERS: usize = 5;

/// Smaller shares are none: they cost as much as large ones and nobody sees them.
const LEAST_SHARE: f64 = 0.004;

/// Side of a thumbnail on the map, points.
const CORNER: f32 = 38.0;

/// The panel.
pub(super) struct Mix {
    textures: Textures,
    /// The exemplars on the map, in the order of its corners.
    corners: Vec<PhotoId>,
    shows_outline: bool,
}

impl Default for Mix {
    fn default() -> Self {
        Self {
            textures: Textures::default(),
            corners: Vec::new(),
            shows_outline: true,
        }
    }
}

/// What can be done on the map.
const MAP_HELP: &str =
    "Drag the point, or a corner to have one alone. Lines join trees that match.";

impl Mix {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let settings = &studio.document().state().content().variation;
        let mix = studio.vary.mix(settings);
        let Some(prepared) = studio.vary.prepared.as_ref().filter(|_| !mix.is_empty()) else {
            empty(ui, "Nothing to mix", "Exemplars show here on a map.");
            return;
        };
        self.keep_corners(&mix);
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            let room = ui.available_size();
            let side = (0.5 * (room.x - GAP)).min(0.62 * room.y).max(90.0);
            ui.horizontal(|ui| {
                ui.spacing_mut().item_spacing.x = GAP;
                self.map(ui, prepared, &mix, side, actions);
                self.preview(ui, studio, side);
            });
            ui.checkbox(&mut self.shows_outline, "Outline")
                .on_hover_text("Draws the outline of the tree that is shown.");
            ui.add(egui::Label::new(egui::RichText::new(MAP_HELP).weak()).wrap());
            let area = egui::ScrollArea::vertical().auto_shrink(false);
            area.show(ui, |ui| shares(ui, studio, &self.corners, &mix, actions));
        });
        self.textures.sweep(ui);
    }

    /// Keeps on the map what is mixed, and fills it up from the strip.
    fn keep_corners(&mut self, mix: &[ExemplarWeight]) {
        let part = |photo: &PhotoId| mix.iter().find(|part| part.photo == *photo);
        self.corners.retain(|photo| part(photo).is_some());
        for wanted in mix.iter().filter(|part| part.weight > 0.0) {
            if self.corners.contains(&wanted.photo) {
                continue;
            }
            let is_free = |photo: &PhotoId| part(photo).is_some_and(|part| part.weight == 0.0);
            if self.corners.len() >= USUAL_CORNERS
                && let Some(at) = self.corners.iter().rposition(is_free)
            {
                self.corners.remove(at);
            }
            if self.corners.len() < MOST_CORNERS {
                self.corners.push(wanted.photo);
            }
        }
        for part in mix {
            if self.corners.len() < USUAL_CORNERS && !self.corners.contains(&part.photo) {
                self.corners.push(part.photo);
            }
        }
    }

    fn map(
        &mut self,
        ui: &mut Ui,
        prepared: &Prepared,
        mix: &[ExemplarWeight],
        side: f32,
        actions: &mut Vec<Action>,
    ) {
        let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::click_and_drag());
        response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Canvas, true, "Map of exemplars")
        });
        let map = MixingMap::new(self.corners.len());
        let radius = 0.5 * side - 0.62 * CORNER;
        let on_screen =
            |point: Point| rect.center() + vec2(point.x as f32, point.y as f32) * radius;
        let share = |photo: &PhotoId| {
            let part = mix.iter().find(|part| part.photo == *photo);
            part.map_or(0.0, |part| part.weight)
        };
        let weights: Vec<f64> = self.corners.iter().map(share).collect();
        self.pull(&response, &map, (rect.center(), radius), mix, actions);
        let tokens = tokens(ui);
        ui.painter().rect_filled(rect, 5.0, tokens.sunken);
        let corners: Vec<Pos2> = map.corners().iter().map(|c| on_screen(*c)).collect();
        let line = Stroke::new(1.0, tokens.line);
        ui.painter().add(Shape::closed_line(corners.clone(), line));
        self.join_matches(ui, prepared, &corners);
        let at = on_screen(map.point(&weights));
        let sum: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
        for ((corner, photo), weight) in corners.iter().zip(&self.corners).zip(&weights) {
            let share = (weight / sum) as f32;
            let stroke = Stroke::new(1.0 + 2.0 * share, tokens.accent.gamma_multiply(share));
            ui.painter().line_segment([at, *corner], stroke);
            let place = Rect::from_center_size(*corner, vec2(CORNER, CORNER));
            let fill = if *weight > 0.0 {
                tokens.chosen
            } else {
                tokens.panel
            };
            ui.painter().rect_filled(place, 6.0, fill);
            if let Some((entry, small)) = prepared.entry(*photo) {
                let key = Hasher::new("exemplar").with(entry.digest.bytes()).finish();
                let texture = self.textures.of(ui.ctx(), key, small);
                let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter()
                    .image(texture.id(), place.shrink(2.0), uv, Color32::WHITE);
            }
        }
        ui.painter().circle_filled(at, 7.0, tokens.panel);
        ui.painter().circle_filled(at, 5.0, tokens.accent);
    }

    /// Joins the exemplars on the map that random choice would mix.
    fn join_matches(&self, ui: &Ui, prepared: &Prepared, corners: &[Pos2]) {
        let stroke = Stroke::new(1.5, tokens(ui).accent.gamma_multiply(0.25));
        let shape = |at: usize| prepared.entry(self.corners[at]).map(|(e, _)| &e.shape);
        for (a, b) in (0..corners.len()).flat_map(|a| (0..a).map(move |b| (a, b))) {
            if let (Some(first), Some(second)) = (shape(a), shape(b))
                && are_of_a_kind(first, second)
            {
                ui.painter().line_segment([corners[a], corners[b]], stroke);
            }
        }
    }

    /// Takes the shares at the pointer while it is down; a click on a corner takes it alone.
    fn pull(
        &self,
        response: &Response,
        map: &MixingMap,
        (middle, radius): (Pos2, f32),
        mix: &[ExemplarWeight],
        actions: &mut Vec<Action>,
    ) {
        let gesture = if response.drag_stopped() {
            Gesture::Ended
        } else if response.dragged() {
            Gesture::Going
        } else if response.clicked() {
            Gesture::Whole
        } else {
            return;
        };
        let Some(pointer) = response.interact_pointer_pos() else {
            actions.push(Action::EndGesture);
            return;
        };
        let offset = (pointer - middle) / radius;
        let mut point = Point::new(f64::from(offset.x), f64::from(offset.y));
        let reach = f64::from(0.5 * CORNER / radius);
        let hit = map.corners().iter().find(|c| c.distance(point) < reach);
        point = hit.copied().unwrap_or(point);
        let on_map = self.corners.iter().copied().zip(map.weights(point));
        let mut weights: Vec<ExemplarWeight> = on_map
            .map(|(photo, weight)| ExemplarWeight {
                photo,
                weight: if weight < LEAST_SHARE { 0.0 } else { weight },
            })
            .collect();
        let others = mix
            .iter()
            .filter(|part| !self.corners.contains(&part.photo));
        weights.extend(others.map(|part| ExemplarWeight {
            photo: part.photo,
            weight: 0.0,
        }));
        actions.push(Action::Vary(VaryAction::Weigh(weights, gesture)));
    }

    fn preview(&mut self, ui: &mut Ui, studio: &Studio, side: f32) {
        let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
        response
            .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "The mixed tree"));
        let tokens = tokens(ui);
        ui.painter().rect_filled(rect, 5.0, tokens.sunken);
        let place = rect.shrink(TIGHT);
        if let Some((key, draft)) = &studio.vary.draft {
            let texture = self.textures.of(ui.ctx(), *key, draft.image());
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter().image(texture.id(), place, uv, Color32::WHITE);
            if !draft.plain.distortion.is_small() {
                let font = egui::FontId::proportional(11.0);
                let at = rect.left_bottom() + vec2(TIGHT, -TIGHT);
                let words = "stretched: these do not match well";
                let align = egui::Align2::LEFT_BOTTOM;
                ui.painter().text(at, align, words, font, tokens.warning);
            }
        }
        if let Some((_, draft)) = studio.vary.draft.as_ref().filter(|_| self.shows_outline) {
            let scale = place.width() / draft.plain.image.width().max(1) as f32;
            // The points are the middles of pixels.
            let on_screen =
                |p: &Point| place.min + vec2(p.x as f32 + 0.5, p.y as f32 + 0.5) * scale;
            let points: Vec<Pos2> = draft
                .plain
                .outline
                .iter()
                .step_by(2)
                .map(on_screen)
                .collect();
            // One by one: where an outline turns back on itself a joint would be a spike.
            let stroke = Stroke::new(1.3, tokens.accent);
            let next = points.iter().cycle().skip(1);
            let lines = points.iter().zip(next);
            let lines = lines.map(|(from, to)| Shape::line_segment([*from, *to], stroke));
            ui.painter_at(rect).extend(lines);
        }
        let told = format!(
            "A quick look at {0} × {0} pixels; batches are made in full.",
            Drafts::SIZE
        );
        response.on_hover_text(told);
    }
}

/// A slider for the share of each exemplar on the map.
fn shares(
    ui: &mut Ui,
    studio: &Studio,
    corners: &[PhotoId],
    mix: &[ExemplarWeight],
    actions: &mut Vec<Action>,
) {
    let photos = &studio.document().state().content().photos;
    let sum: f64 = mix.iter().map(|part| part.weight).sum();
    let on_map = |part: &&ExemplarWeight| corners.contains(&part.photo);
    for part in mix.iter().filter(on_map) {
        let name = photos
            .get(&part.photo)
            .map_or("?", |photo| photo.name.as_str());
        let mut share = part.weight / sum.max(f64::MIN_POSITIVE);
        ui.horizontal(|ui| {
            let slider = egui::Slider::new(&mut share, 0.0..=1.0)
                .custom_formatter(|share, _| format!("{:.0} %", 100.0 * share))
                .custom_parser(|text| {
                    let number: f64 = text.trim_end_matches(['%', ' ']).parse().ok()?;
                    Some(number / 100.0)
                });
            let slider = ui.add(slider);
            let label = ui.add(egui::Label::new(name).truncate());
            let slider = slider.labelled_by(label.id);
            if let Some(gesture) = gesture_of(&slider) {
                let weights = shared(mix, part.photo, share);
                actions.push(Action::Vary(VaryAction::Weigh(weights, gesture)));
            }
        });
    }
}

/// The mix in which `photo` has the share `share` and the others keep theirs among themselves.
fn shared(mix: &[ExemplarWeight], photo: PhotoId, share: f64) -> Vec<ExemplarWeight> {
    let others = mix.iter().filter(|part| part.photo != photo);
    let sum: f64 = others.clone().map(|part| part.weight).sum();
    let mut weights = vec![ExemplarWeight {
        photo,
        // With nobody to share with, it has all.
        weight: if sum > 0.0 { share } else { 1.0 },
    }];
    weights.extend(others.map(|part| ExemplarWeight {
        photo: part.photo,
        // Never quite nothing, or nobody would know their proportions on the way back.
        weight: part.weight / sum.max(f64::MIN_POSITIVE) * (1.0 - share).max(1e-6),
    }));
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slider_leaves_the_others_their_proportions() {
        let part = |photo, weight| ExemplarWeight {
            photo: PhotoId(photo),
            weight,
        };
        let mix = [part(1, 2.0), part(2, 1.0), part(3, 1.0)];
        let found = shared(&mix, PhotoId(1), 0.8);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(found[0].weight, 0.8) && near(found[1].weight, 0.1));
        let all = shared(&mix, PhotoId(1), 1.0);
        assert!(all[1].weight > 0.0 && near(all[1].weight, all[2].weight));
        assert_eq!(shared(&mix[..1], PhotoId(1), 0.3)[0].weight, 1.0);
    }
}
