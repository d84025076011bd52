use super::*;
use crate::document;
use crate::paint::CROWN;
use crate::pipeline::{crown, crown_of_regions, is_crown};

fn disc(width: u32, height: u32, centre: (f64, f64), radius: f64) -> Mask {
    let inside = |i: u32| {
        let (x, y) = (f64::from(i % width), f64::from(i / width));
        (x - centre.0).hypot(y - centre.1) < radius
    };
    Image::from_pixels(width, height, (0..width * height).map(inside).collect())
}

fn photo(width: u32, height: u32) -> Arc<Image<Straight>> {
    let mut random = Seed(3).random();
    let pixels = (0..width * height).map(|_| {
        let light = random.below(120) as u8;
        Straight([30 + light / 2, 50 + light, 20 + light / 3, 255])
    });
    Arc::new(Image::from_pixels(width, height, pixels.collect()))
}

fn input(radius: f64) -> LiveInput {
    let mask = disc(160, 200, (80.0, 90.0), radius);
    LiveInput {
        photo: photo(160, 200),
        labels: Arc::new(TiledMask::from_mask(&mask, CROWN)),
    }
}

fn request(change: impl FnOnce(&mut document::CrownSettings)) -> CrownRequest {
    let mut asked = document::CrownSettings {
        size: 64,
        ..Default::default()
    };
    change(&mut asked);
    CrownRequest::of(&asked).unwrap()
}

fn live(
    live: &mut LiveCrown,
    input: &LiveInput,
    request: &CrownRequest,
    quality: Quality,
) -> LiveResult {
    live.update(input, request, quality, Progress::silent(), &Cancel::new())
        .unwrap()
}

/// The crown without anything kept.
fn afresh(input: &LiveInput, request: &CrownRequest) -> Crown {
    let mask = input.labels.mask(is_crown);
    crown(
        &input.photo,
        &mask,
        &request.settings,
        request.seed,
        Progress::silent(),
        &Cancel::new(),
    )
    .unwrap()
}

#[test]
fn a_full_crown_is_that_of_the_pipeline_after_any_edits() {
    let mut kept = LiveCrown::default();
    let (small, large) = (input(50.0), input(60.0));
    let edits = [
        (&small, request(|_| ())),
        (
            &small,
            request(|s| s.k = document::Tangent::Expression("1+2*j".into())),
        ),
        (&small, request(|s| s.rho = 0.6)),
        (&large, request(|s| s.rho = 0.6)),
        (&large, request(|s| s.copies = 2)),
        (&large, request(|s| s.relief.falloff = 0.2)),
        (&large, request(|s| s.seed = 9)),
        (&small, request(|s| s.photo_front = true)),
    ];
    for (input, request) in &edits {
        live(&mut kept, input, request, Quality::Coarse);
        live(&mut kept, input, request, Quality::Fine);
        let full = live(&mut kept, input, request, Quality::Full);
        assert_eq!(*full.crown, afresh(input, request), "{request:?}");
    }
}

#[test]
fn only_what_an_edit_touches_is_made_anew() {
    let mut kept = LiveCrown::default();
    let input = input(50.0);
    let first = live(&mut kept, &input, &request(|_| ()), Quality::Full);
    assert!(kept.is_inflated(&input));
    let versions = |kept: &LiveCrown| {
        let inflated = kept.fine.inflated.0.as_ref().unwrap().version;
        let shape = kept.fine.shape.0.as_ref().unwrap().version;
        let height = kept.height.0.as_ref().unwrap().version;
        (inflated, shape, height)
    };
    let before = versions(&kept);
    let rho = request(|s| s.rho = 0.5);
    assert!(kept.is_shaped(&input, &rho));
    let second = live(&mut kept, &input, &rho, Quality::Fine);
    assert_eq!(versions(&kept), before);
    assert_eq!(second.color_version, first.color_version);
    assert_ne!(second.crown.radius_m, first.crown.radius_m);
    let k = request(|s| s.k = document::Tangent::Expression("1".into()));
    assert!(!kept.is_shaped(&input, &k));
    let third = live(&mut kept, &input, &k, Quality::Fine);
    let after = versions(&kept);
    assert_eq!((after.0, after.2), (before.0, before.2));
    assert_ne!(after.1, before.1);
    assert_eq!(third.color_version, first.color_version);
    // Flatter: what faces the viewer is nearer to the centre.
    let front = |crown: &Crown| crown.radius_m.nearest(glam::DVec3::Z);
    assert!(front(&third.crown) < 0.7 * front(&first.crown));
}

