//! New trees: a wall of them that fills while one looks, favourites above, one large on demand.

use super::super::act_vary::VaryAction;
use super::super::action::Action;
use super::super::commands::Command;
use super::super::studio::Studio;
use super::super::theme::{GAP, TIGHT};
use super::super::vary::{Cell, Tile};
use super::super::vary_jobs::{EXEMPLARS, GALLERY};
use super::gallery_breed::{self, Breeding};
use super::gallery_tile::{Kind, TileLook, tile_ui};
use super::textures::Textures;
use super::{changed_settings, empty, gallery_large, gesture_of};
use crate::base::Digest;
use egui::{DragValue, Ui, vec2};

/// Most trees that the wall is asked for by its own field; batches make more.
const MOST_TREES: u32 = 500;

/// The panel.
pub(super) struct Gallery {
    textures: Textures,
    /// Side of a tile, points.
    tile: f32,
    /// The selected trees, in the order in which they were chosen.
    selected: Vec<Digest>,
    breeding: Breeding,
    /// The favourite whose name is being typed.
    renamed: Option<(usize, String)>,
}

impl Default for Gallery {
    fn default() -> Self {
        Self {
            textures: Textures::default(),
            tile: 148.0,
            selected: Vec::new(),
            breeding: Breeding::default(),
            renamed: None,
        }
    }
}

