//! Our results beside those of public tools: OpenCV's contours, mean value coordinates to 50 digits,
//! warped positions in NumPy, scikit-image's histogram matching.
//!
//! The files lie in the folder that `BOSCAGE_ORACLE` names, by default `oracle` beside
//! `BOSCAGE_DATA`; without them these tests say so and pass.

use crate::reference;
use boscage::contour::{Outlines, outlines};
use boscage::geometry::{Point, Polygon};
use boscage::raster::{Image, Mask, ReadLimits, Straight, read_image};
use boscage::variation::{
    Cage, Histogram, Transfer, Warp, coordinates, inside_polygons, mapped_exactly,
};
use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Read as _;
use std::path::Path;

fn json(path: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap()
}

fn picture(path: &Path) -> Image<Straight> {
    read_image(path, ReadLimits::default()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().unwrap().iter();
    list.map(|number| number.as_f64().unwrap()).collect()
}

fn point(value: &Value) -> Point {
    let xy = numbers(value);
    Point::new(xy[0], xy[1])
}

fn polygon(value: &Value) -> Polygon {
    value.as_array().unwrap().iter().map(point).collect()
}

/// A border as others can name it too: hole or not, and its points in the order of their
/// coordinates, those that are passed twice listed twice.
type Border = (bool, Vec<(i64, i64)>);

fn border(is_hole: bool, points: &[Point]) -> Border {
    let mut points: Vec<_> = points.iter().map(|p| (p.x as i64, p.y as i64)).collect();
    points.sort_unstable();
    (is_hole, points)
}

/// Each border with the one around it.
type Tree = BTreeMap<Border, Option<Border>>;

fn our_tree(found: &Outlines) -> Tree {
    let name = |index: usize| border(found.all[index].is_hole, &found.all[index].points);
    (0..found.all.len())
        .map(|index| (name(index), found.all[index].parent.map(name)))
        .collect()
}

/// The tree of OpenCV: rows of the hierarchy are next, previous, first child, parent; every second
/// level is a hole.
fn their_tree(tree: &Value) -> Tree {
    let contours: Vec<Polygon> = tree["contours"]
        .as_array()
        .unwrap()
        .iter()
        .map(polygon)
        .collect();
    let parent = |index: usize| usize::try_from(tree["hierarchy"][index][3].as_i64().unwrap()).ok();
    let depth = |index| std::iter::successors(parent(index), |&above| parent(above)).count();
    let name = |index: usize| border(depth(index) % 2 == 1, &contours[index]);
    (0..contours.len())
        .map(|index| (name(index), parent(index).map(name)))
        .collect()
}

/// Whether `ours` is `theirs` begun elsewhere, perhaps walked the other way round.
fn same_walk(ours: &[Point], theirs: &[Point]) -> bool {
    let count = theirs.len();
    let mut backwards = theirs.to_vec();
    backwards.reverse();
    ours.len() == count
        && [theirs, &backwards].iter().any(|walk| {
            (0..count).any(|shift| (0..count).all(|i| ours[i] == walk[(i + shift) % count]))
        })
}

fn check_contours(name: &str, mask: &Mask, reference: &Value) {
    let found = outlines(mask);
    let theirs = reference["tree"]["contours"].as_array().unwrap().len();
    assert_eq!(found.all.len(), theirs, "{name}: borders");
    let external = reference["external"]["contours"].as_array().unwrap();
    assert_eq!(found.exterior().count(), external.len(), "{name}: exterior");
    assert!(
        our_tree(&found) == their_tree(&reference["tree"]),
        "{name}: points or parents differ"
    );
    let longest = found.longest_exterior().unwrap();
    let most = external.iter().map(polygon).map(|c| c.len()).max().unwrap();
    let candidates = external.iter().map(polygon).filter(|c| c.len() == most);
    let same = candidates
        .into_iter()
        .any(|walk| same_walk(&longest, &walk));
    assert!(same, "{name}: the longest exterior border differs");
}

#[test]
fn contours_are_those_of_opencv() {
    let Some(folder) = reference::oracle() else {
        return;
    };
    let cases = json(&folder.join("contour_cases.json"));
    for (name, case) in cases.as_object().unwrap() {
        let rows: Vec<Vec<f64>> = case["mask"]
            .as_array()
            .unwrap()
            .iter()
            .map(numbers)
            .collect();
        let pixels = rows.iter().flatten().map(|&value| value != 0.0).collect();
        let mask = Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels);
        check_contours(name, &mask, case);
    }
    let reference = json(&folder.join("contour_tree_1024.json"));
    let image = picture(&folder.join("in/tree_a_1024.png"));
    check_contours("tree", &image.map(|pixel| pixel.alpha() > 127), &reference);
}

/// The cages of the reference: (target, source).
fn cages(reference: &Value) -> (Cage, Cage) {
    let cage = |key: &str| Cage::new(&[polygon(&reference[key])]).unwrap();
    (cage("dst"), cage("src"))
}

