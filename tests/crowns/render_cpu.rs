//! The renderer on the processor: against what geometry says, and against itself.

use crate::crowns::{crown, lumpy};
use boscage::base::{Cancel, Progress};
use boscage::raster::{Image, Straight};
use boscage::render::{
    LeafSet, Mode, PreparedCrown, RenderSettings, SceneView, Shortcut, View, cpu,
};
use boscage::scene::{Backdrop, Camera, Crown, CrownInstance, Light};
use glam::DVec3;

/// The centre of all crowns here.
const CENTER_M: DVec3 = DVec3::new(0.0, 5.0, 0.0);

fn ball() -> Crown {
    crown(128, CENTER_M, |_| 3.0, |_| [90, 120, 50])
}

/// What `draw` makes of a view of the crown alone.
fn seen<T>(crown: &Crown, camera: &Camera, draw: impl FnOnce(&SceneView<'_>) -> T) -> T {
    let prepared = [PreparedCrown::new(crown, &Cancel::new()).unwrap()];
    draw(&SceneView {
        crowns: &prepared,
        instances: &[CrownInstance::plain(0)],
        meshes: &[],
        leaves: &LeafSet::default(),
        camera,
        light: &Light::default(),
        backdrop: Backdrop::Clear,
    })
}

fn picture(crown: &Crown, camera: &Camera, settings: &RenderSettings) -> Image<Straight> {
    seen(crown, camera, |view| {
        cpu::picture(view, settings, &Progress::silent(), &Cancel::new()).unwrap()
    })
}

fn distances(crown: &Crown, camera: &Camera, settings: &RenderSettings) -> Image<f32> {
    seen(crown, camera, |view| {
        cpu::distances_m(view, settings, &Cancel::new()).unwrap()
    })
}

fn front() -> Camera {
    Camera::framing(CENTER_M, 3.3, (0.0, 0.0), 1.0)
}

fn square(size: u32, view: View) -> RenderSettings {
    RenderSettings {
        size: (size, size),
        fineness: 1,
        view,
        ..RenderSettings::default()
    }
}

/// The ray through the middle of a pixel of a square picture.
fn ray(camera: &Camera, size: u32, x: u32, y: u32) -> DVec3 {
    let (tan, _) = camera.half_extent(1.0);
    let place = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
    let axes = camera.axes();
    (axes.forward + axes.right * (tan * place(x)) - axes.up * (tan * place(y))).normalize()
}

/// How near a ray from the eye comes to the centre of the crown.
fn distance_to_center(camera: &Camera, ray: DVec3) -> f64 {
    let eye = camera.eye_m() - CENTER_M;
    (eye - ray * eye.dot(ray)).length()
}

/// Where a ray from the eye meets the ball of radius 3, from its centre.
fn on_ball(camera: &Camera, ray: DVec3) -> Option<DVec3> {
    let eye = camera.eye_m() - CENTER_M;
    let along = eye.dot(ray);
    let room = 9.0 - (eye - ray * along).length_squared();
    (room > 0.0).then(|| eye + ray * (-along - room.sqrt()))
}

#[test]
fn a_ball_is_the_analytic_ball() {
    const SIZE: u32 = 256;
    let ball = ball();
    // The longest linear step, halved as often as the default has it, and the rounding of floats.
    let defaults = RenderSettings::default().relief;
    let linear_step = 6.0 / f64::from(defaults.least_steps);
    let binary_step = linear_step / 2f64.powi(defaults.halvings as i32) + 1e-5;
    for (yaw, pitch) in [(0.0, 0.0), (45.0, 35.26), (120.0, -60.0), (0.0, 89.0)] {
        let camera = front().orbited(yaw, pitch);
        let normals = picture(&ball, &camera, &square(SIZE, View::Normals));
        let depths = distances(&ball, &camera, &square(SIZE, View::Picture));
        let mut seen = 0;
        for y in 0..SIZE {
            for x in 0..SIZE {
                let ray = ray(&camera, SIZE, x, y);
                let expected = on_ball(&camera, ray);
                let alpha = normals.at(x, y).alpha();
                // A pixel on the very outline may fall to either side.
                if (distance_to_center(&camera, ray) - 3.0).abs() < 2e-3 {
                    continue;
                }
                assert_eq!(alpha == 255, expected.is_some(), "{x} {y}");
                let Some(point) = expected else { continue };
                seen += 1;
                let texel = normals.at(x, y).0;
                let normal = DVec3::from([0, 1, 2].map(|i| linear(texel[i]))) * 2.0 - DVec3::ONE;
                let off = libm::acos(normal.normalize().dot(point / 3.0).min(1.0)).to_degrees();
                assert!(off < 1.0, "{x} {y}: {off} degrees");
                let there = point + CENTER_M - camera.eye_m();
                let exact = there.dot(camera.axes().forward);
                let off = (f64::from(depths.at(x, y)) - exact).abs();
                assert!(off < binary_step, "{x} {y}: {off} m");
            }
        }
        assert!(seen > 20_000, "{seen}");
    }
}

fn linear(srgb: u8) -> f64 {
    let value = f64::from(srgb) / 255.0;
    if value <= 0.04045 {
        value / 12.92
    } else {
        libm::pow((value + 0.055) / 1.055, 2.4)
    }
}

/// Share of the pixels whose values differ by more than `allowed` in a channel.
fn differing(one: &Image<Straight>, other: &Image<Straight>, allowed: u8) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let apart =
        |a: &Straight, b: &Straight| a.0.iter().zip(&b.0).any(|(a, b)| a.abs_diff(*b) > allowed);
    let count = pairs.filter(|(a, b)| apart(a, b)).count();
    count as f64 / one.pixels().len() as f64
}

