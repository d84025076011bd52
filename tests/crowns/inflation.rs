//! The inflation of masks: beside solutions of CHOLMOD, on discs, on a zoo of nasty masks, and the
//! two solvers beside a dense one and each other.
//!
//! The reference solutions lie in the folder that `BOSCAGE_ORACLE` names, by default `oracle` beside
//! `BOSCAGE_DATA`; without them their test says so and passes.

use crate::reference;
use boscage::base::{Cancel, Progress, with_threads};
use boscage::crown::{Domain, Inflation, InflationError, Sheet};
use boscage::raster::{Image, Mask, ReadLimits, read_image};
use boscage::solve::{Factor, GridSystem, Method, Multigrid, Solver, Stencil, poisson};
use proptest::prelude::*;

fn inflation(mask: &Mask, method: Method) -> Inflation {
    let domain = Domain::new(mask).unwrap();
    Inflation::with_method(domain, method, Progress::silent(), &Cancel::new()).unwrap()
}

fn sheet(inflation: &Inflation, k: f64) -> Sheet {
    let ring = vec![k; inflation.domain().ring().len()];
    inflation.sheet(&ring, &Cancel::new()).unwrap()
}

/// k that varies along the ring.
fn varying(inflation: &Inflation) -> Vec<f64> {
    let ring = inflation.domain().ring().iter();
    ring.map(|pixel| 2.0 + 0.3 * f64::from((pixel.x * 7 + pixel.y * 3) % 11))
        .collect()
}

/// The largest distance between the points of two sheets over the largest coordinate of either.
fn difference(a: &Sheet, b: &Sheet) -> f64 {
    assert_eq!(a.positions.len(), b.positions.len());
    let size = a
        .positions
        .iter()
        .fold(0.0f64, |most, p| most.max(p.length()));
    let pairs = a.positions.iter().zip(&b.positions);
    pairs.fold(0.0f64, |most, (a, b)| most.max(a.distance(*b))) / size.max(1e-300)
}

fn disc(size: u32) -> (Mask, f64) {
    let (radius, center) = (0.42 * f64::from(size), (f64::from(size) - 1.0) / 2.0);
    let inside = |i: u32| {
        let (x, y) = (f64::from(i % size) - center, f64::from(i / size) - center);
        x * x + y * y < radius * radius
    };
    (
        Image::from_pixels(size, size, (0..size * size).map(inside).collect()),
        radius,
    )
}

fn drawn(rows: &[&str]) -> Mask {
    let pixels = rows.iter().flat_map(|row| row.bytes().map(|b| b == b'#'));
    Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels.collect())
}

/// `mask` with every pixel `factor` times as large.
fn enlarged(mask: &Mask, factor: u32) -> Mask {
    let (width, height) = (mask.width() * factor, mask.height() * factor);
    let pixel = |i: u32| mask.at(i % width / factor, i / width / factor);
    Image::from_pixels(width, height, (0..width * height).map(pixel).collect())
}

/// Masks that go wrong easily.
fn zoo() -> Vec<(&'static str, Mask)> {
    let ring = enlarged(&drawn(&["#####", "#...#", "#.#.#", "#...#", "#####"]), 9);
    let mut neck = enlarged(&drawn(&["##..##", "##..##"]), 11);
    for x in 22..44 {
        neck.set(x, 11, true);
    }
    let spiral = drawn(&[
        "#########",
        "........#",
        "#######.#",
        "#.....#.#",
        "#.###.#.#",
        "#.#...#.#",
        "#.#####.#",
        "#.......#",
        "#########",
    ]);
    let comb = Image::from_pixels(
        60,
        40,
        (0..2400).map(|i| i / 60 < 8 || i % 60 % 6 < 4).collect(),
    );
    vec![
        ("a single pixel", Image::filled(1, 1, true)),
        ("a line", Image::filled(17, 1, true)),
        ("silhouette only", Image::filled(30, 2, true)),
        ("one unknown", Image::filled(3, 3, true)),
        ("the full frame", Image::filled(61, 47, true)),
        ("a ring around an island", ring),
        ("two blobs joined by a line", neck),
        ("a thin spiral", spiral.clone()),
        ("a thick spiral", enlarged(&spiral, 6)),
        ("a comb", comb),
        (
            "corners that touch",
            enlarged(&drawn(&["#.#", ".#.", "#.#"]), 8),
        ),
    ]
}

