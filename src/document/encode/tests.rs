//! Files: what comes back, what is refused, and that damage is always noticed.

use super::*;
use crate::document::{CrownSettings, Edit, NewPhoto, VERSION};
use crate::raster::Rect;
use proptest::prelude::*;

/// A project with two photographs, painted, with steps on both sides.
fn project() -> Document {
    let mut document = Document::new();
    for (name, side) in [("oak.jpg", 200), ("ash.png", 90)] {
        let bytes = name.repeat(50).into_bytes().into();
        let photo = NewPhoto::new(name, bytes, (side, 150));
        let edit = Edit::AddPhotos(vec![photo]);
        document.apply("Add photo", edit).unwrap();
    }
    for x in [10, 60] {
        let mut mask = (**document.state().mask(PhotoId(0)).unwrap()).clone();
        let rect = Rect {
            x,
            y: 20,
            width: 80,
            height: 90,
        };
        mask.edit(rect, |_, y, row| row.fill(1 + (y % 7 / 6) as u8));
        document
            .apply("Paint", Edit::SetMask(PhotoId(0), Arc::new(mask)))
            .unwrap();
    }
    document
        .apply("Title", Edit::SetTitle("Two trees".to_owned()))
        .unwrap();
    document.undo().unwrap();
    document.view_mut().canvas = Some(crate::document::CanvasView {
        center: (0.1 + 0.2, -3.0),
        zoom: 1.0 / 3.0,
    });
    document
}

fn file_of(document: &Document) -> Vec<u8> {
    encode(&document.snapshot(), &Cancel::new()).unwrap()
}

fn read(file: &[u8]) -> Result<Decoded, FormatError> {
    decode(file, |_| None)
}

#[test]
fn a_project_comes_back_with_its_history_and_view() {
    let document = project();
    let file = file_of(&document);
    let Decoded {
        document: mut back,
        notes,
    } = read(&file).unwrap();
    assert!(notes.is_empty() && !back.is_dirty(), "{notes:?}");
    assert_eq!(
        (back.digest(), back.view()),
        (document.digest(), document.view())
    );
    assert_eq!(
        back.photo_bytes(PhotoId(1)),
        document.photo_bytes(PhotoId(1))
    );
    assert!(
        file_of(&back) == file,
        "the same project gives the same bytes"
    );
    // The masks' strokes can be undone; adding the photographs needs what is embedded anyway, but
    // before them there is nothing that holds their bytes.
    assert_eq!(back.redo().map(|changed| changed.content), Some(true));
    assert_eq!(back.state().content().title, "Two trees");
    back.undo().unwrap();
    let mut original = document.clone();
    while let Some(label) = back.undo_label().map(str::to_owned) {
        assert_eq!(original.undo_label(), Some(&*label));
        assert_eq!(back.undo(), original.undo());
        assert_eq!(back.digest(), original.digest());
    }
}

#[test]
fn a_removed_photograph_is_not_in_the_file() {
    let mut document = project();
    document
        .apply("Remove", Edit::RemovePhoto(PhotoId(1)))
        .unwrap();
    let file = file_of(&document);
    let needle = b"ash.pngash.png";
    assert!(!file.windows(needle.len()).any(|window| window == needle));
    assert_eq!(read(&file).unwrap().document.undo_label(), None);
}

#[test]
fn photographs_may_lie_elsewhere() {
    let document = project();
    let snapshot = document.snapshot();
    let file = encode_without_photos(&snapshot, &Cancel::new()).unwrap();
    assert!(read(&file).is_err());
    assert!(decode(&file, |_| Some(b"others".as_slice().into())).is_err());
    let found = decode(&file, |digest| snapshot.photos().get(&digest).cloned());
    assert_eq!(found.unwrap().document.digest(), document.digest());
}

#[test]
fn newer_versions_are_refused_politely() {
    let mut file = file_of(&project());
    file[8] = VERSION as u8 + 1;
    let refusal = read(&file).unwrap_err();
    assert_eq!(
        refusal,
        FormatError::Newer {
            version: VERSION + 1
        }
    );
    assert!(refusal.to_string().contains("update Boscage"));
}

#[test]
fn a_small_file_cannot_ask_for_all_memory() {
    let mut file = b"\x89BSCG\r\n\x1a".to_vec();
    file.extend(VERSION.to_le_bytes());
    file.extend(5u32.to_le_bytes());
    for _ in 0..5 {
        file.extend(b"MASK\x03\0\0\0");
        file.extend((1u64 << 22).to_le_bytes());
        file.extend((1u64 << 30).to_le_bytes());
        file.extend([0; 32]);
    }
    let digest = Digest::of(&file);
    file.extend(digest.bytes());
    assert_eq!(read(&file).unwrap_err(), FormatError::TooLarge);
}

