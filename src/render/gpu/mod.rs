//! The renderer for graphics cards.
//!
//! A picture is light and depth of all its samples first (backdrop, then crowns, nearest wins) and
//! becomes colours at the end (tone). Crowns go to the card once and stay there as long as they
//! are drawn. Nothing here panics when the card does what cards do: see [`Gpu`].

mod context;
mod crown;
mod layouts;
mod leaves;
mod pipelines;
mod target;
mod timer;

use super::frame::{Frame, InstanceNumbers, Resolved, SceneView, leaf_bound};
use super::proxy::Proxy;
use super::settings::RenderSettings;
use super::shaders::Pass;
use super::{LeafSet, PreparedCrown, RenderError};
use crate::base::Digest;
use crate::raster::{Image, Straight};
use crown::crown_group;
use layouts::Layouts;
use leaves::leaf_group;
use pipelines::Pipelines;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::ops::Range;
use target::Target;
use timer::Timer;
use wgpu::util::{BufferInitDescriptor, DeviceExt as _};

pub use context::Gpu;

/// Draws scenes on a graphics card.
#[derive(Debug)]
pub struct GpuRenderer {
    gpu: Gpu,
    layouts: Layouts,
    pipelines: Pipelines,
    proxy: ProxyBuffers,
    /// Crowns on the card, by their content.
    crowns: Vec<(Digest, wgpu::BindGroup)>,
    leaves: Option<(Digest, wgpu::BindGroup)>,
    target: Option<Target>,
}

/// A proxy's corners and triangles.
#[derive(Debug)]
struct ProxyBuffers {
    corners: wgpu::Buffer,
    triangles: wgpu::Buffer,
    index_count: u32,
}

/// The crowns of a picture, those of one kind after another.
struct Instances {
    buffer: wgpu::Buffer,
    /// For each crown of the scene: first and one after the last instance.
    ranges: Vec<Range<u32>>,
}

/// All that is drawn in a picture.
struct Lists {
    shadows: Instances,
    relief: Instances,
    /// Crowns with about as many leaves, and how many at most.
    leaves: Vec<(u32, Instances)>,
    meshes: Vec<(wgpu::Buffer, u32)>,
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
            crowns: Vec::new(),
            leaves: None,
            target: None,
        })
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
        gpu.guarded(|| {
            self.draw(view, settings, None)?;
            let target = self.target.as_ref();
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
        gpu.guarded(|| {
            let timer = Timer::new(&gpu);
            self.draw(view, settings, Some(&timer))?;
            timer.read_ms(&gpu)
        })
    }

    /// Draws a scene into the renderer's own target.
    fn draw(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
        timer: Option<&Timer>,
    ) -> Result<(), RenderError> {
        let frame = Frame::new(view, settings);
        self.keep_crowns(view.crowns);
        self.keep_leaves(view.leaves);
        let fits = |target: &Target| target.fits(settings.size, settings.fineness);
        if !self.target.as_ref().is_some_and(fits) {
            self.target = None;
            let made = Target::new(&self.gpu, &self.layouts, settings.size, settings.fineness)?;
            self.target = Some(made);
        }
        let Some(target) = &self.target else {
            return Ok(());
        };
        let frame_group = self.frame_group(&frame);
        let lists = Lists::new(&self.gpu, view, settings);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.light_pass(&mut encoder, target, (&frame_group, &lists), timer);
        self.tone_pass(&mut encoder, target, &frame_group);
        if let Some(timer) = timer {
            timer.resolve(&mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        Ok(())
    }

    /// Brings crowns to the card that are not there, and drops those that the scene has no more.
    fn keep_crowns(&mut self, crowns: &[PreparedCrown]) {
        let mut kept = Vec::with_capacity(crowns.len());
        for crown in crowns {
            let known = self
                .crowns
                .iter()
                .find(|(digest, _)| *digest == crown.digest);
            let group = match known {
                Some((_, group)) => group.clone(),
                None => crown_group(&self.gpu, &self.layouts, crown),
            };
            kept.push((crown.digest, group));
        }
        self.crowns = kept;
    }

    /// Brings the leaves to the card if others are there.
    fn keep_leaves(&mut self, leaves: &LeafSet) {
        let known = self.leaves.as_ref();
        if known.is_none_or(|(digest, _)| *digest != leaves.digest) {
            let group = leaf_group(&self.gpu, &self.layouts, leaves);
            self.leaves = Some((leaves.digest, group));
        }
    }

    fn frame_group(&self, frame: &Frame) -> wgpu::BindGroup {
        let numbers = self.gpu.device.create_buffer_init(&BufferInitDescriptor {
            label: Some("frame"),
            contents: bytemuck::bytes_of(frame),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        self.gpu
            .device
            .create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("frame"),
                layout: &self.layouts.frame,
                entries: &[wgpu::BindGroupEntry {
                    binding: 0,
                    resource: numbers.as_entire_binding(),
                }],
            })
    }

    fn light_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target,
        (frame, lists): (&wgpu::BindGroup, &Lists),
        timer: Option<&Timer>,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("light"),
            color_attachments: &[Some(attachment(&target.light))],
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
        pass.set_bind_group(0, frame, &[]);
        pass.set_pipeline(&self.pipelines.backdrop);
        pass.draw(0..3, 0..1);
        pass.set_pipeline(&self.pipelines.ground);
        self.draw_crowns(&mut pass, &lists.shadows, |pass, range| {
            pass.draw(0..6, range);
        });
        pass.set_pipeline(&self.pipelines.mesh);
        for (vertices, count) in &lists.meshes {
            pass.set_vertex_buffer(0, vertices.slice(..));
            pass.draw(0..*count, 0..1);
        }
        pass.set_pipeline(&self.pipelines.relief);
        pass.set_vertex_buffer(0, self.proxy.corners.slice(..));
        pass.set_index_buffer(self.proxy.triangles.slice(..), wgpu::IndexFormat::Uint16);
        self.draw_crowns(&mut pass, &lists.relief, |pass, range| {
            pass.draw_indexed(0..self.proxy.index_count, 0, range);
        });
        if let Some((_, leaves)) = &self.leaves {
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
        for ((_, crown), range) in self.crowns.iter().zip(&instances.ranges) {
            if !range.is_empty() {
                pass.set_bind_group(1, crown, &[]);
                draw(pass, range.clone());
            }
        }
    }

    fn tone_pass(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        target: &Target,
        frame: &wgpu::BindGroup,
    ) {
        let view = target.picture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("tone"),
            color_attachments: &[Some(attachment(&view))],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipelines.tone);
        pass.set_bind_group(0, frame, &[]);
        pass.set_bind_group(1, &target.samples, &[]);
        pass.draw(0..3, 0..1);
    }
}

/// A texture that is drawn into from scratch.
fn attachment(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations {
            load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT),
            store: wgpu::StoreOp::Store,
        },
    }
}

