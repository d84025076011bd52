//! The dialogs that write trees: a batch of pictures, or an export for an engine.

use super::act_vary::VaryAction;
use super::action::Action;
use super::batch_jobs::{BatchSettings, ExportChoice, Which};
use super::commands::Command;
use super::studio::Studio;
use super::theme::{GAP, TIGHT};
use crate::batch::{ExportMap, MapName, TextureForm};
use crate::export::Preset;
use egui::{Context, DragValue, Ui, vec2};
use std::path::PathBuf;

/// Most trees that a batch is asked for.
const MOST_TREES: u32 = 100_000;

/// Width of the names before fields, points.
const NAMES: f32 = 96.0;

/// The dialog, and what was set in it last.
#[derive(Default)]
pub(super) struct MakeDialog {
    is_open: bool,
    is_export: bool,
    settings: BatchSettings,
    export: ExportChoice,
    folder: String,
    /// What the studio's last answer about folders was.
    chosen: Option<PathBuf>,
}

impl MakeDialog {
    /// Opens the dialog of `command`.
    pub(super) fn open(&mut self, command: Command) {
        self.is_open = true;
        self.is_export = command == Command::ExportTrees;
    }

    /// Draws it while it is open.
    pub(super) fn show(&mut self, ctx: &Context, studio: &Studio, actions: &mut Vec<Action>) {
        if studio.vary.folder != self.chosen {
            self.chosen.clone_from(&studio.vary.folder);
            self.folder = self
                .chosen
                .as_ref()
                .map_or(String::new(), |folder| folder.display().to_string());
        }
        if !self.is_open {
            return;
        }
        let modal = egui::Modal::new(egui::Id::unique("make trees")).show(ctx, |ui| {
            ui.set_width(440.0);
            ui.heading(if self.is_export { "Export" } else { "Make Trees" });
            ui.add_space(TIGHT);
            self.which(ui, studio);
            self.place(ui, actions);
            if self.is_export {
                self.engine(ui);
            } else {
                self.pictures(ui);
            }
            row(ui, "", |ui| {
                ui.checkbox(&mut self.settings.replaces, "Write over what is there")
                    .on_hover_text(
                        "Otherwise files of the same trees stay, and a batch that was stopped goes on.",
                    );
            });
            ui.add_space(2.0 * GAP);
            self.buttons(ui, studio, actions);
        });
        if modal.should_close() {
            self.is_open = false;
        }
    }

    fn which(&mut self, ui: &mut Ui, studio: &Studio) {
        let vary = &studio.vary;
        let mut which = self.settings.which;
        row(ui, "Trees", |ui| {
            let is_drawn = matches!(which, Which::Drawn(_));
            if ui
                .selectable_label(is_drawn, "New")
                .on_hover_text("Drawn with the seed of the gallery, which shows the first of them.")
                .clicked()
            {
                which = Which::Drawn(50);
            }
            let shown = format!("Gallery ({})", vary.gallery.len());
            ui.selectable_value(&mut which, Which::Gallery, shown)
                .on_hover_text("The trees that the gallery shows.");
            let kept = format!("Favourites ({})", vary.favourites.len());
            let has_kept = !vary.favourites.is_empty();
            ui.add_enabled_ui(has_kept, |ui| {
                ui.selectable_value(&mut which, Which::Favourites, kept);
            });
            if let Which::Drawn(count) = &mut which {
                let field = DragValue::new(count).range(1..=MOST_TREES).suffix(" trees");
                let field = ui.add(field);
                let told = *count;
                field.widget_info(|| {
                    egui::WidgetInfo::slider(true, f64::from(told), "Number of trees")
                });
            }
        });
        self.settings.which = which;
    }

    fn place(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        row(ui, "Folder", |ui| {
            let width = ui.available_width() - 84.0;
            let field = egui::TextEdit::singleline(&mut self.folder)
                .desired_width(width)
                .hint_text("/home/me/trees");
            let field = ui.add(field);
            let told = self.folder.clone();
            field
                .widget_info(|| egui::WidgetInfo::text_edit(true, "", &told, "Folder to write to"));
            if ui.button("Choose…").clicked() {
                actions.push(Action::Vary(VaryAction::AskForFolder));
            }
        });
        row(ui, "Size", |ui| {
            let size = &mut self.settings.size;
            for side in [512, 1024, 2048] {
                ui.selectable_value(size, side, format!("{side} px"));
            }
        });
    }