#[test]
fn shortcuts_change_what_a_ray_costs_and_not_what_it_finds() {
    let lumpy = lumpy(CENTER_M);
    let with = |shortcut: Shortcut, view: View| {
        let mut settings = square(192, view);
        settings.relief.shortcut = shortcut;
        picture(&lumpy, &front().orbited(30.0, 20.0), &settings)
    };
    let full = with(Shortcut::None, View::Picture);
    let bounded = with(Shortcut::Bounded, View::Picture);
    assert!(differing(&full, &bounded, 8) < 0.03);
    let cost = |image: Image<Straight>| -> f64 {
        let reads = image.pixels().iter().map(|pixel| linear(pixel.0[0]));
        reads.sum()
    };
    let full = cost(with(Shortcut::None, View::Steps));
    let bounded = cost(with(Shortcut::Bounded, View::Steps));
    assert!(bounded < full, "{bounded} {full}");
}

#[test]
fn no_edge_of_the_cube_lets_light_through() {
    // Noise of the finest grain, which is nowhere continuous from face to face.
    let noisy = crown(
        64,
        CENTER_M,
        |d| {
            let hash = libm::sin(d.x * 913.0 + d.y * 717.0 + d.z * 501.0) * 4371.0;
            2.0 + hash - hash.floor()
        },
        |_| [255; 3],
    );
    for (yaw, pitch) in [(45.0, 0.0), (45.0, 35.26), (0.0, 45.0), (225.0, -35.26)] {
        let image = picture(
            &noisy,
            &front().orbited(yaw, pitch),
            &square(256, View::Picture),
        );
        for y in 0..256 {
            for x in 0..256 {
                let ray = ray(&front().orbited(yaw, pitch), 256, x, y);
                if distance_to_center(&front().orbited(yaw, pitch), ray) < 1.99 {
                    assert_eq!(image.at(x, y).alpha(), 255, "{yaw} {pitch}: {x} {y}");
                }
            }
        }
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let lumpy = lumpy(CENTER_M);
    let settings = square(96, View::Picture);
    let with = |threads| {
        boscage::base::with_threads(Some(threads), || picture(&lumpy, &front(), &settings)).unwrap()
    };
    assert_eq!(with(1), with(3));
}

#[test]
fn an_eye_within_the_proxy_sees_the_crown() {
    let mut near = front();
    near.distance_m = 3.05;
    let image = picture(&ball(), &near, &square(64, View::Picture));
    assert!(image.pixels().iter().all(|pixel| pixel.alpha() == 255));
}

/// Sums over the pixels of the smaller and of the larger alpha of two pictures.
fn alphas(one: &Image<Straight>, other: &Image<Straight>) -> (f64, f64) {
    let pairs = one.pixels().iter().zip(other.pixels());
    pairs.fold((0.0, 0.0), |(both, either), (a, b)| {
        let (a, b) = (f64::from(a.alpha()), f64::from(b.alpha()));
        (both + a.min(b), either + a.max(b))
    })
}

/// A tree as tall in the picture as one of 10 m is at 100 m in full HD.
fn at_the_switch(mode: Mode) -> RenderSettings {
    let mut settings = square(240, View::Picture);
    settings.fineness = 2;
    settings.mode = mode;
    settings
}

#[test]
fn forms_have_one_outline_where_they_change() {
    let lumpy = lumpy(CENTER_M);
    for (yaw, pitch) in [(0.0, 5.0), (70.0, 20.0)] {
        let camera = front().orbited(yaw, pitch).zoomed(1.8);
        let relief = picture(&lumpy, &camera, &at_the_switch(Mode::Relief));
        let leaves = picture(&lumpy, &camera, &at_the_switch(Mode::Leaves));
        let (both, either) = alphas(&relief, &leaves);
        assert!(both / either > 0.95, "{yaw} {pitch}: {}", both / either);
    }
}

/// Mean difference of two pictures, in values of 255.
fn change(one: &Image<Straight>, other: &Image<Straight>) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let sum: u64 = pairs
        .flat_map(|(a, b)| a.0.iter().zip(b.0))
        .map(|(a, b)| u64::from(a.abs_diff(b)))
        .sum();
    sum as f64 / (4 * one.pixels().len()) as f64
}

