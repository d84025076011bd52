//! A crown on the card.

use super::context::Gpu;
use super::layouts::Layouts;
use crate::render::{CrownNumbers, PackedCube, PreparedCrown};
use bytemuck::Pod;
use wgpu::util::{BufferInitDescriptor, DeviceExt as _, TextureDataOrder};
use wgpu::{TextureFormat, TextureUsages};

/// The bind group of a crown: its numbers, radii and colours.
pub(super) fn crown_group(gpu: &Gpu, layouts: &Layouts, crown: &PreparedCrown) -> wgpu::BindGroup {
    let numbers = gpu.device.create_buffer_init(&BufferInitDescriptor {
        label: Some("crown"),
        contents: bytemuck::bytes_of(&CrownNumbers::new(crown)),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let radius = layers(gpu, "radius", &crown.radius, TextureFormat::R32Float);
    let surface = layers(
        gpu,
        "surface",
        &crown.surface,
        TextureFormat::Rgba8UnormSrgb,
    );
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("crown"),
        layout: &layouts.crown,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: numbers.as_entire_binding(),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&radius),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::TextureView(&surface),
            },
        ],
    })
}

/// A packed cubemap as six layers of a texture.
fn layers<T: Pod>(
    gpu: &Gpu,
    label: &str,
    cube: &PackedCube<T>,
    format: TextureFormat,
) -> wgpu::TextureView {
    let (width, height) = cube.rectangle();
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d {
                width,
                height,
                depth_or_array_layers: 6,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        },
        TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(cube.texels()),
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    })
}
