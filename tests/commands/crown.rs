//! `boscage crown` as users run it: the folder it writes, what it refuses, and making a crown again.

use crate::exported::{boscage, write_photo_and_mask};
use boscage::export::{CrownFolderError, crown_file_names, crown_from_files};
use boscage::raster::{Compression, Image, encode_grey_png};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

/// A round crown of 120 pixels of noise in 12-pixel clumps, on a blue sky.
fn write_inputs(folder: &Path) {
    let inside = |x: u32, y: u32| (f64::from(x) - 64.0).hypot(f64::from(y) - 60.0) < 56.0;
    write_photo_and_mask(folder, inside);
}

fn made(folder: &Path, out: &str, more: &[&str]) -> Output {
    let usual = [
        "crown",
        "photo.png",
        "--mask",
        "mask.png",
        "--size",
        "64",
        "--out",
        out,
        "--json",
    ];
    boscage(folder, &[&usual[..], more].concat())
}

fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap());
    files
        .map(|file| {
            let name = file.file_name().into_string().unwrap();
            (name, std::fs::read(file.path()).unwrap())
        })
        .collect()
}

#[test]
fn a_crown_is_a_folder_that_reads_back_and_can_be_made_again() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_inputs(at);
    let first = made(
        at,
        "a",
        &["--threads", "1", "--height", "8", "--copies", "2"],
    );
    assert!(
        first.status.success(),
        "{}",
        String::from_utf8_lossy(&first.stderr)
    );
    let files = contents(&at.join("a"));
    let mut names = crown_file_names();
    names.sort();
    assert_eq!(files.keys().cloned().collect::<Vec<_>>(), names);

    let read = |name: &str| Ok::<_, CrownFolderError>(files[name].clone());
    let (crown, record) = crown_from_files(read).unwrap();
    assert_eq!((record.size, crown.color.size()), (64, 64));
    // Eight metres of crown on a trunk of a fifth of that; as deep as it is wide.
    let (low, high) = crown.base_mesh.bounds().unwrap();
    assert!(
        (low.y - 1.6).abs() < 0.2 && (high.y - 9.6).abs() < 0.2,
        "{low} {high}"
    );
    assert!((high.z - low.z - 8.0).abs() < 0.5 && (high.z + low.z).abs() < 1e-3);
    assert!((crown.center_m.y - 5.6).abs() < 0.1 && crown.center_m.x.abs() < 0.1);
    let (shortest, longest) = crown.radius_range_m();
    assert!(shortest > 2.5 && longest < 5.5, "{shortest} {longest}");

    // Other threads, the same bytes; kept by --resume; made again from its record alone.
    let second = made(
        at,
        "b",
        &["--threads", "3", "--height", "8", "--copies", "2"],
    );
    assert!(second.status.success());
    assert!(contents(&at.join("b")) == files);
    let kept = made(at, "a", &["--resume", "--height", "8", "--copies", "2"]);
    let answer: Value = serde_json::from_slice(&kept.stdout).unwrap();
    assert_eq!(answer["kept"], true);
    let again = boscage(at, &["crown", "--recipe", "a/crown.json", "--out", "c"]);
    assert!(
        again.status.success(),
        "{}",
        String::from_utf8_lossy(&again.stderr)
    );
    assert!(contents(&at.join("c")) == files);
}

#[test]
fn the_photograph_in_front_changes_the_front_only_in_colour_and_relief() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_inputs(at);
    assert!(made(at, "plain", &[]).status.success());
    assert!(made(at, "front", &["--photo-front"]).status.success());
    let [plain, front] = ["plain", "front"].map(|name| contents(&at.join(name)));
    assert!(plain["color_pz.png"] != front["color_pz.png"]);
    assert!(plain["base_mesh.ply"] == front["base_mesh.ply"]);
}

