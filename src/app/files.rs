//! File dialogs: the desktop's, and one of our own where the desktop has none.
//!
//! `rfd` asks the desktop's portal. Without one it answers at once, as if the user had cancelled; no
//! hand is that quick, so our own dialog, a field for the path, opens then.

use super::act_vary::VaryAction;
use super::action::Action;
use super::live::LiveAction;
use super::mask_action::MaskAction;
use super::theme::{GAP, dialog};
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

/// What a person needs at least to cancel a dialog.
const QUICKEST_HAND: Duration = Duration::from_millis(350);

/// What a dialog is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    /// Projects and pictures to open.
    Open,
    /// The file to save the project to.
    Save,
    /// A picture whose labels are wanted.
    ImportMask,
    /// A library that runs networks.
    Runtime,
    /// A model that tells crown from trunk.
    Model,
    /// The file to write the labels to.
    ExportMask,
    /// A folder to write trees to.
    Folder,
    /// The file to save a picture of the crown to.
    Picture,
}

/// The dialogs of the window; one at a time.
#[derive(Default)]
pub(super) struct FileDialogs {
    asked: Option<Asked>,
    own: Option<OwnDialog>,
}

struct Asked {
    purpose: Purpose,
    since: Instant,
    answer: Receiver<Option<Vec<PathBuf>>>,
}

struct OwnDialog {
    purpose: Purpose,
    path: String,
    is_new: bool,
}

impl FileDialogs {
    /// Asks the desktop.
    pub(super) fn ask(&mut self, purpose: Purpose, ctx: &egui::Context) {
        if self.asked.is_some() {
            return;
        }
        let (sender, answer) = channel();
        let ctx = ctx.clone();
        let dialog = move || {
            // A window that is gone does not need the answer.
            let _ = sender.send(of_desktop(purpose));
            ctx.request_repaint();
        };
        let started = std::thread::Builder::new()
            .name("file dialog".to_owned())
            .spawn(dialog);
        if started.is_err() {
            self.own = Some(OwnDialog::new(purpose));
            return;
        }
        self.asked = Some(Asked {
            purpose,
            since: Instant::now(),
            answer,
        });
    }

    /// Shows what is open and takes what was chosen.
    pub(super) fn show(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) {
        if let Some(asked) = &self.asked {
            match asked.answer.try_recv() {
                Err(TryRecvError::Empty) => {}
                Ok(Some(paths)) => {
                    actions.extend(chosen(asked.purpose, paths));
                    self.asked = None;
                }
                Ok(None) | Err(TryRecvError::Disconnected) => {
                    let has_no_portal = asked.since.elapsed() < QUICKEST_HAND;
                    self.own = has_no_portal.then(|| OwnDialog::new(asked.purpose));
                    self.asked = None;
                }
            }
        }
        if let Some(own) = &mut self.own
            && own.show(ctx, actions)
        {
            self.own = None;
        }
    }
}

fn of_desktop(purpose: Purpose) -> Option<Vec<PathBuf>> {
    let dialog = rfd::FileDialog::new();
    match purpose {
        Purpose::Folder => dialog.pick_folder().map(|path| vec![path]),
        Purpose::Open => dialog
            .add_filter(
                "Projects and pictures",
                &[
                    "boscage", "png", "jpg", "jpeg", "webp", "tif", "tiff", "tga", "bmp",
                ],
            )
            .add_filter("All files", &["*"])
            .pick_files(),
        Purpose::Runtime => dialog.pick_file().map(|path| vec![path]),
        Purpose::Model => dialog
            .add_filter("ONNX models", &["onnx"])
            .pick_file()
            .map(|path| vec![path]),
        Purpose::ImportMask => dialog
            .add_filter("Masks", &["png", "tif", "tiff", "tga", "bmp", "webp"])
            .pick_file()
            .map(|path| vec![path]),
        Purpose::ExportMask => {
            let dialog = dialog.add_filter("PNG picture", &["png"]);
            let dialog = dialog.set_file_name("mask.png");
            dialog.save_file().map(|path| vec![path])
        }
        Purpose::Picture => dialog
            .add_filter("PNG picture", &["png"])
            .set_file_name("tree.png")
            .save_file()
            .map(|path| vec![path]),
        Purpose::Save => {
            let dialog = dialog.add_filter("Boscage project", &["boscage"]);
            dialog
                .set_file_name("Untitled.boscage")
                .save_file()
                .map(|path| vec![path])
        }
    }
}

fn chosen(purpose: Purpose, mut paths: Vec<PathBuf>) -> Option<Action> {
    match purpose {
        Purpose::Folder => {
            let folder = paths.pop()?;
            Some(Action::Vary(VaryAction::ChoseFolder(folder)))
        }
        Purpose::Open => (!paths.is_empty()).then_some(Action::Open(paths)),
        Purpose::Runtime => Some(Action::UseRuntime(paths.pop()?)),
        Purpose::Model => Some(Action::UseModel(paths.pop()?)),
        Purpose::ImportMask => Some(Action::Mask(MaskAction::Import(paths.pop()?))),
        Purpose::ExportMask | Purpose::Picture => {
            let mut path = paths.pop()?;
            if path.extension().is_none() {
                path.set_extension("png");
            }
            Some(match purpose {
                Purpose::Picture => Action::Live(LiveAction::SavePicture(path)),
                _ => Action::Mask(MaskAction::Export(path)),
            })
        }
        Purpose::Save => {
            let mut path = paths.pop()?;
            if path.extension().is_none() {
                path.set_extension("boscage");
            }
            Some(Action::SaveTo(path))
        }
    }
}

impl OwnDialog {
    fn new(purpose: Purpose) -> Self {
        Self {
            purpose,
            path: String::new(),
            is_new: true,
        }
    }

    /// Whether it is done.
    fn show(&mut self, ctx: &egui::Context, actions: &mut Vec<Action>) -> bool {
        let mut is_done = false;
        let (title, verb) = match self.purpose {
            Purpose::Open => ("Open", "Open"),
            Purpose::Save => ("Save Project As", "Save"),
            Purpose::Runtime => ("Use ONNX Runtime", "Use"),
            Purpose::Model => ("Use Segmentation Model", "Use"),
            Purpose::ImportMask => ("Import Mask", "Import"),
            Purpose::ExportMask => ("Export Mask", "Export"),
            Purpose::Folder => ("Choose a Folder", "Choose"),
            Purpose::Picture => ("Save Picture", "Save"),
        };
        let modal = dialog(ctx, "own file dialog").show(ctx, |ui| {
            ui.set_width(460.0);
            ui.heading(title);
            ui.add_space(GAP);
            ui.label("This desktop offers no file dialog. Type or paste the path.");
            let label = ui.label("Path");
            let field = ui.add(
                egui::TextEdit::singleline(&mut self.path)
                    .desired_width(f32::INFINITY)
                    .hint_text("/home/me/oak.jpg"),
            );
            let field = field.labelled_by(label.id);
            if std::mem::take(&mut self.is_new) {
                field.request_focus();
            }
            let entered =
                field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            ui.add_space(GAP);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                let can = !self.path.trim().is_empty();
                let is_chosen = ui.add_enabled(can, egui::Button::new(verb)).clicked();
                if can && (is_chosen || entered) {
                    actions.extend(chosen(self.purpose, vec![PathBuf::from(self.path.trim())]));
                    is_done = true;
                }
                is_done |= ui.button("Cancel").clicked();
            });
        });
        is_done || modal.should_close()
    }
}
