//! Measurements of the way from a mask to a base mesh.

use super::super::failure::Failure;
use super::row::{Baseline, Row, measured};
use crate::base::{Cancel, Progress};
use crate::crown::{Domain, Inflation, InflationError, Sheet};
use crate::raster::{Image, Mask};
use crate::solve::poisson;
use std::hint::black_box;

const THESIS_MESH: Baseline = Baseline {
    what: "Argudo (2014): 2 to 3 s with Eigen",
    ms: 2_000.0,
};
const EIGEN_512: Baseline = Baseline {
    what: "Eigen LDLT: 6.0 s of CPU",
    ms: 6_000.0,
};
const EIGEN_1024: Baseline = Baseline {
    what: "Eigen LDLT 68 s, CHOLMOD 14 s of CPU",
    ms: 14_000.0,
};

/// All measurements, on discs that fill most of a square.
pub(super) fn rows(cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let cold = |name: &'static str, size: u32| {
        let mask = disc(size, 0.0);
        measured(name, cancel, || {
            let inflation = inflated(&mask, cancel)?;
            black_box(sheet(&inflation, &falling_k(&inflation), cancel)?);
            Ok::<(), Failure>(())
        })
    };
    let mut rows = vec![
        cold("mask to base mesh, 256", 256)?
            .target(150.0)
            .against(THESIS_MESH),
        cold("mask to base mesh, 512", 512)?.against(EIGEN_512),
        cold("mask to base mesh, 1024", 1024)?
            .target(2_000.0)
            .against(EIGEN_1024),
    ];
    rows.push(another_k("another k, 256", 256, cancel)?.target(8.0));
    rows.push(another_k("another k, 512", 512, cancel)?.target(40.0));
    for (name, size) in [("one stroke, 256", 256), ("one stroke, 512", 512)] {
        let before = inflated(&disc(size, 0.0), cancel)?;
        let after = disc(size, 0.03 * f64::from(size));
        rows.push(measured(name, cancel, || {
            let updated = before
                .updated(&after, Progress::silent(), cancel)
                .map_err(failure)?;
            black_box(sheet(&updated, &falling_k(&updated), cancel)?);
            Ok::<(), Failure>(())
        })?);
    }
    let mask = disc(256, 0.0);
    let right = mask.map(|&inside| f64::from(u8::from(inside)));
    rows.push(measured("Poisson equation, 256", cancel, || {
        black_box(poisson(&mask, &right, cancel)?);
        Ok::<(), Failure>(())
    })?);
    Ok(rows)
}

fn inflated(mask: &Mask, cancel: &Cancel) -> Result<Inflation, Failure> {
    let domain = Domain::new(mask).map_err(failure)?;
    Inflation::new(domain, Progress::silent(), cancel).map_err(failure)
}

fn sheet(inflation: &Inflation, k: &[f64], cancel: &Cancel) -> Result<Sheet, Failure> {
    inflation.sheet(k, cancel).map_err(failure)
}

fn failure(error: InflationError) -> Failure {
    match error {
        InflationError::Cancelled(cancelled) => cancelled.into(),
        other => Failure::Environment(other.to_string()),
    }
}

/// A k that falls from top to bottom, so that no solution can be scaled from another.
fn falling_k(inflation: &Inflation) -> Vec<f64> {
    let ring = inflation.domain().ring().iter();
    ring.map(|pixel| 3.0 - 0.005 * f64::from(pixel.y)).collect()
}

fn another_k(name: &'static str, size: u32, cancel: &Cancel) -> Result<Row, Failure> {
    let inflation = inflated(&disc(size, 0.0), cancel)?;
    let k = falling_k(&inflation);
    measured(name, cancel, || {
        black_box(sheet(&inflation, &k, cancel)?);
        Ok::<(), Failure>(())
    })
}

/// A disc across 84 % of a square of `size` pixels, with a bump of this radius on its right.
fn disc(size: u32, bump: f64) -> Mask {
    let (radius, center) = (0.42 * f64::from(size), (f64::from(size) - 1.0) / 2.0);
    let inside = |i: u32| {
        let x = f64::from(i % size) - center;
        let y = f64::from(i / size) - center;
        x * x + y * y < radius * radius || (x - radius) * (x - radius) + y * y < bump * bump
    };
    Image::from_pixels(size, size, (0..size * size).map(inside).collect())
}
