//! The canvas without a screen: the pointer and the keys drive the real window, and what they should
//! have done is looked up in the project.

use crate::reference;
use boscage::app::{
    Action, Command, MaskAction, MaskCommand, Overlay, Pen, Shell, Studio, Tool, ToolOption,
};
use boscage::base::{Digest, Seed};
use boscage::document::{Edit, NewPhoto};
use boscage::paint::{BACKGROUND, CROWN, Sample, TRUNK, TiledMask};
use boscage::raster::{Compression, Image, Straight, encode_png};
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, Vec2, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use std::path::PathBuf;
use std::time::{Duration, Instant};

type Window = Harness<'static, Shell>;

/// A window on these pictures, whose autosaves lie in a folder that is gone afterwards.
fn window(files: Vec<PathBuf>) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let mut window = Harness::builder()
        .with_size([1440.0, 900.0])
        .with_max_steps(64)
        .build_eframe(move |creation| Shell::new(creation, recovery, files));
    // Crowns would take most of the time, and are another test's matter.
    let studio = window.state_mut().studio_mut();
    studio.act(Action::Do(Command::ToggleLiveCrown));
    wait(&mut window, |shell| !shell.studio().is_empty());
    settle(&mut window);
    (window, folder)
}

/// A window on a generated picture.
fn window_on(picture: &Image<Straight>) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("disc.png");
    std::fs::write(&file, encode_png(picture, Compression::Fast)).unwrap();
    let (window, _) = window(vec![file]);
    (window, folder)
}

/// Draws frames until `is_so`, for jobs take their time.
fn wait(window: &mut Window, is_so: impl Fn(&Shell) -> bool) {
    let until = Instant::now() + Duration::from_secs(120);
    while !is_so(window.state()) {
        assert!(Instant::now() < until, "what was waited for did not happen");
        std::thread::sleep(Duration::from_millis(5));
        window.step();
    }
    window.step();
}

/// Waits until no job runs and all results are taken up.
fn settle(window: &mut Window) {
    window.step();
    wait(window, |shell| !shell.studio().is_waiting());
    window.step();
    assert_eq!(studio(window).document().complaint(), None);
}

fn studio(window: &Window) -> &Studio {
    window.state().studio()
}

fn digest(window: &Window) -> Digest {
    studio(window).document().digest()
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    settle(window);
}

fn mask(window: &Window) -> &TiledMask {
    studio(window).shown_mask().unwrap()
}

/// Where a place of the fitted picture is on the screen.
fn on_screen(window: &Window, x: f32, y: f32) -> Pos2 {
    let rect = window.get_by_role_and_label(Role::Image, "Canvas").rect();
    let mask = mask(window);
    let size = vec2(mask.width() as f32, mask.height() as f32);
    let zoom = (rect.width() / size.x).min(rect.height() / size.y) * 0.94;
    rect.center() + (vec2(x, y) - size / 2.0) * zoom
}

fn button(pos: Pos2, button: PointerButton, pressed: bool, modifiers: Modifiers) -> Event {
    Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers,
    }
}

/// Drags over these places of the picture.
fn drag_with(window: &mut Window, which: PointerButton, modifiers: Modifiers, way: &[(f32, f32)]) {
    let places: Vec<Pos2> = way.iter().map(|&(x, y)| on_screen(window, x, y)).collect();
    window.event(Event::ModifiersChanged(modifiers));
    window.event(Event::PointerMoved(places[0]));
    window.step();
    window.event(button(places[0], which, true, modifiers));
    window.step();
    for &place in &places[1..] {
        window.event(Event::PointerMoved(place));
        window.step();
    }
    window.event(button(places[places.len() - 1], which, false, modifiers));
    window.event(Event::ModifiersChanged(Modifiers::NONE));
    settle(window);
}

fn drag(window: &mut Window, way: &[(f32, f32)]) {
    drag_with(window, PointerButton::Primary, Modifiers::NONE, way);
}

