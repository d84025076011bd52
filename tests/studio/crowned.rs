//! A window with a photograph of a round crown, for tests that look at the crown.

use crate::window::{Window, wait};
use boscage::app::{Action, Gesture, Shell};
use boscage::base::Seed;
use boscage::document::{CrownSettings, Edit, PhotoId};
use boscage::paint::{CROWN, TiledMask};
use boscage::raster::{Compression, Image, Mask, Straight, encode_png};
use egui_kittest::Harness;
use std::sync::Arc;

/// Width and height of the photograph, and the disc that is its crown.
pub(crate) const SIZE: (u32, u32) = (160, 200);
const CENTER: (f64, f64) = (80.0, 80.0);
const RADIUS: f64 = 60.0;

pub(crate) fn crown_mask() -> Mask {
    let inside = |i: u32| {
        let (x, y) = (f64::from(i % SIZE.0), f64::from(i / SIZE.0));
        (x - CENTER.0).hypot(y - CENTER.1) < RADIUS
    };
    Image::from_pixels(SIZE.0, SIZE.1, (0..SIZE.0 * SIZE.1).map(inside).collect())
}

/// Speckled green before blue.
pub(crate) fn photo() -> Image<Straight> {
    let mut random = Seed(5).random();
    crown_mask().map(|&inside| {
        let light = random.below(110) as u8;
        match inside {
            true => Straight([20 + light / 2, 50 + light, 15 + light / 4, 255]),
            false => Straight([150, 180, 230, 255]),
        }
    })
}

/// A window with the photograph, its mask, and a crown with so many texels along a face.
pub(crate) fn with_crown(size: u32) -> (Window, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("old oak.png");
    std::fs::write(&file, encode_png(&photo(), Compression::Fast)).unwrap();
    let recovery = folder.path().join("recovery");
    let mut window = Harness::builder()
        .with_size([1440.0, 900.0])
        .with_max_steps(64)
        .build_eframe(move |creation| Shell::new(creation, recovery, vec![file]));
    wait(&mut window, |shell| !shell.studio().is_empty());
    let settings = CrownSettings {
        size,
        ..CrownSettings::default()
    };
    edit(&mut window, Edit::SetCrown(PhotoId(0), Box::new(settings)));
    let mask = TiledMask::from_mask(&crown_mask(), CROWN);
    edit(&mut window, Edit::SetMask(PhotoId(0), Arc::new(mask)));
    settle(&mut window);
    (window, folder)
}

/// Changes the document, without a frame after it.
pub(crate) fn edit(window: &mut Window, edit: Edit) {
    let action = Action::Edit {
        label: "Test",
        edit,
        gesture: Gesture::Whole,
    };
    window.state_mut().studio_mut().act(action);
}

/// Waits until the crown is all that it should be.
pub(crate) fn settle(window: &mut Window) {
    wait(window, |shell| {
        let studio = shell.studio();
        studio.crown_is_final() && studio.shown_crown().is_some()
    });
    assert_eq!(window.state().studio().document().complaint(), None);
}
