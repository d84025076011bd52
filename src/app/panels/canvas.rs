//! The photograph and its mask, and the tools over them.
//!
//! What is drawn lies in the modules below; here the pointer, the wheel and the keys become actions. The
//! pointer's events are read one by one, not once a frame, so that a quick stroke has all its places.

mod bar;
mod camera;
mod depth;
mod heat;
mod icons;
mod overlay;
mod photo_tiles;
mod tint;

use super::super::action::{Action, Gesture, Pen};
use super::super::mask_action::MaskAction;
use super::super::selecting::Sketch;
use super::super::studio::{Effect, Studio};
use super::super::theme::{INSIDE, OUTSIDE, OVER_PHOTO, TIGHT, UNDER_LINE, label_color, tokens};
use super::super::tools::{Overlay, Tool};
use super::empty;
use crate::base::Digest;
use crate::document::CanvasView;
use crate::paint;
use camera::Camera;
use egui::{
    CursorIcon, Event, Frame, Key, Margin, Modifiers, Panel, PointerButton, Pos2, Rect, Response,
    Sense, Ui, Vec2, vec2,
};
use photo_tiles::PhotoTiles;
use tint::TintTiles;

/// What a point of the wheel zooms by, as a logarithm.
const WHEEL_ZOOM: f32 = 0.004;

/// What a point of the wheel, or of a drag with Shift, changes the brush by, as a logarithm.
const SCRUB: f32 = 0.008;

pub(super) use heat::swatch;

/// What the hand is doing over the canvas.
#[derive(Debug, Clone, Default)]
enum Hand {
    #[default]
    Free,
    /// The pen is down.
    Drawing(PointerButton),
    /// The picture moves with it.
    Panning(PointerButton),
    /// The brush's size follows it: where it began, and the radius then.
    Scrubbing(Pos2, f64),
    /// It holds a handle of k.
    Shaping(Box<depth::Grip>),
}

/// The canvas.
pub(super) struct Canvas {
    camera: Camera,
    wanted: Option<Effect>,
    photo: PhotoTiles,
    mask: TintTiles,
    hints: TintTiles,
    found: TintTiles,
    heat: heat::HeatMap,
    hand: Hand,
    last: Pos2,
    /// Where the canvas looked when the project was told last.
    told: Option<CanvasView>,
}

impl Default for Canvas {
    fn default() -> Self {
        let hint = |label| match label {
            paint::INSIDE => Some(INSIDE),
            paint::OUTSIDE => Some(OUTSIDE),
            _ => None,
        };
        Self {
            camera: Camera::default(),
            wanted: None,
            photo: PhotoTiles::default(),
            mask: TintTiles::new(label_color),
            hints: TintTiles::new(hint),
            found: TintTiles::new(|label| (label != 0).then_some(INSIDE)),
            heat: heat::HeatMap::default(),
            hand: Hand::Free,
            last: Pos2::ZERO,
            told: None,
        }
    }
}

impl Canvas {
    pub(super) fn perform(&mut self, effect: &Effect) {
        self.wanted = Some(effect.clone());
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
        let bar = Frame::new().fill(tokens(ui).panel);
        Panel::top("canvas options")
            .resizable(false)
            .frame(bar.inner_margin(Margin::symmetric(6, 3)))
            .show(ui, |ui| bar::options(ui, studio, actions));
        Panel::left("canvas tools")
            .resizable(false)
            .exact_size(30.0 + 2.0 * TIGHT)
            .frame(bar.inner_margin(Margin::same(4)))
            .show(ui, |ui| bar::tool_column(ui, studio, actions));
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Canvas"));
        ui.painter().rect_filled(rect, 0.0, tokens(ui).sunken);
        self.camera.set_panel(rect);
        self.camera.pixels_per_point = ui.ctx().pixels_per_point();
        let size = vec2(photo.width as f32, photo.height as f32);
        self.look(studio, size);
        self.wheel(ui, studio, &response, actions);
        self.pointer(ui, studio, &response, size, actions);
        self.keys(ui, studio, actions);
        self.draw(ui, studio, photo.digest, size);
        self.depth(ui, studio, &response);
        self.cursor(ui, studio, &response);
        let view = Some(self.camera.view());
        if self.told != view {
            self.told = view;
            actions.push(Action::LookAt(self.camera.view()));
        }
    }

