//! The dialogs that write trees: a batch of pictures, or an export for an engine.

use super::act_vary::VaryAction;
use super::action::Action;
use super::batch_jobs::{BatchSettings, ExportChoice, Which};
use super::commands::Command;
use super::panels::leaves::leaf_title;
use super::studio::{Studio, Workspace};
use super::theme::{GAP, TIGHT, dialog};
use crate::batch::{ExportMap, ImpostorName, MapName, ModelTextures, TextureForm};
use crate::branches::leaf_name::LeafName;
use crate::export::Preset;
use crate::pipeline::CrownSettings;
use egui::{Context, DragValue, Ui, vec2};
use std::path::PathBuf;

/// Most trees that a batch is asked for.
const MOST_TREES: u32 = 100_000;

/// What stands for the leaves that each crown has by itself.
const OWN_LEAVES: &str = "Each crown's own";

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
    /// How many crowns there are, and whether one of them is shown.
    crowns: (usize, bool),
    /// Whether it was opened just now.
    is_new: bool,
    /// Whether Enter was pressed in the folder's field.
    is_entered: bool,
}

impl MakeDialog {
    /// Opens the dialog of `command`.
    pub(super) fn open(&mut self, command: Command, studio: &Studio) {
        self.is_open = true;
        self.is_new = true;
        self.is_export = command == Command::ExportTrees;
        let crowns = studio.crowns();
        let is_shown = studio.shown().is_some_and(|id| crowns.contains(&id));
        self.crowns = (crowns.len(), is_shown);
        let which = &mut self.settings.which;
        let wants_crowns = self.is_export && studio.workspace() == Workspace::Crown;
        if wants_crowns && !crowns.is_empty() {
            *which = if is_shown {
                Which::ShownCrown
            } else {
                Which::Crowns
            };
        } else if which.is_of_crowns() {
            *which = BatchSettings::default().which;
        }
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
        let modal = dialog(ctx, "make trees").show(ctx, |ui| {
            ui.set_width(440.0);
            ui.heading(if self.is_export { "Export" } else { "Make Trees" });
            ui.add_space(TIGHT);
            if self.is_export {
                self.crowns(ui);
            }
            self.which(ui, studio, actions);
            self.place(ui, actions);
            match (self.is_export, self.settings.which.is_of_crowns()) {
                (true, true) => {
                    self.engine(ui);
                    self.of_crowns(ui);
                }
                (true, false) => {
                    self.engine(ui);
                    self.of_trees(ui);
                }
                (false, _) => self.pictures(ui),
            }
            if self.is_export {
                self.of_models(ui);
                ui.add_space(TIGHT);
                let readme = self.export.preset.readme();
                ui.add(egui::Label::new(
                    egui::RichText::new(readme.lines().next().unwrap_or_default()).weak(),
                ).wrap());
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

    /// Which crowns, if crowns.
    fn crowns(&mut self, ui: &mut Ui) {
        let (count, is_shown) = self.crowns;
        let which = &mut self.settings.which;
        row(ui, "Crowns", |ui| {
            ui.add_enabled_ui(is_shown, |ui| {
                ui.selectable_value(which, Which::ShownCrown, "This One")
                    .on_hover_text("The crown of the photograph on the canvas.")
                    .on_disabled_hover_text("This photograph has no crown yet: paint its mask.");
            });
            ui.add_enabled_ui(count > 0, |ui| {
                ui.selectable_value(which, Which::Crowns, format!("All ({count})"))
                    .on_hover_text("The crowns of all photographs that have a mask.")
                    .on_disabled_hover_text("No photograph has a crown yet: paint a mask.");
            });
        });
    }

    fn which(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        let vary = &studio.vary;
        let mut which = self.settings.which;
        let name = if self.is_export { "or trees" } else { "Trees" };
        row(ui, name, |ui| {
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
        if self.settings.which != which && studio.workspace() != Workspace::Variations {
            // Trees are drawn from exemplars that only this workspace prepares.
            actions.push(Action::Workspace(Workspace::Variations));
        }
        self.settings.which = which;
    }

    fn place(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        row(ui, "Folder", |ui| {
            let width = ui.available_width() - 84.0;
            let field = egui::TextEdit::singleline(&mut self.folder)
                .desired_width(width)
                .hint_text("/home/me/trees");
            let field = ui.add(field);
            if std::mem::take(&mut self.is_new) {
                field.request_focus();
            }
            let is_entered = ui.input(|input| input.key_pressed(egui::Key::Enter));
            self.is_entered = field.lost_focus() && is_entered;
            let told = self.folder.clone();
            field
                .widget_info(|| egui::WidgetInfo::text_edit(true, "", &told, "Folder to write to"));
            if ui.button("Choose…").clicked() {
                actions.push(Action::Vary(VaryAction::AskForFolder));
            }
        });
        if self.settings.which.is_of_crowns() {
            return;
        }
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
        row(ui, "", |ui| {
            let mut is_on = self.settings.crowns.is_some();
            let help = "Inflates each picture to a crown in three dimensions: some seconds a tree. Export the folder “crowns” for engines.";
            let toggle = ui.checkbox(&mut is_on, "Also make crowns in 3D");
            toggle.on_hover_text(help);
            self.settings.crowns = is_on.then(|| CrownSettings::default().size);
        });
    }

    fn engine(&mut self, ui: &mut Ui) {
        let of_crowns = self.settings.which.is_of_crowns();
        let export = &mut self.export;
        if of_crowns && export.preset == Preset::FlightGear {
            export.preset = Preset::Blender;
        }
        row(ui, "For", |ui| {
            let choice = egui::ComboBox::from_id_salt("preset");
            let choice = choice.selected_text(title(export.preset)).width(160.0);
            let choice = choice.show_ui(ui, |ui| {
                for preset in Preset::ALL {
                    let can = !(of_crowns && preset == Preset::FlightGear);
                    ui.add_enabled_ui(can, |ui| {
                        ui.selectable_value(&mut export.preset, preset, title(preset))
                            .on_disabled_hover_text("FlightGear draws trees from pictures.");
                    });
                }
            });
            choice.response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "Who will read it")
            });
        });
    }

    /// What is made of crowns alone.
    fn of_crowns(&mut self, ui: &mut Ui) {
        let export = &mut self.export;
        row(ui, "Leaves", |ui| {
            let choice = egui::ComboBox::from_id_salt("leaves");
            let title = export.leaves.map_or(OWN_LEAVES, leaf_title);
            let choice = choice.selected_text(title).width(160.0);
            let choice = choice.show_ui(ui, |ui| {
                ui.selectable_value(&mut export.leaves, None, OWN_LEAVES);
                for leaves in LeafName::ALL {
                    ui.selectable_value(&mut export.leaves, Some(leaves), leaf_title(leaves));
                }
            });
            choice.response.widget_info(|| {
                egui::WidgetInfo::labeled(egui::Role::ComboBox, true, "Shape of the leaves")
            });
        });
        row(ui, "Impostors", |ui| {
            ui.spacing_mut().item_spacing.x = TIGHT;
            for (form, title, help) in [
                (
                    ImpostorName::Full,
                    "All Round",
                    "Pictures from every direction, for trees far away.",
                ),
                (
                    ImpostorName::Hemisphere,
                    "From Above",
                    "Pictures from the horizon and above: finer, for ground and air.",
                ),
            ] {
                let mut is_on = export.impostors.contains(&form);
                if ui
                    .toggle_value(&mut is_on, title)
                    .on_hover_text(help)
                    .clicked()
                {
                    if is_on {
                        export.impostors.insert(form);
                    } else {
                        export.impostors.remove(&form);
                    }
                }
            }
        });
        row(ui, "Cubemaps", |ui| {
            ui.add_enabled(false, egui::Button::new("PNG, KTX2").selected(true));
            ui.toggle_value(&mut export.exr, "OpenEXR")
                .on_hover_text("Linear colours and radii in metres.");
        });
    }

    /// What is made of trees alone.
    fn of_trees(&mut self, ui: &mut Ui) {
        let export = &mut self.export;
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
            listed(ui, &mut export.textures, TextureForm::Uastc, "UASTC");
            ui.checkbox(&mut export.has_atlas, "Atlas pages");
        });
    }

    /// What is said of trees and of crowns alike.
    fn of_models(&mut self, ui: &mut Ui) {
        let export = &mut self.export;
        if export.preset.has_models() {
            row(ui, "In models", |ui| {
                let choice = &mut export.model_textures;
                ui.selectable_value(choice, ModelTextures::Png, "PNG")
                    .on_hover_text("Every program reads it.");
                ui.selectable_value(choice, ModelTextures::Basisu, "Basis Universal")
                    .on_hover_text(
                        "Stays packed on the graphics card: a quarter of the memory, with mip levels. \
                         For the web; Blender and Godot want PNG.",
                    );
            });
        }
        row(ui, "Rights", |ui| {
            for (field, hint, told) in [
                (&mut export.author, "author", "Author"),
                (&mut export.license, "licence, as CC-BY-4.0", "Licence"),
            ] {
                let field_now = field.clone();
                let line = egui::TextEdit::singleline(field).hint_text(hint);
                ui.add(line.desired_width(150.0))
                    .widget_info(|| egui::WidgetInfo::text_edit(true, "", &field_now, told));
            }
        });
    }

    fn buttons(&mut self, ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let folder = self.folder.trim();
            let of_crowns = self.settings.which.is_of_crowns();
            let is_ready = of_crowns || studio.vary.prepared.is_some();
            let can = !folder.is_empty() && is_ready;
            let verb = if self.is_export { "Export" } else { "Make" };
            let button = ui.add_enabled(can, egui::Button::new(verb));
            let why = if is_ready {
                "Choose a folder first."
            } else {
                "The exemplars are being prepared."
            };
            let is_entered = std::mem::take(&mut self.is_entered) && can;
            if button.on_disabled_hover_text(why).clicked() || is_entered {
                let export = self.is_export.then(|| self.export.clone());
                let settings = BatchSettings {
                    folder: PathBuf::from(folder),
                    maps: match export {
                        Some(_) => Default::default(),
                        None => self.settings.maps.clone(),
                    },
                    has_sheet: self.settings.has_sheet && !self.is_export,
                    crowns: self.settings.crowns.filter(|_| !self.is_export),
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
