//! The studio without a screen: gestures drive the real window, and what they should have done is
//! looked up in the project.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use boscage::app::{Action, Command, Shell, Workspace};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use std::time::{Duration, Instant};

/// A window with an empty project, whose autosaves lie in a folder that is gone afterwards.
fn window() -> (Harness<'static, Shell>, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let harness = Harness::builder()
        .with_size([1440.0, 900.0])
        .with_max_steps(64)
        .build_eframe(move |creation| Shell::new(creation, recovery, Vec::new()));
    (harness, folder)
}

/// Draws frames until `is_so`, for jobs take their time.
fn wait(window: &mut Harness<'static, Shell>, is_so: impl Fn(&Shell) -> bool) {
    let until = Instant::now() + Duration::from_secs(60);
    while !is_so(window.state()) {
        assert!(Instant::now() < until, "what was waited for did not happen");
        std::thread::sleep(Duration::from_millis(10));
        window.step();
    }
    window.step();
}

fn with_sample() -> (Harness<'static, Shell>, tempfile::TempDir) {
    let (mut window, folder) = window();
    window.get_by_label("Open the sample project").click();
    window.step();
    wait(&mut window, |shell| !shell.studio().is_empty());
    (window, folder)
}

#[test]
fn the_start_screen_opens_the_sample() {
    let (window, _folder) = with_sample();
    let document = window.state().studio().document();
    assert_eq!(document.complaint(), None);
    assert_eq!(
        document.state().content().photos.len(),
        boscage::branches::samples().len()
    );
}

#[test]
fn removing_a_picture_is_undone_exactly() {
    let (mut window, _folder) = with_sample();
    let before = window.state().studio().document().digest();
    let studio = window.state_mut().studio_mut();
    studio.act(Action::Do(Command::RemovePhoto));
    assert_ne!(studio.document().digest(), before);
    assert_eq!(studio.document().complaint(), None);
    studio.act(Action::Do(Command::Undo));
    assert_eq!(studio.document().digest(), before);
}

#[test]
fn all_workspaces_can_be_drawn() {
    let (mut window, _folder) = with_sample();
    for workspace in Workspace::ALL {
        window
            .state_mut()
            .studio_mut()
            .act(Action::Do(Command::Show(workspace)));
        window.step();
        window.step();
    }
}
