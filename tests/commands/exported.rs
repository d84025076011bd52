//! Small libraries and crowns to export, and what tests ask of an exported folder.

use boscage::raster::{Compression, Image, Straight, encode_grey_png, encode_png};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// An oval crown of speckled green on a trunk, 96 pixels high.
fn tree(width: u32, green: u8) -> Vec<u8> {
    let mut image = Image::filled(width, 96, Straight([0; 4]));
    let (middle, radius) = (f64::from(width) / 2.0, f64::from(width) / 2.0 - 2.0);
    for y in 0..96u32 {
        for x in 0..width {
            let (dx, dy) = (f64::from(x) + 0.5 - middle, f64::from(y) - 34.0);
            let shade = (x * 7 + y * 13) as u8 % 40;
            if (dx / radius).powi(2) + (dy / 33.0).powi(2) < 1.0 {
                image.set(x, y, Straight([30 + shade, green - shade, 30, 255]));
            } else if y > 60 && dx.abs() < 4.0 {
                image.set(x, y, Straight([90 - shade, 60, 40, 255]));
            }
        }
    }
    encode_png(&image, Compression::Fast)
}

pub(crate) fn boscage(folder: &Path, arguments: &[&str]) -> Output {
    command(folder, arguments).output().unwrap()
}

/// `boscage` with `arguments`, to be run in `folder`.
pub(crate) fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_boscage"));
    command.args(arguments).current_dir(folder);
    command.env("BOSCAGE_CACHE", folder.join("cache"));
    command
}

/// A folder with `new/library.json` of three trees at 128 pixels.
pub(crate) fn library() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("exemplars")).unwrap();
    for (width, green) in [(60, 150), (70, 170), (80, 190)] {
        let file = folder.path().join(format!("exemplars/{width}.png"));
        fs::write(file, tree(width, green)).unwrap();
    }
    let vary = [
        "vary",
        "--library",
        "exemplars",
        "--count",
        "3",
        "--size",
        "128",
        "--out",
        "new",
    ];
    succeeded(&boscage(folder.path(), &vary));
    folder
}

pub(crate) fn succeeded(output: &Output) {
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
}

pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

pub(crate) fn files_below(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(files_below(&path));
        } else {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The part of JSON Schema that ours uses; also complains of keys that the schema does not describe.
fn check(value: &Value, schema: &Value, root: &Value, at: &str, complaints: &mut Vec<String>) {
    if let Some(reference) = schema["$ref"].as_str() {
        let target = root.pointer(reference.trim_start_matches('#')).unwrap();
        return check(value, target, root, at, complaints);
    }
    let mut fail = |reason: &str| complaints.push(format!("{at} {reason}"));
    let is_type = match schema["type"].as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("number") => value.is_number(),
        Some("integer") => value.is_u64(),
        _ => true,
    };
    if !is_type {
        return fail("has the wrong type");
    }
    if schema
        .get("const")
        .is_some_and(|constant| constant != value)
    {
        fail("is not the constant");
    }
    if schema["enum"]
        .as_array()
        .is_some_and(|values| !values.contains(value))
    {
        fail("is none of the values");
    }
    if schema["minItems"]
        .as_u64()
        .is_some_and(|least| (value.as_array().unwrap().len() as u64) < least)
    {
        fail("has too few items");
    }
    for key in schema["required"].as_array().into_iter().flatten() {
        if value.get(key.as_str().unwrap()).is_none() {
            fail(&format!("lacks {key}"));
        }
    }
    for (index, item) in value.as_array().into_iter().flatten().enumerate() {
        check(
            item,
            &schema["items"],
            root,
            &format!("{at}[{index}]"),
            complaints,
        );
    }
    if schema.get("properties").is_none() && schema.get("additionalProperties").is_none() {
        return;
    }
    for (key, item) in value.as_object().into_iter().flatten() {
        let described = schema["properties"]
            .get(key)
            .or(schema.get("additionalProperties"));
        match described {
            Some(described) => check(item, described, root, &format!("{at}.{key}"), complaints),
            None => complaints.push(format!("{at}.{key} is not described")),
        }
    }
}

/// What in `library` does not keep to `docs/library.schema.json`.
pub(crate) fn schema_complaints(library: &Value) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let schema = json(&root.join("docs/library.schema.json"));
    let mut complaints = Vec::new();
    check(library, &schema, &schema, "library", &mut complaints);
    complaints
}

/// All files that `library.json` in `out` lists, itself and the README included; `kind` is `trees` or
/// `crowns`.
pub(crate) fn listed(library: &Value, out: &Path, kind: &str) -> BTreeSet<PathBuf> {
    let items = library[kind].as_array().unwrap().iter();
    let of_items = items.flat_map(|item| item["files"].as_object().unwrap().values());
    let shared = library["files"].as_object().unwrap().iter();
    let shared = shared
        .filter(|(key, _)| *key != "flightgear_varieties")
        .flat_map(|(_, list)| list.as_array().unwrap());
    let listed = of_items.chain(shared).map(|file| file.as_str().unwrap());
    let fixed = ["library.json", "README.txt"].into_iter();
    listed.chain(fixed).map(|file| out.join(file)).collect()
}

/// All files below `root` with their contents, but the hidden ones that a killed process leaves.
pub(crate) fn contents(root: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let is_hidden = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with(".boscage-"))
    };
    let files = files_below(root).into_iter();
    files
        .filter(|path| !is_hidden(path))
        .map(|path| {
            let content = fs::read(&path).unwrap();
            (path.strip_prefix(root).unwrap().to_owned(), content)
        })
        .collect()
}

/// A folder with two small crowns, `crowns/round` and `crowns/tall`.
pub(crate) fn crowns() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, tall) in [("round", 1.0), ("tall", 1.6)] {
        write_crown_inputs(folder.path(), tall);
        let out = format!("crowns/{name}");
        let crown = ["crown", "photo.png", "--mask", "mask.png", "--size", "64"];
        let more = ["--out", &out, "--overwrite"];
        succeeded(&boscage(folder.path(), &[&crown[..], &more].concat()));
    }
    folder
}

/// `photo.png` and `mask.png`: an oval of clumps on a blue sky, `tall` times as high as wide.
pub(crate) fn write_crown_inputs(folder: &Path, tall: f64) {
    write_photo_and_mask(folder, |x, y| {
        let (dx, dy) = (f64::from(x) - 64.0, f64::from(y) - 64.0);
        (dx * tall).hypot(dy) < 58.0
    });
}

/// `photo.png` and `mask.png` of 128 pixels: clumps where `inside` says so, on a blue sky.
pub(crate) fn write_photo_and_mask(folder: &Path, inside: impl Fn(u32, u32) -> bool) {
    let photo = (0..128 * 128u32).map(|i| {
        let (x, y) = (i % 128, i / 128);
        let clump = (x / 12 * 71 + y / 12 * 37) % 60;
        let leaf = (x * 7919 + y * 104_729 + x * y * 31) % 50;
        let green = (60 + clump + leaf) as u8;
        match inside(x, y) {
            true => Straight([green / 2, green, green / 4, 255]),
            false => Straight([120, 170, 250, 255]),
        }
    });
    let photo = Image::from_pixels(128, 128, photo.collect());
    let mask = (0..128 * 128).map(|i| 255 * u8::from(inside(i % 128, i / 128)));
    let mask = Image::from_pixels(128, 128, mask.collect());
    let write = |name: &str, bytes: Vec<u8>| fs::write(folder.join(name), bytes).unwrap();
    write("photo.png", encode_png(&photo, Compression::Fast));
    write("mask.png", encode_grey_png(&mask, Compression::Fast));
}
