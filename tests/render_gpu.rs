//! The renderer for graphics cards against its twin on the processor, on whatever adapter there is.
//!
//! Where there is none the tests are reported as ignored, unless BOSCAGE_REQUIRE_GPU=1 says that
//! there must be one. Since libtest cannot ignore a test once it runs, this file brings its own
//! small harness; it takes the name of a test as libtest does, and ignores libtest's options.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "a harness tells of its tests")]

#[path = "reference/crowns.rs"]
mod crowns;

use boscage::base::{Cancel, Progress, Seed};
use boscage::branches::leaf_name::LeafName;
use boscage::raster::{Image, Straight, encode_png};
use boscage::render::{
    Gpu, GpuRenderer, LeafClip, LeafSet, Mode, Occlusion, PreparedCrown, PreparedMesh, Proxy,
    RenderError, RenderSettings, SceneView, Shortcut, View, Viewport, cpu,
};
use boscage::scene::{Backdrop, Camera, Crown, CrownInstance, Light, Trunk};
use glam::DVec3;
use std::panic::catch_unwind;
use std::process::ExitCode;

/// A test, by its name.
type Test = (&'static str, fn(&Gpu));

const TESTS: &[Test] = &[
    ("twins_agree_on_relief", twins_agree_on_relief),
    ("twins_agree_on_leaves", twins_agree_on_leaves),
    ("twins_agree_on_meshes", twins_agree_on_meshes),
    ("twins_agree_on_every_view", twins_agree_on_every_view),
    ("twins_agree_on_a_scene", twins_agree_on_a_scene),
    ("twins_agree_against_the_sun", twins_agree_against_the_sun),
    ("proxies_make_one_picture", proxies_make_one_picture),
    (
        "too_large_a_picture_is_refused",
        too_large_a_picture_is_refused,
    ),
    ("a_broken_shader_is_an_error", a_broken_shader_is_an_error),
    (
        "a_viewport_at_rest_shows_the_final_picture",
        a_viewport_at_rest_shows_the_final_picture,
    ),
    (
        "a_viewport_shows_what_has_changed_of_a_crown",
        a_viewport_shows_what_has_changed_of_a_crown,
    ),
    ("a_lost_device_is_an_error", a_lost_device_is_an_error),
    #[cfg(debug_assertions)]
    (
        "changed_shaders_are_taken_and_broken_ones_are_not",
        changed_shaders_are_taken_and_broken_ones_are_not,
    ),
];

fn main() -> ExitCode {
    let wanted = std::env::args().skip(1).find(|word| !word.starts_with('-'));
    let listed = std::env::args().any(|word| word == "--list");
    let ours = |name: &str| wanted.as_ref().is_none_or(|part| name.contains(part));
    let tests: Vec<&Test> = TESTS.iter().filter(|(name, _)| ours(name)).collect();
    if listed {
        tests.iter().for_each(|(name, _)| println!("{name}: test"));
        return ExitCode::SUCCESS;
    }
    let outcome = match Gpu::offscreen() {
        Ok(gpu) => run(&gpu, &tests),
        Err(error) => return without_adapter(&error, &tests),
    };
    match wanted.is_none() && std::env::var_os(BACKEND).is_none() && !agrees_on_opengl() {
        true => ExitCode::FAILURE,
        false => outcome,
    }
}

/// The variable by which wgpu chooses.
const BACKEND: &str = "WGPU_BACKEND";

/// Whether the pass with the richest shader draws the same through OpenGL, whose shaders are translated
/// otherwise; true where there is no OpenGL.
fn agrees_on_opengl() -> bool {
    let mut again = std::process::Command::new(std::env::current_exe().unwrap());
    again.arg("twins_agree_on_leaves").env(BACKEND, "gl");
    again.env_remove("BOSCAGE_REQUIRE_GPU");
    again.status().unwrap().success()
}

fn run(gpu: &Gpu, tests: &[&Test]) -> ExitCode {
    println!("\nrunning {} tests on {}", tests.len(), gpu.name());
    let mut failed = 0;
    for (name, test) in tests {
        let gpu = std::panic::AssertUnwindSafe(gpu);
        let outcome = catch_unwind(|| test(*gpu));
        println!(
            "test {name} ... {}",
            if outcome.is_ok() { "ok" } else { "FAILED" }
        );
        failed += usize::from(outcome.is_err());
    }
    let word = if failed == 0 { "ok" } else { "FAILED" };
    let passed = tests.len() - failed;
    println!("\ntest result: {word}. {passed} passed; {failed} failed; 0 ignored\n");
    ExitCode::from(u8::from(failed > 0))
}

fn without_adapter(error: &RenderError, tests: &[&Test]) -> ExitCode {
    let required = std::env::var_os("BOSCAGE_REQUIRE_GPU").is_some_and(|value| value == "1");
    let word = if required { "FAILED" } else { "ignored" };
    for (name, _) in tests {
        println!("test {name} ... {word}, {error}");
    }
    let count = tests.len();
    match required {
        true => println!("\ntest result: FAILED. 0 passed; {count} failed; 0 ignored\n"),
        false => println!("\ntest result: ok. 0 passed; 0 failed; {count} ignored\n"),
    }
    ExitCode::from(u8::from(required))
}

fn lumpy() -> Crown {
    crowns::lumpy(DVec3::new(0.4, 5.0, -0.2))
}

fn prepared() -> Vec<PreparedCrown> {
    vec![PreparedCrown::new(&lumpy(), &Cancel::new()).unwrap()]
}

fn front() -> Camera {
    Camera::framing(DVec3::new(0.4, 5.0, -0.2), 4.5, (0.0, 0.0), 1.0)
}

fn renderer(gpu: &Gpu) -> GpuRenderer {
    GpuRenderer::new(gpu.clone(), Proxy::Icosahedron).unwrap()
}

/// Share of the pixels whose values differ by more than 2 of 255 in a channel.
fn differing(one: &Image<Straight>, other: &Image<Straight>) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let apart = |a: &Straight, b: &Straight| a.0.iter().zip(&b.0).any(|(a, b)| a.abs_diff(*b) > 2);
    let count = pairs.filter(|(a, b)| apart(a, b)).count();
    count as f64 / one.pixels().len() as f64
}

