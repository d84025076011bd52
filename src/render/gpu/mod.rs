//! The renderer for graphics cards.
//!
//! A picture is light and depth of all its samples first (backdrop, then crowns, nearest wins) and
//! becomes colours at the end (tone). Crowns go to the card once and stay there as long as they
//! are drawn. Nothing here panics when the card does what cards do: see [`Gpu`].

mod context;
mod crown;
mod kept;
mod layouts;
mod leaves;
mod lists;
mod pipelines;
mod target;
mod timer;
mod viewport;
#[cfg(debug_assertions)]
mod watch;

use super::RenderError;
use super::frame::SceneView;
use super::proxy::Proxy;
use super::settings::RenderSettings;
use super::shaders::Pass;
use crate::raster::{Image, Straight};
use kept::Kept;
use layouts::Layouts;
use lists::{Instances, Lists};
use pipelines::Pipelines;
use std::borrow::Cow;
#[cfg(debug_assertions)]
use std::collections::BTreeMap;
use std::ops::Range;
#[cfg(debug_assertions)]
use std::path::Path;
use target::Target;
use timer::Timer;

pub use context::Gpu;
pub use viewport::{Shown, Viewport};

/// Draws scenes on a graphics card.
#[derive(Debug)]
pub struct GpuRenderer {
    gpu: Gpu,
    layouts: Layouts,
    pipelines: Pipelines,
    proxy: ProxyBuffers,
    kept: Kept,
    target: Option<Target>,
    #[cfg(debug_assertions)]
    watch: watch::Watch,
}

/// The folder that the shaders were built from.
#[cfg(debug_assertions)]
const SHADERS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/shaders");

/// A proxy's corners and triangles.
#[derive(Debug)]
struct ProxyBuffers {
    corners: wgpu::Buffer,
    triangles: wgpu::Buffer,
    index_count: u32,
}

/// What of a picture is drawn at once.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Part {
    /// Rows of samples.
    rows: Range<u32>,
    /// Whether nothing was drawn before.
    is_first: bool,
    /// What becomes of the samples, where this is the last part.
    ending: Option<Ending>,
}

/// What a picture is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    /// A file: straight alpha.
    File,
    /// A window: colours times alpha, as sRGB values.
    Window,
}

impl GpuRenderer {
    /// A renderer on `gpu`.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`] when the card refuses a shader, [`RenderError::OutOfMemory`].
    pub fn new(gpu: Gpu, proxy: Proxy) -> Result<Self, RenderError> {
        Self::with_shaders(gpu, proxy, Pass::built_in)
    }

    /// A renderer with other shaders than those built in.
    ///
    /// # Errors
    /// As [`GpuRenderer::new`].
    pub fn with_shaders(
        gpu: Gpu,
        proxy: Proxy,
        text: impl Fn(Pass) -> Cow<'static, str>,
    ) -> Result<Self, RenderError> {
        let (layouts, pipelines, proxy) = gpu.guarded(|| {
            let layouts = Layouts::new(&gpu.device);
            let pipelines = Pipelines::new(&gpu.device, &layouts, text);
            Ok((layouts, pipelines, ProxyBuffers::new(&gpu, proxy)))
        })?;
        Ok(Self {
            gpu,
            layouts,
            pipelines,
            proxy,
            kept: Kept::default(),
            target: None,
            #[cfg(debug_assertions)]
            watch: watch::Watch::new(Path::new(SHADERS)),
        })
    }

