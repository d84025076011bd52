//! The crown in three dimensions.

use super::super::action::Action;
use super::super::live::{Drawn, LiveAction};
use super::super::preferences::Navigation;
use super::super::studio::{Effect, Studio};
use super::super::theme::{GAP, TIGHT, tokens};
use super::empty;
use super::screen::{Look, Screen, light};
use crate::document::PhotoId;
use crate::scene::{Backdrop, Camera};
use eframe::egui_wgpu::RenderState;
use egui::{Color32, PointerButton, Pos2, Rect, Response, Sense, Ui, Vec2, pos2, vec2};
use glam::DVec3;

/// Degrees that a drag over the whole height of the view turns the tree by.
const TURN_DEG: f64 = 200.0;

/// Degrees a second of the turntable.
const TURNTABLE_DEG: f64 = 24.0;

/// Radius of the ball that the sun is dragged on, points.
const BALL: f32 = 24.0;

/// How low the sun may stand, degrees.
const LOWEST_SUN_DEG: f64 = 3.0;

/// The panel.
pub(super) struct View {
    screen: Screen,
    /// The tree that fills the view, and the ball around it: edits do not move the camera.
    framed: Option<(PhotoId, (DVec3, f64))>,
    /// Moves the target in the plane of the picture, heights of the picture.
    pan: Vec2,
    frames_again: bool,
    /// Whether the picture is all that it will be.
    is_final: bool,
}

/// What a drag over the picture does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Motion {
    Orbit,
    Pan,
    Zoom,
    Sun,
}

impl View {
    pub(super) fn new(card: Option<&RenderState>) -> Self {
        Self {
            screen: Screen::new(card),
            framed: None,
            pan: Vec2::ZERO,
            frames_again: false,
            is_final: false,
        }
    }

    pub(super) fn perform(&mut self, effect: &Effect) {
        if *effect == Effect::FrameTree {
            self.frames_again = true;
        }
    }

    /// Whether the picture is all that it will be.
    pub(super) fn is_final(&self) -> bool {
        self.is_final
    }

    /// Whether the graphics card was lost.
    pub(super) fn has_lost_card(&self) -> bool {
        self.screen.has_lost_card()
    }

