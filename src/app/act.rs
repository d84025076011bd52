//! Doing what was asked: with [`super::outcome`] the only place where the project changes.

use super::action::{Action, Answer, Gesture, Pen};
use super::commands::Command;
use super::live::LiveAction;
use super::studio::{Effect, Next, Question, Severity, Studio, Workspace};
use super::tools::Overlay;
use crate::document::store::Over;
use crate::document::{Document, Edit, EditError, PhotoId};
use crate::paint::{BACKGROUND, CROWN, TRUNK, TiledMask, inverted};
use std::path::PathBuf;
use std::sync::Arc;

/// What a brush grows by at a key press.
const BRUSH_STEP: f64 = 1.125;

/// What it grows by with Shift, pixels of its radius.
const BRUSH_LEAP_PX: f64 = 10.0;

/// What a key press zooms by.
const ZOOM_STEP: f32 = 1.25;

fn toggle(choice: &mut bool) {
    *choice = !*choice;
}

impl Studio {
    /// Does what was asked.
    pub fn act(&mut self, action: Action) {
        match action {
            Action::Do(command) => self.run(command),
            Action::Edit {
                label,
                edit,
                gesture,
            } => self.edit(label, edit, gesture),
            Action::EndGesture => self.end_gesture(),
            Action::AbortGesture => self.abort_gesture(),
            Action::Pen(pen) => self.pen(pen),
            Action::Mask(action) => self.act_on_mask(action),
            Action::TakeTool(tool) => self.take_tool(tool),
            Action::PaintLabel(label) => {
                self.tools.label = label;
                self.tools.is_erasing = false;
            }
            Action::BrushRadius(radius) => self.tools.radius_px = radius.clamp(0.75, 4096.0),
            Action::BrushHardness(hardness) => self.tools.hardness = hardness,
            Action::BrushSmoothing(smoothing) => self.tools.smoothing = smoothing,
            Action::Look(view) => {
                *self.document.view_mut() = *view;
                self.changed();
            }
            Action::LookAt(view) => self.document.view_mut().canvas = Some(view),
            Action::ShowPhoto(photo) => self.show_photo(photo),
            Action::SeePhotos(pane, photos) => self.see_photos(pane, &photos),
            Action::Workspace(workspace) => self.go_to(workspace),
            Action::Open(paths) => self.open(paths),
            Action::SaveTo(path) => self.write_project(path, Over::Anything),
            Action::Recover(folder) => self.unless_unsaved(Next::Recover(folder)),
            Action::DiscardRecovery(folder) => self.discard_recovery(&folder),
            Action::CancelJob(job) => self.jobs.cancel(job),
            Action::PauseJob(job, is_paused) => self.jobs.set_paused(job, is_paused),
            Action::Answer(answer) => self.answer(answer),
            Action::UseRuntime(library) => self.use_runtime(library),
            Action::UseModel(model) => self.read_model(model, true),
            Action::TourSeen => self.preferences.tour_was_seen = true,
            Action::Live(action) => self.act_live(action),
            Action::Vary(action) => self.vary(action),
            Action::DismissNotice(id) => self.notices.retain(|notice| notice.id != id),
        }
        self.follow_live();
    }

    /// Keeps the library for the next start: in this session networks may have run already.
    fn use_runtime(&mut self, library: PathBuf) {
        let told = format!(
            "{} will find crown and trunk when Boscage starts again.",
            library.display()
        );
        self.preferences.onnx_runtime = Some(library);
        self.notify(Severity::Info, told);
    }

    /// Something of the project may look different now.
    pub(super) fn changed(&mut self) {
        self.generation += 1;
        self.forget_foreign_sketch();
        self.decode_what_is_shown();
        self.ask_for_shape();
        self.refresh_variations();
    }

