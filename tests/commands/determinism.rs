//! Same inputs, settings and seed give the same files, to the bit: for any number of threads, any
//! shards, any vector unit, in debug and in release, on any machine.
//!
//! `tests/golden/determinism.txt` holds the digest of all that each command writes here;
//! `REGENERATE=1` writes it anew, which every change of an algorithm's results needs. Not in it: what
//! a graphics card draws (its twin on the processor is) and learned models.
//!
//! `BOSCAGE_PROGRAM` names another program to be compared, as `scripts/levels.sh` does: a release
//! build, or one started under an emulator of another processor.

use crate::exported;
use boscage::base::{Digest, Hasher};
use boscage::branches::samples;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Trees of the built-in samples that stand in for a user's.
const TREES: [&str; 4] = ["oak_01", "pine_01", "birch_01", "maple_03"];

/// What is run, one after the other; results of one are inputs of others. The first word is the name
/// in the table and where the results go, with the ending that it has.
const COMMANDS: [&str; 24] = [
    "labels segment trees/a.png trees/b.png --segmenter classical",
    "inspected inspect trees/a.png --size 256 --dump inspected",
    "warped.png warp trees/a.png --from from.json --to to.json --size 160 200",
    "exact.png warp trees/a.png --from from.json --to to.json --size 80 100 --exact",
    "recolored.png recolor trees/a.png --like trees/b.png",
    "new vary --library trees --size 128 --count 4 --maps labels,normal,depth,ao,translucency",
    "blended vary --library trees --size 128 --count 2 --target trees/b.png --colors blend --mix 3",
    "like vary --library trees --size 128 --count 2 --like trees/c.png --sheet like/sheet.png",
    "crowns vary --library trees --size 128 --count 1 --crowns --crown-size 32",
    "bred vary --parents new/library.json#tree_0000 new/library.json#tree_0001 --library trees --count 2",
    "turned season trees/a.png --season autumn --snow 0.3 --segmenter classical",
    "morph morph trees/a.png trees/b.png --steps 3 --size 128",
    "table.png table --library trees --kind contours",
    "body.obj inflate mask.png --k 1+2*j --size 64",
    "radial.obj inflate mask.png --method radial --size 48",
    "distance.obj inflate mask.png --method distance --size 48",
    "body.glb inflate mask.png --size 48 --copies 3",
    "leaves.png synthesize photo.png --mask mask.png --width 200 --height 120",
    "cube cubemap photo.png --mask mask.png --size 48",
    "crown crown photo.png --mask mask.png --size 48 --photo-front --k 2",
    "relief.png render crown --backend cpu --mode relief --size 96 96",
    "leaf.png render crown --backend cpu --mode leaves --size 96 96 --yaw 40",
    "web export new --preset web --atlas",
    "unreal export new --preset unreal --textures png,dds,ktx2",
];

/// A folder with the inputs.
fn inputs() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    fs::create_dir(at("trees")).unwrap();
    for (name, tree) in ["a", "b", "c", "d"].iter().zip(TREES) {
        fs::write(at(&format!("trees/{name}.png")), bundled(tree)).unwrap();
    }
    let square =
        |inner: &str| format!("{{\"points\":[[0,0],[300,20],{inner},[400,500],[10,480]]}}");
    fs::write(at("from.json"), square("[500,250]")).unwrap();
    fs::write(at("to.json"), square("[390,260]")).unwrap();
    exported::write_crown_inputs(folder.path(), 1.2);
    folder
}

fn bundled(name: &str) -> &'static [u8] {
    let sample = samples().iter().find(|sample| sample.name() == name);
    sample.unwrap().bundled()
}

/// Runs all commands with `more` arguments, and gives the digest of what each wrote.
fn digests(more: &[&str]) -> BTreeMap<String, Digest> {
    let folder = inputs();
    let mut digests = BTreeMap::new();
    for command in COMMANDS {
        let words: Vec<&str> = command.split(' ').collect();
        run(
            folder.path(),
            &[&words[1..], &["--out", words[0]], more].concat(),
        );
        digests.insert(
            words[0].to_owned(),
            digest_of(&folder.path().join(words[0])),
        );
    }
    digests
}

fn run(folder: &Path, arguments: &[&str]) {
    let given = std::env::var("BOSCAGE_PROGRAM");
    let given = given.unwrap_or(env!("CARGO_BIN_EXE_boscage").to_owned());
    let program: Vec<&str> = given.split(' ').collect();
    let output = Command::new(program[0])
        .args(&program[1..])
        .args(arguments)
        .args(["--seed", "7"])
        .env("BOSCAGE_CACHE", folder.join("cache"))
        .current_dir(folder)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{arguments:?}: {told}");
}

/// The digest of a file, or of all files in a folder with their names.
fn digest_of(path: &Path) -> Digest {
    let mut files = Vec::new();
    collect(path, &mut files);
    files.sort();
    assert!(!files.is_empty());
    let mut hasher = Hasher::new("boscage golden");
    for file in files {
        let name = file.strip_prefix(path).unwrap().display().to_string();
        hasher = hasher.with(name.as_bytes()).with(&fs::read(&file).unwrap());
    }
    hasher.finish()
}

fn collect(path: &Path, files: &mut Vec<PathBuf>) {
    if path.is_dir() {
        for entry in fs::read_dir(path).unwrap() {
            collect(&entry.unwrap().path(), files);
        }
    } else {
        files.push(path.to_owned());
    }
}

fn golden() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden/determinism.txt")
}

fn table(digests: &BTreeMap<String, Digest>) -> String {
    let line = |(name, digest): (&String, &Digest)| format!("{digest} {name}\n");
    digests.iter().map(line).collect()
}

#[test]
fn results_are_those_of_the_table_on_one_thread_with_the_least_vector_unit() {
    let found = table(&digests(&["--threads", "1", "--vector-level", "least"]));
    if std::env::var_os("REGENERATE").is_some() {
        fs::write(golden(), &found).unwrap();
    }
    let expected = fs::read_to_string(golden()).unwrap();
    assert_eq!(
        found, expected,
        "if an algorithm changed on purpose, REGENERATE=1 renews the table"
    );
}

#[test]
fn results_are_those_of_the_table_on_three_threads_with_the_widest() {
    let found = table(&digests(&["--threads", "3"]));
    // Told by the other test when it is another one now.
    if std::env::var_os("REGENERATE").is_none() {
        assert_eq!(found, fs::read_to_string(golden()).unwrap());
    }
}

#[test]
fn shards_make_what_one_run_makes() {
    let folder = inputs();
    let vary = "vary --library trees --size 128 --count 4 --maps labels,normal --threads 2";
    let vary: Vec<&str> = vary.split(' ').collect();
    run(folder.path(), &[&vary[..], &["--out", "whole"]].concat());
    for shard in ["2/3", "0/3", "1/3"] {
        let wide = ["--vector-level", "wide"];
        let out = ["--out", "parts", "--shard", shard];
        run(folder.path(), &[&vary[..], &out, &wide].concat());
    }
    let digest = |name: &str| digest_of(&folder.path().join(name));
    assert_eq!(digest("whole"), digest("parts"));
}