fn click(window: &mut Window, x: f32, y: f32) {
    drag(window, &[(x, y)]);
    // Two clicks far apart in time are no double click.
    for _ in 0..24 {
        window.step();
    }
}

fn press(window: &mut Window, modifiers: Modifiers, key: Key) {
    window.key_press_modifiers(modifiers, key);
    settle(window);
}

fn key(window: &mut Window, key: Key) {
    press(window, Modifiers::NONE, key);
}

fn history(window: &Window) -> usize {
    studio(window).document().history_steps().0
}

/// Undoes and redoes the one step since `before`.
fn check_one_step(window: &mut Window, before: Digest, steps: usize) {
    let after = digest(window);
    assert_ne!(after, before, "something changed");
    assert_eq!(history(window), steps + 1, "one step");
    press(window, Modifiers::COMMAND, Key::Z);
    assert_eq!(digest(window), before, "undone");
    press(window, Modifiers::COMMAND | Modifiers::SHIFT, Key::Z);
    assert_eq!(digest(window), after, "made again");
}

/// An orange disc of radius 110 at (200, 150) before a blue sky that gets lighter downwards.
fn disc() -> Image<Straight> {
    let mut picture = Image::filled(400, 300, Straight([0; 4]));
    for y in 0..300 {
        for x in 0..400 {
            let noise = ((x * 7 + y * 13) % 5) as u8;
            let color = if in_disc(x, y) {
                [200 + noise, 110 + noise, 40, 255]
            } else {
                [70, 110 + noise, 170 + (y / 5) as u8, 255]
            };
            picture.set(x, y, Straight(color));
        }
    }
    picture
}

fn in_disc(x: u32, y: u32) -> bool {
    let (dx, dy) = (f64::from(x) - 200.0, f64::from(y) - 150.0);
    dx * dx + dy * dy < 110.0 * 110.0
}

/// Share of the disc's pixels that are labelled, and of the others.
fn shares(window: &Window, label: u8) -> (f64, f64) {
    let (mut hits, mut inside, mut strays, mut outside) = (0.0, 0.0, 0.0, 0.0);
    for y in 0..300 {
        for x in 0..400 {
            let is_labelled = f64::from(u8::from(mask(window).at(x, y) == label));
            if in_disc(x, y) {
                inside += 1.0;
                hits += is_labelled;
            } else {
                outside += 1.0;
                strays += is_labelled;
            }
        }
    }
    (hits / inside, strays / outside)
}

/// Labels the disc.
fn with_disc_labelled() -> (Window, tempfile::TempDir) {
    let (mut window, folder) = window_on(&disc());
    key(&mut window, Key::G);
    click(&mut window, 200.0, 150.0);
    let (hits, strays) = shares(&window, CROWN);
    assert_eq!((hits, strays), (1.0, 0.0));
    (window, folder)
}

#[test]
fn a_stroke_on_a_real_photograph_paints_where_the_pointer_went() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let (mut window, _folder) = window(vec![data.join("photos/white_oak_dense_01.jpg")]);
    let (before, steps) = (digest(&window), history(&window));
    let (width, height) = (mask(&window).width(), mask(&window).height());
    let (w, h) = (width as f32, height as f32);
    act(&mut window, Action::BrushRadius(f64::from(w) * 0.02));
    let way = [(0.3 * w, 0.4 * h), (0.45 * w, 0.42 * h), (0.6 * w, 0.5 * h)];
    drag(&mut window, &way);
    for (x, y) in way {
        assert_eq!(mask(&window).at(x as u32, y as u32), CROWN, "({x}, {y})");
    }
    assert_eq!(mask(&window).at(width / 2, height / 10), BACKGROUND);
    let painted = mask(&window).count(|label| label == CROWN) as f64;
    let expected = 0.31 * f64::from(w) * 0.04 * f64::from(w);
    assert!(
        (painted / expected - 1.0).abs() < 0.3,
        "{painted} {expected}"
    );
    check_one_step(&mut window, before, steps);
}

