//! The crown in three dimensions.

use super::super::action::Action;
use super::super::studio::Studio;
use super::empty;
use egui::Ui;

/// The panel.
#[derive(Default)]
pub(super) struct View;

impl View {
    pub(super) fn new(_creation: &eframe::CreationContext<'_>) -> Self {
        Self
    }

    pub(super) fn prepare(&mut self, _frame: &mut eframe::Frame, _studio: &Studio) {}

    pub(super) fn show(&mut self, ui: &mut Ui, _studio: &Studio, _actions: &mut Vec<Action>) {
        empty(
            ui,
            "No crown yet",
            "Paint a mask over the crown of a tree to see it here.",
        );
    }
}
