//! Files in a temporary folder: backups, changes by others, locks, recovery.

use super::*;
use crate::document::{Document, Edit, NewPhoto, PhotoId};
use std::time::{Duration, Instant};

fn project(title: &str) -> Document {
    let mut document = Document::new();
    let bytes = b"bytes of a photograph".as_slice().into();
    let photo = NewPhoto::new("oak.jpg", bytes, (40, 30));
    document.apply("Add", Edit::AddPhotos(vec![photo])).unwrap();
    document
        .apply("Title", Edit::SetTitle(title.to_owned()))
        .unwrap();
    document
}

fn write(path: &Path, document: &Document, over: Over) -> Result<Stamp, StoreError> {
    save(path, &document.snapshot(), over, &Cancel::new())
}

fn title_in(path: &Path) -> String {
    open(path)
        .unwrap()
        .0
        .document
        .state()
        .content()
        .title
        .clone()
}

#[test]
fn the_previous_version_is_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wood.boscage");
    let stamp = write(&path, &project("one"), Over::Anything).unwrap();
    assert!(!backup_path(&path).exists());
    let stamp = write(&path, &project("two"), Over::Unchanged(stamp)).unwrap();
    write(&path, &project("three"), Over::Unchanged(stamp)).unwrap();
    assert_eq!(
        (title_in(&path), title_in(&backup_path(&path))),
        ("three".into(), "two".into())
    );
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        2,
        "nothing else is left"
    );
}

#[test]
fn what_others_changed_is_not_overwritten_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wood.boscage");
    let stamp = write(&path, &project("one"), Over::Anything).unwrap();
    assert_eq!(on_disk(&path, stamp).unwrap(), OnDisk::Same);
    // As long, and with the times of before: only the content tells.
    let modified = fs::metadata(&path).unwrap().modified().unwrap();
    write(&path, &project("two"), Over::Anything).unwrap();
    fs::File::options()
        .write(true)
        .open(&path)
        .unwrap()
        .set_modified(modified)
        .unwrap();
    assert_eq!(on_disk(&path, stamp).unwrap(), OnDisk::Changed);
    let refused = write(&path, &project("mine"), Over::Unchanged(stamp)).unwrap_err();
    assert!(
        matches!(refused, StoreError::ChangedOnDisk { .. }),
        "{refused}"
    );
    assert_eq!(title_in(&path), "two");
    fs::remove_file(&path).unwrap();
    assert_eq!(on_disk(&path, stamp).unwrap(), OnDisk::Missing);
    write(&path, &project("mine"), Over::Unchanged(stamp)).unwrap();
}

#[test]
fn a_cancelled_or_failed_save_leaves_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wood.boscage");
    write(&path, &project("one"), Over::Anything).unwrap();
    let cancel = Cancel::new();
    cancel.cancel();
    let cancelled = save(&path, &project("two").snapshot(), Over::Anything, &cancel);
    assert!(matches!(cancelled, Err(StoreError::Cancelled(_))));
    fs::create_dir(backup_path(&path)).unwrap();
    let failed = write(&path, &project("two"), Over::Anything).unwrap_err();
    assert!(failed.to_string().contains("backup"), "{failed}");
    assert_eq!(title_in(&path), "one");
}

#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("no\nproject.boscage");
    fs::write(&path, b"P6 4 4 255").unwrap();
    let error = open(&path).unwrap_err().to_string();
    assert!(
        error.contains("not a Boscage project") && !error.contains('\n'),
        "{error}"
    );
    assert!(open(&folder.path().join("none.boscage")).is_err());
}

#[test]
fn a_second_instance_is_told_of_the_first() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wood.boscage");
    let lock = Lock::acquire(&path).unwrap();
    let held = Lock::acquire(&path).unwrap_err();
    let LockError::Held {
        owner: Some(owner), ..
    } = &held
    else {
        panic!("{held}");
    };
    assert_eq!(owner.pid, std::process::id());
    assert!(held.to_string().contains("wood.boscage"));
    assert!(matches!(
        Lock::take_over(&path),
        Err(LockError::Held { .. })
    ));
    drop(lock);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    Lock::acquire(&path).unwrap();
}