/// Draws with both and fails when more than half a percent of the pixels differ.
fn assert_twins_agree(name: &str, gpu: &Gpu, view: &SceneView<'_>, settings: &RenderSettings) {
    let card = renderer(gpu).picture(view, settings).unwrap();
    let cancel = Cancel::new();
    let twin = cpu::picture(view, settings, &Progress::silent(), &cancel).unwrap();
    let share = differing(&card, &twin);
    println!("{name}: {:.3} % of the pixels differ", 100.0 * share);
    if let Ok(folder) = std::env::var("BOSCAGE_LOOK") {
        for (who, image) in [("gpu", &card), ("cpu", &twin)] {
            let png = encode_png(image, Default::default());
            std::fs::write(format!("{folder}/{name}_{who}.png"), png).unwrap();
        }
    }
    assert!(share <= 0.005, "{name}: {share}");
    let opaque = twin
        .pixels()
        .iter()
        .filter(|pixel| pixel.alpha() > 0)
        .count();
    assert!(opaque > 1000, "{name}: nothing was drawn");
}

fn settings() -> RenderSettings {
    RenderSettings {
        size: (512, 512),
        fineness: 1,
        ..RenderSettings::default()
    }
}

fn with_view(camera: &Camera, backdrop: Backdrop, draw: impl FnOnce(&SceneView<'_>)) {
    draw(&SceneView {
        crowns: &prepared(),
        instances: &[CrownInstance::plain(0)],
        meshes: &[],
        leaves: &LeafSet::default(),
        camera,
        light: &Light::default(),
        backdrop,
    });
}

fn twins_agree_on_relief(gpu: &Gpu) {
    for (name, yaw, pitch, distance) in [
        ("front", 0.0, 0.0, 1.0),
        ("side", 90.0, 15.0, 1.0),
        ("top", 30.0, 85.0, 1.0),
        ("far", 200.0, -20.0, 12.0),
        ("near", 45.0, 10.0, 0.3),
    ] {
        let camera = front().orbited(yaw, pitch).zoomed(distance);
        with_view(&camera, Backdrop::Sky, |view| {
            assert_twins_agree(name, gpu, view, &settings());
        });
    }
    let fine = RenderSettings {
        fineness: 2,
        size: (256, 256),
        ..settings()
    };
    with_view(&front(), Backdrop::Clear, |view| {
        assert_twins_agree("fine", gpu, view, &fine);
    });
}

fn twins_agree_on_leaves(gpu: &Gpu) {
    for (name, clip, mode, distance) in [
        ("leaves", LeafClip::Center, Mode::Leaves, 1.0),
        ("leaves_cut", LeafClip::Fragment, Mode::Leaves, 1.0),
        ("leaves_far", LeafClip::Center, Mode::Leaves, 6.0),
        ("leaves_near", LeafClip::Center, Mode::Leaves, 0.4),
        ("leaves_mixed", LeafClip::Center, Mode::Switched, 1.0),
    ] {
        let camera = front().orbited(30.0, 12.0).zoomed(distance);
        let mut settings = RenderSettings { mode, ..settings() };
        settings.leaves.clip = clip;
        let middle = camera.eye_m().distance(DVec3::new(0.4, 5.0, -0.2));
        settings.switch.nearest_m = middle;
        settings.switch.farthest_m = middle;
        with_view(&camera, Backdrop::Studio, |view| {
            assert_twins_agree(name, gpu, view, &settings);
        });
    }
    let mut settings = settings();
    settings.mode = Mode::Leaves;
    for (name, leaf, distance) in [
        ("needles", LeafName::Brush, 1.0),
        ("fronds", LeafName::Frond, 1.0),
        ("fronds_near", LeafName::Frond, 0.5),
        ("fronds_far", LeafName::Frond, 5.0),
        ("boughs", LeafName::Bough, 1.0),
        ("boughs_near", LeafName::Bough, 0.5),
        ("boughs_far", LeafName::Bough, 5.0),
    ] {
        let leaves = LeafSet::new(leaf, Seed(1));
        let camera = front().orbited(30.0, 12.0).zoomed(distance);
        with_view(&camera, Backdrop::Studio, |view| {
            let view = SceneView {
                leaves: &leaves,
                ..*view
            };
            assert_twins_agree(name, gpu, &view, &settings);
        });
    }
}

fn twins_agree_on_meshes(gpu: &Gpu) {
    let crown = lumpy();
    let meshes = [
        PreparedMesh::of_trunk(&Trunk::under(&crown), &crown),
        PreparedMesh::of_crown(&crown, 24),
    ];
    let camera = front().orbited(30.0, 12.0);
    let settings = RenderSettings {
        mode: Mode::Mesh,
        ..settings()
    };
    with_view(&camera, Backdrop::Sky, |view| {
        let view = SceneView {
            meshes: &meshes,
            ..*view
        };
        assert_twins_agree("mesh", gpu, &view, &settings);
        // From within: triangles all around, many of them cut off by the near plane.
        let within = Camera {
            distance_m: 40.0,
            target_m: camera.target_m + camera.axes().forward * 40.4,
            ..camera
        };
        let view = SceneView {
            camera: &within,
            ..view
        };
        assert_twins_agree("mesh_within", gpu, &view, &settings);
    });
}

fn twins_agree_on_every_view(gpu: &Gpu) {
    for view in [View::Steps, View::Normals, View::Depth, View::RadiusError] {
        let settings = RenderSettings { view, ..settings() };
        let name = format!("{view:?}");
        with_view(&front(), Backdrop::Clear, |scene| {
            assert_twins_agree(&name, gpu, scene, &settings);
        });
    }
    let mut thesis = settings();
    thesis.occlusion = Occlusion::Terms;
    for shortcut in [Shortcut::None, Shortcut::Bounded, Shortcut::BinaryOnly] {
        thesis.relief.shortcut = shortcut;
        let name = format!("{shortcut:?}");
        with_view(&front(), Backdrop::Studio, |scene| {
            assert_twins_agree(&name, gpu, scene, &thesis);
        });
    }
}

/// Against the sun, on a stem whose shadow falls towards the eye.
fn twins_agree_against_the_sun(gpu: &Gpu) {
    let crown = lumpy();
    let trunk = Trunk::under(&crown);
    let crowns: Vec<PreparedCrown> = prepared().into_iter().map(|c| c.on_stem(&trunk)).collect();
    let camera = Camera::framing(DVec3::new(0.4, 4.0, -0.2), 6.0, (25.0, 16.0), 1.0);
    let light = Light {
        sun_yaw_deg: 190.0,
        sun_pitch_deg: 25.0,
        ..Light::default()
    };
    for (name, mode) in [("relief", Mode::Relief), ("leaves", Mode::Leaves)] {
        let view = SceneView {
            crowns: &crowns,
            instances: &[CrownInstance::plain(0)],
            meshes: &[PreparedMesh::of_trunk(&trunk, &crown)],
            leaves: &LeafSet::default(),
            camera: &camera,
            light: &light,
            backdrop: Backdrop::Studio,
        };
        let settings = RenderSettings { mode, ..settings() };
        assert_twins_agree(&format!("sun_{name}"), gpu, &view, &settings);
        // The stem's shadow is there: without it some pixels are brighter.
        let without = prepared();
        let bare = SceneView {
            crowns: &without,
            ..view
        };
        let [with, bare] =
            [view, bare].map(|view| renderer(gpu).picture(&view, &settings).unwrap());
        assert!(differing(&with, &bare) > 0.000_5);
    }
}

fn twins_agree_on_a_scene(gpu: &Gpu) {
    let instances: Vec<CrownInstance> = (0..9)
        .map(|i| CrownInstance {
            base_m: DVec3::new(
                f64::from(i % 3) * 4.0 - 4.0,
                0.0,
                f64::from(i / 3) * 4.0 - 4.0,
            ),
            yaw_deg: 40.0 * f64::from(i),
            scale: 0.6 + 0.07 * f64::from(i),
            tint: [1.0, 1.0 - 0.05 * i as f32, 0.9],
            ..CrownInstance::plain(0)
        })
        .collect();
    let view = SceneView {
        crowns: &prepared(),
        instances: &instances,
        meshes: &[],
        leaves: &LeafSet::default(),
        camera: &Camera::framing(DVec3::new(0.0, 4.0, 0.0), 9.0, (20.0, 25.0), 1.0),
        light: &Light::default(),
        backdrop: Backdrop::Studio,
    };
    assert_twins_agree("scene", gpu, &view, &settings());
}

fn proxies_make_one_picture(gpu: &Gpu) {
    with_view(&front().orbited(33.0, 12.0), Backdrop::Clear, |view| {
        let [one, other] = [Proxy::Icosahedron, Proxy::Cube].map(|proxy| {
            let mut renderer = GpuRenderer::new(gpu.clone(), proxy).unwrap();
            renderer.picture(view, &settings()).unwrap()
        });
        assert_eq!(differing(&one, &other), 0.0);
    });
}

fn too_large_a_picture_is_refused(gpu: &Gpu) {
    let most = gpu.longest_side();
    let settings = RenderSettings {
        size: (most, 8),
        fineness: 2,
        ..settings()
    };
    with_view(&front(), Backdrop::Clear, |view| {
        let mut renderer = renderer(gpu);
        let error = renderer.picture(view, &settings).unwrap_err();
        assert!(matches!(error, RenderError::TooLarge { .. }), "{error}");
        // And it draws on.
        assert_eq!(Mode::default(), Mode::Relief);
        assert!(renderer.picture(view, &self::settings()).is_ok());
    });
}

fn a_broken_shader_is_an_error(gpu: &Gpu) {
    let broken = GpuRenderer::with_shaders(gpu.clone(), Proxy::Cube, |_| "no shader".into());
    assert!(broken.is_err());
    assert!(GpuRenderer::new(gpu.clone(), Proxy::Cube).is_ok());
}

/// Draws until the final picture is there; also gives how often.
fn rested(viewport: &mut Viewport, view: &SceneView<'_>, settings: &RenderSettings) -> usize {
    for count in 1..100_000 {
        if viewport.draw(view, settings).unwrap().is_final {
            return count;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    panic!("the picture is never final");
}

/// Fails when the viewport does not show the picture that a renderer without a window draws.
fn assert_shows(
    gpu: &Gpu,
    viewport: &Viewport,
    view: &SceneView<'_>,
    settings: &RenderSettings,
) -> Image<Straight> {
    let expected = renderer(gpu).picture(view, settings).unwrap();
    let shown = viewport.picture().unwrap();
    let pairs = expected.pixels().iter().zip(shown.pixels());
    let apart = pairs
        .filter(|(one, other)| {
            let one = one.premultiplied().0;
            one.iter().zip(other.0).any(|(a, b)| a.abs_diff(b) > 1)
        })
        .count();
    assert_eq!(apart, 0);
    expected
}

fn a_viewport_at_rest_shows_the_final_picture(gpu: &Gpu) {
    let settings = RenderSettings {
        size: (201, 157),
        fineness: 2,
        ..settings()
    };
    let mut viewport = Viewport::new(gpu.clone()).unwrap();
    for (mode, backdrop) in [
        (Mode::Relief, Backdrop::Clear),
        (Mode::Leaves, Backdrop::Sky),
    ] {
        with_view(&front(), backdrop, |view| {
            let settings = RenderSettings { mode, ..settings };
            let first = viewport.draw(view, &settings).unwrap();
            let (generation, was_final) = (first.generation, first.is_final);
            let calls = rested(&mut viewport, view, &settings);
            assert!(was_final || calls > 1);
            assert_shows(gpu, &viewport, view, &settings);
            // And stays.
            let last = viewport.draw(view, &settings).unwrap();
            assert!(last.is_final && last.generation >= generation);
            assert_eq!(last.size, settings.size);
        });
    }
}

fn a_viewport_shows_what_has_changed_of_a_crown(gpu: &Gpu) {
    let settings = RenderSettings {
        size: (120, 120),
        ..settings()
    };
    let mut viewport = Viewport::new(gpu.clone()).unwrap();
    let first = prepared();
    let mut crown = lumpy();
    crown.radius_m = crown.radius_m.map(|radius| radius * 0.8);
    let smaller = vec![first[0].reshaped(&crown)];
    crown.color = crown
        .color
        .map(|&Straight([r, g, b, a])| Straight([b, r, g, a]));
    let red = vec![smaller[0].recolored(&crown)];
    let both = vec![red[0].clone(), first[0].clone()];
    let camera = front();
    let mut last = None;
    for crowns in [&first, &smaller, &red, &both, &first] {
        let view = SceneView {
            crowns,
            instances: &[CrownInstance::plain(0)],
            meshes: &[],
            leaves: &LeafSet::default(),
            camera: &camera,
            light: &Light::default(),
            backdrop: Backdrop::Studio,
        };
        rested(&mut viewport, &view, &settings);
        let picture = assert_shows(gpu, &viewport, &view, &settings);
        let changed = last.replace(picture.clone()) != Some(picture);
        assert_eq!(
            changed,
            !std::ptr::eq(crowns, &both),
            "only the last adds no change"
        );
    }
}

/// A device of its own, and what can be done to it.
fn own_device() -> (wgpu::Device, Gpu) {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default())).unwrap();
    let descriptor = wgpu::DeviceDescriptor::default();
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).unwrap();
    (device.clone(), Gpu::new(device, queue, adapter.get_info()))
}

