//! Measurements of the renderer: the forest of the thesis (§7.3, Table 7.2), what proxies and
//! shortcuts save, how alike the two forms of a crown are, and the view of one crown.
//!
//! The thesis' terrain is not to be had. The forest here has as many crowns at the same distances:
//! those that Table 7.2 counts within 50, 100, … 250 m, all others to 1,200 m, on a slope that
//! faces the eye.

use super::super::failure::Failure;
use super::super::session::Session;
use super::row::{Baseline, Row};
use crate::base::{Cancel, Seed};
use crate::geometry::Mesh;
use crate::raster::{Cubemap, Image, Straight};
use crate::render::{
    Backend, Gpu, GpuRenderer, LeafSet, Mode, PreparedCrown, Proxy, ReliefSettings, RenderError,
    RenderSettings, Renderer, SceneView, Shortcut, View, Viewport,
};
use crate::scene::{Backdrop, Camera, Crown, CrownInstance, Light};
use glam::DVec3;
use std::time::{Duration, Instant};

/// Distance, crowns within it, and what the thesis took with leaves up to there (Table 7.2).
const TABLE: [(f64, usize, f64, &str); 6] = [
    (0.0, 0, 21.0, "forest, relief only"),
    (50.0, 97, 20.7, "forest, leaves within 50 m"),
    (100.0, 678, 25.2, "forest, leaves within 100 m"),
    (150.0, 1347, 26.7, "forest, leaves within 150 m"),
    (200.0, 2318, 27.8, "forest, leaves within 200 m"),
    (250.0, 3477, 28.4, "forest, leaves within 250 m"),
];

/// Crowns of the forest, and how far it reaches, metres.
const CROWNS: usize = 27_424;
const REACH_M: f64 = 1_200.0;

/// Runs of a measurement on a card, and on a program that plays one.
const RUNS: [usize; 2] = [15, 2];

/// Pictures of the forest: that of the thesis, and a ninth of it for a program that plays a card.
/// Ratios say the same on both.
const FOREST_SIZES: [(u32, u32); 2] = [(1920, 1080), (640, 360)];

/// What is drawn: one crown, alone or many times.
struct Stand {
    crowns: [PreparedCrown; 1],
    leaves: LeafSet,
    forest: Vec<CrownInstance>,
}

/// All measurements; none, with a warning, where there is no graphics card.
pub(super) fn rows(session: &Session<'_>) -> Result<Vec<Row>, Failure> {
    let cancel = session.cancel;
    let stand = Stand::new(cancel)?;
    let mut rows = stand.coverage_rows(cancel)?;
    rows.extend(stand.switch_rows(cancel)?);
    rows.extend(stand.read_rows(cancel)?);
    match Gpu::offscreen() {
        Ok(gpu) => rows.extend(stand.time_rows(&gpu, cancel)?),
        Err(error) => session
            .progress
            .warn(&format!("{error}: drawing is not timed")),
    }
    Ok(rows)
}

impl Stand {
    fn new(cancel: &Cancel) -> Result<Self, Failure> {
        Ok(Self {
            crowns: [PreparedCrown::new(&lumpy(), cancel)?],
            leaves: LeafSet::default(),
            forest: forest(),
        })
    }