    /// Compiles the shaders anew if one of their files has changed since the last call; whether it
    /// did. Looks at the folder that the program was built from, unless told of another.
    ///
    /// In debug builds only: it does nothing in others.
    ///
    /// # Errors
    /// [`RenderError::Shader`] when a shader cannot be read or compiled; the renderer goes on with
    /// those it has. [`RenderError::DeviceLost`], [`RenderError::OutOfMemory`].
    #[cfg(debug_assertions)]
    pub fn reload_if_changed(&mut self) -> Result<bool, RenderError> {
        if !self.watch.has_changed() {
            return Ok(false);
        }
        let mut texts = BTreeMap::new();
        for pass in Pass::ALL {
            let text = pass.from_folder(self.watch.folder());
            texts.insert(
                pass.name(),
                text.map_err(|error| RenderError::Shader(error.to_string()))?,
            );
        }
        let text = |pass: Pass| texts[pass.name()].clone();
        let made = self
            .gpu
            .guarded(|| Ok(Pipelines::new(&self.gpu.device, &self.layouts, text)));
        self.pipelines = made.map_err(|error| match error {
            RenderError::DeviceLost(text) if self.gpu.trouble().is_none() => {
                RenderError::Shader(text)
            }
            other => other,
        })?;
        Ok(true)
    }

    /// Does nothing: shaders are read anew in debug builds only.
    ///
    /// # Errors
    /// None.
    #[cfg(not(debug_assertions))]
    pub fn reload_if_changed(&mut self) -> Result<bool, RenderError> {
        Ok(false)
    }

    /// Looks for changed shaders in another folder from now on.
    #[cfg(debug_assertions)]
    pub fn watch(&mut self, folder: &Path) {
        self.watch = watch::Watch::new(folder);
    }

    /// The card.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Draws a scene and brings the picture back.
    ///
    /// # Errors
    /// [`RenderError`], but for its `NoAdapter` and `Cancelled`.
    pub fn picture(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
    ) -> Result<Image<Straight>, RenderError> {
        let gpu = self.gpu.clone();
        self.guarded(|renderer| {
            renderer.draw(view, settings, None)?;
            let target = renderer.target.as_ref();
            target
                .ok_or_else(|| RenderError::DeviceLost("nothing was drawn".to_owned()))?
                .read(&gpu)
        })
    }

    /// Draws a scene and gives the time the card took for it, milliseconds: by its own clock where
    /// it has one, else from handing the work over to its end.
    ///
    /// # Errors
    /// As [`GpuRenderer::picture`].
    pub fn drawing_time_ms(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
    ) -> Result<f64, RenderError> {
        let gpu = self.gpu.clone();
        self.guarded(|renderer| {
            let timer = Timer::new(&gpu);
            renderer.draw(view, settings, Some(&timer))?;
            timer.read_ms(&gpu)
        })
    }

