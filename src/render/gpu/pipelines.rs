//! The pipelines of the passes.

use super::layouts::Layouts;
use super::target::{DEPTH_FORMAT, LIGHT_FORMAT, PICTURE_FORMAT};
use crate::render::shaders::Pass;
use std::borrow::Cow;
use wgpu::{BindGroupLayout, CompareFunction, Device, RenderPipeline, TextureFormat};

/// Where an instance's numbers stand in its vertex buffer.
const INSTANCE: [wgpu::VertexAttribute; 7] = wgpu::vertex_attr_array![
    1 => Float32x3, 2 => Float32, 3 => Float32x2, 4 => Float32, 5 => Uint32, 6 => Float32x3,
    7 => Float32
];

/// Where a proxy's corners stand.
const CORNER: [wgpu::VertexAttribute; 1] = wgpu::vertex_attr_array![0 => Float32x3];

/// Where a mesh's numbers stand.
const VERTEX: [wgpu::VertexAttribute; 5] = wgpu::vertex_attr_array![
    0 => Float32x3, 1 => Float32, 2 => Float32x3, 3 => Float32, 4 => Float32x3
];

/// The pipelines of all passes.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) backdrop: RenderPipeline,
    pub(super) ground: RenderPipeline,
    pub(super) mesh: RenderPipeline,
    pub(super) relief: RenderPipeline,
    pub(super) leaves: RenderPipeline,
    pub(super) tone: RenderPipeline,
    pub(super) tone_premultiplied: RenderPipeline,
}

/// What sets a pass apart.
struct Kind<'a> {
    pass: Pass,
    /// The function of the shader that gives a fragment's colour.
    fragment: &'a str,
    layouts: &'a [&'a BindGroupLayout],
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    cull: Option<wgpu::Face>,
    format: TextureFormat,
    blend: Option<wgpu::BlendState>,
    /// Compare and write, where the pass has a depth.
    depth: Option<(CompareFunction, bool)>,
}

impl Pipelines {
    /// Compiles the passes; `text` gives the shader of each.
    pub(super) fn new(
        device: &Device,
        layouts: &Layouts,
        text: impl Fn(Pass) -> Cow<'static, str>,
    ) -> Self {
        let made = |kind: &Kind<'_>| pipeline(device, kind, text(kind.pass));
        let corners = wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &CORNER,
        };
        let instances = wgpu::VertexBufferLayout {
            array_stride: size_of::<crate::render::InstanceNumbers>() as u64,
            step_mode: wgpu::VertexStepMode::Instance,
            attributes: &INSTANCE,
        };
        let behind = Kind {
            pass: Pass::Backdrop,
            fragment: "sample",
            layouts: &[&layouts.frame],
            buffers: &[],
            cull: None,
            format: LIGHT_FORMAT,
            blend: None,
            depth: Some((CompareFunction::Always, false)),
        };
        let vertices = wgpu::VertexBufferLayout {
            array_stride: size_of::<crate::render::MeshVertex>() as u64,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &VERTEX,
        };
        let tone = Kind {
            pass: Pass::Tone,
            layouts: &[&layouts.frame, &layouts.samples],
            format: PICTURE_FORMAT,
            depth: None,
            ..behind
        };
        let nearest = Some((CompareFunction::Greater, true));
        Self {
            backdrop: made(&behind),
            ground: made(&Kind {
                pass: Pass::Ground,
                layouts: &[&layouts.frame, &layouts.crown],
                buffers: &[None, Some(instances.clone())],
                blend: Some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                ..behind
            }),
            mesh: made(&Kind {
                pass: Pass::Mesh,
                buffers: &[Some(vertices)],
                depth: nearest,
                ..behind
            }),
            leaves: made(&Kind {
                pass: Pass::Leaves,
                layouts: &[&layouts.frame, &layouts.crown, &layouts.leaves],
                buffers: &[None, Some(instances.clone())],
                depth: nearest,
                ..behind
            }),
            relief: made(&Kind {
                pass: Pass::Relief,
                layouts: &[&layouts.frame, &layouts.crown],
                buffers: &[Some(corners), Some(instances.clone())],
                // The far side is drawn: an eye within the proxy sees that one only.
                cull: Some(wgpu::Face::Front),
                depth: nearest,
                ..behind
            }),
            tone: made(&tone),
            tone_premultiplied: made(&Kind {
                fragment: "premultiplied",
                ..tone
            }),
        }
    }
}

fn pipeline(device: &Device, kind: &Kind<'_>, text: Cow<'static, str>) -> RenderPipeline {
    let label = Some(kind.pass.name());
    let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label,
        source: wgpu::ShaderSource::Wgsl(text),
    });
    let groups: Vec<Option<&BindGroupLayout>> = kind.layouts.iter().copied().map(Some).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label,
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let depth = |(compare, write)| wgpu::DepthStencilState {
        format: DEPTH_FORMAT,
        depth_write_enabled: Some(write),
        depth_compare: Some(compare),
        stencil: wgpu::StencilState::default(),
        bias: wgpu::DepthBiasState::default(),
    };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label,
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("corner"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: kind.buffers,
        },
        primitive: wgpu::PrimitiveState {
            cull_mode: kind.cull,
            ..Default::default()
        },
        depth_stencil: kind.depth.map(depth),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some(kind.fragment),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(wgpu::ColorTargetState {
                format: kind.format,
                blend: kind.blend,
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}