    fn view<'a>(&'a self, instances: &'a [CrownInstance], camera: &'a Camera) -> SceneView<'a> {
        SceneView {
            crowns: &self.crowns,
            instances,
            meshes: &[],
            leaves: &self.leaves,
            camera,
            light: &LIGHT,
            backdrop: Backdrop::Clear,
        }
    }

    /// How alike the forms are at the distance where they change.
    fn coverage_rows(&self, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
        let tree = [CrownInstance::plain(0)];
        let camera = Camera {
            distance_m: 100.0,
            ..eye_on_tree()
        };
        let view = self.view(&tree, &camera);
        let [relief, leaves] = [Mode::Relief, Mode::Leaves].map(|mode| {
            let settings = RenderSettings {
                mode,
                size: (480, 480),
                ..RenderSettings::default()
            };
            on_processor(&view, &settings, cancel)
        });
        let (relief, leaves) = (relief?, leaves?);
        let pairs = || relief.pixels().iter().zip(leaves.pixels());
        let sum = |share: fn(u8, u8) -> u8| -> f64 {
            pairs()
                .map(|(r, l)| f64::from(share(r.alpha(), l.alpha())))
                .sum()
        };
        let both = sum(u8::min);
        Ok(vec![
            Row::number(
                "leaves against relief, 100 m",
                both / sum(|_, l| l),
                "precision",
            ),
            Row::number(
                "leaves against relief, 100 m",
                both / sum(|r, _| r),
                "recall",
            ),
            Row::number("leaves against relief, 100 m", both / sum(u8::max), "IoU"),
        ])
    }

    /// What changes from picture to picture on the way through the switch.
    fn switch_rows(&self, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
        let changes = self.switch_changes(cancel)?;
        let name = "most change at the switch, its neighbours 1";
        Ok(vec![Row::number(name, changes.ratio(), "ratio")])
    }

    /// A turntable that moves away through the switch: how much each picture differs from the one
    /// before, at the switch and around it.
    fn switch_changes(&self, cancel: &Cancel) -> Result<Changes, Failure> {
        let tree = [CrownInstance::plain(0)];
        let mut settings = RenderSettings {
            mode: Mode::Switched,
            size: (160, 160),
            ..RenderSettings::default()
        };
        // A crown that changes half-way between 100 m and 200 m, over a stretch of 25 m.
        let middle = 0.5 * (settings.switch.nearest_m + settings.switch.farthest_m);
        settings.switch.nearest_m = middle;
        settings.switch.farthest_m = middle;
        let mut changes = Changes::default();
        let mut last: Option<Image<Straight>> = None;
        for step in 0..SWITCH_PICTURES {
            let share = f64::from(step) / f64::from(SWITCH_PICTURES - 1);
            let camera = Camera {
                distance_m: middle + (share - 0.5) * 3.0 * settings.switch.band_m,
                fov_y_deg: 8.0,
                ..eye_on_tree()
            };
            let camera = camera.orbited(2.0 * f64::from(step), 0.0);
            let picture = on_processor(&self.view(&tree, &camera), &settings, cancel)?;
            if let Some(last) = &last {
                // The stretch of both forms is the middle third.
                let is_at_switch =
                    (share - 0.5).abs() < 1.0 / 6.0 + 0.5 / f64::from(SWITCH_PICTURES);
                changes.add(is_at_switch, mean_change(last, &picture));
            }
            last = Some(picture);
        }
        Ok(changes)
    }

    /// Reads of the radius cubemap for a covered pixel, which depend on no machine.
    fn read_rows(&self, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
        let tree = [CrownInstance::plain(0)];
        let camera = eye_on_tree();
        let view = self.view(&tree, &camera);
        let names = [
            (Shortcut::None, "a ray without shortcuts"),
            (Shortcut::Bounded, "a ray between R_min and R_max"),
            (Shortcut::BinaryOnly, "a ray, R_min without linear steps"),
        ];
        names
            .into_iter()
            .map(|(shortcut, name)| {
                let relief = ReliefSettings {
                    shortcut,
                    ..ReliefSettings::default()
                };
                let settings = RenderSettings {
                    view: View::Steps,
                    size: (400, 400),
                    fineness: 1,
                    relief,
                    ..RenderSettings::default()
                };
                let picture = on_processor(&view, &settings, cancel)?;
                Ok(Row::number(name, mean_reads(&picture, &relief), "reads"))
            })
            .collect()
    }

    /// What a card takes.
    fn time_rows(&self, gpu: &Gpu, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
        let size = FOREST_SIZES[usize::from(gpu.is_software())];
        let height = f64::from(size.1);
        let mut rows = vec![Row::number(
            "height of the forest's pictures",
            height,
            "pixels",
        )];
        let eye = eye_on_forest();
        let forest = self.view(&self.forest, &eye);
        let mut renderer = GpuRenderer::new(gpu.clone(), Proxy::Icosahedron)?;
        for (distance, _, thesis_ms, name) in TABLE {
            let mut settings = forest_settings(gpu, Shortcut::Bounded);
            if distance > 0.0 {
                settings.mode = Mode::Switched;
                settings.switch.nearest_m = distance;
                settings.switch.farthest_m = distance;
                settings.switch.band_m = 1.0;
            }
            let row = timed(name, &mut renderer, &forest, &settings, cancel)?;
            rows.push(row.against(Baseline {
                what: "Argudo (2014), GTX 860M",
                ms: thesis_ms,
            }));
        }
        rows.extend(proxy_rows(gpu, &forest, cancel)?);
        let tree = [CrownInstance::plain(0)];
        let camera = eye_on_tree();
        let alone = self.view(&tree, &camera);
        for (name, mode, relief) in [
            (
                "one crown, 800x800, in motion",
                Mode::Relief,
                ReliefSettings::quick(),
            ),
            (
                "one crown, 800x800, at rest",
                Mode::Relief,
                ReliefSettings::default(),
            ),
            (
                "one leaf crown, 800x800",
                Mode::Leaves,
                ReliefSettings::default(),
            ),
        ] {
            let settings = RenderSettings {
                mode,
                relief,
                fineness: 1,
                ..RenderSettings::default()
            };
            rows.push(timed(name, &mut renderer, &alone, &settings, cancel)?.target(16.6));
        }
        for dragged in [
            (
                Mode::Relief,
                ["one crown, 800x800, dragged", "one crown, dragged, drawn"],
            ),
            (
                Mode::Leaves,
                [
                    "one leaf crown, 800x800, dragged",
                    "one leaf crown, dragged, drawn",
                ],
            ),
        ] {
            rows.extend(dragged_rows(gpu, &alone, dragged, cancel)?);
        }
        Ok(rows)
    }
}

