//! `boscage inflate` as pipelines call it: the contract of its OBJ files, its JSON and its refusals,
//! and the positions of the public solver where the reference results are there.

use crate::reference;
use boscage::raster::{Compression, Image, encode_grey_png};
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output};

fn run(folder: &Path, words: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_boscage"));
    command.current_dir(folder).arg("inflate").args(words);
    command.output().unwrap()
}

fn answer(folder: &Path, words: &[&str]) -> Value {
    let output = run(folder, words);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{words:?}: {errors}");
    serde_json::from_slice(&output.stdout).unwrap()
}

fn refusal(folder: &Path, words: &[&str]) -> String {
    let output = run(folder, words);
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{words:?}: {errors}");
    assert_eq!(errors.lines().count(), 1, "{errors}");
    errors
}

/// A disc with a hole of 64 × 64 pixels; greys 100 on the left, 200 on the right.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let value = |i: i32, left: u8, right: u8| {
        let (x, y) = (i % 64 - 32, i / 64 - 32);
        let square = x * x + y * y;
        let inside = (25..=28 * 28).contains(&square);
        if !inside {
            0
        } else if x < 0 {
            left
        } else {
            right
        }
    };
    for (name, left, right) in [
        ("mask.png", 255, 255),
        ("labels.png", 100, 200),
        ("empty.png", 0, 0),
    ] {
        let pixels = (0..64 * 64).map(|i| value(i, left, right)).collect();
        let image = Image::from_pixels(64, 64, pixels);
        let png = encode_grey_png(&image, Compression::Fast);
        std::fs::write(folder.path().join(name), png).unwrap();
    }
    folder
}

fn vertices(path: &Path) -> Vec<[f64; 3]> {
    let text = std::fs::read_to_string(path).unwrap();
    let lines = text.lines().filter_map(|line| line.strip_prefix("v "));
    let numbers = |line: &str| {
        let mut numbers = line.split(' ').map(|word| word.parse().unwrap());
        std::array::from_fn(|_| numbers.next().unwrap())
    };
    lines.map(numbers).collect()
}

#[test]
fn every_method_makes_a_closed_mesh() {
    let folder = place();
    for method in [
        "bilaplacian",
        "radial",
        "distance",
        "distance-sine",
        "iterative",
    ] {
        let out = format!("{method}.obj");
        let words = [
            "mask.png", "--size", "64", "--method", method, "--out", &out, "--json",
        ];
        let told = answer(folder.path(), &words);
        assert_eq!(told["watertight"], true, "{method}");
        assert_eq!(told["genus"], i32::from(method != "radial"), "{method}");
        assert!(told["height"]["max"].as_f64().unwrap() > 0.0);
        for stage in ["assemble", "factor", "solve"] {
            assert!(told["seconds"][stage].is_number(), "{method} {stage}");
        }
        assert_eq!(
            told["unknowns"].as_u64().unwrap() > 0,
            ["bilaplacian", "iterative"].contains(&method)
        );
    }
    for more in [["--copies", "3"], ["--regions", "r.json"]] {
        let regions = r#"{"regions":[{"label":100,"k":1},{"label":200,"k":"1+j","depth_px":4}]}"#;
        std::fs::write(folder.path().join("r.json"), regions).unwrap();
        let words = [
            "labels.png",
            "--size",
            "64",
            more[0],
            more[1],
            "--out",
            "m.glb",
            "--overwrite",
            "--json",
        ];
        let told = answer(folder.path(), &words);
        assert_eq!(
            (&told["watertight"], &told["genus"]),
            (&true.into(), &0.into())
        );
        let file = std::fs::read(folder.path().join("m.glb")).unwrap();
        let (document, ..) = gltf::import_slice(&file).unwrap();
        let bounds = document
            .meshes()
            .next()
            .unwrap()
            .primitives()
            .next()
            .unwrap()
            .bounding_box();
        assert!(
            bounds.min[1].abs() < 0.7 && (bounds.max[1] - 10.0).abs() < 0.7,
            "{bounds:?}"
        );
    }
}

