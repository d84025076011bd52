//! The variations' workspace without a screen: gestures drive the real window; batches and exports are
//! compared with those of the command line, byte for byte.

use crate::window;
use boscage::app::{
    Action, BatchSettings, Command, ExportChoice, Gesture, Shell, Studio, VaryAction, Which,
    Workspace,
};
use boscage::document::{Edit, VariationSettings};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use window::{boscage, contents};

type Window = Harness<'static, Shell>;

/// Samples that are used: three that match, so that few draws are needed.
const SAMPLES: [&str; 3] = ["apple_02", "maple_01", "oak_02"];

/// Draws frames until `is_so`, for jobs take their time.
fn wait(window: &mut Window, is_so: impl Fn(&Studio) -> bool) {
    let until = Instant::now() + Duration::from_secs(300);
    while !is_so(window.state().studio()) {
        assert!(Instant::now() < until, "what was waited for did not happen");
        std::thread::sleep(Duration::from_millis(10));
        window.step();
    }
    window.step();
    window.step();
}

/// Writes the samples to files in `folder`.
fn sample_files(folder: &Path) -> Vec<PathBuf> {
    std::fs::create_dir_all(folder).unwrap();
    let samples = boscage::branches::samples().iter();
    let samples = samples.filter(|sample| SAMPLES.contains(&sample.name()));
    let mut files: Vec<PathBuf> = samples
        .map(|sample| {
            let file = folder.join(format!("{}.webp", sample.name()));
            std::fs::write(&file, sample.bundled()).unwrap();
            file
        })
        .collect();
    files.sort();
    files
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
    let complaint = window.state().studio().document().complaint();
    assert_eq!(complaint, None);
}

fn settings(window: &Window) -> VariationSettings {
    let studio = window.state().studio();
    studio.document().state().content().variation.clone()
}

fn set(window: &mut Window, change: impl FnOnce(&mut VariationSettings)) {
    let mut settings = settings(window);
    change(&mut settings);
    let edit = Edit::SetVariation(Box::new(settings));
    let gesture = Gesture::Whole;
    let label = "Set";
    act(
        window,
        Action::Edit {
            label,
            edit,
            gesture,
        },
    );
}

/// A window with the samples, in the variations' workspace, once its gallery of `count` is full.
fn gallery_of(count: u32) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let mut window = Harness::builder()
        .with_size([1440.0, 900.0])
        .with_max_steps(64)
        .build_eframe(move |creation| Shell::new(creation, recovery, Vec::new()));
    let files = sample_files(&folder.path().join("pictures"));
    act(&mut window, Action::Open(files));
    let all_are_there = |studio: &Studio| {
        let photos = &studio.document().state().content().photos;
        photos.len() == SAMPLES.len()
    };
    wait(&mut window, all_are_there);
    set(&mut window, |settings| settings.count = count);
    act(
        &mut window,
        Action::Do(Command::Show(Workspace::Variations)),
    );
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    (window, folder)
}

/// Drags with the first button, in a few steps.
fn drag(window: &mut Window, from: egui::Pos2, to: egui::Pos2) {
    let button = |pos, pressed| egui::Event::PointerButton {
        pos,
        button: egui::PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    };
    window.event(egui::Event::PointerMoved(from));
    window.event(button(from, true));
    window.step();
    for step in 1..=4 {
        window.event(egui::Event::PointerMoved(from.lerp(to, step as f32 / 4.0)));
        window.step();
    }
    window.event(button(to, false));
    window.step();
}

