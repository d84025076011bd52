//! The tool column at the canvas's left and the line of options above it.

use super::super::super::action::Action;
use super::super::super::commands::{Command, TABLE};
use super::super::super::mask_action::{MaskAction, MaskCommand};
use super::super::super::selecting::{LineKind, Sketch};
use super::super::super::studio::Studio;
use super::super::super::theme::{GAP, ON_LABEL, TIGHT, label_color, tokens};
use super::super::super::tools::{Overlay, Tool, ToolOption, label_name};
use super::super::field::arithmetic;
use super::icons;
use egui::{
    Align2, Button, Color32, DragValue, FontId, Painter, Rect, Response, Role, Sense, Stroke, Ui,
    Vec2, WidgetInfo,
};

/// Side of a tool's button, points.
const BUTTON: f32 = 30.0;

/// Side of a label's swatch, points.
const SWATCH: f32 = 22.0;

/// The last label that has a key.
const LAST_LABEL: u8 = 9;

/// The tools, one below the other.
pub(super) fn tool_column(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.spacing_mut().item_spacing.y = 2.0;
    for tool in Tool::ALL {
        let is_chosen = studio.tools.tool == tool;
        let command = Command::Take(tool);
        let icon = |painter: &Painter, rect: Rect, color: Color32| {
            icons::tool(painter, rect, tool, color);
        };
        if command_button(ui, command, is_chosen, icon).clicked() {
            actions.push(Action::Do(command));
        }
    }
    ui.add_space(GAP);
    let erases = studio.tools.is_erasing;
    if command_button(ui, Command::ToggleEraser, erases, icons::eraser).clicked() {
        actions.push(Action::Do(Command::ToggleEraser));
    }
    ui.add_space(GAP);
    let help = "Grow, shrink, smooth and clean the chosen label.";
    icon_menu(ui, "Refine", help, icons::refine, |ui| {
        refine(ui, studio, actions);
    });
    let help = "What is drawn over the photograph.";
    icon_menu(ui, "Show", help, icons::show, |ui| {
        show(ui, studio, actions);
    });
}

/// A menu behind an icon.
fn icon_menu(
    ui: &mut Ui,
    name: &str,
    help: &str,
    icon: impl FnOnce(&Painter, Rect, Color32),
    content: impl FnOnce(&mut Ui),
) {
    let response = icon_button(ui, name, false, icon);
    let response = response.on_hover_ui(|ui| {
        ui.strong(name);
        ui.label(help);
    });
    egui::Popup::menu(&response)
        .align(egui::RectAlign::RIGHT_START)
        .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside)
        .show(content);
}

/// A button of the column that stands for a command.
fn command_button(
    ui: &mut Ui,
    command: Command,
    is_chosen: bool,
    icon: impl FnOnce(&Painter, Rect, Color32),
) -> Response {
    let row = command.row();
    let response = icon_button(ui, row.label, is_chosen, icon);
    let keys = ui.ctx().format_shortcut(&row.shortcut);
    response.on_hover_ui(|ui| {
        ui.strong(format!("{} ({keys})", row.label));
        ui.label(row.help);
    })
}

fn icon_button(
    ui: &mut Ui,
    name: &str,
    is_chosen: bool,
    icon: impl FnOnce(&Painter, Rect, Color32),
) -> Response {
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(BUTTON), Sense::click());
    response.widget_info(|| WidgetInfo::selected(Role::Button, true, is_chosen, name));
    let tokens = tokens(ui);
    let (fill, color) = match (is_chosen, response.hovered()) {
        (true, _) => (tokens.chosen, tokens.strong),
        (false, true) => (tokens.hovered, tokens.strong),
        (false, false) => (Color32::TRANSPARENT, tokens.text),
    };
    ui.painter().rect_filled(rect, 4.0, fill);
    if response.has_focus() {
        let stroke = Stroke::new(1.0, tokens.accent);
        ui.painter()
            .rect_stroke(rect, 4.0, stroke, egui::StrokeKind::Inside);
    }
    icon(ui.painter(), rect.shrink(5.0), color);
    response
}

/// What tools paint, how the one in hand is set, and what can be done with the mask.
pub(super) fn options(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.horizontal_wrapped(|ui| {
        ui.set_min_height(26.0);
        if studio.tools.tool.paints() {
            labels(ui, studio, actions);
            ui.separator();
        }
        of_tool(ui, studio, actions);
        of_sketch(ui, studio, actions);
    });
}