#[test]
fn the_first_vertices_are_the_pixels_by_rows() {
    let folder = place();
    let words = ["mask.png", "--size", "64", "--out", "a.obj", "--json"];
    let told = answer(folder.path(), &words);
    let pixels = told["mask_pixels"].as_u64().unwrap() as usize;
    let vertices = vertices(&folder.path().join("a.obj"));
    let places: Vec<(usize, usize)> = (0..64 * 64)
        .map(|i| (i % 64, i / 64))
        .filter(|&(x, y)| {
            let (x, y) = (x as i64 - 32, y as i64 - 32);
            (25..=28 * 28).contains(&(x * x + y * y))
        })
        .collect();
    assert_eq!(places.len(), pixels);
    for (vertex, &(x, y)) in vertices.iter().zip(&places) {
        // Inner points move a little; those of the silhouette do not.
        assert!((vertex[0] - x as f64).abs() < 12.0 && (vertex[1] - y as f64).abs() < 12.0);
        assert!(vertex[2] >= 0.0);
    }
    let first = places[0];
    assert_eq!(vertices[0], [first.0 as f64, first.1 as f64, 0.0]);
}

#[test]
fn bad_input_is_refused_in_one_line() {
    let folder = place();
    let say = |words: &[&str]| refusal(folder.path(), words);
    assert!(say(&["empty.png", "--out", "a.obj"]).contains("nothing to inflate"));
    assert!(say(&["mask.png", "--out", "a.stl"]).contains("a.stl: must end in .obj or .glb"));
    let typo = say(&["mask.png", "--k", "1+4*x", "--out", "a.obj"]);
    assert!(typo.contains("--k '1+4*x': column 5"), "{typo}");
    let infinite = say(&["mask.png", "--k", "1/(1-j)-9", "--out", "a.obj"]);
    assert!(infinite.contains("at i ="), "{infinite}");
    assert!(
        say(&[
            "mask.png", "--k", "2", "--method", "radial", "--out", "a.obj"
        ])
        .contains("no part")
    );
    std::fs::write(folder.path().join("p.json"), r#"{"components":[[[2,1]]]}"#).unwrap();
    assert!(say(&["mask.png", "--profile", "p.json", "--out", "a.obj"]).contains("p.json"));
    std::fs::write(folder.path().join("r.json"), r#"{"regions":[{"label":3}]}"#).unwrap();
    assert!(say(&["labels.png", "--regions", "r.json", "--out", "a.obj"]).contains("the grey 3"));
    assert!(!folder.path().join("a.obj").exists());
}

#[test]
fn positions_are_those_of_a_public_solver() {
    let Some(oracle) = reference::oracle() else {
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    for name in ["circle", "blob"] {
        let mask = oracle.join(format!("in/mask_{name}_256.png"));
        let words = [
            mask.to_str().unwrap(),
            "--k",
            "2",
            "--out",
            "a.obj",
            "--overwrite",
            "--json",
        ];
        answer(folder.path(), &words);
        let ours = vertices(&folder.path().join("a.obj"));
        let picture = image::open(&mask).unwrap().into_luma8();
        let mut number = 0;
        let numbers: Vec<usize> = picture
            .pixels()
            .map(|pixel| {
                number += usize::from(pixel.0[0] >= 128);
                number.wrapping_sub(1)
            })
            .collect();
        let file = oracle.join(format!("inflate_{name}_256_k2.json"));
        let theirs: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
        let list = |key: &str| theirs[key].as_array().unwrap().clone();
        let mut worst = 0.0f64;
        for (index, xyz) in list("idx").iter().zip(list("xyz")) {
            let vertex = ours[numbers[index.as_u64().unwrap() as usize]];
            for (ours, theirs) in vertex.iter().zip(xyz.as_array().unwrap()) {
                worst = worst.max((ours - theirs.as_f64().unwrap()).abs());
            }
        }
        println!("{name}: at most {worst:e} pixel apart");
        assert!(worst < 1e-5);
    }
}
