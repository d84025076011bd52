//! `boscage vary` as a user runs it: the real binary on small libraries.

use crate::exported::boscage;
use boscage::raster::{Compression, Image, Straight, encode_png};
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Output;

/// A tree of `width` at 96 pixels of height: an oval crown of `green` on a brown trunk.
fn tree(width: u32, green: u8) -> Vec<u8> {
    let mut image = Image::filled(width, 96, Straight([0; 4]));
    let (middle, radius) = (f64::from(width) / 2.0, f64::from(width) / 2.0 - 2.0);
    for y in 0..96u32 {
        for x in 0..width {
            let (dx, dy) = (f64::from(x) + 0.5 - middle, f64::from(y) - 34.0);
            let in_crown = (dx / radius).powi(2) + (dy / 33.0).powi(2) < 1.0;
            let in_trunk = y > 60 && dx.abs() < 4.0;
            let shade = (x * 7 + y * 13) as u8 % 40;
            if in_crown {
                image.set(x, y, Straight([30 + shade, green - shade, 30, 255]));
            } else if in_trunk {
                image.set(x, y, Straight([90 - shade, 60, 40, 255]));
            }
        }
    }
    encode_png(&image, Compression::Fast)
}

/// A folder with a library of four trees.
fn library(folder: &Path) -> std::path::PathBuf {
    let library = folder.join("library");
    fs::create_dir(&library).unwrap();
    for (index, (width, green)) in [(60, 150), (70, 170), (80, 190), (76, 140)]
        .iter()
        .enumerate()
    {
        fs::write(library.join(format!("{index}.png")), tree(*width, *green)).unwrap();
    }
    library
}

fn vary(folder: &Path, arguments: &[&str]) -> Output {
    let common = ["vary", "--library", "library", "--size", "128"];
    boscage(folder, &[&common, arguments].concat())
}

/// Name and content of all files in a folder, by name.
fn files(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .map(|entry| {
            (
                entry.file_name().into_string().unwrap(),
                fs::read(entry.path()).unwrap(),
            )
        })
        .collect();
    files.sort();
    files
}

#[test]
fn threads_shards_and_the_cache_change_no_byte() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let done = vary(
            folder.path(),
            &["--count", "6", "--threads", threads, "--out", out],
        );
        assert!(done.status.success(), "{done:?}");
    }
    let cached = vary(folder.path(), &["--count", "6", "--out", "cached"]);
    assert!(cached.status.success());
    let fresh = vary(
        folder.path(),
        &["--count", "6", "--no-cache", "--out", "fresh"],
    );
    assert!(fresh.status.success(), "--no-cache wins over BOSCAGE_CACHE");
    for shard in ["2/3", "0/3", "1/3"] {
        let done = vary(
            folder.path(),
            &["--count", "6", "--shard", shard, "--out", "sharded"],
        );
        assert!(done.status.success(), "{done:?}");
    }
    let one = files(&folder.path().join("one"));
    assert_eq!(one.len(), 7, "six trees and library.json");
    for other in ["two", "cached", "fresh", "sharded"] {
        assert!(one == files(&folder.path().join(other)), "{other} differs");
    }
    let seeded = vary(
        folder.path(),
        &["--count", "6", "--seed", "9", "--out", "seeded"],
    );
    assert!(seeded.status.success());
    assert!(one != files(&folder.path().join("seeded")));
}

#[test]
fn a_recorded_tree_can_be_made_again() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    let colors = ["--colors", "blend", "--mix", "3", "--like", "library/2.png"];
    let made = vary(
        folder.path(),
        &[&["--count", "3", "--out", "new"], &colors[..]].concat(),
    );
    assert!(made.status.success(), "{made:?}");
    let again = boscage(
        folder.path(),
        &[
            "vary",
            "--recipe",
            "new/library.json#tree_0002",
            "--out",
            "again",
        ],
    );
    assert!(again.status.success(), "{again:?}");
    let read = |out: &str| fs::read(folder.path().join(out).join("tree_0002.png")).unwrap();
    assert!(read("new") == read("again"));

    fs::write(folder.path().join("library/0.png"), tree(61, 150)).unwrap();
    fs::write(folder.path().join("library/1.png"), tree(71, 150)).unwrap();
    let changed = boscage(
        folder.path(),
        &[
            "vary",
            "--recipe",
            "new/library.json#tree_0002",
            "--out",
            "x",
        ],
    );
    assert_eq!(
        changed.status.code(),
        Some(2),
        "another exemplar is not silently used"
    );
    let missing = boscage(
        folder.path(),
        &["vary", "--recipe", "new/library.json#tree_9", "--out", "x"],
    );
    assert_eq!(missing.status.code(), Some(2));
}

