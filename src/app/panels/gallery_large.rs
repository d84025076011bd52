//! One tree over the whole gallery.

use super::super::act_vary::VaryAction;
use super::super::action::Action;
use super::super::studio::Studio;
use super::super::theme::{GAP, tokens};
use super::super::vary::Large;
use super::gallery::made_of;
use super::textures::Textures;
use crate::base::{Digest, Hasher};
use egui::{Color32, Key, Rect, Sense, Ui, pos2, vec2};

/// Draws the tree, with the way back and to its neighbours.
pub(super) fn show(
    ui: &mut Ui,
    studio: &Studio,
    large: &Large,
    textures: &mut Textures,
    actions: &mut Vec<Action>,
) {
    let vary = &studio.vary;
    let all: Vec<Digest> = vary.gallery.iter().map(|cell| cell.key).collect();
    let at = all.iter().position(|key| *key == large.cell.key);
    let neighbour = |step: isize| {
        let to = at?.checked_add_signed(step)?;
        all.get(to).copied()
    };
    let mut go = |key: Option<Digest>| actions.push(Action::Vary(VaryAction::Enlarge(key)));
    ui.horizontal(|ui| {
        if ui
            .button("Back")
            .on_hover_text("Back to the gallery (Esc)")
            .clicked()
        {
            go(None);
        }
        for (label, step) in [("Previous", -1), ("Next", 1)] {
            let to = neighbour(step);
            if ui
                .add_enabled(to.is_some(), egui::Button::new(label))
                .clicked()
            {
                go(to);
            }
        }
        ui.add_space(GAP);
        ui.weak("Seed");
        ui.monospace(large.cell.seed.to_string());
        if ui.small_button("Copy Seed").clicked() {
            ui.copy_text(large.cell.seed.to_string());
        }
        if let Some(Ok(tile)) = vary.tile(&large.cell) {
            ui.add(egui::Label::new(egui::RichText::new(made_of(studio, tile)).weak()).truncate());
        }
    });
    if !ui.ctx().egui_wants_keyboard_input() {
        let pressed = |key| ui.input(|input| input.key_pressed(key));
        if pressed(Key::Escape) {
            go(None);
        } else if pressed(Key::ArrowLeft) && neighbour(-1).is_some() {
            go(neighbour(-1));
        } else if pressed(Key::ArrowRight) && neighbour(1).is_some() {
            go(neighbour(1));
        }
    }
    let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Tree, large"));
    ui.painter().rect_filled(rect, 5.0, tokens(ui).sunken);
    let side = rect.width().min(rect.height()) - 2.0 * GAP;
    let place = Rect::from_center_size(rect.center(), vec2(side, side));
    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let tile = vary.tile(&large.cell).and_then(|tile| tile.as_ref().ok());
    let (key, image) = match (&large.image, tile) {
        (Some(image), _) => (
            Hasher::new("large").with(large.cell.key.bytes()).finish(),
            image,
        ),
        (None, Some(tile)) => (large.cell.key, &tile.image),
        (None, None) => return,
    };
    let texture = textures.of(ui.ctx(), key, image);
    ui.painter().image(texture.id(), place, uv, Color32::WHITE);
}
