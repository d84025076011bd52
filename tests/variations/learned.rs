//! The learned segmenter: what it makes of real pictures, of models that users bring, and of files that
//! are none.
//!
//! Models are written here byte by byte, so that each is wrong in one place. The real pictures are not
//! part of the project (see `reference`).

use crate::reference;
use boscage::base::{Cancel, with_threads};
use boscage::raster::{Compression, Image, ReadLimits, Straight, encode_png, read_image};
use boscage::segment::{
    Auto, Classical, Label, Labels, Learned, ModelError, Segmenter, Source, labels_from_grey,
};
use serde_json::{Value, json};
use std::path::Path;
use std::process::{Command, Output};

/// Side of the inputs of the models made here.
const SIDE: u64 = 32;

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

fn number(field: u64, value: u64) -> Vec<u8> {
    [varint(field << 3), varint(value)].concat()
}

fn bytes(field: u64, content: &[u8]) -> Vec<u8> {
    [
        varint(field << 3 | 2),
        varint(content.len() as u64),
        content.to_vec(),
    ]
    .concat()
}

/// A named tensor of the graph: 1 is 32-bit floating point, 11 is 64-bit.
fn value(name: &str, kind: u64, sides: &[u64]) -> Vec<u8> {
    let sides = sides.iter().map(|&side| bytes(1, &number(1, side)));
    let shape: Vec<u8> = sides.flatten().collect();
    let tensor = [number(1, kind), bytes(2, &shape)].concat();
    [bytes(1, name.as_bytes()), bytes(2, &bytes(1, &tensor))].concat()
}

/// A model of one operator from `image` to the tensor `makes`.
fn model_of(operator: &str, makes: &str, input: Vec<u8>, output: Vec<u8>) -> Vec<u8> {
    let node = [
        bytes(1, b"image"),
        bytes(2, makes.as_bytes()),
        bytes(3, b"only"),
        bytes(4, operator.as_bytes()),
    ]
    .concat();
    let graph = [
        bytes(1, &node),
        bytes(2, b"graph"),
        bytes(11, &input),
        bytes(12, &output),
    ]
    .concat();
    let opset = bytes(8, &number(2, 17));
    [number(1, 8), opset, bytes(7, &graph)].concat()
}

/// A model that gives back what it is given: red speaks for background, green for trunk, blue for crown.
fn mirror() -> Vec<u8> {
    let tensor = |name| value(name, 1, &[1, 3, SIDE, SIDE]);
    model_of("Identity", "logits", tensor("image"), tensor("logits"))
}

/// Its card; a small `spread` makes it sure.
fn card(spread: f64) -> Value {
    json!({
        "format": 1, "name": "mirror",
        "input": {"name": "image", "size": [SIDE, SIDE], "channels": ["r", "g", "b"],
            "mean": [0, 0, 0], "std": [spread, spread, spread]},
        "output": {"name": "logits", "classes": ["background", "trunk", "crown"]},
    })
}

fn learned(model: Vec<u8>, card: &Value) -> Result<Learned, ModelError> {
    Learned::new(model.into(), Some(card.to_string().as_bytes()))
}

/// A photograph for the mirror: blue crown on a green stem before red.
fn photo() -> Image<Straight> {
    let mut photo = Image::filled(96, 128, Straight([230, 0, 0, 255]));
    for y in 10..120 {
        for x in 0..96u32 {
            if y < 70 && (16..80).contains(&x) {
                photo.set(x, y, Straight([0, 0, 230, 255]));
            } else if y >= 70 && (40..56).contains(&x) {
                photo.set(x, y, Straight([0, 230, 0, 255]));
            }
        }
    }
    photo
}

fn overlap(ours: &Labels, truth: &Labels, class: Label) -> f64 {
    let pairs = || ours.pixels().iter().zip(truth.pixels());
    let both = pairs()
        .filter(|(a, b)| **a == class && **b == class)
        .count();
    let either = pairs()
        .filter(|(a, b)| **a == class || **b == class)
        .count();
    both as f64 / either.max(1) as f64
}

#[test]
fn a_models_answer_reaches_the_pixels_it_is_about() {
    let photo = photo();
    let found = learned(mirror(), &card(0.02)).unwrap();
    let found = found.segmented(&photo, &Cancel::new()).unwrap();
    assert_eq!(found.provenance.source, Source::Learned);
    assert!(found.provenance.confidence.unwrap() > 0.8);
    let truth = photo.map(|pixel| match pixel.0 {
        [_, _, 230, _] => Label::Crown,
        [_, 230, _, _] => Label::Trunk,
        _ => Label::Background,
    });
    assert!(overlap(&found.labels, &truth, Label::Crown) > 0.97);
    assert!(overlap(&found.labels, &truth, Label::Trunk) > 0.9);
}

