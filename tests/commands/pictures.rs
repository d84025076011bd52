//! The commands that draw: `inspect`, `morph`, `table` and `samples`, run as users run them.

use boscage::raster::{
    Compression, Image, ReadLimits, Straight, encode_grey_png, encode_png, read_image,
};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use tempfile::TempDir;

fn boscage(arguments: &[&str]) -> Output {
    let binary = env!("CARGO_BIN_EXE_boscage");
    Command::new(binary).args(arguments).output().unwrap()
}

/// Runs the command with `--json`; it must succeed and print one object.
fn answer(arguments: &[&str]) -> Value {
    let output = boscage(&[arguments, &["--json"]].concat());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {told}");
    serde_json::from_slice(&output.stdout).unwrap()
}

/// Runs the command, which must refuse its input; the one line that it says.
fn refusal(arguments: &[&str]) -> String {
    let output = boscage(arguments);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {told}");
    assert_eq!(told.lines().count(), 1, "{told}");
    told
}

fn read(path: impl AsRef<Path>) -> Image<Straight> {
    read_image(path.as_ref(), ReadLimits::default()).unwrap()
}

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

/// A green disc of radius 30 around (50, 40) on a brown trunk, columns 46 to 53, down to row 99.
fn mushroom() -> (Image<Straight>, Image<u8>) {
    let mut image = Image::filled(100, 110, Straight([0; 4]));
    let mut labels = Image::filled(100, 110, 0u8);
    for y in 0..100u32 {
        for x in 0..100u32 {
            let from_centre = (f64::from(x) - 50.0).hypot(f64::from(y) - 40.0);
            let (color, label) = if from_centre <= 30.0 {
                let light = (x * 7 + y * 13) % 40;
                ([30 + light as u8, 110 + light as u8, 20, 255], 255)
            } else if (46..54).contains(&x) && y > 40 {
                ([90, 60, 30, 255], 128)
            } else {
                continue;
            };
            image.set(x, y, Straight(color));
            labels.set(x, y, label);
        }
    }
    (image, labels)
}

/// A folder with mushroom.png and mushroom.labels.png.
fn folder() -> (TempDir, PathBuf, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (image, labels) = mushroom();
    let picture = folder.path().join("mushroom.png");
    let label_file = folder.path().join("mushroom.labels.png");
    std::fs::write(&picture, encode_png(&image, Compression::Fast)).unwrap();
    std::fs::write(&label_file, encode_grey_png(&labels, Compression::Fast)).unwrap();
    (folder, picture, label_file)
}

/// The first bundled sample of each species in a folder of their own.
fn library() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let third = ["--shard", "0/3"];
    answer(
        &[
            &["samples", "--bundled", "--out", text(folder.path())][..],
            &third,
        ]
        .concat(),
    );
    folder
}

fn xy(value: &Value) -> (f64, f64) {
    (value[0].as_f64().unwrap(), value[1].as_f64().unwrap())
}

#[test]
fn inspect_tells_all_keys_and_pins_the_mushroom() {
    let (_folder, picture, labels) = folder();
    let picture = text(&picture);
    let size = ["--size", "180", "--points", "200", "--simplified", "40"];
    for given in [
        &["--labels", text(&labels)][..],
        &["--segmenter", "classical"],
    ] {
        let found = answer(&[&["inspect", picture][..], &size, given].concat());
        assert_eq!(found["image"]["width"], 100);
        assert_eq!(
            found["normalized"]["crop"],
            serde_json::json!([20, 10, 61, 90])
        );
        assert_eq!(found["normalized"]["scale"], 2.0);
        assert_eq!(xy(&found["normalized"]["offset"]), (29.0, 0.0));
        let contours = &found["contours"];
        assert_eq!(contours["count"], 1);
        assert_eq!(
            (&contours["exterior"], &contours["interior"]),
            (&1.into(), &0.into())
        );
        let pins = &found["pins"];
        assert_eq!(contours["longest"][0], pins["B"]);
        assert_eq!(found["resampled"][0], pins["B"]);
        assert_eq!(found["resampled"].as_array().unwrap().len(), 200);
        assert_eq!(found["simplified"].as_array().unwrap().len(), 40);
        assert!(found["segmentation"]["crown_pixels"].as_u64().unwrap() > 10_000);
        assert!(found["seconds"]["contours"].is_number());
        // The trunk enters the disc at row 69.7 of the picture: at 119 of the normalised one.
        let baseline = found["segmentation"]["baseline_y"].as_f64().unwrap();
        assert!((baseline - 119.0).abs() < 5.0, "{baseline}");
        let ((bx, by), (lx, ly), (rx, ry)) = (xy(&pins["B"]), xy(&pins["L"]), xy(&pins["R"]));
        assert_eq!(by, 179.0);
        assert!((bx - 89.0).abs() < 3.0, "{bx}");
        assert!(
            lx < bx && bx < rx && ly <= baseline && ry <= baseline,
            "{pins}"
        );
        let source = found["segmentation"]["source"].as_str().unwrap();
        assert_eq!(
            source,
            if given.contains(&"--labels") {
                "labels"
            } else {
                "classical"
            }
        );
    }
}

