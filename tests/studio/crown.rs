//! A crown in the real window without a screen: k is pulled out of its outline, the canvas remembers
//! where it looked, and crowns are exported as by the command line, byte for byte.

use crate::crowned::{SIZE, settle, with_crown};
use crate::window;
use boscage::app::{
    Action, BatchSettings, Command, ExportChoice, Overlay, Tool, VaryAction, Which,
};
use boscage::branches::leaf_name::LeafName;
use boscage::document::{PhotoId, Tangent};
use boscage::export::Preset;
use egui::accesskit::Role;
use egui::{Event, Key, Modifiers, PointerButton, Pos2, vec2};
use egui_kittest::kittest::Queryable as _;
use window::{Window, boscage, contents, wait};

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
    assert_eq!(window.state().studio().document().complaint(), None);
}

/// Where a place of the fitted photograph is on the screen.
fn on_screen(window: &Window, x: f32, y: f32) -> Pos2 {
    let rect = window.get_by_role_and_label(Role::Image, "Canvas").rect();
    let size = vec2(SIZE.0 as f32, SIZE.1 as f32);
    let zoom = (rect.width() / size.x).min(rect.height() / size.y) * 0.94;
    rect.center() + (vec2(x, y) - size / 2.0) * zoom
}

fn button(window: &mut Window, pos: Pos2, pressed: bool) {
    window.event(Event::PointerMoved(pos));
    window.event(Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    });
    window.step();
}

fn k(window: &Window) -> Tangent {
    let content = window.state().studio().document().state().content();
    content.crowns[&PhotoId(0)].k.clone()
}

#[test]
fn k_is_pulled_out_of_the_outline_and_a_drag_is_one_step() {
    let (mut window, _folder) = with_crown(64);
    act(&mut window, Action::Do(Command::Take(Tool::Depth)));
    act(&mut window, Action::Do(Command::Overlay(Overlay::Heat)));
    window.step();
    let digest = |window: &Window| window.state().studio().document().digest();
    let before = digest(&window);
    let steps = window.state().studio().document().history_steps().0;
    let right = on_screen(&window, 140.0, 80.0);
    // A click alone changes nothing.
    button(&mut window, right, true);
    button(&mut window, right, false);
    assert_eq!(digest(&window), before);
    for _ in 0..24 {
        window.step();
    }
    button(&mut window, right, true);
    for step in 1..=4 {
        window.event(Event::PointerMoved(right + vec2(5.5 * step as f32, 0.0)));
        window.step();
        assert_eq!(window.state().studio().document().complaint(), None);
    }
    button(&mut window, right + vec2(22.0, 0.0), false);
    settle(&mut window);
    let Tangent::Profile(points) = k(&window) else {
        panic!("handles: {:?}", k(&window));
    };
    // The others keep the k that was found for a disc; the right one was pulled out by 22 points.
    let usual = points.iter().find(|(t, _)| *t == 0.5).unwrap().1;
    let pulled = points.iter().map(|(_, k)| *k).fold(0.0, f64::max);
    assert!((1.9..2.4).contains(&usual), "{points:?}");
    assert!((pulled - usual - 2.0).abs() < 0.1, "{points:?}");
    assert_eq!(
        window.state().studio().document().history_steps().0,
        steps + 1
    );
    let after = digest(&window);
    act(&mut window, Action::Do(Command::Undo));
    assert_eq!(digest(&window), before);
    act(&mut window, Action::Do(Command::Redo));
    assert_eq!(digest(&window), after);

    // Escape gives a drag up.
    let left = on_screen(&window, 20.0, 80.0);
    button(&mut window, left, true);
    window.event(Event::PointerMoved(left - vec2(30.0, 0.0)));
    window.step();
    assert_ne!(digest(&window), after);
    window.key_press(Key::Escape);
    window.step();
    assert_eq!(digest(&window), after);
    button(&mut window, left, false);
    assert_eq!(digest(&window), after);
}

