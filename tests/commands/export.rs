//! `boscage export` as a user runs it: the real binary on a small library, its files read back.

use crate::exported;
use crate::reference;
use boscage::base::Cancel;
use boscage::export::{ALPHA_CUTOFF, coverage, mips};
use boscage::raster::{Image, ReadLimits, Rect, Straight, read_image};
use exported::{
    boscage, contents, files_below, json, library, listed, schema_complaints, succeeded,
};
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

#[test]
fn every_preset_lists_every_file_it_writes_and_no_other() {
    let folder = library();
    for preset in ["blender", "godot", "unity", "unreal", "web", "flightgear"] {
        let mut arguments = vec!["export", "new", "--preset", preset, "--out", preset];
        arguments.extend([
            "--maps",
            "normal,depth,ao,translucency",
            "--textures",
            "dds,ktx2",
        ]);
        if preset != "flightgear" {
            arguments.push("--atlas");
        }
        succeeded(&boscage(folder.path(), &arguments));
        let out = folder.path().join(preset);
        let library = json(&out.join("library.json"));
        assert_eq!(library["preset"], preset);
        let listed = listed(&library, &out, "trees");
        let found: BTreeSet<PathBuf> = files_below(&out).into_iter().collect();
        assert_eq!(listed, found, "{preset}");
    }
}

#[test]
fn trees_stand_on_the_origin_at_the_height_asked_for() {
    let folder = library();
    let export = [
        "export", "new", "--preset", "blender", "--height", "12.5", "--out", "out",
    ];
    succeeded(&boscage(folder.path(), &export));
    for index in 0..3 {
        let path = folder
            .path()
            .join(format!("out/models/tree_000{index}.glb"));
        let file = gltf::Gltf::from_slice_without_validation(&fs::read(&path).unwrap()).unwrap();
        let buffer = file.blob.clone().unwrap();
        assert_eq!(file.meshes().count(), 3, "three levels of detail");
        for mesh in file.meshes() {
            let primitive = mesh.primitives().next().unwrap();
            assert_eq!(primitive.material().alpha_cutoff(), Some(0.5));
            let reader = primitive.reader(|_| Some(&buffer));
            let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
            let top = positions.iter().map(|p| p[1]).fold(f32::MIN, f32::max);
            let bottom = positions.iter().map(|p| p[1]).fold(f32::MAX, f32::min);
            // Cut-outs are grown a little beyond the tree.
            assert!((top - 12.5).abs() < 0.4, "{top}");
            assert!(bottom.abs() < 0.4, "{bottom}");
            let count = positions.len();
            assert_eq!(reader.read_tex_coords(0).unwrap().into_f32().count(), count);
            let wind = primitive
                .attributes()
                .find(|(name, _)| name.to_string() == "_WIND");
            assert_eq!(wind.map(|(_, wind)| wind.count()), Some(count));
        }
    }
}

#[test]
fn shards_threads_and_resume_change_no_byte() {
    let folder = library();
    let export = |out: &str, more: &[&str]| {
        let base = ["export", "new", "--preset", "godot", "--out", out];
        boscage(folder.path(), &[&base, more].concat())
    };
    succeeded(&export("one", &["--threads", "1"]));
    for shard in ["0/2", "1/2"] {
        succeeded(&export("two", &["--shard", shard]));
    }
    succeeded(&export("two", &["--resume"]));
    let content = |out: &str| contents(&folder.path().join(out));
    assert!(content("one") == content("two"), "the folders differ");
    // What is there is refused, and a model that went missing is made again.
    assert_eq!(export("one", &[]).status.code(), Some(2));
    let model = folder.path().join("two/models/tree_0001.glb");
    fs::remove_file(&model).unwrap();
    succeeded(&export("two", &["--resume"]));
    assert!(
        content("one") == content("two"),
        "resuming changed something"
    );
}