impl Gallery {
    pub(super) fn show(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let vary = &studio.vary;
        if vary.gallery.is_empty() {
            nothing(ui, studio, actions);
            return;
        }
        egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
            if let Some(large) = &vary.large {
                gallery_large::show(ui, studio, large, &mut self.textures, actions);
                return;
            }
            self.selected.retain(|key| vary.cell(*key).is_some());
            self.toolbar(ui, studio, actions);
            ui.add_space(TIGHT);
            let below = if self.selected.is_empty() { 34.0 } else { 64.0 };
            let height = (ui.available_height() - below).max(60.0);
            ui.allocate_ui(vec2(ui.available_width(), height), |ui| {
                ui.set_min_height(height);
                self.wall(ui, studio, actions);
            });
            self.told(ui, studio, actions);
            if !self.selected.is_empty() {
                gallery_breed::show(ui, studio, &self.selected, &mut self.breeding, actions);
            }
        });
        self.textures.sweep(ui);
    }

    fn toolbar(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let settings = &studio.document().state().content().variation;
        ui.horizontal(|ui| {
            let roll = Command::RollTrees.row();
            if ui.button("Roll Again").on_hover_text(roll.help).clicked() {
                actions.push(Action::Do(Command::RollTrees));
            }
            let label = ui.label("Seed");
            let mut seed = settings.seed;
            let field = ui.add(DragValue::new(&mut seed).speed(0.1));
            let field = field.labelled_by(label.id).on_hover_text(
                "The same pictures, settings and seed make the same trees, here and with boscage vary.",
            );
            changed_settings(actions, studio, "Seed", gesture_of(&field), |s| s.seed = seed);
            if ui
                .small_button("Copy")
                .on_hover_text("Copies the seed of the gallery.")
                .clicked()
            {
                ui.copy_text(settings.seed.to_string());
            }
            ui.add_space(GAP);
            let label = ui.label("Trees");
            let mut count = settings.count;
            let field = DragValue::new(&mut count).range(1..=MOST_TREES).speed(0.2);
            let field = ui.add(field).labelled_by(label.id);
            let field = field.on_hover_text("How many trees the gallery shows.");
            changed_settings(actions, studio, "Trees", gesture_of(&field), |s| s.count = count);
            if settings.around.is_some() {
                ui.add_space(GAP);
                let chip = egui::Button::new("Siblings of One Tree").selected(true);
                let help = "The gallery shows trees like the one you chose. Click for all kinds again.";
                if ui.add(chip).on_hover_text(help).clicked() {
                    actions.push(Action::Vary(VaryAction::MoreLike(None)));
                }
            } else {
                gallery_breed::lineage(ui, settings.lineage.len(), actions);
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                // Where there is little room, the progress has it while there is some.
                let is_filling = studio.vary.missing_count() > 0;
                if ui.available_width() > 270.0 || !is_filling {
                    self.thumbnail_size(ui);
                }
                progress(ui, studio, actions);
            });
        });
    }

    fn thumbnail_size(&mut self, ui: &mut Ui) {
        ui.spacing_mut().slider_width = 72.0_f32.min(ui.available_width());
        let slider = egui::Slider::new(&mut self.tile, 96.0..=280.0).show_value(false);
        let slider = ui.add(slider);
        slider.widget_info(|| {
            egui::WidgetInfo::slider(true, f64::from(self.tile), "Size of the thumbnails")
        });
        slider.on_hover_text("Size of the thumbnails.");
    }

    /// Favourites, the parents of a generation, then the gallery; only rows that are seen are drawn.
    fn wall(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let vary = &studio.vary;
        let gap = vec2(GAP, GAP);
        let room = ui.available_width() - 12.0;
        let columns = (((room + gap.x) / (self.tile + gap.x)) as usize).max(1);
        let side = ((room + gap.x) / columns as f32 - gap.x).min(1.25 * self.tile);
        // As high as each other, so that rows can be counted.
        let size = vec2(side, side + 20.0);
        if !vary.favourites.is_empty() {
            ui.weak(format!("Favourites: {}", vary.favourites.len()));
        }
        let groups = [
            (Kind::Favourite, &vary.favourites),
            (Kind::Parent, &vary.parents),
            (Kind::New, &vary.gallery),
        ];
        let rows: Vec<(Kind, usize, &[Cell])> = groups
            .iter()
            .flat_map(|(kind, cells)| {
                let rows = cells.chunks(columns).enumerate();
                rows.map(|(row, cells)| (*kind, row * columns, cells))
            })
            .collect();
        ui.spacing_mut().item_spacing = gap;
        let area = egui::ScrollArea::vertical().auto_shrink(false);
        area.show_rows(ui, size.y, rows.len(), |ui, range| {
            for (kind, first, cells) in &rows[range] {
                ui.horizontal(|ui| {
                    for (index, cell) in (*first..).zip(*cells) {
                        self.tile_ui(ui, studio, (index, cell, *kind), size, actions);
                    }
                });
            }
        });
    }

    fn tile_ui(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        (index, cell, kind): (usize, &Cell, Kind),
        size: egui::Vec2,
        actions: &mut Vec<Action>,
    ) {
        let favourites = &studio.document().state().content().variation.favourites;
        let name = match kind {
            Kind::Favourite => favourites
                .get(index)
                .map_or(String::new(), |kept| kept.name.clone()),
            Kind::Parent | Kind::New => format!("{}", index + 1),
        };
        let look = TileLook {
            cell,
            name: &name,
            kind,
            is_favourite: kind == Kind::Favourite || studio.favourite_index(cell).is_some(),
            is_selected: self.selected.contains(&cell.key),
            is_alike: self.breeding.shown.contains(&cell.key),
            size,
        };
        if tile_ui(ui, studio, &look, &mut self.textures, actions) {
            self.select(ui, studio, cell.key);
        }
    }

    /// A click selects one tree; with Ctrl it takes one more or one less, with Shift all between.
    fn select(&mut self, ui: &Ui, studio: &Studio, key: Digest) {
        let modifiers = ui.input(|input| input.modifiers);
        let all: Vec<Digest> = studio.vary.cells().map(|cell| cell.key).collect();
        let at = |key: &Digest| all.iter().position(|other| other == key);
        self.breeding.shown.clear();
        if modifiers.shift
            && let Some(from) = self.selected.last().and_then(at)
            && let Some(to) = at(&key)
        {
            for key in &all[from.min(to)..=from.max(to)] {
                if !self.selected.contains(key) {
                    self.selected.push(*key);
                }
            }
        } else if modifiers.command {
            match self.selected.iter().position(|known| *known == key) {
                Some(at) => drop(self.selected.remove(at)),
                None => self.selected.push(key),
            }
        } else {
            self.selected = vec![key];
        }
    }

    /// What is known of the selected tree, and what can be done with it.
    fn told(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        ui.add_space(TIGHT);
        ui.horizontal(|ui| {
            let cell = match self.selected[..] {
                [] => {
                    let told = "Click a tree to see what it is made of, with Ctrl or Shift more to breed from. Double-click shows it large.";
                    ui.add(egui::Label::new(egui::RichText::new(told).weak()).truncate());
                    None
                }
                [key] => studio.vary.cell(key),
                _ => {
                    self.breeding.score(ui, studio, &self.selected, actions);
                    None
                }
            };
            let Some(cell) = cell else { return };
            self.name_ui(ui, studio, cell, actions);
            ui.weak("Seed");
            ui.monospace(cell.seed.to_string());
            if ui.small_button("Copy Seed").clicked() {
                ui.copy_text(cell.seed.to_string());
            }
            if ui
                .small_button("More Like This")
                .on_hover_text(
                    "Fills the gallery with siblings: the same exemplars, shares nearby.",
                )
                .clicked()
            {
                actions.push(Action::Vary(VaryAction::MoreLike(Some(cell.key))));
            }
            if ui
                .small_button("Take Mix")
                .on_hover_text("Puts the shares of this tree on the map.")
                .clicked()
            {
                actions.push(Action::Vary(VaryAction::TakeMix(cell.key)));
            }
            if let Some(Ok(tile)) = studio.vary.tile(cell) {
                let text = made_of(studio, tile);
                ui.add(egui::Label::new(egui::RichText::new(&text).weak()).truncate())
                    .on_hover_text(text);
            }
        });
    }

    /// A favourite's name, to be typed over.
    fn name_ui(&mut self, ui: &mut Ui, studio: &Studio, cell: &Cell, actions: &mut Vec<Action>) {
        let Some(index) = studio.favourite_index(cell) else {
            return;
        };
        let kept = &studio.document().state().content().variation.favourites[index];
        let mut name = match &self.renamed {
            Some((at, name)) if *at == index => name.clone(),
            _ => kept.name.clone(),
        };
        let field = egui::TextEdit::singleline(&mut name).desired_width(110.0);
        let field = ui.add(field);
        field.widget_info(|| egui::WidgetInfo::text_edit(true, "", &name, "Name of the favourite"));
        if field.changed() {
            self.renamed = Some((index, name.clone()));
        }
        if field.lost_focus()
            && let Some((at, name)) = self.renamed.take()
            && name != kept.name
            && !name.trim().is_empty()
        {
            actions.push(Action::Vary(VaryAction::Rename(at, name)));
        }
    }
}