#[test]
fn locks_left_behind_block_nobody_but_those_of_other_machines_are_asked_about() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wood.boscage");
    let file = beside(&path, ".", ".lock");
    fs::write(&file, b"{\"pid\":1,\"host\":\"elsewhere\"}").unwrap();
    let unsure = Lock::acquire(&path).unwrap_err();
    assert!(unsure.to_string().contains("elsewhere"), "{unsure}");
    drop(Lock::take_over(&path).unwrap());
    for left in [b"not json".as_slice(), b""] {
        fs::write(&file, left).unwrap();
        drop(Lock::acquire(&path).unwrap());
    }
    // This machine's process of that number lives, but it does not hold the lock.
    let ours = Lock::acquire(&path).unwrap();
    let text = fs::read(&file).unwrap();
    drop(ours);
    fs::write(&file, text).unwrap();
    Lock::acquire(&path).unwrap();
}

#[test]
fn a_crashed_session_is_offered_and_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = Recovery::at(folder.path().join("autosaves"));
    assert_eq!(recovery.list(), []);
    let document = project("left behind");
    let file = Path::new("/somewhere/wood.boscage");
    let mut session = recovery.begin("a").unwrap();
    session
        .write(&document.snapshot(), Some(file), 100, &Cancel::new())
        .unwrap();
    session
        .write(&document.snapshot(), Some(file), 130, &Cancel::new())
        .unwrap();
    assert_eq!(recovery.list(), [], "it is still open");
    drop(session);
    let left = recovery.list().remove(0);
    assert_eq!(
        (&*left.title, left.file.as_deref()),
        ("left behind", Some(file))
    );
    assert_eq!((left.saved_at, left.tries), (130, 0));
    let back = recovery.open(&left).unwrap().document;
    assert_eq!(back.digest(), document.digest());
    assert_eq!(
        back.photo_bytes(PhotoId(0)),
        document.photo_bytes(PhotoId(0))
    );
    assert_eq!(recovery.list()[0].tries, 1, "it would be the second try");
    recovery.discard(&left).unwrap();
    assert_eq!(recovery.list(), []);
}

#[test]
fn an_autosave_whose_folder_was_cleared_is_whole_again() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = Recovery::at(folder.path());
    let mut session = recovery.begin("a").unwrap();
    for title in ["before", "after"] {
        let snapshot = project(title).snapshot();
        session.write(&snapshot, None, 1, &Cancel::new()).unwrap();
        if title == "before" {
            fs::remove_dir_all(folder.path().join("a")).unwrap();
        }
    }
    drop(session);
    let left = recovery.list().remove(0);
    let back = recovery.open(&left).unwrap().document;
    assert_eq!(back.digest(), project("after").digest());
}

#[test]
fn damaged_autosaves_never_stop_the_list() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = Recovery::at(folder.path());
    for (name, about, content) in [
        ("a", "{", "x"),
        ("b", "[1]", ""),
        ("c", "{\"tries\":-1}", "y"),
    ] {
        fs::create_dir(folder.path().join(name)).unwrap();
        fs::write(folder.path().join(name).join("about.json"), about).unwrap();
        fs::write(folder.path().join(name).join("document.boscage"), content).unwrap();
    }
    fs::create_dir(folder.path().join("empty")).unwrap();
    fs::write(folder.path().join("stray"), "file").unwrap();
    let list = recovery.list();
    assert_eq!(list.len(), 3);
    assert!(list.iter().all(|left| recovery.open(left).is_err()));
    assert_eq!(recovery.list().len(), 3);
}

#[test]
fn a_session_closed_in_order_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let recovery = Recovery::at(folder.path());
    let mut session = recovery.begin("a").unwrap();
    session
        .write(&project("x").snapshot(), None, 1, &Cancel::new())
        .unwrap();
    session.discard().unwrap();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn autosaves_are_due_while_less_than_thirty_seconds_are_at_stake() {
    let mut clock = AutosaveClock::default();
    let start = Instant::now();
    let after = |seconds| start + Duration::from_secs(seconds);
    clock.wrote(1);
    assert_eq!(clock.due_in(1, after(500)), None, "nothing changed");
    assert_eq!(clock.due_in(2, after(500)), Some(Duration::from_secs(20)));
    assert_eq!(clock.due_in(3, after(510)), Some(Duration::from_secs(10)));
    let since_the_first_change = clock.due_in(4, after(521));
    assert_eq!(since_the_first_change, Some(Duration::ZERO));
    clock.wrote(4);
    assert_eq!(clock.due_in(5, after(522)), Some(Duration::from_secs(20)));
}