#[test]
fn positions_are_those_of_cholmod() {
    let Some(folder) = reference::oracle() else {
        return;
    };
    for name in ["circle", "blob"] {
        let picture = folder.join(format!("in/mask_{name}_256.png"));
        let mask = read_image(&picture, ReadLimits::default()).unwrap();
        let mask = mask.map(|pixel| pixel.0[0] >= 128 && pixel.alpha() >= 128);
        let text = std::fs::read(folder.join(format!("inflate_{name}_256_k2.json"))).unwrap();
        let reference: serde_json::Value = serde_json::from_slice(&text).unwrap();
        for method in [Method::Direct, Method::Multigrid] {
            let sheet = sheet(&inflation(&mask, method), 2.0);
            let number_of = |place: u64| {
                let pixel = ((place % 256) as u32, (place / 256) as u32);
                sheet
                    .domain
                    .pixels()
                    .iter()
                    .position(|&p| p == pixel)
                    .unwrap()
            };
            let height = sheet.positions.iter().fold(0.0f64, |most, p| most.max(p.z));
            let mut worst = 0.0f64;
            let places = reference["idx"].as_array().unwrap();
            let points = reference["xyz"].as_array().unwrap();
            assert_eq!(places.len(), points.len());
            assert!(places.len() > 500);
            for (place, point) in places.iter().zip(points) {
                let ours = sheet.positions[number_of(place.as_u64().unwrap())];
                for axis in 0..3 {
                    worst = worst.max((ours[axis] - point[axis].as_f64().unwrap()).abs());
                }
            }
            println!("{name}, {method:?}: {:.1e} of the height", worst / height);
            assert!(worst / height < 1e-6, "{name}, {method:?}: {worst:e}");
        }
    }
}

/// Root mean square and largest deviation from a half-sphere, over its radius.
fn from_sphere(sheet: &Sheet, radius: f64, center: f64) -> (f64, f64) {
    let (mut sum, mut most) = (0.0, 0.0f64);
    for p in &sheet.positions {
        let (x, y) = (p.x - center, p.y - center);
        let off = (x * x + y * y + p.z * p.z).sqrt() / radius - 1.0;
        sum += off * off;
        most = most.max(off.abs());
    }
    ((sum / sheet.positions.len() as f64).sqrt(), most)
}

#[test]
fn a_disc_becomes_nearly_a_half_sphere_and_flat_as_k_vanishes() {
    let (mask, radius) = disc(256);
    let inflation = inflation(&mask, Method::Automatic);
    let deviation = |k: f64| from_sphere(&sheet(&inflation, k), radius, 127.5);
    let (best, (rms, most)) = (30..=60)
        .map(|i| f64::from(i) * 0.05)
        .map(|k| (k, deviation(k)))
        .min_by(|a, b| a.1.0.total_cmp(&b.1.0))
        .unwrap();
    println!(
        "best k {best:.2}: RMS {:.1} %, at most {:.1} % of R",
        100.0 * rms,
        100.0 * most
    );
    assert!((2.1..2.4).contains(&best), "{best}");
    assert!(rms < 0.05 && most < 0.083, "{rms} {most}");
    let top = |k: f64| {
        sheet(&inflation, k)
            .positions
            .iter()
            .fold(0.0f64, |m, p| m.max(p.z))
    };
    assert!((top(2.0803) / radius - 1.0).abs() < 1e-3, "{}", top(2.0803));
    assert_eq!(top(0.0), 0.0);
    assert!((top(0.01) - 0.01 * top(1.0)).abs() < 1e-12);
}