#[test]
fn the_record_says_what_each_tree_is_made_of() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    let made = vary(
        folder.path(),
        &[
            "--count",
            "5",
            "--json",
            "--weights",
            "0.4..0.6",
            "--out",
            "new",
        ],
    );
    let answer: Value = serde_json::from_slice(&made.stdout).unwrap();
    let record: Value =
        serde_json::from_slice(&fs::read(folder.path().join("new/library.json")).unwrap()).unwrap();
    assert_eq!(answer["trees"], record["trees"]);
    for tree in record["trees"].as_array().unwrap() {
        let weights: Vec<f64> = tree["contour_weights"]
            .as_array()
            .unwrap()
            .iter()
            .map(|w| w.as_f64().unwrap())
            .collect();
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        assert!((0.4..=0.6).contains(&weights[0]));
        assert_eq!(tree["exemplars"].as_array().unwrap().len(), 2);
        assert_eq!(tree["size"], serde_json::json!([128, 128]));
        // The trunk stands on the ground, the crown's pins above it.
        assert_eq!(tree["pins"]["B"][1], 127.0);
        assert!(tree["pins"]["L"][0].as_f64() < tree["pins"]["R"][0].as_f64());
        assert!(tree["distortion"]["folded"].as_f64().unwrap() <= 0.01);
        let file = folder
            .path()
            .join("new")
            .join(tree["file"].as_str().unwrap());
        assert!(file.is_file());
    }
}

#[test]
fn bad_pictures_are_reported_and_the_rest_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let library = library(folder.path());
    let picture =
        |width, height, pixel| encode_png(&Image::filled(width, height, pixel), Compression::Fast);
    fs::write(library.join("broken.png"), b"\x89PNG\r\n\x1a\nnothing").unwrap();
    fs::write(library.join("empty.png"), b"").unwrap();
    fs::write(
        library.join("clear.png"),
        picture(40, 40, Straight([9, 9, 9, 0])),
    )
    .unwrap();
    fs::write(
        library.join("opaque.png"),
        picture(40, 40, Straight([9, 9, 9, 255])),
    )
    .unwrap();
    fs::write(
        library.join("dot.png"),
        picture(1, 1, Straight([9, 9, 9, 255])),
    )
    .unwrap();
    let made = vary(folder.path(), &["--count", "4", "--out", "new"]);
    assert!(made.status.success(), "{made:?}");
    let warnings = String::from_utf8(made.stderr).unwrap();
    for name in ["broken", "empty", "clear", "opaque", "dot"] {
        let lines: Vec<&str> = warnings
            .lines()
            .filter(|l| l.contains(&format!("{name}.png")))
            .collect();
        assert_eq!(lines.len(), 1, "{name} in {warnings}");
        assert!(lines[0].starts_with("warning: "));
    }
    assert_eq!(files(&folder.path().join("new")).len(), 5);

    for name in ["0", "1", "2", "3"] {
        fs::remove_file(library.join(format!("{name}.png"))).unwrap();
    }
    let none = vary(folder.path(), &["--count", "4", "--out", "none"]);
    assert_eq!(none.status.code(), Some(2));
    let errors = String::from_utf8(none.stderr).unwrap();
    assert_eq!(
        errors
            .lines()
            .filter(|line| line.starts_with("error: "))
            .count(),
        1,
        "{errors}"
    );
    assert!(!folder.path().join("none").exists());
}

#[test]
fn variations_of_a_target_go_as_far_as_asked() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    fs::write(folder.path().join("mine.png"), tree(66, 200)).unwrap();
    let mut differences = Vec::new();
    for strength in ["0", "0.5", "1"] {
        let out = format!("out{strength}");
        let made = vary(
            folder.path(),
            &[
                "--target",
                "mine.png",
                "--strength",
                strength,
                "--count",
                "3",
                "--out",
                &out,
            ],
        );
        assert!(made.status.success(), "{made:?}");
        let record: Value = serde_json::from_slice(
            &fs::read(folder.path().join(&out).join("library.json")).unwrap(),
        )
        .unwrap();
        let trees = record["trees"].as_array().unwrap();
        assert!(
            trees
                .iter()
                .all(|tree| tree["exemplars"][0]["file"] == "mine.png")
        );
        let share = |tree: &Value| tree["contour_weights"][0].as_f64().unwrap();
        differences.push(trees.iter().map(|tree| 1.0 - share(tree)).sum::<f64>());
    }
    assert_eq!(differences[0], 0.0);
    assert!(differences[0] < differences[1] && differences[1] < differences[2]);
    assert!(
        differences[2] <= 1.5,
        "half of the outline stays the target's"
    );
}

