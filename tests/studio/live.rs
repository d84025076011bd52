//! The live crown in the real window: edits change what is shown, in order, and are undone exactly.

use crate::crowned::{crown_mask, edit, photo, settle, with_crown};
use crate::window::{Window, wait};
use boscage::app::{Action, Command, Drawn, LiveAction, Shell};
use boscage::base::{Cancel, Progress, Seed};
use boscage::document::{CrownSettings, Edit, PhotoId, Tangent};
use boscage::pipeline;
use boscage::scene::Crown;
use egui::{Event, Modifiers, PointerButton, Pos2, pos2};
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use std::sync::Arc;

fn crown(window: &Window) -> Arc<Crown> {
    Arc::clone(window.state().studio().shown_crown().unwrap().0)
}

/// How far the crown reaches towards the viewer.
fn depth(crown: &Crown) -> f32 {
    crown.radius_m.nearest(glam::DVec3::Z)
}

fn pointer(window: &mut Window, at: Pos2, pressed: Option<bool>) {
    window.event(Event::PointerMoved(at));
    if let Some(pressed) = pressed {
        window.event(Event::PointerButton {
            pos: at,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        });
    }
    window.step();
}

#[test]
fn a_fresh_documents_crown_is_that_of_the_command_line() {
    let (window, _folder) = with_crown(CrownSettings::default().size);
    let expected = pipeline::crown(
        &photo(),
        &crown_mask(),
        &pipeline::CrownSettings::default(),
        Seed(0),
        Progress::silent(),
        &Cancel::new(),
    );
    assert_eq!(*crown(&window), expected.unwrap());
}

#[test]
fn dragging_k_changes_the_crown_in_order_and_is_one_step_to_undo() {
    let (mut window, _folder) = with_crown(64);
    let settings = CrownSettings {
        size: 64,
        k: Tangent::Expression("2".to_owned()),
        ..CrownSettings::default()
    };
    edit(&mut window, Edit::SetCrown(PhotoId(0), Box::new(settings)));
    settle(&mut window);
    let (before, shown_before) = (window.state().studio().document().digest(), crown(&window));
    let slider = window
        .get_all_by_label("k")
        .find(|node| node.accesskit_node().role() == egui::accesskit::Role::Slider)
        .unwrap()
        .rect();
    let y = slider.center().y;
    pointer(
        &mut window,
        pos2(slider.left() + 0.34 * slider.width(), y),
        Some(true),
    );
    let shown = |shell: &Shell| shell.studio().shown_crown().unwrap().1;
    // Where the hand went down k is a little less than it was.
    let mut last = (shown(window.state()), 0.0);
    for step in 1..=6 {
        let share = 0.34 + 0.04 * step as f32;
        let at = pos2(slider.left() + share * slider.width(), y);
        pointer(&mut window, at, None);
        // The next crown may still be that of the move before, but none older than the last.
        wait(&mut window, |shell| {
            assert!(shown(shell) >= last.0, "a stale crown flashed back");
            shown(shell) > last.0
        });
        let now = (shown(window.state()), depth(&crown(&window)));
        assert!(now.1 >= last.1, "{now:?} after {last:?}");
        last = now;
    }
    assert!(depth(&crown(&window)) > 1.1 * depth(&shown_before));
    pointer(
        &mut window,
        pos2(slider.left() + 0.58 * slider.width(), y),
        Some(false),
    );
    settle(&mut window);
    let studio = window.state_mut().studio_mut();
    assert_eq!(studio.document().complaint(), None);
    assert_ne!(studio.document().digest(), before);
    studio.act(Action::Do(Command::Undo));
    assert_eq!(studio.document().digest(), before, "one drag is one step");
    settle(&mut window);
    assert_eq!(*crown(&window), *shown_before);
}

#[test]
fn a_formula_that_cannot_be_read_is_told_and_the_crown_stays() {
    let (mut window, _folder) = with_crown(64);
    let before = crown(&window);
    let with_k = |k: &str| {
        let settings = CrownSettings {
            size: 64,
            k: Tangent::Expression(k.to_owned()),
            ..CrownSettings::default()
        };
        Edit::SetCrown(PhotoId(0), Box::new(settings))
    };
    edit(&mut window, with_k("1+"));
    window.step();
    let trouble = window.state().studio().crown_trouble().unwrap().to_owned();
    assert!(trouble.contains("column"), "{trouble}");
    assert_eq!(*crown(&window), *before);
    assert!(window.query_all_by_label(&trouble).next().is_some());
    // It can be read, but gives a k below 0.
    edit(&mut window, with_k("j-2"));
    wait(&mut window, |shell| {
        shell.studio().crown_trouble().is_some()
    });
    assert_eq!(*crown(&window), *before);
    edit(&mut window, with_k("1+j"));
    settle(&mut window);
    assert_eq!(window.state().studio().crown_trouble(), None);
    assert_ne!(*crown(&window), *before);
}

#[test]
fn without_a_mask_there_is_no_crown_and_undo_brings_it_back() {
    let (mut window, _folder) = with_crown(64);
    let before = crown(&window);
    window
        .state_mut()
        .studio_mut()
        .act(Action::Do(Command::ClearMask));
    window.step();
    assert!(window.state().studio().shown_crown().is_none());
    window
        .state_mut()
        .studio_mut()
        .act(Action::Do(Command::Undo));
    settle(&mut window);
    assert_eq!(*crown(&window), *before);
}

#[test]
fn looking_at_the_crown_changes_nothing_of_the_project() {
    let (mut window, _folder) = with_crown(64);
    let before = window.state().studio().document().digest();
    for drawn in Drawn::ALL {
        window
            .state_mut()
            .studio_mut()
            .act(Action::Do(Command::Draw(drawn)));
        settle(&mut window);
    }
    let studio = window.state_mut().studio_mut();
    studio.act(Action::Live(LiveAction::Sun((70.0, 30.0))));
    studio.act(Action::Live(LiveAction::Camera((40.0, 10.0), 1.2)));
    assert_eq!(studio.document().view().sun_deg, (70.0, 30.0));
    assert_eq!(studio.document().digest(), before);
    window.get_by_label("Turn").click();
    window.step();
    let yaw = |window: &Window| window.state().studio().document().view().camera_deg.0;
    let start = yaw(&window);
    window.step();
    window.step();
    assert_ne!(yaw(&window), start, "the turntable turns");
    assert_eq!(window.state().studio().document().digest(), before);
}
