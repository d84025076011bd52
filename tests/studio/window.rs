//! The real window without a screen, for tests to do in what a user does.

use boscage::app::Shell;
use egui::{TextureId, TexturesDelta};
use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, TestRenderer};
use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

pub(crate) type Window = Harness<'static, Shell>;

/// A window with an empty project, whose autosaves lie in a folder that is gone afterwards.
pub(crate) fn window() -> (Window, tempfile::TempDir) {
    opened(Harness::builder().with_size([1440.0, 900.0]))
}

/// As [`window`], of `size` points with `density` pixels each, drawn by a graphics card.
pub(crate) fn drawn_window(size: [f32; 2], density: f32) -> (Window, tempfile::TempDir) {
    let builder = Harness::builder().with_size(size);
    opened(builder.with_pixels_per_point(density).wgpu())
}

/// As [`window`], with the bytes of the textures that a graphics card would hold for it: nothing is drawn, but what
/// waits to be drawn does not pile up either.
pub(crate) fn long_lived_window() -> (Window, tempfile::TempDir, Arc<AtomicUsize>) {
    let textures = Textures::default();
    let bytes = Arc::clone(&textures.bytes);
    let builder = Harness::builder().with_size([1440.0, 900.0]);
    let (window, folder) = opened(builder.renderer(textures));
    (window, folder, bytes)
}

/// Stands for a graphics card: knows its textures by their sizes only.
#[derive(Default)]
struct Textures {
    sizes: HashMap<TextureId, usize>,
    bytes: Arc<AtomicUsize>,
}

impl TestRenderer for Textures {
    fn setup_eframe(&self, _: &mut eframe::CreationContext<'_>, _: &mut eframe::Frame) {}

    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        for (&id, images) in &delta.set {
            // Parts change what is there already.
            for image in images.iter().filter(|image| image.is_whole()) {
                let [width, height] = image.image.size();
                self.sizes.insert(id, 4 * width * height);
            }
        }
        for id in &delta.free {
            self.sizes.remove(id);
        }
        delta.clear();
        self.bytes
            .store(self.sizes.values().sum(), Ordering::Relaxed);
    }

    fn render(
        &mut self,
        _: &egui::Context,
        _: &egui::FullOutput,
    ) -> Result<image::RgbaImage, String> {
        Err("nothing is drawn".to_owned())
    }
}

fn opened(builder: egui_kittest::HarnessBuilder<Shell>) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let window = builder
        .with_max_steps(64)
        .build_eframe(move |creation| Shell::new(creation, recovery, Vec::new()));
    (window, folder)
}

/// A window with the project that comes with the studio.
pub(crate) fn with_sample() -> (Window, tempfile::TempDir) {
    let (mut window, folder) = window();
    open_sample(&mut window);
    (window, folder)
}

/// Opens the project that comes with the studio.
pub(crate) fn open_sample(window: &mut Window) {
    window.get_by_label("Open the sample project").click();
    window.step();
    wait(window, |shell| !shell.studio().is_empty());
}

/// Draws frames until `is_so`: jobs take their time.
pub(crate) fn wait(window: &mut Window, is_so: impl Fn(&Shell) -> bool) {
    let until = Instant::now() + Duration::from_secs(300);
    while !is_so(window.state()) {
        assert!(Instant::now() < until, "what was waited for did not happen");
        std::thread::sleep(Duration::from_millis(10));
        window.step();
    }
    window.step();
}

/// All files below `folder`, by their path in it.
pub(crate) fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(next) = folders.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else {
                let name = path.strip_prefix(folder).unwrap().to_owned();
                found.insert(name, std::fs::read(path).unwrap());
            }
        }
    }
    found
}

/// Runs the command line, which must succeed.
pub(crate) fn boscage(arguments: &[&std::ffi::OsStr]) {
    let run = std::process::Command::new(env!("CARGO_BIN_EXE_boscage"))
        .args(arguments)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{told}");
}
