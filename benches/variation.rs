//! Measurements of the variation pipeline: `cargo bench`. The same work as `boscage bench`, with
//! divan's statistics.

use boscage::base::{Cancel, Progress};
use boscage::branches::samples::sample_named;
use boscage::raster::{Compression, Straight, encode_png};
use boscage::segment::Classical;
use boscage::variation::{Exemplar, ExemplarSettings, Layout, Source, WarpPrecision, synthesized};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

type Picture = boscage::raster::Image<Straight>;

/// The picture of one of the built-in samples.
fn picture(name: &str) -> Picture {
    let sample = sample_named(name).expect("a built-in sample");
    sample.trimmed().expect("a picture")
}

fn prepared(picture: &Picture, size: u32) -> Exemplar {
    let settings = ExemplarSettings {
        size,
        ..ExemplarSettings::default()
    };
    let cancel = Cancel::new();
    Exemplar::prepare(picture, &settings, &Classical, Progress::silent(), &cancel)
        .expect("a sample can be prepared")
}

fn pair(size: u32) -> [Exemplar; 2] {
    ["oak_02", "maple_01"].map(|name| prepared(&picture(name), size))
}

fn layout(pair: &[Exemplar; 2]) -> Layout {
    let shapes = [0, 1].map(|i| (&pair[i].shape, 0.5, 0.5));
    Layout::new(&shapes).expect("a cage with an area")
}

#[divan::bench(args = [512, 1024])]
fn synthesis(bencher: Bencher<'_, '_>, size: u32) {
    let pair = pair(size);
    let layout = layout(&pair);
    let sources = [0, 1].map(|i| Source {
        exemplar: &pair[i],
        contour_weight: 0.5,
        color_weight: 0.5,
    });
    bencher.bench_local(|| {
        synthesized(
            &layout,
            &sources,
            WarpPrecision::Interpolated,
            &Cancel::new(),
        )
    });
}

#[divan::bench]
fn layout_and_distortion(bencher: Bencher<'_, '_>) {
    let pair = pair(1024);
    bencher.bench_local(|| layout(black_box(&pair)));
}

#[divan::bench(args = ["oak", "spruce", "birch"])]
fn preparation(bencher: Bencher<'_, '_>, name: &str) {
    let picture = picture(name);
    bencher.bench_local(|| prepared(black_box(&picture), 1024));
}

#[divan::bench]
fn png_encoding(bencher: Bencher<'_, '_>) {
    let picture = picture("oak");
    bencher.bench_local(|| encode_png(black_box(&picture), Compression::Fast));
}