#[test]
fn classes_and_channels_may_stand_in_any_order() {
    let mut other = card(0.02);
    // Blue first: what was crown's plane is now the first, and so on.
    other["input"]["channels"] = json!(["b", "r", "g"]);
    other["output"]["classes"] = json!(["crown", "background", "trunk"]);
    let photo = photo();
    let labels = |card: &Value| {
        let learned = learned(mirror(), card).unwrap();
        learned.segment(&photo, &Cancel::new()).unwrap()
    };
    assert_eq!(labels(&other), labels(&card(0.02)));
}

#[test]
fn a_network_that_is_unsure_hands_over_to_the_rules() {
    let unsure = Auto::with(learned(mirror(), &card(1.0)).unwrap());
    let tree = photo().map(|pixel| match pixel.0 {
        [230, ..] => Straight([0; 4]),
        _ => *pixel,
    });
    let found = unsure.segmented(&tree, &Cancel::new()).unwrap();
    assert_eq!(found.provenance.source, Source::Classical);
    assert!(found.provenance.confidence.unwrap() < 0.5);
    assert!(found.provenance.reason.unwrap().contains("unsure"));
    assert_eq!(
        found.labels,
        Classical.segment(&tree, &Cancel::new()).unwrap()
    );
    let sure = Auto::with(learned(mirror(), &card(0.02)).unwrap());
    assert_ne!(sure.key(), unsure.key());
}

#[test]
fn a_network_that_fails_hands_over_to_the_rules() {
    let mut wrong = card(0.02);
    wrong["output"]["name"] = json!("nothing");
    let broken = learned(mirror(), &wrong).unwrap();
    assert!(broken.segment(&photo(), &Cancel::new()).is_err());
    let found = Auto::with(broken)
        .segmented(&photo(), &Cancel::new())
        .unwrap();
    assert_eq!(found.provenance.source, Source::Classical);
    assert!(found.provenance.reason.unwrap().contains("no output"));
}

#[test]
fn what_a_card_and_its_model_disagree_about_is_told() {
    let tensor = |name, kind, sides: &[u64]| value(name, kind, sides);
    let identity = |kind, sides: &[u64]| {
        model_of(
            "Identity",
            "logits",
            tensor("image", kind, sides),
            tensor("logits", kind, sides),
        )
    };
    for (model, reason) in [
        (
            identity(1, &[1, 5, SIDE, SIDE]),
            "its input is [1, 5, 32, 32], not [1, 3, 32, 32]",
        ),
        (
            identity(1, &[1, SIDE, SIDE, 3]),
            "its input is [1, 32, 32, 3]",
        ),
        (identity(1, &[1, 3, 64, 64]), "its input is [1, 3, 64, 64]"),
        (
            identity(11, &[1, 3, SIDE, SIDE]),
            "not 32-bit floating point",
        ),
    ] {
        let error = learned(model, &card(1.0)).unwrap().try_out().unwrap_err();
        assert!(error.to_string().contains(reason), "{error}");
    }
    let tensor = |name| value(name, 1, &[1, 3, SIDE, SIDE]);
    for (operator, reason) in [("Upsample", "Upsample"), ("Frobnicate", "Frobnicate")] {
        let model = model_of(operator, "logits", tensor("image"), tensor("logits"));
        let error = learned(model, &card(1.0)).unwrap().try_out().unwrap_err();
        assert!(error.to_string().contains(reason), "{error}");
        assert_eq!(error.to_string().lines().count(), 1);
    }
    let described = Learned::new(mirror().into(), None);
    assert!(matches!(described, Err(ModelError::Undescribed)));
    let described = [
        mirror(),
        bytes(
            14,
            &[
                bytes(1, b"boscage"),
                bytes(2, card(1.0).to_string().as_bytes()),
            ]
            .concat(),
        ),
    ];
    assert!(Learned::new(described.concat().into(), None).is_ok());
}

#[test]
fn labels_are_the_same_for_any_number_of_threads() {
    let learned = Learned::built_in().unwrap();
    let tree = photo().map(|pixel| match pixel.0 {
        [230, ..] => Straight([0; 4]),
        [_, _, 230, _] => Straight([60, 110, 40, 255]),
        _ => Straight([100, 80, 60, 255]),
    });
    let labelled = |threads| {
        with_threads(Some(threads), || {
            let all = || learned.segment(&tree, &Cancel::new()).unwrap();
            let (one, other) = both_at_once(all, all);
            assert_eq!(one, other);
            one
        })
        .unwrap()
    };
    assert_eq!(labelled(1), labelled(3));
}

/// Both at once, on the threads of this pool.
fn both_at_once<T: Send>(one: impl Fn() -> T + Send, other: impl Fn() -> T + Send) -> (T, T) {
    std::thread::scope(|scope| {
        let other = scope.spawn(other);
        (one(), other.join().unwrap())
    })
}

