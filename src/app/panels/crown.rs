//! How the crown is made.

use super::super::action::Action;
use super::super::studio::Studio;
use super::empty;
use egui::Ui;

/// The panel.
#[derive(Default)]
pub(super) struct Crown;

impl Crown {
    pub(super) fn show(&mut self, ui: &mut Ui, _studio: &Studio, _actions: &mut Vec<Action>) {
        empty(ui, "No picture", "Add a photograph of a tree first.");
    }
}
