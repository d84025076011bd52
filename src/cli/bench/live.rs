//! Measurements of what happens between an edit and the crown that shows it, until it is ready for
//! the graphics card.

use super::super::failure::Failure;
use super::row::{Row, measured};
use crate::base::{Cancel, Progress, Seed};
use crate::crown::Tangent;
use crate::document;
use crate::paint::{CROWN, TiledMask};
use crate::pipeline::{CrownRequest, LiveCrown, LiveInput, LiveResult, Quality};
use crate::raster::{Image, Straight};
use crate::render::PreparedCrown;
use std::hint::black_box;
use std::sync::Arc;

/// Side of the photograph, pixels.
const SIDE: u32 = 1024;

/// All measurements, on a disc of speckled green at the size of 256.
pub(super) fn rows(cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let photo = Arc::new(photo());
    let input = |bump: f64| LiveInput {
        photo: Arc::clone(&photo),
        labels: Arc::new(labels(bump)),
    };
    let (one, other) = (input(0.0), input(40.0));
    let mut live = LiveCrown::default();
    let first = updated(&mut live, &one, &request(), Quality::Full, cancel)?;
    let prepared = PreparedCrown::new(&first.crown, cancel)?;
    let mut turn = 0u32;
    let mut rows = Vec::new();
    for (name, quality, target) in [
        ("live: k", Quality::Coarse, Some(16.0)),
        ("live: k, refined", Quality::Fine, None),
    ] {
        let row = measured(name, cancel, || {
            turn += 1;
            let mut request = request();
            let k = 1.5 + 0.01 * f64::from(turn % 50);
            request.settings.k = Some(Tangent::Constant(k));
            let made = updated(&mut live, &one, &request, quality, cancel)?;
            black_box(prepared.reshaped(&made.crown));
            Ok::<(), Failure>(())
        })?;
        rows.push(match target {
            Some(target) => row.target(target),
            None => row,
        });
    }
    rows.push(
        measured("live: ρ", cancel, || {
            turn += 1;
            let mut request = request();
            request.settings.rho = 0.01 * f64::from(turn % 50);
            let made = updated(&mut live, &one, &request, Quality::Fine, cancel)?;
            black_box(prepared.reshaped(&made.crown));
            Ok::<(), Failure>(())
        })?
        .target(16.0),
    );
    rows.push(
        measured("live: stroke", cancel, || {
            turn += 1;
            let input = if turn.is_multiple_of(2) { &one } else { &other };
            let made = updated(&mut live, input, &request(), Quality::Coarse, cancel)?;
            black_box(prepared.reshaped(&made.crown));
            Ok::<(), Failure>(())
        })?
        .target(100.0),
    );
    Ok(rows)
}

fn request() -> CrownRequest {
    let asked = document::CrownSettings::default();
    CrownRequest::of(&asked).unwrap_or_else(|_| unreachable!("the default has no formula"))
}

fn updated(
    live: &mut LiveCrown,
    input: &LiveInput,
    request: &CrownRequest,
    quality: Quality,
    cancel: &Cancel,
) -> Result<LiveResult, Failure> {
    let made = live.update(input, request, quality, Progress::silent(), cancel);
    made.map_err(|error| match error.is_cancelled() {
        true => Failure::Cancelled,
        false => Failure::Environment(error.to_string()),
    })
}

fn photo() -> Image<Straight> {
    let mut random = Seed(1).random();
    let pixels = (0..SIDE * SIDE).map(|_| {
        let light = random.below(120) as u8;
        Straight([30 + light / 2, 50 + light, 20 + light / 3, 255])
    });
    Image::from_pixels(SIDE, SIDE, pixels.collect())
}

/// A disc with a bump of this radius on its right.
fn labels(bump: f64) -> TiledMask {
    let (radius, center) = (0.42 * f64::from(SIDE), f64::from(SIDE) / 2.0);
    let label = |i: u32| {
        let (x, y) = (f64::from(i % SIDE) - center, f64::from(i / SIDE) - center);
        let is_crown = x.hypot(y) < radius || (x - radius).hypot(y) < bump;
        if is_crown { CROWN } else { 0 }
    };
    TiledMask::from_image(&Image::from_pixels(
        SIDE,
        SIDE,
        (0..SIDE * SIDE).map(label).collect(),
    ))
}
