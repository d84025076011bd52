//! How the crown is made.

use super::super::action::{Action, Gesture};
use super::super::k_field::{self, KField, MOST_K};
use super::super::live::ShownCrown;
use super::super::studio::Studio;
use super::super::theme::{GAP, OVER_PHOTO, TIGHT, tokens};
use super::canvas::swatch;
use super::field::{Field, dice, section};
use super::leaves::leaf_row;
use super::outline::Outline;
use super::profile::ProfileEditor;
use super::{empty, field};
use crate::base::Seed;
use crate::crown::{PRESETS, ReliefSettings};
use crate::document::{CrownSettings, Edit, PhotoId, Tangent};
use egui::{Rect, Sense, Ui, pos2, vec2};

/// Sides of cubemaps to choose from.
const SIZES: [(u32, &str); 4] = [
    (128, "128 – draft"),
    (256, "256"),
    (512, "512 – fine"),
    (1024, "1024 – slow"),
];

/// Seeds are this small so that people can tell them each other.
const SEEDS: u64 = 1_000_000;

/// The panel.
#[derive(Default)]
pub(super) struct Crown {
    /// The photograph whose formula is being typed, and the text.
    formula: Option<(PhotoId, String)>,
    profile: ProfileEditor,
    keeps_seed: bool,
}

/// A change of the settings.
pub(super) struct Change {
    pub(super) label: &'static str,
    pub(super) gesture: Gesture,
}

