//! Textures of foliage: like their exemplar, without visible repetition, the same for any number of
//! threads, around what is given, and quick to stop.
//!
//! The built-in samples serve where any crown will do. The comparison with a plain implementation of
//! Wei & Levoy 2000 is made on real crowns of `BOSCAGE_DATA` (default `../shared/data`); without the
//! folder it says so and passes.

use crate::reference;
use boscage::base::{Cancel, Progress, Random, Reporter, Seed, Update, with_threads};
use boscage::branches::samples::sample_named;
use boscage::raster::{Image, Mask, Straight};
use boscage::synth::{
    Exemplar, ExemplarSettings, SynthesisError, SynthesisSettings, Texture, patch_distance,
    repeated_share, texture, texture_around,
};
use rayon::prelude::*;
use std::path::Path;

type Picture = Image<Straight>;

/// A part of a built-in sample's crown, and its mask.
fn sample(name: &str) -> (Picture, Mask) {
    let whole = sample_named(name).unwrap().trimmed().unwrap();
    let picture = whole.cropped(whole.width() / 2 - 160, whole.height() / 4, 320, 256);
    let mask = picture.map(|pixel| pixel.alpha() > 127);
    (picture, mask)
}

fn exemplar(name: &str) -> Exemplar {
    let (picture, mask) = sample(name);
    Exemplar::new(
        &picture,
        &mask,
        &ExemplarSettings::default(),
        &Cancel::new(),
    )
    .unwrap()
}

fn made(exemplar: &Exemplar, known: &Image<Option<[u8; 3]>>, seed: u64) -> Texture {
    let settings = SynthesisSettings::default();
    let (silent, cancel) = (Progress::silent(), Cancel::new());
    texture_around(
        exemplar,
        known,
        &settings,
        Seed(seed),
        |_| {},
        &silent,
        &cancel,
    )
    .unwrap()
}

#[test]
fn every_pixel_is_one_of_the_foliage() {
    let settings = ExemplarSettings {
        flatten: 0.0,
        ..ExemplarSettings::default()
    };
    let (picture, mask) = sample("oak_02");
    let exemplar = Exemplar::new(&picture, &mask, &settings, &Cancel::new()).unwrap();
    let texture = made(&exemplar, &Image::filled(150, 90, None), 1);
    assert_eq!((texture.image.width(), texture.image.height()), (150, 90));
    for (pixel, source) in texture.image.pixels().iter().zip(texture.sources.pixels()) {
        let [x, y] = source.unwrap();
        assert!(exemplar.foliage().at(x, y) && mask.at(x, y));
        assert_eq!(pixel.0[..3], picture.at(x, y).0[..3]);
        assert_eq!(pixel.alpha(), 255);
    }
}

#[test]
fn threads_change_nothing_and_seeds_change_everything() {
    let make = |threads, seed| {
        with_threads(Some(threads), || {
            made(&exemplar("maple_01"), &Image::filled(133, 101, None), seed).image
        })
        .unwrap()
    };
    let one = make(1, 5);
    assert_eq!(one, make(3, 5));
    assert_ne!(one, make(3, 6));
}

