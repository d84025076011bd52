//! Doing what was asked: with [`super::outcome`] the only place where the project changes.

use super::action::{Action, Answer, Gesture, Pen};
use super::commands::Command;
use super::live::LiveAction;
use super::studio::{Effect, Next, Painting, Question, Severity, Studio, Tool};
use crate::document::store::{OnDisk, Over, on_disk};
use crate::document::{Document, Edit, EditError, PhotoId};
use crate::paint::{BACKGROUND, BrushSettings, CROWN, Paint, Stroke, TRUNK, TiledMask, inverted};
use std::path::PathBuf;
use std::sync::{Arc, PoisonError};

/// What a brush grows by at a key press.
const BRUSH_STEP: f64 = 1.125;

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
            Action::TakeTool(tool) => self.tools.tool = tool,
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
            Action::ShowPhoto(photo) => self.show_photo(photo),
            Action::Workspace(workspace) => self.workspace = workspace,
            Action::Open(paths) => self.open(paths),
            Action::SaveTo(path) => self.write_project(path, Over::Anything),
            Action::Recover(folder) => self.unless_unsaved(Next::Recover(folder)),
            Action::DiscardRecovery(folder) => self.discard_recovery(&folder),
            Action::CancelJob(job) => self.jobs.cancel(job),
            Action::PauseJob(job, is_paused) => self.jobs.set_paused(job, is_paused),
            Action::Answer(answer) => self.answer(answer),
            Action::Live(action) => self.act_live(action),
            Action::DismissNotice(id) => self.notices.retain(|notice| notice.id != id),
        }
        self.follow_live();
    }

    /// Something of the project may look different now.
    pub(super) fn changed(&mut self) {
        self.generation += 1;
        self.decode_what_is_shown();
    }

    fn run(&mut self, command: Command) {
        match command {
            Command::New => self.unless_unsaved(Next::New),
            Command::Open | Command::AddPhotos => self.effects.push(Effect::AskWhatToOpen),
            Command::OpenSample => self.unless_unsaved(Next::OpenSample),
            Command::Save => self.save(),
            Command::SaveAs => self.effects.push(Effect::AskWhereToSave),
            Command::Quit => self.unless_unsaved(Next::Quit),
            Command::Undo => {
                self.painting = None;
                self.document.undo();
                self.changed();
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
            Command::InvertMask => self.edit_mask("Invert Mask", |mask| {
                inverted(mask, CROWN);
            }),
            Command::Take(tool) => self.tools.tool = tool,
            Command::LargerBrush => {
                self.act(Action::BrushRadius(self.tools.radius_px * BRUSH_STEP))
            }
            Command::SmallerBrush => {
                self.act(Action::BrushRadius(self.tools.radius_px / BRUSH_STEP));
            }
            Command::ToggleEraser => self.tools.is_erasing = !self.tools.is_erasing,
            Command::SwapLabel => {
                let other = if self.tools.label == CROWN {
                    TRUNK
                } else {
                    CROWN
                };
                self.act(Action::PaintLabel(other));
            }
            Command::Show(workspace) => self.workspace = workspace,
            Command::ZoomToFit => self.effects.push(Effect::ZoomToFit),
            Command::ZoomToPixels => self.effects.push(Effect::ZoomToPixels),
            Command::ToggleMask => self.shows_mask = !self.shows_mask,
            Command::ToggleTheme => self.preferences.is_dark = !self.preferences.is_dark,
            Command::RestoreLayout => self.effects.push(Effect::RestoreLayout),
            Command::FrameTree => self.effects.push(Effect::FrameTree),
            Command::SavePicture => self.effects.push(Effect::AskWhereToSavePicture),
            Command::Turntable => self.live.is_turning = !self.live.is_turning,
            Command::Draw(drawn) => self.act_live(LiveAction::Draw(drawn)),
            Command::Palette => self.effects.push(Effect::TogglePalette),
            Command::ShortcutSheet => self.effects.push(Effect::ToggleShortcutSheet),
            Command::About => self.effects.push(Effect::ToggleAbout),
        }
    }

    /// Whether the command would do something now; menus grey out what would not.
    pub fn can(&self, command: Command) -> bool {
        match command {
            Command::Undo => self.document.undo_label().is_some(),
            Command::Redo => self.document.redo_label().is_some(),
            Command::Save => self.document.is_dirty() || self.file.path.is_none(),
            Command::FrameTree | Command::Turntable | Command::SavePicture => {
                self.live.shown.is_some()
            }
            Command::RemovePhoto
            | Command::ClearMask
            | Command::InvertMask
            | Command::ZoomToFit
            | Command::ZoomToPixels => self.shown().is_some(),
            _ => true,
        }
    }

    fn edit(&mut self, label: &'static str, edit: Edit, gesture: Gesture) {
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

    fn told(&mut self, edited: Result<bool, EditError>) {
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

    fn end_gesture(&mut self) {
        self.pen(Pen::Up);
        if self.document.commit() {
            self.changed();
        }
    }

    fn abort_gesture(&mut self) {
        self.painting = None;
        if self.document.abort() {
            self.changed();
        }
    }

    fn pen(&mut self, pen: Pen) {
        match pen {
            Pen::Down { sample, erases } => {
                self.end_gesture();
                self.painting = self.painting_begun(erases);
                self.pen(Pen::Move(sample));
            }
            Pen::Move(sample) => {
                if let Some(painting) = &mut self.painting {
                    painting.stroke.extend(&mut painting.mask, sample);
                    self.generation += 1;
                }
            }
            Pen::Up => {
                if let Some(Painting {
                    photo,
                    stroke,
                    mut mask,
                }) = self.painting.take()
                {
                    stroke.finish(&mut mask);
                    let label = if self.tools.is_erasing {
                        "Erase"
                    } else {
                        "Brush"
                    };
                    let edit = Edit::SetMask(photo, Arc::new(mask));
                    let edited = self.document.apply(label, edit);
                    self.told(edited);
                }
            }
        }
    }

    fn painting_begun(&self, erases: bool) -> Option<Painting> {
        let photo = self.shown()?;
        let mask = self.document.state().mask(photo)?;
        let tools = &self.tools;
        let settings = BrushSettings {
            radius_px: tools.radius_px,
            hardness: tools.hardness,
            smoothing: tools.smoothing,
            ..BrushSettings::default()
        };
        let label = if erases || tools.is_erasing {
            BACKGROUND
        } else {
            tools.label
        };
        (tools.tool == Tool::Brush).then(|| Painting {
            photo,
            stroke: Stroke::new(settings, Paint::of(label)),
            mask: TiledMask::clone(mask),
        })
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
                self.document
                    .mark_saved(self.document.snapshot().revision());
                self.go_on(next);
            }
            (Question::ChangedOnDisk(path), Answer::Anyway) => {
                self.write_project(path, Over::Anything);
            }
            (Question::ChangedOnDisk(_) | Question::OpenElsewhere(..), _) => {
                self.effects.push(Effect::AskWhereToSave);
            }
        }
    }

    /// The file's state, for a look when the window comes to the front.
    pub fn look_at_file(&mut self) {
        let (Some(path), Some(stamp)) = (&self.file.path, self.file.stamp) else {
            return;
        };
        if matches!(on_disk(path, stamp), Ok(OnDisk::Missing)) {
            let gone = format!("{} is gone; saving writes it again.", path.display());
            self.document.mark_unsaved();
            self.notify(Severity::Warning, gone);
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

    /// The project is in order: nothing needs to be recovered after this session.
    fn discard_autosave(&mut self) {
        self.jobs.cancel_all();
        let taken = self
            .autosave
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(autosave) = taken
            && let Err(error) = autosave.discard()
        {
            self.notify(Severity::Warning, error.to_string());
        }
    }
}