impl Crown {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let content = studio.document().state().content();
        let shown = studio.shown();
        let Some((photo, before)) = shown.and_then(|id| Some((id, content.crowns.get(&id)?)))
        else {
            empty(ui, "No picture", "Add a photograph of a tree first.");
            return;
        };
        let mut settings = before.clone();
        let mut change = None;
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
                    self.shape(ui, studio, photo, &mut settings, &mut change);
                    relief(ui, &mut settings, &mut change);
                    let name = content.photos.get(&photo).map_or("", |photo| &photo.name);
                    self.foliage(ui, name, &mut settings, &mut change);
                    sub_crowns(ui, studio, photo, &mut settings, &mut change);
                });
            });
        let is_idle = |change: &Change| change.gesture == Gesture::Going && settings == *before;
        if let Some(Change { label, gesture }) = change.filter(|change| !is_idle(change)) {
            actions.push(Action::Edit {
                label,
                edit: Edit::SetCrown(photo, Box::new(settings)),
                gesture,
            });
        }
    }

    /// k, by whatever means.
    fn shape(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        photo: PhotoId,
        settings: &mut CrownSettings,
        change: &mut Option<Change>,
    ) {
        section(ui, "Depth (k)");
        let constant = constant_of(&settings.k);
        let kinds = [
            (
                "Auto",
                "As deep as it is wide.",
                settings.k == Tangent::Automatic,
            ),
            (
                "Fixed",
                "One k all along the silhouette: 0 is flat, about 2 is round.",
                constant.is_some(),
            ),
            (
                "Formula",
                "k from i and j: 0 to 1 from the left and from the top of the crown. For instance 1+3*j.",
                matches!(&settings.k, Tangent::Expression(_)) && constant.is_none(),
            ),
            (
                "Curve",
                "A curve along the silhouette, with handles to drag.",
                matches!(&settings.k, Tangent::Profile(_)),
            ),
        ];
        let mut chosen = None;
        ui.horizontal_wrapped(|ui| {
            ui.spacing_mut().item_spacing.x = TIGHT;
            for (index, (title, help, is_on)) in kinds.into_iter().enumerate() {
                if ui
                    .selectable_label(is_on, title)
                    .on_hover_text(help)
                    .clicked()
                    && !is_on
                {
                    chosen = Some(index);
                }
            }
        });
        if let Some(index) = chosen {
            settings.k = chosen_k(index, studio, photo, &settings.k);
            self.formula = None;
            *change = Some(whole("Choose k"));
        }
        match &mut settings.k {
            Tangent::Automatic => {
                let found = shown_of(studio, photo).and_then(|shown| shown.k);
                ui.weak(match found {
                    Some([k, _]) => format!("As deep as it is wide: k is {k:.2}."),
                    None => "The crown is as deep as it is wide.".to_owned(),
                });
            }
            Tangent::Expression(_) => match constant {
                Some(k) => constant_field(ui, k, settings, change),
                None => self.formula_field(ui, studio, photo, settings, change),
            },
            Tangent::Profile(points) => {
                let shown = shown_of(studio, photo);
                let silhouette = shown.map(|shown| &*shown.silhouette);
                if let Some(gesture) = self.profile.show(ui, points, silhouette) {
                    *change = Some(Change {
                        label: "Shape k",
                        gesture,
                    });
                }
            }
        }
        presets(ui, settings, change);
    }

    fn formula_field(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        photo: PhotoId,
        settings: &mut CrownSettings,
        change: &mut Option<Change>,
    ) {
        let Tangent::Expression(kept) = &mut settings.k else {
            return;
        };
        let is_ours = self.formula.as_ref().is_some_and(|(of, _)| *of == photo);
        if !is_ours {
            self.formula = Some((photo, kept.clone()));
        }
        let Some((_, text)) = &mut self.formula else {
            return;
        };
        let label = ui.label("k(i, j) =");
        let response = ui
            .add(
                egui::TextEdit::singleline(text)
                    .font(egui::TextStyle::Monospace)
                    .desired_width(f32::INFINITY),
            )
            .labelled_by(label.id)
            .on_hover_text(
                "i and j go from 0 to 1; sin, cos, abs, sqrt, min, max, pi and ^ are known.",
            );
        if response.changed() && *text != *kept {
            kept.clone_from(text);
            *change = Some(Change {
                label: "Formula of k",
                gesture: Gesture::Going,
            });
        } else if response.lost_focus() {
            *change = Some(Change {
                label: "Formula of k",
                gesture: Gesture::Ended,
            });
        }
        if !response.has_focus() && *text != *kept {
            // Undone, or a preset.
            text.clone_from(kept);
        }
        let field = KField::of(&settings.k, None);
        if let Some(field @ KField::Formula(_)) = &field {
            formula_map(ui, shown_of(studio, photo), field);
        }
        if let Some(trouble) = &studio.live.trouble {
            ui.add(egui::Label::new(egui::RichText::new(trouble).color(tokens(ui).error)).wrap());
        }
    }

    /// What the leaves are and where.
    fn foliage(
        &mut self,
        ui: &mut Ui,
        photo: &str,
        settings: &mut CrownSettings,
        change: &mut Option<Change>,
    ) {
        section(ui, "Foliage");
        leaf_row(ui, photo, settings, change);
        let front = ui.checkbox(&mut settings.photo_front, "Photograph on the front");
        if front
            .on_hover_text(
                "Keeps the photograph where it was taken from; the rest grows out of it.",
            )
            .changed()
        {
            *change = Some(whole("Photograph on the Front"));
        }
        let mut copies = f64::from(settings.copies);
        let gesture = Field::new("Turned copies", 1.0..=8.0, 1.0)
            .whole()
            .help("Merges copies turned about the trunk, for crowns that would be flat from the side.")
            .show(ui, &mut copies);
        if let Some(gesture) = gesture {
            settings.copies = copies.round().clamp(1.0, 16.0) as u32;
            *change = Some(Change {
                label: "Copies",
                gesture,
            });
        }
        ui.add_space(TIGHT);
        ui.horizontal(|ui| {
            let label = ui.label("Seed");
            let response = ui
                .add(
                    egui::DragValue::new(&mut settings.seed)
                        .range(0..=u64::MAX)
                        .update_while_editing(false),
                )
                .labelled_by(label.id)
                .on_hover_text("The same seed gives the same leaves.");
            if let Some(gesture) = field::gesture_of(&response) {
                *change = Some(Change {
                    label: "Seed",
                    gesture,
                });
            }
            if ui
                .add_enabled_ui(!self.keeps_seed, |ui| dice(ui, "Roll the Seed"))
                .inner
                .clicked()
            {
                settings.seed = Seed(settings.seed).derive("roll", 0).0 % SEEDS;
                *change = Some(whole("Roll the Seed"));
            }
            ui.checkbox(&mut self.keeps_seed, "Lock")
                .on_hover_text("Keeps the seed from being rolled.");
        });
        ui.horizontal(|ui| {
            let title = SIZES.iter().find(|(size, _)| *size == settings.size);
            let title = title.map_or(settings.size.to_string(), |(_, title)| (*title).to_owned());
            let label = ui.label("Texels");
            let combo = egui::ComboBox::from_id_salt("size").selected_text(title);
            let response = combo.show_ui(ui, |ui| {
                for (size, title) in SIZES {
                    if ui
                        .selectable_value(&mut settings.size, size, title)
                        .changed()
                    {
                        *change = Some(whole("Size of the Crown"));
                    }
                }
            });
            response
                .response
                .labelled_by(label.id)
                .on_hover_text("Texels along a face of the crown's cubemaps.");
        });
    }
}