fn labels(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.spacing_mut().item_spacing.x = TIGHT;
    let chosen = studio.tools.label;
    for label in 1..=chosen.saturating_add(1).clamp(3, LAST_LABEL) {
        let (rect, response) = ui.allocate_exact_size(Vec2::splat(SWATCH), Sense::click());
        let name = label_name(label);
        let is_chosen = label == chosen;
        let info =
            || WidgetInfo::selected(Role::RadioButton, true, is_chosen, format!("Paint {name}"));
        response.widget_info(info);
        let color = label_color(label).unwrap_or_default();
        let is_dimmed = studio.tools.is_erasing || !(is_chosen || response.hovered());
        let fill = if is_dimmed {
            color.gamma_multiply(0.55)
        } else {
            color
        };
        ui.painter().rect_filled(rect.shrink(2.0), 4.0, fill);
        if is_chosen {
            let stroke = Stroke::new(2.0, tokens(ui).strong);
            ui.painter()
                .rect_stroke(rect.shrink(1.0), 5.0, stroke, egui::StrokeKind::Middle);
        }
        let font = FontId::proportional(12.0);
        let text = if is_dimmed {
            tokens(ui).strong
        } else {
            ON_LABEL
        };
        ui.painter()
            .text(rect.center(), Align2::CENTER_CENTER, label, font, text);
        let tip = format!("Paint {name} ({label}). X swaps crown and trunk.");
        if response.on_hover_text(tip).clicked() {
            actions.push(Action::PaintLabel(label));
        }
    }
    ui.spacing_mut().item_spacing.x = GAP;
}

fn of_tool(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let tools = &studio.tools;
    match tools.tool {
        Tool::Brush => {
            size(ui, studio, actions);
            let tip = "How sharp the brush's edge is. A soft brush covers what it goes over often.";
            percent(ui, "Hardness", tip, tools.hardness, |value| {
                actions.push(Action::BrushHardness(value));
            });
            let tip = "How calmly the brush follows a trembling hand.";
            percent(ui, "Smoothing", tip, tools.smoothing, |value| {
                actions.push(Action::BrushSmoothing(value));
            });
        }
        Tool::Smart => size(ui, studio, actions),
        Tool::Flood => {
            let mut tolerance = tools.tolerance;
            let label = ui.label("Tolerance");
            let field = ui.add(DragValue::new(&mut tolerance).speed(0.5));
            let tip = "How different colours may be that count as one, 0 to 255.";
            if field.labelled_by(label.id).on_hover_text(tip).changed() {
                set(actions, ToolOption::Tolerance(tolerance));
            }
            let mut is_contiguous = tools.is_contiguous;
            let tip = "Takes only what hangs together with the place that is clicked.";
            if ui
                .checkbox(&mut is_contiguous, "Contiguous")
                .on_hover_text(tip)
                .changed()
            {
                set(actions, ToolOption::Contiguous(is_contiguous));
            }
        }
        Tool::Lasso => {
            ui.weak("Draw round the crown");
        }
        Tool::Polygon | Tool::Livewire => {
            if studio.sketch().is_none() {
                ui.weak("Click round the crown");
            }
        }
        Tool::Depth => {
            ui.weak("Drag the outline: outwards is deeper. Double-click adds or removes a handle");
        }
        Tool::Hand => {
            ui.weak("Drag to move, wheel to zoom");
        }
    }
}

/// The brush's size: its diameter, as painting programs have it.
fn size(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let mut diameter = 2.0 * studio.tools.radius_px;
    let label = ui.label("Size");
    let speed = (diameter * 0.01).max(0.1);
    let field = DragValue::new(&mut diameter)
        .speed(speed)
        .range(1.5..=8192.0)
        .max_decimals(1)
        .custom_parser(arithmetic)
        .suffix(" px");
    let tip = "Diameter of the brush in pixels of the picture. [ and ] change it, with Shift by 10; \
               so do Shift and drag, Alt and wheel.";
    if ui
        .add(field)
        .labelled_by(label.id)
        .on_hover_text(tip)
        .changed()
    {
        actions.push(Action::BrushRadius(diameter / 2.0));
    }
}

fn percent(ui: &mut Ui, name: &str, tip: &str, value: f64, changed: impl FnOnce(f64)) {
    let mut percent = 100.0 * value;
    let label = ui.label(name);
    let field = DragValue::new(&mut percent)
        .speed(0.5)
        .range(0.0..=100.0)
        .max_decimals(0)
        .custom_parser(arithmetic)
        .suffix(" %");
    if ui
        .add(field)
        .labelled_by(label.id)
        .on_hover_text(tip)
        .changed()
    {
        changed(percent / 100.0);
    }
}