#[test]
fn inspect_dumps_pictures_that_agree() {
    let (folder, picture, _) = folder();
    let dump = folder.path().join("dump");
    let arguments = [
        "inspect",
        text(&picture),
        "--size",
        "96",
        "--dump",
        text(&dump),
    ];
    answer(&arguments);
    let (normalized, mask) = (
        read(dump.join("normalized.png")),
        read(dump.join("mask.png")),
    );
    let labels = read(dump.join("labels.png"));
    for (image, (mask, label)) in normalized
        .pixels()
        .iter()
        .zip(mask.pixels().iter().zip(labels.pixels()))
    {
        let opaque = image.alpha() > 127;
        assert_eq!(mask.0[0], if opaque { 255 } else { 0 });
        assert_eq!(label.0[0] > 0, opaque);
    }
    assert!(read(dump.join("overlay.png")).width() > 96);
    assert!(refusal(&arguments).contains("--overwrite"));
    answer(&[&arguments[..], &["--resume"]].concat());
}

#[test]
fn inspect_looks_at_odd_pictures_and_refuses_empty_ones() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, image: &Image<Straight>| {
        let path = folder.path().join(name);
        std::fs::write(&path, encode_png(image, Compression::Fast)).unwrap();
        path
    };
    let opaque = Straight([40, 90, 30, 255]);
    for (name, image) in [
        ("opaque.png", Image::filled(40, 30, opaque)),
        ("dot.png", Image::filled(1, 1, opaque)),
        ("line.png", Image::filled(1, 300, opaque)),
    ] {
        let path = file(name, &image);
        let found = answer(&["inspect", text(&path), "--size", "16"]);
        assert_eq!(found["resampled"].as_array().unwrap().len(), 2000, "{name}");
    }
    let clear = file("clear.png", &Image::filled(40, 30, Straight([9, 9, 9, 5])));
    assert!(refusal(&["inspect", text(&clear)]).contains("fully transparent"));
    let dot = folder.path().join("dot.png");
    for wrong in [
        &["--size", "15"][..],
        &["--threshold", "1"],
        &["--threshold", "nan"],
        &["--points", "9"],
        &["--points", "50", "--simplified", "51"],
        &["--labels", text(&folder.path().join("opaque.png"))],
    ] {
        refusal(&[&["inspect", text(&dot)], wrong].concat());
    }
}

