//! Undo, redo and transactions by example and by random sequences of edits.

use super::*;
use crate::document::{CrownSettings, ExemplarWeight, NewPhoto, Tangent, VariationSettings};
use crate::paint::{BrushSettings, Paint, Sample, Stroke, TiledMask};
use crate::raster::Rect;
use proptest::prelude::*;

fn photo(name: &str, width: u32, height: u32) -> Edit {
    let bytes = format!("the bytes of {name}").into_bytes().into();
    Edit::AddPhotos(vec![NewPhoto::new(name, bytes, (width, height))])
}

fn with_photo() -> (Document, PhotoId) {
    let mut document = Document::new();
    document
        .apply("Add photo", photo("oak.jpg", 300, 200))
        .unwrap();
    (document, PhotoId(0))
}

fn painted(document: &Document, id: PhotoId, x: u32, y: u32, label: u8) -> Edit {
    let mut mask = (**document.state().mask(id).unwrap()).clone();
    let rect = Rect {
        x,
        y,
        width: 60,
        height: 50,
    };
    mask.edit(rect, |_, _, row| row.fill(label));
    Edit::SetMask(id, Arc::new(mask))
}

#[test]
fn a_gesture_is_one_step() {
    let (mut document, id) = with_photo();
    let before = document.digest();
    document.begin("Brush");
    for x in [0, 40, 80] {
        document
            .apply("", painted(&document, id, x, 10, 1))
            .unwrap();
    }
    assert!(document.commit());
    let after = document.digest();
    assert_eq!(document.undo_label(), Some("Brush"));
    let changed = document.undo().unwrap();
    assert!(!changed.content && changed.masks[0].0 == id);
    assert_eq!(
        (document.digest(), document.redo_label()),
        (before, Some("Brush"))
    );
    document.redo().unwrap();
    assert_eq!(document.digest(), after);
    assert_eq!(document.history_steps(), (2, 0));
}

#[test]
fn an_aborted_gesture_leaves_nothing() {
    let (mut document, id) = with_photo();
    let before = document.digest();
    document.begin("Brush");
    document.apply("", painted(&document, id, 5, 5, 2)).unwrap();
    document.apply("", photo("ash.jpg", 10, 10)).unwrap();
    assert!(document.is_dirty() && document.abort());
    assert_eq!(
        (document.digest(), document.history_steps()),
        (before, (1, 0))
    );
    assert_eq!(
        document.blobs.len(),
        1,
        "the photograph's bytes are gone too"
    );
}

#[test]
fn a_gesture_without_effect_keeps_what_can_be_redone() {
    let (mut document, id) = with_photo();
    document
        .apply("Paint", painted(&document, id, 5, 5, 2))
        .unwrap();
    document.undo().unwrap();
    document.begin("Slider");
    let other = CrownSettings {
        rho: 0.9,
        ..CrownSettings::default()
    };
    document
        .apply("", Edit::SetCrown(id, Box::new(other)))
        .unwrap();
    document
        .apply("", Edit::SetCrown(id, Box::default()))
        .unwrap();
    assert!(!document.commit());
    assert_eq!(document.redo_label(), Some("Paint"));
}

#[test]
fn undo_during_a_gesture_gives_it_up() {
    let (mut document, id) = with_photo();
    let before = document.digest();
    document.begin("Brush");
    document.apply("", painted(&document, id, 5, 5, 2)).unwrap();
    assert_eq!(document.redo(), None);
    let changed = document.undo().unwrap();
    assert_eq!(changed.masks.len(), 1);
    assert_eq!(
        (document.digest(), document.is_in_gesture()),
        (before, false)
    );
}

#[test]
fn undoing_to_what_was_saved_is_clean() {
    let (mut document, id) = with_photo();
    let snapshot = document.snapshot();
    document
        .apply("Paint", painted(&document, id, 5, 5, 2))
        .unwrap();
    document.mark_saved(snapshot.revision());
    assert!(document.is_dirty(), "painted while the save ran");
    document.undo().unwrap();
    assert!(!document.is_dirty());
    document.undo().unwrap();
    assert!(document.is_dirty());
    document.redo().unwrap();
    document.view_mut().distance = 9.0;
    assert!(!document.is_dirty(), "looking is no change");
}

#[test]
fn what_does_not_fit_is_refused_and_changes_nothing() {
    let (mut document, id) = with_photo();
    let before = document.digest();
    let wrong = Edit::SetMask(id, Arc::new(TiledMask::filled(3, 3, 0)));
    let refusal = document.apply("", wrong).unwrap_err().to_string();
    assert!(
        refusal.contains("3×3") && refusal.contains("300×200"),
        "{refusal}"
    );
    let bad_k = CrownSettings {
        k: Tangent::Profile(vec![(0.5, f64::NAN)]),
        ..CrownSettings::default()
    };
    let bad_mix = VariationSettings {
        exemplars: vec![ExemplarWeight {
            photo: PhotoId(7),
            weight: 1.0,
        }],
        ..VariationSettings::default()
    };
    for edit in [
        Edit::SetCrown(id, Box::new(bad_k)),
        Edit::SetVariation(Box::new(bad_mix)),
        Edit::RemovePhoto(PhotoId(4)),
        Edit::SetTitle("x".repeat(2000)),
        photo("none", 0, 4),
        photo("vast", 90_000, 90_000),
    ] {
        assert!(document.apply("", edit).is_err());
    }
    assert_eq!(
        (document.digest(), document.history_steps()),
        (before, (1, 0))
    );
}

