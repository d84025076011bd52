//! Cubemaps of the foliage of real crowns: no edge, no corner, whatever the threads.
//!
//! The photographs and masks are those of `BOSCAGE_DATA` (default `../shared/data`); without them the
//! tests say so and pass.

use crate::reference;
use boscage::base::{Cancel, Progress, Seed, with_threads};
use boscage::crown::crown_center;
use boscage::geometry::Point;
use boscage::pipeline::{CrownSettings, colored_surface};
use boscage::raster::{CubeFace, Cubemap, Image, Mask, Straight, opaque_bounds};
use boscage::synth::{
    CrownSurface, CubemapSettings, Extent, FoliageCubemap, edge_statistic, foliage_cubemap,
};
use glam::DVec3;

const CROWNS: [&str; 4] = [
    "white_oak_dense_01",
    "red_maple_autumn_dense_01",
    "ponderosa_pine_01",
    "bald_cypress_01",
];

/// How far the crown of `mask` reaches from `center`, pixels, if it is as deep as wide.
fn extent_of(mask: &Mask, center: Point) -> Extent {
    let bounds = opaque_bounds(mask).unwrap();
    let (top, height) = (f64::from(bounds.y) - 0.5, f64::from(bounds.height));
    Extent {
        across: f64::from(bounds.width) / 2.0,
        depth: f64::from(bounds.width) / 2.0,
        up: (center.y - top).clamp(0.0, height),
        down: (top + height - center.y).clamp(0.0, height),
    }
}

fn made(photo: &Image<Straight>, mask: &Mask, size: u32, with_photo: bool) -> FoliageCubemap {
    let center = crown_center(mask).unwrap();
    let extent = extent_of(mask, center);
    let settings = CubemapSettings {
        size,
        ..CubemapSettings::default()
    };
    let radius = ellipsoid(extent);
    let surface = CrownSurface {
        center,
        radius: &radius,
    };
    let front = with_photo.then_some(surface);
    let (seed, silent, cancel) = (Seed(0), Progress::silent(), Cancel::new());
    foliage_cubemap(
        photo, mask, extent, front, &settings, seed, &silent, &cancel,
    )
    .unwrap()
}

/// An ellipsoid as the crown's surface.
fn ellipsoid(extent: Extent) -> Cubemap<f32> {
    Cubemap::from_directions(64, |direction| {
        let d = direction.normalize();
        let vertical = if d.y > 0.0 { extent.up } else { extent.down };
        let unit = DVec3::new(d.x / extent.across, d.y / vertical, d.z / extent.depth);
        (1.0 / unit.length()) as f32
    })
}

#[test]
fn edges_and_corners_differ_no_more_than_lines_inside_faces() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let mut ranks = Vec::new();
    for name in reference::some(&CROWNS) {
        let (photo, mask) = reference::photo_and_mask(&data, name);
        let [plain, front] =
            [false, true].map(|front| edge_statistic(&made(&photo, &mask, 128, front).color));
        eprintln!("{name}: {plain:?}, with the photograph {front:?}");
        for statistic in [plain, front] {
            assert!(statistic.edges <= 1.15 * statistic.interior, "{name}");
            assert!(statistic.edge_rank < 0.999, "{name}");
            assert!(statistic.corner_rank < 0.999, "{name}");
            ranks.extend([statistic.edge_rank, statistic.corner_rank]);
        }
    }
    // Not one of them stands out, nor do all of them lean the same way.
    let mean = ranks.iter().sum::<f64>() / ranks.len() as f64;
    assert!(mean < 0.75, "{mean}");
}