/// Far below what the model card tells: a slip in feeding the network falls through, a better network
/// does not.
#[test]
fn real_trees_are_labelled_as_by_hand() {
    let Some(folder) = reference::data("labels") else {
        return;
    };
    let learned = Learned::built_in().unwrap();
    let read = |path: &Path| read_image(path, ReadLimits::default()).unwrap();
    let (mut crowns, mut trunks) = (Vec::new(), Vec::new());
    for name in [
        "apple_airy_medium_01",
        "bare_conifer_sparse_01",
        "broadleaf_conical_medium_07",
        "larch_autumn_medium_01",
        "palm_medium_01",
        "spruce_dense_01",
    ] {
        let picture = read(&folder.join(format!("billboards/{name}.png")));
        let truth = read(&folder.join(format!("labels/{name}.labels.png")));
        let truth = labels_from_grey(&truth.map(|pixel| pixel.0[0]));
        let found = learned.segmented(&picture, &Cancel::new()).unwrap();
        assert!(found.provenance.confidence.unwrap() > 0.5, "{name}");
        for (pixel, label) in picture.pixels().iter().zip(found.labels.pixels()) {
            assert_eq!(pixel.alpha() >= 128, *label != Label::Background);
        }
        crowns.push(overlap(&found.labels, &truth, Label::Crown));
        trunks.push(overlap(&found.labels, &truth, Label::Trunk));
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    assert!(mean(&crowns) > 0.97, "{crowns:?}");
    assert!(mean(&trunks) > 0.8, "{trunks:?}");
}

/// The real binary in a folder with `tree.png`.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        place.write("tree.png", &encode_png(&photo(), Compression::Fast));
        place
    }

    fn write(&self, name: &str, content: &[u8]) {
        std::fs::write(self.0.path().join(name), content).unwrap();
    }

    fn run(&self, line: &str) -> Output {
        Command::new(env!("CARGO_BIN_EXE_boscage"))
            .current_dir(self.0.path())
            .env_remove("ORT_DYLIB_PATH")
            .args(line.split_whitespace())
            .output()
            .unwrap()
    }

    /// What `segment --model m.onnx` says no with.
    fn refusal(&self, model: &[u8]) -> String {
        self.write("m.onnx", model);
        let output = self.run("segment tree.png --model m.onnx --out o");
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{told}");
        assert_eq!(told.lines().count(), 1, "{told}");
        assert!(
            told.starts_with("error: m.") && !self.0.path().join("o").exists(),
            "{told}"
        );
        told
    }
}

#[test]
fn a_users_model_is_tried_out_and_used() {
    let place = Place::new();
    place.write("m.onnx", &mirror());
    place.write("m.json", card(0.02).to_string().as_bytes());
    let output = place.run("segment tree.png --model m.onnx --out o --json");
    let told = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), told.as_str()), (Some(0), ""));
    let answer: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(answer["images"][0]["source"], "learned");
    assert!(answer["images"][0]["confidence"].as_f64().unwrap() > 0.9);
    // Kept labels still know who made them.
    let again = place.run("segment tree.png --model m.onnx --out o --json --resume");
    let again: Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(again["images"], answer["images"]);
}

#[test]
fn files_that_are_no_sound_models_are_refused_in_one_line() {
    let place = Place::new();
    place.write("m.json", card(1.0).to_string().as_bytes());
    let whole = mirror();
    assert!(place.refusal(b"").contains("not an ONNX model"));
    assert!(
        place
            .refusal(&whole[..whole.len() / 2])
            .contains("not an ONNX model")
    );
    let tensor = |name| value(name, 1, &[1, 3, SIDE, SIDE]);
    let looping = model_of("Loop", "logits", tensor("image"), tensor("logits"));
    assert!(place.refusal(&looping).contains("operator Loop"));
    // The output comes from nowhere: tract panics, across a border that ends the process.
    let nowhere = model_of("Identity", "other", tensor("image"), tensor("logits"));
    place.refusal(&nowhere);
    // Four terabytes.
    let bomb = model_of(
        "Identity",
        "logits",
        value("image", 1, &[1, 3, 1 << 20, 1 << 20]),
        tensor("logits"),
    );
    place.refusal(&bomb);
    place.write("m.json", b"{\"format\": 7}");
    assert!(
        place
            .refusal(&whole)
            .contains("m.json: its description has format 7")
    );
}

#[test]
fn a_runtime_that_is_none_is_told_of_and_passed_over() {
    let place = Place::new();
    for library in ["missing.so", "tree.png"] {
        let line = format!(
            "segment tree.png --segmenter onnx --onnx-runtime ./{library} --out o --overwrite"
        );
        let output = place.run(&line);
        let told = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{told}");
        // Whether the network takes the drawing for a tree is another matter.
        let told_of_it = |line: &&str| line.contains("not used to run models");
        assert_eq!(told.lines().filter(told_of_it).count(), 1, "{told}");
        assert!(told.lines().all(|line| line.starts_with("warning: ")));
    }
}
