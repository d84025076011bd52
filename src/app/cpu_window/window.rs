//! The window in which the processor draws: what eframe does for a window with a graphics card, as far
//! as the studio needs it.

use super::super::run::StartError;
use super::super::shell::Shell;
use super::canvas::Canvas;
use super::storage::Storage;
use super::textures::Textures;
use eframe::{App as _, Storage as _, UserEvent};
use egui::{Context, FullOutput, RawInput, ViewportBuilder, ViewportCommand, ViewportId};
use egui::{PlatformOutput, ViewportInfo};
use egui_winit::accesskit_winit;
use egui_winit::winit::event::WindowEvent;
use egui_winit::winit::event_loop::{ActiveEventLoop, EventLoopProxy, OwnedDisplayHandle};
use egui_winit::winit::window::Window;
use egui_winit::{ActionRequested, WindowGeometry, WindowSettings};
use std::io::Write as _;
use std::num::NonZeroU32;
use std::path::PathBuf;
use std::rc::Rc;
use std::time::{Duration, Instant};

/// Where nothing is drawn.
const GROUND: u32 = 0xff0c_0c0c;

/// The longest side of a texture, as graphics cards have it: pictures are cut for it anyway.
const LONGEST_SIDE: usize = 8192;

/// How long a hidden window may leave a frame undrawn until what is due is done without it.
const PATIENCE: Duration = Duration::from_millis(250);

/// Shortest times from frame to frame: after input, and when only a spinner turns. The jobs that it turns
/// for need the processor, too.
const AFTER_INPUT: Duration = Duration::from_millis(16);
const WITHOUT_INPUT: Duration = Duration::from_millis(33);

/// The names that eframe keeps things under.
const EGUI_MEMORY: &str = "egui";
const WINDOW: &str = "window";

/// Makes the content of a window.
pub(super) type Begin<'a> = Box<dyn FnOnce(&Context, Option<&dyn eframe::Storage>) -> Shell + 'a>;

/// The window and all that it needs.
pub(super) struct CpuWindow {
    shell: Shell,
    ctx: Context,
    window: Rc<Window>,
    winit: egui_winit::State,
    surface: softbuffer::Surface<OwnedDisplayHandle, Rc<Window>>,
    canvas: Canvas,
    textures: Textures,
    storage: Storage,
    saved: Instant,
    info: ViewportInfo,
    geometry: Option<WindowGeometry>,
    /// Input that no frame has seen yet.
    pending: RawInput,
    /// When the last frame began.
    last_frame: Instant,
    /// When the next one is due.
    next_frame: Option<Instant>,
    /// When the frame that was asked for is no longer waited for.
    overdue: Option<Instant>,
    closes: bool,
}

impl CpuWindow {
    /// A window that shows its first frame.
    pub(super) fn open(
        event_loop: &ActiveEventLoop,
        proxy: EventLoopProxy<UserEvent>,
        builder: ViewportBuilder,
        storage_path: PathBuf,
        begin: Begin<'_>,
    ) -> Result<Self, StartError> {
        let storage = Storage::at(storage_path);
        let ctx = context(&storage);
        let settings: Option<WindowSettings> = eframe::get_value(&storage, WINDOW);
        let window = window(event_loop, &ctx, builder, settings)?;
        let surface = softbuffer::Context::new(event_loop.owned_display_handle())
            .and_then(|context| softbuffer::Surface::new(&context, Rc::clone(&window)))
            .map_err(unshown)?;
        let mut winit = egui_winit::State::new(
            ctx.clone(),
            ViewportId::ROOT,
            event_loop,
            Some(window.scale_factor() as f32),
            event_loop.system_theme(),
            Some(LONGEST_SIDE),
        );
        winit.init_accesskit(event_loop, &window, proxy.clone());
        wake_by(&ctx, proxy);
        let mut info = ViewportInfo::default();
        egui_winit::update_viewport_info(&mut info, &ctx, &window, true);
        let pixels_per_point = egui_winit::pixels_per_point(&ctx, &window);
        ctx.input_mut(|input| {
            input.raw.viewports.insert(ViewportId::ROOT, info.clone());
            input.pixels_per_point = pixels_per_point;
        });
        let shell = begin(&ctx, Some(&storage));
        let mut opened = Self {
            shell,
            ctx,
            geometry: settings.map(|settings| settings.normal_geometry()),
            window,
            winit,
            surface,
            canvas: Canvas::default(),
            textures: Textures::default(),
            storage,
            saved: Instant::now(),
            info,
            pending: RawInput::default(),
            last_frame: Instant::now(),
            next_frame: None,
            overdue: None,
            closes: false,
        };
        // Shown once there is something to see.
        opened.frame(event_loop)?;
        if let Some(settings) = &settings {
            settings.before_first_show(&opened.window);
        }
        opened.window.set_visible(true);
        if let Some(settings) = &settings {
            settings.after_first_show(&opened.window);
        }
        opened.due_at(Instant::now());
        Ok(opened)
    }

