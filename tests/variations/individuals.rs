//! Individuals of real conifers are conifers, those of palms have whole fronds, those of bare trees whole limbs, and
//! none repeats another.
//!
//! The pictures are those of `BOSCAGE_DATA` (default `../shared/data`); without them the tests say so and
//! pass.

use crate::reference;
use boscage::base::{Cancel, Progress, Seed};
use boscage::raster::labelled_components;
use boscage::segment::{Classical, Label};
use boscage::variation::{
    ChoiceSettings, ExemplarSettings, Finish, IndividualSettings, Library, LibraryPicture, Look,
    Repetition, Shape, Tree, TreeMaker, chosen,
};
use rayon::prelude::*;
use std::path::Path;

/// Firs and spruces: broad, slender, in tiers, under snow.
const CONIFERS: [&str; 5] = [
    "fir_dense_01",
    "spruce_dense_08",
    "spruce_medium_06",
    "spruce_painted_medium_12",
    "spruce_snow_medium_04",
];

/// Others that go with them, and others that do not.
const MORE_CONIFERS: [&str; 5] = [
    "fir_dense_03",
    "spruce_dense_03",
    "spruce_medium_07",
    "spruce_painted_medium_15",
    "spruce_snow_medium_03",
];
const OTHERS: [&str; 3] = [
    "broadleaf_dense_01",
    "broadleaf_dense_02",
    "willow_green_medium_01",
];

const PALMS: [&str; 3] = [
    "palm_medium_01",
    "palm_short_dense_02",
    "twin_palm_sparse_04",
];

const BARE: [&str; 4] = [
    "bare_broadleaf_snow_sparse_02",
    "bare_conifer_snow_sparse_02",
    "bare_conifer_sparse_01",
    "bare_tree_sparse_02",
];

fn library(data: &Path, others: &[&str]) -> Library<'static> {
    let names = CONIFERS.iter().chain(&MORE_CONIFERS).chain(others);
    let picture = |name: &&str| LibraryPicture {
        path: data.join("billboards").join(format!("{name}.png")),
        bytes: None,
        pins: None,
    };
    let pictures: Vec<LibraryPicture> = names.map(picture).collect();
    let settings = ExemplarSettings {
        size: 384,
        ..ExemplarSettings::default()
    };
    let (silent, cancel) = (Progress::silent(), Cancel::new());
    let made = Library::of(&pictures, settings, &Classical, None, None, silent, &cancel);
    made.unwrap().0
}

fn index(library: &Library<'_>, name: &str) -> usize {
    let file = format!("{name}.png");
    let mut entries = library.entries().iter();
    entries.position(|entry| entry.file_name() == file).unwrap()
}

/// The exemplar itself.
fn plain(library: &Library<'_>, name: &str) -> Tree {
    let own = library.exemplar(index(library, name), &Cancel::new());
    let own = own.unwrap();
    Tree {
        image: own.image.straight(),
        labels: own.labels.clone(),
    }
}

/// As `boscage vary --target` makes them.
fn individuals(library: &Library<'_>, name: &str, strength: f64, count: u64) -> Vec<Tree> {
    let entries = library.entries().iter();
    let shapes: Vec<&Shape> = entries.map(|entry| entry.shape.as_ref()).collect();
    let maker = TreeMaker::new(library, None);
    let settings = ChoiceSettings {
        strength,
        ..ChoiceSettings::default()
    };
    let target = Some(index(library, name));
    let made = (0..count).into_par_iter().map(|number| {
        let (seed, cancel) = (Seed(0).derive("tree", number), Cancel::new());
        let chosen = chosen(&shapes, target, &settings, seed).unwrap();
        let mut tree = maker.make(&chosen, &cancel).unwrap();
        let finish = Finish {
            individual: IndividualSettings::drawn(strength, seed),
            ..Finish::default()
        };
        let finish = finish.of_tree(&chosen, library);
        finish.put(&mut tree, None, seed, &cancel).unwrap();
        tree
    });
    made.collect()
}

