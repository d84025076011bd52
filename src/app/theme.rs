//! How the studio looks: a few tokens, and egui's styles made of them.
//!
//! Surfaces are neutral greys, so that they do not tint the eye that judges a tree's colours; one
//! accent, the green of young leaves, marks what is chosen. Distances are multiples of 4 points.

use egui::style::{Selection, WidgetVisuals, Widgets};
use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Stroke, TextStyle, Theme, Visuals};

/// Half of the usual distance, points.
pub(super) const TIGHT: f32 = 4.0;

/// The usual distance between things, points.
pub(super) const GAP: f32 = 8.0;

/// Side of a thumbnail, points.
pub(super) const THUMBNAIL: f32 = 72.0;

const RADIUS: u8 = 4;

/// The colours of one theme.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tokens {
    /// Behind everything.
    pub(super) ground: Color32,
    /// Panels.
    pub(super) panel: Color32,
    /// Menus and dialogs, above panels.
    pub(super) raised: Color32,
    /// Fields one writes in, and what lies under pictures.
    pub(super) sunken: Color32,
    /// Buttons at rest.
    pub(super) button: Color32,
    /// Buttons under the pointer.
    pub(super) hovered: Color32,
    /// Lines between things.
    pub(super) line: Color32,
    /// Text.
    pub(super) text: Color32,
    /// Text that explains.
    pub(super) weak: Color32,
    /// Text on the accent, headings.
    pub(super) strong: Color32,
    /// What is chosen.
    pub(super) accent: Color32,
    /// Behind what is chosen.
    pub(super) chosen: Color32,
    /// Something may be lost.
    pub(super) warning: Color32,
    /// Something failed.
    pub(super) error: Color32,
    /// Red, green and blue of plots.
    pub(super) channels: [Color32; 3],
}

impl Tokens {
    /// Behind a picture that can be chosen.
    pub(super) fn stamp(&self, is_chosen: bool, is_hovered: bool) -> Color32 {
        match (is_chosen, is_hovered) {
            (true, _) => self.chosen,
            (false, true) => self.hovered,
            (false, false) => self.sunken,
        }
    }
}

/// The colours of labels 1 to 9, over any photograph: told apart also by those who see red and green
/// alike.
const LABELS: [Color32; 9] = [
    Color32::from_rgb(112, 214, 84),
    Color32::from_rgb(236, 146, 58),
    Color32::from_rgb(92, 160, 250),
    Color32::from_rgb(232, 104, 196),
    Color32::from_rgb(248, 222, 84),
    Color32::from_rgb(104, 222, 222),
    Color32::from_rgb(172, 132, 250),
    Color32::from_rgb(250, 124, 112),
    Color32::from_rgb(206, 196, 170),
];

/// The colour of a label; `None` for background.
pub(super) fn label_color(label: u8) -> Option<Color32> {
    let index = usize::from(label).checked_sub(1)?;
    Some(LABELS[index.min(LABELS.len() - 1)])
}

/// What stands on a label's colour.
pub(super) const ON_LABEL: Color32 = Color32::from_rgb(16, 18, 20);

/// Lines over photographs: light, with a dark edge, so that they show on any of them.
pub(super) const OVER_PHOTO: Color32 = Color32::from_rgb(255, 255, 255);

/// The edge of those lines.
pub(super) const UNDER_LINE: Color32 = Color32::from_black_alpha(150);

/// What smart select was told is inside, and what it found.
pub(super) const INSIDE: Color32 = Color32::from_rgb(90, 190, 255);

/// What smart select was told is outside.
pub(super) const OUTSIDE: Color32 = Color32::from_rgb(255, 96, 96);

/// Pins and baseline.
pub(super) const PIN: Color32 = Color32::from_rgb(255, 214, 64);

/// Colours of a value from 0 to 1, dark blue to yellow: even steps to the eye, and readable without
/// seeing red from green (after *viridis* by S. van der Walt and N. Smith).
const HEAT: [[f32; 3]; 6] = [
    [68.0, 1.0, 84.0],
    [65.0, 68.0, 135.0],
    [42.0, 120.0, 142.0],
    [34.0, 168.0, 132.0],
    [122.0, 209.0, 81.0],
    [253.0, 231.0, 37.0],
];

/// The colour of `share`; what is no number is grey.
pub(super) fn heat(share: f32) -> Color32 {
    if share.is_nan() {
        return Color32::GRAY;
    }
    let at = share.clamp(0.0, 1.0) * (HEAT.len() - 1) as f32;
    let first = (at as usize).min(HEAT.len() - 2);
    let part = at - first as f32;
    let [r, g, b] = [0, 1, 2].map(|c| {
        let (from, to) = (HEAT[first][c], HEAT[first + 1][c]);
        (from + (to - from) * part).round() as u8
    });
    Color32::from_rgb(r, g, b)
}

const DARK: Tokens = Tokens {
    ground: Color32::from_rgb(24, 25, 26),
    panel: Color32::from_rgb(36, 37, 39),
    raised: Color32::from_rgb(46, 47, 50),
    sunken: Color32::from_rgb(26, 27, 28),
    button: Color32::from_rgb(58, 60, 63),
    hovered: Color32::from_rgb(72, 74, 78),
    line: Color32::from_rgb(55, 57, 60),
    text: Color32::from_rgb(214, 216, 218),
    weak: Color32::from_rgb(158, 162, 166),
    strong: Color32::from_rgb(245, 246, 247),
    accent: Color32::from_rgb(142, 196, 106),
    chosen: Color32::from_rgb(62, 94, 46),
    warning: Color32::from_rgb(240, 190, 90),
    error: Color32::from_rgb(244, 124, 110),
    channels: [
        Color32::from_rgb(232, 108, 100),
        Color32::from_rgb(116, 190, 108),
        Color32::from_rgb(108, 152, 240),
    ],
};