#[test]
fn the_zoo_is_inflated_alike_by_both_solvers() {
    for (name, mask) in zoo() {
        let direct = inflation(&mask, Method::Direct);
        let sheet = sheet(&direct, 2.0);
        assert_eq!(sheet.positions.len(), mask.count(), "{name}");
        for (i, (p, &(x, y))) in sheet
            .positions
            .iter()
            .zip(sheet.domain.pixels())
            .enumerate()
        {
            assert!(p.is_finite(), "{name}");
            if sheet.domain.is_silhouette(i) {
                assert_eq!((p.x, p.y, p.z), (x.into(), y.into(), 0.0), "{name}");
            } else {
                assert!(p.z > 0.0, "{name}: {p} at {x}, {y}");
            }
        }
        let other = inflation(&mask, Method::Multigrid);
        let k = varying(&direct);
        let cancel = Cancel::new();
        let pair = [&direct, &other].map(|inflation| inflation.sheet(&k, &cancel).unwrap());
        let off = difference(&pair[0], &pair[1]);
        assert!(off < 1e-6, "{name}: {off:e}");
    }
}

#[test]
fn a_constant_k_is_the_limit_of_a_varying_one() {
    let (mask, _) = disc(64);
    let inflation = inflation(&mask, Method::Direct);
    let mut k = vec![1.5; inflation.domain().ring().len()];
    let constant = inflation.sheet(&k, &Cancel::new()).unwrap();
    k[0] += 1e-12;
    let solved = inflation.sheet(&k, &Cancel::new()).unwrap();
    assert!(difference(&constant, &solved) < 1e-10);
}

#[test]
fn threads_do_not_change_a_bit() {
    let (mask, _) = disc(300);
    let bits = |threads: usize, method: Method| {
        with_threads(Some(threads), || {
            let inflation = inflation(&mask, method);
            let sheet = inflation
                .sheet(&varying(&inflation), &Cancel::new())
                .unwrap();
            let bits = |p: &glam::DVec3| p.to_array().map(f64::to_bits);
            sheet.positions.iter().map(bits).collect::<Vec<_>>()
        })
        .unwrap()
    };
    for method in [Method::Direct, Method::Multigrid] {
        assert!(bits(1, method) == bits(3, method), "{method:?}");
    }
}

#[test]
fn an_edited_mask_gives_what_a_new_one_gives() {
    let (mask, radius) = disc(380);
    let edited = Image::from_pixels(
        380,
        380,
        (0..380 * 380)
            .map(|i| {
                let (x, y) = (f64::from(i % 380u32) - 330.0, f64::from(i / 380) - 190.0);
                let added = x * x + y * y < 900.0;
                let removed = i / 380 < (190.0 - 0.9 * radius) as u32;
                (mask.pixels()[i as usize] || added) && !removed
            })
            .collect(),
    );
    let last = inflation(&mask, Method::Automatic);
    let updated = last
        .updated(&edited, Progress::silent(), &Cancel::new())
        .unwrap();
    let fresh = inflation(&edited, Method::Direct);
    let off = difference(&sheet(&updated, 2.0), &sheet(&fresh, 2.0));
    assert!(off < 1e-6, "{off:e}");
}

#[test]
fn wrong_values_of_k_and_cancelled_work_are_refused() {
    let inflation = inflation(&Image::filled(5, 5, true), Method::Automatic);
    let cancel = Cancel::new();
    let short = inflation.sheet(&[1.0], &cancel);
    assert!(matches!(
        short,
        Err(InflationError::RingLength {
            given: 1,
            expected: 20
        })
    ));
    let mut k = vec![1.0; 20];
    k[7] = f64::NAN;
    let wrong = inflation.sheet(&k, &cancel);
    assert!(matches!(wrong, Err(InflationError::NotFinite { .. })));
    cancel.cancel();
    for method in [Method::Direct, Method::Multigrid] {
        let domain = Domain::new(&disc(128).0).unwrap();
        let stopped = Inflation::with_method(domain, method, Progress::silent(), &cancel);
        assert!(matches!(stopped, Err(InflationError::Cancelled(_))));
    }
}

