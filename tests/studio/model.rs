//! The segmenter in the real window without a screen: a photograph's mask is proposed, and the user's
//! own model is tried out, used, remembered or refused.

use crate::window;
use boscage::app::{Action, Command, MaskCommand, Severity};
use boscage::paint::{CROWN, TRUNK, TiledMask};
use boscage::raster::{Image, ReadLimits, Straight, read_image};
use std::path::{Path, PathBuf};
use window::{Window, wait, window};

const BUILT_IN: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/models/segmenter.onnx");

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
}

fn open(window: &mut Window, picture: PathBuf) {
    act(window, Action::Open(vec![picture]));
    wait(window, |shell| {
        !shell.studio().is_empty() && !shell.studio().is_waiting()
    });
}

/// The last thing that the user was told, once there is one that `is_so`.
fn told(window: &mut Window, is_so: impl Fn(&str) -> bool) -> (Severity, String) {
    wait(window, |shell| {
        let mut notices = shell.studio().notices().iter();
        notices.any(|notice| is_so(&notice.text))
    });
    let mut notices = window.state().studio().notices().iter();
    let notice = notices.rfind(|notice| is_so(&notice.text)).unwrap();
    (notice.severity, notice.text.clone())
}

fn propose(window: &mut Window) {
    act(window, Action::Do(Command::Mask(MaskCommand::Propose)));
}

/// The share of two masks' crowns that both have.
fn overlap(found: &TiledMask, truth: &Image<Straight>) -> f64 {
    let (mut both, mut either) = (0, 0);
    for y in 0..truth.height() {
        for x in 0..truth.width() {
            let (own, other) = (found.at(x, y) == CROWN, truth.at(x, y).0[0] > 191);
            both += u32::from(own && other);
            either += u32::from(own || other);
        }
    }
    f64::from(both) / f64::from(either.max(1))
}

#[test]
fn a_photographs_mask_is_proposed() {
    let photos = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/photos");
    let truth = photos.join("meadow_oak.mask.png");
    let truth = read_image(&truth, ReadLimits::default()).unwrap();
    let (mut window, _folder) = window();
    open(&mut window, photos.join("meadow_oak.jpg"));
    propose(&mut window);
    let (severity, text) = told(&mut window, |text| text.starts_with("Proposed"));
    assert_eq!(severity, Severity::Info);
    assert!(text.contains("the learned segmenter"), "{text}");
    let mask = window.state().studio().shown_mask().unwrap();
    let overlap = overlap(mask, &truth);
    assert!(overlap > 0.7, "{overlap}");
    assert!(mask.count(|label| label == TRUNK) > 0);
}

/// The built-in model under another name.
fn own_model(folder: &Path) -> PathBuf {
    let path = folder.join("mine.onnx");
    std::fs::copy(BUILT_IN, &path).unwrap();
    let card = std::fs::read_to_string(Path::new(BUILT_IN).with_extension("json")).unwrap();
    let card = card.replace("boscage-segmenter", "orchard");
    std::fs::write(path.with_extension("json"), card).unwrap();
    path
}

#[test]
fn a_users_model_is_tried_out_used_and_remembered() {
    let (mut window, folder) = window();
    let program = env!("CARGO_BIN_EXE_boscage").into();
    window.state_mut().studio_mut().try_models_with(program);
    let path = own_model(folder.path());
    act(&mut window, Action::UseModel(path.clone()));
    let (severity, text) = told(&mut window, |text| text.contains("orchard"));
    assert_eq!(severity, Severity::Info, "{text}");
    let studio = window.state().studio();
    assert_eq!(studio.model_name(), Some("orchard"));
    assert_eq!(studio.preferences().segmentation_model, Some(path));

    let tree = boscage::branches::samples::starters().next().unwrap();
    let file = folder.path().join("tree.webp");
    std::fs::write(&file, tree.bundled()).unwrap();
    open(&mut window, file);
    propose(&mut window);
    let (_, text) = told(&mut window, |text| text.starts_with("Proposed"));
    assert!(text.contains("the model orchard"), "{text}");

    act(&mut window, Action::Do(Command::UseBuiltInModel));
    let studio = window.state().studio();
    assert_eq!(studio.model_name(), None);
    assert_eq!(studio.preferences().segmentation_model, None);
}

#[test]
fn a_file_that_is_no_model_is_refused_with_the_reason() {
    let (mut window, folder) = window();
    let path = folder.path().join("no model.onnx");
    std::fs::write(&path, b"nothing").unwrap();
    act(&mut window, Action::UseModel(path));
    let (severity, text) = told(&mut window, |text| text.contains("is not used"));
    assert_eq!(severity, Severity::Error);
    assert!(
        text.contains("no model.onnx") && text.contains("not an ONNX model"),
        "{text}"
    );
    let studio = window.state().studio();
    assert_eq!(studio.model_name(), None);
    assert_eq!(studio.preferences().segmentation_model, None);
}
