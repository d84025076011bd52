//! The studio's window where no graphics card can be used: the processor draws what egui wants shown,
//! and the desktop is given the finished picture.

mod canvas;
mod fill;
mod pixel;
mod storage;
mod textures;
mod window;

pub use canvas::Canvas;
pub use textures::Textures;

use super::run::StartError;
use super::shell::Shell;
use eframe::UserEvent;
use egui::{Context, ViewportBuilder};
use egui_winit::winit::application::ApplicationHandler;
use egui_winit::winit::event::WindowEvent;
use egui_winit::winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use egui_winit::winit::platform::run_on_demand::EventLoopExtRunOnDemand as _;
use egui_winit::winit::window::WindowId;
use std::path::PathBuf;
use window::CpuWindow;

/// Shows a window until it is closed. Preferences are kept in `storage`; `begin` makes the content.
///
/// # Errors
/// [`StartError::Window`]; what no file holds is in the autosaves then.
pub(super) fn show(
    event_loop: &mut EventLoop<UserEvent>,
    builder: ViewportBuilder,
    storage: PathBuf,
    begin: impl FnOnce(&Context, Option<&dyn eframe::Storage>) -> Shell,
) -> Result<(), StartError> {
    let proxy = event_loop.create_proxy();
    let open = |event_loop: &ActiveEventLoop| {
        CpuWindow::open(event_loop, proxy, builder, storage, Box::new(begin))
    };
    let mut shown = Shown {
        open: Some(Box::new(open)),
        window: None,
        failed: None,
    };
    let ended = event_loop.run_app_on_demand(&mut shown);
    if let Some(error) = shown.failed {
        return Err(error);
    }
    ended.map_err(|error| StartError::Window(error.to_string()))
}

type Open<'a> = Box<dyn FnOnce(&ActiveEventLoop) -> Result<CpuWindow, StartError> + 'a>;

/// The window as the event loop sees it.
struct Shown<'a> {
    /// Until the event loop runs.
    open: Option<Open<'a>>,
    /// Until it is closed.
    window: Option<CpuWindow>,
    failed: Option<StartError>,
}

impl Shown<'_> {
    fn end(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(mut window) = self.window.take() {
            window.save();
        }
        event_loop.exit();
    }

    fn fail(&mut self, event_loop: &ActiveEventLoop, error: StartError) {
        if let Some(window) = &mut self.window {
            window.rescue();
        }
        self.failed = Some(error);
        self.end(event_loop);
    }
}

impl ApplicationHandler<UserEvent> for Shown<'_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(open) = self.open.take() {
            match open(event_loop) {
                Ok(window) => self.window = Some(window),
                Err(error) => self.fail(event_loop, error),
            }
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, event: UserEvent) {
        if let Some(window) = &mut self.window {
            window.user_event(event);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(window) = &mut self.window else {
            return;
        };
        if let Err(error) = window.event(event_loop, &event) {
            self.fail(event_loop, error);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(window) = &mut self.window else {
            return;
        };
        let until = window.wait(event_loop);
        if window.closes() {
            return self.end(event_loop);
        }
        event_loop.set_control_flow(until.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }

    fn exiting(&mut self, event_loop: &ActiveEventLoop) {
        self.end(event_loop);
    }
}