const LIGHT: Light = Light::DAY;

/// Pictures on the way through the switch.
const SWITCH_PICTURES: u32 = 31;

/// How much pictures differ from the ones before them, in values of 255.
#[derive(Debug, Default)]
struct Changes {
    /// The most while both forms are drawn.
    at_switch: f64,
    /// The most before and after.
    around: f64,
}

impl Changes {
    fn add(&mut self, is_at_switch: bool, change: f64) {
        let most = match is_at_switch {
            true => &mut self.at_switch,
            false => &mut self.around,
        };
        *most = most.max(change);
    }

    /// The most at the switch for the most around it.
    fn ratio(&self) -> f64 {
        self.at_switch / self.around
    }
}

/// Mean difference of two pictures, in values of 255.
fn mean_change(one: &Image<Straight>, other: &Image<Straight>) -> f64 {
    let pairs = one.pixels().iter().zip(other.pixels());
    let values = pairs.flat_map(|(a, b)| a.premultiplied().0.into_iter().zip(b.premultiplied().0));
    let sum: u64 = values.map(|(a, b)| u64::from(a.abs_diff(b))).sum();
    sum as f64 / (4 * one.pixels().len()) as f64
}

/// Views of a dragged window, and calls at most until one has landed.
const DRAGGED: u32 = 40;
const MOST_LOOKS: u32 = 20_000;

