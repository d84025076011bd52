//! Our minimum cut beside PyMaxflow's and SciPy's on two pictures of foliage.
//!
//! The files lie in the folder that `BOSCAGE_ORACLE` names, by default `oracle` beside
//! `BOSCAGE_DATA`; without them the test says so and passes.

use crate::reference;
use boscage::base::Cancel;
use boscage::raster::{Image, ReadLimits, Straight, read_image};
use boscage::synth::{Side, StepCost, seam};
use std::path::Path;

fn picture(path: &Path) -> Image<Straight> {
    read_image(path, ReadLimits::default()).unwrap()
}

/// What the steps between pixels of different labels cost.
fn cost(a: &Image<Straight>, b: &Image<Straight>, second: impl Fn(u32, u32) -> bool) -> i64 {
    let difference = |x, y| {
        let channels = a.at(x, y).0.into_iter().zip(b.at(x, y).0).take(3);
        channels.map(|(a, b)| i64::from(a.abs_diff(b))).sum::<i64>()
    };
    let mut sum = 0;
    for y in 0..a.height() {
        for x in 0..a.width() {
            for (x1, y1) in [(x + 1, y), (x, y + 1)] {
                if x1 < a.width() && y1 < a.height() && second(x, y) != second(x1, y1) {
                    sum += difference(x, y) + difference(x1, y1);
                }
            }
        }
    }
    sum
}

#[test]
fn the_cheapest_seam_costs_what_two_other_solvers_found() {
    let Some(oracle) = reference::oracle() else {
        return;
    };
    let (a, b) = (
        picture(&oracle.join("in/overlap_a.png")),
        picture(&oracle.join("in/overlap_b.png")),
    );
    let reference: serde_json::Value =
        serde_json::from_slice(&std::fs::read(oracle.join("graphcut.json")).unwrap()).unwrap();
    let last = a.width() - 1;
    let side = |x, _| match x {
        0 => Side::First,
        x if x == last => Side::Second,
        _ => Side::Either,
    };
    let ours = seam(&a, &b, side, StepCost::Difference, &Cancel::new()).unwrap();
    assert_eq!(ours.cost as f64, reference["flow"].as_f64().unwrap());
    assert_eq!(cost(&a, &b, |x, y| ours.from_second.at(x, y)), ours.cost);

    // Theirs is one cheapest seam; ours leaves the fewest pixels to the first picture.
    let theirs = picture(&oracle.join("graphcut_labels.png")).map(|pixel| pixel.0[0] > 0);
    assert_eq!(cost(&a, &b, |x, y| theirs.at(x, y)), ours.cost);
    assert!(ours.from_second.count() >= theirs.count());
}
