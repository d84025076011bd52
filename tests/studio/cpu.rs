//! The studio's window as the processor draws it, beside the same frames drawn through wgpu.

use crate::window;
use boscage::app::{Action, Canvas, Command, Gesture, Shell, Textures, Workspace};
use boscage::document::{CrownSettings, Edit};
use eframe::egui_wgpu::RendererOptions;
use egui::epaint::textures::TexturesDelta;
use egui::{Context, FullOutput};
use egui_kittest::wgpu::{WgpuTestRenderer, create_render_state, default_wgpu_setup};
use egui_kittest::{Harness, TestRenderer};
use image::RgbaImage;
use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};
use window::{Window, open_sample, wait};

/// Share of the pixels that must be the same, but for [`SHADES`].
const SAME: f64 = 0.995;

/// How much a channel may differ in them: rounding, layer by layer.
const SHADES: u8 = 2;

/// What the processor drew, and how long that took.
#[derive(Default)]
struct Drawn {
    canvas: Canvas,
    took: Duration,
}

/// Draws each frame twice. The studio is not told of a card: all that it shows are textures of egui.
struct Both {
    card: WgpuTestRenderer,
    textures: Textures,
    drawn: Rc<RefCell<Drawn>>,
}

impl TestRenderer for Both {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut own = delta.clone();
        self.textures.set(&mut own);
        self.textures.free(&mut own);
        self.card.handle_delta(delta);
    }

    fn render(&mut self, ctx: &Context, output: &FullOutput) -> Result<RgbaImage, String> {
        let scale = ctx.pixels_per_point();
        let size = ctx.content_rect().size() * scale;
        let size = (size.x.round() as u32, size.y.round() as u32);
        let primitives = ctx.tessellate(output.shapes.clone(), scale);
        let begun = Instant::now();
        let mut drawn = self.drawn.borrow_mut();
        let ground = 0xff00_0000;
        drawn.canvas = Canvas::default();
        drawn
            .canvas
            .draw(size, scale, &primitives, &self.textures, ground);
        drawn.took = begun.elapsed();
        self.card.render(ctx, output)
    }
}

fn window_of_both(density: f32) -> (Window, Rc<RefCell<Drawn>>, tempfile::TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let recovery = folder.path().join("recovery");
    let drawn = Rc::new(RefCell::new(Drawn::default()));
    // As the studio's window has it, but for the noise.
    let options = RendererOptions {
        dithering: false,
        ..RendererOptions::default()
    };
    let state = create_render_state(default_wgpu_setup(), options);
    let both = Both {
        card: WgpuTestRenderer::from_render_state(state),
        textures: Textures::default(),
        drawn: Rc::clone(&drawn),
    };
    let window = Harness::builder()
        .with_size([1440.0, 900.0])
        .with_pixels_per_point(density)
        .with_max_steps(64)
        .renderer(both)
        .build_eframe(move |creation| Shell::new(creation, recovery, Vec::new()));
    (window, drawn, folder)
}

/// Draws a frame on both and compares.
fn compare(window: &mut Window, drawn: &RefCell<Drawn>, name: &str) {
    let card = window.render().unwrap();
    let drawn = drawn.borrow();
    assert_eq!(card.dimensions(), drawn.canvas.size());
    let mut most = 0;
    let mut same = 0;
    for (one, other) in card.pixels().zip(drawn.canvas.pixels()) {
        let [_, red, green, blue] = other.to_be_bytes();
        let apart = one.0.iter().zip([red, green, blue]);
        let apart = apart.map(|(a, b)| a.abs_diff(b)).max().unwrap();
        most = most.max(apart);
        same += usize::from(apart <= SHADES);
    }
    let share = same as f64 / drawn.canvas.pixels().len() as f64;
    println!("{name}: {share:.5} the same, most {most}, {:?}", drawn.took);
    if let Some(folder) = std::env::var_os("BOSCAGE_PICTURES") {
        let (width, height) = drawn.canvas.size();
        let bytes = drawn.canvas.pixels().iter().flat_map(|pixel| {
            let [_, red, green, blue] = pixel.to_be_bytes();
            [red, green, blue, 255]
        });
        let picture = RgbaImage::from_raw(width, height, bytes.collect()).unwrap();
        let path = |by: &str| std::path::Path::new(&folder).join(format!("{name}-{by}.png"));
        picture.save(path("cpu")).unwrap();
        card.save(path("card")).unwrap();
    }
    assert!(share >= SAME, "{name}: {share} of the pixels are the same");
}

fn act(window: &mut Window, action: Action) {
    window.state_mut().studio_mut().act(action);
    window.step();
}

#[test]
fn the_processor_draws_the_window_as_a_card_does() {
    if boscage::render::Gpu::offscreen().is_err() {
        eprintln!("left out: there is no adapter to compare with");
        return;
    }
    let (mut window, drawn, _folder) = window_of_both(1.0);
    compare(&mut window, &drawn, "start");
    open_sample(&mut window);
    act(&mut window, Action::TourSeen);
    // A crown that is soon made.
    let settings = CrownSettings {
        size: 64,
        ..CrownSettings::default()
    };
    let id = window.state().studio().shown().unwrap();
    let small = Action::Edit {
        label: "Test",
        edit: Edit::SetCrown(id, Box::new(settings)),
        gesture: Gesture::Whole,
    };
    act(&mut window, small);
    wait(&mut window, |shell| shell.studio().shown_crown().is_some());
    compare(&mut window, &drawn, "crown");
    act(&mut window, Action::Do(Command::ToggleTheme));
    act(&mut window, Action::Do(Command::ZoomIn));
    act(&mut window, Action::Do(Command::Palette));
    // The first frame only measures it.
    for _ in 0..3 {
        window.step();
    }
    compare(&mut window, &drawn, "palette");
    act(&mut window, Action::Do(Command::Palette));
    for (workspace, name) in [
        (Workspace::Variations, "variations"),
        (Workspace::Library, "library"),
    ] {
        act(&mut window, Action::Workspace(workspace));
        for _ in 0..8 {
            window.step();
        }
        compare(&mut window, &drawn, name);
    }
}