/// How a crown narrows to its tip; lengths as shares of its largest width.
#[derive(Debug)]
struct Spire {
    /// Mean width of its upper tenth and of its upper quarter.
    tenth: f64,
    quarter: f64,
    /// All widening on the way up from a third of its height.
    widening: f64,
    /// How far its tip stands beside the middle of its lower half.
    lean: f64,
    /// How much more lies on one side of the line between those, as a share of all.
    imbalance: f64,
    /// Height by width.
    aspect: f64,
}

impl Spire {
    fn of(tree: &Tree) -> Self {
        let is_crown = |x: u32, y: u32| {
            tree.labels.at(x, y) == Label::Crown && tree.image.at(x, y).alpha() >= 128
        };
        let row = |y: u32| -> Vec<f64> {
            let all = 0..tree.labels.width();
            all.filter(|&x| is_crown(x, y)).map(f64::from).collect()
        };
        let rows: Vec<Vec<f64>> = (0..tree.labels.height()).map(row).collect();
        let rows: Vec<Vec<f64>> = rows.into_iter().skip_while(Vec::is_empty).collect();
        let last = rows.iter().rposition(|row| !row.is_empty()).unwrap();
        let rows = &rows[..=last];
        let count = rows.len();
        let width = |row: &Vec<f64>| match (row.first(), row.last()) {
            (Some(left), Some(right)) => right - left + 1.0,
            _ => 0.0,
        };
        let widths: Vec<f64> = rows.iter().map(width).collect();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        // Tiers are no widening.
        let reach = count / 12;
        let smooth =
            |at: usize| mean(&widths[at.saturating_sub(reach)..(at + reach + 1).min(count)]);
        let smooth: Vec<f64> = (0..count).map(smooth).collect();
        let widest = smooth.iter().copied().fold(1.0, f64::max);
        let upwards = smooth[..2 * count / 3].windows(2);
        let widening: f64 = upwards.map(|pair| (pair[0] - pair[1]).max(0.0)).sum();
        let middle = |rows: &[Vec<f64>]| mean(&rows.concat());
        let (tip, foot) = (middle(&rows[..count / 25 + 1]), middle(&rows[count / 2..]));
        let axis = |y: usize| tip + (foot - tip) * (y as f64 / (0.75 * count as f64)).min(1.0);
        let sides = rows.iter().enumerate().flat_map(|(y, row)| {
            let axis = axis(y);
            row.iter().map(move |x| if *x > axis { 1.0 } else { -1.0 })
        });
        let sides: Vec<f64> = sides.collect();
        Self {
            tenth: mean(&widths[..count / 10]) / widest,
            quarter: mean(&widths[..count / 4]) / widest,
            widening: widening / widest,
            lean: (tip - foot).abs() / widest,
            imbalance: mean(&sides).abs(),
            aspect: count as f64 / widest,
        }
    }
}

