//! Project files of every version there was open as what they are.
//!
//! `REGENERATE=1` writes the fixture of the present version; those of older versions are kept as they
//! were written.

use boscage::base::Cancel;
use boscage::document::{
    CrownSettings, Document, Edit, ExemplarWeight, NewPhoto, PhotoId, Tangent, VariationSettings,
    decode, encode, store,
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
    let bytes = encode_png(&photo, Compression::Small).into();
    let photo = NewPhoto::new("drawn.png", bytes, (48, 64));
    let photo = Edit::AddPhotos(vec![photo]);
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

/// Files that are nearly a project: cut anywhere, a byte changed anywhere, doubled, with a tail.
fn damaged(file: &[u8]) -> Vec<Vec<u8>> {
    let mut all: Vec<Vec<u8>> = (0..file.len())
        .step_by(37)
        .map(|at| file[..at].to_vec())
        .collect();
    for at in (0..file.len()).step_by(11) {
        for bit in [0, 7] {
            let mut changed = file.to_vec();
            changed[at] ^= 1 << bit;
            all.push(changed);
        }
    }
    all.push(file.repeat(2));
    all.push([file, b"tail"].concat());
    all.push(vec![0; 4096]);
    all
}

#[test]
fn every_damaged_file_is_refused_in_one_line_that_names_it() {
    let file = std::fs::read(fixture()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wood.boscage");
    let mut opened = 0;
    let all = damaged(&file);
    for bytes in &all {
        std::fs::write(&path, bytes).unwrap();
        match store::open(&path) {
            Err(error) => {
                let line = error.to_string();
                assert!(
                    line.contains("wood.boscage") && !line.contains(char::is_control),
                    "{line}"
                );
            }
            // Damage of what may be left out (the history, how it was looked at) is told, and left out.
            Ok((decoded, _)) => {
                opened += 1;
                assert!(!decoded.notes.is_empty(), "damage that nobody noticed");
                assert_eq!(decoded.document.complaint(), None);
            }
        }
    }
    println!(
        "damaged projects: {} files, {opened} opened without their history or view, all others refused in a line",
        all.len()
    );
}
