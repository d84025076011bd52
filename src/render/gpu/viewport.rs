//! A scene in a window: drawn into a texture on the window's own device, which the window samples.
//!
//! While the scene changes each picture is drawn at once, as finely as the card can in time (see
//! [`crate::render::pace`]). Once it rests the final picture is made in parts, one a call, and shown
//! when it is whole. Nothing waits for the card: while it works, the last picture is shown on.
//!
//! A texture of a changed crown is written over the old one; what has not changed stays on the card.

use super::lists::Lists;
use super::target::Target;
use super::{Ending, Gpu, GpuRenderer, Part};
use crate::base::Digest;
use crate::raster::{Image, Premultiplied};
use crate::render::frame::{CrownNumbers, Frame, SceneView};
use crate::render::pace::{Pace, Portion};
use crate::render::{Proxy, RenderError, RenderSettings};
use crate::scene::CrownInstance;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// Draws a scene for a window.
///
/// It takes over the device's handlers of errors and of loss, which would else end the program: one
/// viewport a device.
#[derive(Debug)]
pub struct Viewport {
    renderer: GpuRenderer,
    /// The picture in motion, and the final one.
    moving: Option<Target>,
    resting: Option<Target>,
    /// Whether the final picture is shown.
    shows_resting: bool,
    /// Counts the textures that were shown.
    generation: u64,
    /// What was drawn last.
    scene: Option<Scene>,
    refining: Refining,
    pace: Pace,
    portion: Portion,
    flight: Option<Flight>,
}

/// What a window shows of a scene.
#[derive(Debug)]
pub struct Shown<'a> {
    /// A picture of the format `Rgba8Unorm`: sRGB values times alpha, as egui wants them. Sample it
    /// linearly: it may be smaller than what was asked for.
    pub picture: &'a wgpu::TextureView,
    /// Its width and height, pixels.
    pub size: (u32, u32),
    /// Another number when `picture` is another texture than before.
    pub generation: u64,
    /// Whether this is the final picture of the scene. If not, draw again soon.
    pub is_final: bool,
}

impl Shown<'_> {
    /// How the picture is to be sampled.
    pub const FILTER: wgpu::FilterMode = wgpu::FilterMode::Linear;
}

/// How far the final picture is.
#[derive(Debug)]
enum Refining {
    /// Nothing of it is there.
    Begins,
    /// So many rows of samples are there.
    Goes(Box<Lists>, u32),
    /// It is there.
    Done,
}

/// Work that was handed to the card.
#[derive(Debug)]
struct Flight {
    /// Milliseconds, once it is done.
    took_ms: Arc<Mutex<Option<f64>>>,
    is_part: bool,
}

impl Flight {
    /// How long it took, milliseconds, once it is done.
    fn ms(&self) -> Option<f64> {
        let took = self.took_ms.lock();
        *took.unwrap_or_else(PoisonError::into_inner)
    }
}

/// All that a picture depends on.
#[derive(Debug, PartialEq)]
struct Scene {
    frame: Frame,
    settings: RenderSettings,
    instances: Vec<CrownInstance>,
    crowns: Vec<(Digest, Digest, CrownNumbers)>,
    meshes: Vec<Digest>,
    leaves: Digest,
}

impl Scene {
    fn new(view: &SceneView<'_>, settings: &RenderSettings) -> Self {
        let crowns = view.crowns.iter();
        Self {
            frame: Frame::new(view, settings),
            settings: *settings,
            instances: view.instances.to_vec(),
            crowns: crowns
                .map(|crown| {
                    let numbers = CrownNumbers::new(crown);
                    (crown.radius_digest, crown.surface_digest, numbers)
                })
                .collect(),
            meshes: view.meshes.iter().map(|mesh| mesh.digest).collect(),
            leaves: view.leaves.digest,
        }
    }
}

impl Viewport {
    /// A viewport on the device of a window.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`] when the card refuses a shader, [`RenderError::OutOfMemory`].
    pub fn new(gpu: Gpu) -> Result<Self, RenderError> {
        let is_software = gpu.is_software();
        Ok(Self {
            renderer: GpuRenderer::new(gpu, Proxy::default())?,
            moving: None,
            resting: None,
            shows_resting: false,
            generation: 0,
            scene: None,
            refining: Refining::Begins,
            pace: Pace::new(is_software),
            portion: Portion::new(is_software),
            flight: None,
        })
    }

    /// The card.
    pub fn gpu(&self) -> &Gpu {
        self.renderer.gpu()
    }

