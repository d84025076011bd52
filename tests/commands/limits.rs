//! Machines that give too little: no memory, no threads, no place on the disk. Each is an error of one
//! line with exit code 1, and leaves nothing half-written.
#![cfg(target_os = "linux")]

use boscage::branches::samples;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// A folder with one tree.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("trees")).unwrap();
    fs::write(folder.path().join("trees/oak.png"), samples()[0].bundled()).unwrap();
    folder
}

/// Runs the program with `arguments` after `limit`, a command of the shell.
fn limited(folder: &Path, limit: &str, arguments: &str) -> Output {
    let program = env!("CARGO_BIN_EXE_boscage");
    let script = format!("{limit} && exec '{program}' {arguments}");
    Command::new("sh")
        .args(["-c", &script])
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Exit code 1, one line that begins as errors do, and no file at `out`.
fn check_failed(folder: &Path, output: &Output, out: &str) {
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{told}");
    assert!(
        told.starts_with("error: ") && told.lines().count() == 1,
        "{told}"
    );
    let left = fs::read_dir(folder.join(out));
    assert!(left.is_ok_and(|mut files| files.next().is_none()) || !folder.join(out).exists());
}

#[test]
fn too_little_memory_is_an_error_not_an_abort() {
    let folder = folder();
    let mut failed = 0;
    let memory = |kilobytes: u32| format!("ulimit -c 0 && ulimit -v {kilobytes}");
    // The system itself ends programs that it has no place for, and how large this one is tells its build.
    let starts = |kilobytes: &u32| {
        let told = limited(folder.path(), &memory(*kilobytes), "--version");
        told.status.success()
    };
    let least = (60_000..600_000).step_by(10_000).find(starts).unwrap();
    // From hardly enough to start to nearly enough to finish.
    for more in [0, 10_000, 20_000, 30_000, 40_000, 50_000] {
        let limit = memory(least + more);
        let vary = "vary --library trees --count 2 --no-cache --threads 2 --out new";
        let output = limited(folder.path(), &limit, vary);
        match output.status.code() {
            Some(0) => fs::remove_dir_all(folder.path().join("new")).unwrap(),
            // The loader itself did not find place for the program.
            Some(127) => {}
            _ => {
                check_failed(folder.path(), &output, "new");
                failed += 1;
            }
        }
    }
    assert!(failed > 1);
}

#[test]
fn no_threads_is_an_error() {
    // Root may have as many as it likes, and tests often run as root: then this tests nothing.
    let folder = folder();
    let vary = "vary --library trees --count 1 --size 64 --no-cache --threads 8 --out new";
    let output = limited(folder.path(), "ulimit -p 1", vary);
    if output.status.code() != Some(0) {
        check_failed(folder.path(), &output, "new");
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(
            told.contains("threads") || told.contains("signals"),
            "{told}"
        );
    }
}

#[test]
fn files_that_must_not_grow_are_a_full_disk() {
    let folder = folder();
    let vary = "vary --library trees --count 1 --size 256 --no-cache --out new";
    // Beyond the limit the system sends a signal, which is ignored here as on a full disk.
    let output = limited(folder.path(), "trap '' XFSZ && ulimit -f 8", vary);
    check_failed(folder.path(), &output, "new");
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(!told.contains(".part"), "it tells a hidden name: {told}");
}