    /// Does what menus and keys asked of the view.
    fn look(&mut self, studio: &Studio, size: Vec2) {
        let camera = &mut self.camera;
        let view = studio.document().view().canvas;
        match view.filter(|_| view != self.told) {
            // Another project, or the photograph of one that was opened.
            Some(view) => camera.look(view),
            None if camera.zoom <= 0.0 => camera.fit(size),
            None => {}
        }
        match self.wanted.take() {
            Some(Effect::ZoomToFit) => camera.fit(size),
            Some(Effect::ZoomToPixels) => camera.show_pixels(),
            Some(Effect::ZoomBy(factor)) => camera.zoom_at(camera.panel.center(), factor),
            _ => {}
        }
    }

    fn wheel(&mut self, ui: &Ui, studio: &Studio, response: &Response, actions: &mut Vec<Action>) {
        let Some(pointer) = response.hover_pos() else {
            return;
        };
        let (wheel, pinch, modifiers) = ui.input(|input| {
            let wheel = input.smooth_scroll_delta();
            (wheel.y, input.zoom_delta(), input.modifiers)
        });
        if pinch != 1.0 {
            self.camera.zoom_at(pointer, pinch);
        } else if wheel != 0.0 && modifiers.alt && studio.tools.tool.has_size() {
            let radius = studio.tools.radius_px * f64::from(wheel * SCRUB).exp();
            actions.push(Action::BrushRadius(radius));
        } else if wheel != 0.0 {
            self.camera.zoom_at(pointer, (wheel * WHEEL_ZOOM).exp());
        }
    }

    /// Reads the pointer's events in their order.
    fn pointer(
        &mut self,
        ui: &Ui,
        studio: &Studio,
        response: &Response,
        size: Vec2,
        actions: &mut Vec<Action>,
    ) {
        let is_over = response.contains_pointer() && !egui::Popup::is_any_open(ui.ctx());
        let (events, has_space, is_down) = ui.input(|input| {
            let has_space = input.key_down(Key::Space);
            (input.events.clone(), has_space, input.pointer.any_down())
        });
        for event in events {
            match event {
                Event::PointerButton {
                    pos,
                    button,
                    pressed: true,
                    modifiers,
                } if is_over
                    && matches!(self.hand, Hand::Free)
                    && self.camera.panel.contains(pos) =>
                {
                    self.press(studio, pos, button, modifiers, has_space, actions);
                }
                Event::PointerButton {
                    button,
                    pressed: false,
                    ..
                } => self.release(button, actions),
                Event::PointerMoved(pos) => {
                    let modifiers = ui.input(|input| input.modifiers);
                    self.moved(studio, (pos, modifiers), is_over, size, actions);
                    self.last = pos;
                }
                _ => {}
            }
        }
        if !is_down && !matches!(self.hand, Hand::Free) {
            // The button went up where nobody saw it.
            self.lift(actions);
        }
        let is_double =
            ui.input(|input| input.pointer.button_double_clicked(PointerButton::Primary));
        let is_line = matches!(studio.sketch(), Some(Sketch::Line(_) | Sketch::Wire(_)));
        if is_over && is_double && is_line {
            actions.push(Action::Mask(MaskAction::Close));
        }
        if is_over
            && is_double
            && studio.tools.tool == Tool::Depth
            && let Some(edit) = depth::toggled(studio, &self.camera, self.last)
        {
            actions.push(Action::Edit {
                label: "Handle of k",
                edit,
                gesture: Gesture::Whole,
            });
        }
    }

