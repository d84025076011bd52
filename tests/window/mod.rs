//! The real window without a screen, for tests to do in what a user does.
#![allow(dead_code, reason = "each test needs a part of it")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use boscage::app::Shell;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use std::time::{Duration, Instant};

pub(crate) type Window = Harness<'static, Shell>;

/// A window with an empty project, whose autosaves lie in a folder that is gone afterwards.
pub(crate) fn window() -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let harness = Harness::builder()
        .with_size([1440.0, 900.0])
        .with_max_steps(64)
        .build_eframe(move |creation| Shell::new(creation, recovery, Vec::new()));
    (harness, folder)
}

/// A window with the project that comes with the studio.
pub(crate) fn with_sample() -> (Window, tempfile::TempDir) {
    let (mut window, folder) = window();
    window.get_by_label("Open the sample project").click();
    window.step();
    wait(&mut window, |shell| !shell.studio().is_empty());
    (window, folder)
}

/// Draws frames until `is_so`: jobs take their time.
pub(crate) fn wait(window: &mut Window, is_so: impl Fn(&Shell) -> bool) {
    let until = Instant::now() + Duration::from_secs(120);
    while !is_so(window.state()) {
        assert!(Instant::now() < until, "what was waited for did not happen");
        std::thread::sleep(Duration::from_millis(10));
        window.step();
    }
    window.step();
}
