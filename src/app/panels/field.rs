//! A number with a name: a slider, a field that does arithmetic, and a double click that resets.

use super::super::action::Gesture;
use super::super::theme::{GAP, TIGHT, tokens};
use crate::crown::Expression;
use egui::{DragValue, PointerButton, Response, Sense, Slider, SliderClamping, Ui, vec2};
use std::ops::RangeInclusive;

/// A number to be set.
pub(super) struct Field<'a> {
    name: &'a str,
    help: &'a str,
    /// What the slider reaches.
    range: RangeInclusive<f64>,
    /// What can be typed.
    limits: RangeInclusive<f64>,
    usual: f64,
    is_whole: bool,
    is_beside: bool,
}

impl<'a> Field<'a> {
    pub(super) fn new(name: &'a str, range: RangeInclusive<f64>, usual: f64) -> Self {
        Self {
            name,
            help: "",
            limits: *range.start()..=f64::INFINITY,
            range,
            usual,
            is_whole: false,
            is_beside: false,
        }
    }

    /// What it is for, in a sentence.
    pub(super) fn help(self, help: &'a str) -> Self {
        Self { help, ..self }
    }

    /// What can be typed beyond the slider's ends.
    pub(super) fn limits(self, limits: RangeInclusive<f64>) -> Self {
        Self { limits, ..self }
    }

    /// Whole numbers only.
    pub(super) fn whole(self) -> Self {
        Self {
            is_whole: true,
            ..self
        }
    }

    /// Its name stands in a column beside it, not above it.
    pub(super) fn beside(self) -> Self {
        Self {
            is_beside: true,
            ..self
        }
    }

    /// Shows it and changes `value`; where in a gesture of the hand it was changed, if it was.
    pub(super) fn show(self, ui: &mut Ui, value: &mut f64) -> Option<Gesture> {
        let before = *value;
        let help = format!(
            "{}\nDouble-click resets; Ctrl and a click types, sums too.",
            self.help
        );
        let above = (!self.is_beside).then(|| self.label(ui));
        let (label, (rail, typed)) = ui
            .horizontal(|ui| {
                let label = above.unwrap_or_else(|| self.column(ui));
                (label, self.rail_and_value(ui, value))
            })
            .inner;
        let label = label.on_hover_text(&help);
        let rail = rail.labelled_by(label.id).on_hover_text(&help);
        let typed = typed.labelled_by(label.id).on_hover_text(&help);
        let (clicks_twice, is_command) = ui.input(|input| {
            let twice = input.pointer.button_double_clicked(PointerButton::Primary);
            (twice, input.modifiers.command)
        });
        if label.double_clicked() || (rail.hovered() && clicks_twice) {
            *value = self.usual;
            return Some(Gesture::Whole);
        }
        if is_command && rail.is_pointer_button_down_on() {
            // Ctrl and a click: the value is to be typed.
            *value = before;
            typed.request_focus();
            return None;
        }
        *value = value.clamp(*self.limits.start(), *self.limits.end());
        let gesture = gesture_of(&rail).or_else(|| gesture_of(&typed));
        gesture.filter(|gesture| *gesture == Gesture::Ended || *value != before)
    }

    fn label(&self, ui: &mut Ui) -> Response {
        ui.add(egui::Label::new(self.name).sense(Sense::click()))
    }

    /// The name in the first column of a row.
    fn column(&self, ui: &mut Ui) -> Response {
        let size = vec2(96.0, ui.spacing().interact_size.y);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let column = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(size.x);
            self.label(ui)
        });
        column.inner
    }

    fn rail_and_value(&self, ui: &mut Ui, value: &mut f64) -> (Response, Response) {
        /// Width of the field behind the rail, points.
        const FIELD: f32 = 52.0;
        ui.spacing_mut().item_spacing.x = TIGHT;
        ui.spacing_mut().interact_size.x = FIELD;
        ui.spacing_mut().slider_width = (ui.available_width() - FIELD - TIGHT).max(48.0);
        let slider = Slider::new(value, self.range.clone())
            .clamping(SliderClamping::Never)
            .show_value(false);
        let speed = (self.range.end() - self.range.start()) / 300.0;
        let rail = if self.is_whole {
            ui.add(slider.step_by(1.0))
        } else {
            ui.add(slider)
        };
        let field = DragValue::new(value)
            .speed(if self.is_whole { 0.05 } else { speed })
            .update_while_editing(false)
            .custom_parser(arithmetic);
        let typed = if self.is_whole {
            ui.add(field.fixed_decimals(0))
        } else {
            ui.add(field.max_decimals(3))
        };
        (rail, typed)
    }
}

/// Where in a gesture a widget was changed, if it was.
pub(super) fn gesture_of(response: &Response) -> Option<Gesture> {
    if response.drag_stopped() {
        Some(Gesture::Ended)
    } else if response.dragged() || response.is_pointer_button_down_on() {
        Some(Gesture::Going).filter(|_| response.changed() || response.dragged())
    } else {
        response.changed().then_some(Gesture::Whole)
    }
}

/// The number that a typed text stands for.
pub(in super::super) fn arithmetic(text: &str) -> Option<f64> {
    let value = Expression::parse(text.trim()).ok()?.value(0.0, 0.0);
    value.is_finite().then_some(value)
}

/// A heading within a panel.
pub(super) fn section(ui: &mut Ui, title: &str) {
    ui.add_space(GAP);
    ui.strong(title);
    ui.add_space(TIGHT / 2.0);
}

/// A button with a die on it.
pub(super) fn dice(ui: &mut Ui, name: &str) -> Response {
    let side = ui.spacing().interact_size.y;
    let (rect, response) = ui.allocate_exact_size(vec2(side, side), Sense::click());
    let is_enabled = ui.is_enabled();
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, is_enabled, name));
    let visuals = ui.style().interact(&response);
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, visuals.weak_bg_fill);
    let face = rect.shrink(5.0);
    let stroke = (1.2, visuals.fg_stroke.color);
    painter.rect_stroke(face, 2.5, stroke, egui::StrokeKind::Inside);
    for (x, y) in [
        (-1.0, -1.0),
        (1.0, -1.0),
        (0.0, 0.0),
        (-1.0, 1.0),
        (1.0, 1.0),
    ] {
        let at = face.center() + vec2(x, y) * (face.width() * 0.24);
        painter.circle_filled(at, 1.2, visuals.fg_stroke.color);
    }
    if response.has_focus() {
        painter.rect_stroke(
            rect,
            4.0,
            (1.0, tokens(ui).accent),
            egui::StrokeKind::Inside,
        );
    }
    response.on_hover_text(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typed_values_may_be_sums() {
        assert_eq!(arithmetic(" 0.5+1/4 "), Some(0.75));
        assert_eq!(arithmetic("2*pi"), Some(2.0 * std::f64::consts::PI));
        assert_eq!(arithmetic("1/0"), None);
        assert_eq!(arithmetic("two"), None);
    }
}
