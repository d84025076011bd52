//! What panels, keys and menus ask the studio to do.

use super::act_vary::VaryAction;
use super::commands::Command;
use super::dock::Pane;
use super::live::LiveAction;
use super::mask_action::MaskAction;
use super::studio::Workspace;
use super::tools::Tool;
use crate::document::{CanvasView, Edit, PhotoId, ViewState};
use crate::jobs::JobId;
use crate::paint::Sample;
use std::path::PathBuf;

/// Where in a gesture of the user's hand an edit stands: all edits of one gesture are one step to
/// undo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Gesture {
    /// All of it: a click, a typed value.
    Whole,
    /// The hand is still down.
    Going,
    /// The hand went up.
    Ended,
}

/// Something to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// A command with a name.
    Do(Command),
    /// A change of the project, called `label` in the menu.
    Edit {
        /// Its name in the history.
        label: &'static str,
        /// The change.
        edit: Edit,
        /// Where in a gesture it stands.
        gesture: Gesture,
    },
    /// Ends the gesture in progress, whatever it was.
    EndGesture,
    /// Takes back the gesture in progress.
    AbortGesture,
    /// The pen on the canvas of the shown photograph.
    Pen(Pen),
    /// Something with the mask of the shown photograph.
    Mask(MaskAction),
    /// Takes up another tool.
    TakeTool(Tool),
    /// The label that tools paint.
    PaintLabel(u8),
    /// The brush's radius, pixels of the photograph.
    BrushRadius(f64),
    /// The brush's hardness, 0 to 1.
    BrushHardness(f64),
    /// How far the brush calms the hand, 0 to 1.
    BrushSmoothing(f64),
    /// Runs networks with this library from the next start on.
    UseRuntime(PathBuf),
    /// Tells crown from trunk with this model, if it is sound.
    UseModel(PathBuf),
    /// Looks differently at the project; not undone.
    Look(Box<ViewState>),
    /// The canvas looks here now; not undone.
    LookAt(CanvasView),
    /// Shows another photograph.
    ShowPhoto(PhotoId),
    /// These photographs are in a panel's sight and their thumbnails are not there.
    SeePhotos(Pane, Vec<PhotoId>),
    /// Goes to another workspace.
    Workspace(Workspace),
    /// Opens a project, or adds pictures: whatever the files are.
    Open(Vec<PathBuf>),
    /// Writes the project to a file of the user's choice.
    SaveTo(PathBuf),
    /// Opens the autosave in this folder.
    Recover(PathBuf),
    /// Throws the autosave in this folder away.
    DiscardRecovery(PathBuf),
    /// Stops a job.
    CancelJob(JobId),
    /// Pauses a job, or lets it go on.
    PauseJob(JobId, bool),
    /// The question in the middle of the window is answered.
    Answer(Answer),
    /// The tour was walked or skipped: it does not begin by itself again.
    TourSeen,
    /// Something about the crown and its view.
    Live(LiveAction),
    /// What the variations' panels ask for.
    Vary(VaryAction),
    /// A line at the bottom of the window was read.
    DismissNotice(u64),
}

/// What the pen does, in pixels of the shown photograph.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pen {
    /// It goes down; `erases` while the user holds the key for that.
    Down {
        /// Where.
        sample: Sample,
        /// Whether it erases whatever the tool.
        erases: bool,
    },
    /// It moves while down.
    Move(Sample),
    /// It goes up.
    Up,
}

/// What the user answered to a [`super::studio::Question`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Saves, then goes on.
    Save,
    /// Goes on without saving, or writes over.
    Anyway,
    /// Does nothing.
    Cancel,
}
