//! The panels, one a file. Each looks at the studio and asks for actions; what a panel itself must
//! remember (scrolling, textures, half-typed text) is in its struct and in no project.

mod canvas;
mod crown;
mod exemplars;
mod field;
mod gallery;
mod gallery_breed;
mod gallery_large;
mod gallery_tile;
mod grid;
mod icon;
mod jobs;
pub(super) mod leaves;
mod library_map;
mod mix;
mod outline;
mod pictures;
mod pin_editor;
mod profile;
pub(super) mod screen;
mod search;
mod season;
mod textures;
mod thumbnails;
mod variation;
mod view;

use super::action::{Action, Gesture};
use super::dock::Pane;
use super::studio::{Effect, Studio};
use crate::document::{Edit, VariationSettings};
use crate::raster::{Image, Straight};
use eframe::egui_wgpu::RenderState;
use egui::{ColorImage, Response, Ui};

/// All panels of the window.
pub(super) struct Panels {
    pictures: pictures::Pictures,
    canvas: canvas::Canvas,
    view: view::View,
    crown: crown::Crown,
    exemplars: exemplars::Exemplars,
    gallery: gallery::Gallery,
    mix: mix::Mix,
    library_map: library_map::LibraryMap,
    variation: variation::Variation,
}

impl Panels {
    pub(super) fn new(card: Option<&RenderState>) -> Self {
        Self {
            pictures: pictures::Pictures::default(),
            canvas: canvas::Canvas::default(),
            view: view::View::new(card),
            crown: crown::Crown::default(),
            exemplars: exemplars::Exemplars::default(),
            gallery: gallery::Gallery::default(),
            mix: mix::Mix::default(),
            library_map: library_map::LibraryMap::default(),
            variation: variation::Variation::default(),
        }
    }

    pub(super) fn show(
        &mut self,
        pane: Pane,
        ui: &mut Ui,
        studio: &Studio,
        actions: &mut Vec<Action>,
    ) {
        match pane {
            Pane::Pictures => self.pictures.show(ui, studio, actions),
            Pane::Canvas => self.canvas.show(ui, studio, actions),
            Pane::View => self.view.show(ui, studio, actions),
            Pane::Crown => self.crown.show(ui, studio, actions),
            Pane::Exemplars => self.exemplars.show(ui, studio, actions),
            Pane::Gallery => self.gallery.show(ui, studio, actions),
            Pane::Mix => self.mix.show(ui, studio, actions),
            Pane::Map => self.library_map.show(ui, studio, actions),
            Pane::Variation => self.variation.show(ui, studio, actions),
            Pane::Jobs => jobs::show(ui, studio, actions),
        }
    }

    /// Whether the picture of the crown is all that it will be.
    pub(super) fn view_is_final(&self) -> bool {
        self.view.is_final()
    }

    /// Whether the graphics card that the window is drawn with was lost.
    pub(super) fn has_lost_card(&self) -> bool {
        self.view.has_lost_card()
    }

    /// Loses that card, to try out what comes of it.
    #[cfg(debug_assertions)]
    pub(super) fn lose_card(&self) {
        self.view.lose_card();
    }

    pub(super) fn perform(&mut self, effect: &Effect) {
        self.canvas.perform(effect);
        self.view.perform(effect);
    }
}

/// A picture as egui takes it.
fn color_image(image: &Image<Straight>) -> ColorImage {
    let size = [image.width() as usize, image.height() as usize];
    let bytes: &[[u8; 4]] = bytemuck::cast_slice(image.pixels());
    ColorImage::from_rgba_unmultiplied(size, bytes.as_flattened())
}

/// A panel that has nothing to show says what to do.
fn empty(ui: &mut Ui, heading: &str, text: &str) {
    let above = (ui.available_height() * 0.38).max(0.0);
    ui.add_space(above);
    ui.vertical_centered(|ui| {
        ui.label(egui::RichText::new(heading).size(15.0));
        ui.add_space(super::theme::TIGHT);
        ui.add(egui::Label::new(egui::RichText::new(text).weak()).wrap());
    });
}

/// Where in a gesture of the hand a widget's change stands; `None` when it has none.
fn gesture_of(response: &Response) -> Option<Gesture> {
    if response.drag_stopped() {
        Some(Gesture::Ended)
    } else if response.changed() {
        let is_held = response.dragged();
        Some(if is_held {
            Gesture::Going
        } else {
            Gesture::Whole
        })
    } else {
        None
    }
}

/// Asks for a change of the variations' settings, if there is a gesture.
fn changed_settings(
    actions: &mut Vec<Action>,
    studio: &Studio,
    label: &'static str,
    gesture: Option<Gesture>,
    change: impl FnOnce(&mut VariationSettings),
) {
    let Some(gesture) = gesture else { return };
    let mut settings = studio.document().state().content().variation.clone();
    change(&mut settings);
    actions.push(Action::Edit {
        label,
        edit: Edit::SetVariation(Box::new(settings)),
        gesture,
    });
}
