//! What the studio knows: the project, what it shows, the tools in hand, the jobs. No window.

use super::act_mask::MaskWork;
use super::commands::Command;
use super::live::Live;
use super::outcome::Outcome;
use super::own_model::OwnModel;
use super::photos::Photos;
use super::preferences::Preferences;
use super::tools::Tools;
use super::vary::Vary;
use crate::document::store::{Autosave, AutosaveClock, Lock, Recoverable, Recovery, Stamp};
use crate::document::{Document, PhotoId};
use crate::jobs::Jobs;
use crate::paint::{Stroke, TiledMask};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// What fills the window.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize, serde::Deserialize,
)]
pub enum Workspace {
    /// One photograph, its mask, its crown.
    #[default]
    Crown,
    /// New trees from several.
    Variations,
    /// All pictures.
    Library,
}

impl Workspace {
    /// In the order of their tabs.
    pub const ALL: [Self; 3] = [Self::Crown, Self::Variations, Self::Library];

    /// What stands on its tab.
    pub fn title(self) -> &'static str {
        match self {
            Self::Crown => "Crown",
            Self::Variations => "Variations",
            Self::Library => "Library",
        }
    }
}

/// Where the project lies on disk.
#[derive(Debug, Default)]
pub struct ProjectFile {
    /// The file, once there is one.
    pub path: Option<PathBuf>,
    /// What it held when it was read or written last.
    pub(super) stamp: Option<Stamp>,
    /// The right to write it; `None` also when it could not be had.
    pub(super) lock: Option<Lock>,
}

/// A question in the middle of the window; nothing else goes on until it is answered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Question {
    /// The project would be lost by what comes next.
    Unsaved(Next),
    /// Somebody else wrote the file.
    ChangedOnDisk(PathBuf),
}

/// What is done once the project is safe.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Next {
    /// An empty project.
    New,
    /// The project in this file.
    Open(PathBuf),
    /// The project that comes with the studio.
    OpenSample,
    /// The autosave in this folder.
    Recover(PathBuf),
    /// The end.
    Quit,
}

/// How serious a notice is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// Done.
    Info,
    /// Worth knowing.
    Warning,
    /// Not done.
    Error,
}

/// A line for the user at the bottom of the window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Notice {
    /// Its number.
    pub id: u64,
    /// How serious it is.
    pub severity: Severity,
    /// What it says.
    pub text: String,
}

/// Something that only the window can do.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Effect {
    /// Shows the file dialog for opening.
    AskWhatToOpen,
    /// Shows the file dialog for saving.
    AskWhereToSave,
    /// Shows the file dialog for folders.
    AskForFolder,
    /// Opens the dialog of a command that writes trees.
    AskWhatToMake(super::Command),
    /// Shows all of the picture.
    ZoomToFit,
    /// Shows each pixel on one of the screen.
    ZoomToPixels,
    /// Zooms the canvas by this factor.
    ZoomBy(f32),
    /// Shows the file dialog for a mask to read.
    AskWhichMask,
    /// Asks for a library that runs networks.
    AskWhichRuntime,
    /// Asks for a model that tells crown from trunk.
    AskWhichModel,
    /// Shows the file dialog for a mask to write.
    AskWhereToExportMask,
    /// Shows the file dialog for a picture of the crown.
    AskWhereToSavePicture,
    /// Shows the whole tree.
    FrameTree,
    /// Puts all panels back.
    RestoreLayout,
    /// Opens the command palette or closes it.
    TogglePalette,
    /// Opens the shortcut sheet or closes it.
    ToggleShortcutSheet,
    /// Begins the tour.
    StartTour,
    /// Says what the studio is, or stops saying it.
    ToggleAbout,
    /// Closes the window.
    Quit,
}

/// A brush stroke that is being painted on a copy of the mask.
#[derive(Debug)]
pub(super) struct Painting {
    pub(super) photo: PhotoId,
    pub(super) stroke: Stroke,
    pub(super) mask: TiledMask,
    /// Whether it erases.
    pub(super) erases: bool,
}

/// The autosaves of this session; shared with the job that writes them.
pub(super) type SharedAutosave = Arc<Mutex<Option<Autosave>>>;

/// All that the studio knows. Panels read it; [`Studio::act`] changes it.
pub struct Studio {
    /// The project: changed in [`super::act`] only.
    pub(super) document: Document,
    /// Counts up whenever another project takes its place: what was saved before says nothing of it.
    pub(super) project: u64,
    /// Counts up whenever the project may look different.
    pub(super) generation: u64,
    pub(super) file: ProjectFile,
    pub(super) recovery: Recovery,
    pub(super) recoverable: Vec<Recoverable>,
    pub(super) autosave: SharedAutosave,
    pub(super) autosave_clock: AutosaveClock,
    pub(super) jobs: Jobs<Outcome>,
    pub(super) photos: Photos,
    pub(super) tools: Tools,
    pub(super) painting: Option<Painting>,
    pub(super) live: Live,
    pub(super) vary: Vary,
    pub(super) workspace: Workspace,
    pub(super) mask_work: MaskWork,
    pub(super) preferences: Preferences,
    pub(super) own_model: Option<OwnModel>,
    /// What tries models out, if not the program that runs.
    pub(super) trial_program: Option<PathBuf>,
    /// Commands in the order of their last use, the latest first.
    pub(super) recent_commands: Vec<Command>,
    pub(super) question: Option<Question>,
    /// What waits until the project is saved.
    pub(super) after_save: Option<Next>,
    pub(super) notices: Vec<Notice>,
    pub(super) next_notice: u64,
    /// For the shell to take.
    pub(super) effects: Vec<Effect>,
}