#[test]
fn coordinates_are_exact_to_nine_digits() {
    let Some(folder) = reference::oracle() else {
        return;
    };
    let reference = json(&folder.join("mvc_ref.json"));
    let (target, source) = cages(&reference);
    for kind in ["interior", "near_edge", "exterior"] {
        let (mut worst, mut worst_px) = (0.0f64, 0.0f64);
        for entry in reference[kind].as_array().unwrap() {
            let at = point(&entry["p"]);
            let theirs = numbers(&entry["w"]);
            let largest = theirs.iter().fold(0.0f64, |most, w| most.max(w.abs()));
            for (ours, theirs) in coordinates(&target, at).iter().zip(&theirs) {
                worst = worst.max((ours - theirs).abs() / largest);
            }
            let mapped = mapped_exactly(&target, &source, at);
            worst_px = worst_px.max(mapped.distance(point(&entry["mapped"])));
        }
        println!("{kind}: coordinates differ by {worst:.1e}, positions by {worst_px:.1e} px");
        assert!(worst < 1e-9, "{kind}: {worst:e}");
        assert!(worst_px < 1e-6, "{kind}: {worst_px:e}");
    }
}

#[test]
fn coordinates_on_vertices_and_edges_are_their_limits() {
    let Some(folder) = reference::oracle() else {
        return;
    };
    let reference = json(&folder.join("mvc_ref.json"));
    let (target, _) = cages(&reference);
    let index = |value: &Value| value.as_u64().unwrap() as usize;
    for entry in reference["on_vertex"].as_array().unwrap() {
        let weights = coordinates(&target, point(&entry["p"]));
        assert_eq!(weights[index(&entry["index"])], 1.0);
        assert_eq!(weights.iter().sum::<f64>(), 1.0);
    }
    for entry in reference["on_edge"].as_array().unwrap() {
        let mut weights = coordinates(&target, point(&entry["p"]));
        let t = entry["t"].as_f64().unwrap();
        weights[index(&entry["i"])] -= 1.0 - t;
        weights[index(&entry["j"])] -= t;
        let worst = weights.iter().fold(0.0f64, |most, w| most.max(w.abs()));
        assert!(worst < 1e-9, "{worst:e}");
    }
}

/// The data of array `name` in an `.npz` file: a zip archive of deflated `.npy` files.
fn npz(bytes: &[u8], name: &str) -> Vec<u8> {
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]));
    let u32_at = |at: usize| u16_at(at) | u16_at(at + 2) << 16;
    // The end record, without a comment, holds the place of the directory.
    let mut at = u32_at(bytes.len() - 22 + 16);
    while bytes[at..].starts_with(b"PK\x01\x02") {
        let (name_length, rest) = (u16_at(at + 28), u16_at(at + 30) + u16_at(at + 32));
        let entry = &bytes[at + 46..at + 46 + name_length];
        if entry == format!("{name}.npy").as_bytes() {
            let local = u32_at(at + 42);
            let data = local + 30 + u16_at(local + 26) + u16_at(local + 28);
            let mut npy = Vec::new();
            let mut inflated = flate2::read::DeflateDecoder::new(&bytes[data..]);
            inflated.read_to_end(&mut npy).unwrap();
            let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
            return npy.split_off(header);
        }
        at += 46 + name_length + rest;
    }
    panic!("no array {name}");
}

#[test]
fn every_pixel_of_the_warp_is_where_numpy_has_it() {
    let Some(folder) = reference::oracle() else {
        return;
    };
    let reference = json(&folder.join("in/cage_100.json"));
    let (target, source) = cages(&reference);
    let arrays = std::fs::read(folder.join("warp_positions_f64.npz")).unwrap();
    let mask: Vec<bool> = npz(&arrays, "mask").into_iter().map(|b| b != 0).collect();
    let inside = inside_polygons(&[polygon(&reference["dst"])], 1024, 1024);
    assert!(inside.pixels() == mask, "the inside differs");

    let values = npz(&arrays, "pos");
    let values = values
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().unwrap()));
    let positions: Vec<f64> = values.collect();
    let warp = Warp::new(&target, &source, 1).unwrap();
    let pixels = (0..1024 * 1024).filter(|&i| mask[i]).step_by(16);
    let mut worst = 0.0f64;
    for (i, theirs) in pixels.zip(positions.chunks_exact(2)) {
        let ours = warp.position(Point::new((i % 1024) as f64, (i / 1024) as f64));
        worst = worst.max(ours.distance(Point::new(theirs[0], theirs[1])));
    }
    println!("positions differ by {worst:.1e} px");
    assert!(worst < 1e-6, "{worst:e} px");
}

#[test]
fn histograms_are_matched_as_scikit_image_does() {
    let Some(folder) = reference::oracle() else {
        return;
    };
    let image = picture(&folder.join("in/tree_a_1024.png"));
    let like = picture(&folder.join("in/tree_b_1024.png"));
    let transfer = Transfer::between(&Histogram::of(&image), &Histogram::of(&like));
    let reference = json(&folder.join("histmatch_lut.json"));
    for channel in 0..3 {
        for (value, theirs) in numbers(&reference["lut_rgb"][channel]).iter().enumerate() {
            let ours = transfer.applied(Straight([value as u8, value as u8, value as u8, 255]));
            assert_eq!(
                ours.0[channel], *theirs as u8,
                "channel {channel}, value {value}"
            );
        }
    }
    let expected = picture(&folder.join("histmatch_out.png"));
    let pairs = image.pixels().iter().zip(expected.pixels());
    for (pixel, theirs) in pairs.filter(|(pixel, _)| pixel.alpha() > 0) {
        assert_eq!(transfer.applied(*pixel).0[..3], theirs.0[..3]);
    }
}
