//! What random choice builds on: distortion foreseen from outlines against the measured one, on the
//! real trees of `BOSCAGE_DATA` (default `../shared/data`). Without the folder the tests say so and
//! pass.

use crate::reference;
use boscage::base::{Cancel, Progress, Seed};
use boscage::raster::{ReadLimits, read_image};
use boscage::segment::Classical;
use boscage::variation::{
    ChoiceError, ChoiceSettings, CompatibilityGraph, Distortion, Exemplar, ExemplarSettings,
    Forecast, Layout, Shape, are_of_a_kind, chosen, library_places,
};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The outlines of the real trees, prepared once, at half of the usual size: four times as many pixels
/// change no order.
fn trees(data: &Path) -> &'static [(String, Shape)] {
    static TREES: OnceLock<Vec<(String, Shape)>> = OnceLock::new();
    TREES.get_or_init(|| prepared(data))
}

fn prepared(data: &Path) -> Vec<(String, Shape)> {
    let folder = std::fs::read_dir(data.join("billboards")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let settings = ExemplarSettings {
        size: 512,
        ..ExemplarSettings::default()
    };
    let prepared = files.par_iter().map(|file| {
        let picture = read_image(file, ReadLimits::default()).unwrap();
        let (silent, cancel) = (Progress::silent(), Cancel::new());
        let exemplar = Exemplar::prepare(&picture, &settings, &Classical, silent, &cancel);
        let name = file.file_stem().unwrap().to_string_lossy().into_owned();
        (name, exemplar.unwrap().shape)
    });
    prepared.collect()
}

/// The rank of each value; equal ones share the mean of theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    for group in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let before = order.iter().position(|i| i == &group[0]).unwrap();
        for &index in group {
            ranks[index] = before as f64 + 0.5 * (group.len() - 1) as f64;
        }
    }
    ranks
}

/// Spearman's rank correlation.
fn agreement(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (ranks(a), ranks(b));
    let middle = 0.5 * (a.len() - 1) as f64;
    let product = |x: &[f64], y: &[f64]| -> f64 {
        let pairs = x.iter().zip(y);
        pairs.map(|(x, y)| (x - middle) * (y - middle)).sum()
    };
    product(&a, &b) / (product(&a, &a) * product(&b, &b)).sqrt()
}

#[test]
fn foreseen_distortion_ranks_pairs_as_measured_distortion_does() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let trees = trees(&data);
    let shapes: Vec<&Shape> = trees.iter().map(|tree| &tree.1).collect();
    let count = shapes.len();
    let pairs: Vec<(usize, usize)> = (0..count * count)
        .map(|i| (i / count, i % count))
        .filter(|(a, b)| a != b)
        .collect();
    let forecasts: Vec<Forecast> = shapes.iter().map(|s| Forecast::of(s).unwrap()).collect();
    let foreseen: Vec<Distortion> = pairs
        .iter()
        .map(|&(a, b)| forecasts[a].with(shapes[b]).own)
        .collect();
    let measured: Vec<Distortion> = pairs
        .par_iter()
        .map(|&(a, b)| {
            let layout = Layout::new(&[(shapes[a], 0.5, 1.0), (shapes[b], 0.5, 0.0)]);
            layout.unwrap().distortion
        })
        .collect();
    let of = |value: fn(&Distortion) -> f64| {
        let values = |all: &[Distortion]| all.iter().map(value).collect::<Vec<f64>>();
        agreement(&values(&measured), &values(&foreseen))
    };
    let (penalty, stretch) = (of(Distortion::penalty), of(|found| found.stretch));
    eprintln!(
        "{} pairs: rank correlation {penalty:.3} of the penalty, {stretch:.3} of the stretching",
        pairs.len()
    );
    assert!(penalty >= 0.8 && stretch >= 0.8);
}

#[test]
fn random_choice_mixes_only_trees_of_a_kind_and_no_map_folds() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let trees = trees(&data);
    let shapes: Vec<&Shape> = trees.iter().map(|tree| &tree.1).collect();
    let settings = ChoiceSettings::default();
    let found: Vec<_> = (0..30u64)
        .into_par_iter()
        .map(|index| chosen(&shapes, None, &settings, Seed(1).derive("tree", index)).unwrap())
        .collect();
    let mut stretch: Vec<f64> = Vec::new();
    for tree in &found {
        let [a, b] = [0, 1].map(|part| tree.parts[part].exemplar);
        assert!(
            are_of_a_kind(shapes[a], shapes[b]),
            "{} {}",
            trees[a].0,
            trees[b].0
        );
        let distortion = tree.layout.distortion;
        assert_eq!(distortion.folded, 0.0, "{} {}", trees[a].0, trees[b].0);
        stretch.push(distortion.stretch);
    }
    stretch.sort_by(f64::total_cmp);
    eprintln!(
        "stretching: median {:.2}, worst {:.2}",
        stretch[15], stretch[29]
    );
    assert!(stretch[29] <= 1.8);

    let named = |name: &str| {
        *shapes
            .iter()
            .zip(trees)
            .find(|(_, t)| t.0 == name)
            .unwrap()
            .0
    };
    let thin = named("bare_tree_sparse_02");
    for thick in ["broadleaf_dense_01", "spruce_dense_08", "olive_medium_01"] {
        let pair = [thin, named(thick)];
        // It stays by itself.
        let aimed = chosen(&pair, Some(0), &settings, Seed(1)).unwrap();
        assert!(aimed.parts.len() == 1, "{thick}");
        let poured = chosen(&pair, None, &settings, Seed(1));
        assert!(matches!(poured, Err(ChoiceError::NoMatch)), "{thick}");
    }
}

#[test]
fn alike_trees_are_neighbours_in_the_graph_and_on_the_map() {
    let Some(data) = reference::data("billboards") else {
        return;
    };
    let trees = trees(&data);
    let shapes: Vec<&Shape> = trees.iter().map(|tree| &tree.1).collect();
    let graph = CompatibilityGraph::of(&shapes);
    let places = library_places(&shapes);
    let at = |name: &str| trees.iter().position(|tree| tree.0 == name).unwrap();
    let (oak, same_oak) = (at("broadleaf_dense_01"), at("broadleaf_dense_04"));
    assert_eq!(graph.neighbours[oak][0].exemplar, same_oak);
    assert!(places[oak].distance(places[same_oak]) < 0.03);
    let apart = places[at("bare_tree_sparse_02")].distance(places[oak]);
    assert!(apart > 0.3, "{apart}");
    let edges = graph.edges();
    assert!(
        edges
            .windows(2)
            .all(|pair| (pair[0].0, pair[0].1) < (pair[1].0, pair[1].1))
    );
}
