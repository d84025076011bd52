//! The studio without a screen: gestures drive the real window, and what they should have done is
//! looked up in the project.

use crate::window;
use boscage::app::{
    Action, Answer, Command, MaskCommand, Menu, Question, Severity, TABLE, Workspace,
};
use boscage::document::{Edit, PhotoId};
use egui::{Key, Modifiers};
use egui_kittest::kittest::Queryable as _;
use window::{Window, wait, window, with_sample};

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    let complaint = window.state().studio().document().complaint();
    assert_eq!(complaint, None);
    window.step();
}

#[test]
fn the_start_screen_opens_the_sample() {
    let (window, _folder) = with_sample();
    let document = window.state().studio().document();
    assert_eq!(document.complaint(), None);
    let content = document.state().content();
    assert_eq!(
        content.photos.len(),
        boscage::branches::samples::starters().count()
    );
    assert!(!document.is_dirty());
    assert_eq!(document.history_steps(), (0, 0));
    let oak = document.state().mask(PhotoId(0)).unwrap();
    assert!(oak.count(|label| label == boscage::paint::CROWN) > 10_000);
}

#[test]
fn removing_a_picture_is_undone_exactly() {
    let (mut window, _folder) = with_sample();
    let before = window.state().studio().document().digest();
    act(&mut window, Action::Do(Command::RemovePhoto));
    assert_ne!(window.state().studio().document().digest(), before);
    act(&mut window, Action::Do(Command::Undo));
    assert_eq!(window.state().studio().document().digest(), before);
}

#[test]
fn every_widget_of_every_workspace_has_a_name() {
    let (mut window, _folder) = with_sample();
    for workspace in Workspace::ALL {
        act(&mut window, Action::Do(Command::Show(workspace)));
        window.step();
        window.check_accessibility();
    }
    for command in [Command::Palette, Command::ShortcutSheet, Command::About] {
        act(&mut window, Action::Do(command));
        window.step();
        window.check_accessibility();
        act(&mut window, Action::Do(command));
    }
}

#[test]
fn every_command_stands_in_its_menu() {
    let (mut window, _folder) = with_sample();
    for menu in Menu::ALL {
        let rows: Vec<_> = TABLE.iter().filter(|row| row.menu == menu).collect();
        if rows.is_empty() {
            continue;
        }
        window.get_by_label(menu.title()).click();
        window.step();
        window.step();
        for row in rows {
            let label = window.state().studio().label_of(row.command);
            let found = window.query_all_by_label_contains(&label).next();
            assert!(
                found.is_some(),
                "{label} is not in the menu {}",
                menu.title()
            );
        }
        window.key_press(Key::Escape);
        window.step();
        window.step();
    }
}

#[test]
fn every_command_has_a_key_that_does_it() {
    let (mut window, _folder) = with_sample();
    // Crowns would take most of the time.
    act(&mut window, Action::Do(Command::ToggleLiveCrown));
    for row in TABLE {
        // These wait for the desktop's file dialog, which comes when it likes.
        let asks = [
            Command::Open,
            Command::AddPhotos,
            Command::SaveAs,
            Command::Save,
            Command::SavePicture,
            Command::Mask(MaskCommand::Import),
            Command::Mask(MaskCommand::Export),
        ];
        let studio = window.state().studio();
        if asks.contains(&row.command) || !studio.can(row.command) {
            continue;
        }
        window.key_press_modifiers(row.shortcut.modifiers, row.shortcut.logical_key);
        window.step();
        let studio = window.state().studio();
        assert_eq!(
            studio.recent_commands().first(),
            Some(&row.command),
            "{}",
            row.label
        );
        // Whatever was opened is closed again.
        window.key_press(Key::Escape);
        window.step();
        if studio_question(&window).is_some() {
            act(&mut window, Action::Answer(Answer::Cancel));
        }
        wait(&mut window, |shell| !shell.studio().is_busy());
        if window.state().studio().is_empty() {
            act(&mut window, Action::Do(Command::OpenSample));
            wait(&mut window, |shell| !shell.studio().is_empty());
        }
    }
}

fn studio_question(window: &Window) -> Option<Question> {
    window.state().studio().question().cloned()
}

#[test]
fn the_palette_runs_what_is_typed() {
    let (mut window, _folder) = with_sample();
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    window.step();
    window.step();
    for row in TABLE {
        let label = format!("{}: {}", row.menu.title(), row.label);
        let found = window.query_all_by_label_contains(&label).next();
        assert!(found.is_some(), "{label}");
    }
    window.event(egui::Event::Text("library work".to_owned()));
    window.step();
    window.key_press(Key::Enter);
    window.step();
    window.step();
    assert_eq!(window.state().studio().workspace(), Workspace::Library);
    assert!(
        window
            .query_by_label_contains("Library Workspace")
            .is_none()
    );
}

