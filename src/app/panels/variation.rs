//! How new trees are made: how many exemplars each mixes, what they resemble, where colours come
//! from; and what leads out of the studio, batches and exports.

use super::super::action::{Action, Gesture};
use super::super::batch_jobs::BATCH;
use super::super::commands::Command;
use super::super::dock::Pane;
use super::super::studio::Studio;
use super::super::theme::{GAP, TIGHT, tokens};
use super::field::Field;
use super::thumbnails::Thumbnails;
use super::{changed_settings, empty};
use crate::base::Hasher;
use crate::document::{Coloring, PhotoId, VariationSettings};
use crate::jobs::Phase;
use crate::variation::Histogram;
use egui::{Color32, Rect, Sense, Ui, pos2, vec2};
use egui_plot::{Line, LineStyle, Plot, PlotPoints};

/// Columns of a plotted histogram.
const BINS: usize = 64;

/// Side of a well that pictures are dropped into, points.
const WELL: f32 = 52.0;

/// The panel.
pub(super) struct Variation {
    thumbnails: Thumbnails,
}

impl Default for Variation {
    fn default() -> Self {
        Self {
            thumbnails: Thumbnails::new(Pane::Variation),
        }
    }
}

impl Variation {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        if studio.vary.prepared.is_none() {
            empty(ui, "Nothing to set", "Add some cut-out trees first.");
            return;
        }
        let settings = &studio.document().state().content().variation;
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            let jobs = studio.jobs.snapshot();
            let batches = jobs.iter().filter(|job| job.topic.kind == BATCH).count();
            // What leads out stays in sight, whatever is scrolled above it.
            let below = 36.0 + batches as f32 * (WELL + 2.0 * GAP);
            let height = (ui.available_height() - below).max(60.0);
            let area = egui::ScrollArea::vertical().auto_shrink(false);
            area.max_height(height).show(ui, |ui| {
                chances(ui, studio, settings, actions);
                self.target(ui, studio, settings, actions);
                heading(ui, "Season");
                let textures = self.thumbnails.textures();
                super::season::show(ui, studio, settings, textures, actions);
                self.colors(ui, studio, settings, actions);
            });
            ui.add_space(TIGHT);
            ui.horizontal(|ui| {
                for command in [Command::MakeTrees, Command::ExportTrees] {
                    let row = command.row();
                    if ui.button(row.label).on_hover_text(row.help).clicked() {
                        actions.push(Action::Do(command));
                    }
                }
            });
            self.batches(ui, studio, actions);
        });
        self.thumbnails.end_frame(ui, actions);
    }

    /// Batches that are being written, with the tree made last.
    fn batches(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        for job in studio.jobs.snapshot() {
            if job.topic.kind != BATCH {
                continue;
            }
            ui.add_space(TIGHT);
            ui.horizontal(|ui| {
                if let Some(tree) = &studio.vary.batch_tree {
                    let (rect, response) = ui.allocate_exact_size(vec2(WELL, WELL), Sense::hover());
                    response.widget_info(|| {
                        egui::WidgetInfo::labeled(egui::Role::Image, true, "The tree made last")
                    });
                    ui.painter().rect_filled(rect, 5.0, tokens(ui).sunken);
                    let key = Hasher::new("batch").with(bytemuck::cast_slice(tree.pixels()));
                    let textures = self.thumbnails.textures();
                    let texture = textures.of(ui.ctx(), key.finish(), tree);
                    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                    ui.painter()
                        .image(texture.id(), rect.shrink(2.0), uv, Color32::WHITE);
                }
                ui.vertical(|ui| {
                    let is_paused = job.phase == Phase::Paused;
                    let share = job.fraction().unwrap_or(0.0) as f32;
                    let stage = if is_paused {
                        "paused"
                    } else {
                        job.stage.unwrap_or("waits")
                    };
                    let text = format!("{stage}: {} of {}", job.done, job.total);
                    ui.add(
                        egui::ProgressBar::new(share)
                            .text(text)
                            .desired_height(18.0),
                    );
                    ui.horizontal(|ui| {
                        let pause = if is_paused { "Go On" } else { "Pause" };
                        if ui.small_button(pause).clicked() {
                            actions.push(Action::PauseJob(job.id, !is_paused));
                        }
                        if ui.small_button("Cancel").clicked() {
                            actions.push(Action::CancelJob(job.id));
                        }
                    });
                });
            });
        }
    }

    fn target(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        settings: &VariationSettings,
        actions: &mut Vec<Action>,
    ) {
        heading(ui, "Target");
        let help = "A picture that all trees are made like. Drop an exemplar here.";
        if let Some(target) = self.well(ui, studio, ("Made like", help), settings.target) {
            let whole = Some(Gesture::Whole);
            changed_settings(actions, studio, "Target", whole, |s| s.target = target);
        }
        let mut strength = settings.strength;
        let usual = VariationSettings::default().strength;
        let gesture = Field::new("Strength", 0.0..=1.0, usual)
            .limits(0.0..=1.0)
            .beside()
            .help("How far trees go from the target, or from what their exemplars mix to, in outline, foliage and hue: at 0 they are that.")
            .show(ui, &mut strength);
        changed_settings(actions, studio, "Strength", gesture, |s| {
            s.strength = strength
        });
    }

    fn colors(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        settings: &VariationSettings,
        actions: &mut Vec<Action>,
    ) {
        heading(ui, "Colours");
        ui.horizontal(|ui| {
            for (coloring, label, help) in [
                (
                    Coloring::One,
                    "Of One",
                    "All colours from one exemplar: the crispest leaves.",
                ),
                (
                    Coloring::Blend,
                    "Blended",
                    "Colours of all exemplars, averaged by their shares.",
                ),
            ] {
                let is_on = settings.coloring == coloring;
                if ui
                    .selectable_label(is_on, label)
                    .on_hover_text(help)
                    .clicked()
                    && !is_on
                {
                    let whole = Some(Gesture::Whole);
                    changed_settings(actions, studio, "Colours", whole, |s| s.coloring = coloring);
                }
            }
        });
        let help =
            "Takes the colours of this picture, for another season say. Drop an exemplar here.";
        if let Some(like) = self.well(ui, studio, ("Colours of", help), settings.like) {
            let whole = Some(Gesture::Whole);
            changed_settings(actions, studio, "Colours Like", whole, |s| s.like = like);
        }
        let draft = studio.vary.draft.as_ref();
        match draft.and_then(|(_, draft)| draft.plain.histograms.as_ref()) {
            Some((before, after)) => histograms(ui, before, after),
            None if settings.like.is_some() => {}
            None => {
                ui.weak("With a picture here the colours before and after are plotted.");
            }
        }
    }

    /// A well with a picture or none; what it is to hold from now on, if that changed.
    fn well(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        (name, help): (&str, &str),
        holds: Option<PhotoId>,
    ) -> Option<Option<PhotoId>> {
        let photos = &studio.document().state().content().photos;
        let prepared = studio.vary.prepared.as_ref()?;
        let mut wanted = None;
        ui.horizontal(|ui| {
            let (rect, response) = ui.allocate_exact_size(vec2(WELL, WELL), Sense::hover());
            let hovers = response.dnd_hover_payload::<PhotoId>().is_some();
            response.widget_info(|| {
                let name = format!("{name}: drop a picture");
                egui::WidgetInfo::labeled(egui::Role::Image, true, name)
            });
            let tokens = tokens(ui);
            let edge = if hovers { tokens.accent } else { tokens.line };
            ui.painter().rect_filled(rect, 5.0, tokens.sunken);
            let stroke = egui::Stroke::new(1.0, edge);
            ui.painter()
                .rect_stroke(rect, 5.0, stroke, egui::StrokeKind::Inside);
            if let Some((&id, photo)) = holds.and_then(|id| photos.get_key_value(&id)) {
                let place = rect.shrink(TIGHT);
                self.thumbnails
                    .draw(ui, studio, (id, photo), place, Color32::WHITE);
            } else {
                let font = egui::FontId::proportional(11.0);
                let align = egui::Align2::CENTER_CENTER;
                ui.painter()
                    .text(rect.center(), align, "drop", font, tokens.weak);
            }
            if let Some(dropped) = response.dnd_release_payload::<PhotoId>() {
                wanted = Some(Some(*dropped));
            }
            response.on_hover_text(help);
            ui.vertical(|ui| {
                let label = ui.label(name);
                let title = |id: Option<PhotoId>| {
                    let photo = id.and_then(|id| photos.get(&id));
                    photo.map_or("None", |photo| photo.name.as_str())
                };
                let choice = egui::ComboBox::from_id_salt(name)
                    .selected_text(title(holds))
                    .truncate();
                let choice = choice.show_ui(ui, |ui| {
                    let usable = prepared.photos.iter().copied().map(Some);
                    for id in std::iter::once(None).chain(usable) {
                        if ui.selectable_label(holds == id, title(id)).clicked() && holds != id {
                            wanted = Some(id);
                        }
                    }
                });
                choice.response.labelled_by(label.id);
            });
        });
        wanted
    }
}