/// Why there are no trees.
fn nothing(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let jobs = studio.jobs.snapshot();
    let is_preparing = jobs.iter().any(|job| job.topic.kind == EXEMPLARS);
    match &studio.vary.prepared {
        None if !is_preparing => {
            empty(ui, "No trees yet", "The exemplars were not prepared.");
            ui.vertical_centered(|ui| {
                if ui.button("Prepare Them").clicked() {
                    actions.push(Action::Vary(VaryAction::GoOn));
                }
            });
        }
        None => {
            let above = (ui.available_height() * 0.38).max(0.0);
            ui.add_space(above);
            ui.vertical_centered(|ui| {
                ui.label(egui::RichText::new("Preparing the exemplars").size(15.0));
                ui.add_space(TIGHT);
                ui.weak("Outlines are followed and trunks found; it is done once a picture.");
            });
        }
        Some(_) => empty(
            ui,
            "No trees yet",
            "Add pictures of trees on a transparent background to mix new ones from.",
        ),
    }
}

/// How far the gallery is, and the button to stop it.
fn progress(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let jobs = studio.jobs.snapshot();
    let missing = studio.vary.missing_count();
    let total = studio.vary.cells().count();
    match jobs.iter().find(|job| job.topic.kind == GALLERY) {
        Some(job) if missing > 0 => {
            if ui.small_button("Stop").clicked() {
                actions.push(Action::CancelJob(job.id));
            }
            let share = 1.0 - missing as f32 / total.max(1) as f32;
            let text = format!("{} of {total}", total - missing);
            let width = ui.available_width().min(110.0);
            if width > 40.0 {
                let bar = egui::ProgressBar::new(share).text(text);
                ui.add(bar.desired_width(width));
            }
        }
        None if missing > 0 => {
            if ui.small_button("Go On").clicked() {
                actions.push(Action::Vary(VaryAction::GoOn));
            }
            ui.weak(format!("{} of {total}", total - missing));
        }
        _ => {}
    }
}

/// The exemplars of a tree with their shares of the outline, largest first.
pub(super) fn made_of(studio: &Studio, tile: &Tile) -> String {
    let photos = &studio.document().state().content().photos;
    let prepared = studio.vary.prepared.as_ref();
    let name = |index: usize| {
        let photo = prepared.and_then(|prepared| prepared.photos.get(index));
        photo
            .and_then(|id| photos.get(id))
            .map_or("?", |photo| photo.name.as_str())
    };
    let mut parts = tile.genome.parts.clone();
    parts.sort_by(|a, b| b.contour_weight.total_cmp(&a.contour_weight));
    let shares = parts.iter().map(|part| {
        let share = 100.0 * part.contour_weight;
        format!("{share:.0} % {}", name(part.exemplar))
    });
    let mut told = shares.collect::<Vec<_>>().join(", ");
    if tile
        .genome
        .finish
        .individual
        .is_some_and(|own| own.mirrored)
    {
        told.push_str(", mirrored");
    }
    told
}