fn a_lost_device_is_an_error(_: &Gpu) {
    let settings = RenderSettings {
        size: (96, 96),
        ..settings()
    };
    with_view(&front(), Backdrop::Sky, |view| {
        let (device, gpu) = own_device();
        let mut viewport = Viewport::new(gpu.clone()).unwrap();
        viewport.draw(view, &settings).unwrap();
        let mut renderer = renderer(&gpu);
        renderer.picture(view, &settings).unwrap();
        device.destroy();
        for _ in 0..3 {
            let error = viewport.draw(view, &settings).unwrap_err();
            assert!(matches!(error, RenderError::DeviceLost(_)), "{error}");
            assert!(error.is_of_device());
        }
        assert!(viewport.picture().is_err());
        assert!(
            renderer
                .picture(view, &settings)
                .unwrap_err()
                .is_of_device()
        );
        assert!(renderer.drawing_time_ms(view, &settings).is_err());
        assert!(GpuRenderer::new(gpu.clone(), Proxy::Cube).is_err());
        assert!(Viewport::new(gpu).is_err());
        // The processor draws the view that the card cannot.
        let twin = cpu::picture(view, &settings, &Progress::silent(), &Cancel::new()).unwrap();
        assert!(twin.pixels().iter().all(|pixel| pixel.alpha() == 255));
    });
}