#[test]
fn a_coarse_crown_is_nearly_the_full_one() {
    let mask = disc(1600, 2000, (800.0, 900.0), 600.0);
    let input = LiveInput {
        photo: photo(1600, 2000),
        labels: Arc::new(TiledMask::from_mask(&mask, CROWN)),
    };
    let request = request(|s| {
        s.size = 128;
        s.rho = 0.0;
    });
    let mut kept = LiveCrown::default();
    let coarse = live(&mut kept, &input, &request, Quality::Coarse).crown;
    let fine = live(&mut kept, &input, &request, Quality::Fine).crown;
    assert!(coarse.center_m.distance(fine.center_m) < 0.05);
    for direction in [glam::DVec3::X, glam::DVec3::Y, glam::DVec3::Z] {
        let (a, b) = (
            coarse.radius_m.nearest(direction),
            fine.radius_m.nearest(direction),
        );
        assert!((a / b - 1.0).abs() < 0.02, "{a} {b}");
    }
    // The photograph, the same behind as in front.
    let at = |z: f64| coarse.color.nearest(glam::DVec3::new(0.3, 0.2, z));
    assert_eq!(at(1.0), at(-1.0));
    assert!(at(1.0).0[1] >= 50);
}

#[test]
fn sub_crowns_stand_at_their_depths() {
    let (one, two) = (
        disc(160, 200, (60.0, 100.0), 34.0),
        disc(160, 200, (105.0, 100.0), 34.0),
    );
    let labels = Image::from_pixels(
        160,
        200,
        one.pixels()
            .iter()
            .zip(two.pixels())
            .map(|(&one, &two)| if two { 3 } else { u8::from(one) })
            .collect(),
    );
    let input = LiveInput {
        photo: photo(160, 200),
        labels: Arc::new(TiledMask::from_image(&labels)),
    };
    let request = request(|s| {
        s.sub_crown_depths.insert(3, 0.2);
    });
    let mut kept = LiveCrown::default();
    let made = live(&mut kept, &input, &request, Quality::Full).crown;
    let regions = Regions::new(&input.labels, Thinning::none(&input.labels)).unwrap();
    let sub_crowns = request.sub_crowns(&regions);
    assert!((sub_crowns[1].depth_px - 0.2 * 113.0).abs() < 0.5);
    let expected = crown_of_regions(
        &input.photo,
        &sub_crowns,
        &request.settings,
        request.seed,
        Progress::silent(),
        &Cancel::new(),
    );
    assert_eq!(*made, expected.unwrap());
}

#[test]
fn copies_take_up_what_each_other_found_and_errors_are_told() {
    let mut kept = LiveCrown::default();
    let input = input(40.0);
    let mut copy = kept.clone();
    live(&mut copy, &input, &request(|_| ()), Quality::Fine);
    assert!(!kept.is_inflated(&input));
    kept.adopt(copy);
    assert!(kept.is_inflated(&input));
    let empty = LiveInput {
        photo: Arc::clone(&input.photo),
        labels: Arc::new(TiledMask::filled(160, 200, 2)),
    };
    let failed = kept.update(
        &empty,
        &request(|_| ()),
        Quality::Fine,
        Progress::silent(),
        &Cancel::new(),
    );
    assert!(matches!(
        failed,
        Err(CrownError::Inflation(InflationError::Empty))
    ));
    let half_typed = document::CrownSettings {
        k: document::Tangent::Expression("1+".into()),
        ..Default::default()
    };
    assert!(matches!(
        CrownRequest::of(&half_typed),
        Err(CrownError::Tangent(_))
    ));
}