#[test]
fn what_is_given_stays_and_the_rest_continues_it() {
    let (picture, mask) = sample("oak_02");
    let settings = ExemplarSettings {
        flatten: 0.0,
        ..ExemplarSettings::default()
    };
    let exemplar = Exemplar::new(&picture, &mask, &settings, &Cancel::new()).unwrap();
    let first = made(&exemplar, &Image::filled(160, 96, None), 1);
    let mut known = Image::filled(160, 96, None);
    for y in 0..96 {
        for x in (0..160).filter(|x| !(50..110).contains(x)) {
            let [r, g, b, _] = first.image.at(x, y).0;
            known.set(x, y, Some([r, g, b]));
        }
    }
    let second = made(&exemplar, &known, 2);
    for (at, known) in known.pixels().iter().enumerate() {
        let pixel = second.image.pixels()[at].0;
        assert!(known.is_none_or(|known| known == pixel[..3]));
        assert_eq!(known.is_none(), second.sources.pixels()[at].is_some());
    }
    // What grew out of the given pixels follows them better than another texture pasted there.
    let third = made(&exemplar, &Image::filled(160, 96, None), 3).image;
    let step = |at: (u32, &Picture), next: (u32, &Picture)| -> f64 {
        let rows = (0..96).map(|y| {
            let (a, b) = (at.1.at(at.0, y).0, next.1.at(next.0, y).0);
            a.iter()
                .zip(b)
                .map(|(&a, b)| f64::from(a.abs_diff(b)))
                .sum::<f64>()
        });
        rows.sum::<f64>() / 96.0
    };
    let image = &second.image;
    let grown = step((49, image), (50, image)) + step((109, image), (110, image));
    let pasted = step((49, image), (50, &third)) + step((109, &third), (110, image));
    eprintln!("steps beside given pixels: grown {grown:.1}, pasted {pasted:.1}");
    assert!(grown < 0.85 * pasted, "{grown} {pasted}");
}

#[test]
fn the_preview_comes_once_before_seams_are_corrected_and_looks_like_the_texture() {
    let exemplar = exemplar("oak_02");
    let known = Image::filled(200, 120, None);
    let refined = std::sync::atomic::AtomicBool::new(false);
    let noted = Noted(&refined);
    let progress = Progress::to(&noted);
    let mut previews = Vec::new();
    let settings = SynthesisSettings::default();
    let shown = |picture| {
        let late = refined.load(std::sync::atomic::Ordering::Relaxed);
        assert!(!late, "the preview came after the first correction");
        previews.push(picture);
    };
    let cancel = Cancel::new();
    let made = texture_around(
        &exemplar,
        &known,
        &settings,
        Seed(4),
        shown,
        &progress,
        &cancel,
    )
    .unwrap();
    assert!(refined.load(std::sync::atomic::Ordering::Relaxed));
    let [preview] = &previews[..] else {
        panic!("{} previews", previews.len())
    };
    assert_eq!((preview.width(), preview.height()), (200, 120));
    // The same pieces: their insides stay, seams do not.
    let pairs = preview.pixels().iter().zip(made.image.pixels());
    let same = pairs.filter(|(a, b)| a == b).count();
    assert!(same > 200 * 120 / 4 && same < 200 * 120, "{same}");
}

/// Notes that the correction has begun.
struct Noted<'a>(&'a std::sync::atomic::AtomicBool);

impl Reporter for Noted<'_> {
    fn report(&self, update: Update<'_>) {
        if matches!(
            update,
            Update::Advanced {
                stage: "refine",
                ..
            }
        ) {
            self.0.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    }
}

#[test]
fn a_tiling_texture_continues_across_its_edge() {
    let exemplar = exemplar("oak_02");
    let settings = SynthesisSettings {
        tiles_x: true,
        ..SynthesisSettings::default()
    };
    let (silent, cancel) = (Progress::silent(), Cancel::new());
    let image = texture(&exemplar, 160, 80, &settings, Seed(1), &silent, &cancel).unwrap();
    let step = |left: u32, right: u32| -> f64 {
        let rows = (0..80).map(|y| {
            let (a, b) = (image.at(left, y).0, image.at(right, y).0);
            a.iter()
                .zip(b)
                .map(|(&a, b)| f64::from(a.abs_diff(b)))
                .sum::<f64>()
        });
        rows.sum::<f64>() / 80.0
    };
    let inside = (1..160).map(|x| step(x - 1, x)).sum::<f64>() / 159.0;
    assert!(step(159, 0) < 1.3 * inside, "{} {inside}", step(159, 0));
}

