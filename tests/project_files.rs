//! Project files of every version there was open as what they are.
//!
//! `REGENERATE=1` writes the fixture of the present version; those of older versions are kept as they
//! were written.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use boscage::base::Cancel;
use boscage::document::{
    CrownSettings, Document, Edit, ExemplarWeight, PhotoId, Tangent, VariationSettings, decode,
    encode,
};
use boscage::paint::{CROWN, FillRule, Paint, TRUNK, painted, polygon_selection};
use boscage::raster::{Compression, Image, Straight, encode_png};
use std::path::PathBuf;
use std::sync::Arc;

fn fixture() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/v1.boscage")
}

/// A small project: a drawn photograph, a mask of crown and trunk, settings, a step to redo.
fn project() -> Document {
    let id = PhotoId(0);
    let mut document = Document::new();
    let pixel = |i: u32| Straight([(i % 48 * 5) as u8, (i / 48 * 3) as u8, 90, 255]);
    let photo = Image::from_pixels(48, 64, (0..48 * 64).map(pixel).collect());
    let photo = Edit::AddPhoto {
        name: "drawn.png".to_owned(),
        bytes: encode_png(&photo, Compression::Small).into(),
        width: 48,
        height: 64,
    };
    document.apply("Add photo", photo).unwrap();
    let mut mask = (**document.state().mask(id).unwrap()).clone();
    for (points, label) in [
        (
            [(4.0, 20.0), (24.0, 2.0), (44.0, 22.0), (24.0, 40.0)],
            CROWN,
        ),
        (
            [(21.0, 38.0), (27.0, 38.0), (28.0, 63.0), (20.0, 63.0)],
            TRUNK,
        ),
    ] {
        let selection = polygon_selection(48, 64, &points.map(Into::into), FillRule::EvenOdd);
        painted(&mut mask, &selection, Paint::of(label));
    }
    document
        .apply("Polygon", Edit::SetMask(id, Arc::new(mask)))
        .unwrap();
    let crown = CrownSettings {
        k: Tangent::Profile(vec![(0.0, 1.5), (0.5, 3.0)]),
        rho: 0.1,
        sub_crown_depths: [(3, 0.25)].into(),
        ..CrownSettings::default()
    };
    document
        .apply("Crown", Edit::SetCrown(id, Box::new(crown)))
        .unwrap();
    let variation = VariationSettings {
        exemplars: vec![ExemplarWeight {
            photo: id,
            weight: 0.7,
        }],
        seed: 12_345_678_901,
        ..VariationSettings::default()
    };
    document
        .apply("Variation", Edit::SetVariation(Box::new(variation)))
        .unwrap();
    document
        .apply("Title", Edit::SetTitle("Undone".to_owned()))
        .unwrap();
    document.undo().unwrap();
    document.view_mut().sun_deg = (120.0, 33.3);
    document
}

#[test]
fn files_of_version_1_open() {
    let expected = project();
    if std::env::var_os("REGENERATE").is_some() {
        let file = encode(&expected.snapshot(), &Cancel::new()).unwrap();
        std::fs::write(fixture(), file).unwrap();
    }
    let file = std::fs::read(fixture()).unwrap();
    let mut back = decode(&file, |_| None).unwrap();
    assert!(back.notes.is_empty(), "{:?}", back.notes);
    assert_eq!(back.document.digest(), expected.digest());
    assert_eq!(back.document.view(), expected.view());
    assert_eq!(
        back.document.photo_bytes(PhotoId(0)),
        expected.photo_bytes(PhotoId(0))
    );
    assert_eq!(back.document.history_steps(), (4, 1));
    back.document.redo().unwrap();
    assert_eq!(back.document.state().content().title, "Undone");
}
