//! `boscage export` of crowns as a user runs it: the real binary on two small crowns, its files read
//! back.

use crate::exported;
use boscage::raster::{ReadLimits, read_image};
use exported::{
    boscage, contents, crowns, files_below, json, listed, schema_complaints, succeeded,
};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Small enough to be quick.
const SMALL: [&str; 4] = ["--impostor-frames", "4", "--impostor-frame", "64"];

fn exported(folder: &Path, preset: &str, out: &str, more: &[&str]) {
    let usual = ["export", "crowns", "--preset", preset, "--out", out];
    succeeded(&boscage(folder, &[&usual[..], &SMALL, more].concat()));
}

#[test]
fn every_preset_lists_every_file_it_writes_and_keeps_to_the_schema() {
    let folder = crowns();
    for preset in ["blender", "godot", "unity", "unreal", "web"] {
        exported(folder.path(), preset, preset, &["--exr"]);
        let out = folder.path().join(preset);
        let library = json(&out.join("library.json"));
        let found: BTreeSet<PathBuf> = files_below(&out).into_iter().collect();
        assert_eq!(listed(&library, &out, "crowns"), found, "{preset}");
        let complaints = schema_complaints(&library);
        assert!(complaints.is_empty(), "{preset}: {complaints:?}");
        let names: Vec<&str> = library["crowns"]
            .as_array()
            .unwrap()
            .iter()
            .map(|crown| crown["name"].as_str().unwrap())
            .collect();
        assert_eq!(names, ["round", "tall"]);
    }
    let refused = boscage(
        folder.path(),
        &["export", "crowns", "--preset", "flightgear", "--out", "f"],
    );
    assert_eq!(refused.status.code(), Some(2));
}

#[test]
fn models_stand_on_the_origin_in_four_levels_with_wind_and_single_sides() {
    let folder = crowns();
    exported(folder.path(), "unity", "out", &["--no-impostors"]);
    let library = json(&folder.path().join("out/library.json"));
    for crown in library["crowns"].as_array().unwrap() {
        for (key, counts) in [
            ("model", "leaf_triangles"),
            ("surface", "surface_triangles"),
        ] {
            let path = crown["files"][key].as_str().unwrap();
            let bytes = fs::read(folder.path().join("out").join(path)).unwrap();
            let (document, buffers, _) = gltf::import_slice(&bytes).unwrap();
            let counted: Vec<u64> = document.meshes().map(|mesh| triangles(&mesh)).collect();
            let told = crown[counts].as_array().unwrap().iter();
            assert_eq!(
                counted,
                told.map(|n| n.as_u64().unwrap()).collect::<Vec<_>>()
            );
            assert!(counted.windows(2).all(|pair| pair[1] * 2 < pair[0]));
            let finest = document.meshes().next().unwrap();
            let (mut low, mut high) = (f32::MAX, f32::MIN);
            for primitive in finest.primitives() {
                assert!(!primitive.material().double_sided());
                let wind = primitive.attributes();
                assert!(
                    wind.into_iter()
                        .any(|(name, _)| name.to_string() == "_WIND")
                );
                let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
                for [_, y, _] in reader.read_positions().unwrap() {
                    (low, high) = (low.min(y), high.max(y));
                }
            }
            let height = crown["size_m"][1].as_f64().unwrap();
            assert!(low.abs() < 0.1, "{low}");
            assert!(
                (f64::from(high) / height - 1.0).abs() < 0.1,
                "{high} {height}"
            );
        }
    }
}

fn triangles(mesh: &gltf::Mesh<'_>) -> u64 {
    let counts = mesh
        .primitives()
        .map(|part| part.indices().unwrap().count());
    counts.sum::<usize>() as u64 / 3
}

#[test]
fn a_scene_shows_every_crown_and_a_gallery_holds_its_model() {
    let folder = crowns();
    exported(folder.path(), "web", "out", &["--no-impostors"]);
    let out = folder.path().join("out");
    let scene = fs::read(out.join("scatter.glb")).unwrap();
    let scene = gltf::Gltf::from_slice_without_validation(&scene).unwrap();
    assert_eq!(scene.nodes().count(), 2);
    assert!(
        scene
            .extensions_used()
            .any(|name| name == "EXT_mesh_gpu_instancing")
    );
    let list = fs::read_to_string(out.join("gallery.js")).unwrap();
    for name in ["round", "tall"] {
        let script = fs::read_to_string(out.join(format!("gallery/{name}.js"))).unwrap();
        // "glTF" and version 2, in base 64.
        assert!(script.contains("\"glb\":\"Z2xURgIAAA"), "{name}");
        assert!(list.contains(&format!("gallery/{name}.js")));
        let thumbnail = out.join(format!("gallery/{name}.png"));
        let thumbnail = read_image(&thumbnail, ReadLimits::default()).unwrap();
        let seen = thumbnail.map(|pixel| pixel.alpha() > 127);
        let share = seen.count() as f64 / f64::from(thumbnail.width() * thumbnail.height());
        assert!((0.05..0.8).contains(&share), "{name} {share}");
    }
}