#[test]
fn odd_sizes_and_thin_crowns_work_and_too_small_ones_are_refused() {
    let exemplar = exemplar("birch_01");
    for (width, height) in [(1, 1), (3, 40), (65, 7), (17, 33)] {
        let texture = made(&exemplar, &Image::filled(width, height, None), 1);
        assert_eq!(
            (texture.image.width(), texture.image.height()),
            (width, height)
        );
    }
    let (picture, _) = sample("birch_01");
    let thin = |width: u32| {
        let mut mask = Image::filled(picture.width(), picture.height(), false);
        for y in 0..picture.height() {
            for x in (0..width).map(|x| picture.width() / 2 + x) {
                mask.set(x, y, true);
            }
        }
        let opaque = picture.map(|pixel| Straight([pixel.0[0], pixel.0[1], pixel.0[2], 255]));
        let settings = ExemplarSettings::default();
        Exemplar::new(&opaque, &mask, &settings, &Cancel::new())
    };
    let texture = made(&thin(5).unwrap(), &Image::filled(60, 60, None), 1);
    assert_eq!(texture.image.width(), 60);
    assert!(matches!(
        thin(2),
        Err(SynthesisError::TooLittleFoliage { .. })
    ));
}

/// Raises the flag when a stage begins.
struct StopAt<'a>(&'a str, &'a Cancel);

impl Reporter for StopAt<'_> {
    fn report(&self, update: Update<'_>) {
        if matches!(update, Update::Advanced { stage, .. } if stage == self.0) {
            self.1.cancel();
        }
    }
}

#[test]
fn a_cancelled_texture_is_none() {
    let exemplar = exemplar("oak_02");
    for stage in ["patches", "refine"] {
        let cancel = Cancel::new();
        let reporter = StopAt(stage, &cancel);
        let progress = Progress::to(&reporter);
        let settings = SynthesisSettings::default();
        let outcome = texture(&exemplar, 200, 200, &settings, Seed(1), &progress, &cancel);
        assert!(
            matches!(outcome, Err(SynthesisError::Cancelled(_))),
            "{stage}"
        );
    }
}

// What follows is the comparison with Wei & Levoy on real crowns.

/// A square of `side` pixels from the middle of a real crown; all of it is foliage.
fn real_foliage(data: &Path, name: &str, side: u32) -> Picture {
    let (photo, inside) = reference::photo_and_mask(data, name);
    let corners = (0..photo.height() - side).step_by(8).flat_map(|y| {
        let columns = (0..photo.width() - side).step_by(8);
        columns.map(move |x| (x, y))
    });
    let fullest = corners.max_by_key(|&(x, y)| inside.cropped(x, y, side, side).count());
    let (x, y) = fullest.unwrap();
    photo.cropped(x, y, side, side)
}

/// Side of the exemplars and of the textures that are compared.
const EXEMPLAR: u32 = 112;
const TEXTURE: u32 = 96;

/// Textures of ours that are compared with the mean of two of theirs: one of this size is a sample
/// of some ten pieces, and may be unlucky.
const SEEDS: u64 = 4;

#[test]
fn textures_are_as_like_their_exemplar_as_those_of_wei_and_levoy() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let names = reference::some(&[
        "white_oak_dense_01",
        "catalpa_01",
        "juniper_shrub_dense_01",
        "boxelder_dense_01",
    ]);
    let figures: Vec<(f64, f64)> = names
        .par_iter()
        .map(|name| {
            let foliage = real_foliage(&data, name, EXEMPLAR);
            let settings = ExemplarSettings {
                erosion: 0,
                without_sky: false,
                without_unique: false,
                flatten: 0.0,
                levels: 3,
            };
            let all = Image::filled(EXEMPLAR, EXEMPLAR, true);
            let exemplar = Exemplar::new(&foliage, &all, &settings, &Cancel::new()).unwrap();
            let settings = SynthesisSettings::default();
            let distances = (0..SEEDS).map(|seed| {
                let (silent, cancel) = (Progress::silent(), Cancel::new());
                let ours = texture(
                    &exemplar,
                    TEXTURE,
                    TEXTURE,
                    &settings,
                    Seed(seed),
                    &silent,
                    &cancel,
                );
                patch_distance((&ours.unwrap(), None), (&foliage, None))
            });
            let ours = distances.sum::<f64>() / SEEDS as f64;
            let theirs = (1..=2).map(|seed| {
                let theirs = wei_levoy::texture(&foliage, TEXTURE, Seed(seed));
                patch_distance((&theirs, None), (&foliage, None))
            });
            (ours, theirs.sum::<f64>() / 2.0)
        })
        .collect();
    for (name, (ours, theirs)) in names.iter().zip(&figures) {
        eprintln!("{name}: distance {ours:.2}, Wei & Levoy {theirs:.2}");
    }
    for (name, (ours, theirs)) in names.iter().zip(&figures) {
        assert!(ours <= theirs, "{name}: {ours} {theirs}");
    }
    let sums = figures
        .iter()
        .fold((0.0, 0.0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
    assert!(sums.0 < 0.7 * sums.1, "{figures:?}");
}

#[test]
fn little_of_a_texture_occurs_twice() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let names = [
        "white_oak_dense_01",
        "catalpa_01",
        "osage_orange_autumn_dense_01",
    ];
    names.par_iter().for_each(|name| {
        let foliage = real_foliage(&data, name, 256);
        let all = Image::filled(256, 256, true);
        let settings = ExemplarSettings::default();
        let exemplar = Exemplar::new(&foliage, &all, &settings, &Cancel::new()).unwrap();
        let texture = made(&exemplar, &Image::filled(512, 256, None), 1);
        let share = repeated_share(&texture, 32);
        eprintln!("{name}: {:.1} % repeated", 100.0 * share);
        assert!(share < 0.15, "{name}: {share}");
    });
}

