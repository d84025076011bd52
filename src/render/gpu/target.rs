//! What the passes draw into, and the way of a picture back from the card.

use super::context::Gpu;
use super::layouts::Layouts;
use crate::raster::{Image, Straight};
use crate::render::{RenderError, RenderSettings};
use wgpu::{TextureFormat, TextureUsages, TextureView};

/// Linear light: half floats hold more than the 8 bits of a picture at any brightness.
pub(super) const LIGHT_FORMAT: TextureFormat = TextureFormat::Rgba16Float;
/// Reversed depth.
pub(super) const DEPTH_FORMAT: TextureFormat = TextureFormat::Depth32Float;

/// sRGB values, not decoded when they are read: what files and windows want.
pub(super) const PICTURE_FORMAT: TextureFormat = TextureFormat::Rgba8Unorm;

/// Light and depth of every sample, and the picture that they become.
#[derive(Debug)]
pub(super) struct Target {
    pub(super) light: TextureView,
    pub(super) depth: TextureView,
    picture: wgpu::Texture,
    /// All of the picture.
    pub(super) shown: TextureView,
    pub(super) samples: wgpu::BindGroup,
    size: (u32, u32),
    fineness: u32,
}

impl Target {
    /// A target for pictures with `settings`.
    ///
    /// # Errors
    /// [`RenderError::TooLarge`].
    pub(super) fn new(
        gpu: &Gpu,
        layouts: &Layouts,
        settings: &RenderSettings,
    ) -> Result<Self, RenderError> {
        let (size, fineness) = (settings.drawn_size(), settings.fineness);
        let (width, height) = (size.0 * fineness, size.1 * fineness);
        let most = gpu.longest_side();
        if width.max(height) > most {
            return Err(RenderError::TooLarge {
                width,
                height,
                most,
            });
        }
        let drawn = TextureUsages::RENDER_ATTACHMENT;
        let read = drawn | TextureUsages::TEXTURE_BINDING;
        let light = texture(gpu, "light", (width, height), LIGHT_FORMAT, read);
        let depth = texture(gpu, "depth", (width, height), DEPTH_FORMAT, drawn);
        let copied = read | TextureUsages::COPY_SRC;
        let picture = texture(gpu, "picture", size, PICTURE_FORMAT, copied);
        let light = light.create_view(&wgpu::TextureViewDescriptor::default());
        let samples = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("samples"),
            layout: &layouts.samples,
            entries: &[wgpu::BindGroupEntry {
                binding: 0,
                resource: wgpu::BindingResource::TextureView(&light),
            }],
        });
        Ok(Self {
            light,
            depth: depth.create_view(&wgpu::TextureViewDescriptor::default()),
            shown: picture.create_view(&wgpu::TextureViewDescriptor::default()),
            picture,
            samples,
            size,
            fineness,
        })
    }

    /// Whether the target serves such a picture.
    pub(super) fn fits(&self, settings: &RenderSettings) -> bool {
        self.size == settings.drawn_size() && self.fineness == settings.fineness
    }

    /// Samples across.
    pub(super) fn columns(&self) -> u32 {
        self.size.0 * self.fineness
    }

    /// Samples down.
    pub(super) fn rows(&self) -> u32 {
        self.size.1 * self.fineness
    }

    /// Width and height of the picture, pixels.
    pub(super) fn size(&self) -> (u32, u32) {
        self.size
    }

    /// The picture, brought back.
    ///
    /// # Errors
    /// [`RenderError::DeviceLost`], [`RenderError::OutOfMemory`].
    pub(super) fn read(&self, gpu: &Gpu) -> Result<Image<Straight>, RenderError> {
        let (width, height) = self.size;
        let stride = (width * 4).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("readback"),
            size: u64::from(stride) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.picture.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(stride),
                    rows_per_image: None,
                },
            },
            self.picture.size(),
        );
        gpu.queue.submit([encoder.finish()]);
        let bytes = mapped(gpu, &buffer)?;
        let rows = bytes.chunks_exact(stride as usize);
        let pixels = rows.flat_map(|row| {
            let texels = row[..width as usize * 4].chunks_exact(4);
            texels.map(|texel| Straight([texel[0], texel[1], texel[2], texel[3]]))
        });
        Ok(Image::from_pixels(width, height, pixels.collect()))
    }
}

/// What stands in a buffer that the card has written.
///
/// # Errors
/// [`RenderError::DeviceLost`].
pub(super) fn mapped(gpu: &Gpu, buffer: &wgpu::Buffer) -> Result<Vec<u8>, RenderError> {
    let (tell, told) = std::sync::mpsc::channel();
    buffer.map_async(wgpu::MapMode::Read, .., move |outcome| {
        // Nobody listens any more once the wait below has failed.
        let _ = tell.send(outcome);
    });
    gpu.wait()?;
    let lost = |reason: String| RenderError::DeviceLost(reason);
    match told.try_recv() {
        Ok(Ok(())) => {}
        Ok(Err(error)) => return Err(lost(error.to_string())),
        Err(_) => return Err(lost("a picture did not come back".to_owned())),
    }
    let range = buffer.get_mapped_range(..);
    let bytes = range.map_err(|error| lost(error.to_string()))?.to_vec();
    buffer.unmap();
    Ok(bytes)
}

fn texture(
    gpu: &Gpu,
    label: &str,
    (width, height): (u32, u32),
    format: TextureFormat,
    usage: TextureUsages,
) -> wgpu::Texture {
    gpu.device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage,
        view_formats: &[],
    })
}