    /// Whether the user has closed it.
    pub(super) fn closes(&self) -> bool {
        self.closes
    }

    /// Writes what is kept between sessions.
    pub(super) fn save(&mut self) {
        let settings =
            WindowSettings::from_window(self.ctx.zoom_factor(), &self.window, self.geometry);
        self.geometry = Some(settings.normal_geometry());
        eframe::set_value(&mut self.storage, WINDOW, &settings);
        self.ctx
            .memory(|memory| eframe::set_value(&mut self.storage, EGUI_MEMORY, memory));
        self.shell.save(&mut self.storage);
        self.storage.flush();
        self.saved = Instant::now();
    }

    /// Saves what no file holds of the project: the window cannot go on.
    pub(super) fn rescue(&mut self) {
        self.shell.studio_mut().rescue();
    }

    /// Takes an event of the desktop.
    pub(super) fn event(
        &mut self,
        event_loop: &ActiveEventLoop,
        event: &WindowEvent,
    ) -> Result<(), StartError> {
        match event {
            WindowEvent::RedrawRequested => return self.frame(event_loop),
            WindowEvent::CloseRequested => {
                self.info.events.push(egui::ViewportEvent::Close);
                self.due_at(Instant::now());
            }
            WindowEvent::Occluded(is_occluded) => self.info.occluded = Some(*is_occluded),
            _ => {}
        }
        if self.winit.on_window_event(&self.window, event).repaint {
            self.due_at(Instant::now());
        }
        Ok(())
    }

    /// Takes what somebody sent: a thread that wants a frame, or a reader of the screen.
    pub(super) fn user_event(&mut self, event: UserEvent) {
        match event {
            UserEvent::RequestRepaint {
                when,
                cumulative_pass_nr: asked_in,
                ..
            } => {
                let now_in = self.ctx.cumulative_pass_nr();
                // Older wishes are fulfilled.
                if now_in == asked_in || now_in == asked_in + 1 {
                    self.due_at(when);
                }
            }
            UserEvent::AccessKitActionRequest(request) => {
                match request.window_event {
                    accesskit_winit::WindowEvent::InitialTreeRequested => {
                        self.ctx.enable_accesskit();
                    }
                    accesskit_winit::WindowEvent::ActionRequested(request) => {
                        self.winit.on_accesskit_action_request(request);
                    }
                    accesskit_winit::WindowEvent::AccessibilityDeactivated => {
                        self.ctx.disable_accesskit();
                        return;
                    }
                }
                self.due_at(Instant::now());
            }
        }
    }

    fn due_at(&mut self, when: Instant) {
        self.next_frame = Some(self.next_frame.map_or(when, |next| next.min(when)));
    }