    /// Does `work`, and gives what went wrong with the card meanwhile as an error; nothing that was
    /// brought to the card is relied on after one.
    fn guarded<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let gpu = self.gpu.clone();
        let done = gpu.guarded(|| work(self));
        if done.is_err() {
            self.kept = Kept::default();
            self.target = None;
        }
        done
    }

    /// Draws a scene into the renderer's own target.
    fn draw(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
        timer: Option<&Timer>,
    ) -> Result<(), RenderError> {
        let lists = self.lists(view, settings);
        let old = self.target.take();
        let target = self.fitting(old, settings)?;
        let whole = Part {
            rows: 0..target.rows(),
            is_first: true,
            ending: Some(Ending::File),
        };
        self.draw_part(&target, &lists, &whole, timer);
        self.target = Some(target);
        Ok(())
    }

    /// Brings a scene to the card.
    fn lists(&mut self, view: &SceneView<'_>, settings: &RenderSettings) -> Lists {
        self.kept.keep(&self.gpu, &self.layouts, view);
        Lists::new(&self.gpu, &self.layouts.frame, view, settings)
    }

    /// `old` if it serves, else a new target.
    fn fitting(
        &self,
        old: Option<Target>,
        settings: &RenderSettings,
    ) -> Result<Target, RenderError> {
        match old.filter(|target| target.fits(settings)) {
            Some(target) => Ok(target),
            None => Target::new(&self.gpu, &self.layouts, settings),
        }
    }

    /// Hands the work for a part of a picture to the card, without waiting for it.
    fn draw_part(&self, target: &Target, lists: &Lists, part: &Part, timer: Option<&Timer>) {
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.light_pass(&mut encoder, target, (lists, part), timer);
        if let Some(ending) = part.ending {
            self.tone_pass(&mut encoder, target, &lists.frame, ending);
        }
        if let Some(timer) = timer {
            timer.resolve(&mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
    }

    fn light_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target,
        (lists, part): (&Lists, &Part),
        timer: Option<&Timer>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light"),
            color_attachments: &[Some(attachment(&target.light, part.is_first))],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &target.depth,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            timestamp_writes: timer.and_then(Timer::writes),
            ..Default::default()
        });
        let (width, rows) = (target.columns(), &part.rows);
        pass.set_scissor_rect(0, rows.start, width, rows.end - rows.start);
        pass.set_bind_group(0, &lists.frame, &[]);
        pass.set_pipeline(&self.pipelines.backdrop);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&self.pipelines.ground);
        self.draw_crowns(&mut pass, &lists.shadows, |pass, range| {
            pass.draw(0..6, range);
        });
        pass.set_pipeline(&self.pipelines.mesh);
        for mesh in &self.kept.meshes {
            pass.set_vertex_buffer(0, mesh.corners.slice(..));
            pass.draw(0..mesh.corner_count, 0..1);
        }
        pass.set_pipeline(&self.pipelines.relief);
        pass.set_vertex_buffer(0, self.proxy.corners.slice(..));
        pass.set_index_buffer(self.proxy.triangles.slice(..), wgpu::IndexFormat::Uint16);
        self.draw_crowns(&mut pass, &lists.relief, |pass, range| {
            pass.draw_indexed(0..self.proxy.index_count, 0, range);
        });
        if let Some((_, leaves)) = &self.kept.leaves {
            pass.set_pipeline(&self.pipelines.leaves);
            pass.set_bind_group(2, leaves, &[]);
            for (count, crowns) in &lists.leaves {
                self.draw_crowns(&mut pass, crowns, |pass, range| {
                    pass.draw(0..6 * count, range);
                });
            }
        }
    }

    /// Calls `draw` with the instances of each crown.
    fn draw_crowns<'pass>(
        &self,
        pass: &mut wgpu::RenderPass<'pass>,
        instances: &Instances,
        draw: impl Fn(&mut wgpu::RenderPass<'pass>, Range<u32>),
    ) {
        pass.set_vertex_buffer(1, instances.buffer.slice(..));
        for (crown, range) in self.kept.crowns.iter().zip(&instances.ranges) {
            if !range.is_empty() {
                pass.set_bind_group(1, &crown.group, &[]);
                draw(pass, range.clone());
            }
        }
    }

    fn tone_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target,
        frame: &wgpu::BindGroup,
        ending: Ending,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tone"),
            color_attachments: &[Some(attachment(&target.shown, true))],
            ..Default::default()
        });
        pass.set_pipeline(match ending {
            Ending::File => &self.pipelines.tone,
            Ending::Window => &self.pipelines.tone_premultiplied,
        });
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, &target.samples, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A texture that is drawn into, from scratch or beside what is there.
fn attachment(view: &wgpu::TextureView, from_scratch: bool) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: match from_scratch {
                true => wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
                false => wgpu::LoadOp::Load,
            },
            store: wgpu::StoreOp::Store,
        },
    }
}

impl ProxyBuffers {
    fn new(gpu: &Gpu, proxy: Proxy) -> Self {
        let (corners, triangles) = proxy.triangles();
        Self {
            corners: gpu.buffer(
                "proxy corners",
                bytemuck::cast_slice(&corners),
                wgpu::BufferUsages::VERTEX,
            ),
            triangles: gpu.buffer(
                "proxy triangles",
                bytemuck::cast_slice(&triangles),
                wgpu::BufferUsages::INDEX,
            ),
            index_count: 3 * triangles.len() as u32,
        }
    }
}