    fn press(
        &mut self,
        studio: &Studio,
        at: Pos2,
        button: PointerButton,
        modifiers: Modifiers,
        has_space: bool,
        actions: &mut Vec<Action>,
    ) {
        self.last = at;
        let tool = studio.tools.tool;
        let pans = button == PointerButton::Middle
            || (button == PointerButton::Primary && (has_space || tool == Tool::Hand));
        let is_outside = button == PointerButton::Secondary && tool == Tool::Smart;
        if pans {
            self.hand = Hand::Panning(button);
        } else if tool == Tool::Depth {
            let grip = depth::grip(studio, &self.camera, at);
            if let Some(grip) = grip.filter(|_| button == PointerButton::Primary) {
                self.hand = Hand::Shaping(Box::new(grip));
            }
        } else if button == PointerButton::Primary && modifiers.shift && tool.has_size() {
            self.hand = Hand::Scrubbing(at, studio.tools.radius_px);
        } else if button == PointerButton::Primary || is_outside {
            let closing = studio
                .sketch()
                .and_then(|sketch| overlay::closing_place(&self.camera, sketch));
            if closing.is_some_and(|place| place.distance(at) <= overlay::CLOSING) {
                actions.push(Action::Mask(MaskAction::Close));
                return;
            }
            self.hand = Hand::Drawing(button);
            actions.push(Action::Pen(Pen::Down {
                sample: self.camera.sample(at),
                erases: modifiers.command || is_outside,
            }));
        }
    }

    fn moved(
        &mut self,
        studio: &Studio,
        (to, modifiers): (Pos2, Modifiers),
        is_over: bool,
        size: Vec2,
        actions: &mut Vec<Action>,
    ) {
        match &mut self.hand {
            Hand::Drawing(_) => actions.push(Action::Pen(Pen::Move(self.camera.sample(to)))),
            Hand::Panning(_) => self.camera.pan(to - self.last, size),
            Hand::Scrubbing(from, radius) => {
                let radius = *radius * f64::from((to.x - from.x) * SCRUB).exp();
                actions.push(Action::BrushRadius(radius));
            }
            Hand::Shaping(grip) => {
                let edit = grip.dragged(studio, &self.camera, to, modifiers.shift);
                actions.extend(edit.map(|edit| Action::Edit {
                    label: "Shape k",
                    edit,
                    gesture: Gesture::Going,
                }));
            }
            Hand::Free => {
                if is_over && studio.sketch().is_some() {
                    let sample = self.camera.sample(to);
                    actions.push(Action::Mask(MaskAction::Hover(sample)));
                }
            }
        }
    }

    fn release(&mut self, released: PointerButton, actions: &mut Vec<Action>) {
        let is_released = match &self.hand {
            Hand::Free => false,
            Hand::Drawing(button) | Hand::Panning(button) => *button == released,
            Hand::Scrubbing(..) | Hand::Shaping(_) => released == PointerButton::Primary,
        };
        if is_released {
            self.lift(actions);
        }
    }

    fn lift(&mut self, actions: &mut Vec<Action>) {
        match self.hand {
            Hand::Drawing(_) => actions.push(Action::Pen(Pen::Up)),
            Hand::Shaping(_) => actions.push(Action::EndGesture),
            _ => {}
        }
        self.hand = Hand::Free;
    }

