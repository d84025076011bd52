//! The real trees of `BOSCAGE_DATA` (default `../shared/data`): outlines, pins and maps of pictures
//! that nobody here drew. Without the folder the tests say so and pass.

use crate::reference;
use boscage::base::{Cancel, Progress};
use boscage::geometry::Point;
use boscage::raster::{ReadLimits, read_image};
use boscage::segment::{Classical, Label, labels_from_grey};
use boscage::variation::{Exemplar, ExemplarSettings, Layout, Outlined, Shape, normalized};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn billboards(data: &Path) -> Vec<PathBuf> {
    let folder = std::fs::read_dir(data.join("billboards")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn shapes(data: &Path) -> Vec<(String, Shape)> {
    billboards(data)
        .par_iter()
        .map(|file| {
            let picture = read_image(file, ReadLimits::default()).unwrap();
            let settings = ExemplarSettings::default();
            let (silent, cancel) = (Progress::silent(), Cancel::new());
            let exemplar = Exemplar::prepare(&picture, &settings, &Classical, silent, &cancel);
            (stem(file), exemplar.unwrap().shape)
        })
        .collect()
}

fn stem(file: &Path) -> String {
    file.file_stem().unwrap().to_string_lossy().into_owned()
}

/// Largest relative deviation from the mean of the distances between neighbouring `points`.
fn unevenness(points: &[Point]) -> f64 {
    let chords: Vec<f64> = points
        .windows(2)
        .map(|pair| pair[0].distance(pair[1]))
        .collect();
    let mean = chords.iter().sum::<f64>() / chords.len() as f64;
    chords
        .iter()
        .map(|chord| (chord / mean - 1.0).abs())
        .fold(0.0, f64::max)
}

#[test]
fn resampled_outlines_have_equal_chords_in_each_part() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    for (name, shape) in shapes(&data) {
        let contour = &shape.contour;
        assert_eq!(contour.points.len(), 2000, "{name}");
        let mut closed = contour.points.clone();
        closed.push(contour.points[0]);
        let (right, left) = (contour.pins.right, contour.pins.left);
        let parts = if contour.pins.has_trunk() {
            assert_eq!((right, left), (200, 1800), "{name}");
            vec![0..=right, right..=left, left..=2000]
        } else {
            vec![0..=2000]
        };
        for part in parts {
            let unevenness = unevenness(&closed[part.clone()]);
            assert!(unevenness <= 0.01, "{name} {part:?}: {unevenness}");
        }
    }
}

#[test]
fn maps_between_all_pairs_hardly_fold() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let shapes = shapes(&data);
    let count = shapes.len();
    let folded: Vec<f64> = (0..count * count)
        .into_par_iter()
        .filter(|index| index / count != index % count)
        .map(|index| {
            let (a, b) = (&shapes[index / count].1, &shapes[index % count].1);
            let layout = Layout::new(&[(a, 0.5, 1.0), (b, 0.5, 0.0)]).unwrap();
            layout.distortion.folded
        })
        .collect();
    let clean = folded.iter().filter(|&&share| share == 0.0).count() as f64 / folded.len() as f64;
    let worst = folded.iter().copied().fold(0.0, f64::max);
    eprintln!(
        "{} pairs: {:.1} % fold nowhere, worst {:.2} %",
        folded.len(),
        100.0 * clean,
        100.0 * worst
    );
    assert!(worst <= 0.01, "worst {worst}");
    assert!(clean >= 0.98, "{clean} of the pairs fold nowhere");
}

/// Name → (baseline y, left x, right x, bottom x, bottom y) in pixels of the picture.
fn drawn_pins(data: &Path) -> BTreeMap<String, [f64; 5]> {
    let text = std::fs::read_to_string(data.join("pins.csv")).unwrap();
    let rows = text.lines().skip(1).map(|line| {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |i: usize| fields[i].parse::<f64>().unwrap();
        (
            fields[0].to_owned(),
            [number(2), number(3), number(4), number(5), number(6)],
        )
    });
    rows.collect()
}

#[test]
fn pins_from_drawn_labels_are_the_drawn_pins() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let drawn = drawn_pins(&data);
    let settings = ExemplarSettings::default();
    let mut errors = Vec::new();
    for file in billboards(&data) {
        let name = stem(&file);
        let [baseline_y, left, right, bottom_x, bottom_y] = drawn[&name];
        if baseline_y < 0.0 {
            continue;
        }
        let picture = read_image(&file, ReadLimits::default()).unwrap();
        let labels = data.join("labels").join(format!("{name}.labels.png"));
        let labels = read_image(&labels, ReadLimits::default()).unwrap();
        let labels = labels_from_grey(&labels.map(|pixel| pixel.0[0]));
        let normalized = normalized(&picture, settings.size, settings.threshold).unwrap();
        let placement = normalized.placement;
        let outlined = Outlined::new(&normalized, Progress::silent());
        let (pins, _) = outlined.pins(&placement.placed(&labels, Label::Background));
        let crop = Point::new(f64::from(placement.crop.x), f64::from(placement.crop.y));
        let placed = |x: f64, y: f64| {
            (Point::new(x, y) + 0.5 - crop) * placement.scale + placement.offset - 0.5
        };
        let points = &outlined.longest;
        let size = f64::from(settings.size);
        let error = [
            (points[pins.left].x - placed(left, baseline_y).x).abs(),
            (points[pins.right].x - placed(right, baseline_y).x).abs(),
            points[pins.bottom].distance(placed(bottom_x, bottom_y)),
        ]
        .map(|pixels| pixels / size);
        errors.push((error.into_iter().fold(0.0, f64::max), name));
    }
    errors.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (error, name) in errors.iter().rev().take(5) {
        eprintln!("{name}: {:.1} % of the picture's side", 100.0 * error);
    }
    let median = errors[errors.len() / 2].0;
    let good =
        errors.iter().filter(|(error, _)| *error < 0.03).count() as f64 / errors.len() as f64;
    eprintln!(
        "median {:.2} %, within 3 %: {:.0} %",
        100.0 * median,
        100.0 * good
    );
    assert!(median <= 0.015, "{median}");
    assert!(good >= 0.75, "{good}");
}