#[test]
fn open_exr_faces_hold_the_radii_in_metres() {
    let folder = crowns();
    exported(
        folder.path(),
        "blender",
        "out",
        &["--no-impostors", "--exr"],
    );
    let cubemaps = folder.path().join("out/cubemaps/tall");
    let record = json(&cubemaps.join("crown.json"));
    let most = record["radius_max_m"].as_f64().unwrap();
    let mut largest = 0.0f32;
    for face in ["px", "nx", "py", "ny", "pz", "nz"] {
        let bytes = fs::read(cubemaps.join(format!("radius_{face}.exr"))).unwrap();
        assert_eq!(bytes[..4], [0x76, 0x2f, 0x31, 0x01]);
        let colors = fs::read(cubemaps.join(format!("color_{face}.exr"))).unwrap();
        assert_eq!(colors.len() % 4, bytes.len() % 4);
        // The last line: as many floats as the face is wide.
        let last = &bytes[bytes.len() - 4 * 32..];
        for value in last.as_chunks::<4>().0 {
            let metres = f32::from_le_bytes(*value);
            assert!(metres > 0.0 && f64::from(metres) < most * 1.001);
            largest = largest.max(metres);
        }
    }
    assert!(f64::from(largest) > most / 4.0);
}

#[test]
fn threads_shards_and_resume_change_no_byte() {
    let folder = crowns();
    let at = folder.path();
    exported(at, "web", "one", &["--threads", "1"]);
    for shard in ["0/2", "1/2"] {
        exported(at, "web", "two", &["--shard", shard]);
    }
    exported(at, "web", "two", &["--resume"]);
    let (one, two) = (contents(&at.join("one")), contents(&at.join("two")));
    assert!(one == two, "the folders differ");
    for lost in [
        "models/tall.glb",
        "gallery/round.js",
        "impostors/tall_full_normal.png",
    ] {
        fs::remove_file(at.join("two").join(lost)).unwrap();
    }
    exported(at, "web", "two", &["--resume"]);
    assert!(
        one == contents(&at.join("two")),
        "resuming changed something"
    );
}

#[test]
fn the_crowns_of_a_project_are_made_and_exported() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let project = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/v1.boscage");
    let usual = ["export", project.to_str().unwrap(), "--preset", "godot"];
    let more = ["--no-impostors", "--leaves", "lobed", "--out", "out"];
    succeeded(&boscage(at, &[&usual[..], &more].concat()));
    let library = json(&at.join("out/library.json"));
    assert_eq!(library["crowns"][0]["name"], "drawn");
    let record = json(&at.join("out/crowns/drawn/crown.json"));
    assert_eq!(record["recipe"]["leaf"], "lobed");
    for made_from in ["photo", "mask"] {
        let file = record["recipe"][made_from].as_str().unwrap();
        read_image(&at.join(file), ReadLimits::default()).unwrap();
    }
    // What is there stays.
    let before = contents(&at.join("out"));
    succeeded(&boscage(at, &[&usual[..], &more, &["--resume"]].concat()));
    assert!(
        before == contents(&at.join("out")),
        "resuming changed something"
    );
}

#[test]
fn a_project_without_a_crown_and_one_that_is_none_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let empty = boscage::document::Document::new().snapshot();
    let bytes = boscage::document::encode(&empty, &boscage::base::Cancel::new()).unwrap();
    fs::write(at.join("empty.boscage"), bytes).unwrap();
    fs::write(at.join("none.boscage"), "a letter").unwrap();
    for (project, reason) in [("empty", "has no crown"), ("none", "")] {
        let project = format!("{project}.boscage");
        let export = ["export", &project, "--preset", "godot", "--out", "out"];
        let refused = boscage(at, &export);
        let told = String::from_utf8(refused.stderr).unwrap();
        assert_eq!(refused.status.code(), Some(2), "{told}");
        assert!(told.starts_with(&format!("error: {project}")), "{told}");
        assert!(told.contains(reason) && told.lines().count() == 1, "{told}");
    }
    assert!(!at.join("out").exists());
}
