//! Hands that know nothing: random gestures in the studio without a screen. Whatever they do, the
//! project stays whole, undo and redo bring back exactly what was, and memory does not grow.
//!
//! The short run is part of the suite; `BOSCAGE_SOAK_GESTURES=28800 cargo test --test studio soak:: --
//! --ignored` is the long one, which also watches the memory (Linux only). A hand at work makes about
//! one gesture a second, so these are eight hours; without a screen they take less.

use crate::window;
use boscage::app::{Action, Answer, Command, MaskCommand, Shell, TABLE};
use boscage::base::{Random, Seed, return_free_memory};
use boscage::document::{CrownSettings, Edit, Tangent};
use egui::{Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2};
use egui::{TouchPhase, pos2, vec2};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};
use window::{Window, long_lived_window, open_sample, wait, with_sample};

/// Commands that leave the window for a dialog of the desktop or for good, or never rest.
const LEAVING: [Command; 10] = [
    Command::Open,
    Command::AddPhotos,
    Command::Save,
    Command::SaveAs,
    Command::Quit,
    Command::SavePicture,
    Command::Mask(MaskCommand::Import),
    Command::Mask(MaskCommand::Export),
    Command::ExportTrees,
    Command::Turntable,
];

/// How long is waited for a window that may never rest: a click may have started the turntable, or a
/// thousand trees.
const PATIENCE: Duration = Duration::from_secs(5);

/// The same where what it does must end: memory is measured then.
const MOST_OF_A_JOB: Duration = Duration::from_secs(120);

/// Of so many projects one has its crown made with every change: most of the time would go there.
const CROWNS_IN: u64 = 4;

/// Most growth of memory over a long run, in percent.
const MOST_GROWTH_PERCENT: f64 = 5.0;

#[test]
fn sixty_random_gestures_harm_nothing() {
    let (mut window, folder) = with_sample();
    let mut hand = Hand::new(1, folder.path());
    window
        .state_mut()
        .studio_mut()
        .act(Action::Do(Command::ToggleLiveCrown));
    for _ in 0..60 {
        hand.gesture(&mut window);
    }
    hand.look_closely(&mut window);
}

#[test]
#[ignore = "as many as BOSCAGE_SOAK_GESTURES says"]
fn random_gestures_for_hours_harm_nothing_and_need_no_more_memory() {
    let told = |name: &str, usual| std::env::var(name).map_or(usual, |text| text.parse().unwrap());
    let (wanted, seed) = (
        told("BOSCAGE_SOAK_GESTURES", 900),
        told("BOSCAGE_SOAK_SEED", 1),
    );
    let (mut window, folder, textures) = long_lived_window();
    open_sample(&mut window);
    let mut hand = Hand::new(seed, folder.path());
    hand.begin_again(&mut window);
    let start = Instant::now();
    let mut memory = Vec::new();
    while hand.gestures < wanted {
        // Enough to be about it, then a new project, and all jobs done: what is measured is what stays.
        for _ in 0..150 {
            hand.gesture(&mut window);
        }
        hand.look_closely(&mut window);
        hand.begin_again(&mut window);
        rests_within(&mut window, MOST_OF_A_JOB);
        return_free_memory();
        memory.push(resident_bytes());
        println!(
            "after {} gestures, {} s: {:.0} MB, textures {:.0} MB",
            hand.gestures,
            start.elapsed().as_secs(),
            resident_bytes() / 1e6,
            textures.load(Ordering::Relaxed) as f64 / 1e6,
        );
    }
    // The caches are full after a while: the first third does not count.
    let behind = &memory[memory.len() / 3..];
    let (early, late) = behind.split_at(behind.len() / 2);
    let growth = 100.0 * (median(late) / median(early) - 1.0);
    println!(
        "random gestures: {} in {} s, {} projects, memory {:.0} MB, then {:.0} MB: growth {growth:.1} %, all steps undone and redone to the bit",
        hand.gestures,
        start.elapsed().as_secs(),
        memory.len(),
        median(early) / 1e6,
        median(late) / 1e6,
    );
    assert!(growth < MOST_GROWTH_PERCENT, "{memory:?}");
}