#[test]
fn a_click_paints_a_dot_of_the_brush_size() {
    let (mut window, _folder) = window_on(&disc());
    let (before, steps) = (digest(&window), history(&window));
    act(&mut window, Action::BrushRadius(20.0));
    click(&mut window, 100.0, 100.0);
    let painted = mask(&window).count(|label| label == CROWN) as f64;
    assert!((painted / (std::f64::consts::PI * 400.0) - 1.0).abs() < 0.05);
    check_one_step(&mut window, before, steps);
}

#[test]
fn control_and_the_eraser_erase() {
    let (mut window, _folder) = with_disc_labelled();
    key(&mut window, Key::B);
    let (before, steps) = (digest(&window), history(&window));
    let way = [(150.0, 150.0), (250.0, 150.0)];
    drag_with(
        &mut window,
        PointerButton::Primary,
        Modifiers::COMMAND,
        &way,
    );
    assert_eq!(mask(&window).at(200, 150), BACKGROUND);
    assert_eq!(studio(&window).document().undo_label(), Some("Erase"));
    check_one_step(&mut window, before, steps);
    key(&mut window, Key::E);
    drag(&mut window, &[(200.0, 80.0), (200.0, 220.0)]);
    assert_eq!(mask(&window).at(200, 200), BACKGROUND);
    assert_eq!(mask(&window).at(110, 150), CROWN);
}

#[test]
fn escape_gives_up_the_stroke_in_progress() {
    let (mut window, _folder) = window_on(&disc());
    let (before, steps) = (digest(&window), history(&window));
    let place = on_screen(&window, 150.0, 150.0);
    window.event(Event::PointerMoved(place));
    window.event(button(place, PointerButton::Primary, true, Modifiers::NONE));
    window.step();
    window.event(Event::PointerMoved(place + vec2(60.0, 0.0)));
    window.step();
    assert!(studio(&window).is_drawing());
    assert!(mask(&window).count(|label| label == CROWN) > 0);
    key(&mut window, Key::Escape);
    assert!(!studio(&window).is_drawing());
    window.event(Event::PointerMoved(place + vec2(90.0, 0.0)));
    window.step();
    window.event(button(
        place,
        PointerButton::Primary,
        false,
        Modifiers::NONE,
    ));
    settle(&mut window);
    assert_eq!(digest(&window), before);
    assert_eq!(history(&window), steps);
}

#[test]
fn lasso_and_polygon_label_what_they_go_round() {
    let (mut window, _folder) = window_on(&disc());
    key(&mut window, Key::L);
    let (before, steps) = (digest(&window), history(&window));
    drag(
        &mut window,
        &[(50.0, 50.0), (150.0, 50.0), (150.0, 200.0), (50.0, 200.0)],
    );
    assert_eq!(mask(&window).at(100, 100), CROWN);
    assert_eq!(mask(&window).at(200, 100), BACKGROUND);
    let painted = mask(&window).count(|label| label == CROWN) as f64;
    assert!((painted / 15_000.0 - 1.0).abs() < 0.05, "{painted}");
    check_one_step(&mut window, before, steps);

    press(&mut window, Modifiers::SHIFT, Key::L);
    key(&mut window, Key::Num2);
    let (before, steps) = (digest(&window), history(&window));
    for (x, y) in [(220.0, 40.0), (380.0, 40.0), (390.0, 5.0)] {
        click(&mut window, x, y);
    }
    assert!(studio(&window).is_drawing());
    // The last click was a mistake.
    key(&mut window, Key::Backspace);
    click(&mut window, 300.0, 250.0);
    key(&mut window, Key::Enter);
    assert!(!studio(&window).is_drawing());
    assert_eq!(mask(&window).at(300, 100), TRUNK);
    assert_eq!(mask(&window).at(385, 20), BACKGROUND);
    check_one_step(&mut window, before, steps);
}

