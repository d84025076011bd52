//! The relief of real crowns: nothing on the silhouette, and the lighter the higher.
//!
//! The photographs and masks are those of `BOSCAGE_DATA` (default `../shared/data`); without them the
//! tests say so and pass.

use crate::reference;
use boscage::base::Cancel;
use boscage::crown::{Pyramid, ReliefSettings, luminance, relief};
use boscage::raster::{Image, Mask, Straight, opaque_bounds, resized};

const CROWNS: [&str; 3] = [
    "white_oak_dense_01",
    "ponderosa_pine_01",
    "red_maple_autumn_dense_01",
];

/// Pixels along the longer side of the crowns.
const LONGEST: f64 = 192.0;

/// The crowns, smaller; none where there is no data.
fn crowns() -> Vec<(&'static str, Image<Straight>, Mask)> {
    let Some(folder) = reference::data("photos") else {
        return Vec::new();
    };
    let crown = |name| {
        let (photo, mask) = reference::photo_and_mask(&folder, name);
        let bounds = opaque_bounds(&mask).unwrap();
        let mask = mask.map(|&inside| Straight([if inside { 255 } else { 0 }; 4]));
        let scale = LONGEST / f64::from(bounds.width.max(bounds.height));
        let [width, height] =
            [bounds.width, bounds.height].map(|side| (f64::from(side) * scale) as u32);
        let small = |image: &Image<Straight>| {
            let image = image.map(|pixel| pixel.premultiplied());
            resized(&image, bounds, width, height).straight()
        };
        let mask = small(&mask).map(|pixel| pixel.0[0] >= 128);
        (name, small(&photo), mask)
    };
    CROWNS.map(crown).into()
}

fn made(photo: &Image<Straight>, mask: &Mask, pyramid: Pyramid) -> Image<f32> {
    let settings = ReliefSettings {
        pyramid,
        ..ReliefSettings::default()
    };
    relief(photo, mask, &settings, &Cancel::new()).unwrap()
}

/// How many of the four neighbours of a pixel are in the mask, 0 for one outside.
fn neighbours(mask: &Mask, x: u32, y: u32) -> usize {
    let (x, y) = (i64::from(x), i64::from(y));
    let around = [(x + 1, y), (x - 1, y), (x, y + 1), (x, y - 1)];
    match mask.get(x, y) {
        Some(true) => around
            .iter()
            .filter(|&&(x, y)| mask.get(x, y) == Some(true))
            .count(),
        _ => 0,
    }
}

#[test]
fn the_silhouette_and_what_is_outside_stay_flat() {
    for (name, photo, mask) in crowns() {
        for pyramid in [Pyramid::Gaussian, Pyramid::Laplacian] {
            let relief = made(&photo, &mask, pyramid);
            let mut raised = 0;
            for (x, y) in (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| (x, y))) {
                match neighbours(&mask, x, y) {
                    4 => raised += usize::from(relief.at(x, y) != 0.0),
                    _ => assert_eq!(relief.at(x, y), 0.0, "{name} {x} {y}"),
                }
            }
            assert!(
                raised * 3 > mask.count(),
                "{name}: {raised} of {}",
                mask.count()
            );
        }
    }
}

#[test]
fn the_lighter_a_fifth_of_the_crown_the_higher_it_lies() {
    for (name, photo, mask) in crowns() {
        let relief = made(&photo, &mask, Pyramid::Gaussian);
        let mut pixels: Vec<(f32, f32)> = Vec::new();
        for (x, y) in (0..mask.height()).flat_map(|y| (0..mask.width()).map(move |x| (x, y))) {
            if neighbours(&mask, x, y) == 4 {
                pixels.push((luminance(photo.at(x, y)), relief.at(x, y)));
            }
        }
        pixels.sort_by(|a, b| a.0.total_cmp(&b.0));
        let means: Vec<f32> = pixels
            .chunks(pixels.len().div_ceil(5))
            .map(|fifth| fifth.iter().map(|one| one.1).sum::<f32>() / fifth.len() as f32)
            .collect();
        eprintln!("{name}: {means:?}");
        assert!(
            means.windows(2).all(|pair| pair[0] < pair[1]),
            "{name}: {means:?}"
        );
    }
}

#[test]
fn more_light_on_a_spot_raises_it_and_less_lowers_it() {
    for (name, photo, mask) in crowns() {
        // The spot lies where the crown is widest, away from its silhouette.
        let (width, height) = (mask.width(), mask.height());
        let deep = |x: u32, y: u32| {
            let reach = |dx: i64, dy: i64| {
                (1..)
                    .take_while(|i| {
                        mask.get(i64::from(x) + i * dx, i64::from(y) + i * dy) == Some(true)
                    })
                    .count()
            };
            [(1, 0), (-1, 0), (0, 1), (0, -1)]
                .map(|(dx, dy)| reach(dx, dy))
                .into_iter()
                .min()
                .unwrap()
        };
        let places = (0..height)
            .step_by(4)
            .flat_map(|y| (0..width).step_by(4).map(move |x| (x, y)));
        let inside = places.filter(|&(x, y)| mask.at(x, y));
        let (x, y) = inside.max_by_key(|&(x, y)| deep(x, y)).unwrap();
        let spot = |u: u32, v: u32| u.abs_diff(x).max(v.abs_diff(y)) <= 4;
        let mean = |change: i32| {
            let mut lit = photo.clone();
            for (u, v) in (0..height).flat_map(|v| (0..width).map(move |u| (u, v))) {
                if spot(u, v) {
                    let [r, g, b, a] = photo.at(u, v).0;
                    let add = |value: u8| (i32::from(value) + change).clamp(0, 255) as u8;
                    lit.set(u, v, Straight([add(r), add(g), add(b), a]));
                }
            }
            let relief = made(&lit, &mask, Pyramid::Gaussian);
            let heights = (0..height).flat_map(|v| (0..width).map(move |u| (u, v)));
            let heights: Vec<f32> = heights
                .filter(|&(u, v)| spot(u, v))
                .map(|(u, v)| relief.at(u, v))
                .collect();
            heights.iter().sum::<f32>() / heights.len() as f32
        };
        let means = [-30, 0, 30].map(mean);
        eprintln!("{name}: {means:?}");
        assert!(
            means[0] < means[1] && means[1] < means[2],
            "{name}: {means:?}"
        );
    }
}
