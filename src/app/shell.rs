//! The window: menus, workspaces, panels, the line at the bottom, and what lies over them.

use super::action::{Action, Answer};
use super::commands::{Command, Menu, TABLE};
use super::dock::{Layouts, Pane};
use super::files::{FileDialogs, Purpose};
use super::make_dialog::MakeDialog;
use super::panels::Panels;
use super::preferences::Preferences;
use super::run::{Left, Session, Waker};
use super::studio::{Effect, Next, Question, Severity, Studio, Workspace};
use super::theme::{self, GAP, TIGHT, dialog, tokens};
use super::{palette, shortcut_sheet, start, tour};
use crate::segment::Runtime;
use eframe::egui_wgpu::RenderState;
use egui::{Context, RichText, Ui, ViewportCommand};
use std::io::Write as _;
use std::path::PathBuf;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// The window and the studio in it.
pub struct Shell {
    studio: Studio,
    layouts: Layouts,
    panels: Panels,
    dialogs: FileDialogs,
    make_dialog: MakeDialog,
    palette: palette::Palette,
    shows_shortcuts: bool,
    shows_about: bool,
    tour: tour::Tour,
    title: String,
    /// Whether [`TRACE`] is set.
    traces_frames: bool,
    /// When the frame in progress began.
    frame_begun: Instant,
    /// What draws, for *About*.
    adapter: String,
    waker: Waker,
    session: Session,
    has_lost_card: bool,
}

/// The variable that makes the studio tell of its frames.
const TRACE: &str = "BOSCAGE_TRACE_FRAMES";

const PREFERENCES: &str = "preferences";
const LAYOUTS: &str = "layouts";

impl Shell {
    /// The window's content. Autosaves lie below `recovery_folder`; `files` are opened first.
    pub fn new(
        creation: &eframe::CreationContext<'_>,
        recovery_folder: PathBuf,
        files: Vec<PathBuf>,
    ) -> Self {
        Self::in_session(creation, recovery_folder, files, Session::default())
    }

    /// As [`Shell::new`], but with the studio of the window before, if that was lost.
    pub fn in_session(
        creation: &eframe::CreationContext<'_>,
        recovery_folder: PathBuf,
        files: Vec<PathBuf>,
        session: Session,
    ) -> Self {
        let (ctx, kept) = (&creation.egui_ctx, creation.storage);
        let card = creation.wgpu_render_state.as_ref();
        Self::begin(ctx, kept, card, recovery_folder, files, session)
    }

    /// As [`Shell::in_session`], in any window: what it `kept` from the last session, and the `card` that
    /// it is drawn with, if that is one.
    pub(super) fn begin(
        ctx: &Context,
        kept: Option<&dyn eframe::Storage>,
        card: Option<&RenderState>,
        recovery_folder: PathBuf,
        files: Vec<PathBuf>,
        session: Session,
    ) -> Self {
        theme::install(ctx);
        let layouts: Option<Layouts> = kept.and_then(|kept| eframe::get_value(kept, LAYOUTS));
        let (mut studio, waker) = match session.take() {
            Some(left) => (left.studio, left.waker),
            None => begun(kept, recovery_folder),
        };
        waker.belongs_to(ctx);
        if !files.is_empty() {
            studio.act(Action::Open(files));
        }
        let adapter = card.map_or("the processor".to_owned(), |card| {
            let info = card.adapter.get_info();
            format!("{} ({})", info.name, info.backend)
        });
        Self {
            studio,
            layouts: layouts.filter(Layouts::is_complete).unwrap_or_default(),
            panels: Panels::new(card),
            dialogs: FileDialogs::default(),
            make_dialog: MakeDialog::default(),
            palette: palette::Palette::default(),
            shows_shortcuts: false,
            shows_about: false,
            tour: tour::Tour::default(),
            title: String::new(),
            traces_frames: std::env::var_os(TRACE).is_some(),
            frame_begun: Instant::now(),
            adapter,
            waker,
            session,
            has_lost_card: false,
        }
    }

    /// The studio in the window.
    pub fn studio(&self) -> &Studio {
        &self.studio
    }