#[test]
fn pins_are_dragged_and_trees_follow_here_and_from_their_record() {
    let (mut window, folder) = gallery_of(1);
    let before = window.state().studio().document().digest();
    let name = SAMPLES[0];
    window.get_by_label(&format!("Pins of {name}.webp")).click();
    for _ in 0..4 {
        window.step();
    }
    window.check_accessibility();
    let pin = window.get_by_label("Left top of the trunk").rect().center();
    // A little up the outline, so that trees still fit.
    drag(&mut window, pin, pin - egui::vec2(6.0, 14.0));
    let studio = window.state().studio();
    let pins = &studio.document().state().content().pins;
    let (id, moved) = pins.iter().next().map(|(id, pins)| (*id, *pins)).unwrap();
    assert!(
        moved.is_sound() && moved.left[0] < moved.right[0],
        "{moved:?}"
    );
    assert_eq!(studio.document().complaint(), None);
    wait(&mut window, |studio| {
        studio.missing_trees() == Some(0) && !studio.is_busy()
    });

    // The record of a tree tells of the pins, and makes it again.
    let ours = folder.path().join("ours");
    let settings = BatchSettings {
        which: Which::Drawn(6),
        folder: ours.clone(),
        size: 128,
        has_sheet: false,
        ..BatchSettings::default()
    };
    act(
        &mut window,
        Action::Vary(VaryAction::Make(Box::new(settings))),
    );
    wait(&mut window, |studio| {
        let mut notices = studio.notices().iter();
        notices.any(|notice| notice.text.starts_with("Made 6 trees"))
    });
    let record = std::fs::read(ours.join("library.json")).unwrap();
    let record: serde_json::Value = serde_json::from_slice(&record).unwrap();
    let is_pinned = |tree: &&serde_json::Value| {
        let exemplars = tree["exemplars"].as_array().unwrap();
        let ours = exemplars
            .iter()
            .find(|part| part["file"] == format!("{name}.webp"));
        ours.is_some_and(|part| part["pins"]["left"][1] == moved.left[1])
    };
    let tree = record["trees"].as_array().unwrap().iter().find(is_pinned);
    let file = tree.unwrap()["file"].as_str().unwrap();
    check_made_again(&ours, file, &folder.path().join("again"));

    let forget = Edit::SetPins(id, None);
    let (label, gesture) = ("Find Pins Again", Gesture::Whole);
    act(
        &mut window,
        Action::Edit {
            label,
            edit: forget,
            gesture,
        },
    );
    assert_eq!(window.state().studio().document().digest(), before);
    act(&mut window, Action::Do(Command::Undo));
    act(&mut window, Action::Do(Command::Undo));
    assert_eq!(window.state().studio().document().digest(), before);
}

/// Checks that the command line makes the tree `name` of the library in `made` again from its record,
/// in the folder `again`.
fn check_made_again(made: &Path, name: &str, again: &Path) {
    let of_tree = format!("{}#{name}", made.join("library.json").display());
    let vary: [&std::ffi::OsStr; 6] = [
        "vary".as_ref(),
        "--recipe".as_ref(),
        of_tree.as_ref(),
        "--no-cache".as_ref(),
        "--out".as_ref(),
        again.as_os_str(),
    ];
    boscage(&vary);
    let file = format!("{}.png", name.trim_end_matches(".png"));
    let [ours, again] = [made, again].map(|at| std::fs::read(at.join(&file)).unwrap());
    assert!(again == ours);
}

#[test]
fn the_gallery_fills_and_locks_keep_what_rolling_replaces() {
    let (mut window, _folder) = gallery_of(3);
    let studio = window.state().studio();
    let before = studio.gallery_seeds();
    assert_eq!(before.len(), 3);
    for index in 0..3 {
        let picture = studio.gallery_picture(index).unwrap();
        let opaque = picture.pixels().iter().filter(|pixel| pixel.alpha() > 128);
        assert!(opaque.count() > 2000, "tree {index} is empty");
    }
    let kept = studio.gallery_picture(1).unwrap().clone();
    window.get_by_label("Lock tree 2").click();
    window.step();
    window.step();
    assert_eq!(settings(&window).locked, [before[1]]);
    assert_eq!(window.state().studio().gallery_seeds(), before);
    let digest = window.state().studio().document().digest();

    window.get_by_label("Roll Again").click();
    window.step();
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    let studio = window.state().studio();
    let after = studio.gallery_seeds();
    assert_eq!(after.len(), 3);
    assert_eq!(after[0], before[1]);
    assert_eq!(studio.gallery_picture(0), Some(&kept));
    assert!(after[1..].iter().all(|seed| !before.contains(seed)));

    act(&mut window, Action::Do(Command::Undo));
    let studio = window.state().studio();
    assert_eq!(studio.document().digest(), digest);
    assert_eq!(studio.gallery_seeds(), before);
    // What was made before is found again.
    assert_eq!(studio.missing_trees(), Some(0));
}

#[test]
fn favourites_stay_and_siblings_are_made_of_the_same_exemplars() {
    let (mut window, _folder) = gallery_of(2);
    let digest = window.state().studio().document().digest();
    window.get_by_label("Keep tree 1").click();
    window.step();
    let kept = settings(&window).favourites;
    assert_eq!(kept.len(), 1);
    assert_eq!(kept[0].name, "Tree 1");
    assert_eq!(kept[0].seed, window.state().studio().gallery_seeds()[0]);
    let sum: f64 = kept[0].exemplars.iter().map(|part| part.weight).sum();
    assert!((sum - 1.0).abs() < 1e-9);
    let name = "Old oak".to_owned();
    act(&mut window, Action::Vary(VaryAction::Rename(0, name)));
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    assert!(window.query_by_label("Favourite Old oak").is_some());
    // Chance may change; the favourite does not.
    set(&mut window, |settings| settings.mix = 3);
    act(&mut window, Action::Do(Command::RollTrees));
    assert_eq!(settings(&window).favourites[0].exemplars, kept[0].exemplars);
    for _ in 0..4 {
        act(&mut window, Action::Do(Command::Undo));
    }
    assert_eq!(window.state().studio().document().digest(), digest);
}

