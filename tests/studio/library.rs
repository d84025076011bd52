//! Many pictures in the studio: only those in sight are laid out and made small, and names find them.
//!
//! `cargo test --test studio library:: -- --ignored --nocapture` tries the ten thousand that a project
//! may have (`BOSCAGE_LIBRARY` says how many), and tells memory and frames.

use crate::window;
use boscage::app::{Action, BatchSettings, Command, Pen, VaryAction, Which, Workspace};
use boscage::paint::Sample;
use boscage::raster::{
    Compression, Image, ReadLimits, Straight, encode_png, read_image_from_memory, resized,
};
use egui::accesskit::Role;
use egui::{Event, Modifiers, MouseWheelUnit, TouchPhase, pos2, vec2};
use egui_kittest::kittest::{By, Queryable as _};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use window::{Window, wait, window};

/// Most memory of a project of ten thousand pictures, bytes.
const MOST_BYTES: f64 = 1.5e9;

/// Middle of the list of pictures in the library's workspace, points.
const LIST: egui::Pos2 = pos2(400.0, 500.0);

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
}

/// Opens `files` and goes to the library.
fn with_pictures(files: Vec<PathBuf>) -> (Window, tempfile::TempDir) {
    let (mut window, folder) = window();
    act(&mut window, Action::Do(Command::ToggleLiveCrown));
    act(&mut window, Action::Workspace(Workspace::Library));
    let count = files.len();
    act(&mut window, Action::Open(files));
    let until = Instant::now() + Duration::from_secs(3600);
    while window
        .state()
        .studio()
        .document()
        .state()
        .content()
        .photos
        .len()
        < count
    {
        assert!(Instant::now() < until);
        std::thread::sleep(Duration::from_millis(10));
        window.step();
    }
    (window, folder)
}

/// Stamps of pictures that are laid out now.
fn stamps(window: &Window) -> usize {
    let stamp = By::new().role(Role::Button).label_contains("tree ");
    window.query_all(stamp).count()
}

fn scroll(window: &mut Window, points: f32) {
    window.event(Event::PointerMoved(LIST));
    window.event(Event::MouseWheel {
        unit: MouseWheelUnit::Point,
        delta: vec2(0.0, points),
        phase: TouchPhase::Move,
        source: egui::MouseWheelSource::Wheel,
        modifiers: Modifiers::NONE,
    });
    window.step();
}

fn type_into_search(window: &mut Window, text: &str) {
    window.get_by_label("Search pictures").focus();
    window.step();
    window.get_by_label("Search pictures").type_text(text);
    window.step();
    window.step();
}

fn tiny(folder: &Path, number: u32) -> PathBuf {
    let shade = |shift: u32| (number >> shift) as u8;
    let pixel = Straight([shade(0), shade(8), 90, 255]);
    let path = folder.join(format!("tree {number:05}.png"));
    let png = encode_png(&Image::filled(24, 20, pixel), Compression::Fast);
    std::fs::write(&path, png).unwrap();
    path
}

#[test]
fn of_many_pictures_only_those_in_sight_are_laid_out_and_names_find_them() {
    let pictures = tempfile::tempdir().unwrap();
    let files = (0..1500).map(|number| tiny(pictures.path(), number));
    let (mut window, _folder) = with_pictures(files.collect());
    wait(&mut window, |shell| !shell.studio().is_busy());
    assert!(stamps(&window) > 20 && stamps(&window) < 300);
    assert!(window.query_by_label("tree 00000.png").is_some());
    for _ in 0..60 {
        scroll(&mut window, -4000.0);
    }
    assert!(window.query_by_label("tree 00000.png").is_none());
    assert!(window.query_by_label("tree 01499.png").is_some());
    type_into_search(&mut window, "0077 TREE");
    // 00077 and 00770 to 00779.
    assert_eq!(stamps(&window), 11);
    window.get_by_label("tree 00773.png").click();
    window.step();
    let shown = window.state().studio().shown().unwrap();
    assert_eq!(shown.0, 773);
    // One step to undo, however many came.
    assert_eq!(window.state().studio().document().history_steps(), (1, 0));
}

/// A tree of the samples, turned in colour by `number`, as a file.
fn variant(folder: &Path, trees: &[Image<Straight>], number: usize) -> PathBuf {
    let tree = &trees[number % trees.len()];
    let turned = |pixel: &Straight| {
        let [r, g, b, a] = pixel.0;
        let by = (number / trees.len()) as u8;
        Straight([r.wrapping_add(by), g, b.wrapping_sub(by), a])
    };
    let path = folder.join(format!("tree {number:05}.png"));
    let png = encode_png(&tree.map(turned), Compression::Fast);
    std::fs::write(&path, png).unwrap();
    path
}