    /// The studio in the window, for tests to do what a user does.
    pub fn studio_mut(&mut self) -> &mut Studio {
        &mut self.studio
    }

    /// Whether the 3D view shows the finished crown as finely as it will.
    pub fn view_is_final(&self) -> bool {
        self.studio.crown_is_final() && self.panels.view_is_final()
    }

    /// Whether what the window is drawn with was lost: it closes, and leaves its studio to another.
    pub fn has_lost_card(&self) -> bool {
        self.has_lost_card
    }

    /// Whether frames are told of.
    pub(super) fn traces_frames(&self) -> bool {
        self.traces_frames
    }

    /// Closes the window once its card is lost.
    fn watch_card(&mut self, ctx: &Context) {
        if !self.has_lost_card && self.panels.has_lost_card() {
            self.has_lost_card = true;
            self.studio.act(Action::EndGesture);
            ctx.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    fn perform(&mut self, effect: Effect, ctx: &Context) {
        match effect {
            Effect::AskWhatToOpen => self.dialogs.ask(Purpose::Open, ctx),
            Effect::AskWhereToSave => self.dialogs.ask(Purpose::Save, ctx),
            Effect::AskWhichRuntime => self.dialogs.ask(Purpose::Runtime, ctx),
            Effect::AskWhichModel => self.dialogs.ask(Purpose::Model, ctx),
            Effect::AskWhichMask => self.dialogs.ask(Purpose::ImportMask, ctx),
            Effect::AskWhereToExportMask => self.dialogs.ask(Purpose::ExportMask, ctx),
            Effect::ZoomToFit | Effect::ZoomToPixels | Effect::ZoomBy(_) | Effect::FrameTree => {
                self.panels.perform(&effect);
            }
            Effect::AskForFolder => self.dialogs.ask(Purpose::Folder, ctx),
            Effect::AskWhatToMake(command) => self.make_dialog.open(command, &self.studio),
            Effect::AskWhereToSavePicture => self.dialogs.ask(Purpose::Picture, ctx),
            Effect::RestoreLayout => self.layouts = Layouts::default(),
            Effect::TogglePalette => self.palette.toggle(),
            Effect::ToggleShortcutSheet => self.shows_shortcuts = !self.shows_shortcuts,
            Effect::StartTour => self.tour.start(),
            Effect::ToggleAbout => self.shows_about = !self.shows_about,
            Effect::Quit => ctx.send_viewport_cmd(ViewportCommand::Close),
        }
    }

    fn keep_title(&mut self, ctx: &Context) {
        let title = self.studio.title();
        if title != self.title {
            ctx.send_viewport_cmd(ViewportCommand::Title(title.clone()));
            self.title = title;
        }
    }

    fn draw(&mut self, ui: &mut Ui, actions: &mut Vec<Action>) {
        egui::Panel::top("menu bar").show(ui, |ui| menu_bar(ui, &self.studio, actions));
        egui::Panel::bottom("status").show(ui, |ui| status(ui, &self.studio, actions));
        let frame = egui::Frame::NONE.fill(tokens(ui).ground);
        egui::CentralPanel::default().frame(frame).show(ui, |ui| {
            if self.studio.is_empty() {
                start::show(ui, &self.studio, actions);
                return;
            }
            let mut docked = Docked {
                panels: &mut self.panels,
                studio: &self.studio,
                actions,
            };
            self.layouts.of(self.studio.workspace).ui(&mut docked, ui);
        });
    }

    fn draw_over(&mut self, ctx: &Context, actions: &mut Vec<Action>) {
        self.palette.show(ctx, &self.studio, actions);
        self.make_dialog.show(ctx, &self.studio, actions);
        self.dialogs.show(ctx, actions);
        if self.shows_shortcuts {
            shortcut_sheet::show(ctx, &mut self.shows_shortcuts);
        }
        if self.shows_about {
            about(ctx, &self.adapter, &mut self.shows_about);
        }
        self.tour.show(ctx, &self.studio, actions);
        if let Some(question) = self.studio.question() {
            ask(ctx, question, actions);
        }
    }
}

impl Shell {
    /// What a frame begins with, and what is due while nobody sees the window.
    pub(super) fn think(&mut self, ctx: &Context) {
        self.frame_begun = Instant::now();
        self.studio.take_outcomes();
        let may_close = self.has_lost_card || !self.studio.may_not_close();
        if ctx.input(|input| input.viewport().close_requested()) && !may_close {
            ctx.send_viewport_cmd(ViewportCommand::CancelClose);
            self.studio.act(Action::Do(Command::Quit));
        }
        let came_back = ctx.input(|input| {
            let focused = |event: &egui::Event| matches!(event, egui::Event::WindowFocused(true));
            input.events.iter().any(focused)
        });
        if came_back {
            self.studio.look_at_file();
        }
        // An autosave is due even when nobody touches anything; nothing else needs the time.
        if let Some(wait) = self.studio.autosave_due_in() {
            ctx.request_repaint_after(wait);
        }
    }

    /// Draws the window, then does what the user asked for.
    pub(super) fn show(&mut self, ui: &mut Ui) {
        let ctx = ui.ctx().clone();
        #[cfg(debug_assertions)]
        lose_card(&ctx, &self.panels);
        self.watch_card(&ctx);
        let theme = if self.studio.preferences.is_dark {
            egui::Theme::Dark
        } else {
            egui::Theme::Light
        };
        if ctx.theme() != theme {
            ctx.set_theme(theme);
        }
        self.keep_title(&ctx);
        let mut actions = Vec::new();
        let is_free = self.studio.question().is_none();
        if is_free {
            shortcuts(&ctx, &self.studio, &mut actions);
            dropped(&ctx, &mut actions);
        }
        self.draw(ui, &mut actions);
        self.draw_over(&ctx, &mut actions);
        let did_something = !actions.is_empty();
        for action in actions {
            self.studio.act(action);
        }
        for effect in std::mem::take(&mut self.studio.effects) {
            self.perform(effect, &ctx);
        }
        if self.traces_frames {
            trace_frame(&ctx, self.frame_begun.elapsed());
        }
        if did_something {
            // What was done is seen in the next frame.
            ctx.request_repaint();
        }
    }
}

impl eframe::App for Shell {
    fn logic(&mut self, ctx: &Context, _: &mut eframe::Frame) {
        self.think(ctx);
    }

    fn ui(&mut self, ui: &mut Ui, _: &mut eframe::Frame) {
        self.show(ui);
    }

    fn save(&mut self, storage: &mut dyn eframe::Storage) {
        eframe::set_value(storage, PREFERENCES, &self.studio.preferences);
        eframe::set_value(storage, LAYOUTS, &self.layouts);
    }
}

impl Drop for Shell {
    /// Leaves the studio behind where it shall go on, or where the program failed.
    fn drop(&mut self) {
        if self.has_lost_card || std::thread::panicking() {
            let nothing = Studio::new(Preferences::default(), PathBuf::new(), || {});
            self.session.leave(Left {
                studio: std::mem::replace(&mut self.studio, nothing),
                waker: self.waker.clone(),
                has_lost_card: self.has_lost_card,
            });
        }
    }
}

/// A new studio with the preferences that were kept, and what wakes its window.
fn begun(kept: Option<&dyn eframe::Storage>, recovery_folder: PathBuf) -> (Studio, Waker) {
    let preferences: Preferences = kept
        .and_then(|kept| eframe::get_value(kept, PREFERENCES))
        .unwrap_or_default();
    // Heard unless the command line named one.
    Runtime::choose(preferences.onnx_runtime.as_deref());
    let waker = Waker::default();
    let wakes = waker.clone();
    let studio = Studio::new(preferences, recovery_folder, move || wakes.wake());
    (studio, waker)
}

/// Loses the card in the frame that `BOSCAGE_LOSE_CARD` says, for trying out what becomes of the window.
#[cfg(debug_assertions)]
fn lose_card(ctx: &Context, panels: &Panels) {
    let when = std::env::var("BOSCAGE_LOSE_CARD").ok();
    let Some(when) = when.and_then(|text| text.parse::<u64>().ok()) else {
        return;
    };
    ctx.request_repaint();
    if ctx.cumulative_frame_nr() == when {
        panels.lose_card();
    }
}

/// Tells when a frame was made, in microseconds since 1970, how much input it saw and how many
/// microseconds it took: for scripts that measure how soon the window answers.
fn trace_frame(ctx: &Context, took: Duration) {
    let now = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .unwrap_or_default();
    let events = ctx.input(|input| input.events.len());
    // Nobody may listen.
    let (now, took) = (now.as_micros(), took.as_micros());
    let _ = writeln!(std::io::stderr(), "frame {now} {events} {took}");
}

/// The panels of the present workspace.
struct Docked<'a> {
    panels: &'a mut Panels,
    studio: &'a Studio,
    actions: &'a mut Vec<Action>,
}

impl egui_tiles::Behavior<Pane> for Docked<'_> {
    fn pane_ui(
        &mut self,
        ui: &mut Ui,
        _: egui_tiles::TileId,
        pane: &mut Pane,
    ) -> egui_tiles::UiResponse {
        let fill = tokens(ui).panel;
        ui.painter().rect_filled(ui.max_rect(), 0.0, fill);
        self.panels.show(*pane, ui, self.studio, self.actions);
        egui_tiles::UiResponse::None
    }