#[test]
fn a_click_on_the_first_vertex_closes_a_polygon() {
    let (mut window, _folder) = window_on(&disc());
    press(&mut window, Modifiers::SHIFT, Key::L);
    for (x, y) in [(20.0, 20.0), (120.0, 20.0), (70.0, 120.0), (21.0, 21.0)] {
        click(&mut window, x, y);
    }
    assert!(!studio(&window).is_drawing());
    assert_eq!(mask(&window).at(70, 50), CROWN);
}

#[test]
fn undo_takes_back_clicks_of_a_polygon_before_steps() {
    let (mut window, _folder) = with_disc_labelled();
    press(&mut window, Modifiers::SHIFT, Key::L);
    let before = digest(&window);
    click(&mut window, 20.0, 20.0);
    click(&mut window, 120.0, 20.0);
    for is_drawing in [true, false] {
        press(&mut window, Modifiers::COMMAND, Key::Z);
        assert_eq!(studio(&window).is_drawing(), is_drawing);
        assert_eq!(digest(&window), before);
    }
    press(&mut window, Modifiers::COMMAND, Key::Z);
    assert_ne!(digest(&window), before);
}

#[test]
fn flood_takes_colours_as_far_as_it_is_told() {
    let (mut window, _folder) = window_on(&disc());
    key(&mut window, Key::G);
    let (before, steps) = (digest(&window), history(&window));
    click(&mut window, 200.0, 150.0);
    assert_eq!(shares(&window, CROWN), (1.0, 0.0));
    check_one_step(&mut window, before, steps);
    // A tolerance of nothing takes specks of one colour only.
    press(&mut window, Modifiers::COMMAND, Key::Z);
    act(
        &mut window,
        Action::Mask(MaskAction::Set(ToolOption::Tolerance(0))),
    );
    click(&mut window, 200.0, 150.0);
    assert!(shares(&window, CROWN).0 < 0.01);
    act(
        &mut window,
        Action::Mask(MaskAction::Set(ToolOption::Contiguous(false))),
    );
    click(&mut window, 200.0, 150.0);
    let (hits, strays) = shares(&window, CROWN);
    assert!(hits > 0.15 && hits < 0.25 && strays == 0.0, "{hits}");
}

#[test]
fn smart_select_finds_the_disc_from_two_strokes() {
    let (mut window, _folder) = window_on(&disc());
    key(&mut window, Key::S);
    act(&mut window, Action::BrushRadius(8.0));
    let (before, steps) = (digest(&window), history(&window));
    drag(&mut window, &[(150.0, 150.0), (250.0, 160.0)]);
    let outside = [(30.0, 30.0), (40.0, 270.0)];
    drag_with(
        &mut window,
        PointerButton::Secondary,
        Modifiers::NONE,
        &outside,
    );
    assert!(studio(&window).is_drawing());
    assert_eq!(digest(&window), before, "strokes are no labels");
    key(&mut window, Key::Enter);
    assert!(!studio(&window).is_drawing());
    let (hits, strays) = shares(&window, CROWN);
    assert!(hits > 0.99 && strays < 0.01, "{hits} {strays}");
    check_one_step(&mut window, before, steps);
}

#[test]
fn escape_gives_smart_select_up_and_another_tool_takes_it() {
    let (mut window, _folder) = window_on(&disc());
    let before = digest(&window);
    key(&mut window, Key::S);
    drag(&mut window, &[(150.0, 150.0), (250.0, 160.0)]);
    key(&mut window, Key::Escape);
    assert!(!studio(&window).is_drawing());
    assert_eq!(digest(&window), before);
    drag(&mut window, &[(150.0, 150.0), (250.0, 160.0)]);
    key(&mut window, Key::B);
    assert!(shares(&window, CROWN).0 > 0.9);
}