/// The plain method of the thesis, for comparison: L.-Y. Wei & M. Levoy, *Fast Texture Synthesis using
/// Tree-structured Vector Quantization*, 2000, with an exhaustive search instead of the tree. Three
/// levels, the causal half of 7×7 pixels and 3×3 of the next coarser level; outputs wrap around,
/// windows of the exemplar do not.
mod wei_levoy {
    use super::*;

    const LEVELS: usize = 3;
    /// 24 pixels of the level and 9 of the coarser one, three channels.
    const NUMBERS: usize = (24 + 9) * 3;

    type Rgb = Image<[f32; 3]>;

    pub(super) fn texture(exemplar: &Picture, side: u32, seed: Seed) -> Picture {
        let finest = exemplar.map(|pixel| [0, 1, 2].map(|c| f32::from(pixel.0[c])));
        let mut pyramid = vec![finest];
        for level in 1..LEVELS {
            pyramid.push(halved(&pyramid[level - 1]));
        }
        let mut random = seed.random();
        let mut coarser: Option<Rgb> = None;
        for level in (0..LEVELS).rev() {
            let source = &pyramid[level];
            let coarse = coarser.as_ref().map(|made| (made, &pyramid[level + 1]));
            coarser = Some(level_made(source, coarse, side >> level, &mut random));
        }
        coarser.unwrap().map(|&color| {
            let [r, g, b] = color.map(|value| value as u8);
            Straight([r, g, b, 255])
        })
    }

    fn level_made(
        source: &Rgb,
        coarse: Option<(&Rgb, &Rgb)>,
        side: u32,
        random: &mut Random,
    ) -> Rgb {
        let (width, height) = (source.width(), source.height());
        let places: Vec<(u32, u32)> = (3..height - 4)
            .flat_map(|y| (3..width - 4).map(move |x| (x, y)))
            .collect();
        let windows = places
            .iter()
            .map(|&(x, y)| window(source, coarse.map(|(_, theirs)| theirs), x, y));
        let windows = Windows::new(windows.collect());
        let mut made = Image::filled(side, side, [0.0; 3]);
        for pixel in made.pixels_mut() {
            let (x, y) = places[random.below(places.len())];
            *pixel = source.at(x, y);
        }
        for y in 0..side {
            for x in 0..side {
                let wanted = window(&made, coarse.map(|(ours, _)| ours), x, y);
                let (x0, y0) = places[windows.nearest(&wanted)];
                made.set(x, y, source.at(x0, y0));
            }
        }
        made
    }

    /// All windows, sorted by their means.
    struct Windows {
        /// The sum over a window by the root of its length, and which window.
        order: Vec<(f32, usize)>,
        windows: Vec<[f32; NUMBERS]>,
    }

