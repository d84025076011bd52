//! Pictures of the studio beside those that somebody looked at: every workspace, dark and light, at one
//! and two pixels a point.
//!
//! `UPDATE_SNAPSHOTS=1 cargo test --test studio pictures::` makes new ones: look at them. Drivers draw
//! text and edges a little differently, so a share of the pixels may differ.

use crate::window;
use boscage::app::{Action, Command, Workspace};
use egui_kittest::SnapshotOptions;
use window::{Window, drawn_window, open_sample, wait};

/// Size of the window, points: the smallest that it may have, so that the files stay small.
const SIZE: [f32; 2] = [960.0, 600.0];

/// Share of the pixels that may differ: what is drawn with other drivers, and a job's spinner.
const MAY_DIFFER: f32 = 0.02;

fn has_adapter() -> bool {
    let found = boscage::render::Gpu::offscreen().is_ok();
    let required = std::env::var_os("BOSCAGE_REQUIRE_GPU").is_some_and(|value| value == "1");
    assert!(
        found || !required,
        "BOSCAGE_REQUIRE_GPU is set and there is no adapter"
    );
    if !found {
        eprintln!("left out: there is no adapter to draw with");
    }
    found
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
}

/// Waits until all jobs are done and compares with `tests/golden/studio/NAME.png`.
fn compare(window: &mut Window, name: &str) {
    // What one job gives may be what the next one waits for.
    let mut quiet = 0;
    while quiet < 8 {
        wait(window, |shell| !shell.studio().is_busy());
        quiet = if window.state().studio().is_busy() {
            0
        } else {
            quiet + 1
        };
    }
    if window.state().studio().workspace() == Workspace::Crown
        && !window.state().studio().is_empty()
    {
        // The crown is drawn in parts, better and better.
        wait(window, boscage::app::Shell::view_is_final);
    }
    let pixels = SIZE[0] * SIZE[1] * window.ctx.pixels_per_point().powi(2);
    let options = SnapshotOptions::new()
        .output_path("tests/golden/studio")
        .threshold(1.6)
        .max_failed_pixels((pixels * MAY_DIFFER) as usize);
    window.snapshot_options(name, &options);
}

#[test]
fn the_start_screen_looks_as_it_did() {
    if has_adapter() {
        let (mut window, _folder) = drawn_window(SIZE, 1.0);
        compare(&mut window, "start");
    }
}

/// Compares all workspaces at `density` pixels a point, in both themes; the window, unless there is no adapter.
fn compared_workspaces(density: f32, names: [&str; 3]) -> Option<(Window, tempfile::TempDir)> {
    if !has_adapter() {
        return None;
    }
    let (mut window, folder) = drawn_window(SIZE, density);
    act(&mut window, Action::TourSeen);
    open_sample(&mut window);
    for (workspace, name) in Workspace::ALL.into_iter().zip(names) {
        act(&mut window, Action::Do(Command::Show(workspace)));
        compare(&mut window, name);
        act(&mut window, Action::Do(Command::ToggleTheme));
        compare(&mut window, &format!("{name}-light"));
        act(&mut window, Action::Do(Command::ToggleTheme));
    }
    Some((window, folder))
}

/// What lies over them comes in the same window: most of the time goes into working out its project.
#[test]
fn the_workspaces_and_what_lies_over_them_look_as_they_did() {
    let names = ["crown", "variations", "library"];
    let Some((mut window, _folder)) = compared_workspaces(1.0, names) else {
        return;
    };
    for (command, name) in [
        (Command::Palette, "palette"),
        (Command::ShortcutSheet, "shortcuts"),
    ] {
        act(&mut window, Action::Do(command));
        compare(&mut window, name);
        act(&mut window, Action::Do(command));
    }
    act(&mut window, Action::Do(Command::RemovePhoto));
    act(&mut window, Action::Do(Command::New));
    compare(&mut window, "unsaved");
}

#[test]
fn the_workspaces_look_as_they_did_on_dense_screens() {
    compared_workspaces(2.0, ["crown-2x", "variations-2x", "library-2x"]);
}