#[test]
fn livewire_follows_the_disc() {
    let (mut window, _folder) = window_on(&disc());
    key(&mut window, Key::I);
    let (before, steps) = (digest(&window), history(&window));
    for (x, y) in [(200.0, 41.0), (309.0, 150.0), (200.0, 259.0), (91.0, 150.0)] {
        click(&mut window, x, y);
    }
    key(&mut window, Key::Enter);
    let (hits, strays) = shares(&window, CROWN);
    assert!(hits > 0.97 && strays < 0.02, "{hits} {strays}");
    check_one_step(&mut window, before, steps);
}

#[test]
fn mask_commands_are_one_step_each() {
    let (mut window, _folder) = with_disc_labelled();
    // Something to fill, something to remove, and nothing symmetric.
    act(&mut window, Action::BrushRadius(4.0));
    key(&mut window, Key::B);
    let dot = [(200.0, 150.0)];
    drag_with(
        &mut window,
        PointerButton::Primary,
        Modifiers::COMMAND,
        &dot,
    );
    click(&mut window, 20.0, 20.0);
    for command in [
        MaskCommand::Grow,
        MaskCommand::Shrink,
        MaskCommand::Smooth,
        MaskCommand::FillHoles,
        MaskCommand::RemoveSpecks,
        MaskCommand::Flip,
        MaskCommand::MirrorLeft,
        MaskCommand::MirrorRight,
    ] {
        let (before, steps) = (digest(&window), history(&window));
        act(&mut window, Action::Do(Command::Mask(command)));
        check_one_step(&mut window, before, steps);
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    for command in [Command::InvertMask, Command::ClearMask] {
        let (before, steps) = (digest(&window), history(&window));
        act(&mut window, Action::Do(command));
        check_one_step(&mut window, before, steps);
        press(&mut window, Modifiers::COMMAND, Key::Z);
    }
    let count = |window: &Window| mask(window).count(|label| label == CROWN);
    let before = count(&window);
    act(
        &mut window,
        Action::Mask(MaskAction::Set(ToolOption::Amount(6))),
    );
    act(&mut window, Action::Do(Command::Mask(MaskCommand::Grow)));
    let ring = std::f64::consts::PI * (116.0 * 116.0 - 110.0 * 110.0);
    assert!((count(&window) - before) as f64 > ring * 0.9);
    act(
        &mut window,
        Action::Do(Command::Mask(MaskCommand::RemoveSpecks)),
    );
    act(
        &mut window,
        Action::Do(Command::Mask(MaskCommand::FillHoles)),
    );
    assert_eq!(mask(&window).at(20, 20), BACKGROUND);
    assert_eq!(mask(&window).at(200, 150), CROWN);
}

#[test]
fn a_mask_comes_back_from_its_file() {
    let (mut window, folder) = with_disc_labelled();
    key(&mut window, Key::Num4);
    key(&mut window, Key::B);
    click(&mut window, 200.0, 150.0);
    let before = mask(&window).clone();
    let file = folder.path().join("mask.png");
    act(&mut window, Action::Mask(MaskAction::Export(file.clone())));
    act(&mut window, Action::Do(Command::ClearMask));
    assert_eq!(mask(&window).count(|label| label != BACKGROUND), 0);
    let (cleared, steps) = (digest(&window), history(&window));
    act(&mut window, Action::Mask(MaskAction::Import(file)));
    assert_eq!(*mask(&window), before);
    check_one_step(&mut window, cleared, steps);
}

#[test]
fn a_mask_of_another_size_is_refused_in_words() {
    let (mut window, folder) = window_on(&disc());
    let before = digest(&window);
    let file = folder.path().join("small.png");
    let small = Image::filled(20, 10, Straight([255; 4]));
    std::fs::write(&file, encode_png(&small, Compression::Fast)).unwrap();
    act(&mut window, Action::Mask(MaskAction::Import(file)));
    assert_eq!(digest(&window), before);
    let notice = &studio(&window).notices().last().unwrap().text;
    assert_eq!(
        notice,
        "small.png has 20 × 10 pixels, the photograph 400 × 300"
    );
}

#[test]
fn a_cut_out_tree_gets_a_mask_and_a_photograph_smart_select() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("tree.png");
    let sample = boscage::branches::samples()[0];
    std::fs::write(&file, sample.bundled()).unwrap();
    let (mut window, _other) = window(vec![file]);
    let (before, steps) = (digest(&window), history(&window));
    press(&mut window, Modifiers::SHIFT, Key::P);
    assert!(mask(&window).count(|label| label == CROWN) > 1000);
    check_one_step(&mut window, before, steps);
    for overlay in [
        Overlay::Contour,
        Overlay::Pins,
        Overlay::Baseline,
        Overlay::Silhouette,
    ] {
        act(&mut window, Action::Do(Command::Overlay(overlay)));
    }

    // Nothing but sky.
    let sky = disc().map(|_| Straight([150, 180, 210, 255]));
    let (mut window, _folder) = window_on(&sky);
    let before = digest(&window);
    press(&mut window, Modifiers::SHIFT, Key::P);
    assert_eq!(digest(&window), before);
    assert!(
        studio(&window)
            .notices()
            .last()
            .unwrap()
            .text
            .contains("Smart Select")
    );
    drag(&mut window, &[(150.0, 150.0), (250.0, 160.0)]);
    assert!(studio(&window).is_drawing(), "the tool is in hand");
}

