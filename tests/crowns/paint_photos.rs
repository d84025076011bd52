//! Smart select on the real photographs of `BOSCAGE_DATA` (default `../shared/data`): a few strokes
//! made from the hand-drawn mask, and what comes of them. Without the folder the test says so and
//! passes. `BOSCAGE_OVERLAYS=DIR` writes pictures to look at.

use crate::reference;
use boscage::base::Cancel;
use boscage::paint::{
    BrushSettings, INSIDE, OUTSIDE, Over, Paint, Sample, Stroke, TiledMask, grown, shrunk,
    smart_selection,
};
use boscage::raster::{Compression, Image, Mask, ReadLimits, Straight, encode_png, read_image};
use std::path::PathBuf;

/// The first and last column of `mask` in row `y`.
fn extent(mask: &TiledMask, y: u32) -> Option<(f64, f64)> {
    let inside = |x: &u32| mask.at(*x, y) == 1;
    let first = (0..mask.width()).find(inside)?;
    let last = (0..mask.width()).rev().find(inside)?;
    Some((f64::from(first), f64::from(last)))
}

/// What a hasty hand would do: five lines well within the crown, and one around it at a distance.
fn strokes(truth: &TiledMask) -> TiledMask {
    let mut hints = TiledMask::filled(truth.width(), truth.height(), 0);
    let bounds = truth.bounds(|label| label == 1).unwrap();
    let size = f64::from(bounds.width.min(bounds.height));
    let brush = BrushSettings {
        radius_px: 3.0,
        ..BrushSettings::default()
    };
    let draw = |hints: &mut TiledMask, label, points: &[(f64, f64)]| {
        let mut stroke = Stroke::new(brush, Paint::of(label));
        for &(x, y) in points {
            stroke.extend(hints, Sample::at(x, y));
        }
        stroke.finish(hints);
    };
    let rows = |shape: &TiledMask, parts: &[f64]| -> Vec<(f64, f64, f64)> {
        let bounds = shape.bounds(|label| label == 1).unwrap();
        let row = |part: &f64| {
            let y = bounds.y + (part * f64::from(bounds.height - 1)) as u32;
            extent(shape, y).map(|(left, right)| (left, right, f64::from(y)))
        };
        parts.iter().filter_map(row).collect()
    };
    let mut core = truth.clone();
    shrunk(&mut core, 1, size * 0.08, &Cancel::new()).unwrap();
    for (left, right, y) in rows(&core, &[0.05, 0.3, 0.5, 0.7, 0.95]) {
        draw(&mut hints, INSIDE, &[(left, y), (right, y)]);
    }
    // Strokes of gaps within the crown stay inside: only where the mask agrees.
    let mut around = truth.clone();
    grown(
        &mut around,
        1,
        size * 0.05 + 4.0,
        Over::Everything,
        &Cancel::new(),
    )
    .unwrap();
    let parts: Vec<f64> = (0..=12).map(|i| f64::from(i) / 12.0).collect();
    let rows = rows(&around, &parts);
    let left: Vec<_> = rows.iter().map(|&(left, _, y)| (left, y)).collect();
    let right: Vec<_> = rows.iter().rev().map(|&(_, right, y)| (right, y)).collect();
    let ring = [left, right].concat();
    let mut outside = TiledMask::filled(truth.width(), truth.height(), 0);
    draw(
        &mut outside,
        OUTSIDE,
        &[ring.clone(), vec![ring[0]]].concat(),
    );
    hints.edit(hints.rect(), |x, y, row| {
        for (x, pixel) in (x..).zip(row) {
            let at_border = x < 2 || y < 2 || x + 2 >= truth.width() || y + 2 >= truth.height();
            if outside.at(x, y) == OUTSIDE && truth.at(x, y) == 0 && !at_border {
                *pixel = OUTSIDE;
            }
        }
    });
    hints
}

/// Pixels in both over pixels in any.
fn overlap(a: &Mask, b: &Mask) -> f64 {
    let pairs = || a.pixels().iter().zip(b.pixels());
    let both = pairs().filter(|(a, b)| **a && **b).count();
    let any = pairs().filter(|(a, b)| **a || **b).count();
    both as f64 / any as f64
}

/// The photograph: what is not selected darker, strokes in red and green, errors tinted.
fn overlay(
    photo: &Image<Straight>,
    found: &Mask,
    truth: &Mask,
    hints: &TiledMask,
) -> Image<Straight> {
    let mut picture = photo.clone();
    for y in 0..photo.height() {
        for (x, pixel) in (0..).zip(picture.row_mut(y)) {
            let [r, g, b, _] = pixel.0;
            pixel.0 = match (hints.at(x, y), found.at(x, y), truth.at(x, y)) {
                (INSIDE, ..) => [0, 255, 0, 255],
                (OUTSIDE, ..) => [255, 0, 0, 255],
                (_, true, true) => [r, g, b, 255],
                (_, false, false) => [r / 3, g / 3, b / 3, 255],
                (_, true, false) => [255, g / 2, 255, 255],
                (_, false, true) => [r / 2, 255, 255, 255],
            };
        }
    }
    picture
}

#[test]
fn a_few_strokes_select_real_crowns() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let folder = std::fs::read_dir(data.join("photos")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let mut overlaps = Vec::new();
    for file in files {
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        let photo = read_image(&file, ReadLimits::default()).unwrap();
        let mask = data.join("masks").join(format!("{name}.mask.png"));
        let mask = read_image(&mask, ReadLimits::default()).unwrap();
        let truth = mask.map(|pixel| pixel.0[0] >= 128);
        let hints = strokes(&TiledMask::from_mask(&truth, 1));
        let start = std::time::Instant::now();
        let found = smart_selection(&photo, &hints, &Cancel::new()).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let found = found.mask(|label| label == 1);
        let share = overlap(&found, &truth);
        eprintln!("{name}: {share:.3} in {seconds:.2} s");
        if let Some(folder) = std::env::var_os("BOSCAGE_OVERLAYS") {
            let picture = overlay(&photo, &found, &truth, &hints);
            let png = encode_png(&picture, Compression::Fast);
            std::fs::write(PathBuf::from(folder).join(format!("{name}.png")), png).unwrap();
        }
        overlaps.push(share);
    }
    let mean = overlaps.iter().sum::<f64>() / overlaps.len() as f64;
    let least = overlaps.iter().copied().fold(1.0, f64::min);
    eprintln!("mean {mean:.3}, least {least:.3}");
    assert!(mean > 0.88 && least > 0.77, "mean {mean}, least {least}");
}