#[test]
fn the_canvas_looks_where_it_looked_when_the_project_was_saved() {
    let (mut window, folder) = with_crown(64);
    let view = |window: &Window| window.state().studio().document().view().canvas;
    act(&mut window, Action::Do(Command::ZoomIn));
    act(&mut window, Action::Do(Command::ZoomIn));
    for _ in 0..3 {
        window.step();
    }
    let looked = view(&window).unwrap();
    let path = folder.path().join("wald.boscage");
    act(&mut window, Action::SaveTo(path.clone()));
    wait(&mut window, |shell| !shell.studio().document().is_dirty());
    act(&mut window, Action::Do(Command::ZoomToFit));
    for _ in 0..3 {
        window.step();
    }
    assert_ne!(view(&window), Some(looked));
    // Looking elsewhere is no change that has to be saved.
    assert!(!window.state().studio().document().is_dirty());
    act(&mut window, Action::Do(Command::New));
    act(&mut window, Action::Open(vec![path]));
    wait(&mut window, |shell| !shell.studio().is_empty());
    for _ in 0..3 {
        window.step();
    }
    let now = view(&window).unwrap();
    assert!((now.zoom / looked.zoom - 1.0).abs() < 1e-6, "{now:?}");
    assert!((now.center.0 - looked.center.0).abs() < 1e-3, "{now:?}");
}

#[test]
fn leaves_go_by_the_photograph_until_others_are_chosen() {
    let (mut window, _folder) = with_crown(64);
    let chosen = |window: &Window| {
        let content = window.state().studio().document().state().content();
        content.crowns[&PhotoId(0)].leaf
    };
    let combo = |window: &Window, value: &str| {
        let node = window.get_by_role_and_label(Role::ComboBox, "Leaves");
        assert_eq!(node.value().as_deref(), Some(value));
        node.click();
    };
    combo(&window, "Automatic (Lobed: oak)");
    window.run_steps(3);
    window.get_by_label("Fronds: palm").click();
    window.run_steps(2);
    assert_eq!(chosen(&window), Some(LeafName::Frond));
    settle(&mut window);
    act(&mut window, Action::Do(Command::Undo));
    assert_eq!(chosen(&window), None);
    settle(&mut window);
    combo(&window, "Automatic (Lobed: oak)");
}

#[test]
fn crowns_are_exported_as_by_the_command_line() {
    let (mut window, folder) = with_crown(64);
    let (ours, theirs) = (folder.path().join("ours"), folder.path().join("theirs"));
    let settings = BatchSettings {
        which: Which::ShownCrown,
        folder: ours.clone(),
        export: Some(ExportChoice {
            preset: Preset::Godot,
            impostors: std::collections::BTreeSet::new(),
            ..ExportChoice::default()
        }),
        ..BatchSettings::default()
    };
    act(
        &mut window,
        Action::Vary(VaryAction::Make(Box::new(settings))),
    );
    wait(&mut window, |shell| {
        let mut notices = shell.studio().notices().iter();
        notices.any(|notice| notice.text.starts_with("Exported 1 crown for godot"))
    });

    // The crown's own record is enough to make it again.
    let record = ours.join("crowns/old_oak/crown.json");
    let crowns = theirs.join("crowns");
    let crown = crowns.join("old_oak");
    boscage(&[
        "crown".as_ref(),
        "--recipe".as_ref(),
        record.as_os_str(),
        "--out".as_ref(),
        crown.as_os_str(),
    ]);
    boscage(&[
        "export".as_ref(),
        crowns.as_os_str(),
        "--preset".as_ref(),
        "godot".as_ref(),
        "--no-impostors".as_ref(),
        "--out".as_ref(),
        theirs.as_os_str(),
    ]);
    let (mut ours, theirs) = (contents(&ours), contents(&theirs));
    ours.retain(|path, _| !path.starts_with("crowns/photographs"));
    assert!(ours.keys().eq(theirs.keys()), "{:?}", ours.keys());
    for (path, bytes) in &theirs {
        assert!(ours[path] == *bytes, "{} differs", path.display());
    }
}

#[test]
fn the_export_dialog_offers_the_crown_that_is_shown() {
    let (mut window, _folder) = with_crown(64);
    act(&mut window, Action::Do(Command::ExportTrees));
    for _ in 0..3 {
        window.step();
    }
    for name in ["This One", "All (1)", "Shape of the leaves", "From Above"] {
        assert!(window.query_by_label(name).is_some(), "{name}");
    }
    window.check_accessibility();
    let workspace = window.state().studio().workspace();
    assert_eq!(workspace, boscage::app::Workspace::Crown);
}