impl ProxyBuffers {
    fn new(gpu: &Gpu, proxy: Proxy) -> Self {
        let (corners, triangles) = proxy.triangles();
        let buffer = |label, contents: &[u8], usage| {
            gpu.device.create_buffer_init(&BufferInitDescriptor {
                label: Some(label),
                contents,
                usage,
            })
        };
        Self {
            corners: buffer(
                "proxy corners",
                bytemuck::cast_slice(&corners),
                wgpu::BufferUsages::VERTEX,
            ),
            triangles: buffer(
                "proxy triangles",
                bytemuck::cast_slice(&triangles),
                wgpu::BufferUsages::INDEX,
            ),
            index_count: 3 * triangles.len() as u32,
        }
    }
}

impl Instances {
    /// `list`, sorted by crown, on the card.
    fn new(gpu: &Gpu, list: &[(usize, InstanceNumbers)], crown_count: usize) -> Self {
        let mut numbers: Vec<InstanceNumbers> = list.iter().map(|(_, numbers)| *numbers).collect();
        let first = |crown: usize| list.partition_point(|(index, _)| *index < crown) as u32;
        let ranges = (0..crown_count).map(|crown| first(crown)..first(crown + 1));
        let ranges = ranges.collect();
        // A buffer must not be empty.
        if numbers.is_empty() {
            numbers.push(bytemuck::Zeroable::zeroed());
        }
        Self {
            buffer: vertex_buffer(gpu, "instances", bytemuck::cast_slice(&numbers)),
            ranges,
        }
    }
}

impl Lists {
    fn new(gpu: &Gpu, view: &SceneView<'_>, settings: &RenderSettings) -> Self {
        let resolved = Resolved::new(view, settings);
        let count = view.crowns.len();
        let instances = |list: &[(usize, InstanceNumbers)]| Instances::new(gpu, list, count);
        let mut leaves: BTreeMap<u32, Vec<(usize, InstanceNumbers)>> = BTreeMap::new();
        for entry in &resolved.leaves {
            let bound = leaf_bound(view, settings, entry);
            leaves.entry(bound).or_default().push(*entry);
        }
        let meshes = view.meshes.iter().filter(|mesh| !mesh.corners.is_empty());
        Self {
            shadows: instances(&resolved.shadows),
            relief: instances(&resolved.relief),
            leaves: leaves
                .into_iter()
                .map(|(bound, list)| (bound, instances(&list)))
                .collect(),
            meshes: meshes
                .map(|mesh| {
                    let bytes = bytemuck::cast_slice(&mesh.corners);
                    (vertex_buffer(gpu, "mesh", bytes), mesh.corners.len() as u32)
                })
                .collect(),
        }
    }
}

fn vertex_buffer(gpu: &Gpu, label: &str, contents: &[u8]) -> wgpu::Buffer {
    gpu.device.create_buffer_init(&BufferInitDescriptor {
        label: Some(label),
        contents,
        usage: wgpu::BufferUsages::VERTEX,
    })
}
