//! The studio in a window of the desktop, and what outlives that window.
//!
//! When the graphics card is lost (its driver was reset or updated, the machine changed cards) nothing
//! can be drawn on its device any more, the window itself included. The window is closed then and
//! another is opened on a new device, with the same studio: project, undo, tools and jobs go on. Where
//! there is no card, or none that lasts, the processor draws the window. When the program fails
//! otherwise, what no file holds is written to the autosaves first.

use super::cpu_window;
use super::shell::Shell;
use super::studio::{Severity, Studio};
use crate::base::without_panics;
use crate::render::Backend;
use eframe::UserEvent;
use egui::Context;
use egui_winit::winit::application::ApplicationHandler;
use egui_winit::winit::event::WindowEvent;
use egui_winit::winit::event_loop::{ActiveEventLoop, EventLoop};
use egui_winit::winit::platform::run_on_demand::EventLoopExtRunOnDemand as _;
use egui_winit::winit::window::WindowId;
use std::cell::Cell;
use std::path::PathBuf;
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
    /// There is no card, though one was asked for.
    #[error("no graphics card can be used")]
    NoCard,
    /// The card was lost too often, though one was asked for.
    #[error("the graphics card is lost again and again")]
    Card,
}

/// Opens the studio and returns when it is closed. `files` are opened first. Without a `backend` the
/// graphics card draws where one can be used, and the processor elsewhere.
///
/// # Errors
/// [`StartError`]; what no file holds is in the autosaves then.
pub fn run(files: Vec<PathBuf>, backend: Option<Backend>) -> Result<(), StartError> {
    let session = Session::default();
    let start = Start {
        folder: own_folder(),
        files,
        session: session.clone(),
    };
    let ended = without_panics(|| windows(start, backend));
    session.rescue();
    ended.unwrap_or_else(|panicked| Err(StartError::Desktop(panicked.message)))
}

/// What a window begins with.
#[derive(Clone)]
struct Start {
    folder: PathBuf,
    files: Vec<PathBuf>,
    session: Session,
}

impl Start {
    fn storage(&self) -> PathBuf {
        self.folder.join("studio.ron")
    }

    fn recovery(&self) -> PathBuf {
        self.folder.join("recovery")
    }
}

/// How windows with a card ended.
enum Ended {
    /// The user closed the last one, or it failed.
    ForGood(Result<(), StartError>),
    /// No window could be drawn with a card.
    NoCard,
    /// Cards are lost as soon as they are used.
    LostAgain,
}

/// Shows one window after the other.
fn windows(mut start: Start, backend: Option<Backend>) -> Result<(), StartError> {
    let mut event_loop = EventLoop::with_user_event()
        .build()
        .map_err(|error| StartError::Window(error.to_string()))?;
    let ended = match backend {
        Some(Backend::Cpu) => None,
        _ => Some(card_windows(&mut event_loop, &mut start)),
    };
    let notice = match (ended, backend) {
        (None, _) => None,
        (Some(Ended::ForGood(ended)), _) => return ended,
        (Some(Ended::NoCard), Some(Backend::Gpu)) => return Err(StartError::NoCard),
        (Some(Ended::LostAgain), Some(Backend::Gpu)) => return Err(StartError::Card),
        (Some(Ended::NoCard), _) => Some("No graphics card can be used"),
        (Some(Ended::LostAgain), _) => Some("The graphics card is lost again and again"),
    };
    cpu_window::show(&mut event_loop, viewport(), start.storage(), |ctx, kept| {
        let recovery = start.recovery();
        let mut shell = Shell::begin(ctx, kept, None, recovery, start.files, start.session);
        if let Some(notice) = notice {
            let text = format!("{notice}; Boscage draws on the processor");
            shell.studio_mut().notify(Severity::Warning, text);
        }
        shell
    })
}

/// Shows windows that a card draws, as long as each loses it.
fn card_windows(event_loop: &mut EventLoop<UserEvent>, start: &mut Start) -> Ended {
    let mut lost = 0;
    loop {
        let begun = Instant::now();
        let (is_shown, closed) = card_window(event_loop, start);
        if !is_shown {
            return Ended::NoCard;
        }
        start.files.clear();
        if !start.session.goes_on() {
            return Ended::ForGood(closed);
        }
        lost = if begun.elapsed() < SOON { lost + 1 } else { 0 };
        if lost == MOST_LOST {
            return Ended::LostAgain;
        }
    }
}

/// Shows one window until it is closed, and whether it came to be seen. There is a desktop: only a card
/// that cannot be used, or a driver that fails, is in the way of that.
fn card_window(
    event_loop: &mut EventLoop<UserEvent>,
    start: &Start,
) -> (bool, Result<(), StartError>) {
    let options = eframe::NativeOptions {
        persistence_path: Some(start.storage()),
        viewport: viewport(),
        ..Default::default()
    };
    let is_shown = Cell::new(false);
    let Start { files, session, .. } = start.clone();
    let (recovery, begun) = (start.recovery(), &is_shown);
    let shell: eframe::AppCreator<'_> = Box::new(move |creation| {
        begun.set(true);
        Ok(Box::new(Shell::in_session(
            creation, recovery, files, session,
        )))
    });
    let closed = without_panics(|| {
        let mut window = eframe::create_native("boscage", options, shell, event_loop);
        event_loop.run_app_on_demand(&mut window)
    });
    let closed = match closed {
        Ok(closed) => closed.map_err(|error| StartError::Window(error.to_string())),
        Err(panicked) => {
            settle(event_loop);
            Err(StartError::Desktop(panicked.message))
        }
    };
    (is_shown.get(), closed)
}

/// Ends what a panic broke off: the event loop would not tell the next window that it may open.
fn settle(event_loop: &mut EventLoop<UserEvent>) {
    struct Ends;
    impl ApplicationHandler<UserEvent> for Ends {
        fn resumed(&mut self, _: &ActiveEventLoop) {}
        fn window_event(&mut self, _: &ActiveEventLoop, _: WindowId, _: WindowEvent) {}
        fn user_event(&mut self, event_loop: &ActiveEventLoop, _: UserEvent) {
            event_loop.exit();
        }
    }
    let wakes = UserEvent::RequestRepaint {
        viewport_id: egui::ViewportId::ROOT,
        when: Instant::now(),
        cumulative_pass_nr: 0,
    };
    // If that fails so does the next window.
    if event_loop.create_proxy().send_event(wakes).is_ok() {
        let _ = event_loop.run_app_on_demand(&mut Ends);
    }
}

/// The window as the desktop shall show it.
fn viewport() -> egui::ViewportBuilder {
    egui::ViewportBuilder::default()
        .with_app_id("boscage")
        .with_title("Boscage")
        .with_inner_size([1440.0, 900.0])
        .with_min_inner_size([960.0, 600.0])
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