impl Studio {
    /// A studio with an empty project. Autosaves lie below `recovery_folder`; `waker` is called from
    /// any thread when a job has something to tell.
    pub fn new(
        preferences: Preferences,
        recovery_folder: PathBuf,
        waker: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let threads = std::thread::available_parallelism().map_or(2, usize::from);
        let recovery = Recovery::at(recovery_folder);
        let model = preferences.segmentation_model.clone();
        let mut studio = Self {
            document: Document::new(),
            project: 0,
            generation: 0,
            file: ProjectFile::default(),
            recoverable: recovery.list(),
            recovery,
            autosave: SharedAutosave::default(),
            autosave_clock: AutosaveClock::default(),
            jobs: Jobs::new(threads, waker),
            photos: Photos::default(),
            tools: Tools::default(),
            painting: None,
            live: Live::default(),
            vary: Vary::default(),
            workspace: Workspace::default(),
            mask_work: MaskWork::default(),
            preferences,
            own_model: None,
            trial_program: None,
            recent_commands: Vec::new(),
            question: None,
            after_save: None,
            notices: Vec::new(),
            next_notice: 0,
            effects: Vec::new(),
        };
        if let Some(model) = model {
            studio.read_model(model, false);
        }
        studio
    }

    /// The project.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// Where it lies.
    pub fn file(&self) -> &ProjectFile {
        &self.file
    }

    /// The photograph that is shown.
    pub fn shown(&self) -> Option<PhotoId> {
        let photos = &self.document.state().content().photos;
        let wanted = self.document.view().photo;
        wanted
            .filter(|photo| photos.contains_key(photo))
            .or_else(|| photos.keys().next().copied())
    }

    /// The labels of the shown photograph, with the stroke that is being painted.
    pub fn shown_mask(&self) -> Option<&TiledMask> {
        let shown = self.shown()?;
        match &self.painting {
            Some(painting) if painting.photo == shown => Some(&painting.mask),
            _ => self.document.state().mask(shown).map(Arc::as_ref),
        }
    }

    /// Whether there is nothing to work on.
    pub fn is_empty(&self) -> bool {
        self.document.state().content().photos.is_empty()
    }

    /// What the title bar calls the project.
    pub fn title(&self) -> String {
        let name = self.file.path.as_deref().and_then(Path::file_stem);
        let name = name.map_or("Untitled".into(), |name| name.to_string_lossy());
        let mark = if self.document.is_dirty() { "*" } else { "" };
        format!("{name}{mark} – Boscage")
    }

    /// What was left behind by a crash.
    pub fn recoverable(&self) -> &[Recoverable] {
        &self.recoverable
    }

    /// Commands in the order of their last use, the latest first.
    pub fn recent_commands(&self) -> &[Command] {
        &self.recent_commands
    }

    /// What fills the window.
    pub fn workspace(&self) -> Workspace {
        self.workspace
    }

    /// The user's choices.
    pub fn preferences(&self) -> &Preferences {
        &self.preferences
    }

    /// Whether jobs wait or run.
    pub fn is_busy(&self) -> bool {
        !self.jobs.is_idle()
    }

    /// What is asked, if anything.
    pub fn question(&self) -> Option<&Question> {
        self.question.as_ref()
    }

    /// The lines at the bottom of the window, the newest last.
    pub fn notices(&self) -> &[Notice] {
        &self.notices
    }

    /// Tells the user something.
    pub(super) fn notify(&mut self, severity: Severity, text: impl Into<String>) {
        let (id, text) = (self.next_notice, text.into());
        self.next_notice += 1;
        self.notices.retain(|notice| notice.text != text);
        self.notices.push(Notice { id, severity, text });
        // Older ones were read or never will be.
        let many = self.notices.len().saturating_sub(3);
        self.notices.drain(..many);
    }
}

impl Studio {
    /// Whether closing the window now would lose something.
    pub fn may_not_close(&self) -> bool {
        self.document.is_dirty() && !self.is_empty()
    }

    /// A command's name now: what *Undo* would undo, for instance.
    pub fn label_of(&self, command: Command) -> String {
        let label = command.row().label;
        let of = match command {
            Command::Undo => self.document.undo_label(),
            Command::Redo => self.document.redo_label(),
            _ => None,
        };
        of.map_or(label.to_owned(), |of| format!("{label} {of}"))
    }
}