#[test]
fn the_relief_of_the_front_is_dumped_when_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_inputs(at);
    let run = made(at, "a", &["--dump", "looks"]);
    let message = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{message}");
    let bytes = std::fs::read(at.join("looks/relief.png")).unwrap();
    let relief = boscage::raster::decode_grey16_png(&bytes, 128).unwrap();
    assert_eq!((relief.width(), relief.height()), (128, 128));
    let outside = f64::from(relief.at(1, 1)) / 65_535.0;
    assert!((outside - 0.5).abs() < 1e-4);
    let inside: Vec<u16> = (40..80).map(|x| relief.at(x, 60)).collect();
    assert!(inside.iter().max().unwrap() - inside.iter().min().unwrap() > 2000);
    let again = made(at, "b", &["--dump", "looks"]);
    assert_eq!(again.status.code(), Some(2));
    assert!(!at.join("b").exists());
}

#[test]
fn bad_input_is_one_line_that_names_the_file_and_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_inputs(at);
    let empty = encode_grey_png(&Image::filled(128, 128, 0), Compression::Fast);
    std::fs::write(at.join("empty.png"), empty).unwrap();
    let small = encode_grey_png(&Image::filled(5, 5, 255), Compression::Fast);
    std::fs::write(at.join("small.png"), small).unwrap();
    let run = |mask: &str, more: &[&str]| {
        let usual = ["crown", "photo.png", "--mask", mask, "--out", "x"];
        boscage(at, &[&usual[..], more].concat())
    };
    let cases: [(Output, &str); 7] = [
        (run("empty.png", &[]), "empty.png: the mask is empty"),
        (run("small.png", &[]), "small.png: the mask is 5×5"),
        (run("none.png", &[]), "none.png: "),
        (run("mask.png", &["--k", "1+"]), "--k: "),
        (
            run("mask.png", &["--size", "100"]),
            "size is 100, not a multiple of 16",
        ),
        (run("mask.png", &["--relief", "nan"]), "rho is NaN"),
        (
            boscage(at, &["crown", "--recipe", "photo.png", "--out", "x"]),
            "photo.png: ",
        ),
    ];
    for (output, expected) in cases {
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(
            message.starts_with("error: ") && message.lines().count() == 1,
            "{message}"
        );
        assert!(message.contains(expected), "{message}");
    }
    assert!(!at.join("x").exists());
}

/// A mask of two discs side by side, grey 100 and 200, of the photograph's size, and its regions.
fn write_regions(folder: &Path) {
    let grey = |x: u32, y: u32| {
        let inside = |cx: f64| (f64::from(x) - cx).hypot(f64::from(y) - 60.0) < 28.0;
        match (inside(38.0), inside(90.0)) {
            (true, _) => 100,
            (false, true) => 200,
            _ => 0,
        }
    };
    let mask = (0..128 * 128).map(|i| grey(i % 128, i / 128)).collect();
    let mask = encode_grey_png(&Image::from_pixels(128, 128, mask), Compression::Fast);
    std::fs::write(folder.join("mask.png"), mask).unwrap();
    let regions = r#"{"regions":[{"label":100,"k":2,"depth_px":12},
        {"label":200,"k":"1","depth_px":-12}]}"#;
    std::fs::write(folder.join("regions.json"), regions).unwrap();
}

#[test]
fn regions_stand_at_their_depths_and_are_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_inputs(at);
    write_regions(at);
    let first = made(at, "a", &["--regions", "regions.json", "--height", "10"]);
    let message = String::from_utf8_lossy(&first.stderr);
    assert!(first.status.success(), "{message}");
    let files = contents(&at.join("a"));
    let read = |name: &str| Ok::<_, CrownFolderError>(files[name].clone());
    let (crown, record) = crown_from_files(read).unwrap();
    assert_eq!(record.recipe["regions"][0]["label"], 100);
    assert_eq!(record.recipe["regions"][1]["depth_px"], -12.0);
    // Discs of 55 pixels stand for ten metres, so that all 107 are 19.5 metres, and 64 pixels of the
    // volume: between the regions lie 24 of those, 7.3 metres. What no region is behind is bridged,
    // which leaves some four of them; without depths k alone would make two.
    let foremost = |left: bool| {
        let of_side = crown.base_mesh.positions.iter();
        let of_side = of_side.filter(|p| (p.x < 0.0) == left && p.x.abs() > 6.0);
        of_side.map(|p| p.z).fold(f64::NEG_INFINITY, f64::max)
    };
    assert!(
        foremost(true) > foremost(false) + 4.0,
        "{} {}",
        foremost(true),
        foremost(false)
    );

    let again = boscage(at, &["crown", "--recipe", "a/crown.json", "--out", "b"]);
    let message = String::from_utf8_lossy(&again.stderr);
    assert!(again.status.success(), "{message}");
    assert!(contents(&at.join("b")) == files);

    std::fs::write(
        at.join("wrong.json"),
        r#"{"regions":[{"label":7,"depth_px":1}]}"#,
    )
    .unwrap();
    let wrong = made(at, "c", &["--regions", "wrong.json"]);
    let message = String::from_utf8(wrong.stderr).unwrap();
    assert_eq!(wrong.status.code(), Some(2), "{message}");
    assert!(message.starts_with("error: wrong.json: no pixel of mask.png has the grey 7"));
    assert!(!at.join("c").exists());
}