    /// Draws a scene, or some more of it, and gives what can be shown now.
    ///
    /// `settings` are those of the final picture. Call it once for each picture of the window.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`], [`RenderError::OutOfMemory`], [`RenderError::TooLarge`]. Show the
    /// scene as [`crate::render::cpu`] draws it then; a lost device stays lost.
    pub fn draw(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
    ) -> Result<Shown<'_>, RenderError> {
        let gpu = self.gpu().clone();
        let done = gpu.guarded(|| self.advance(view, settings));
        if let Err(error) = done {
            self.forget();
            return Err(error);
        }
        self.shown()
            .ok_or_else(|| RenderError::DeviceLost("nothing was drawn".to_owned()))
    }

    /// As [`GpuRenderer::reload_if_changed`]; the next call of [`Viewport::draw`] draws anew.
    ///
    /// # Errors
    /// As there.
    pub fn reload_if_changed(&mut self) -> Result<bool, RenderError> {
        let changed = self.renderer.reload_if_changed()?;
        if changed {
            self.scene = None;
        }
        Ok(changed)
    }

    /// Whether the card has done all that it was given; does not wait.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`].
    pub fn is_idle(&self) -> Result<bool, RenderError> {
        self.gpu().poll()?;
        Ok(self
            .flight
            .as_ref()
            .is_none_or(|flight| flight.ms().is_some()))
    }

    /// Brings what is shown back from the card, and waits for it: for tests, or a copy to keep. What
    /// is shown is final only where [`Shown::is_final`] says so.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`], also when nothing was drawn; [`RenderError::OutOfMemory`].
    pub fn picture(&self) -> Result<Image<Premultiplied>, RenderError> {
        let target = self
            .target()
            .ok_or_else(|| RenderError::DeviceLost("nothing was drawn".to_owned()))?;
        let pixels = self.gpu().guarded(|| target.read(self.gpu()))?;
        // The window's picture is multiplied by alpha, unlike one for a file.
        Ok(pixels.map(|pixel| Premultiplied(pixel.0)))
    }

    /// What can be shown, if anything was drawn.
    fn shown(&self) -> Option<Shown<'_>> {
        self.target().map(|target| Shown {
            picture: &target.shown,
            size: target.size(),
            generation: self.generation,
            is_final: matches!(self.refining, Refining::Done) && self.flight.is_none(),
        })
    }

    /// What is shown.
    fn target(&self) -> Option<&Target> {
        match self.shows_resting {
            true => self.resting.as_ref(),
            false => self.moving.as_ref(),
        }
    }

    /// Relies on nothing that is on the card.
    fn forget(&mut self) {
        self.renderer.kept = Default::default();
        (self.moving, self.resting) = (None, None);
        self.scene = None;
        self.flight = None;
        self.refining = Refining::Begins;
    }

    /// Takes note of work that is done, and hands the next over.
    fn advance(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
    ) -> Result<(), RenderError> {
        self.gpu().poll()?;
        if !self.has_landed(settings) {
            return Ok(());
        }
        let scene = Scene::new(view, settings);
        if self.scene.as_ref() != Some(&scene) {
            self.draw_moving(view, settings)?;
            self.scene = Some(scene);
            return Ok(());
        }
        match std::mem::replace(&mut self.refining, Refining::Done) {
            Refining::Done => Ok(()),
            Refining::Begins => {
                let lists = self.renderer.lists(view, settings);
                self.refine(settings, Box::new(lists), 0)
            }
            Refining::Goes(lists, rows) => self.refine(settings, lists, rows),
        }
    }

    /// Whether the card has nothing to do; learns from what it has done.
    fn has_landed(&mut self, settings: &RenderSettings) -> bool {
        let Some(flight) = &self.flight else {
            return true;
        };
        let Some(ms) = flight.ms() else {
            return false;
        };
        if flight.is_part {
            self.portion.record(ms);
        } else {
            self.pace.record(ms, settings);
        }
        self.flight = None;
        true
    }

    /// The scene as finely as there is time for.
    fn draw_moving(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
    ) -> Result<(), RenderError> {
        let moving = self.pace.settings(settings);
        let lists = self.renderer.lists(view, &moving);
        let old = self.moving.take();
        let was_shown = old.is_some() && !self.shows_resting;
        let reused = old.as_ref().is_some_and(|old| old.fits(&moving));
        let target = self.renderer.fitting(old, &moving)?;
        let whole = Part {
            rows: 0..target.rows(),
            is_first: true,
            ending: Some(Ending::Window),
        };
        self.hand_over(&target, &lists, &whole, false);
        self.moving = Some(target);
        self.generation += u64::from(!(was_shown && reused));
        self.shows_resting = false;
        self.refining = match self.pace.is_final() {
            true => Refining::Done,
            false => Refining::Begins,
        };
        Ok(())
    }

    /// The next part of the final picture, after so many rows.
    fn refine(
        &mut self,
        settings: &RenderSettings,
        lists: Box<Lists>,
        first: u32,
    ) -> Result<(), RenderError> {
        let old = self.resting.take();
        let target = self.renderer.fitting(old, settings)?;
        let end = (first + self.portion.rows(target.rows())).min(target.rows());
        let is_last = end == target.rows();
        let part = Part {
            rows: first..end,
            is_first: first == 0,
            ending: is_last.then_some(Ending::Window),
        };
        self.hand_over(&target, &lists, &part, true);
        self.resting = Some(target);
        if is_last {
            self.shows_resting = true;
            self.generation += 1;
        } else {
            self.refining = Refining::Goes(lists, end);
        }
        Ok(())
    }

    /// Gives work to the card, and looks at the clock when it is done.
    fn hand_over(&mut self, target: &Target, lists: &Lists, part: &Part, is_part: bool) {
        let took_ms = Arc::new(Mutex::new(None));
        let told = Arc::clone(&took_ms);
        let start = Instant::now();
        self.renderer.draw_part(target, lists, part, None);
        let queue = &self.renderer.gpu.queue;
        queue.on_submitted_work_done(move || {
            let ms = start.elapsed().as_secs_f64() * 1e3;
            *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(ms);
        });
        self.flight = Some(Flight { took_ms, is_part });
    }
}