/// What a formula gives all over the crown's bounds, with the crown's outline.
fn formula_map(ui: &mut Ui, shown: Option<&ShownCrown>, field: &KField) {
    let silhouette = shown.map(|shown| &*shown.silhouette);
    let silhouette = silhouette.filter(|silhouette| !silhouette.points.is_empty());
    let aspect = silhouette.map_or(1.0, |silhouette| {
        let size = silhouette.bounds[1] - silhouette.bounds[0];
        (size.x / size.y).clamp(0.2, 5.0) as f32
    });
    let room = vec2(ui.available_width(), 120.0);
    let size = vec2(room.x.min(room.y * aspect), room.y.min(room.x / aspect));
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response
        .widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Map of the formula"));
    swatch(ui.painter(), rect, field);
    if let Some(outline) = silhouette.and_then(|silhouette| Outline::within(silhouette, rect)) {
        let line: Vec<_> = outline.points().iter().map(|(_, at)| *at).collect();
        let stroke = egui::Stroke::new(1.2, OVER_PHOTO);
        ui.painter().add(egui::Shape::closed_line(line, stroke));
    }
    response.on_hover_text(
        "k over the crown: dark blue is flat, yellow steep. Shift+W shows it on the photograph.",
    );
}

/// The crown that is shown, if it is that of `photo`.
fn shown_of(studio: &Studio, photo: PhotoId) -> Option<&ShownCrown> {
    let shown = studio.live.shown.as_deref();
    shown.filter(|shown| shown.photo == photo)
}

/// The k of another kind that is nearest to what it was.
fn chosen_k(kind: usize, studio: &Studio, photo: PhotoId, before: &Tangent) -> Tangent {
    let shown = shown_of(studio, photo);
    let automatic = shown.and_then(|shown| shown.k).map(|[k, _]| k);
    let k = constant_of(before).or(automatic).unwrap_or(2.0);
    let k = (k * 100.0).round() / 100.0;
    match kind {
        0 => Tangent::Automatic,
        1 => Tangent::Expression(format!("{k}")),
        2 => Tangent::Expression(format!("{k}*(0.75+0.5*j)")),
        _ => {
            let field = KField::of(before, automatic).unwrap_or(KField::Constant(k));
            let silhouette = shown.map(|shown| &*shown.silhouette);
            let handles = silhouette.map(|silhouette| field.handles(silhouette));
            Tangent::Profile(
                handles.unwrap_or_else(|| [0.0, 0.25, 0.5, 0.75].map(|t| (t, k)).to_vec()),
            )
        }
    }
}

fn whole(label: &'static str) -> Change {
    Change {
        label,
        gesture: Gesture::Whole,
    }
}

/// The number that `k` is, if it is a number and nothing else.
fn constant_of(k: &Tangent) -> Option<f64> {
    match k {
        Tangent::Expression(text) => k_field::constant_of(text),
        _ => None,
    }
}

fn constant_field(ui: &mut Ui, k: f64, settings: &mut CrownSettings, change: &mut Option<Change>) {
    let mut k = k;
    let gesture = Field::new("k", 0.0..=MOST_K, 2.0)
        .help("How steeply the crown leaves its silhouette: 0 is flat, about 2 is round.")
        .show(ui, &mut k);
    if let Some(gesture) = gesture {
        let k = (k.clamp(0.0, 1000.0) * 1000.0).round() / 1000.0;
        settings.k = Tangent::Expression(format!("{k}"));
        *change = Some(Change {
            label: "Change k",
            gesture,
        });
    }
}

fn presets(ui: &mut Ui, settings: &mut CrownSettings, change: &mut Option<Change>) {
    ui.menu_button("Presets", |ui| {
        for preset in PRESETS {
            let mut name = preset.name.to_owned();
            name[..1].make_ascii_uppercase();
            let button = egui::Button::new(name).shortcut_text(preset.formula);
            if ui.add(button).on_hover_text(preset.about).clicked() {
                settings.k = Tangent::Expression(preset.formula.to_owned());
                *change = Some(whole("Preset of k"));
                ui.close();
            }
        }
    })
    .response
    .on_hover_text("Shapes to begin with.");
}

fn relief(ui: &mut Ui, settings: &mut CrownSettings, change: &mut Option<Change>) {
    let usual = CrownSettings::default();
    section(ui, "Relief");
    let mut told = |gesture: Option<Gesture>, label| {
        if let Some(gesture) = gesture {
            *change = Some(Change { label, gesture });
        }
    };
    let rho = Field::new("Strength (ρ)", 0.0..=1.0, usual.rho)
        .limits(0.0..=1.5)
        .help("How far light and dark move the surface, as a share of the radius.");
    told(rho.show(ui, &mut settings.rho), "Strength of the Relief");
    let of = &mut settings.relief;
    told(weights(ui, of), "Weights of the Relief");
    let coarsest = Field::new("Branch size", 0.01..=0.15, usual.relief.coarsest)
        .limits(0.0..=0.25)
        .help("Width of the largest bulges, as a share of the crown's.");
    told(coarsest.show(ui, &mut of.coarsest), "Branch Size");
    let even = Field::new("Light removal", 0.0..=1.0, usual.relief.even_light)
        .limits(0.0..=1.0)
        .help("How much of the sun on one side is taken off before light becomes relief.");
    told(even.show(ui, &mut of.even_light), "Light Removal");
    let steepest = Field::new("Steepest wall", 0.2..=4.0, usual.relief.steepest)
        .limits(0.05..=20.0)
        .help("How steep the walls of gaps may be; on steep walls leaves are drawn out.");
    told(steepest.show(ui, &mut of.steepest), "Steepest Wall");
}