/// A window of 800×800 whose view is dragged around a crown, once the pace is found: the time of a
/// picture and the share of its sides that is drawn.
fn dragged_rows(
    gpu: &Gpu,
    view: &SceneView<'_>,
    (mode, names): (Mode, [&'static str; 2]),
    cancel: &Cancel,
) -> Result<[Row; 2], Failure> {
    let mut viewport = Viewport::new(gpu.clone())?;
    let settings = RenderSettings {
        mode,
        ..RenderSettings::default()
    };
    let mut times = Vec::new();
    let mut widths = 0;
    for step in 0..DRAGGED {
        cancel.check()?;
        let camera = view.camera.orbited(2.0 * f64::from(step), 0.0);
        let start = Instant::now();
        let moved = SceneView {
            camera: &camera,
            ..*view
        };
        let (width, _) = viewport.draw(&moved, &settings)?.size;
        for _ in 0..MOST_LOOKS {
            if viewport.is_idle()? {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        if step >= DRAGGED / 2 {
            times.push(start.elapsed().as_secs_f64() * 1e3);
            widths += width;
        }
    }
    let share = f64::from(widths) / (times.len() as f64 * f64::from(settings.size.0));
    let time = Row::of_times(names[0], times).target(1e3 / 15.0);
    Ok([time, Row::number(names[1], share, "of the sides")])
}

/// The forest with each proxy, with and without shortcuts.
fn proxy_rows(gpu: &Gpu, forest: &SceneView<'_>, cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    let kinds = [
        (
            Proxy::Icosahedron,
            Shortcut::None,
            "forest, icosahedron, no shortcut",
            12.9,
        ),
        (
            Proxy::Icosahedron,
            Shortcut::Bounded,
            "forest, icosahedron, bounded",
            12.5,
        ),
        (
            Proxy::Icosahedron,
            Shortcut::BinaryOnly,
            "forest, icosahedron, binary only",
            12.5,
        ),
        (
            Proxy::Cube,
            Shortcut::None,
            "forest, cube, no shortcut",
            15.4,
        ),
        (
            Proxy::Cube,
            Shortcut::Bounded,
            "forest, cube, bounded",
            12.8,
        ),
    ];
    for (proxy, shortcut, name, ms) in kinds {
        let mut renderer = GpuRenderer::new(gpu.clone(), proxy)?;
        let row = timed(
            name,
            &mut renderer,
            forest,
            &forest_settings(gpu, shortcut),
            cancel,
        )?;
        rows.push(row.against(Baseline {
            what: "Argudo (2014), 22,000 crowns",
            ms,
        }));
    }
    Ok(rows)
}

/// The picture of the forest, one sample a pixel.
fn forest_settings(gpu: &Gpu, shortcut: Shortcut) -> RenderSettings {
    let mut settings = RenderSettings {
        size: FOREST_SIZES[usize::from(gpu.is_software())],
        fineness: 1,
        ..RenderSettings::default()
    };
    settings.relief.shortcut = shortcut;
    settings
}

fn timed(
    name: &'static str,
    renderer: &mut GpuRenderer,
    view: &SceneView<'_>,
    settings: &RenderSettings,
    cancel: &Cancel,
) -> Result<Row, Failure> {
    let software = renderer.gpu().is_software();
    let runs = RUNS[usize::from(software)];
    if !software {
        renderer.drawing_time_ms(view, settings)?;
    }
    let mut times = Vec::with_capacity(runs);
    for _ in 0..runs {
        cancel.check()?;
        times.push(renderer.drawing_time_ms(view, settings)?);
    }
    Ok(Row::of_times(name, times))
}

fn on_processor(
    view: &SceneView<'_>,
    settings: &RenderSettings,
    cancel: &Cancel,
) -> Result<Image<Straight>, RenderError> {
    Renderer::new(Backend::Cpu)?.picture(view, settings, cancel)
}

/// The mean of what [`View::Steps`] shows, over all pixels that the crown covers.
fn mean_reads(picture: &Image<Straight>, relief: &ReliefSettings) -> f64 {
    let covered = picture.pixels().iter().filter(|pixel| pixel.alpha() > 0);
    let (mut sum, mut count) = (0.0, 0.0);
    for pixel in covered {
        let value = f64::from(pixel.0[0]) / 255.0;
        // sRGB to linear.
        sum += libm::pow((value + 0.055) / 1.055, 2.4);
        count += 1.0;
    }
    sum / f64::max(count, 1.0) * f64::from(relief.most_steps + relief.halvings)
}

/// A crown of waves of several lengths, as uneven as a made one.
fn lumpy() -> Crown {
    let relief = |d: DVec3| {
        let wave = |count: f64, x: f64, phase: f64| libm::sin(x * count + phase);
        let kinds = [(4.0, 0.35), (9.0, 0.3), (23.0, 0.2), (47.0, 0.15)];
        let waves = kinds.iter().map(|&(count, weight)| {
            weight * wave(count, d.x, 1.0) * wave(count, d.y, 2.0 + count) * wave(count, d.z, 4.0)
        });
        waves.sum::<f64>()
    };
    let color = |d: DVec3| {
        let light = 0.8 + 0.5 * relief(d);
        let [r, g, b] = [95.0, 125.0, 60.0].map(|c| (c * light).clamp(0.0, 255.0) as u8);
        Straight([r, g, b, 255])
    };
    Crown {
        center_m: DVec3::new(0.0, 6.5, 0.0),
        radius_m: Cubemap::from_directions(256, |d| {
            let d = d.normalize();
            (4.0 * (1.0 - 0.15 * d.y) * (1.0 + 0.4 * relief(d))) as f32
        }),
        color: Cubemap::from_directions(256, |d| color(d.normalize())),
        height: Cubemap::filled(256, 0.5),
        base_mesh: Mesh::default(),
        cover: 1.0,
        stem: None,
    }
}

fn eye_on_tree() -> Camera {
    Camera::framing(DVec3::new(0.0, 6.5, 0.0), 5.2, (20.0, 8.0), 1.0)
}

/// From the foot of the slope, looking up it.
fn eye_on_forest() -> Camera {
    Camera {
        target_m: DVec3::new(0.0, 60.0, -400.0),
        distance_m: 400.0,
        yaw_deg: 0.0,
        pitch_deg: 0.0,
        fov_y_deg: 45.0,
    }
}

/// The crowns of the forest, within the view of [`eye_on_forest`].
fn forest() -> Vec<CrownInstance> {
    let eye = eye_on_forest().eye_m();
    let mut random = Seed(0).derive("bench forest", 0).random();
    let bands = TABLE.map(|(distance, count, ..)| (distance, count));
    let mut crowns = Vec::with_capacity(CROWNS);
    for index in 0..CROWNS {
        let far = bands.iter().position(|(_, count)| index < *count);
        let (low, high) = far.map_or((250.0, REACH_M), |far| (bands[far - 1].0, bands[far].0));
        // As many crowns for every piece of ground.
        let share = random.unit();
        let distance = (low * low + (high * high - low * low) * share)
            .sqrt()
            .max(8.0);
        let angle = random.between(-0.6, 0.6);
        let flat = DVec3::new(libm::sin(angle), 0.0, -libm::cos(angle)) * distance;
        let height = eye.y - 22.0 + 0.16 * distance;
        crowns.push(CrownInstance {
            base_m: DVec3::new(eye.x, height, eye.z) + flat,
            yaw_deg: random.between(0.0, 360.0),
            scale: random.between(0.7, 1.2),
            switch_at: random.unit(),
            ..CrownInstance::plain(0)
        });
    }
    crowns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_pops_on_a_turntable_that_moves_through_the_switch() {
        let cancel = Cancel::new();
        let changes = Stand::new(&cancel)
            .unwrap()
            .switch_changes(&cancel)
            .unwrap();
        assert!(changes.around > 0.1, "the tree turns");
        assert!(changes.ratio() < 1.3, "{changes:?}");
    }

    #[test]
    fn the_forest_has_as_many_crowns_at_each_distance_as_the_thesis() {
        let forest = forest();
        assert_eq!(forest.len(), CROWNS);
        let eye = eye_on_forest().eye_m();
        for (distance, count, ..) in TABLE {
            let within = forest.iter().filter(|tree| {
                let offset = tree.base_m - eye;
                DVec3::new(offset.x, 0.0, offset.z).length() < distance
            });
            assert_eq!(within.count(), count, "{distance} m");
        }
    }
}