fn heading(ui: &mut Ui, text: &str) {
    ui.add_space(TIGHT);
    ui.label(egui::RichText::new(text).strong());
}

/// How many exemplars a tree mixes, and how unevenly.
fn chances(ui: &mut Ui, studio: &Studio, settings: &VariationSettings, actions: &mut Vec<Action>) {
    heading(ui, "Chance");
    let usual = VariationSettings::default();
    let mut each = f64::from(settings.mix);
    let gesture = Field::new("Exemplars each", 1.0..=6.0, f64::from(usual.mix))
        .limits(1.0..=16.0)
        .whole()
        .beside()
        .help("How many exemplars a tree of the gallery mixes.")
        .show(ui, &mut each);
    changed_settings(actions, studio, "Exemplars Each", gesture, |s| {
        s.mix = each.round().clamp(1.0, 16.0) as u32;
    });
    let is_pair = settings.mix == 2 && settings.target.is_none();
    ui.add_enabled_ui(is_pair, |ui| {
        let (mut low, mut high) = settings.weights;
        let share = |name, usual| {
            Field::new(name, 0.0..=1.0, usual)
                .limits(0.0..=1.0)
                .beside()
                .help("Of two exemplars the first has a share drawn from this range.")
        };
        let gesture = share("Share from", usual.weights.0).show(ui, &mut low);
        changed_settings(actions, studio, "Shares", gesture, |s| {
            s.weights = (low, high.max(low));
        });
        let gesture = share("to", usual.weights.1).show(ui, &mut high);
        changed_settings(actions, studio, "Shares", gesture, |s| {
            s.weights = (low.min(high), high);
        });
    });
}

/// The colours of the mixed tree before and after another picture's were taken.
fn histograms(ui: &mut Ui, before: &Histogram, after: &Histogram) {
    let colors = tokens(ui).channels;
    ui.weak("Colours of the mixed tree: dashed before, solid after.");
    let plot = Plot::new("histograms")
        .height(96.0)
        .show_axes(false)
        .show_grid(false)
        .show_x(false)
        .show_y(false)
        .allow_drag(false)
        .allow_zoom(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false);
    plot.show(ui, |plot| {
        for (histogram, style, when) in [
            (before, LineStyle::dashed_dense(), "before"),
            (after, LineStyle::Solid, "after"),
        ] {
            for ((shares, color), channel) in histogram
                .shares(BINS)
                .into_iter()
                .zip(colors)
                .zip(["Red", "Green", "Blue"])
            {
                let points = (0..)
                    .zip(shares)
                    .map(|(bin, share)| [(f64::from(bin) + 0.5) / BINS as f64, share]);
                let line = Line::new(format!("{channel} {when}"), PlotPoints::from_iter(points));
                plot.line(line.color(color).style(style).width(1.4));
            }
        }
    });
}
