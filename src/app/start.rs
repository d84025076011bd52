//! What the window shows while there is nothing to work on.

use super::action::Action;
use super::commands::Command;
use super::studio::Studio;
use super::theme::{GAP, TIGHT, tokens};
use egui::{RichText, Ui};

pub(super) fn show(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let width = 520.0_f32.min(ui.available_width() - 2.0 * GAP);
    let above = (ui.available_height() * 0.18).max(GAP);
    ui.add_space(above);
    ui.vertical_centered(|ui| {
        ui.set_max_width(width);
        ui.label(RichText::new("Boscage").size(34.0).color(tokens(ui).strong));
        ui.label(
            RichText::new("New trees from a few pictures of trees")
                .size(15.0)
                .color(tokens(ui).weak),
        );
        ui.add_space(3.0 * GAP);
        for (command, text) in [
            (Command::OpenSample, "Open the sample project"),
            (Command::Open, "Open a project or pictures…"),
        ] {
            let button = egui::Button::new(RichText::new(text).size(15.0));
            let response = ui.add_sized([width * 0.72, 38.0], button);
            if response.on_hover_text(command.row().help).clicked() {
                actions.push(Action::Do(command));
            }
        }
        ui.add_space(TIGHT);
        ui.weak("or drop photographs and cut-out trees anywhere in this window");
        ui.add_space(3.0 * GAP);
        left_behind(ui, studio, actions);
        recent(ui, studio, actions);
    });
}

/// What a crash left behind: offered, never opened unasked.
fn left_behind(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    if studio.recoverable().is_empty() {
        return;
    }
    ui.label(
        RichText::new("Boscage did not close in order. You can go on with:")
            .color(tokens(ui).warning),
    );
    for left in studio.recoverable() {
        let name = left.file.as_deref().and_then(|file| file.file_name());
        let name = name.map_or("A project without a file".into(), |name| {
            name.to_string_lossy()
        });
        ui.horizontal(|ui| {
            if ui.button("Recover").clicked() {
                actions.push(Action::Recover(left.folder.clone()));
            }
            if ui
                .button("Discard")
                .on_hover_text("Throws these changes away for good.")
                .clicked()
            {
                actions.push(Action::DiscardRecovery(left.folder.clone()));
            }
            ui.label(name);
            if left.tries > 0 {
                ui.weak(format!("tried {} times before", left.tries));
            }
        });
    }
    ui.add_space(2.0 * GAP);
}

fn recent(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    if studio.preferences.recent.is_empty() {
        return;
    }
    ui.label(RichText::new("Recent").color(tokens(ui).weak));
    for path in &studio.preferences.recent {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let link = ui.link(name).on_hover_text(path.display().to_string());
        if link.clicked() {
            actions.push(Action::Open(vec![path.clone()]));
        }
    }
}