/// The weights of the relief's levels, to be dragged: from leaves on the left to branches.
fn weights(ui: &mut Ui, relief: &mut ReliefSettings) -> Option<Gesture> {
    ui.horizontal(|ui| {
        let label = ui.add(egui::Label::new("Leaves against branches").sense(Sense::click()));
        if label
            .on_hover_text(
                "Drag the points: how far leaves rise against whole branches. Double-click resets.",
            )
            .double_clicked()
        {
            relief.falloff = ReliefSettings::default().falloff;
            return Some(Gesture::Whole);
        }
        None
    })
    .inner
    .or_else(|| {
        let (rect, response) =
            ui.allocate_exact_size(vec2(ui.available_width(), 64.0), Sense::click_and_drag());
        let name = "Weights of leaves and branches";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
        let inner = rect.shrink2(vec2(10.0, 8.0));
        let levels = relief.levels.max(2);
        let at = |level: u32, falloff: f64| {
            let weight = falloff.powi((levels - 1 - level) as i32) as f32;
            let x = inner.left() + inner.width() * level as f32 / (levels - 1) as f32;
            pos2(x, inner.bottom() - weight * inner.height())
        };
        let gesture = if response.double_clicked() {
            relief.falloff = ReliefSettings::default().falloff;
            Some(Gesture::Whole)
        } else {
            field::gesture_of(&response)
        };
        if response.dragged()
            && let Some(pointer) = response.interact_pointer_pos()
        {
            let share = (pointer.x - inner.left()) / inner.width() * (levels - 1) as f32;
            let level = (share.round().max(0.0) as u32).min(levels - 2);
            let weight = f64::from((inner.bottom() - pointer.y) / inner.height());
            let root = 1.0 / f64::from(levels - 1 - level);
            relief.falloff = libm::pow(weight.clamp(0.0, 1.0), root).clamp(0.0, 1.0);
        }
        draw_weights(
            ui,
            rect,
            (0..levels).map(|level| at(level, relief.falloff)).collect(),
        );
        gesture
    })
}

fn draw_weights(ui: &Ui, rect: Rect, points: Vec<egui::Pos2>) {
    let tokens = tokens(ui);
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, tokens.sunken);
    let base = rect.bottom() - 8.0;
    for point in &points {
        painter.line_segment([pos2(point.x, base), *point], (2.0, tokens.line));
    }
    painter.line(points.clone(), (1.5, tokens.accent));
    for point in points {
        painter.circle(point, 4.0, tokens.accent, (1.0, tokens.sunken));
    }
    let font = egui::TextStyle::Small.resolve(ui.style());
    let top = rect.top() + 3.0;
    let left = pos2(rect.left() + 6.0, top);
    painter.text(left, egui::Align2::LEFT_TOP, "leaves", font, tokens.weak);
}

/// Depths of the sub-crowns that are painted.
fn sub_crowns(
    ui: &mut Ui,
    studio: &Studio,
    photo: PhotoId,
    settings: &mut CrownSettings,
    change: &mut Option<Change>,
) {
    let shown = studio
        .live
        .shown
        .as_ref()
        .filter(|shown| shown.photo == photo);
    let labels = shown.map(|shown| &*shown.sub_crowns).unwrap_or_default();
    if labels.is_empty() {
        return;
    }
    section(ui, "Sub-crowns");
    for &label in labels {
        let mut depth = settings
            .sub_crown_depths
            .get(&label)
            .copied()
            .unwrap_or(0.0);
        let name = format!("Depth of {}", label - 2);
        let gesture = Field::new(&name, -0.5..=0.5, 0.0)
            .limits(-2.0..=2.0)
            .help("How far this sub-crown stands towards the viewer, in widths of the crown.")
            .show(ui, &mut depth);
        if let Some(gesture) = gesture {
            settings.sub_crown_depths.insert(label, depth);
            *change = Some(Change {
                label: "Depth of a Sub-crown",
                gesture,
            });
        }
    }
}