fn median(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Time that this thread has worked: on a busy machine the clock tells of others.
#[cfg(target_os = "linux")]
fn worked_ms() -> f64 {
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap();
    told.split(' ').next().unwrap().parse::<f64>().unwrap() / 1e6
}

#[cfg(target_os = "linux")]
fn memory(field: &str) -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with(field)).unwrap();
    1024.0
        * line
            .split_whitespace()
            .nth(1)
            .unwrap()
            .parse::<f64>()
            .unwrap()
}

#[test]
#[ignore = "some minutes, for scripts/soak.sh"]
#[cfg(target_os = "linux")]
fn ten_thousand_pictures_scroll_and_fit_into_memory() {
    let count = std::env::var("BOSCAGE_LIBRARY").map_or(10_000, |text| text.parse().unwrap());
    let trees: Vec<_> = boscage::branches::samples::samples()
        .iter()
        .take(12)
        .collect();
    let decoded = |tree: &&boscage::branches::samples::Sample| {
        let limits = ReadLimits::default();
        read_image_from_memory(tree.bundled(), Path::new("tree.webp"), limits).unwrap()
    };
    // Small: the project keeps the bytes of all its files in memory.
    let small = |tree: &_| {
        let image: Image<Straight> = decoded(tree);
        let (width, height) = (image.width(), image.height());
        let premultiplied = image.premultiplied();
        resized(
            &premultiplied,
            premultiplied.rect(),
            144,
            144 * height / width,
        )
        .straight()
    };
    let trees: Vec<Image<Straight>> = trees.iter().map(small).collect();
    let pictures = tempfile::tempdir().unwrap();
    let files: Vec<PathBuf> = (0..count)
        .map(|number| variant(pictures.path(), &trees, number))
        .collect();
    let megabytes = |files: &[PathBuf]| {
        let bytes = files
            .iter()
            .map(|file| std::fs::metadata(file).unwrap().len());
        bytes.sum::<u64>() as f64 / 1e6
    };
    let on_disk = megabytes(&files);
    let start = Instant::now();
    let (mut window, _folder) = with_pictures(files);
    let added = start.elapsed().as_secs();
    wait(&mut window, |shell| !shell.studio().is_busy());
    let mut frames = Vec::new();
    // Down to the end and up again, a screenful a second at sixty frames, then in leaps.
    for step in 0..1200 {
        let points = match step {
            0..400 => -12.0,
            400..800 => -3000.0,
            _ => 3000.0,
        };
        let start = worked_ms();
        scroll(&mut window, points);
        frames.push(worked_ms() - start);
    }
    wait(&mut window, |shell| !shell.studio().is_busy());
    let start = Instant::now();
    type_into_search(&mut window, "tree 0077");
    let search = 1000.0 * start.elapsed().as_secs_f64() / 3.0;
    assert_eq!(stamps(&window), 11);
    let slowest = frames.iter().copied().fold(0.0, f64::max);
    let file = pictures.path().join("library.boscage");
    let start = Instant::now();
    act(&mut window, Action::SaveTo(file.clone()));
    wait(&mut window, |shell| !shell.studio().is_busy());
    let saved = start.elapsed().as_secs();
    println!(
        "library of {count} pictures, {on_disk:.0} MB on disk: added in {added} s, a frame while scrolling {:.1} ms of work (slowest {slowest:.0}), search {search:.0} ms, saved in {saved} s, memory {:.0} MB, most {:.0} MB",
        median(&mut frames),
        memory("VmRSS:") / 1e6,
        memory("VmHWM:") / 1e6,
    );
    assert!(memory("VmRSS:") < MOST_BYTES);
    let (opened, _) = boscage::document::store::open(&file).unwrap();
    let digest = window.state().studio().document().digest();
    assert_eq!(opened.document.digest(), digest);
}