#[test]
fn the_photograph_stays_on_the_front_and_only_there() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let (photo, mask) = reference::photo_and_mask(&data, "beech_round_dense_01");
    let front = made(&photo, &mask, 128, true);
    let own = |face: CubeFace| {
        let texels = front.from_photo.face(face).pixels().iter();
        texels.filter(|own| **own).count()
    };
    let share = own(CubeFace::PosZ) as f64 / (128.0 * 128.0);
    eprintln!("{share:.2} of the front is the photograph's");
    assert!(share > 0.75);
    assert_eq!(own(CubeFace::NegZ), 0);

    // The foliage grows out of it: where the photograph ends, texels differ not much more than elsewhere,
    // and clearly less than from foliage that knows nothing of it.
    let plain = made(&photo, &mask, 128, false);
    let step = |a: Straight, b: Straight| -> f64 {
        let pairs = a.0.into_iter().zip(b.0);
        pairs.map(|(a, b)| f64::from(a.abs_diff(b))).sum()
    };
    let (mut grown, mut pasted, mut within) = ([0.0, 0.0], [0.0, 0.0], [0.0, 0.0]);
    for face in CubeFace::ALL {
        let (color, own) = (front.color.face(face), front.from_photo.face(face));
        for (x, y) in (0..127).flat_map(|y| (0..127).map(move |x| (x, y))) {
            for (u, v) in [(x + 1, y), (x, y + 1)] {
                let add = |sum: &mut [f64; 2], step| *sum = [sum[0] + step, sum[1] + 1.0];
                let here = step(color.at(x, y), color.at(u, v));
                match (own.at(x, y), own.at(u, v)) {
                    (true, false) => {
                        add(&mut grown, here);
                        let other = plain.color.face(face).at(u, v);
                        add(&mut pasted, step(color.at(x, y), other));
                    }
                    (false, true) => {
                        add(&mut grown, here);
                        let other = plain.color.face(face).at(x, y);
                        add(&mut pasted, step(other, color.at(u, v)));
                    }
                    _ => add(&mut within, here),
                }
            }
        }
    }
    let [grown, pasted, within] = [grown, pasted, within].map(|sum| sum[0] / sum[1]);
    eprintln!(
        "steps where the photograph ends {grown:.1}, pasted {pasted:.1}, elsewhere {within:.1}"
    );
    assert!(grown < 1.5 * within && grown < 0.75 * pasted);
}

#[test]
fn threads_change_nothing() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let (photo, mask) = reference::photo_and_mask(&data, CROWNS[1]);
    for front in [false, true] {
        let of = |threads| {
            let made = || made(&photo, &mask, 64, front).color;
            with_threads(Some(threads), made).unwrap()
        };
        assert_eq!(of(1), of(3));
    }
}

/// The photographs stay on most of what faces the viewer, on crowns with gaps of sky as well: what is
/// grown there fills those.
#[test]
fn most_of_the_front_is_the_photographs() {
    let Some(data) = reference::data("photos") else {
        return;
    };
    let mut names: Vec<String> = std::fs::read_dir(data.join("photos"))
        .unwrap()
        .map(|file| file.unwrap().path().file_stem().unwrap().to_owned())
        .map(|stem| stem.into_string().unwrap())
        .collect();
    names.sort();
    let settings = CrownSettings {
        size: 192,
        photo_front: true,
        ..CrownSettings::default()
    };
    let mut shares = Vec::new();
    for name in reference::some(&names) {
        let (photo, mask) = reference::photo_and_mask(&data, name);
        let (silent, cancel) = (Progress::silent(), Cancel::new());
        let made = colored_surface(&photo, &mask, &settings, Seed(0), silent, &cancel).unwrap();
        let share = made.photo_share(0.5);
        eprintln!("{name}: {:.0} % of the front", 100.0 * share);
        shares.push(share);
    }
    shares.sort_unstable_by(f64::total_cmp);
    let median = shares[shares.len() / 2];
    eprintln!("median {median:.2}, least {:.2}", shares[0]);
    // Of all of them 0.78; the few that are looked at here have more sky in their crowns.
    assert!(median > 0.65 && shares[0] > 0.2, "{shares:?}");
}