    /// Asks for the frame that is due, and returns when to look again; `None` when an event must come.
    pub(super) fn wait(&mut self, event_loop: &ActiveEventLoop) -> Option<Instant> {
        let now = Instant::now();
        let pause = match self.winit.egui_input().events.is_empty() {
            true => WITHOUT_INPUT,
            false => AFTER_INPUT,
        };
        self.next_frame = self
            .next_frame
            .map(|when| when.max(self.last_frame + pause));
        if self.next_frame.is_some_and(|when| when <= now) {
            self.next_frame = None;
            self.overdue.get_or_insert(now + PATIENCE);
            self.window.request_redraw();
        }
        if self.overdue.is_some_and(|when| when <= now) {
            self.overdue = None;
            self.hidden_frame(event_loop);
        }
        match (self.next_frame, self.overdue) {
            (Some(one), Some(other)) => Some(one.min(other)),
            (one, other) => one.or(other),
        }
    }

    fn input(&mut self) -> RawInput {
        egui_winit::update_viewport_info(&mut self.info, &self.ctx, &self.window, false);
        let mut input = std::mem::take(&mut self.pending);
        input.append(self.winit.take_egui_input(&self.window));
        input.viewports = std::iter::once((ViewportId::ROOT, self.info.take())).collect();
        input
    }

    /// Runs the studio and shows what it looks like.
    fn frame(&mut self, event_loop: &ActiveEventLoop) -> Result<(), StartError> {
        self.last_frame = Instant::now();
        self.overdue = None;
        let input = self.input();
        let is_asked_to_close = input.viewport().close_requested();
        let shell = &mut self.shell;
        let FullOutput {
            platform_output,
            mut textures_delta,
            shapes,
            pixels_per_point,
            viewport_output,
        } = self.ctx.run_ui(input, |ui| {
            shell.think(ui.ctx());
            shell.show(ui);
        });
        let begun = Instant::now();
        self.textures.set(&mut textures_delta);
        let primitives = self.ctx.tessellate(shapes, pixels_per_point);
        let size = self.window.inner_size();
        let size = (size.width, size.height);
        let canvas = &mut self.canvas;
        let rows = canvas.draw(size, pixels_per_point, &primitives, &self.textures, GROUND);
        self.textures.free(&mut textures_delta);
        self.present().map_err(unshown)?;
        if self.shell.traces_frames() {
            trace_drawing(rows, begun.elapsed());
        }
        let commands = viewport_output.into_values().flat_map(|of| of.commands);
        self.answer(
            event_loop,
            platform_output,
            commands.collect(),
            is_asked_to_close,
        );
        if self.saved.elapsed() > self.shell.auto_save_interval() {
            self.save();
        }
        Ok(())
    }

    /// Does what is due while nobody sees the window: autosaves, the outcomes of jobs.
    fn hidden_frame(&mut self, event_loop: &ActiveEventLoop) {
        let input = self.input();
        let is_asked_to_close = input.viewport().close_requested();
        let shell = &mut self.shell;
        let output = self.ctx.run_logic(&input, |ctx| shell.think(ctx));
        self.pending = input;
        let commands = output.viewport_commands.into_values().flatten().collect();
        self.answer(
            event_loop,
            output.platform_output,
            commands,
            is_asked_to_close,
        );
    }

    /// Does what the frame asked of the desktop.
    fn answer(
        &mut self,
        event_loop: &ActiveEventLoop,
        output: PlatformOutput,
        commands: Vec<ViewportCommand>,
        is_asked_to_close: bool,
    ) {
        let (window, winit) = (&self.window, &mut self.winit);
        winit.handle_platform_output_with_event_loop(window, event_loop, output);
        self.closes |= is_asked_to_close && !commands.contains(&ViewportCommand::CancelClose);
        let mut actions = Vec::new();
        let events = self.info.events.len();
        egui_winit::process_viewport_commands(
            &self.ctx,
            &mut self.info,
            commands,
            window,
            &mut actions,
        );
        let mut goes_on = self.info.events.len() > events;
        for action in actions {
            goes_on |= self.clipboard(&action);
        }
        if goes_on {
            self.due_at(Instant::now());
        }
    }