    fn tab_title_for_pane(&mut self, pane: &Pane) -> egui::WidgetText {
        pane.title().into()
    }

    fn gap_width(&self, _: &egui::Style) -> f32 {
        3.0
    }

    fn simplification_options(&self) -> egui_tiles::SimplificationOptions {
        egui_tiles::SimplificationOptions {
            all_panes_must_have_tabs: true,
            ..Default::default()
        }
    }
}

/// Keys of commands. While somebody types, only those with Ctrl count.
fn shortcuts(ctx: &Context, studio: &Studio, actions: &mut Vec<Action>) {
    let is_typing = ctx.egui_wants_keyboard_input();
    // `Y` redoes too: hands from other programs know it.
    let redo = egui::KeyboardShortcut::new(egui::Modifiers::COMMAND, egui::Key::Y);
    if ctx.input_mut(|input| input.consume_shortcut(&redo)) {
        actions.push(Action::Do(Command::Redo));
    }
    // `+` stands above `=` on many keyboards.
    if !is_typing
        && ctx.input_mut(|input| input.consume_key(egui::Modifiers::NONE, egui::Key::Equals))
    {
        actions.push(Action::Do(Command::ZoomIn));
    }
    // Those with more modifiers first, or Ctrl+S would take Ctrl+Shift+S.
    let mut rows: Vec<_> = TABLE.iter().collect();
    rows.sort_by_key(|row| std::cmp::Reverse(row.shortcut.modifiers.shift));
    for row in rows {
        let is_plain = !row.shortcut.modifiers.command;
        if (is_plain && is_typing) || !studio.can(row.command) {
            continue;
        }
        if ctx.input_mut(|input| input.consume_shortcut(&row.shortcut)) {
            actions.push(Action::Do(row.command));
        }
    }
}