    fn draw(&mut self, ui: &Ui, studio: &Studio, digest: Digest, size: Vec2) {
        let painter = ui.painter().with_clip_rect(self.camera.panel);
        let camera = self.camera;
        let place = camera.rect_on_screen(Rect::from_min_size(Pos2::ZERO, size));
        let checks = [tokens(ui).sunken, tokens(ui).raised];
        self.photo.draw_checks(&painter, place, checks);
        self.photo
            .draw(&painter, &camera, &studio.photos, digest, size);
        let within = painter.with_clip_rect(camera.panel.intersect(place));
        let overlays = studio.mask_work.overlays;
        if let Some(mask) = studio.shown_mask() {
            self.mask.follow(mask);
            // One colour at a time over the photograph.
            if overlays.has(Overlay::Tint) && !overlays.has(Overlay::Heat) {
                self.mask.draw(&within, &camera, size);
            }
            if overlays.has(Overlay::Silhouette) {
                let colors = (OVER_PHOTO, UNDER_LINE);
                self.mask.draw_lines(&within, &camera, size, colors);
            }
        }
        if overlays.has(Overlay::Heat) {
            self.heat.draw(ui, &within, &camera, studio);
        }
        overlay::pixel_grid(&within, &camera, size);
        overlay::shape(ui, &painter, &camera, studio);
        match studio.sketch() {
            Some(Sketch::Smart(smart)) => {
                if let Some(selection) = &smart.selection {
                    self.found.follow(selection);
                    self.found.draw(&within, &camera, size);
                    let colors = (OVER_PHOTO, UNDER_LINE);
                    self.found.draw_lines(&within, &camera, size, colors);
                }
                self.hints.follow(&smart.hints);
                self.hints.draw(&within, &camera, size);
            }
            Some(sketch) => overlay::sketch(&painter, &camera, sketch),
            None => {
                self.found.clear();
                self.hints.clear();
            }
        }
    }

    /// k along the silhouette, where it is wanted.
    fn depth(&self, ui: &Ui, studio: &Studio, response: &Response) {
        let is_tool = studio.tools.tool == Tool::Depth;
        if !is_tool && !studio.mask_work.overlays.has(Overlay::Heat) {
            return;
        }
        let painter = ui.painter().with_clip_rect(self.camera.panel);
        let held = match &self.hand {
            Hand::Shaping(grip) => Some(&**grip),
            _ => None,
        };
        let pointer = response.hover_pos();
        depth::draw(ui, &painter, &self.camera, studio, held, pointer);
    }

    /// The tool under the pointer.
    fn cursor(&self, ui: &Ui, studio: &Studio, response: &Response) {
        let scrubbed = match &self.hand {
            Hand::Scrubbing(from, _) => Some(*from),
            _ => None,
        };
        let Some(pointer) = response.hover_pos().or(scrubbed) else {
            return;
        };
        let (space, ctrl) = ui.input(|input| (input.key_down(Key::Space), input.modifiers.command));
        let tool = studio.tools.tool;
        let icon = match (&self.hand, tool) {
            (Hand::Panning(_) | Hand::Shaping(_), _) => CursorIcon::Grabbing,
            (_, Tool::Hand) => CursorIcon::Grab,
            _ if space => CursorIcon::Grab,
            (_, Tool::Depth) => CursorIcon::PointingHand,
            (_, Tool::Brush | Tool::Smart) => {
                let painter = ui.painter().with_clip_rect(self.camera.panel);
                let at = scrubbed.unwrap_or(pointer);
                let erases = ctrl || (studio.tools.is_erasing && tool == Tool::Brush);
                overlay::brush(&painter, &self.camera, studio, at, erases);
                CursorIcon::None
            }
            _ => CursorIcon::Crosshair,
        };
        ui.ctx().set_cursor_icon(icon);
    }

    /// Keys that mean something while a stroke or a selection is in progress.
    fn keys(&mut self, ui: &Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let is_shaping = matches!(self.hand, Hand::Shaping(_));
        if !(studio.is_drawing() || is_shaping) || ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |key| {
            ui.ctx()
                .input_mut(|input| input.consume_key(Modifiers::NONE, key))
        };
        if pressed(Key::Escape) {
            if is_shaping {
                self.hand = Hand::Free;
            }
            actions.push(Action::AbortGesture);
        } else if pressed(Key::Enter) {
            actions.push(Action::Mask(MaskAction::Close));
        } else if pressed(Key::Backspace) {
            actions.push(Action::Mask(MaskAction::Back));
        }
    }
}
