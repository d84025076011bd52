//! A crown on the card.

use super::context::Gpu;
use super::layouts::Layouts;
use crate::base::Digest;
use crate::render::{CrownNumbers, PackedCube, PreparedCrown};
use bytemuck::Pod;
use wgpu::{BufferUsages, TextureFormat, TextureUsages};

/// The numbers, radii and colours of a crown.
#[derive(Debug)]
pub(super) struct CardCrown {
    numbers: (CrownNumbers, wgpu::Buffer),
    radius: Layers,
    surface: Layers,
    pub(super) group: wgpu::BindGroup,
}

/// The layers of a packed cubemap, and the digest of what they hold.
#[derive(Debug)]
struct Layers {
    texture: wgpu::Texture,
    digest: Digest,
}

impl CardCrown {
    /// Brings `crown` to the card.
    pub(super) fn new(gpu: &Gpu, layouts: &Layouts, crown: &PreparedCrown) -> Self {
        let numbers = CrownNumbers::new(crown);
        let buffer = gpu.buffer("crown", bytemuck::bytes_of(&numbers), BufferUsages::UNIFORM);
        let radius = Layers::new(
            gpu,
            ("radius", TextureFormat::R32Float),
            (&crown.radius, crown.radius_digest),
        );
        let surface = Layers::new(
            gpu,
            ("surface", TextureFormat::Rgba8UnormSrgb),
            (&crown.surface, crown.surface_digest),
        );
        Self {
            group: group(gpu, layouts, &buffer, [&radius, &surface]),
            numbers: (numbers, buffer),
            radius,
            surface,
        }
    }

    /// Whether this is `crown`.
    pub(super) fn is(&self, crown: &PreparedCrown) -> bool {
        self.radius.digest == crown.radius_digest
            && self.surface.digest == crown.surface_digest
            && self.numbers.0 == CrownNumbers::new(crown)
    }

    /// Whether this becomes `crown` without new textures.
    pub(super) fn can_become(&self, crown: &PreparedCrown) -> bool {
        self.radius.fits(&crown.radius) && self.surface.fits(&crown.surface)
    }

    /// Writes what is different in `crown`, whose cubemaps have the same sizes, over what there is.
    pub(super) fn become_crown(&mut self, gpu: &Gpu, crown: &PreparedCrown) {
        let numbers = CrownNumbers::new(crown);
        if self.numbers.0 != numbers {
            let bytes = bytemuck::bytes_of(&numbers);
            gpu.queue.write_buffer(&self.numbers.1, 0, bytes);
            self.numbers.0 = numbers;
        }
        self.radius.update(gpu, &crown.radius, crown.radius_digest);
        self.surface
            .update(gpu, &crown.surface, crown.surface_digest);
    }
}

fn group(
    gpu: &Gpu,
    layouts: &Layouts,
    numbers: &wgpu::Buffer,
    layers: [&Layers; 2],
) -> wgpu::BindGroup {
    let [radius, surface] = layers.map(Layers::view);
    // The default: nearest, no further than the edge.
    let texels = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("texels"),
        ..Default::default()
    });
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
            wgpu::BindGroupEntry {
                binding: 3,
                resource: wgpu::BindingResource::Sampler(&texels),
            },
        ],
    })
}

impl Layers {
    fn new<T: Pod>(
        gpu: &Gpu,
        (label, format): (&str, TextureFormat),
        (cube, digest): (&PackedCube<T>, Digest),
    ) -> Self {
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: extent(cube),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: TextureUsages::TEXTURE_BINDING | TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let layers = Self { texture, digest };
        layers.write(gpu, cube);
        layers
    }

    fn fits<T: Copy>(&self, cube: &PackedCube<T>) -> bool {
        self.texture.size() == extent(cube)
    }

    fn update<T: Pod>(&mut self, gpu: &Gpu, cube: &PackedCube<T>, digest: Digest) {
        if self.digest != digest {
            self.write(gpu, cube);
            self.digest = digest;
        }
    }

    fn write<T: Pod>(&self, gpu: &Gpu, cube: &PackedCube<T>) {
        let (width, height) = cube.rectangle();
        gpu.queue.write_texture(
            self.texture.as_image_copy(),
            bytemuck::cast_slice(cube.texels()),
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(width * size_of::<T>() as u32),
                rows_per_image: Some(height),
            },
            extent(cube),
        );
    }

    fn view(&self) -> wgpu::TextureView {
        self.texture.create_view(&wgpu::TextureViewDescriptor {
            dimension: Some(wgpu::TextureViewDimension::D2Array),
            ..Default::default()
        })
    }
}

/// One layer a face.
fn extent<T: Copy>(cube: &PackedCube<T>) -> wgpu::Extent3d {
    let (width, height) = cube.rectangle();
    wgpu::Extent3d {
        width,
        height,
        depth_or_array_layers: 6,
    }
}