    fn pictures(&mut self, ui: &mut Ui) {
        row(ui, "Maps", |ui| {
            ui.spacing_mut().item_spacing.x = TIGHT;
            for map in [
                MapName::Normal,
                MapName::Depth,
                MapName::Ao,
                MapName::Translucency,
                MapName::Labels,
            ] {
                let mut is_on = self.settings.maps.contains(&map);
                if ui.toggle_value(&mut is_on, map.title()).clicked() {
                    if is_on {
                        self.settings.maps.insert(map);
                    } else {
                        self.settings.maps.remove(&map);
                    }
                }
            }
        });
        row(ui, "", |ui| {
            ui.checkbox(&mut self.settings.has_sheet, "Also draw all on one sheet");
        });
    }

    fn engine(&mut self, ui: &mut Ui) {
        let export = &mut self.export;
        row(ui, "For", |ui| {
            let choice = egui::ComboBox::from_id_salt("preset");
            let choice = choice.selected_text(title(export.preset)).width(160.0);
            let choice = choice.show_ui(ui, |ui| {
                for preset in Preset::ALL {
                    ui.selectable_value(&mut export.preset, preset, title(preset));
                }
            });
            choice.response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "Who will read it")
            });
        });
        row(ui, "Height", |ui| {
            let field = DragValue::new(&mut export.height_m).range(0.01..=1000.0);
            let field = ui.add(field.speed(0.1).suffix(" m"));
            let told = export.height_m;
            field.widget_info(|| egui::WidgetInfo::slider(true, told, "Height of each tree"));
        });
        row(ui, "Maps", |ui| {
            ui.spacing_mut().item_spacing.x = TIGHT;
            for (map, title) in [
                (ExportMap::Normal, "Normal"),
                (ExportMap::Depth, "Depth"),
                (ExportMap::Ao, "Occlusion"),
                (ExportMap::Translucency, "Translucency"),
            ] {
                listed(ui, &mut export.maps, map, title);
            }
        });
        row(ui, "Textures", |ui| {
            ui.add_enabled(false, egui::Button::new("PNG").selected(true));
            listed(ui, &mut export.textures, TextureForm::Dds, "DDS");
            listed(ui, &mut export.textures, TextureForm::Ktx2, "KTX2");
            ui.checkbox(&mut export.has_atlas, "Atlas pages");
        });
        ui.add_space(TIGHT);
        ui.weak(export.preset.readme().lines().next().unwrap_or_default());
    }

    fn buttons(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let folder = self.folder.trim();
            let is_ready = studio.vary.prepared.is_some();
            let can = !folder.is_empty() && is_ready;
            let verb = if self.is_export { "Export" } else { "Make" };
            let button = ui.add_enabled(can, egui::Button::new(verb));
            let why = if is_ready {
                "Choose a folder first."
            } else {
                "The exemplars are being prepared."
            };
            if button.on_disabled_hover_text(why).clicked() {
                let export = self.is_export.then(|| self.export.clone());
                let settings = BatchSettings {
                    folder: PathBuf::from(folder),
                    maps: match export {
                        Some(_) => Default::default(),
                        None => self.settings.maps.clone(),
                    },
                    has_sheet: self.settings.has_sheet && !self.is_export,
                    export,
                    ..self.settings.clone()
                };
                actions.push(Action::Vary(VaryAction::Make(Box::new(settings))));
                self.is_open = false;
            }
            if ui.button("Cancel").clicked() {
                self.is_open = false;
            }
        });
    }
}

/// A line with a name in the first column.
fn row(ui: &mut Ui, name: &str, content: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        let size = vec2(NAMES, ui.spacing().interact_size.y);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_width(NAMES);
            ui.weak(name);
        });
        content(ui);
    });
}

/// A button that puts `value` on a list or takes it off.
fn listed<T: PartialEq>(ui: &mut Ui, list: &mut Vec<T>, value: T, title: &str) {
    let mut is_on = list.contains(&value);
    if ui.toggle_value(&mut is_on, title).clicked() {
        if is_on {
            list.push(value);
        } else {
            list.retain(|listed| *listed != value);
        }
    }
}

fn title(preset: Preset) -> &'static str {
    match preset {
        Preset::Blender => "Blender",
        Preset::Godot => "Godot",
        Preset::Unity => "Unity",
        Preset::Unreal => "Unreal Engine",
        Preset::Web => "Web gallery",
        Preset::FlightGear => "FlightGear",
    }
}

impl MapName {
    fn title(self) -> &'static str {
        match self {
            Self::Labels => "Labels",
            Self::Normal => "Normal",
            Self::Depth => "Depth",
            Self::Ao => "Occlusion",
            Self::Translucency => "Translucency",
        }
    }
}