#[test]
fn the_wheel_zooms_to_the_pointer_and_the_brush_still_hits() {
    let (mut window, _folder) = window_on(&disc());
    let place = on_screen(&window, 120.0, 90.0);
    window.event(Event::PointerMoved(place));
    window.step();
    for _ in 0..20 {
        window.event(Event::MouseWheel {
            unit: egui::MouseWheelUnit::Line,
            delta: vec2(0.0, 1.0),
            modifiers: Modifiers::NONE,
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
        });
        window.step();
    }
    window.run_steps(20);
    act(&mut window, Action::BrushRadius(1.0));
    window.event(button(place, PointerButton::Primary, true, Modifiers::NONE));
    window.step();
    window.event(button(
        place,
        PointerButton::Primary,
        false,
        Modifiers::NONE,
    ));
    settle(&mut window);
    let painted = mask(&window).bounds(|label| label == CROWN).unwrap();
    let middle = pos2(
        painted.x as f32 + painted.width as f32 / 2.0,
        painted.y as f32 + painted.height as f32 / 2.0,
    );
    assert!((middle - pos2(120.0, 90.0)).length() < 1.5, "{middle}");
    assert!(
        painted.width <= 4,
        "a brush is measured in pixels of the picture"
    );
}

/// Drags on the screen and tells whether the picture moved with it: a dot painted afterwards at the
/// same place of the screen lies elsewhere in the picture.
fn pans_with(window: &mut Window, which: PointerButton, with_space: bool) -> Vec2 {
    let place = on_screen(window, 200.0, 150.0);
    window.event(Event::PointerMoved(place));
    if with_space {
        window.key_down(Key::Space);
    }
    window.step();
    window.event(button(place, which, true, Modifiers::NONE));
    window.step();
    let to = place + vec2(-40.0, 0.0);
    window.event(Event::PointerMoved(to));
    window.step();
    window.event(button(to, which, false, Modifiers::NONE));
    if with_space {
        window.key_up(Key::Space);
    }
    settle(window);
    act(window, Action::BrushRadius(2.0));
    click(window, 200.0, 150.0);
    let painted = mask(window).bounds(|label| label == CROWN).unwrap();
    vec2(
        painted.x as f32 + 2.0 - 200.0,
        painted.y as f32 + 2.0 - 150.0,
    )
}

#[test]
fn space_and_the_middle_button_move_the_picture() {
    for (which, with_space) in [
        (PointerButton::Middle, false),
        (PointerButton::Primary, true),
    ] {
        let (mut window, _folder) = window_on(&disc());
        let moved = pans_with(&mut window, which, with_space);
        assert!(moved.x > 20.0 && moved.y.abs() < 2.0, "{moved}");
    }
}