    /// Whether the next frame has something to see.
    fn clipboard(&mut self, action: &ActionRequested) -> bool {
        let event = match action {
            ActionRequested::Cut => Some(egui::Event::Cut),
            ActionRequested::Copy => Some(egui::Event::Copy),
            ActionRequested::Paste => self
                .winit
                .clipboard_text()
                .filter(|text| !text.is_empty())
                .map(|text| egui::Event::Paste(text.replace("\r\n", "\n"))),
            // Nothing in the studio asks for them.
            ActionRequested::Screenshot(_) | ActionRequested::PaintWhileHidden => None,
        };
        let is_any = event.is_some();
        self.winit.egui_input_mut().events.extend(event);
        is_any
    }

    fn present(&mut self) -> Result<(), softbuffer::SoftBufferError> {
        let (width, height) = self.canvas.size();
        let (Some(width), Some(height)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        self.surface.resize(width, height)?;
        let mut buffer = self.surface.buffer_mut()?;
        // No window of ours is transparent: nobody looks at the highest byte.
        buffer.copy_from_slice(self.canvas.pixels());
        self.window.pre_present_notify();
        buffer.present()
    }
}

/// Tells how many rows of pixels a frame drew and how many microseconds that took, beside what the
/// studio tells of itself.
fn trace_drawing(rows: usize, took: Duration) {
    // Nobody may listen.
    let _ = writeln!(std::io::stderr(), "drawn {rows} {}", took.as_micros());
}

fn unshown(error: softbuffer::SoftBufferError) -> StartError {
    StartError::Window(error.to_string())
}

/// As eframe makes it.
fn context(storage: &Storage) -> Context {
    let ctx = Context::default();
    ctx.options_mut(|options| options.max_passes = std::num::NonZeroUsize::MIN.saturating_add(1));
    if let Some(memory) = eframe::get_value(storage, EGUI_MEMORY) {
        ctx.memory_mut(|kept| *kept = memory);
    }
    ctx
}

/// A window that is not shown yet, where and as large as the last one was.
fn window(
    event_loop: &ActiveEventLoop,
    ctx: &Context,
    builder: ViewportBuilder,
    settings: Option<WindowSettings>,
) -> Result<Rc<Window>, StartError> {
    let zoom = ctx.zoom_factor();
    let mut builder = builder.with_visible(false);
    if let Some(mut settings) = settings {
        settings.clamp_size_to_sane_values(largest_screen(event_loop, zoom));
        settings.clamp_position_to_monitors(zoom, event_loop);
        builder = settings.initialize_viewport_builder(zoom, builder);
    } else if let Some(size) = builder.inner_size {
        builder = builder.with_inner_size(size.min(largest_screen(event_loop, zoom)));
    }
    let window = egui_winit::create_window(ctx, event_loop, &builder)
        .map_err(|error| StartError::Window(error.to_string()))?;
    if let Some(settings) = settings {
        settings.initialize_window(&window);
    }
    Ok(Rc::new(window))
}

/// The size of the largest screen, points.
fn largest_screen(event_loop: &ActiveEventLoop, zoom: f32) -> egui::Vec2 {
    let sizes = event_loop.available_monitors().map(|monitor| {
        let size = monitor
            .size()
            .to_logical::<f32>(f64::from(zoom) * monitor.scale_factor());
        egui::vec2(size.width, size.height)
    });
    let largest = sizes.fold(egui::Vec2::ZERO, egui::Vec2::max);
    if largest == egui::Vec2::ZERO {
        egui::Vec2::splat(16_000.0)
    } else {
        largest
    }
}

/// Lets any thread that asks `ctx` for a frame wake the event loop.
fn wake_by(ctx: &Context, proxy: EventLoopProxy<UserEvent>) {
    ctx.set_request_repaint_callback(move |wish| {
        let wish = UserEvent::RequestRepaint {
            viewport_id: wish.viewport_id,
            when: Instant::now() + wish.delay,
            cumulative_pass_nr: wish.current_cumulative_pass_nr,
        };
        // The window may be closed already.
        let _ = proxy.send_event(wish);
    });
}
