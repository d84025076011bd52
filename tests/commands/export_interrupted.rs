//! `boscage export` that is killed or cancelled on its way: what is there is whole, nothing is there
//! under a final name that is not, and `--resume` makes the same bytes as a run that nobody stopped.
#![cfg(unix)]

use crate::exported;
use exported::{boscage, command, contents, crowns, library, succeeded};
use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

/// Runs `arguments` in `folder`, sends `signal` once as many progress lines have come as `after`
/// says, and waits.
fn stopped(folder: &Path, arguments: &[&str], signal: &str, after: usize) -> ExitStatus {
    let progress = ["--progress", "json", "--threads", "2"];
    let mut child = command(folder, &[arguments, &progress].concat())
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let _ = lines.nth(after);
    // A process that has finished by then is a run that nobody stopped, which is no harm.
    let pid = child.id().to_string();
    let _ = Command::new("kill").args([signal, &pid]).status();
    let rest = lines.map_while(Result::ok).last();
    let status = child.wait().unwrap();
    if status.code() == Some(3) {
        assert_eq!(rest.as_deref(), Some("error: cancelled"));
    }
    status
}

/// Every file that is there is one of those of the whole run, and holds the same.
fn check_whole(found: &Path, whole: &BTreeMap<PathBuf, Vec<u8>>) -> usize {
    if !found.exists() {
        return 0;
    }
    let files = contents(found);
    for (path, content) in &files {
        assert!(whole.get(path) == Some(content), "{}", path.display());
    }
    files.len()
}

/// Stops `arguments` at several moments, resumes, and compares with a run that nobody stopped.
fn check_interrupted(folder: &Path, arguments: &[&str], moments: &[usize]) {
    let with_out = |out: &'static str| [arguments, &["--out", out]].concat();
    succeeded(&boscage(folder, &with_out("whole")));
    let whole: BTreeMap<PathBuf, Vec<u8>> = contents(&folder.join("whole")).into_iter().collect();
    let mut partial = 0;
    for signal in ["-KILL", "-TERM"] {
        for &after in moments {
            let run = [&with_out("part")[..], &["--resume"]].concat();
            let status = stopped(folder, &run, signal, after);
            assert!(
                [None, Some(0), Some(3)].contains(&status.code()),
                "{status}"
            );
            let count = check_whole(&folder.join("part"), &whole);
            partial += usize::from(count > 0 && count < whole.len());
        }
        succeeded(&boscage(
            folder,
            &[&with_out("part")[..], &["--resume"]].concat(),
        ));
        assert_eq!(
            check_whole(&folder.join("part"), &whole),
            whole.len(),
            "{signal}"
        );
        std::fs::remove_dir_all(folder.join("part")).unwrap();
    }
    assert!(partial > 0, "no run was stopped on its way");
}

#[test]
fn trees_with_texture_files_and_an_atlas_survive_kills() {
    let folder = library();
    let export =
        "export new --preset unreal --textures png,dds,ktx2 --maps normal,depth,ao --atlas";
    let arguments: Vec<&str> = export.split(' ').collect();
    check_interrupted(folder.path(), &arguments, &[0, 1, 2, 3, 4]);
}

#[test]
fn crowns_survive_kills() {
    let folder = crowns();
    let export = "export crowns --preset web --impostor-frames 4 --impostor-frame 64 --exr";
    let arguments: Vec<&str> = export.split(' ').collect();
    check_interrupted(folder.path(), &arguments, &[0, 1, 2]);
}

#[test]
fn a_killed_run_with_other_settings_leaves_no_mixture() {
    let folder = library();
    let at = folder.path();
    let export = |out: &str, height: &str, more: &[&str]| {
        let usual = ["export", "new", "--preset", "godot", "--no-maps"];
        let more = [&usual[..], &["--height", height, "--out", out], more].concat();
        more.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let run = |arguments: Vec<String>| {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        succeeded(&boscage(at, &arguments));
    };
    run(export("whole", "10", &[]));
    run(export("part", "10", &[]));
    let whole: BTreeMap<PathBuf, Vec<u8>> = contents(&at.join("whole")).into_iter().collect();
    for moment in 0..3 {
        // Another height is begun over it: some trees are replaced, one is on its way.
        let other = export("part", "20", &["--overwrite"]);
        let other: Vec<&str> = other.iter().map(String::as_str).collect();
        stopped(at, &other, "-KILL", moment);
        run(export("part", "10", &["--resume"]));
        assert_eq!(check_whole(&at.join("part"), &whole), whole.len());
    }
}
