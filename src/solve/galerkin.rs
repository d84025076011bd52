//! Coarse matrices of the multigrid hierarchy: PᵀAP, P being the cubic B-spline's weights restricted
//! to the unknowns of both grids.
//!
//! A coarse pixel (x, y) stands on the fine pixel (2x, 2y) and has an unknown where that has one.
//! The product of 5 × 5 or 7 × 7 stencils with these weights has 7 × 7 entries again. Coarse rows
//! far from the border are all the same and are reckoned once.
//!
//! Rediscretised coarse operators, the usual short cut, need three to eight times as many
//! iterations near a clamped border.

use super::grid::GridSystem;
use super::level::{Level, PAD, REACH, Row, SIDE};
use rayon::prelude::*;

/// Steps of the power iteration for the largest eigenvalue, and what is added for safety: it comes
/// from below, and a bound that is too small makes the cycle indefinite. The eigenvalue for waves on
/// an endless grid is too small, since rows near the border exceed it.
const POWER_STEPS: usize = 10;
const SAFETY: f32 = 1.2;

/// The weight of the B-spline at distance −2 … 2.
const WEIGHTS: [f64; 5] = [0.125, 0.5, 0.75, 0.5, 0.125];

/// The grid of `system`, from its first occupied column and row on.
pub(super) fn finest(system: &GridSystem) -> (Level, (u32, u32)) {
    let columns = system.pixels().iter().map(|pixel| pixel.0);
    let rows = system.pixels().iter().map(|pixel| pixel.1);
    let least = |values: &mut dyn Iterator<Item = u32>| {
        values.fold((u32::MAX, 0), |(low, high), v| (low.min(v), high.max(v)))
    };
    let (left, right) = least(&mut columns.into_iter());
    let (top, bottom) = least(&mut rows.into_iter());
    let side = |first: u32, last: u32| (last - first + 1).next_multiple_of(2) as usize + 2 * PAD;
    let (width, height) = (side(left, right), side(top, bottom));
    let mut unknown = vec![false; width * height];
    for &(x, y) in system.pixels() {
        unknown[((y - top) as usize + PAD) * width + (x - left) as usize + PAD] = true;
    }
    let mut common: Row = [0.0; SIDE * SIDE];
    let mut total = 0.0;
    for &(dx, dy, coefficient) in system.stencil().entries() {
        common[((dy + 3) * 7 + dx + 3) as usize] = coefficient as f32;
        total += coefficient.abs();
    }
    let special_at = vec![u32::MAX; unknown.len()];
    let mut level = level(width, height, unknown, common, Vec::new(), special_at);
    // Gershgorin's bound, which both stencils nearly reach.
    level.largest = (total / system.stencil().entries()[0].2) as f32;
    (level, (left, top))
}

fn level(
    width: usize,
    height: usize,
    unknown: Vec<bool>,
    common: Row,
    special: Vec<(usize, Row)>,
    special_at: Vec<u32>,
) -> Level {
    let mask = unknown.iter().map(|&is| f32::from(u8::from(is))).collect();
    let mut level = Level {
        width,
        height,
        inverse_diagonal: vec![0.0; unknown.len()],
        unknown,
        mask,
        common,
        special,
        special_at,
        largest: 0.0,
    };
    for place in 0..level.unknown.len() {
        if level.unknown[place] {
            level.inverse_diagonal[place] = 1.0 / level.row(place)[REACH * SIDE + REACH];
        }
    }
    level
}

/// The grid of half the size.
pub(super) fn coarser(fine: &Level) -> Level {
    let side = |side: usize| (side - 2 * PAD).div_ceil(2).next_multiple_of(2) + 2 * PAD;
    let (width, height) = (side(fine.width), side(fine.height));
    let mut unknown = vec![false; width * height];
    for y in PAD..height - PAD {
        for x in PAD..width - PAD {
            let (fx, fy) = fine_of(x, y);
            unknown[y * width + x] =
                fx < fine.width && fy < fine.height && fine.unknown[fy * fine.width + fx];
        }
    }
    let is_far = far_from_border(fine, &unknown, width, height);
    let row = |place: usize| product_row(fine, &unknown, width, place);
    let places = (0..unknown.len()).filter(|&place| unknown[place]);
    let (far, near): (Vec<usize>, Vec<usize>) = places.partition(|&place| is_far[place]);
    let common = far.first().map(|&place| row(place));
    let special: Vec<(usize, Row)> = near.par_iter().map(|&place| (place, row(place))).collect();
    let mut special_at = vec![u32::MAX; unknown.len()];
    for (number, (place, _)) in special.iter().enumerate() {
        special_at[*place] = number as u32;
    }
    let common = common.unwrap_or([0.0; SIDE * SIDE]);
    let mut level = level(width, height, unknown, common, special, special_at);
    level.largest = SAFETY * largest_eigenvalue(&level);
    level
}