    impl Windows {
        fn new(windows: Vec<[f32; NUMBERS]>) -> Self {
            let mut order: Vec<(f32, usize)> =
                (0..).zip(&windows).map(|(i, w)| (level(w), i)).collect();
            order.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
            Self { order, windows }
        }

        /// The window nearest to `wanted`: an exhaustive search, in the order of the difference of the
        /// means, which no distance is below; it ends where that exceeds the least.
        fn nearest(&self, wanted: &[f32; NUMBERS]) -> usize {
            let middle = level(wanted);
            let mut above = self.order.partition_point(|(mean, _)| *mean < middle);
            let mut below = above;
            let (mut best, mut least) = (0, f32::INFINITY);
            loop {
                let gap = |at: Option<&(f32, usize)>| {
                    at.map_or(f32::INFINITY, |(mean, _)| (mean - middle).abs())
                };
                let up = gap(self.order.get(above));
                let down = gap(below.checked_sub(1).map(|at| &self.order[at]));
                let gap = up.min(down);
                if gap == f32::INFINITY || gap * gap * 0.999 > least {
                    return best;
                }
                let index = if up <= down {
                    above += 1;
                    self.order[above - 1].1
                } else {
                    below -= 1;
                    self.order[below].1
                };
                let distance = distance(&self.windows[index], wanted, least);
                if distance < least {
                    (best, least) = (index, distance);
                }
            }
        }
    }

    /// The length of a window along the diagonal: differences of it never exceed distances.
    fn level(window: &[f32; NUMBERS]) -> f32 {
        window.iter().sum::<f32>() / (NUMBERS as f32).sqrt()
    }

    /// The squared distance, or something not less than `limit`.
    fn distance(window: &[f32; NUMBERS], wanted: &[f32; NUMBERS], limit: f32) -> f32 {
        let mut sum = 0.0;
        for (here, there) in wanted.chunks_exact(9).zip(window.chunks_exact(9)) {
            let squares = here.iter().zip(there).map(|(a, b)| (a - b) * (a - b));
            sum += squares.sum::<f32>();
            if sum >= limit {
                break;
            }
        }
        sum
    }

    fn window(level: &Rgb, coarser: Option<&Rgb>, x: u32, y: u32) -> [f32; NUMBERS] {
        let at = |image: &Rgb, x: i64, y: i64| {
            let (width, height) = (i64::from(image.width()), i64::from(image.height()));
            image.at(x.rem_euclid(width) as u32, y.rem_euclid(height) as u32)
        };
        let (x, y) = (i64::from(x), i64::from(y));
        let causal = (0..24).map(|i| at(level, x + i % 7 - 3, y + i / 7 - 3));
        let around =
            (0..9).filter_map(|i| Some(at(coarser?, x / 2 + i % 3 - 1, y / 2 + i / 3 - 1)));
        let mut numbers = [0.0; NUMBERS];
        for (place, value) in numbers.iter_mut().zip(causal.chain(around).flatten()) {
            *place = value;
        }
        numbers
    }

    fn halved(image: &Rgb) -> Rgb {
        const TAPS: [f32; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];
        let (width, height) = (image.width() / 2, image.height() / 2);
        let at = |x: i64, y: i64| {
            let clamped = |i: i64, count: u32| i.clamp(0, i64::from(count) - 1) as u32;
            image.at(clamped(x, image.width()), clamped(y, image.height()))
        };
        let pixel = |x: i64, y: i64| {
            let mut sum = [0.0f32; 3];
            for (dy, down) in (-2..).zip(TAPS) {
                for (dx, across) in (-2..).zip(TAPS) {
                    let color = at(2 * x + dx, 2 * y + dy);
                    sum = [0, 1, 2].map(|c| sum[c] + down * across * color[c]);
                }
            }
            sum
        };
        let pixels = (0..i64::from(width * height))
            .map(|i| pixel(i % i64::from(width), i / i64::from(width)));
        Image::from_pixels(width, height, pixels.collect())
    }
}