#[test]
fn vary_writes_the_maps_asked_for() {
    let folder = library();
    let vary = "vary --library exemplars --count 2 --size 128 --maps normal,depth,ao,translucency";
    let arguments = |more: &'static str| vary.split(' ').chain(more.split(' ')).collect::<Vec<_>>();
    succeeded(&boscage(folder.path(), &arguments("--out maps")));
    let read = |file: &str| {
        let path = folder.path().join("maps").join(file);
        read_image(&path, ReadLimits::default()).unwrap()
    };
    let tree = read("tree_0001.png");
    for map in ["normal", "depth", "ao", "translucency"] {
        let image = read(&format!("tree_0001.{map}.png"));
        assert_eq!(
            (image.width(), image.height()),
            (tree.width(), tree.height())
        );
    }
    // The middle of the crown faces the viewer and stands out.
    assert!(read("tree_0001.normal.png").at(64, 50).0[2] > 200);
    assert!(read("tree_0001.depth.png").at(64, 50).0[0] > 60);
    let before = files_below(&folder.path().join("maps"));
    succeeded(&boscage(folder.path(), &arguments("--out maps --resume")));
    assert_eq!(before, files_below(&folder.path().join("maps")));
}

#[test]
fn bad_libraries_are_refused_in_one_line() {
    let folder = library();
    let record = folder.path().join("new/library.json");
    let text = fs::read_to_string(&record).unwrap();
    for (broken, reason) in [
        (
            text.replace("tree_0001.png", "../tree_0001.png"),
            "outside the folder",
        ),
        (
            text.replace("tree_0001.png", "tree_0000.png"),
            "listed twice",
        ),
        (text.replace("boscage-library", "other"), "not known"),
        ("{".to_owned(), "not a library record"),
    ] {
        fs::write(&record, broken).unwrap();
        let output = boscage(
            folder.path(),
            &["export", "new", "--preset", "godot", "--out", "o"],
        );
        let told = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert!(
            told.contains(reason) && told.trim_end().lines().count() == 1,
            "{told}"
        );
    }
}

#[test]
fn every_example_keeps_to_the_schema() {
    let folder = library();
    let export = [
        "export", "new", "--preset", "web", "--author", "A", "--out", "out",
    ];
    succeeded(&boscage(folder.path(), &export));
    let library = json(&folder.path().join("out/library.json"));
    let complaints = schema_complaints(&library);
    assert!(complaints.is_empty(), "{complaints:?}");
    // The check itself finds what is wrong.
    let mut broken = library;
    broken["trees"][0]["pivot_px"] = serde_json::json!([1]);
    broken["version"] = serde_json::json!(2);
    let complaints = schema_complaints(&broken);
    assert_eq!(complaints.len(), 2, "{complaints:?}");
}

fn mean(image: &Image<Straight>) -> Option<[f64; 3]> {
    let seen: Vec<&Straight> = image
        .pixels()
        .iter()
        .filter(|pixel| pixel.alpha() >= ALPHA_CUTOFF)
        .collect();
    let sum = |c: usize| seen.iter().map(|pixel| f64::from(pixel.0[c])).sum::<f64>();
    (!seen.is_empty()).then(|| [0, 1, 2].map(|c| sum(c) / seen.len() as f64))
}

#[test]
fn real_trees_neither_pale_nor_dissolve_with_distance() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let folder = data.join("billboards");
    for path in files_below(&folder)
        .iter()
        .filter(|path| path.extension().is_some_and(|e| e == "png"))
    {
        let image = read_image(path, ReadLimits::default()).unwrap();
        let whole = |image: &Image<Straight>| Rect {
            x: 0,
            y: 0,
            width: image.width(),
            height: image.height(),
        };
        let (wanted, color) = (coverage(&image, whole(&image)), mean(&image).unwrap());
        for level in mips(&image, &[], &Cancel::new()).unwrap() {
            let texels = level.pixels().len() as f64;
            let found = coverage(&level, whole(&level));
            // A twentieth of the picture, or half a texel where texels are larger than that.
            let allowed = 0.05f64.max(0.5 / texels + 1e-9);
            assert!(
                (found - wanted).abs() <= allowed,
                "{path:?} {texels}: {found} {wanted}"
            );
            for (found, wanted) in mean(&level).iter().flatten().zip(color) {
                assert!(
                    (found - wanted).abs() <= 3.0,
                    "{path:?} {texels}: {found} {wanted}"
                );
            }
        }
    }
}