#[test]
fn trees_of_one_picture_differ_unless_told_otherwise() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    for file in ["1.png", "2.png", "3.png"] {
        fs::remove_file(folder.path().join("library").join(file)).unwrap();
    }
    let pictures = |out: &str, strength: &str| {
        let asked = ["--mix", "1", "--count", "3", "--strength", strength];
        let made = vary(folder.path(), &[&asked[..], &["--out", out]].concat());
        assert!(made.status.success(), "{made:?}");
        let file = |i: u32| folder.path().join(format!("{out}/tree_000{i}.png"));
        [0, 1, 2].map(|i| image::open(file(i)).unwrap())
    };
    let plain = pictures("plain", "0");
    assert!(plain[0] == plain[1] && plain[1] == plain[2]);
    let moved = pictures("moved", "0.7");
    assert!(moved[0] != moved[1] && moved[1] != moved[2] && moved[0] != moved[2]);
    assert!(moved.iter().all(|picture| *picture != plain[0]));
    // The record is enough to make the second again.
    let recipe = [
        "vary",
        "--recipe",
        "moved/library.json#tree_0001",
        "--out",
        "again",
    ];
    assert!(boscage(folder.path(), &recipe).status.success());
    let again = image::open(folder.path().join("again/tree_0001.png"));
    assert_eq!(again.unwrap(), moved[1]);
}

/// The record of the folder `out`.
fn record(folder: &Path, out: &str) -> Value {
    let file = folder.join(out).join("library.json");
    serde_json::from_slice(&fs::read(file).unwrap()).unwrap()
}

#[test]
fn each_tree_gets_a_crown_that_is_drawn_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    let crowns = ["--count", "2", "--crowns", "--crown-size", "32"];
    let run = |extra: &[&str]| vary(folder.path(), &[&crowns, extra].concat());
    let made = run(&["--out", "new"]);
    assert!(made.status.success(), "{made:?}");
    let new = folder.path().join("new");
    assert_eq!(
        record(folder.path(), "new")["trees"][1]["crown"],
        serde_json::json!({"folder": "crowns/tree_0001", "size": 32})
    );
    assert!(new.join("tree_0000.normal.png").is_file());
    let of = |out: &str| files(&folder.path().join(out).join("crowns/tree_0001"));
    let crown = of("new");
    assert!(crown.iter().any(|(name, _)| name == "crown.json"));
    assert!(crown.iter().any(|(name, _)| name == "radius_py.png"));

    // Shards, threads and a recipe give the same bytes; what was lost comes back.
    for shard in ["1/2", "0/2"] {
        assert!(
            run(&["--shard", shard, "--threads", "1", "--out", "shards"])
                .status
                .success()
        );
    }
    assert!(of("shards") == crown);
    let recipe = [
        "vary",
        "--recipe",
        "new/library.json#tree_0001",
        "--out",
        "again",
    ];
    assert!(boscage(folder.path(), &recipe).status.success());
    assert!(of("again") == crown);
    fs::remove_file(new.join("crowns/tree_0001/radius_py.png")).unwrap();
    let picture = fs::metadata(new.join("tree_0001.png")).unwrap().modified();
    assert_eq!(run(&["--out", "new"]).status.code(), Some(2));
    assert!(run(&["--resume", "--out", "new"]).status.success());
    assert!(of("new") == crown);
    let kept = fs::metadata(new.join("tree_0001.png")).unwrap().modified();
    assert_eq!(picture.unwrap(), kept.unwrap());

    let drawn = boscage(
        folder.path(),
        &[
            "render",
            "new/crowns/tree_0001",
            "--backend",
            "cpu",
            "--samples",
            "1",
            "--size",
            "48",
            "48",
            "--yaw",
            "90",
            "--out",
            "side.png",
        ],
    );
    assert!(drawn.status.success(), "{drawn:?}");
    let exported = boscage(
        folder.path(),
        &[
            "export",
            "new/crowns",
            "--preset",
            "blender",
            "--no-impostors",
            "--out",
            "engine",
        ],
    );
    assert!(exported.status.success(), "{exported:?}");
    let engine = record(folder.path(), "engine");
    assert_eq!(engine["crowns"].as_array().unwrap().len(), 2);
    assert!(engine["crowns"][0]["recipe"]["tree"]["exemplars"].is_array());
}