#[cfg(unix)]
#[test]
fn a_signal_at_any_stage_leaves_nothing() {
    use std::io::{BufRead as _, BufReader};
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    write_inputs(at);
    let stages = [
        "read", "shape", "exemplar", "refine", "assemble", "relief", "write",
    ];
    for (number, stage) in stages.into_iter().enumerate() {
        let out = format!("new{number}/crown");
        let mut child = Command::new(env!("CARGO_BIN_EXE_boscage"))
            .current_dir(at)
            .args(["crown", "photo.png", "--mask", "mask.png", "--size", "128"])
            .args(["--progress", "json", "--threads", "1", "--out", &out])
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
        let name = format!("\"{stage}\"");
        let begun = lines.find(|line| line.as_ref().unwrap().contains(&name));
        let pid = child.id().to_string();
        let kill = Command::new("kill").args(["-INT", &pid]).status();
        // One that has finished by then has written all of it.
        let killed = kill.unwrap().success() && begun.is_some();
        let last = lines.map(|line| line.unwrap()).last();
        match child.wait().unwrap().code() {
            Some(3) => {
                assert_eq!(last.as_deref(), Some("error: cancelled"));
                assert!(!at.join(format!("new{number}")).exists(), "{stage}");
            }
            code => {
                assert_eq!(code, Some(0), "{stage}");
                assert!(
                    !killed || ["assemble", "relief", "write"].contains(&stage),
                    "{stage}"
                );
                assert_eq!(contents(&at.join(&out)).len(), crown_file_names().len());
            }
        }
    }
}

/// A photograph that comes with the program: nobody says where its crown is.
#[test]
fn without_a_mask_the_network_finds_the_crown() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let photo = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/photos/meadow_oak.jpg");
    std::fs::copy(photo, at.join("oak.jpg")).unwrap();
    let made = boscage(
        at,
        &["crown", "oak.jpg", "--size", "64", "--out", "a", "--json"],
    );
    let told = String::from_utf8(made.stderr).unwrap();
    assert!(made.status.success(), "{told}");
    assert!(
        told.contains("warning: oak.jpg: its crown was found by the learned segmenter"),
        "{told}"
    );
    let answer: Value = serde_json::from_slice(&made.stdout).unwrap();
    assert_eq!(answer["mask"]["source"], "learned");
    assert!(answer["mask"]["confidence"].as_f64().unwrap() > 0.5);
    let record: Value =
        serde_json::from_slice(&std::fs::read(at.join("a/crown.json")).unwrap()).unwrap();
    assert_eq!(record["recipe"]["segmenter"]["name"], "auto");

    // Made again from its record alone, with the same crown found.
    let again = boscage(at, &["crown", "--recipe", "a/crown.json", "--out", "b"]);
    let told = String::from_utf8(again.stderr).unwrap();
    assert!(again.status.success(), "{told}");
    assert!(contents(&at.join("a")) == contents(&at.join("b")));

    // The rules see no tree in a photograph: that is said, and nothing is written.
    let guessed = boscage(
        at,
        &["crown", "oak.jpg", "--segmenter", "classical", "--out", "c"],
    );
    let told = String::from_utf8(guessed.stderr).unwrap();
    assert_eq!(guessed.status.code(), Some(2), "{told}");
    assert!(told.contains("give a --mask"), "{told}");
    assert!(!at.join("c").exists());
}