#[test]
fn a_morph_begins_and_ends_with_its_exemplars() {
    let library = library();
    let (from, to) = (
        library.path().join("oak_01.png"),
        library.path().join("spruce_01.png"),
    );
    let out = library.path().join("frames");
    let sheet = library.path().join("sheet.png");
    let arguments = [
        "morph",
        text(&from),
        text(&to),
        "--steps",
        "3",
        "--size",
        "128",
    ];
    let sheet_too = ["--out", text(&out), "--sheet", text(&sheet)];
    let told = answer(&[&arguments[..], &sheet_too].concat());
    let frames = told["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 3);
    assert_eq!(frames[1]["t"], 0.5);
    assert!(frames[1]["distortion"]["folded"].is_number());
    assert!(read(&sheet).width() >= 3 * 320);
    for (picture, frame) in [(&from, "frame_0000.png"), (&to, "frame_0002.png")] {
        let dump = out.join("dump");
        answer(&[
            "inspect",
            text(picture),
            "--size",
            "128",
            "--dump",
            text(&dump),
            "--overwrite",
        ]);
        let exemplar = read(dump.join("normalized.png")).premultiplied();
        let made = read(out.join(frame)).premultiplied();
        let pairs = exemplar.pixels().iter().zip(made.pixels());
        let off: u64 = pairs
            .flat_map(|(a, b)| a.0.into_iter().zip(b.0))
            .map(|(a, b)| u64::from(a.abs_diff(b)))
            .sum();
        let mean = off as f64 / (4.0 * 128.0 * 128.0);
        assert!(mean < 2.0, "{frame} is off by {mean}");
    }
}

#[test]
fn frames_are_the_same_for_any_threads_and_shards_and_may_be_resumed() {
    let library = library();
    let (from, to) = (
        library.path().join("pine_01.png"),
        library.path().join("birch_01.png"),
    );
    let frames = |name: &str, given: &[&str]| {
        let out = library.path().join(name);
        let arguments = [
            "morph",
            text(&from),
            text(&to),
            "--steps",
            "4",
            "--size",
            "96",
            "--out",
            text(&out),
        ];
        answer(&[&arguments[..], given].concat());
        (0..4)
            .map(|i| std::fs::read(out.join(format!("frame_000{i}.png"))).ok())
            .collect::<Vec<_>>()
    };
    let one = frames("one", &["--threads", "1"]);
    assert!(one.iter().all(Option::is_some));
    assert_eq!(frames("two", &["--threads", "2"]), one);
    let half = frames("half", &["--shard", "1/2"]);
    assert_eq!((&half[0], &half[1]), (&None, &one[1]));
    assert_eq!(frames("half", &["--resume"]), one);
}

#[test]
fn a_table_crosses_what_can_be_used() {
    let library = library();
    std::fs::write(library.path().join("broken.png"), b"no picture").unwrap();
    let table = |name: &str, given: &[&str]| {
        let out = library.path().join("tables").join(name);
        let arguments = [
            "table",
            "--library",
            text(library.path()),
            "--out",
            text(&out),
        ];
        (
            answer(&[&arguments[..], given].concat()),
            std::fs::read(&out).unwrap(),
        )
    };
    let (told, one) = table("one.png", &["--limit", "3", "--threads", "1"]);
    let count = told["exemplars"].as_array().unwrap().len();
    assert!((2..=3).contains(&count));
    let sheet = read(library.path().join("tables/one.png"));
    assert_eq!(told["width"], sheet.width());
    assert_eq!(sheet.width(), (count as u32 + 1) * 240 + 3 * 48);
    assert_eq!(told["distortion"][0][0], Value::Null);
    assert!(told["distortion"][0][1]["stretch"].is_number());
    let (_, two) = table("two.png", &["--limit", "3", "--threads", "2"]);
    assert!(one == two, "threads change nothing");
    let (_, contours) = table("contours.png", &["--limit", "3", "--kind", "contours"]);
    assert!(one != contours);
    let (_folder, alone, _) = folder();
    std::fs::remove_file(alone.with_file_name("mushroom.labels.png")).unwrap();
    let out = library.path().join("none.png");
    refusal(&[
        "table",
        "--library",
        text(alone.parent().unwrap()),
        "--out",
        text(&out),
    ]);
    refusal(&["table", "--library", "no such folder", "--out", text(&out)]);
}

#[test]
fn samples_are_written_bundled_or_grown() {
    let library = library();
    let names: Vec<PathBuf> = std::fs::read_dir(library.path())
        .unwrap()
        .map(|e| e.unwrap().path())
        .collect();
    assert_eq!(names.len(), 12);
    let sizes = [&names[0], &names[11]].map(|name| read(name).height());
    assert_eq!(sizes, [1536; 2]);
    let folder = tempfile::tempdir().unwrap();
    let few = [
        "--species",
        "pine,palm",
        "--individuals",
        "2",
        "--first",
        "3",
    ];
    let small = ["samples", "--height", "48", "--out", text(folder.path())];
    let small = [&small[..], &few, &["--layers"]].concat();
    let told = answer(&small);
    let samples = told["samples"].as_array().unwrap();
    assert_eq!(samples.len(), 4);
    for sample in samples {
        let image = read(sample["file"].as_str().unwrap());
        let labels = read(sample["labels"].as_str().unwrap());
        assert_eq!((image.width(), image.height()), (32, 48));
        assert_eq!((labels.width(), labels.height()), (32, 48));
        let legend = std::fs::read(sample["layers"][2].as_str().unwrap()).unwrap();
        let legend: serde_json::Value = serde_json::from_slice(&legend).unwrap();
        assert!(legend["height_m"].as_f64().unwrap() > 2.0);
        assert!(legend["depth"]["step_m"].as_f64().unwrap() > 0.0);
    }
    refusal(&small);
    assert_eq!(
        answer(&[&small[..], &["--resume"]].concat())["samples"],
        told["samples"]
    );
    let out = text(folder.path());
    refusal(&["samples", "--species", "baobab", "--out", out]);
    refusal(&[
        "samples",
        "--bundled",
        "--height",
        "99",
        "--out",
        text(folder.path()),
    ]);
}