/// The exemplars of a recorded tree with their shares of its outline, by name.
fn shares_of(tree: &Value) -> Vec<(String, f64)> {
    let parts = tree["exemplars"].as_array().unwrap().iter();
    let weights = tree["contour_weights"].as_array().unwrap();
    let mut shares: Vec<(String, f64)> = parts
        .zip(weights)
        .map(|(part, weight)| (part["file"].to_string(), weight.as_f64().unwrap()))
        .filter(|(_, weight)| *weight > 0.0)
        .collect();
    shares.sort_by(|a, b| a.0.cmp(&b.0));
    shares
}

#[test]
fn trees_are_bred_from_trees_and_keep_what_is_locked() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    assert!(
        vary(folder.path(), &["--count", "4", "--out", "new"])
            .status
            .success()
    );
    let breed = |extra: &[&str]| {
        let parents = [
            "vary",
            "--library",
            "library",
            "--parents",
            "new/library.json#tree_0000",
            "new/library.json#tree_0002",
            "--count",
            "3",
        ];
        boscage(folder.path(), &[&parents, extra].concat())
    };
    let made = breed(&["--lock", "contour,hue", "--out", "next"]);
    assert!(made.status.success(), "{made:?}");
    let parents = record(folder.path(), "new");
    let contours = [0, 2].map(|index| shares_of(&parents["trees"][index]));
    let next = record(folder.path(), "next");
    for tree in next["trees"].as_array().unwrap() {
        assert!(contours.contains(&shares_of(tree)), "{tree}");
        assert!(tree["shift"].is_null(), "the hue is locked");
        assert_eq!(tree["parents"].as_array().unwrap().len(), 2);
        assert_eq!(tree["size"], serde_json::json!([128, 128]));
    }
    assert!(
        breed(&["--threads", "1", "--lock", "contour,hue", "--out", "one"])
            .status
            .success()
    );
    let pictures = |out: &str| files(&folder.path().join(out));
    assert!(pictures("next") == pictures("one"));
    let again = [
        "vary",
        "--recipe",
        "next/library.json#tree_0001",
        "--out",
        "again",
    ];
    assert!(boscage(folder.path(), &again).status.success());
    let read = |out: &str| fs::read(folder.path().join(out).join("tree_0001.png")).unwrap();
    assert!(read("next") == read("again"));

    // Without locks hues move, and later generations go on from there.
    assert!(breed(&["--out", "free"]).status.success());
    assert!(record(folder.path(), "free")["trees"][0]["shift"]["hue"].is_number());
    assert!(
        breed(&["--generation", "3", "--out", "later"])
            .status
            .success()
    );
    assert!(read("free") != read("later"));
    // Children may be parents, also without a library: then only exemplars of parents are used.
    let on = [
        "vary",
        "--parents",
        "free/library.json#tree_0000",
        "--count",
        "1",
        "--out",
        "on",
    ];
    let on = boscage(folder.path(), &on);
    assert!(on.status.success(), "{on:?}");

    let missing = ["vary", "--parents", "new/library.json#tree_9", "--out", "x"];
    assert_eq!(boscage(folder.path(), &missing).status.code(), Some(2));
    fs::write(folder.path().join("library/0.png"), tree(61, 150)).unwrap();
    fs::write(folder.path().join("library/1.png"), tree(71, 150)).unwrap();
    fs::write(folder.path().join("library/2.png"), tree(81, 150)).unwrap();
    fs::write(folder.path().join("library/3.png"), tree(77, 150)).unwrap();
    let changed = breed(&["--out", "x"]);
    assert_eq!(changed.status.code(), Some(2), "{changed:?}");
    assert!(!folder.path().join("x").exists());
}