#[test]
fn unknown_sections_are_kept_or_refused_by_their_flag() {
    let (_, mut all) = sections(&file_of(&project())).unwrap();
    all.push(Section::new(b"NOTE", *b"from the future").optional());
    let again = file_of(&read(&container(&all)).unwrap().document);
    let (_, kept) = sections(&again).unwrap();
    assert!(kept.len() == all.len() && all.iter().all(|section| kept.contains(section)));
    all.push(Section::new(b"MUST", *b"x"));
    let kind = "MUST".to_owned();
    assert_eq!(
        read(&container(&all)).unwrap_err(),
        FormatError::Unknown { kind }
    );
}

/// `project` with its content changed as JSON, digests put right: what an enemy can do.
fn forged(change: impl Fn(&mut serde_json::Value)) -> Vec<u8> {
    let (_, mut all) = sections(&file_of(&project())).unwrap();
    let docu = all
        .iter_mut()
        .find(|section| &section.kind == b"DOCU")
        .unwrap();
    let mut value = serde_json::from_slice(&docu.bytes).unwrap();
    change(&mut value);
    docu.bytes = serde_json::to_vec(&value).unwrap().into();
    container(&all)
}

#[test]
fn well_formed_nonsense_is_refused() {
    let none = serde_json::Value::Null;
    type Change<'a> = &'a dyn Fn(&mut serde_json::Value);
    let changes: [Change<'_>; 6] = [
        &|v| v["photos"]["0"]["width"] = 7.into(),
        &|v| v["photos"]["1"]["digest"] = "ab".into(),
        &|v| v["photos"]["1"]["digest"] = "0".repeat(64).into(),
        &|v| v["crowns"]["0"]["copies"] = 100_000.into(),
        &|v| v["next_photo"] = 0.into(),
        &|v| *v = none.clone(),
    ];
    for change in changes {
        assert!(read(&forged(change)).is_err());
    }
    // Fields that a later version of the same format leaves to their defaults.
    let lenient = forged(|v| {
        v["crowns"]["0"].as_object_mut().unwrap().remove("relief");
        v["new_field"] = 3.into();
    });
    let back = read(&lenient).unwrap().document;
    assert_eq!(
        back.state().content().crowns[&PhotoId(0)],
        CrownSettings::default()
    );
}

#[test]
fn a_history_that_does_not_fit_is_left_out_and_told() {
    let file = forged(|v| v["next_photo"] = 9.into());
    // Undoing over that works; a history of another project does not.
    assert!(read(&file).is_ok());
    let (_, mut all) = sections(&file).unwrap();
    let history = all
        .iter_mut()
        .find(|section| &section.kind == b"HIST")
        .unwrap();
    history.bytes = b"\x01\x04abcd\0\x01\x05".as_slice().into();
    let Decoded { document, notes } = read(&container(&all)).unwrap();
    assert_eq!((document.history_steps(), notes.len()), ((0, 0), 1));
}

#[test]
fn lengths_that_lie_ask_for_no_memory() {
    let (_, mut all) = sections(&file_of(&project())).unwrap();
    let mask = all
        .iter_mut()
        .find(|section| &section.kind == b"MASK")
        .unwrap();
    let mut bytes = mask.bytes.to_vec();
    bytes[4..12].copy_from_slice(&[0x20, 0x4e, 0, 0, 0x20, 0x4e, 0, 0]);
    mask.bytes = bytes.into();
    assert!(read(&container(&all)).is_err());
}

#[test]
fn a_cancelled_save_gives_nothing() {
    let cancel = Cancel::new();
    cancel.cancel();
    assert_eq!(encode(&project().snapshot(), &cancel), Err(Cancelled));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    #[test]
    fn any_damage_is_noticed(at in any::<prop::sample::Index>(), flip in 1u8.., cut in any::<prop::sample::Index>()) {
        thread_local! {
            static FILE: Vec<u8> = file_of(&project());
        }
        let mut file = FILE.with(Clone::clone);
        prop_assert!(read(&file[..cut.index(file.len())]).is_err());
        let index = at.index(file.len());
        file[index] ^= flip;
        prop_assert!(read(&file).is_err());
    }

    #[test]
    fn any_bytes_are_no_project(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        prop_assert!(read(&bytes).is_err());
        let ours = [b"\x89BSCG\r\n\x1a\x01\0\0\0".as_slice(), &bytes].concat();
        prop_assert!(read(&ours).is_err());
    }
}