#[test]
fn harmonic_quadratics_are_found_again_by_poisson() {
    // u = (x + 1)(32 − x)(y + 1)(24 − y) is zero around the frame; its second differences are exact.
    let u = |x: f64, y: f64| (x + 1.0) * (32.0 - x) * (y + 1.0) * (24.0 - y);
    let place = |i: u32| (f64::from(i % 32), f64::from(i / 32));
    let right = |(x, y): (f64, f64)| 2.0 * (y + 1.0) * (24.0 - y) + 2.0 * (x + 1.0) * (32.0 - x);
    let sides = Image::from_pixels(32, 24, (0..32 * 24).map(|i| right(place(i))).collect());
    let found = poisson(&Image::filled(32, 24, true), &sides, &Cancel::new()).unwrap();
    for (i, found) in (0..).zip(found.pixels()) {
        let (x, y) = place(i);
        assert!((found - u(x, y)).abs() < 1e-7, "{found} at {x}, {y}");
    }
}

/// Gaussian elimination on the whole matrix.
fn dense_solution(system: &GridSystem, right: &[f64]) -> Vec<f64> {
    let count = system.len();
    let column = |j: usize| {
        let mut unit = vec![0.0; count];
        unit[j] = 1.0;
        system.product(&unit)
    };
    let mut rows: Vec<Vec<f64>> = (0..count).map(column).collect();
    let mut values = right.to_vec();
    for i in 0..count {
        for j in i + 1..count {
            let factor = rows[j][i] / rows[i][i];
            let (above, below) = rows.split_at_mut(j);
            for (value, other) in below[0].iter_mut().zip(&above[i]) {
                *value -= factor * other;
            }
            values[j] -= factor * values[i];
        }
    }
    for i in (0..count).rev() {
        let sum: f64 = (i + 1..count).map(|j| rows[i][j] * values[j]).sum();
        values[i] = (values[i] - sum) / rows[i][i];
    }
    values
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn both_solvers_agree_with_elimination(
        (width, pixels) in (1u32..20).prop_flat_map(|width| {
            (Just(width), prop::collection::vec(prop::bool::weighted(0.8), width as usize * 14))
        }),
        seed in 0u32..1000,
    ) {
        let mask = Image::from_pixels(width, 14, pixels);
        for stencil in [Stencil::Laplacian, Stencil::Bilaplacian] {
            let system = GridSystem::new(&mask, stencil);
            let right: Vec<f64> = (0..system.len() as u32)
                .map(|i| f64::from((i * 37 + seed) % 101) - 50.0)
                .collect();
            let expected = dense_solution(&system, &right);
            let size = expected.iter().fold(1e-300f64, |most, v| most.max(v.abs()));
            let cancel = Cancel::new();
            for method in [Method::Direct, Method::Multigrid] {
                let solver = Solver::new(system.clone(), method, &cancel).unwrap();
                let found = solver.solution(&right, None, &cancel).unwrap();
                for (found, expected) in found.iter().zip(&expected) {
                    prop_assert!((found - expected).abs() < 1e-6 * size, "{method:?} {stencil:?}");
                }
            }
        }
    }
}

#[test]
fn the_iterations_hardly_grow_with_the_size() {
    let cancel = Cancel::new();
    for (size, most) in [(100, 16), (200, 18), (400, 20)] {
        let system = GridSystem::new(&disc(size).0, Stencil::Bilaplacian);
        let right = vec![1.0; system.len()];
        let multigrid = Multigrid::new(&system, &cancel).unwrap().unwrap();
        let found = multigrid.solution(&right, None, &cancel).unwrap();
        println!("{size}: {} iterations", found.iterations);
        assert!(found.iterations <= most, "{size}: {}", found.iterations);
        let exact = Factor::new(&system, &cancel).unwrap().solution(&right);
        let again = multigrid.solution(&right, Some(&exact), &cancel).unwrap();
        assert!(again.iterations <= 1, "{}", again.iterations);
        assert!(again.solution.is_some());
    }
}