#[test]
#[ignore = "some minutes, for scripts/soak.sh"]
fn two_hundred_open_jobs_leave_the_window_usable() {
    let (mut window, folder) = window::with_sample();
    act(&mut window, Action::Do(Command::ToggleLiveCrown));
    act(&mut window, Action::Workspace(Workspace::Variations));
    wait(&mut window, |shell| !shell.studio().is_busy());
    for number in 0..200 {
        let settings = BatchSettings {
            which: Which::Drawn(1),
            folder: folder.path().join(format!("batch {number}")),
            size: 64,
            has_sheet: false,
            ..BatchSettings::default()
        };
        let make = VaryAction::Make(Box::new(settings));
        window.state_mut().studio_mut().act(Action::Vary(make));
    }
    act(&mut window, Action::Workspace(Workspace::Library));
    let cancels = window.query_all_by_label("Cancel").count();
    let mut frames = Vec::new();
    for _ in 0..60 {
        let start = Instant::now();
        window.step();
        frames.push(1000.0 * start.elapsed().as_secs_f64());
    }
    // The hand does not wait for them.
    let start = Instant::now();
    act(&mut window, Action::Do(Command::InvertMask));
    wait(&mut window, |shell| shell.studio().document().is_dirty());
    let edit = 1000.0 * start.elapsed().as_secs_f64();
    // Some seconds each.
    let start = Instant::now();
    while window.state().studio().is_busy() {
        assert!(start.elapsed().as_secs() < 3600, "they do not end");
        std::thread::sleep(std::time::Duration::from_millis(100));
        window.step();
    }
    let done = start.elapsed().as_secs();
    for number in 0..200 {
        let tree = folder.path().join(format!("batch {number}/tree_0000.png"));
        assert!(tree.is_file(), "{}", tree.display());
    }
    println!(
        "200 open jobs: {cancels} of them still shown when counted, frame {:.1} ms, an edit among them after {edit:.0} ms, all 200 done in {done} s",
        median(&mut frames)
    );
}

/// Writes a grey picture of `side` pixels a side, row by row: it would take 1.6 GB as an image.
fn write_large(path: &Path, side: u32) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let mut encoder = png::Encoder::new(file, side, side);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().unwrap();
    let mut stream = writer.stream_writer().unwrap();
    let mut row = vec![0; side as usize];
    for y in 0..side {
        let leaf = |x: u32| ((x / 7 * 31 + y / 5 * 17 + (x * y) / 64) % 199) as u8;
        for (x, grey) in (0..).zip(&mut row) {
            *grey = leaf(x);
        }
        std::io::Write::write_all(&mut stream, &row).unwrap();
    }
    stream.finish().unwrap();
}

#[test]
#[ignore = "some minutes and gigabytes, for scripts/soak.sh"]
#[cfg(target_os = "linux")]
fn the_largest_photograph_is_painted_saved_and_opened_again() {
    let side = std::env::var("BOSCAGE_PHOTO").map_or(20_000, |text| text.parse().unwrap());
    let pictures = tempfile::tempdir().unwrap();
    let photo = pictures.path().join("tree large.png");
    write_large(&photo, side);
    let start = Instant::now();
    let (mut window, _folder) = with_pictures(vec![photo]);
    act(&mut window, Action::Workspace(Workspace::Crown));
    wait(&mut window, |shell| !shell.studio().is_busy());
    let opened = start.elapsed().as_secs();
    let middle = f64::from(side) / 2.0;
    act(&mut window, Action::BrushRadius(1500.0));
    let start = Instant::now();
    let place = |step: u32| {
        let (down, across) = (f64::from(step / 8), f64::from(step % 8));
        Sample::at(middle * (0.4 + 0.15 * across), middle * (0.4 + 0.3 * down))
    };
    let down = Pen::Down {
        sample: place(0),
        erases: false,
    };
    act(&mut window, Action::Pen(down));
    for step in 1..32 {
        act(&mut window, Action::Pen(Pen::Move(place(step))));
    }
    act(&mut window, Action::Pen(Pen::Up));
    act(&mut window, Action::EndGesture);
    let painted = start.elapsed().as_secs_f64();
    let digest = window.state().studio().document().digest();
    let file = pictures.path().join("large.boscage");
    let start = Instant::now();
    act(&mut window, Action::SaveTo(file.clone()));
    wait(&mut window, |shell| !shell.studio().is_busy());
    let saved = start.elapsed().as_secs();
    assert!(!window.state().studio().document().is_dirty());
    act(&mut window, Action::Do(Command::New));
    act(&mut window, Action::Open(vec![file]));
    wait(&mut window, |shell| !shell.studio().is_empty());
    wait(&mut window, |shell| !shell.studio().is_busy());
    assert_eq!(window.state().studio().document().digest(), digest);
    println!(
        "photograph of {side} × {side}: opened in {opened} s, a stroke of 32 places in {painted:.1} s, saved in {saved} s, the same after opening, most memory {:.0} MB",
        memory("VmHWM:") / 1e6
    );
}