    /// Loses that card, to try out what comes of it.
    #[cfg(debug_assertions)]
    pub(super) fn lose_card(&self) {
        self.screen.lose_card();
    }

    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let Some(shown) = &studio.live.shown else {
            let (heading, text) = match (&studio.live.trouble, studio.live.is_working()) {
                (Some(trouble), _) => ("No crown", trouble.as_str()),
                (None, true) => ("Making the crown", "It shows here in a moment."),
                (None, false) => (
                    "No crown yet",
                    "Paint a mask over the crown of a tree to see it here.",
                ),
            };
            empty(ui, heading, text);
            return;
        };
        egui::Frame::NONE
            .inner_margin(egui::Margin::symmetric(GAP as i8, TIGHT as i8))
            .show(ui, |ui| toolbar(ui, studio, actions));
        let (rect, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Crown"));
        if rect.width() < 8.0 || rect.height() < 8.0 {
            return;
        }
        let bounds = self.framed_bounds(shown.photo, shown.bounds, actions, studio);
        let camera = self.camera(studio, bounds, rect);
        self.navigate(ui, studio, &response, rect, &camera, actions);
        self.turn(ui, studio, actions);
        let scale = ui.ctx().pixels_per_point();
        let look = Look {
            shown,
            camera,
            light: light(studio),
            size: (
                (rect.width() * scale).round().max(1.0) as u32,
                (rect.height() * scale).round().max(1.0) as u32,
            ),
        };
        if studio.live.seen != Some((camera, look.size)) {
            actions.push(Action::Live(LiveAction::Seen(camera, look.size)));
        }
        let texture = self.screen.texture(ui.ctx(), studio, &look, actions);
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 0.0, tokens(ui).sunken);
        self.is_final = texture.is_some_and(|(_, is_final)| is_final);
        if let Some((texture, is_final)) = texture {
            let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            painter.image(texture, rect, uv, Color32::WHITE);
            if !is_final {
                ui.ctx().request_repaint();
            }
        }
        self.sun_ball(ui, studio, rect, &camera, actions);
        self.remarks(ui, studio, rect);
    }

    /// The ball that the view is framed to.
    fn framed_bounds(
        &mut self,
        photo: PhotoId,
        bounds: (DVec3, f64),
        actions: &mut Vec<Action>,
        studio: &Studio,
    ) -> (DVec3, f64) {
        let is_other = self.framed.is_none_or(|(of, _)| of != photo);
        if std::mem::take(&mut self.frames_again) {
            let view = studio.document().view();
            actions.push(Action::Live(LiveAction::Camera(view.camera_deg, 1.0)));
            self.pan = Vec2::ZERO;
            self.framed = Some((photo, bounds));
        } else if is_other {
            self.pan = Vec2::ZERO;
            self.framed = Some((photo, bounds));
        }
        self.framed.map_or(bounds, |(_, bounds)| bounds)
    }

    fn camera(&self, studio: &Studio, (middle, radius): (DVec3, f64), rect: Rect) -> Camera {
        let view = studio.document().view();
        let aspect = f64::from(rect.width() / rect.height());
        Camera::framing(middle, radius, view.camera_deg, aspect)
            .zoomed(view.distance.clamp(0.02, 50.0))
            .panned(f64::from(self.pan.x), f64::from(self.pan.y))
    }

    fn navigate(
        &mut self,
        ui: &Ui,
        studio: &Studio,
        response: &Response,
        rect: Rect,
        camera: &Camera,
        actions: &mut Vec<Action>,
    ) {
        let view = studio.document().view();
        let mut distance = view.distance;
        let (mut yaw, mut pitch) = view.camera_deg;
        if response.hovered() {
            let wheel =
                ui.input(|input| input.smooth_scroll_delta().y + 120.0 * input.zoom_delta().ln());
            distance *= (-f64::from(wheel) * 0.004).exp();
        }
        if response.double_clicked() {
            self.frames_again = true;
        }
        if response.dragged() {
            let delta = response.drag_delta() / rect.height();
            let (across, down) = (f64::from(delta.x), f64::from(delta.y));
            match self.motion(ui, studio, response) {
                Some(Motion::Orbit) => {
                    let turned = camera.orbited(-across * TURN_DEG, down * TURN_DEG);
                    (yaw, pitch) = (turned.yaw_deg, turned.pitch_deg);
                }
                Some(Motion::Pan) => self.pan += vec2(-delta.x, delta.y),
                Some(Motion::Zoom) => distance *= (down * 3.0).exp(),
                Some(Motion::Sun) if delta != Vec2::ZERO => {
                    let (yaw, pitch) = view.sun_deg;
                    let pitch = (pitch - down * TURN_DEG).clamp(LOWEST_SUN_DEG, 89.0);
                    let sun = ((yaw + across * TURN_DEG).rem_euclid(360.0), pitch);
                    actions.push(Action::Live(LiveAction::Sun(sun)));
                }
                Some(Motion::Sun) | None => {}
            }
        }
        let distance = distance.clamp(0.05, 20.0);
        if ((yaw, pitch), distance) != (view.camera_deg, view.distance) {
            actions.push(Action::Live(LiveAction::Camera((yaw, pitch), distance)));
        }
    }

    fn motion(&self, ui: &Ui, studio: &Studio, response: &Response) -> Option<Motion> {
        let modifiers = ui.input(|input| input.modifiers);
        let button = [
            PointerButton::Primary,
            PointerButton::Middle,
            PointerButton::Secondary,
        ]
        .into_iter()
        .find(|button| response.dragged_by(*button))?;
        let navigation = studio.preferences.navigation;
        Some(match (navigation, button) {
            (Navigation::Maya, PointerButton::Middle) if modifiers.alt => Motion::Pan,
            (Navigation::Maya, PointerButton::Secondary) if modifiers.alt => Motion::Zoom,
            (Navigation::Maya, PointerButton::Primary) if modifiers.alt => Motion::Orbit,
            (_, PointerButton::Primary) if modifiers.alt => Motion::Sun,
            (_, PointerButton::Primary) if modifiers.shift => Motion::Pan,
            (_, PointerButton::Primary) => Motion::Orbit,
            (Navigation::Blender, PointerButton::Middle) if modifiers.shift => Motion::Pan,
            (Navigation::Blender, PointerButton::Middle) if modifiers.ctrl => Motion::Zoom,
            (Navigation::Blender, PointerButton::Middle) => Motion::Orbit,
            (_, PointerButton::Middle) => Motion::Pan,
            _ => return None,
        })
    }

    fn turn(&self, ui: &Ui, studio: &Studio, actions: &mut Vec<Action>) {
        if !studio.live.is_turning {
            return;
        }
        let seconds = f64::from(ui.input(|input| input.stable_dt)).min(0.2);
        let view = studio.document().view();
        let yaw = (view.camera_deg.0 + TURNTABLE_DEG * seconds).rem_euclid(360.0);
        let camera = (yaw, view.camera_deg.1);
        actions.push(Action::Live(LiveAction::Camera(camera, view.distance)));
        ui.ctx().request_repaint();
    }

    /// A ball lit by the sun; dragging its light moves the sun.
    fn sun_ball(
        &mut self,
        ui: &Ui,
        studio: &Studio,
        rect: Rect,
        camera: &Camera,
        actions: &mut Vec<Action>,
    ) {
        let center = rect.right_top() + vec2(-BALL - 2.0 * GAP, BALL + 2.0 * GAP);
        let place = Rect::from_center_size(center, Vec2::splat(2.0 * BALL));
        let id = ui.scope_id().with("sun");
        let response = ui.interact(place, id, Sense::drag());
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, "Sun"));
        let axes = camera.axes();
        if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let at = (pointer - center) / BALL;
            let at = at / at.length().max(1.0);
            let (x, y) = (f64::from(at.x), -f64::from(at.y));
            let towards = (1.0 - x * x - y * y).max(0.0).sqrt();
            let sun = axes.right * x + axes.up * y - axes.forward * towards;
            let yaw = libm::atan2(sun.x, sun.z).to_degrees();
            let pitch = libm::asin(sun.y.clamp(-1.0, 1.0)).to_degrees();
            let pitch = pitch.clamp(LOWEST_SUN_DEG, 89.0);
            if (yaw, pitch) != studio.document().view().sun_deg {
                actions.push(Action::Live(LiveAction::Sun((yaw, pitch))));
            }
        }
        let sun = light(studio).toward_sun();
        let seen = vec2(sun.dot(axes.right) as f32, -sun.dot(axes.up) as f32);
        let is_in_front = sun.dot(axes.forward) < 0.0;
        draw_ball(
            ui,
            center,
            seen,
            is_in_front,
            response.hovered() || response.dragged(),
        );
        response.on_hover_text(
            "The sun: drag the light over the ball. Or drag in the view with Alt held.",
        );
    }

    /// What the user should know about the picture.
    fn remarks(&self, ui: &Ui, studio: &Studio, rect: Rect) {
        let mut lines = Vec::new();
        if let Some(trouble) = &studio.live.trouble {
            lines.push((format!("Not changed: {trouble}"), tokens(ui).error));
        }
        if let Some(trouble) = &self.screen.trouble {
            let text = format!("Drawn on the processor, coarsely: {trouble}");
            lines.push((text, tokens(ui).weak));
        }
        let mut bottom = rect.left_bottom() + vec2(GAP, -GAP);
        for (text, color) in lines {
            let font = egui::TextStyle::Body.resolve(ui.style());
            let width = rect.width() - 4.0 * GAP;
            let text = ui.painter().layout(text, font, color, width);
            let size = text.size();
            let place =
                Rect::from_min_size(bottom - vec2(0.0, size.y + GAP), size + vec2(GAP, GAP));
            ui.painter().rect_filled(place, 4.0, tokens(ui).raised);
            ui.painter()
                .galley(place.min + vec2(TIGHT, TIGHT), text, color);
            bottom.y = place.min.y - TIGHT;
        }
    }
}