#[test]
fn nothing_pops_on_the_way_through_the_switch() {
    let lumpy = lumpy(CENTER_M);
    let mut settings = at_the_switch(Mode::Switched);
    settings.size = (120, 120);
    let begin = front().zoomed(1.8);
    settings.switch.nearest_m = begin.distance_m * 1.2;
    settings.switch.farthest_m = settings.switch.nearest_m;
    settings.switch.band_m = begin.distance_m * 0.2;
    let steps = (0..=20).map(|i| {
        let view = begin.zoomed(1.0 + 0.02 * f64::from(i));
        picture(&lumpy, &view, &settings)
    });
    let pictures: Vec<Image<Straight>> = steps.collect();
    let changes: Vec<f64> = pictures.windows(2).map(|w| change(&w[0], &w[1])).collect();
    // The first and the last changes are those of the tree growing smaller alone.
    let plain = changes[0].max(changes[1]);
    let most = changes.iter().copied().fold(0.0, f64::max);
    assert!(most < 1.6 * plain, "{most} against {plain}: {changes:?}");
}

/// Writes what a person should look at into the folder that BOSCAGE_LOOK names.
#[test]
fn pictures_to_look_at() {
    let Ok(folder) = std::env::var("BOSCAGE_LOOK") else {
        return;
    };
    let mut settings = square(512, View::Picture);
    settings.fineness = 2;
    for (name, crown) in [("ball", ball()), ("lumpy", lumpy(CENTER_M))] {
        for (side, yaw, pitch) in [("front", 0.0, 10.0), ("top", 30.0, 70.0)] {
            let image = picture(&crown, &front().orbited(yaw, pitch), &settings);
            let png = boscage::raster::encode_png(&image, Default::default());
            std::fs::write(format!("{folder}/{name}_{side}.png"), png).unwrap();
        }
    }
}