fn dropped(ctx: &Context, actions: &mut Vec<Action>) {
    let paths: Vec<PathBuf> = ctx.input(|input| {
        input
            .raw
            .dropped_files
            .iter()
            .map(|file| file.path().to_owned())
            .collect()
    });
    if !paths.is_empty() {
        actions.push(Action::Open(paths));
    }
}

fn menu_bar(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    egui::MenuBar::new().ui(ui, |ui| {
        for menu in Menu::ALL {
            let rows = || TABLE.iter().filter(|row| row.menu == menu);
            if rows().next().is_none() {
                continue;
            }
            ui.menu_button(menu.title(), |ui| {
                for row in rows() {
                    if menu_item(ui, studio, row.command).clicked() {
                        actions.push(Action::Do(row.command));
                        ui.close();
                    }
                }
                if menu == Menu::File {
                    recent(ui, studio, actions);
                }
            });
        }
        ui.add_space(2.0 * GAP);
        for workspace in Workspace::ALL {
            let is_on = studio.workspace == workspace;
            let title = workspace.title();
            let help = Command::Show(workspace).row().help;
            if ui
                .selectable_label(is_on, title)
                .on_hover_text(help)
                .clicked()
            {
                actions.push(Action::Workspace(workspace));
            }
        }
    });
}