const LIGHT: Tokens = Tokens {
    ground: Color32::from_rgb(206, 208, 210),
    panel: Color32::from_rgb(240, 241, 242),
    raised: Color32::from_rgb(250, 250, 251),
    sunken: Color32::from_rgb(226, 228, 230),
    button: Color32::from_rgb(216, 219, 222),
    hovered: Color32::from_rgb(200, 204, 208),
    line: Color32::from_rgb(204, 207, 210),
    text: Color32::from_rgb(44, 47, 50),
    weak: Color32::from_rgb(94, 99, 104),
    strong: Color32::from_rgb(16, 18, 20),
    accent: Color32::from_rgb(52, 112, 34),
    chosen: Color32::from_rgb(190, 220, 170),
    warning: Color32::from_rgb(128, 78, 0),
    error: Color32::from_rgb(176, 40, 28),
    channels: [
        Color32::from_rgb(190, 50, 40),
        Color32::from_rgb(40, 124, 40),
        Color32::from_rgb(40, 84, 190),
    ],
};

/// The tokens of the theme that `ui` is drawn in.
pub(super) fn tokens(ui: &egui::Ui) -> &'static Tokens {
    if ui.visuals().dark_mode {
        &DARK
    } else {
        &LIGHT
    }
}

/// A dialog over the window, with room around what it holds.
pub(super) fn dialog(ctx: &egui::Context, name: &str) -> egui::Modal {
    let frame = egui::Frame::popup(&ctx.global_style()).inner_margin(Margin::same(16));
    egui::Modal::new(egui::Id::unique(name)).frame(frame)
}

/// Gives both themes to `ctx`.
pub(super) fn install(ctx: &egui::Context) {
    for (theme, tokens) in [(Theme::Dark, &DARK), (Theme::Light, &LIGHT)] {
        ctx.style_mut_of(theme, |style| {
            style.visuals = visuals(tokens, theme == Theme::Dark);
            style.spacing.item_spacing = egui::vec2(GAP, TIGHT + 2.0);
            style.spacing.button_padding = egui::vec2(GAP, TIGHT);
            style.spacing.interact_size.y = 24.0;
            style.spacing.window_margin = Margin::same(12);
            style.spacing.menu_margin = Margin::same(6);
            style.spacing.slider_width = 140.0;
            style.interaction.tooltip_delay = 0.4;
            style.interaction.selectable_labels = false;
            let font = |size| FontId::new(size, FontFamily::Proportional);
            style.text_styles = [
                (TextStyle::Small, font(11.0)),
                (TextStyle::Body, font(13.0)),
                (TextStyle::Button, font(13.0)),
                (TextStyle::Heading, font(17.0)),
                (
                    TextStyle::Monospace,
                    FontId::new(12.5, FontFamily::Monospace),
                ),
            ]
            .into();
        });
    }
}

fn visuals(tokens: &Tokens, is_dark: bool) -> Visuals {
    let plain = if is_dark {
        Visuals::dark()
    } else {
        Visuals::light()
    };
    let widget = |fill: Color32, text: Color32, border: Color32| WidgetVisuals {
        bg_fill: fill,
        weak_bg_fill: fill,
        bg_stroke: Stroke::new(1.0, border),
        fg_stroke: Stroke::new(1.0, text),
        corner_radius: CornerRadius::same(RADIUS),
        expansion: 0.0,
    };
    Visuals {
        widgets: Widgets {
            noninteractive: widget(tokens.panel, tokens.text, tokens.line),
            inactive: widget(tokens.button, tokens.text, Color32::TRANSPARENT),
            hovered: widget(tokens.hovered, tokens.strong, Color32::TRANSPARENT),
            active: widget(tokens.chosen, tokens.strong, tokens.accent),
            open: widget(tokens.hovered, tokens.strong, Color32::TRANSPARENT),
        },
        selection: Selection {
            bg_fill: tokens.chosen,
            stroke: Stroke::new(1.0, tokens.strong),
        },
        weak_text_color: Some(tokens.weak),
        hyperlink_color: tokens.accent,
        faint_bg_color: tokens.raised,
        extreme_bg_color: tokens.sunken,
        code_bg_color: tokens.sunken,
        warn_fg_color: tokens.warning,
        error_fg_color: tokens.error,
        window_fill: tokens.raised,
        window_stroke: Stroke::new(1.0, tokens.line),
        window_corner_radius: CornerRadius::same(8),
        menu_corner_radius: CornerRadius::same(6),
        panel_fill: tokens.panel,
        slider_trailing_fill: true,
        ..plain
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Contrast of two colours (WCAG 2.2, relative luminance).
    fn contrast(a: Color32, b: Color32) -> f32 {
        let luminance = |color: Color32| {
            let linear = |byte: u8| egui::ecolor::linear_f32_from_gamma_u8(byte);
            0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
        };
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn all_text_can_be_read_on_all_it_stands_on() {
        for tokens in [&DARK, &LIGHT] {
            for ground in [tokens.panel, tokens.raised, tokens.sunken] {
                for text in [
                    tokens.text,
                    tokens.weak,
                    tokens.strong,
                    tokens.warning,
                    tokens.error,
                ] {
                    assert!(contrast(text, ground) >= 4.5, "{text:?} on {ground:?}");
                }
            }
            for ground in [tokens.button, tokens.hovered, tokens.chosen] {
                assert!(contrast(tokens.strong, ground) >= 4.5, "{ground:?}");
            }
        }
    }
}