#[test]
fn a_changed_project_is_not_lost_unasked() {
    let (mut window, _folder) = with_sample();
    act(&mut window, Action::Do(Command::RemovePhoto));
    let changed = window.state().studio().document().digest();
    act(&mut window, Action::Do(Command::New));
    assert!(matches!(
        studio_question(&window),
        Some(Question::Unsaved(_))
    ));
    window.step();
    window.get_by_label("Cancel").click();
    window.step();
    window.step();
    assert_eq!(studio_question(&window), None);
    assert_eq!(window.state().studio().document().digest(), changed);
    act(&mut window, Action::Do(Command::New));
    window.step();
    window.get_by_label("Do Not Save").click();
    window.step();
    window.step();
    assert!(window.state().studio().is_empty());
}

#[test]
fn a_project_is_saved_changed_elsewhere_and_asked_about() {
    let (mut window, folder) = with_sample();
    let path = folder.path().join("wald.boscage");
    act(&mut window, Action::SaveTo(path.clone()));
    wait(&mut window, |shell| shell.studio().file().path.is_some());
    assert!(!window.state().studio().document().is_dirty());
    assert_eq!(window.state().studio().title(), "wald – Boscage");

    let title = Edit::SetTitle("Wald".to_owned());
    act(&mut window, edit("Title", title));
    assert!(window.state().studio().document().is_dirty());
    let mut bytes = std::fs::read(&path).unwrap();
    bytes.push(0);
    std::fs::write(&path, &bytes).unwrap();
    act(&mut window, Action::Do(Command::Save));
    wait(&mut window, |shell| shell.studio().question().is_some());
    assert_eq!(
        studio_question(&window),
        Some(Question::ChangedOnDisk(path.clone()))
    );
    assert_eq!(
        std::fs::read(&path).unwrap(),
        bytes,
        "nothing was written unasked"
    );

    act(&mut window, Action::Answer(Answer::Anyway));
    wait(&mut window, |shell| !shell.studio().document().is_dirty());
    let (opened, _) = boscage::document::store::open(&path).unwrap();
    assert_eq!(
        opened.document.digest(),
        window.state().studio().document().digest()
    );
}

fn edit(label: &'static str, edit: Edit) -> Action {
    let gesture = boscage::app::Gesture::Whole;
    Action::Edit {
        label,
        edit,
        gesture,
    }
}

/// Whether the window tells of an error.
fn has_failed(shell: &boscage::app::Shell) -> bool {
    let mut notices = shell.studio().notices().iter();
    notices.any(|notice| notice.severity == Severity::Error)
}

#[test]
fn a_save_that_fails_keeps_the_project_dirty_and_says_why() {
    let (mut window, folder) = with_sample();
    act(&mut window, Action::Do(Command::RemovePhoto));
    let file = folder.path().join("a file");
    std::fs::write(&file, "no folder").unwrap();
    let path = file.join("wald.boscage");
    act(&mut window, Action::SaveTo(path));
    wait(&mut window, has_failed);
    assert!(window.state().studio().document().is_dirty());
    assert_eq!(window.state().studio().file().path, None);
}

#[test]
fn a_save_that_ends_once_another_project_is_there_gives_it_no_file() {
    let (mut window, folder) = with_sample();
    let path = folder.path().join("wald.boscage");
    let saved = window.state().studio().document().digest();
    let studio = window.state_mut().studio_mut();
    studio.act(Action::SaveTo(path.clone()));
    studio.act(Action::Do(Command::New));
    let told = |shell: &boscage::app::Shell| {
        let notices = shell.studio().notices();
        notices
            .iter()
            .any(|notice| notice.text.starts_with("Saved"))
    };
    wait(&mut window, told);
    let studio = window.state().studio();
    assert!(studio.is_empty());
    // The next save would write the empty project over the other.
    assert_eq!(studio.file().path, None);
    let (opened, _) = boscage::document::store::open(&path).unwrap();
    assert_eq!(opened.document.digest(), saved);
}

#[test]
fn a_project_that_cannot_be_opened_leaves_the_other_one_unsaved() {
    let (mut window, folder) = with_sample();
    act(&mut window, Action::Do(Command::RemovePhoto));
    let broken = folder.path().join("broken.boscage");
    std::fs::write(&broken, "no project").unwrap();
    act(&mut window, Action::Open(vec![broken]));
    assert!(studio_question(&window).is_some());
    act(&mut window, Action::Answer(Answer::Anyway));
    wait(&mut window, has_failed);
    let document = window.state().studio().document();
    assert!(document.is_dirty() && document.history_steps().0 == 1);
}

#[test]
fn files_that_are_no_pictures_are_refused_by_name() {
    let (mut window, folder) = window();
    let path = folder.path().join("notes.png");
    std::fs::write(&path, "no picture").unwrap();
    act(&mut window, Action::Open(vec![path]));
    wait(&mut window, |shell| !shell.studio().notices().is_empty());
    let notice = window.state().studio().notices()[0].clone();
    assert_eq!(notice.severity, Severity::Error);
    assert!(notice.text.contains("notes.png"), "{}", notice.text);
    assert!(window.state().studio().is_empty());
}

#[test]
fn single_keys_are_letters_while_somebody_types() {
    let (mut window, _folder) = with_sample();
    window.key_press_modifiers(Modifiers::COMMAND | Modifiers::SHIFT, Key::P);
    window.step();
    window.step();
    window.key_press(Key::E);
    window.step();
    let recent = window.state().studio().recent_commands();
    assert_eq!(recent.first(), Some(&Command::Palette));
}