/// Clicks the tree with this label, with Ctrl held if it is one more.
fn choose(window: &mut Window, label: &str, is_more: bool) {
    let modifiers = match is_more {
        true => egui::Modifiers::COMMAND,
        false => egui::Modifiers::NONE,
    };
    window.get_by_label(label).click_modifiers(modifiers);
    for _ in 0..3 {
        window.step();
    }
}

/// A batch makes the trees of the gallery, three, and one of them comes from its record again.
fn a_batch_of_the_gallery_is_made_again(window: &mut Window, folder: &Path) {
    let ours = folder.join("bred");
    let batch = BatchSettings {
        which: Which::Gallery,
        folder: ours.clone(),
        size: 128,
        has_sheet: false,
        ..BatchSettings::default()
    };
    act(window, Action::Vary(VaryAction::Make(Box::new(batch))));
    wait(window, |studio| {
        let mut notices = studio.notices().iter();
        notices.any(|notice| notice.text.starts_with("Made 3 trees"))
    });
    check_made_again(&ours, "tree_0001", &folder.join("again"));
}

#[test]
fn chosen_trees_are_scored_and_bred_and_every_generation_comes_back() {
    let (mut window, folder) = gallery_of(3);
    // The tour stands in the way.
    window.get_by_label("Skip").click();
    window.step();
    let first = window.state().studio().document().digest();
    let seeds = window.state().studio().gallery_seeds();
    let pictures = |window: &Window| -> Vec<_> {
        let studio = window.state().studio();
        (0..3)
            .map(|index| studio.gallery_picture(index).cloned())
            .collect()
    };
    let before = pictures(&window);
    choose(&mut window, "Tree 1", false);
    choose(&mut window, "Tree 3", true);
    wait(&mut window, |studio| studio.selection_score().is_some());
    let (score, worst) = window.state().studio().selection_score().unwrap();
    assert!((0.0..1.0).contains(&score), "{score}");
    assert_eq!(worst, Some([0, 2]));
    // To look at a selection changes nothing.
    assert_eq!(window.state().studio().document().digest(), first);

    window.get_by_label("Keep outline").click();
    window.step();
    window.get_by_label("Breed Next Generation").click();
    window.step();
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    let second = window.state().studio().document().digest();
    let lineage = settings(&window).lineage;
    assert_eq!((lineage.len(), lineage[0].parents.len()), (1, 2));
    assert!(
        lineage[0]
            .locks
            .contains(&boscage::variation::Aspect::Contour)
    );
    assert!(window.query_by_label("Parent 2").is_some());
    let children = pictures(&window);
    assert!(children.iter().all(|child| !before.contains(child)));
    window.check_accessibility();

    // A child and a parent have children, too.
    choose(&mut window, "Tree 2", false);
    choose(&mut window, "Parent 1", true);
    window.get_by_label("Breed Next Generation").click();
    window.step();
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    assert_eq!(settings(&window).lineage.len(), 2);
    let third = window.state().studio().document().digest();
    let grandchildren = pictures(&window);
    for (digest, is_undo) in [
        (second, true),
        (first, true),
        (second, false),
        (third, false),
    ] {
        let command = if is_undo {
            Command::Undo
        } else {
            Command::Redo
        };
        act(&mut window, Action::Do(command));
        assert_eq!(window.state().studio().document().digest(), digest);
    }
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    assert_eq!(pictures(&window), grandchildren);

    a_batch_of_the_gallery_is_made_again(&mut window, folder.path());
    for _ in 0..2 {
        window.get_by_label("Back to Parents").click();
        window.step();
        window.step();
    }
    assert_eq!(window.state().studio().gallery_seeds(), seeds);
    assert_eq!(settings(&window).lineage.len(), 0);
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    assert_eq!(pictures(&window), before);
}

#[test]
fn seasons_are_chosen_by_their_looks_and_chance_walks_or_does_not() {
    let (mut window, _folder) = gallery_of(1);
    let digest = window.state().studio().document().digest();
    let before = window.state().studio().gallery_picture(0).cloned().unwrap();
    window.get_by_label("Season winter").click();
    window.step();
    window.step();
    wait(&mut window, |studio| studio.missing_trees() == Some(0));
    let season = settings(&window).season.unwrap();
    assert_eq!(season.settings.season, boscage::variation::Season::Winter);
    let seen = |image: &boscage::raster::Image<boscage::raster::Straight>| {
        let pixels = image.pixels().iter();
        pixels.filter(|pixel| pixel.alpha() > 128).count()
    };
    let bare = window.state().studio().gallery_picture(0).unwrap();
    assert!(seen(bare) < seen(&before) * 4 / 5, "no leaf has fallen");
    window.get_by_label("Season as it is").click();
    window.step();
    assert_eq!(settings(&window).season, None);
    assert_eq!(window.state().studio().document().digest(), digest);

    // The map of the library stands beside the mix.
    window.get_by_label("Map").click();
    for _ in 0..4 {
        window.step();
    }
    assert!(
        window
            .query_by_label("Map of trees that go together")
            .is_some()
    );
    window.check_accessibility();
    window.get_by_label("Any Pair").click();
    window.step();
    window.step();
    assert!(!settings(&window).walks);
    act(&mut window, Action::Do(Command::Undo));
    assert!(settings(&window).walks);
}

