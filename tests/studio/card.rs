//! Graphics cards that are lost at random moments, in the real window without a screen: the window ends
//! and the next one, on another device, shows the same project and draws the same view.
//!
//! `BOSCAGE_LOSSES=50 cargo test --test studio card::` loses more than the suite does, and makes and
//! compares the pictures of a crown, which takes long without a card.

use crate::window;
use boscage::app::{Action, Command, Drawn, LiveAction, Pen, Session, Shell};
use boscage::base::{Random, Seed};
use boscage::paint::Sample;
use eframe::egui_wgpu::{RenderState, RendererOptions};
use egui_kittest::Harness;
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use std::path::Path;
use window::{Window, open_sample, wait};

/// Frames within which a loss must be noticed.
const PATIENCE: usize = 10;

/// A window on a device of its own, with the studio of the window before if there was one.
fn window_on_card(folder: &Path, session: &Session) -> (Window, RenderState) {
    let state = create_render_state(default_wgpu_setup(), RendererOptions::PREDICTABLE);
    let renderer = WgpuTestRenderer::from_render_state(state.clone());
    let (recovery, session) = (folder.join("recovery"), session.clone());
    let window = Harness::builder()
        .with_size([1200.0, 700.0])
        .with_max_steps(64)
        .renderer(renderer)
        .build_eframe(move |creation| Shell::in_session(creation, recovery, Vec::new(), session));
    (window, state)
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
}

fn is_at_rest(shell: &Shell) -> bool {
    shell.view_is_final() && !shell.studio().is_busy()
}

/// The window as it is seen.
fn seen(window: &mut Window) -> image::RgbaImage {
    wait(window, is_at_rest);
    window.render().unwrap()
}

/// Share of the pixels that differ by more than a shade.
fn differing(one: &image::RgbaImage, other: &image::RgbaImage) -> f64 {
    assert_eq!(one.dimensions(), other.dimensions());
    let apart = |(a, b): (&u8, &u8)| a.abs_diff(*b) > 3;
    let pairs = one.pixels().zip(other.pixels());
    let count = pairs.filter(|(a, b)| a.0.iter().zip(&b.0).any(apart));
    count.count() as f64 / f64::from(one.width() * one.height())
}

/// Something that makes the card draw something else.
fn something(window: &mut Window, random: &mut Random) {
    let action = match random.below(5) {
        0 | 1 => {
            let camera = (random.between(0.0, 360.0), random.between(-10.0, 50.0));
            Action::Live(LiveAction::Camera(camera, random.between(0.6, 1.6)))
        }
        2 => Action::Do(Command::Draw(Drawn::ALL[random.below(Drawn::ALL.len())])),
        3 => Action::Do(Command::ToggleTheme),
        _ => Action::Do(Command::ZoomIn),
    };
    act(window, action);
}

/// A stroke on the mask up to where the pen is still down.
fn begin_stroke(window: &mut Window, random: &mut Random) {
    let mut sample = || Sample::at(random.between(20.0, 200.0), random.between(20.0, 200.0));
    let (from, to) = (sample(), sample());
    let down = Pen::Down {
        sample: from,
        erases: false,
    };
    act(window, Action::Pen(down));
    act(window, Action::Pen(Pen::Move(to)));
}

#[test]
fn a_lost_card_costs_a_window_and_nothing_else() {
    if boscage::render::Gpu::offscreen().is_err() {
        eprintln!("left out: there is no adapter to lose");
        return;
    }
    let asked: Option<u64> = std::env::var("BOSCAGE_LOSSES")
        .ok()
        .map(|text| text.parse().unwrap());
    let losses = asked.unwrap_or(2);
    let (folder, session) = (tempfile::tempdir().unwrap(), Session::default());
    let mut random = Seed(9).random();
    let (mut window, mut state) = window_on_card(folder.path(), &session);
    if asked.is_none() {
        act(&mut window, Action::Do(Command::ToggleLiveCrown));
    }
    open_sample(&mut window);
    let mut strokes = 0;
    for loss in 0..losses {
        let compares = asked.is_some() && loss % 3 == 0;
        let picture = compares.then(|| {
            wait(&mut window, is_at_rest);
            // The view was framed to the crown as it was when it first showed.
            act(&mut window, Action::Do(Command::FrameTree));
            window.event(egui::Event::PointerGone);
            window.step();
            seen(&mut window)
        });
        if picture.is_none() {
            for _ in 0..random.below(6) {
                something(&mut window, &mut random);
            }
        }
        let before = window.state().studio().document().digest();
        let is_drawing = loss % 3 == 1;
        if is_drawing {
            begin_stroke(&mut window, &mut random);
            strokes += 1;
        }
        state.device.destroy();
        let mut frames = 0;
        while !window.state().has_lost_card() {
            assert!(frames < PATIENCE, "a loss was not noticed");
            window.step();
            frames += 1;
        }
        // The stroke ends where the pen was; undo takes it back, to the bit.
        let lost = window.state().studio().document().digest();
        drop(window);
        assert!(session.goes_on());
        (window, state) = window_on_card(folder.path(), &session);
        assert!(!session.goes_on());
        let document = window.state().studio().document();
        assert_eq!(document.digest(), lost);
        assert_eq!(document.complaint(), None);
        match is_drawing {
            true => {
                act(&mut window, Action::Do(Command::Undo));
                assert_eq!(window.state().studio().document().digest(), before);
            }
            false => assert_eq!(lost, before),
        }
        if let Some(picture) = picture {
            let again = seen(&mut window);
            let share = differing(&picture, &again);
            assert!(share < 0.01, "{share} of the pixels differ after a loss");
        }
    }
    println!(
        "graphics card lost in the studio: {losses} times, {strokes} of them while drawing, view and project came back each time"
    );
}