#[test]
fn copies_repeat_and_the_pair_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let row = folder.path().join("row");
    fs::create_dir(&row).unwrap();
    fs::write(row.join("a.png"), tree(60, 150)).unwrap();
    fs::write(row.join("b.png"), tree(90, 180)).unwrap();
    fs::write(row.join("c.png"), tree(60, 150)).unwrap();
    let score = |arguments: &[&str]| boscage(folder.path(), &[&["score"], arguments].concat());
    let made = score(&[
        "row",
        "--json",
        "--against",
        "row/a.png",
        "--sheet",
        "sheet.png",
    ]);
    assert!(made.status.success(), "{made:?}");
    let answer: Value = serde_json::from_slice(&made.stdout).unwrap();
    assert_eq!(answer["trees"], 3);
    let pair = &answer["row"]["pairs"][0];
    assert_eq!((&pair["a"], &pair["b"]), (&"a.png".into(), &"c.png".into()));
    assert!(pair["score"].as_f64().unwrap() > 0.99);
    let row = answer["row"]["score"].as_f64().unwrap();
    assert!((0.6..=1.0).contains(&row), "{row}");
    assert!(answer["copies"]["row"].as_f64().unwrap() > 0.99);
    assert!(answer["jittered"]["row"].as_f64().unwrap() > 0.9);
    assert!(folder.path().join("sheet.png").is_file());
    let told = score(&["row"]);
    let told = String::from_utf8(told.stdout).unwrap();
    assert!(
        told.contains("most alike in the row: a.png and c.png"),
        "{told}"
    );
    assert_eq!(score(&["row", "nowhere.png"]).status.code(), Some(2));
    assert_eq!(
        score(&["row", "--sheet", "sheet.png"]).status.code(),
        Some(2)
    );
}

#[test]
fn seasons_change_crowns_only_and_not_evergreens() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    let season = |arguments: &[&str]| boscage(folder.path(), &[&["season"], arguments].concat());
    let autumn = ["library", "--season", "autumn", "--season-amount", "0.9"];
    for (out, threads) in [("one", "1"), ("two", "2")] {
        let run = season(&[&autumn[..], &["--threads", threads, "--out", out]].concat());
        assert!(run.status.success(), "{run:?}");
    }
    assert!(files(&folder.path().join("one")) == files(&folder.path().join("two")));
    let kept = season(&[&autumn[..], &["--evergreen", "yes", "--out", "green"]].concat());
    assert!(kept.status.success());
    let read = |path: &str| {
        let path = folder.path().join(path);
        boscage::raster::read_image(&path, boscage::raster::ReadLimits::default()).unwrap()
    };
    let (before, turned) = (read("library/0.png"), read("one/0.png"));
    assert_eq!(read("green/0.png"), before);
    let changed = |rows: std::ops::Range<u32>| {
        let places = rows.flat_map(|y| (0..60).map(move |x| (x, y)));
        let seen = places.filter(|&(x, y)| before.at(x, y).alpha() > 0);
        let far = |(x, y): &(u32, u32)| {
            let (a, b) = (before.at(*x, *y).0, turned.at(*x, *y).0);
            a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1])) > 16
        };
        let seen: Vec<(u32, u32)> = seen.collect();
        seen.iter().filter(|place| far(place)).count() as f64 / seen.len() as f64
    };
    assert!(changed(0..40) > 0.6, "{}", changed(0..40));
    assert_eq!(changed(74..96), 0.0, "the trunk turned");
    for bad in [
        &["library", "--out", "x"][..],
        &[
            "library",
            "--season",
            "autumn",
            "--season-amount",
            "1.5",
            "--out",
            "x",
        ],
        &["nowhere", "--season", "winter", "--out", "x"],
    ] {
        assert_eq!(season(bad).status.code(), Some(2), "{bad:?}");
    }
    let resumed = season(&[&autumn[..], &["--resume", "--out", "one"]].concat());
    assert!(resumed.status.success());
    assert_eq!(
        season(&[&autumn[..], &["--out", "one"]].concat())
            .status
            .code(),
        Some(2)
    );
}

#[test]
fn what_is_there_is_refused_kept_or_replaced() {
    let folder = tempfile::tempdir().unwrap();
    library(folder.path());
    let run = |extra: &[&str]| {
        vary(
            folder.path(),
            &[&["--count", "3", "--out", "new"], extra].concat(),
        )
    };
    assert!(run(&[]).status.success());
    let first = files(&folder.path().join("new"));
    assert_eq!(run(&[]).status.code(), Some(2));
    // A lost and a damaged tree come back, the others are not touched.
    let path = |name: &str| folder.path().join("new").join(name);
    fs::remove_file(path("tree_0000.png")).unwrap();
    fs::write(path("tree_0001.png"), b"damaged").unwrap();
    let kept = fs::metadata(path("tree_0002.png"))
        .unwrap()
        .modified()
        .unwrap();
    assert!(run(&["--resume"]).status.success());
    assert!(first == files(&folder.path().join("new")));
    assert_eq!(
        kept,
        fs::metadata(path("tree_0002.png"))
            .unwrap()
            .modified()
            .unwrap()
    );
    assert!(run(&["--seed", "4", "--overwrite"]).status.success());
    assert!(first != files(&folder.path().join("new")));
}