fn median(values: &[f64]) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(1.0)
}

fn resident_bytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:"));
    let kilobytes = line.unwrap().split_whitespace().nth(1).unwrap();
    1024.0 * kilobytes.parse::<f64>().unwrap()
}

/// Whose gestures they are.
struct Hand {
    random: Random,
    gestures: u64,
    projects: u64,
    file: PathBuf,
    /// The sample, kept so that its pictures are told into crown and trunk once only.
    sample: PathBuf,
}

impl Hand {
    fn new(seed: u64, folder: &Path) -> Self {
        Self {
            random: Seed(seed).random(),
            gestures: 0,
            projects: 0,
            file: folder.join("soak.boscage"),
            sample: folder.join("sample.boscage"),
        }
    }

    /// One of all that a hand can do; then the project must be whole.
    fn gesture(&mut self, window: &mut Window) {
        match self.random.below(12) {
            0..=3 => self.drag(window),
            4 => self.click(window),
            5 => self.wheel(window),
            6..=7 => self.command(window),
            8 => self.history(window),
            9 => self.edit(window),
            10 => self.key(window),
            _ => self.save(window),
        }
        self.answer(window);
        window.step();
        self.gestures += 1;
        let document = window.state().studio().document();
        assert_eq!(document.complaint(), None, "gesture {}", self.gestures);
        if window.state().studio().is_empty() {
            self.begin_again(window);
        }
    }

    /// All the way back and forth again: the same project, to the bit.
    fn look_closely(&mut self, window: &mut Window) {
        window.key_press(Key::Escape);
        window.step();
        act(window, Action::EndGesture);
        if !rests(window) {
            return;
        }
        let now = window.state().studio().document().digest();
        let (undo, _) = window.state().studio().document().history_steps();
        for command in [Command::Undo, Command::Redo] {
            for _ in 0..undo {
                act(window, Action::Do(command));
            }
        }
        assert_eq!(window.state().studio().document().digest(), now);
        assert_eq!(window.state().studio().document().complaint(), None);
    }

    /// The sample project, whatever was there.
    fn begin_again(&mut self, window: &mut Window) {
        act(window, Action::EndGesture);
        rests(window);
        let is_first = !self.sample.is_file();
        if !is_first {
            act(window, Action::Open(vec![self.sample.clone()]));
        } else if window.state().studio().is_empty() {
            act(window, Action::Do(Command::OpenSample));
        }
        if window.state().studio().question().is_some() {
            act(window, Action::Answer(Answer::Anyway));
        }
        wait(window, |shell: &Shell| {
            let document = shell.studio().document();
            !shell.studio().is_empty() && document.history_steps() == (0, 0)
        });
        if is_first {
            act(window, Action::SaveTo(self.sample.clone()));
            let sample = self.sample.clone();
            wait(window, move |shell: &Shell| {
                shell.studio().file().path.as_deref() == Some(&sample)
            });
        }
        let wants_crown = self.projects.is_multiple_of(CROWNS_IN);
        if window.state().studio().preferences().live_crown != wants_crown {
            act(window, Action::Do(Command::ToggleLiveCrown));
        }
        self.projects += 1;
    }

    fn place(&mut self) -> Pos2 {
        pos2(
            self.random.between(0.0, 1440.0) as f32,
            self.random.between(60.0, 900.0) as f32,
        )
    }

    fn modifiers(&mut self) -> Modifiers {
        let all = [Modifiers::NONE, Modifiers::SHIFT, Modifiers::COMMAND];
        all[self.random.below(all.len())]
    }

    fn button(&mut self) -> PointerButton {
        match self.random.below(8) {
            0 => PointerButton::Secondary,
            1 => PointerButton::Middle,
            _ => PointerButton::Primary,
        }
    }