fn set(actions: &mut Vec<Action>, option: ToolOption) {
    actions.push(Action::Mask(MaskAction::Set(option)));
}

/// What can be done with a selection in progress.
fn of_sketch(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let (verb, can) = match studio.sketch() {
        Some(Sketch::Smart(smart)) => ("Take", smart.strokes > 0),
        Some(Sketch::Line(line)) if line.kind == LineKind::Free => return,
        Some(Sketch::Line(line)) => ("Close", line.points.len() > 2),
        Some(Sketch::Wire(wire)) => ("Close", wire.anchors().len() > 1),
        None => {
            if studio.tools.tool == Tool::Smart {
                ui.weak("Draw a stroke inside the crown");
            }
            return;
        }
    };
    let button = Button::new(verb).shortcut_text("Enter");
    if ui.add_enabled(can, button).clicked() {
        actions.push(Action::Mask(MaskAction::Close));
    }
    if ui
        .add(Button::new("Give Up").shortcut_text("Esc"))
        .clicked()
    {
        actions.push(Action::AbortGesture);
    }
}

fn refine(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let tools = &studio.tools;
    ui.horizontal(|ui| {
        show_fields(ui);
        let mut amount = tools.amount_px;
        let label = ui.label("Amount");
        let field = DragValue::new(&mut amount)
            .speed(0.1)
            .range(1..=128)
            .suffix(" px");
        let tip = "How far Grow, Shrink and Smooth go.";
        if ui
            .add(field)
            .labelled_by(label.id)
            .on_hover_text(tip)
            .changed()
        {
            set(actions, ToolOption::Amount(amount));
        }
    });
    for command in [MaskCommand::Grow, MaskCommand::Shrink, MaskCommand::Smooth] {
        item(ui, studio, Command::Mask(command), actions);
    }
    ui.separator();
    ui.horizontal(|ui| {
        show_fields(ui);
        let mut pixels = tools.speck_px;
        let label = ui.label("Up to");
        let speed = (pixels as f64 * 0.02).max(1.0);
        let field = DragValue::new(&mut pixels)
            .speed(speed)
            .range(1..=100_000_000_u64)
            .suffix(" px");
        let tip = "The largest hole and the largest speck, in pixels of area.";
        if ui
            .add(field)
            .labelled_by(label.id)
            .on_hover_text(tip)
            .changed()
        {
            set(actions, ToolOption::Speck(pixels));
        }
    });
    for command in [MaskCommand::FillHoles, MaskCommand::RemoveSpecks] {
        item(ui, studio, Command::Mask(command), actions);
    }
    ui.separator();
    for command in [
        Command::InvertMask,
        Command::Mask(MaskCommand::Flip),
        Command::Mask(MaskCommand::MirrorLeft),
        Command::Mask(MaskCommand::MirrorRight),
        Command::Mask(MaskCommand::Propose),
        Command::ClearMask,
    ] {
        item(ui, studio, command, actions);
    }
}

/// Fields in a menu look like fields, not like its items.
fn show_fields(ui: &mut Ui) {
    let fill = tokens(ui).button;
    ui.visuals_mut().widgets.inactive.weak_bg_fill = fill;
}

fn item(ui: &mut Ui, studio: &Studio, command: Command, actions: &mut Vec<Action>) {
    let row = command.row();
    let keys = ui.ctx().format_shortcut(&row.shortcut);
    let button = Button::new(row.label).shortcut_text(keys);
    let response = ui.add_enabled(studio.can(command), button);
    if response.on_hover_text(row.help).clicked() {
        actions.push(Action::Do(command));
    }
}

fn show(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let overlays = [
        (Overlay::Tint, Command::ToggleMask),
        (Overlay::Silhouette, Command::Overlay(Overlay::Silhouette)),
        (Overlay::Contour, Command::Overlay(Overlay::Contour)),
        (Overlay::Pins, Command::Overlay(Overlay::Pins)),
        (Overlay::Baseline, Command::Overlay(Overlay::Baseline)),
        (Overlay::Heat, Command::Overlay(Overlay::Heat)),
    ];
    for (overlay, command) in overlays {
        let Some(row) = TABLE.iter().find(|row| row.command == command) else {
            continue;
        };
        let mut is_on = studio.mask_work.overlays.has(overlay);
        let keys = ui.ctx().format_shortcut(&row.shortcut);
        let text = format!("{} ({keys})", row.label);
        if ui
            .checkbox(&mut is_on, text)
            .on_hover_text(row.help)
            .changed()
        {
            actions.push(Action::Do(command));
        }
    }
}