#[test]
fn keys_set_the_tools() {
    let (mut window, _folder) = window_on(&disc());
    act(&mut window, Action::BrushRadius(20.0));
    let painted = |window: &mut Window| {
        key(window, Key::B);
        click(window, 200.0, 150.0);
        let bounds = mask(window).bounds(|label| label != BACKGROUND).unwrap();
        let label = mask(window).at(200, 150);
        press(window, Modifiers::COMMAND, Key::Z);
        (bounds.width, label)
    };
    assert_eq!(painted(&mut window), (40, CROWN));
    key(&mut window, Key::CloseBracket);
    assert_eq!(painted(&mut window), (44, CROWN));
    press(&mut window, Modifiers::SHIFT, Key::CloseCurlyBracket);
    assert_eq!(painted(&mut window), (64, CROWN));
    press(&mut window, Modifiers::SHIFT, Key::OpenCurlyBracket);
    key(&mut window, Key::OpenBracket);
    key(&mut window, Key::X);
    assert_eq!(painted(&mut window), (40, TRUNK));
    key(&mut window, Key::Num5);
    assert_eq!(painted(&mut window), (40, 5));
    // Shift and drag scrubs, and paints nothing.
    let before = digest(&window);
    let way = [(200.0, 150.0), (260.0, 150.0)];
    drag_with(&mut window, PointerButton::Primary, Modifiers::SHIFT, &way);
    assert_eq!(digest(&window), before);
    assert!(painted(&mut window).0 > 50);
}

#[test]
fn every_tool_and_swatch_can_be_clicked() {
    let (mut window, _folder) = window_on(&disc());
    for tool in Tool::ALL {
        let name = match tool {
            Tool::Brush => "Brush",
            Tool::Lasso => "Lasso",
            Tool::Polygon => "Polygon",
            Tool::Livewire => "Livewire",
            Tool::Flood => "Flood",
            Tool::Smart => "Smart Select",
            Tool::Depth => "Depth Handles",
            Tool::Hand => "Hand",
        };
        window.get_by_role_and_label(Role::Button, name).click();
        settle(&mut window);
    }
    window.get_by_role_and_label(Role::Button, "Lasso").click();
    settle(&mut window);
    window
        .get_by_role_and_label(Role::RadioButton, "Paint Trunk")
        .click();
    settle(&mut window);
    drag(&mut window, &[(50.0, 50.0), (150.0, 50.0), (100.0, 200.0)]);
    assert_eq!(mask(&window).at(100, 80), TRUNK);
}

#[test]
fn a_result_that_comes_during_a_stroke_waits_for_its_end() {
    let (mut window, _folder) = window_on(&disc());
    let steps = history(&window);
    let studio = window.state_mut().studio_mut();
    studio.act(Action::TakeTool(Tool::Flood));
    let sample = Sample::at(200.0, 150.0);
    studio.act(Action::Pen(Pen::Down {
        sample,
        erases: false,
    }));
    studio.act(Action::TakeTool(Tool::Brush));
    studio.act(Action::PaintLabel(TRUNK));
    studio.act(Action::Pen(Pen::Down {
        sample: Sample::at(20.0, 20.0),
        erases: false,
    }));
    for _ in 0..200 {
        std::thread::sleep(Duration::from_millis(2));
        window.step();
        assert_eq!(mask(&window).at(200, 150), BACKGROUND);
    }
    act(&mut window, Action::Pen(Pen::Up));
    assert_eq!(mask(&window).at(200, 150), CROWN);
    assert_eq!(mask(&window).at(20, 20), TRUNK);
    assert_eq!(history(&window), steps + 2);
}

