//! Measurements of the brush: what a hand waits for between two places of the pen.

use super::super::failure::Failure;
use super::row::Row;
use crate::base::Cancel;
use crate::document::{Document, Edit, NewPhoto, PhotoId};
use crate::paint::{BrushSettings, CROWN, Paint, Sample, Stroke, TiledMask};
use std::sync::Arc;
use std::time::Instant;

/// Side of the photograph, pixels.
const SIDE: u32 = 8192;

/// Strokes, and places of the pen in each, 48 pixels apart.
const STROKES: u32 = 40;
const STEPS: u32 = 150;

/// A brush of 200 pixels on a photograph of 8192²: each place of the pen, and each stroke as a step
/// that can be undone.
pub(super) fn rows(cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for (hardness, median, late, commit) in [
        (
            1.0,
            "brush 200 px, 8192², median",
            "brush 200 px, 8192², 95 of 100",
            "the stroke as a step",
        ),
        (
            0.5,
            "soft brush 200 px, 8192², median",
            "soft brush 200 px, 8192², 95 of 100",
            "the soft stroke as a step",
        ),
    ] {
        let (mut steps, commits) = painted(hardness, cancel)?;
        steps.sort_by(f64::total_cmp);
        let of_share = |share: f64| vec![steps[(share * (steps.len() - 1) as f64) as usize]];
        // 60 places of the pen a second.
        rows.push(Row::of_times(median, of_share(0.5)).target(16.7));
        rows.push(Row::of_times(late, of_share(0.95)).target(16.7));
        rows.push(Row::of_times(commit, commits));
    }
    Ok(rows)
}

/// Milliseconds for each place of the pen, and for keeping each stroke.
fn painted(hardness: f64, cancel: &Cancel) -> Result<(Vec<f64>, Vec<f64>), Failure> {
    let mut project = Document::new();
    let refused = |error: crate::document::EditError| Failure::Environment(error.to_string());
    let photo = PhotoId(project.state().content().next_photo);
    // The project does not look into pictures.
    let large = NewPhoto::new("large", Arc::from(*b"large"), (SIDE, SIDE));
    let edit = Edit::AddPhotos(vec![large]);
    project.apply("Add Picture", edit).map_err(refused)?;
    let settings = BrushSettings {
        radius_px: 100.0,
        hardness,
        ..BrushSettings::default()
    };
    let (mut steps, mut commits) = (Vec::new(), Vec::new());
    for stroke in 0..STROKES {
        cancel.check()?;
        let mask = project.state().mask(photo);
        let mut mask =
            mask.map_or_else(|| TiledMask::filled(SIDE, SIDE, 0), |mask| (**mask).clone());
        let mut brush = Stroke::new(settings, Paint::of(CROWN));
        let row = f64::from(150 + stroke * 197);
        for step in 0..STEPS {
            let wave = 60.0 * libm::sin(f64::from(step) * 0.3);
            let sample = Sample::at(200.0 + 48.0 * f64::from(step), row + wave);
            let begin = Instant::now();
            std::hint::black_box(brush.extend(&mut mask, sample));
            steps.push(begin.elapsed().as_secs_f64() * 1e3);
        }
        let begin = Instant::now();
        brush.finish(&mut mask);
        let edit = Edit::SetMask(photo, Arc::new(mask));
        project.apply("Brush", edit).map_err(refused)?;
        commits.push(begin.elapsed().as_secs_f64() * 1e3);
    }
    Ok((steps, commits))
}
