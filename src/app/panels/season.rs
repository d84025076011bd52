//! The season of new trees: the mixed tree in all of them, to choose from.

use super::super::action::{Action, Gesture};
use super::super::studio::Studio;
use super::super::theme::{TIGHT, tokens};
use super::changed_settings;
use super::field::Field;
use super::textures::Textures;
use crate::base::Hasher;
use crate::document::VariationSettings;
use crate::variation::{Season, SeasonChoice, SeasonSettings};
use egui::{Align2, Color32, FontId, Rect, Sense, Ui, pos2, vec2};

/// Names in the order of the stamps, and what they mean.
const SEASONS: [(&str, Option<Season>); 5] = [
    ("As It Is", None),
    ("Spring", Some(Season::Spring)),
    ("Summer", Some(Season::Summer)),
    ("Autumn", Some(Season::Autumn)),
    ("Winter", Some(Season::Winter)),
];

/// Height of a stamp's name, points.
const NAME: f32 = 14.0;

/// Draws the choice.
pub(super) fn show(
    ui: &mut Ui,
    studio: &Studio,
    settings: &VariationSettings,
    textures: &mut Textures,
    actions: &mut Vec<Action>,
) {
    let own = settings.season;
    let shown = own.filter(|own| own.settings.amount > 0.0 || own.settings.snow == 0.0);
    let shown = shown.map(|own| own.settings.season);
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = TIGHT;
        let side = ((ui.available_width() - 4.0 * TIGHT) / 5.0).clamp(30.0, 84.0);
        for (index, (name, season)) in SEASONS.into_iter().enumerate() {
            let is_on = shown == season;
            if stamp(ui, studio, (index, name, is_on), side, textures) && !is_on {
                let whole = Some(Gesture::Whole);
                changed_settings(actions, studio, "Season", whole, |s| {
                    s.season = chosen(season, own);
                });
            }
        }
    });
    let Some(own) = own else { return };
    let mut change = |label, gesture, settings: SeasonSettings, evergreen| {
        changed_settings(actions, studio, label, gesture, |s| {
            s.season = Some(SeasonChoice {
                settings,
                evergreen,
            });
        });
    };
    let usual = SeasonSettings::of(own.settings.season);
    let mut amount = own.settings.amount;
    let gesture = Field::new("Extent", 0.0..=1.0, usual.amount)
        .limits(0.0..=1.0)
        .beside()
        .help("How far the season has come: the share of leaves that have turned or fallen.")
        .show(ui, &mut amount);
    let turned = SeasonSettings {
        amount,
        ..own.settings
    };
    change("Extent of the Season", gesture, turned, own.evergreen);
    let mut snow = own.settings.snow;
    let gesture = Field::new("Snow", 0.0..=1.0, 0.0)
        .limits(0.0..=1.0)
        .beside()
        .help("How much of what faces the sky is under snow.")
        .show(ui, &mut snow);
    let snowy = SeasonSettings {
        snow,
        ..own.settings
    };
    change("Snow", gesture, snowy, own.evergreen);
    ui.horizontal(|ui| {
        ui.weak("Evergreens");
        for (evergreen, title, help) in [
            (
                None,
                "By Looks",
                "Conifers, palms and such keep leaves and colours, by their names or looks.",
            ),
            (Some(true), "All", "All trees keep leaves and colours."),
            (Some(false), "None", "All trees turn."),
        ] {
            let is_on = own.evergreen == evergreen;
            let choice = ui.selectable_label(is_on, title);
            if choice.on_hover_text(help).clicked() && !is_on {
                change("Evergreens", Some(Gesture::Whole), own.settings, evergreen);
            }
        }
    });
}

/// What is set when a stamp is clicked: the season as it usually is, with the snow that there was.
fn chosen(season: Option<Season>, before: Option<SeasonChoice>) -> Option<SeasonChoice> {
    let season = season?;
    Some(SeasonChoice {
        settings: SeasonSettings {
            snow: before.map_or(0.0, |before| before.settings.snow),
            ..SeasonSettings::of(season)
        },
        evergreen: before.and_then(|before| before.evergreen),
    })
}

/// The mixed tree in a season. Whether it was clicked.
fn stamp(
    ui: &mut Ui,
    studio: &Studio,
    (index, name, is_on): (usize, &str, bool),
    side: f32,
    textures: &mut Textures,
) -> bool {
    let (rect, response) = ui.allocate_exact_size(vec2(side, side + NAME), Sense::click());
    response.widget_info(|| {
        let name = format!("Season {}", name.to_lowercase());
        egui::WidgetInfo::selected(egui::Role::RadioButton, true, is_on, name)
    });
    let tokens = tokens(ui);
    let fill = tokens.stamp(is_on, response.hovered());
    ui.painter().rect_filled(rect, 5.0, fill);
    if is_on {
        let stroke = egui::Stroke::new(1.0, tokens.accent);
        ui.painter()
            .rect_stroke(rect, 5.0, stroke, egui::StrokeKind::Inside);
    }
    if let Some((key, seasons)) = &studio.vary.seasons {
        let picture = Hasher::new("season").with(key.bytes());
        let key = picture.with(&(index as u64).to_le_bytes()).finish();
        let texture = textures.of(ui.ctx(), key, &seasons[index]);
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        let place = Rect::from_min_size(rect.min, vec2(side, side)).shrink(2.0);
        ui.painter().image(texture.id(), place, uv, Color32::WHITE);
    }
    let at = pos2(rect.center().x, rect.bottom() - 0.5 * NAME);
    let color = if is_on { tokens.strong } else { tokens.weak };
    ui.painter().text(
        at,
        Align2::CENTER_CENTER,
        name,
        FontId::proportional(10.0),
        color,
    );
    response.clicked()
}