fn draw_ball(ui: &Ui, center: Pos2, seen: Vec2, is_in_front: bool, is_hot: bool) {
    let tokens = tokens(ui);
    let painter = ui.painter();
    let ring = if is_hot { tokens.accent } else { tokens.line };
    painter.circle(
        center,
        BALL,
        tokens.sunken.gamma_multiply(0.85),
        (1.5, ring),
    );
    // The lit side, in rings towards the light.
    let rings = 7;
    for i in 0..rings {
        let share = i as f32 / rings as f32;
        let radius = BALL * (1.0 - share) * 0.92;
        let middle = center + seen * (BALL - radius) * 0.94;
        let light = if is_in_front { 20.0 } else { 9.0 };
        let color = Color32::from_white_alpha((light * (0.5 + share)) as u8);
        painter.circle_filled(middle, radius, color);
    }
    let fill = if is_in_front {
        tokens.warning
    } else {
        tokens.button
    };
    painter.circle(
        center + seen * (BALL - 5.0),
        4.5,
        fill,
        (1.0, tokens.ground),
    );
}

fn toolbar(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = TIGHT;
        for drawn in Drawn::ALL {
            let command = super::super::Command::Draw(drawn);
            let row = command.row();
            let keys = ui.ctx().format_shortcut(&row.shortcut);
            let help = format!("{} ({keys})", row.help);
            let is_on = studio.live.drawn == drawn;
            if ui
                .selectable_label(is_on, drawn.title())
                .on_hover_text(help)
                .clicked()
            {
                actions.push(Action::Do(command));
            }
        }
        for (command, title, is_on) in [
            (super::super::Command::FrameTree, "Frame", false),
            (
                super::super::Command::Turntable,
                "Turn",
                studio.live.is_turning,
            ),
        ] {
            let row = command.row();
            let keys = ui.ctx().format_shortcut(&row.shortcut);
            let help = format!("{} ({keys})", row.help);
            if ui
                .selectable_label(is_on, title)
                .on_hover_text(help)
                .clicked()
            {
                actions.push(Action::Do(command));
            }
        }
        let save = super::super::Command::SavePicture;
        if ui.button("Save…").on_hover_text(save.row().help).clicked() {
            actions.push(Action::Do(save));
        }
        ui.menu_button("Look", |ui| look_menu(ui, studio, actions))
            .response
            .on_hover_text("What stands behind the tree, and which buttons move the camera.");
    });
}

fn look_menu(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.weak("Backdrop");
    for (backdrop, title) in [
        (Backdrop::Studio, "Paper"),
        (Backdrop::Sky, "Sky and Ground"),
        (Backdrop::Clear, "Nothing"),
    ] {
        if ui.radio(studio.live.backdrop == backdrop, title).clicked() {
            actions.push(Action::Live(LiveAction::Backdrop(backdrop)));
        }
    }
    ui.separator();
    ui.weak("Mouse");
    for (navigation, title, help) in [
        (
            Navigation::Trackpad,
            "Trackpad",
            "Left drag orbits, Shift and drag moves, the wheel zooms.",
        ),
        (
            Navigation::Blender,
            "As Blender",
            "Middle drag orbits, with Shift moves, with Ctrl zooms.",
        ),
        (
            Navigation::Maya,
            "As Maya",
            "Alt with left orbits, with middle moves, with right zooms.",
        ),
    ] {
        let is_on = studio.preferences.navigation == navigation;
        if ui.radio(is_on, title).on_hover_text(help).clicked() {
            actions.push(Action::Live(LiveAction::Navigation(navigation)));
        }
    }
}
