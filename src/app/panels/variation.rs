//! How new trees are made.

use super::super::action::Action;
use super::super::studio::Studio;
use super::empty;
use egui::Ui;

/// The panel.
#[derive(Default)]
pub(super) struct Variation;

impl Variation {
    pub(super) fn show(&mut self, ui: &mut Ui, _studio: &Studio, _actions: &mut Vec<Action>) {
        empty(ui, "Nothing to set", "Add some cut-out trees first.");
    }
}