#[test]
fn equal_photographs_are_kept_once_and_removed_ones_come_back() {
    let (mut document, id) = with_photo();
    document.apply("Add", photo("oak.jpg", 300, 200)).unwrap();
    assert_eq!(
        (
            document.state().content().photos.len(),
            document.blobs.len()
        ),
        (2, 1)
    );
    let use_it = VariationSettings {
        exemplars: vec![ExemplarWeight {
            photo: id,
            weight: 0.5,
        }],
        target: Some(id),
        ..VariationSettings::default()
    };
    document
        .apply("Use", Edit::SetVariation(Box::new(use_it)))
        .unwrap();
    document
        .apply("Paint", painted(&document, id, 9, 9, 1))
        .unwrap();
    let before = document.digest();
    document.apply("Remove", Edit::RemovePhoto(id)).unwrap();
    assert_eq!(document.complaint(), None);
    assert_eq!(document.state().content().variation.target, None);
    document.apply("Add", photo("new.jpg", 4, 4)).unwrap();
    assert!(
        document.state().mask(id).is_none(),
        "no number is given twice"
    );
    document.undo().unwrap();
    document.undo().unwrap();
    assert_eq!(document.digest(), before);
    assert!(document.photo_bytes(id).is_some());
}

#[test]
fn two_hundred_long_strokes_on_a_large_photograph_stay_below_the_limit() {
    let mut document = Document::new();
    document
        .apply("Add", photo("large.jpg", 8192, 8192))
        .unwrap();
    let id = PhotoId(0);
    let brush = BrushSettings {
        radius_px: 100.0,
        smoothing: 0.0,
        ..BrushSettings::default()
    };
    for stroke in 0..200 {
        let mut mask = (**document.state().mask(id).unwrap()).clone();
        let mut path = Stroke::new(brush, Paint::of(1 + stroke as u8 % 3));
        let y = 40.0 * f64::from(stroke);
        path.extend(&mut mask, Sample::at(50.0, y));
        path.extend(&mut mask, Sample::at(4000.0, 8100.0 - y));
        path.extend(&mut mask, Sample::at(8100.0, y));
        path.finish(&mut mask);
        document
            .apply("Brush", Edit::SetMask(id, Arc::new(mask)))
            .unwrap();
    }
    let (steps, bytes) = (document.history_steps(), document.history_bytes());
    println!("{} steps in {:.1} MB", steps.0, bytes as f64 / 1e6);
    assert_eq!(steps, (201, 0));
    assert!(bytes < 200_000_000, "{bytes}");
}

/// A random edit of the document as it stands, valid or not.
fn random_edit(document: &Document, kind: u8, which: u32, value: u32) -> Edit {
    let id = PhotoId(which % document.state().content().next_photo.max(1));
    let share = f64::from(value % 100) / 99.0;
    match kind {
        0 => photo(&format!("{}.png", value % 4), 100 + which * 40, 150),
        1 => Edit::RemovePhoto(id),
        2 => Edit::RenamePhoto(id, format!("name {value}")),
        3 => Edit::SetTitle(format!("title {}", value % 3)),
        4 => Edit::SetCrown(
            id,
            Box::new(CrownSettings {
                rho: share * 1.1,
                copies: value % 5,
                sub_crown_depths: [(3, share)].into(),
                ..CrownSettings::default()
            }),
        ),
        5 => Edit::SetVariation(Box::new(VariationSettings {
            exemplars: vec![ExemplarWeight {
                photo: id,
                weight: share,
            }],
            like: Some(id).filter(|_| value.is_multiple_of(2)),
            seed: u64::from(value),
            ..VariationSettings::default()
        })),
        _ if document.state().mask(id).is_some() => {
            painted(document, id, value % 250, which * 37, (value % 4) as u8)
        }
        _ => Edit::SetTitle(String::new()),
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// Any interleaving of edits, gestures, aborts, undo and redo: after each the project is sound,
    /// and each place in the history always has the digest it had when it was made.
    #[test]
    fn undo_and_redo_return_the_exact_state(
        steps in prop::collection::vec((0u8..16, 0u32..5, any::<u32>()), 1..25),
    ) {
        let mut document = Document::new();
        let mut known = std::collections::HashMap::new();
        known.insert(document.revision, document.digest());
        for (kind, which, value) in steps {
            match kind {
                0..=9 => {
                    let edit = random_edit(&document, kind, which, value);
                    let before = document.digest();
                    match document.apply("edit", edit) {
                        Ok(is_different) => prop_assert_eq!(is_different, document.digest() != before),
                        Err(_) => prop_assert_eq!(document.digest(), before),
                    }
                }
                10 => {
                    // A gesture that was open ends here, as a step.
                    document.begin("gesture");
                    let digest = document.digest();
                    prop_assert_eq!(*known.entry(document.revision).or_insert(digest), digest);
                }
                11 => { document.commit(); }
                12 => { document.abort(); }
                13 | 14 => { document.undo(); }
                _ => { document.redo(); }
            }
            prop_assert_eq!(document.complaint(), None);
            if !document.is_in_gesture() {
                let digest = document.digest();
                prop_assert_eq!(*known.entry(document.revision).or_insert(digest), digest);
            }
        }
        document.commit();
        known.insert(document.revision, document.digest());
        while document.undo().is_some() {
            prop_assert_eq!(known[&document.revision], document.digest());
            prop_assert_eq!(document.complaint(), None);
        }
        prop_assert_eq!(document.revision, 0);
        while document.redo().is_some() {
            prop_assert_eq!(known[&document.revision], document.digest());
        }
    }
}