fn menu_item(ui: &mut Ui, studio: &Studio, command: Command) -> egui::Response {
    let row = command.row();
    let label = studio.label_of(command);
    let keys = ui.ctx().format_shortcut(&row.shortcut);
    let button = egui::Button::new(label).shortcut_text(keys);
    ui.add_enabled(studio.can(command), button)
        .on_hover_text(row.help)
}

fn recent(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.menu_button("Open Recent", |ui| {
        if studio.preferences.recent.is_empty() {
            ui.weak("Nothing yet");
        }
        for path in &studio.preferences.recent {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if ui
                .button(name)
                .on_hover_text(path.display().to_string())
                .clicked()
            {
                actions.push(Action::Open(vec![path.clone()]));
                ui.close();
            }
        }
    });
}

/// What is going on, and what the user should know.
fn status(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    ui.horizontal(|ui| {
        ui.set_min_height(22.0);
        let jobs = studio.jobs.snapshot();
        if let Some(job) = jobs.first() {
            ui.add(egui::Spinner::new().size(14.0));
            ui.weak(&job.name);
            if jobs.len() > 1 {
                ui.weak(format!("and {} more", jobs.len() - 1));
            }
        } else if let Some(photo) = studio
            .shown()
            .and_then(|id| studio.document().state().content().photos.get(&id))
        {
            ui.weak(format!(
                "{} · {} × {} px",
                photo.name, photo.width, photo.height
            ));
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for notice in studio.notices().iter().rev() {
                let color = match notice.severity {
                    Severity::Info => tokens(ui).weak,
                    Severity::Warning => tokens(ui).warning,
                    Severity::Error => tokens(ui).error,
                };
                let text = RichText::new(&notice.text).color(color);
                let button = egui::Button::new(text).frame(false).truncate();
                let response = ui.add(button);
                if response
                    .on_hover_text(format!("{}\nClick to dismiss.", notice.text))
                    .clicked()
                {
                    actions.push(Action::DismissNotice(notice.id));
                }
            }
        });
    });
}

fn ask(ctx: &Context, question: &Question, actions: &mut Vec<Action>) {
    let (heading, text, save, anyway) = match question {
        Question::Unsaved(next) => {
            let anyway = if *next == Next::Quit {
                "Quit Without Saving"
            } else {
                "Do Not Save"
            };
            (
                "Save the changes?",
                "The project has changes that no file holds.".to_owned(),
                "Save",
                anyway,
            )
        }
        Question::ChangedOnDisk(path) => {
            let text = format!(
                "{} was changed by another program since it was opened. Saving writes over those changes.",
                path.display()
            );
            ("The file has changed", text, "Save As…", "Write Over")
        }
    };
    let modal = dialog(ctx, "question").show(ctx, |ui| {
        ui.set_width(420.0);
        ui.heading(heading);
        ui.add_space(TIGHT);
        ui.label(text);
        ui.add_space(2.0 * GAP);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            for (label, answer) in [
                (save, Answer::Save),
                (anyway, Answer::Anyway),
                ("Cancel", Answer::Cancel),
            ] {
                if ui.button(label).clicked() {
                    actions.push(Action::Answer(answer));
                }
            }
        });
    });
    if modal.should_close() {
        actions.push(Action::Answer(Answer::Cancel));
    }
}

fn about(ctx: &Context, adapter: &str, is_open: &mut bool) {
    let modal = dialog(ctx, "about").show(ctx, |ui| {
        ui.set_width(380.0);
        ui.heading("Boscage");
        ui.label(format!("Version {}", env!("CARGO_PKG_VERSION")));
        ui.add_space(GAP);
        ui.label("Turns a few tree pictures into any number of new trees.");
        ui.add_space(GAP);
        ui.weak(format!("Draws with {adapter}"));
        ui.weak(format!("Licence: {}", env!("CARGO_PKG_LICENSE")));
        ui.add_space(GAP);
        if ui.button("Close").clicked() {
            ui.close();
        }
    });
    if modal.should_close() {
        *is_open = false;
    }
}
