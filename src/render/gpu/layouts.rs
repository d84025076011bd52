//! What the shaders are given: the layouts of their bind groups.

use wgpu::{
    BindGroupLayout, BindGroupLayoutEntry, BindingType, BufferBindingType, Device,
    SamplerBindingType, ShaderStages, TextureSampleType, TextureViewDimension,
};

/// The layouts of all bind groups.
#[derive(Debug)]
pub(super) struct Layouts {
    /// 0: the frame.
    pub(super) frame: BindGroupLayout,
    /// A crown: its numbers, radii, colours.
    pub(super) crown: BindGroupLayout,
    /// Leaves: their places, pictures of twigs.
    pub(super) leaves: BindGroupLayout,
    /// The samples that the tone pass reads.
    pub(super) samples: BindGroupLayout,
}

impl Layouts {
    pub(super) fn new(device: &Device) -> Self {
        let layout = |label, entries: &[BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
                label: Some(label),
                entries,
            })
        };
        Self {
            frame: layout("frame", &[numbers(0)]),
            crown: layout(
                "crown",
                &[
                    numbers(0),
                    texels(1, TextureViewDimension::D2Array),
                    texels(2, TextureViewDimension::D2Array),
                    entry(3, BindingType::Sampler(SamplerBindingType::NonFiltering)),
                ],
            ),
            leaves: layout(
                "leaves",
                &[
                    texels(0, TextureViewDimension::D2),
                    texels(1, TextureViewDimension::D2Array),
                ],
            ),
            samples: layout("samples", &[texels(0, TextureViewDimension::D2)]),
        }
    }
}

fn numbers(binding: u32) -> BindGroupLayoutEntry {
    entry(
        binding,
        BindingType::Buffer {
            ty: BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
    )
}

/// A texture that is read texel by texel: shaders filter themselves.
fn texels(binding: u32, view_dimension: TextureViewDimension) -> BindGroupLayoutEntry {
    entry(
        binding,
        BindingType::Texture {
            sample_type: TextureSampleType::Float { filterable: false },
            view_dimension,
            multisampled: false,
        },
    )
}

fn entry(binding: u32, ty: BindingType) -> BindGroupLayoutEntry {
    BindGroupLayoutEntry {
        binding,
        visibility: ShaderStages::VERTEX_FRAGMENT,
        ty,
        count: None,
    }
}
