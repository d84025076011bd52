//! Leaves on the card.

use super::context::Gpu;
use super::layouts::Layouts;
use super::leaf_order::{DIRECTIONS, orders};
use crate::render::LeafSet;
use crate::render::leaf_atlas::VARIANTS;
use wgpu::util::{DeviceExt as _, TextureDataOrder};
use wgpu::{TextureFormat, TextureUsages, TextureView, TextureViewDimension};

/// Places in a row of their texture, and of that of their orders.
const ROW: usize = 64;

/// The bind group of a set of leaves.
pub(super) fn leaf_group(gpu: &Gpu, layouts: &Layouts, leaves: &LeafSet) -> wgpu::BindGroup {
    let (points, atlas) = (points(gpu, leaves), atlas(gpu, leaves));
    let orders = order_layers(gpu, leaves);
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("leaves"),
        layout: &layouts.leaves,
        entries: &[
            wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&points),
            },
            wgpu::BindGroupEntry {
                binding: 1,
                resource: wgpu::BindingResource::TextureView(&atlas),
            },
            wgpu::BindGroupEntry {
                binding: 2,
                resource: wgpu::BindingResource::TextureView(&orders),
            },
        ],
    })
}

fn points(gpu: &Gpu, leaves: &LeafSet) -> TextureView {
    let mut points = leaves.points.clone();
    points.resize(points.len().max(1).next_multiple_of(ROW), [0.0; 4]);
    let size = wgpu::Extent3d {
        width: ROW as u32,
        height: (points.len() / ROW) as u32,
        depth_or_array_layers: 1,
    };
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &described("leaf points", size, TextureFormat::Rgba32Float, 1),
        TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&points),
    );
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

fn order_layers(gpu: &Gpu, leaves: &LeafSet) -> TextureView {
    let orders = orders(&leaves.points);
    let size = wgpu::Extent3d {
        width: ROW as u32,
        height: orders.len() as u32 / (ROW as u32 * DIRECTIONS),
        depth_or_array_layers: DIRECTIONS,
    };
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &described("leaf orders", size, TextureFormat::R16Uint, 1),
        TextureDataOrder::LayerMajor,
        bytemuck::cast_slice(&orders),
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2Array),
        ..Default::default()
    })
}

fn atlas(gpu: &Gpu, leaves: &LeafSet) -> TextureView {
    let level_count = leaves.atlas.level_count();
    let levels = (0..level_count).flat_map(|level| leaves.atlas.texels(level));
    let texels: Vec<[u8; 2]> = levels.collect();
    let size = wgpu::Extent3d {
        width: leaves.atlas.size(),
        height: leaves.atlas.size(),
        depth_or_array_layers: VARIANTS,
    };
    let texture = gpu.device.create_texture_with_data(
        &gpu.queue,
        &described("leaf atlas", size, TextureFormat::Rg8Unorm, level_count),
        TextureDataOrder::MipMajor,
        bytemuck::cast_slice(&texels),
    );
    texture.create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(TextureViewDimension::D2Array),
        ..Default::default()
    })
}

fn described(
    label: &str,
    size: wgpu::Extent3d,
    format: TextureFormat,
    mip_level_count: u32,
) -> wgpu::TextureDescriptor<'_> {
    wgpu::TextureDescriptor {
        label: Some(label),
        size,
        mip_level_count,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: TextureUsages::TEXTURE_BINDING,
        view_formats: &[],
    }
}
