//! A number with a name: a slider, a field that does arithmetic, and a double click that resets.

use super::super::action::Gesture;
use super::super::theme::{GAP, TIGHT, tokens};
use crate::crown::Expression;
use egui::{PointerButton, Response, Sense, Slider, SliderClamping, Ui, vec2};
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

    /// Shows it and changes `value`; where in a gesture of the hand it was changed, if it was.
    pub(super) fn show(self, ui: &mut Ui, value: &mut f64) -> Option<Gesture> {
        let before = *value;
        let help = format!(
            "{}\nDouble-click resets; the field does arithmetic.",
            self.help
        );
        let label = ui.add(egui::Label::new(self.name).sense(Sense::click()));
        let label = label.on_hover_text(&help);
        ui.spacing_mut().slider_width = (ui.available_width() - 64.0).max(48.0);
        let slider = Slider::new(value, self.range.clone())
            .clamping(SliderClamping::Never)
            .update_while_editing(false)
            .custom_parser(arithmetic);
        let slider = if self.is_whole {
            slider.step_by(1.0).fixed_decimals(0)
        } else {
            slider.max_decimals(3)
        };
        let left = ui.cursor().left();
        let rail = ui.spacing().slider_width;
        let response = ui.add(slider).labelled_by(label.id).on_hover_text(&help);
        let on_rail = response.hover_pos().is_some_and(|at| at.x < left + rail);
        let clicks = ui.input(|input| input.pointer.button_double_clicked(PointerButton::Primary));
        if label.double_clicked() || (on_rail && clicks) {
            *value = self.usual;
            return Some(Gesture::Whole);
        }
        *value = value.clamp(*self.limits.start(), *self.limits.end());
        gesture_of(&response).filter(|gesture| *gesture == Gesture::Ended || *value != before)
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
fn arithmetic(text: &str) -> Option<f64> {
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