#[test]
fn a_spruce_stays_a_spire() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let library = library(&data, &[]);
    let mut wrong = Vec::new();
    for name in CONIFERS {
        let own = Spire::of(&plain(&library, name));
        // Boughs that are kept whole stand out here and there.
        for (strength, lumps, slenderness) in [(0.7, 0.15, 0.58..1.65), (1.0, 0.2, 0.5..1.9)] {
            for (seed, tree) in individuals(&library, name, strength, 6).iter().enumerate() {
                let new = Spire::of(tree);
                let slender = new.aspect / own.aspect;
                let rules = [
                    ("blunt", new.tenth < own.tenth + 0.12),
                    ("blunt", new.quarter < own.quarter + 0.15),
                    ("lumps", new.widening < own.widening + lumps),
                    ("crooked", new.lean < own.lean + 0.1),
                    ("lopsided", new.imbalance < own.imbalance + 0.15),
                    ("of other proportions", slenderness.contains(&slender)),
                ];
                let told = |rule: &(&str, bool)| {
                    format!(
                        "{name} {strength} {seed} is {}: {new:.2?}, itself {own:.2?}",
                        rule.0
                    )
                };
                wrong.extend(rules.iter().filter(|rule| !rule.1).map(told));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Share of a tree's pixels that do not hang together with the rest.
fn loose(tree: &Tree) -> f64 {
    let parts = labelled_components(&tree.image.map(|pixel| pixel.alpha() >= 48));
    let last = parts.pixels().iter().copied().max().unwrap();
    let mut areas = vec![0u32; last as usize + 1];
    for &part in parts.pixels() {
        areas[part as usize] += 1;
    }
    let (all, largest) = (areas[1..].iter().sum::<u32>(), areas[1..].iter().max());
    1.0 - f64::from(*largest.unwrap()) / f64::from(all)
}

/// Columns in which a stem ends with sky right above it, below a crown that goes on there.
fn stems_cut(tree: &Tree) -> usize {
    let (width, height) = (tree.image.width(), tree.image.height());
    let shows = |x: u32, y: u32| tree.image.at(x, y).alpha() >= 96;
    let is_cut = |x: &u32| {
        let stem = (0..height).find(|&y| tree.labels.at(*x, y) == Label::Trunk && shows(*x, y));
        let Some(top) = stem.filter(|&top| top > 0) else {
            return false;
        };
        // A hand's breadth of sky between both.
        let gap = (0..top).rev().take_while(|&y| !shows(*x, y)).count() as u32;
        gap >= height / 60 && gap < top && gap < height / 12
    };
    (0..width).filter(is_cut).count()
}

#[test]
fn a_palm_keeps_its_fronds() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let library = library(&data, &PALMS);
    for name in PALMS {
        let own = loose(&plain(&library, name));
        for (seed, tree) in individuals(&library, name, 0.7, 6).iter().enumerate() {
            let new = loose(tree);
            assert!(new < own + 0.03, "{name} {seed}: {new:.3}, itself {own:.3}");
            let cut = stems_cut(tree);
            // A slanting stem has sky above its side, and fronds above that.
            assert!(cut < 16, "{name} {seed}: {cut}");
        }
    }
}

#[test]
fn a_bare_tree_keeps_its_limbs_whole() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let library = library(&data, &BARE);
    let seen = |tree: &Tree| tree.image.map(|pixel| pixel.alpha() >= 96).count() as f64;
    for name in BARE {
        let own = plain(&library, name);
        for (seed, tree) in individuals(&library, name, 0.7, 6).iter().enumerate() {
            let (own_loose, new) = (loose(&own), loose(tree));
            assert!(
                new < own_loose + 0.05,
                "{name} {seed}: {new:.3}, itself {own_loose:.3}"
            );
            let share = seen(tree) / seen(&own);
            assert!((0.55..1.65).contains(&share), "{name} {seed}: {share:.2}");
        }
    }
}

/// Copies of other scale and colour have a score of 1: at most half of it.
const MOST_REPEATED: f64 = 0.5;

#[test]
fn no_individual_is_a_double() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let others: Vec<&str> = OTHERS.into_iter().chain(BARE).collect();
    let library = library(&data, &others);
    for name in [
        "fir_dense_01",
        "spruce_dense_08",
        "spruce_medium_06",
        "spruce_snow_medium_04",
        "bare_conifer_sparse_01",
        "bare_broadleaf_snow_sparse_02",
        "broadleaf_dense_02",
        "willow_green_medium_01",
    ] {
        let cancel = Cancel::new();
        let trees = individuals(&library, name, 0.7, 8);
        let looks = trees.par_iter().map(|tree| {
            let look = Look::of(&tree.image.premultiplied(), &cancel);
            look.unwrap().unwrap()
        });
        let looks: Vec<Look> = looks.collect();
        let repetition = Repetition::among(&looks, Progress::silent(), &cancel).unwrap();
        assert!(
            repetition.score <= MOST_REPEATED,
            "{name}: {:.2}",
            repetition.score
        );
    }
}