#[test]
fn a_drag_on_the_map_is_one_step_that_mixes() {
    let (mut window, _folder) = gallery_of(1);
    let digest = window.state().studio().document().digest();
    let map = window.get_by_label("Map of exemplars").rect();
    let pointer = |window: &mut Window, at: egui::Pos2, pressed: Option<bool>| {
        window.event(egui::Event::PointerMoved(at));
        if let Some(pressed) = pressed {
            window.event(egui::Event::PointerButton {
                pos: at,
                button: egui::PointerButton::Primary,
                pressed,
                modifiers: egui::Modifiers::NONE,
            });
        }
        window.step();
    };
    let middle = map.center();
    pointer(&mut window, middle, Some(true));
    for step in 1..=8 {
        let at = middle + egui::vec2(3.0, -2.0) * step as f32;
        pointer(&mut window, at, None);
    }
    pointer(&mut window, middle, None);
    pointer(&mut window, middle, Some(false));
    window.step();
    let mix = settings(&window).exemplars;
    assert_eq!(mix.len(), 3);
    for part in &mix {
        assert!((part.weight - 1.0 / 3.0).abs() < 0.02, "{mix:?}");
    }
    let studio = window.state().studio();
    assert_eq!(studio.document().complaint(), None);
    assert_eq!(studio.document().undo_label(), Some("Mix"));
    act(&mut window, Action::Do(Command::Undo));
    assert_eq!(window.state().studio().document().digest(), digest);
}

#[test]
fn batches_and_exports_are_those_of_the_command_line() {
    let (mut window, folder) = gallery_of(1);
    let (ours, theirs) = (folder.path().join("ours"), folder.path().join("theirs"));
    let batch = BatchSettings {
        which: Which::Drawn(2),
        folder: ours.clone(),
        size: 128,
        has_sheet: false,
        export: Some(ExportChoice {
            preset: boscage::export::Preset::Godot,
            ..ExportChoice::default()
        }),
        ..BatchSettings::default()
    };
    act(&mut window, Action::Vary(VaryAction::Make(Box::new(batch))));
    let is_done = |studio: &Studio| {
        let mut notices = studio.notices().iter();
        notices.any(|notice| notice.text.starts_with("Exported 2 trees for godot"))
    };
    wait(&mut window, is_done);

    let pictures = folder.path().join("pictures");
    let trees = theirs.join("trees");
    let vary = [
        "vary",
        "--count",
        "2",
        "--size",
        "128",
        "--no-cache",
        "--library",
    ];
    let mut vary: Vec<&std::ffi::OsStr> = vary.map(AsRef::as_ref).to_vec();
    vary.extend([pictures.as_os_str(), "--out".as_ref(), trees.as_os_str()]);
    boscage(&vary);
    let export: [&std::ffi::OsStr; 6] = [
        "export".as_ref(),
        trees.as_os_str(),
        "--preset".as_ref(),
        "godot".as_ref(),
        "--out".as_ref(),
        theirs.as_os_str(),
    ];
    boscage(&export);
    let (mut ours, theirs) = (contents(&ours), contents(&theirs));
    // The studio's has its exemplars beside it; the records name different folders of them.
    ours.retain(|path, _| !path.starts_with("trees/exemplars"));
    assert!(
        ours.keys().eq(theirs.keys()),
        "{:?} {:?}",
        ours.keys(),
        theirs.keys()
    );
    for (path, bytes) in &theirs {
        if path != Path::new("trees/library.json") {
            assert!(ours[path] == *bytes, "{} differs", path.display());
        }
    }

    // A batch can be made again from its record alone.
    let again = folder.path().join("again");
    let record = folder.path().join("ours/trees/library.json#tree_0001");
    let vary: [&std::ffi::OsStr; 6] = [
        "vary".as_ref(),
        "--recipe".as_ref(),
        record.as_os_str(),
        "--no-cache".as_ref(),
        "--out".as_ref(),
        again.as_os_str(),
    ];
    boscage(&vary);
    let again = std::fs::read(again.join("tree_0001.png")).unwrap();
    assert!(again == ours[Path::new("trees/tree_0001.png")]);
}
