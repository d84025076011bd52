//! The closed surface over masks of every nasty kind: one part a component, one handle a hole.

use boscage::crown::closed_surface;
use boscage::geometry::{Mesh, Topology};
use boscage::raster::{Image, Mask, labelled_components};
use glam::DVec3;
use proptest::prelude::*;

fn mask(rows: &[&str]) -> Mask {
    let pixels = rows.iter().flat_map(|row| row.bytes().map(|b| b == b'#'));
    Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels.collect())
}

/// A stand-in for a sheet: the silhouette at 0, everything else at 1.
fn raised(mask: &Mask) -> Vec<DVec3> {
    let mut sheet = Vec::new();
    for y in 0..i64::from(mask.height()) {
        for x in 0..i64::from(mask.width()) {
            let inside = |dx, dy| mask.get(x + dx, y + dy) == Some(true);
            let inner = inside(1, 0) && inside(-1, 0) && inside(0, 1) && inside(0, -1);
            if inside(0, 0) {
                sheet.push(DVec3::new(x as f64, y as f64, f64::from(u8::from(inner))));
            }
        }
    }
    sheet
}

fn surface(mask: &Mask) -> Mesh {
    closed_surface(mask, &raised(mask), |_| 2.0)
}

/// Components (to eight neighbours) and holes (background to four), counted by flooding.
fn components_and_holes(mask: &Mask) -> (usize, usize) {
    let components = labelled_components(mask)
        .pixels()
        .iter()
        .copied()
        .max()
        .unwrap() as usize;
    let (width, height) = (mask.width() as usize + 2, mask.height() as usize + 2);
    let is_open = |x: usize, y: usize| mask.get(x as i64 - 1, y as i64 - 1) != Some(true);
    let mut seen = vec![false; width * height];
    let mut regions = 0;
    for start in 0..width * height {
        if seen[start] || !is_open(start % width, start / width) {
            continue;
        }
        regions += 1;
        let mut stack = vec![start];
        while let Some(at) = stack.pop() {
            if std::mem::replace(&mut seen[at], true) {
                continue;
            }
            let (x, y) = (at % width, at / width);
            let sides = [
                (x > 0).then(|| at - 1),
                (x + 1 < width).then_some(at + 1),
                (y > 0).then(|| at - width),
                (y + 1 < height).then_some(at + width),
            ];
            let open = |&next: &usize| is_open(next % width, next / width) && !seen[next];
            stack.extend(sides.into_iter().flatten().filter(open));
        }
    }
    (components, regions - 1)
}

fn check(mask: &Mask) {
    let mesh = surface(mask);
    let found = Topology::of(&mesh);
    assert_eq!(
        (found.bad_edges, found.bad_vertices),
        (0, 0),
        "{found:?}\n{mask:?}"
    );
    let (components, holes) = components_and_holes(mask);
    assert_eq!(found.components, components, "{mask:?}");
    assert_eq!(found.genus(), Some(holes as u64), "{mask:?}");
    assert!(mesh.volume() > 0.0);
    assert_eq!(&mesh.positions[..mask.count()], raised(mask));
}

fn spiral(side: i64, gap: i64) -> Mask {
    let mut mask = Image::filled(side as u32, side as u32, false);
    let (mut x, mut y, mut dx, mut dy) = (0, 0, 1, 0);
    let inside = |x: i64, y: i64| (0..side).contains(&x) && (0..side).contains(&y);
    for _ in 0..side * side {
        mask.set(x as u32, y as u32, true);
        let ahead = (1..=gap).any(|s| mask.get(x + s * dx, y + s * dy) == Some(true));
        if !inside(x + dx, y + dy) || ahead {
            (dx, dy) = (-dy, dx);
            let blocked = (1..=gap).any(|s| mask.get(x + s * dx, y + s * dy) == Some(true));
            if blocked || !inside(x + dx, y + dy) {
                break;
            }
        }
        (x, y) = (x + dx, y + dy);
    }
    mask
}

#[test]
fn the_zoo_becomes_closed_surfaces_of_the_right_kind() {
    let zoo: &[&[&str]] = &[
        &["#"],
        &["##"],
        &["#####"],
        &["#", "#", "#"],
        &["##", "##"],
        &["##", "#."],
        &["####", "####"],
        &["#..", ".#.", "..#"],
        &["###", "#.#", "###"],
        &[".#.", "#.#", ".#."],
        &["#####", "#...#", "#.#.#", "#...#", "#####"],
        &["###...###", "#########", "###...###"],
        &[
            "###....", "###....", "###....", "...####", "...####", "...####",
        ],
        &["###.....", "###.....", "########", ".....###", ".....###"],
        &["#########", "#.#.#.#.#", "#.#.#.#.#", "#.#.#.#.#"],
        &["#.#.#", ".#.#.", "#.#.#", ".#.#."],
        &["..#..", "..#..", "#####", "..#..", "..#.."],
        &["######", "######", "######", "######"],
        &["######", "##.###", "###.##", "######"],
        &["######", "######", "##..##", "######", "######"],
        &["###.###", "###.###", "##...##"],
    ];
    for rows in zoo {
        check(&mask(rows));
    }
    for (side, gap) in [(12, 2), (25, 2), (25, 3)] {
        check(&spiral(side, gap));
    }
}

#[test]
fn thin_parts_have_the_thickness_of_a_pixel() {
    let line = surface(&mask(&["#####"]));
    let (low, high) = line.bounds().unwrap();
    assert_eq!((low.y, high.y, low.z, high.z), (-0.5, 0.5, -0.5, 0.5));
    assert_eq!((low.x, high.x), (-0.5, 4.5));
    // Where k is 0 everything is flat, and still closed.
    let sheet = raised(&mask(&["##", "##"]));
    let flat = closed_surface(&mask(&["##", "##"]), &sheet, |_| 0.0);
    assert!(Topology::of(&flat).is_watertight() && flat.volume() == 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]
    #[test]
    fn any_mask_becomes_a_closed_surface(
        width in 1u32..9,
        height in 1u32..9,
        bits in proptest::collection::vec(any::<u8>(), 81),
        density in 40u8..250,
    ) {
        let pixels = bits.iter().take((width * height) as usize).map(|&b| b < density).collect();
        let mask = Image::from_pixels(width, height, pixels);
        prop_assume!(mask.count() > 0);
        check(&mask);
    }
}
