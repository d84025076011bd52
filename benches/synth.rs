//! Measurements of foliage synthesis: `cargo bench --bench synth`. The textures are those of a cubemap
//! of 256 pixels (Argudo 2014: 40 to 45 minutes).

use boscage::base::{Cancel, Progress, Seed};
use boscage::branches::samples::sample_named;
use boscage::raster::{Image, Mask, Straight};
use boscage::synth::{Exemplar, ExemplarSettings, SynthesisSettings, texture};
use divan::{Bencher, black_box};

fn main() {
    divan::main();
}

/// Sizes of the textures of a cubemap.
const SIZES: [(u32, u32); 3] = [(1056, 320), (256, 256), (256, 256)];

/// The upper half of a built-in sample, which is all crown.
fn crown(name: &str) -> (Image<Straight>, Mask) {
    let sample = sample_named(name).expect("a built-in sample");
    let picture = sample.trimmed().expect("a picture");
    let picture = picture.cropped(0, 0, picture.width(), picture.height() / 2);
    let mask = picture.map(|pixel| pixel.alpha() > 127);
    (picture, mask)
}

fn prepared((picture, mask): &(Image<Straight>, Mask)) -> Exemplar {
    Exemplar::new(picture, mask, &ExemplarSettings::default(), &Cancel::new()).expect("a crown")
}

#[divan::bench(args = ["oak_02", "spruce_01"])]
fn exemplar(bencher: Bencher<'_, '_>, name: &str) {
    let crown = crown(name);
    bencher.bench_local(|| prepared(black_box(&crown)));
}

#[divan::bench(args = ["oak_02", "spruce_01"])]
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
