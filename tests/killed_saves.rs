//! Saving, killed at random moments: the project in the file is always one that was saved whole, the
//! newest that was reported as saved or the one after it; so is the one in the autosave.
//!
//! This program is saver and judge: without arguments it starts itself as the saver, kills it and
//! looks, `BOSCAGE_KILLS` times (24 if not set) for files and as often for autosaves. Other harnesses
//! call it as `killed_saves save FILE REVISION`, which prints `SAVED` once the project is safe, and
//! `killed_saves check FILE`, which prints the revision it finds.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "it is its own harness")]

use boscage::base::{Cancel, Random, Seed};
use boscage::document::store::{Over, Recovery, backup_path, open, save};
use boscage::document::{Document, Edit, NewPhoto, PhotoId};
use boscage::paint::{CROWN, TiledMask};
use boscage::raster::Rect;
use std::io::{Read as _, Write as _};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::Duration;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
    match arguments[..] {
        ["save", file, revision] => {
            save_revision(Path::new(file), revision.parse().unwrap());
            tell("SAVED");
        }
        ["check", file] => println!("{}", revision_in(Path::new(file))),
        ["save-on", file, from] => save_on(Path::new(file), from.parse().unwrap()),
        ["autosave-on", folder, from] => autosave_on(Path::new(folder), from.parse().unwrap()),
        // The flags of cargo's own harness.
        _ => killed_at_random(),
    }
}

fn killed_at_random() {
    let kills = std::env::var("BOSCAGE_KILLS").map_or(24, |count| count.parse().unwrap());
    let mut random = Seed(9).random();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("wood.boscage");
    let saves = judged(kills, &mut random, "save-on", &file, || {
        // The version before it is whole too.
        let backup = backup_path(&file);
        if backup.exists() {
            revision_in(&backup);
        }
        revision_in(&file)
    });
    let autosaves = folder.path().join("autosaves");
    let recovery = Recovery::at(&autosaves);
    let writes = judged(kills, &mut random, "autosave-on", &autosaves, || {
        let left = recovery.list();
        assert_eq!(left.len(), 1);
        revision_of(&recovery.open(&left[0]).unwrap().document)
    });
    println!("{kills} kills within {saves} saves and {kills} within {writes} autosaves: none lost");
}

/// Starts `work` on `place`, kills it, and compares what `found` finds with what it told, `kills`
/// times. Gives the number of revisions written.
fn judged(
    kills: u32,
    random: &mut Random,
    work: &str,
    place: &Path,
    found: impl Fn() -> u64,
) -> u64 {
    let mut newest = 0;
    for kill in 0..kills {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args([work, place.to_str().unwrap(), &(newest + 1).to_string()])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut told = child.stdout.take().unwrap();
        if kill == 0 {
            // One is there before any may be lost.
            told.read_exact(&mut [0; 2]).unwrap();
            newest = 1;
        }
        std::thread::sleep(Duration::from_micros(random.below(60_000) as u64));
        child.kill().unwrap();
        child.wait().unwrap();
        let mut lines = String::new();
        told.read_to_string(&mut lines).unwrap();
        let told = lines.lines().filter_map(|line| line.parse().ok()).max();
        let told = told.unwrap_or(newest);
        let found = found();
        assert!(
            found == told || found == told + 1,
            "kill {kill}: {work} told of {told}, found {found}"
        );
        newest = found;
    }
    newest
}

/// A project whose title tells its revision, with a photograph and a mask that differ each time.
fn project(revision: u64) -> Document {
    let mut document = Document::new();
    let photo: Vec<u8> = (0..300_000u64)
        .map(|at| (at.wrapping_mul(0x9e37_79b9_7f4a_7c15 ^ (revision % 3)) >> 32) as u8)
        .collect();
    let photo = NewPhoto::new("wood.png", photo.into(), (800, 600));
    let photo = Edit::AddPhotos(vec![photo]);
    let mut mask = TiledMask::filled(800, 600, 0);
    let rect = Rect {
        x: (revision % 500) as u32,
        y: 50,
        width: 211,
        height: 333,
    };
    mask.edit(rect, |_, _, row| row.fill(CROWN));
    let title = Edit::SetTitle(revision.to_string());
    for edit in [photo, Edit::SetMask(PhotoId(0), Arc::new(mask)), title] {
        document.apply("Edit", edit).unwrap();
    }
    document
}

fn revision_of(document: &Document) -> u64 {
    let revision = document.state().content().title.parse().unwrap();
    assert_eq!(document.digest(), project(revision).digest());
    revision
}

fn revision_in(file: &Path) -> u64 {
    revision_of(&open(file).unwrap().0.document)
}

fn save_revision(file: &Path, revision: u64) {
    let snapshot = project(revision).snapshot();
    save(file, &snapshot, Over::Anything, &Cancel::new()).unwrap();
}

fn save_on(file: &Path, from: u64) {
    for revision in from.. {
        save_revision(file, revision);
        tell(&revision.to_string());
    }
}

fn autosave_on(folder: &Path, from: u64) {
    let recovery = Recovery::at(folder);
    let mut autosave = recovery.begin("session").unwrap();
    for revision in from.. {
        let snapshot = project(revision).snapshot();
        autosave
            .write(&snapshot, None, revision, &Cancel::new())
            .unwrap();
        tell(&revision.to_string());
    }
}

fn tell(line: &str) {
    let mut out = std::io::stdout();
    writeln!(out, "{line}").unwrap();
    out.flush().unwrap();
}
