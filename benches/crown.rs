//! Measurements of the crown pipeline: `cargo bench --bench crown`.

use boscage::base::{Cancel, Progress};
use boscage::crown::{Domain, Inflation};
use boscage::raster::{Image, Mask};
use boscage::solve::poisson;
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// A disc that fills 84 % of a square image of `size` pixels, with a `bump` at its right.
fn disc(size: u32, bump: f64) -> Mask {
    let (radius, center) = (0.42 * f64::from(size), (f64::from(size) - 1.0) / 2.0);
    let inside = |i: u32| {
        let x = f64::from(i % size) - center;
        let y = f64::from(i / size) - center;
        x * x + y * y < radius * radius || (x - radius).powi(2) + y * y < bump * bump
    };
    Image::from_pixels(size, size, (0..size * size).map(inside).collect())
}

fn inflation(mask: &Mask) -> Inflation {
    let domain = Domain::new(mask).expect("a disc has pixels");
    Inflation::new(domain, Progress::silent(), &Cancel::new()).expect("nobody cancels")
}

#[divan::bench(args = [256, 512, 1024])]
fn mask_to_sheet(bencher: Bencher<'_, '_>, size: u32) {
    let mask = disc(size, 0.0);
    bencher.bench_local(|| {
        let inflation = inflation(black_box(&mask));
        let ring = vec![2.0; inflation.domain().ring().len()];
        inflation.sheet(&ring, &Cancel::new())
    });
}

#[divan::bench(args = [256, 512, 1024])]
fn varying_k(bencher: Bencher<'_, '_>, size: u32) {
    let inflation = inflation(&disc(size, 0.0));
    let ring = inflation.domain().ring().iter();
    let k: Vec<f64> = ring.map(|pixel| 2.0 + 0.01 * f64::from(pixel.y)).collect();
    bencher.bench_local(|| inflation.sheet(black_box(&k), &Cancel::new()));
}

#[divan::bench(args = [256, 512, 1024])]
fn one_stroke(bencher: Bencher<'_, '_>, size: u32) {
    let last = inflation(&disc(size, 0.0));
    let edited = disc(size, 0.03 * f64::from(size));
    bencher.bench_local(|| last.updated(&edited, Progress::silent(), &Cancel::new()));
}

#[divan::bench(args = [256, 512, 1024])]
fn poisson_on_a_disc(bencher: Bencher<'_, '_>, size: u32) {
    let mask = disc(size, 0.0);
    let right = mask.map(|&inside| f64::from(u8::from(inside)));
    bencher.bench_local(|| poisson(black_box(&mask), &right, &Cancel::new()));
}
