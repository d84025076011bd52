//! New trees.

use super::super::action::Action;
use super::super::studio::Studio;
use super::empty;
use egui::Ui;

/// The panel.
#[derive(Default)]
pub(super) struct Gallery;

impl Gallery {
    pub(super) fn show(&mut self, ui: &mut Ui, _studio: &Studio, _actions: &mut Vec<Action>) {
        empty(
            ui,
            "No trees yet",
            "Add some cut-out trees to mix new ones from.",
        );
    }
}
