//! The photograph and its mask.

use super::super::action::{Action, Pen};
use super::super::studio::{Effect, Studio, Tool};
use super::super::theme::tokens;
use super::{color_image, empty};
use crate::base::Digest;
use crate::paint::{CROWN, Sample, TRUNK, TiledMask};
use egui::{
    Color32, ColorImage, PointerButton, Pos2, Rect, Sense, TextureHandle, TextureOptions, Ui, Vec2,
    pos2, vec2,
};

/// The canvas.
#[derive(Default)]
pub(super) struct Canvas {
    photo: Option<(Digest, TextureHandle)>,
    tint: Option<(u64, TextureHandle)>,
    wanted: Option<Zoom>,
    /// The photograph's pixel in the middle of the panel, and points for a pixel.
    center: Pos2,
    zoom: f32,
}

#[derive(Clone, Copy)]
enum Zoom {
    Fit,
    Pixels,
}

impl Canvas {
    pub(super) fn perform(&mut self, effect: &Effect) {
        match effect {
            Effect::ZoomToFit => self.wanted = Some(Zoom::Fit),
            Effect::ZoomToPixels => self.wanted = Some(Zoom::Pixels),
            _ => {}
        }
    }

    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let content = studio.document().state().content();
        let photo = studio.shown().and_then(|id| content.photos.get(&id));
        let Some(photo) = photo else {
            empty(
                ui,
                "No picture",
                "Add a photograph of a tree to paint its crown.",
            );
            return;
        };
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Canvas"));
        ui.painter().rect_filled(rect, 0.0, tokens(ui).sunken);
        let size = vec2(photo.width as f32, photo.height as f32);
        self.navigate(ui, &response, rect, size);
        self.draw(ui, studio, photo.digest, rect, size);
        self.paint(ui, studio, &response, rect, actions);
    }

    /// Where a pixel of the photograph is on the screen.
    fn on_screen(&self, rect: Rect, pixel: Pos2) -> Pos2 {
        rect.center() + (pixel - self.center) * self.zoom
    }

    fn on_photo(&self, rect: Rect, point: Pos2) -> Pos2 {
        self.center + (point - rect.center()) / self.zoom
    }

    fn navigate(&mut self, ui: &Ui, response: &egui::Response, rect: Rect, size: Vec2) {
        if self.zoom <= 0.0 {
            self.wanted = Some(Zoom::Fit);
        }
        match self.wanted.take() {
            Some(Zoom::Fit) => {
                self.center = (size / 2.0).to_pos2();
                self.zoom = (rect.width() / size.x).min(rect.height() / size.y) * 0.94;
            }
            Some(Zoom::Pixels) => self.zoom = 1.0 / ui.ctx().pixels_per_point(),
            None => {}
        }
        let (wheel, space) = ui.input(|input| {
            (
                input.smooth_scroll_delta().y,
                input.key_down(egui::Key::Space),
            )
        });
        if let Some(pointer) = response.hover_pos()
            && wheel != 0.0
        {
            let under = self.on_photo(rect, pointer);
            self.zoom = (self.zoom * (wheel * 0.004).exp()).clamp(0.01, 64.0);
            self.center = under - (pointer - rect.center()) / self.zoom;
        }
        if response.dragged_by(PointerButton::Middle) || (space && response.dragged()) {
            self.center -= response.drag_delta() / self.zoom;
        }
    }

    fn draw(&mut self, ui: &Ui, studio: &Studio, digest: Digest, rect: Rect, size: Vec2) {
        let place = Rect::from_min_max(
            self.on_screen(rect, Pos2::ZERO),
            self.on_screen(rect, size.to_pos2()),
        );
        let painter = ui.painter().with_clip_rect(rect);
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        if self.photo.as_ref().is_none_or(|(of, _)| *of != digest) {
            self.photo = studio.photos.whole(digest).map(|image| {
                (
                    digest,
                    ui.ctx()
                        .load_texture("photo", color_image(image), TextureOptions::LINEAR),
                )
            });
        }
        if let Some((_, texture)) = &self.photo {
            painter.image(texture.id(), place, uv, Color32::WHITE);
        }
        let Some(mask) = studio.shown_mask().filter(|_| studio.shows_mask) else {
            return;
        };
        if self
            .tint
            .as_ref()
            .is_none_or(|(of, _)| *of != studio.generation)
        {
            self.tint = Some((
                studio.generation,
                ui.ctx()
                    .load_texture("mask", tint(mask), TextureOptions::NEAREST),
            ));
        }
        if let Some((_, texture)) = &self.tint {
            painter.image(texture.id(), place, uv, Color32::WHITE);
        }
    }

    fn paint(
        &self,
        ui: &Ui,
        studio: &Studio,
        response: &egui::Response,
        rect: Rect,
        actions: &mut Vec<Action>,
    ) {
        let Some(pointer) = response.hover_pos().or(response.interact_pointer_pos()) else {
            return;
        };
        if studio.tools.tool != Tool::Brush || ui.input(|input| input.key_down(egui::Key::Space)) {
            return;
        }
        let at = self.on_photo(rect, pointer);
        let sample = Sample::at(f64::from(at.x) - 0.5, f64::from(at.y) - 0.5);
        if response.drag_started_by(PointerButton::Primary) {
            let erases = ui.input(|input| input.modifiers.ctrl);
            actions.push(Action::Pen(Pen::Down { sample, erases }));
        } else if response.dragged_by(PointerButton::Primary) {
            actions.push(Action::Pen(Pen::Move(sample)));
        }
        if response.drag_stopped_by(PointerButton::Primary) {
            actions.push(Action::Pen(Pen::Up));
        }
        let radius = studio.tools.radius_px as f32 * self.zoom;
        let painter = ui.painter().with_clip_rect(rect);
        painter.circle_stroke(pointer, radius, (2.0, Color32::from_black_alpha(140)));
        painter.circle_stroke(pointer, radius, (1.0, Color32::WHITE));
    }
}

fn tint(mask: &TiledMask) -> ColorImage {
    let labels = mask.image();
    let color = |label: &u8| match *label {
        0 => Color32::TRANSPARENT,
        CROWN => Color32::from_rgba_unmultiplied(110, 220, 80, 96),
        TRUNK => Color32::from_rgba_unmultiplied(230, 150, 60, 110),
        _ => Color32::from_rgba_unmultiplied(90, 160, 250, 110),
    };
    let pixels = labels.pixels().iter().map(color).collect();
    ColorImage::new([labels.width() as usize, labels.height() as usize], pixels)
}