#[test]
fn whatever_the_hand_does_can_be_undone() {
    let (mut window, _folder) = window_on(&disc());
    let (before, steps) = (digest(&window), history(&window));
    let mut random = Seed(5).random();
    let commands = [
        MaskCommand::Grow,
        MaskCommand::Shrink,
        MaskCommand::Smooth,
        MaskCommand::FillHoles,
        MaskCommand::RemoveSpecks,
        MaskCommand::Flip,
        MaskCommand::MirrorLeft,
    ];
    for _ in 0..80 {
        let studio = window.state_mut().studio_mut();
        let tool = Tool::ALL[random.below(Tool::ALL.len())];
        studio.act(Action::TakeTool(tool));
        studio.act(Action::PaintLabel(1 + random.below(9) as u8));
        for step in 0..1 + random.below(6) {
            let sample = Sample::at(
                random.below(440) as f64 - 20.0,
                random.below(340) as f64 - 20.0,
            );
            let erases = random.below(4) == 0;
            studio.act(Action::Pen(match step {
                0 => Pen::Down { sample, erases },
                _ => Pen::Move(sample),
            }));
        }
        match random.below(10) {
            0 => studio.act(Action::AbortGesture),
            1 => studio.act(Action::Do(Command::Undo)),
            2 => studio.act(Action::Mask(MaskAction::Close)),
            3 => studio.act(Action::EndGesture),
            4..7 => {
                let command = commands[random.below(commands.len())];
                studio.act(Action::Do(Command::Mask(command)));
            }
            _ => studio.act(Action::Pen(Pen::Up)),
        }
        assert_eq!(studio.document().complaint(), None);
        window.step();
    }
    act(&mut window, Action::AbortGesture);
    let after = digest(&window);
    let made = history(&window) - steps;
    assert!(made > 10, "{made}");
    for _ in 0..made {
        act(&mut window, Action::Do(Command::Undo));
    }
    assert_eq!(digest(&window), before);
    for _ in 0..made {
        act(&mut window, Action::Do(Command::Redo));
    }
    assert_eq!(digest(&window), after);
}

#[test]
fn two_hundred_strokes_on_a_large_photograph_stay_small() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let mut window = Harness::builder()
        .with_size([1440.0, 900.0])
        .build_eframe(move |creation| Shell::new(creation, recovery, Vec::new()));
    let studio = window.state_mut().studio_mut();
    // The history does not care that these bytes are no picture.
    let photo = NewPhoto::new("large", (*b"no picture").into(), (8192, 8192));
    let edit = Edit::AddPhotos(vec![photo]);
    studio.act(Action::Edit {
        label: "Add Picture",
        edit,
        gesture: boscage::app::Gesture::Whole,
    });
    studio.act(Action::BrushRadius(100.0));
    studio.act(Action::BrushHardness(0.5));
    let mut digests = vec![studio.document().digest()];
    for stroke in 0..200_u32 {
        let y = f64::from(200 + stroke * 37 % 7800);
        studio.act(Action::PaintLabel(1 + (stroke % 9) as u8));
        for step in 0..24_u32 {
            let x = 200.0 + f64::from(step * 320);
            let sample = Sample::at(x, y + f64::from(step * stroke % 90));
            let pen = match step {
                0 => Pen::Down {
                    sample,
                    erases: false,
                },
                _ => Pen::Move(sample),
            };
            studio.act(Action::Pen(pen));
        }
        studio.act(Action::Pen(Pen::Up));
        if stroke % 40 == 39 {
            assert_eq!(studio.document().complaint(), None);
            digests.push(studio.document().digest());
        }
    }
    let (steps, _) = studio.document().history_steps();
    let bytes = studio.document().history_bytes();
    assert_eq!(steps, 201, "no step was dropped");
    assert!(bytes < 200 << 20, "{bytes} bytes");
    for wanted in digests.iter().rev().skip(1) {
        for _ in 0..40 {
            studio.act(Action::Do(Command::Undo));
        }
        assert_eq!(studio.document().digest(), *wanted);
    }
}
