//! Measurements of foliage synthesis: `cargo bench --bench synth`. The textures are those of a cubemap
//! of 256 pixels (Argudo 2014: 40 to 45 minutes).

use boscage::base::{Cancel, Progress, Seed};
use boscage::branches::samples;
use boscage::raster::{Image, Mask, ReadLimits, Straight, read_image_from_memory};
use boscage::synth::{Exemplar, ExemplarSettings, SynthesisSettings, texture};
use divan::{Bencher, black_box};
use std::path::Path;

fn main() {
    divan::main();
}

/// Sizes of the textures of a cubemap.
const SIZES: [(u32, u32); 3] = [(1056, 320), (256, 256), (256, 256)];

/// The upper half of a built-in sample, which is all crown.
fn crown(name: &str) -> (Image<Straight>, Mask) {
    let sample = samples().iter().find(|sample| sample.name() == name);
    let bytes = sample.expect("a built-in sample").bundled();
    let picture = read_image_from_memory(bytes, Path::new(name), ReadLimits::default());
    let picture = picture.expect("a picture");
    let picture = picture.cropped(0, 0, picture.width(), picture.height() / 2);
    let mask = picture.map(|pixel| pixel.alpha() > 127);
    (picture, mask)
}

fn prepared((picture, mask): &(Image<Straight>, Mask)) -> Exemplar {
    Exemplar::new(picture, mask, &ExemplarSettings::default(), &Cancel::new()).expect("a crown")
}

#[divan::bench(args = ["oak", "spruce"])]
fn exemplar(bencher: Bencher<'_, '_>, name: &str) {
    let crown = crown(name);
    bencher.bench_local(|| prepared(black_box(&crown)));
}

#[divan::bench(args = ["oak", "spruce"])]
fn textures_of_a_cubemap(bencher: Bencher<'_, '_>, name: &str) {
    let exemplar = prepared(&crown(name));
    let settings = SynthesisSettings::default();
    bencher.bench_local(|| {
        for (number, (width, height)) in (0..).zip(SIZES) {
            let (silent, cancel) = (Progress::silent(), Cancel::new());
            let seed = Seed(number);
            let made = texture(&exemplar, width, height, &settings, seed, &silent, &cancel);
            black_box(made.expect("nobody cancels"));
        }
    });
}