    fn run(&mut self, command: Command) {
        self.recent_commands.retain(|&other| other != command);
        self.recent_commands.insert(0, command);
        match command {
            Command::New => self.unless_unsaved(Next::New),
            Command::Open | Command::AddPhotos => self.effects.push(Effect::AskWhatToOpen),
            Command::OpenSample => self.unless_unsaved(Next::OpenSample),
            Command::Save => self.save(),
            Command::SaveAs => self.effects.push(Effect::AskWhereToSave),
            Command::Quit => self.unless_unsaved(Next::Quit),
            Command::Undo => {
                if !self.step_back() {
                    self.document.undo();
                    self.changed();
                }
            }
            Command::Redo => {
                self.document.redo();
                self.changed();
            }
            Command::RemovePhoto => {
                if let Some(photo) = self.shown() {
                    self.edit("Remove Picture", Edit::RemovePhoto(photo), Gesture::Whole);
                }
            }
            Command::ClearMask => self.edit_mask("Clear Mask", |mask| {
                *mask = TiledMask::filled(mask.width(), mask.height(), BACKGROUND);
            }),
            Command::InvertMask => {
                let label = self.tools.label;
                self.change_mask("Invert Mask", move |mask, _| Ok(inverted(mask, label)));
            }
            Command::Mask(command) => self.run_on_mask(command),
            Command::Take(tool) => self.take_tool(tool),
            // Where no digit chooses a label, 1 is what it is in other programs.
            Command::Label(1) if !self.tools.tool.paints() => {
                self.effects.push(Effect::ZoomToPixels);
            }
            Command::Label(label) => self.act(Action::PaintLabel(label)),
            Command::LargerBrush => {
                let radius = (self.tools.radius_px * BRUSH_STEP).max(self.tools.radius_px + 0.5);
                self.act(Action::BrushRadius(radius));
            }
            Command::SmallerBrush => {
                let radius = (self.tools.radius_px / BRUSH_STEP).min(self.tools.radius_px - 0.5);
                self.act(Action::BrushRadius(radius));
            }
            Command::MuchLargerBrush => {
                self.act(Action::BrushRadius(self.tools.radius_px + BRUSH_LEAP_PX));
            }
            Command::MuchSmallerBrush => {
                self.act(Action::BrushRadius(self.tools.radius_px - BRUSH_LEAP_PX));
            }
            Command::ToggleEraser => self.tools.is_erasing = !self.tools.is_erasing,
            Command::SwapLabel => self.swap_label(),
            Command::Show(workspace) => self.go_to(workspace),
            Command::RollTrees => self.roll(),
            Command::MakeTrees | Command::ExportTrees => self.ask_where_to_make(command),
            Command::ZoomToFit => self.effects.push(Effect::ZoomToFit),
            Command::ZoomToPixels => self.effects.push(Effect::ZoomToPixels),
            Command::ZoomIn => self.effects.push(Effect::ZoomBy(ZOOM_STEP)),
            Command::ZoomOut => self.effects.push(Effect::ZoomBy(1.0 / ZOOM_STEP)),
            Command::ToggleMask => self.toggle_overlay(Overlay::Tint),
            Command::Overlay(overlay) => self.toggle_overlay(overlay),
            Command::ToggleTheme => self.preferences.is_dark = !self.preferences.is_dark,
            Command::RestoreLayout => self.effects.push(Effect::RestoreLayout),
            Command::FrameTree => self.effects.push(Effect::FrameTree),
            Command::SavePicture => self.effects.push(Effect::AskWhereToSavePicture),
            Command::ToggleLiveCrown => toggle(&mut self.preferences.live_crown),
            Command::Turntable => self.live.is_turning = !self.live.is_turning,
            Command::Draw(drawn) => self.act_live(LiveAction::Draw(drawn)),
            Command::Palette => self.effects.push(Effect::TogglePalette),
            Command::ShortcutSheet => self.effects.push(Effect::ToggleShortcutSheet),
            Command::Tour => self.effects.push(Effect::StartTour),
            Command::ChooseRuntime => self.effects.push(Effect::AskWhichRuntime),
            Command::ChooseModel => self.effects.push(Effect::AskWhichModel),
            Command::UseBuiltInModel => self.use_built_in_model(),
            Command::About => self.effects.push(Effect::ToggleAbout),
        }
    }

    /// Crown to trunk; anything else to crown.
    fn swap_label(&mut self) {
        let other = if self.tools.label == CROWN {
            TRUNK
        } else {
            CROWN
        };
        self.act(Action::PaintLabel(other));
    }

    /// Whether the command would do something now; menus grey out what would not.
    pub fn can(&self, command: Command) -> bool {
        match command {
            Command::Undo => self.document.undo_label().is_some() || self.is_drawing(),
            Command::Redo => self.document.redo_label().is_some(),
            Command::Save => self.document.is_dirty() || self.file.path.is_none(),
            Command::FrameTree | Command::Turntable | Command::SavePicture => {
                self.live.shown.is_some()
            }
            Command::RemovePhoto
            | Command::ClearMask
            | Command::InvertMask
            | Command::Mask(_)
            | Command::ZoomIn
            | Command::ZoomOut
            | Command::ZoomToFit
            | Command::ZoomToPixels => self.shown().is_some(),
            Command::RollTrees => self.workspace == Workspace::Variations,
            Command::MakeTrees | Command::ExportTrees => !self.is_empty(),
            _ => true,
        }
    }

    pub(super) fn go_to(&mut self, workspace: Workspace) {
        self.workspace = workspace;
        self.refresh_variations();
    }