    fn drag(&mut self, window: &mut Window) {
        let (button, modifiers) = (self.button(), self.modifiers());
        let mut pos = self.place();
        window.event(Event::PointerMoved(pos));
        window.event(pressed(pos, button, true, modifiers));
        window.step();
        for _ in 0..self.random.below(8) {
            pos += vec2(
                self.random.between(-90.0, 90.0) as f32,
                self.random.between(-90.0, 90.0) as f32,
            );
            window.event(Event::PointerMoved(pos));
            window.step();
        }
        window.event(pressed(pos, button, false, modifiers));
    }

    fn click(&mut self, window: &mut Window) {
        let (pos, modifiers) = (self.place(), self.modifiers());
        window.event(Event::PointerMoved(pos));
        for down in [true, false] {
            window.event(pressed(pos, PointerButton::Primary, down, modifiers));
        }
    }

    fn wheel(&mut self, window: &mut Window) {
        let pos = self.place();
        window.event(Event::PointerMoved(pos));
        window.event(Event::MouseWheel {
            unit: MouseWheelUnit::Point,
            delta: vec2(0.0, self.random.between(-300.0, 300.0) as f32),
            phase: TouchPhase::Move,
            source: MouseWheelSource::Wheel,
            modifiers: self.modifiers(),
        });
    }

    fn command(&mut self, window: &mut Window) {
        let command = TABLE[self.random.below(TABLE.len())].command;
        if !LEAVING.contains(&command) && window.state().studio().can(command) {
            act(window, Action::Do(command));
        }
    }

    fn history(&mut self, window: &mut Window) {
        let command = [Command::Undo, Command::Redo][self.random.below(2)];
        for _ in 0..self.random.below(4) {
            act(window, Action::Do(command));
        }
    }

    fn edit(&mut self, window: &mut Window) {
        let Some(photo) = window.state().studio().shown() else {
            return;
        };
        let crown = CrownSettings {
            k: Tangent::Expression(format!("{:.2}", self.random.between(0.5, 4.0))),
            rho: self.random.between(0.0, 0.4),
            ..CrownSettings::default()
        };
        let edit = Edit::SetCrown(photo, Box::new(crown));
        let gesture = boscage::app::Gesture::Whole;
        let label = "Crown";
        act(
            window,
            Action::Edit {
                label,
                edit,
                gesture,
            },
        );
    }

    fn key(&mut self, window: &mut Window) {
        let keys = [
            Key::Escape,
            Key::Enter,
            Key::Tab,
            Key::Space,
            Key::ArrowLeft,
            Key::ArrowDown,
            Key::Backspace,
            Key::Delete,
        ];
        window.key_press(keys[self.random.below(keys.len())]);
    }

    /// Saves, and what was saved is what is there.
    fn save(&mut self, window: &mut Window) {
        act(window, Action::EndGesture);
        act(window, Action::SaveTo(self.file.clone()));
        self.answer(window);
        if !rests(window) {
            return;
        }
        let studio = window.state().studio();
        let (document, is_of_file) = (
            studio.document(),
            studio.file().path == Some(self.file.clone()),
        );
        // Another project may have come meanwhile, which no file holds.
        if is_of_file && !document.is_dirty() && !document.is_in_gesture() {
            let (saved, _) = boscage::document::store::open(&self.file).unwrap();
            assert_eq!(saved.document.digest(), document.digest());
        }
    }

    fn answer(&mut self, window: &mut Window) {
        if window.state().studio().question().is_some() {
            let answer = [Answer::Anyway, Answer::Cancel][self.random.below(2)];
            act(window, Action::Answer(answer));
        }
    }
}

/// Draws frames until no job is left, if that comes to pass.
fn rests(window: &mut Window) -> bool {
    rests_within(window, PATIENCE)
}

/// The same with another patience.
fn rests_within(window: &mut Window, patience: Duration) -> bool {
    let until = Instant::now() + patience;
    while window.state().studio().is_busy() && Instant::now() < until {
        std::thread::sleep(Duration::from_millis(10));
        window.step();
    }
    window.step();
    !window.state().studio().is_busy()
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
}

fn pressed(pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) -> Event {
    Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers,
    }
}