/// The fine pixel under the coarse pixel (x, y).
fn fine_of(x: usize, y: usize) -> (usize, usize) {
    (2 * (x - PAD) + PAD, 2 * (y - PAD) + PAD)
}

/// Where the row of a coarse unknown does not feel the border.
fn far_from_border(fine: &Level, unknown: &[bool], width: usize, height: usize) -> Vec<bool> {
    let common: Vec<bool> = (0..fine.unknown.len())
        .map(|place| fine.unknown[place] && fine.special_at[place] == u32::MAX)
        .collect();
    let fine_far = eroded(&fine.unknown, fine.width, fine.height, REACH + 2);
    let fine_common = eroded(&common, fine.width, fine.height, 2);
    let mut far = eroded(unknown, width, height, REACH);
    for place in (0..far.len()).filter(|&place| unknown[place]) {
        let (fx, fy) = fine_of(place % width, place / width);
        let under = fy * fine.width + fx;
        far[place] = far[place] && fine_far[under] && fine_common[under];
    }
    far
}

/// Where all pixels within `radius` along both axes are set.
fn eroded(set: &[bool], width: usize, height: usize, radius: usize) -> Vec<bool> {
    let mut rows = vec![false; set.len()];
    for y in 0..height {
        let mut run = 0;
        for x in 0..width {
            run = if set[y * width + x] { run + 1 } else { 0 };
            if run > 2 * radius {
                rows[y * width + x - radius] = true;
            }
        }
    }
    let mut out = vec![false; set.len()];
    let mut runs = vec![0; width];
    for y in 0..height {
        for (x, run) in runs.iter_mut().enumerate() {
            *run = if rows[y * width + x] { *run + 1 } else { 0 };
            if *run > 2 * radius {
                out[(y - radius) * width + x] = true;
            }
        }
    }
    out
}

/// One row of PᵀAP.
fn product_row(fine: &Level, unknown: &[bool], width: usize, place: usize) -> Row {
    let (fx, fy) = fine_of(place % width, place / width);
    let mut sums = [0.0; SIDE * SIDE];
    for (a, b) in (0..25).map(|i| (i % 5, i / 5)) {
        let under = (fy + b - 2) * fine.width + fx + a - 2;
        if !fine.unknown[under] {
            continue;
        }
        let weight = WEIGHTS[a] * WEIGHTS[b];
        for (i, &coefficient) in fine.row(under).iter().enumerate() {
            if coefficient == 0.0 {
                continue;
            }
            let (dx, dy) = (
                a as isize + (i % SIDE) as isize - 5,
                b as isize + (i / SIDE) as isize - 5,
            );
            let other = ((fy * fine.width + fx) as isize + dy * fine.width as isize + dx) as usize;
            if fine.unknown[other] {
                gather(&mut sums, dx, dy, weight * f64::from(coefficient));
            }
        }
    }
    let mut row = [0.0; SIDE * SIDE];
    for (i, (value, sum)) in row.iter_mut().zip(sums).enumerate() {
        let other = place + (i / SIDE) * width + i % SIDE - REACH * width - REACH;
        *value = if unknown[other] { sum as f32 } else { 0.0 };
    }
    row
}

/// Shares `value`, at the fine offset (dx, dy), among the coarse pixels whose weights reach it.
fn gather(sums: &mut [f64; SIDE * SIDE], dx: isize, dy: isize, value: f64) {
    let parents = |d: isize| (-3..=3).filter(move |j| (d - 2 * j).abs() <= 2);
    for jy in parents(dy) {
        for jx in parents(dx) {
            let weight = WEIGHTS[(dx - 2 * jx + 2) as usize] * WEIGHTS[(dy - 2 * jy + 2) as usize];
            sums[((jy + 3) * 7 + jx + 3) as usize] += weight * value;
        }
    }
}

/// The largest eigenvalue of the matrix over its diagonal, from below.
fn largest_eigenvalue(level: &Level) -> f32 {
    let mut state = 1u32;
    let mut field: Vec<f32> = level
        .mask
        .iter()
        .map(|mask| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            mask * ((state >> 9) as f32 / (1 << 22) as f32 - 1.0)
        })
        .collect();
    let norm = |field: &[f32]| {
        field
            .iter()
            .map(|v| f64::from(*v) * f64::from(*v))
            .sum::<f64>()
            .sqrt()
    };
    let mut product = vec![0.0; field.len()];
    let mut largest = 1.0;
    for _ in 0..POWER_STEPS {
        let before = norm(&field);
        level.product(&field, &mut product);
        for (value, inverse) in product.iter_mut().zip(&level.inverse_diagonal) {
            *value *= inverse;
        }
        let after = norm(&product);
        if before == 0.0 || after == 0.0 {
            break;
        }
        largest = after / before;
        for (value, product) in field.iter_mut().zip(&product) {
            *value = (f64::from(*product) / after) as f32;
        }
    }
    largest as f32
}