    pub(super) fn edit(&mut self, label: &'static str, edit: Edit, gesture: Gesture) {
        if gesture == Gesture::Whole {
            self.end_gesture();
        } else if !self.document.is_in_gesture() {
            self.document.begin(label);
        }
        let edited = self.document.apply(label, edit);
        if gesture == Gesture::Ended {
            self.document.commit();
        }
        self.told(edited);
    }

    pub(super) fn told(&mut self, edited: Result<bool, EditError>) {
        match edited {
            Ok(true) => self.changed(),
            Ok(false) => {}
            Err(error) => self.notify(Severity::Error, error.to_string()),
        }
    }

    fn edit_mask(&mut self, label: &'static str, change: impl FnOnce(&mut TiledMask)) {
        let Some(photo) = self.shown() else { return };
        let Some(mask) = self.document.state().mask(photo) else {
            return;
        };
        let mut mask = TiledMask::clone(mask);
        change(&mut mask);
        self.edit(label, Edit::SetMask(photo, Arc::new(mask)), Gesture::Whole);
    }

    pub(super) fn end_gesture(&mut self) {
        self.pen(Pen::Up);
        if self.document.commit() {
            self.changed();
        }
        self.take_up_held();
    }

    fn abort_gesture(&mut self) {
        self.painting = None;
        self.mask_work.sketch = None;
        self.generation += 1;
        if self.document.abort() {
            self.changed();
        }
        self.take_up_held();
    }

    fn show_photo(&mut self, photo: PhotoId) {
        self.end_gesture();
        if self.shown() != Some(photo) {
            self.document.view_mut().photo = Some(photo);
            self.effects.push(Effect::ZoomToFit);
            self.changed();
        }
    }

    fn open(&mut self, paths: Vec<PathBuf>) {
        let is_project = |path: &PathBuf| path.extension().is_some_and(|end| end == "boscage");
        let (projects, pictures): (Vec<_>, Vec<_>) = paths.into_iter().partition(is_project);
        if let Some(project) = projects.into_iter().next() {
            self.unless_unsaved(Next::Open(project));
        }
        if !pictures.is_empty() {
            self.read_pictures(pictures);
        }
    }

    fn save(&mut self) {
        let Some(path) = self.file.path.clone() else {
            self.effects.push(Effect::AskWhereToSave);
            return;
        };
        if self.file.lock.is_none() {
            // Somebody else may be writing this file.
            self.effects.push(Effect::AskWhereToSave);
            return;
        }
        let over = self.file.stamp.map_or(Over::Anything, Over::Unchanged);
        self.write_project(path, over);
    }

    /// Goes on with `next`, or asks first when the project would be lost.
    fn unless_unsaved(&mut self, next: Next) {
        self.end_gesture();
        if self.document.is_dirty() && !(self.is_empty() && self.document.undo_label().is_none()) {
            self.question = Some(Question::Unsaved(next));
        } else {
            self.go_on(next);
        }
    }

    /// Does what waited for the project to be safe.
    pub(super) fn go_on(&mut self, next: Next) {
        match next {
            Next::New => self.replace(Document::new()),
            Next::Open(path) => self.read_project(path),
            Next::OpenSample => self.make_sample(),
            Next::Recover(folder) => self.recover(&folder),
            Next::Quit => {
                self.jobs.cancel_all();
                self.discard_autosave();
                self.effects.push(Effect::Quit);
            }
        }
    }

    fn answer(&mut self, answer: Answer) {
        let Some(question) = self.question.take() else {
            return;
        };
        match (question, answer) {
            (_, Answer::Cancel) => {}
            (Question::Unsaved(next), Answer::Save) => {
                self.after_save = Some(next);
                self.save();
            }
            (Question::Unsaved(next), Answer::Anyway) => {
                // Else the window would ask again; a project that cannot be opened leaves this one unsaved.
                if next == Next::Quit {
                    let revision = self.document.snapshot().revision();
                    self.document.mark_saved(revision);
                }
                self.go_on(next);
            }
            (Question::ChangedOnDisk(path), Answer::Anyway) => {
                self.write_project(path, Over::Anything);
            }
            (Question::ChangedOnDisk(_), Answer::Save) => {
                self.effects.push(Effect::AskWhereToSave);
            }
        }
    }

    fn discard_recovery(&mut self, folder: &std::path::Path) {
        let Some(at) = self
            .recoverable
            .iter()
            .position(|left| left.folder == folder)
        else {
            return;
        };
        match self.recovery.discard(&self.recoverable[at]) {
            Ok(()) => drop(self.recoverable.remove(at)),
            Err(error) => self.notify(Severity::Error, error.to_string()),
        }
    }
}