/// A copy of the built-in shaders in a folder of its own.
#[cfg(debug_assertions)]
fn folder_of_shaders() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let from = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    std::fs::create_dir(folder.path().join("shared")).unwrap();
    for name in boscage::render::Pass::files() {
        std::fs::copy(from.join(name), folder.path().join(name)).unwrap();
    }
    folder
}

#[cfg(debug_assertions)]
fn changed_shaders_are_taken_and_broken_ones_are_not(gpu: &Gpu) {
    let folder = folder_of_shaders();
    let file = folder.path().join("tone.wgsl");
    let text = std::fs::read_to_string(&file).unwrap();
    // Some file systems tell whole seconds: a time of its own for each change.
    let mut time = std::time::SystemTime::now();
    let mut write = |text: &str| {
        std::fs::write(&file, text).unwrap();
        time += std::time::Duration::from_secs(2);
        std::fs::File::options()
            .write(true)
            .open(&file)
            .and_then(|file| file.set_modified(time))
            .unwrap();
    };
    with_view(&front(), Backdrop::Sky, |view| {
        let mut renderer = renderer(gpu);
        renderer.watch(folder.path());
        let before = renderer.picture(view, &settings()).unwrap();
        assert_eq!(renderer.reload_if_changed(), Ok(false));
        write("no shader");
        let error = renderer.reload_if_changed().unwrap_err();
        assert!(matches!(&error, RenderError::Shader(_)), "{error}");
        assert!(!error.is_of_device());
        assert_eq!(
            renderer.reload_if_changed(),
            Ok(false),
            "it is told of once"
        );
        assert_eq!(renderer.picture(view, &settings()).unwrap(), before);
        let white = "    return toned(vec2<u32>(place.xy));";
        assert!(text.contains(white));
        write(&text.replace(white, "    return vec4(1.0);"));
        assert_eq!(renderer.reload_if_changed(), Ok(true));
        let after = renderer.picture(view, &settings()).unwrap();
        assert!(
            after
                .pixels()
                .iter()
                .all(|&pixel| pixel == Straight([255; 4]))
        );
    });
}
