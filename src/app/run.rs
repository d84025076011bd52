//! The studio in a window of the desktop, and what outlives that window.
//!
//! When the graphics card is lost (its driver was reset or updated, the machine changed cards) nothing
//! can be drawn on its device any more, the window itself included. The window is closed then and
//! another is opened on a new device, with the same studio: project, undo, tools and jobs go on. When
//! the program fails otherwise, what no file holds is written to the autosaves first.

use super::shell::Shell;
use super::studio::Studio;
use egui::Context;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Windows that may lose their cards one after the other within [`SOON`]: a card that is lost as soon as
/// it is used shall not keep opening them.
const MOST_LOST: usize = 4;

/// Time in which a window has hardly been used.
const SOON: Duration = Duration::from_secs(10);

/// The studio cannot be shown.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// There is no desktop to show it on, or no way to draw on it.
    #[error("no window can be opened: {0}")]
    Window(String),
    /// A library of the desktop is missing or broken.
    #[error("the desktop's libraries failed: {0}")]
    Desktop(String),
    /// The card was lost too often.
    #[error("the graphics card is lost again and again")]
    Card,
}

/// Opens the studio and returns when it is closed. `files` are opened first.
///
/// # Errors
/// [`StartError`]; what no file holds is in the autosaves then.
pub fn run(files: Vec<PathBuf>) -> Result<(), StartError> {
    let folder = own_folder();
    let session = Session::default();
    let mut files = files;
    let mut lost = 0;
    loop {
        let begun = Instant::now();
        let closed = window(&folder, std::mem::take(&mut files), &session);
        if !session.goes_on() {
            session.rescue();
            return closed;
        }
        lost = if begun.elapsed() < SOON { lost + 1 } else { 0 };
        if lost == MOST_LOST {
            session.rescue();
            return Err(StartError::Card);
        }
    }
}

/// Shows one window until it is closed.
fn window(folder: &Path, files: Vec<PathBuf>, session: &Session) -> Result<(), StartError> {
    let recovery = folder.join("recovery");
    let options = eframe::NativeOptions {
        persistence_path: Some(folder.join("studio.ron")),
        viewport: egui::ViewportBuilder::default()
            .with_app_id("boscage")
            .with_title("Boscage")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([960.0, 600.0]),
        ..Default::default()
    };
    let session = session.clone();
    let shell = move |creation: &eframe::CreationContext<'_>| -> Box<dyn eframe::App> {
        Box::new(Shell::in_session(creation, recovery, files, session))
    };
    let closed = crate::base::without_panics(|| {
        eframe::run_native(
            "boscage",
            options,
            Box::new(move |creation| Ok(shell(creation))),
        )
    });
    match closed {
        Ok(Ok(())) => Ok(()),
        Ok(Err(error)) => Err(StartError::Window(error.to_string())),
        Err(panicked) => Err(StartError::Desktop(panicked.message)),
    }
}

/// Where preferences and autosaves lie: `BOSCAGE_CONFIG`, or the place that the desktop gives.
fn own_folder() -> PathBuf {
    if let Some(folder) = std::env::var_os("BOSCAGE_CONFIG") {
        return folder.into();
    }
    directories::ProjectDirs::from("", "", "boscage").map_or_else(
        || std::env::temp_dir().join("boscage"),
        |folders| folders.data_local_dir().to_owned(),
    )
}

/// Wakes the window that there is now; the studio's jobs hold it and outlive windows.
#[derive(Clone, Default)]
pub(super) struct Waker(Arc<Mutex<Option<Context>>>);

impl Waker {
    pub(super) fn wake(&self) {
        if let Some(window) = &*self.0.lock().unwrap_or_else(PoisonError::into_inner) {
            window.request_repaint();
        }
    }

    pub(super) fn belongs_to(&self, window: &Context) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(window.clone());
    }
}

/// What a window leaves to the next one.
pub(super) struct Left {
    pub(super) studio: Studio,
    pub(super) waker: Waker,
    /// Whether the window ended because its card was lost.
    pub(super) has_lost_card: bool,
}

/// The place where a window leaves its studio when it ends otherwise than by the user's will.
#[derive(Clone, Default)]
pub struct Session(Arc<Mutex<Option<Left>>>);

impl Session {
    /// Whether a studio waits for another window.
    pub fn goes_on(&self) -> bool {
        let left = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        left.as_ref().is_some_and(|left| left.has_lost_card)
    }

    pub(super) fn take(&self) -> Option<Left> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    pub(super) fn leave(&self, left: Left) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(left);
    }

    /// Writes what no file holds of the studio that was left, if there is one.
    fn rescue(&self) {
        if let Some(mut left) = self.take() {
            left.studio.rescue();
        }
    }
}
