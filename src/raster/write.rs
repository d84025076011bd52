//! Pictures as PNG files.

use super::{Image, Straight};
use std::borrow::Cow;

/// How much time a PNG may take to become small.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Compression {
    /// Four times faster to write, a fifth larger: for previews and for large jobs.
    #[default]
    Fast,
    /// For files that are kept in a repository or shipped.
    Small,
}

impl Compression {
    pub(super) fn of_png(self) -> png::Compression {
        match self {
            Self::Fast => png::Compression::Fast,
            Self::Small => png::Compression::High,
        }
    }
}

/// `image` as the bytes of an RGBA PNG file, marked as sRGB.
pub fn encode_png(image: &Image<Straight>, compression: Compression) -> Vec<u8> {
    let bytes = Cow::Borrowed(bytemuck::cast_slice(image.pixels()));
    encoded(
        image.width(),
        image.height(),
        png::ColorType::Rgba,
        bytes,
        compression,
    )
}

/// `image` as the bytes of an RGB PNG file, marked as sRGB; its alpha is left out.
pub fn encode_opaque_png(image: &Image<Straight>, compression: Compression) -> Vec<u8> {
    let colors = image.pixels().iter().flat_map(|p| [p.0[0], p.0[1], p.0[2]]);
    encoded(
        image.width(),
        image.height(),
        png::ColorType::Rgb,
        Cow::Owned(colors.collect()),
        compression,
    )
}

/// `image` as the bytes of a JPEG file of `quality` 1 … 100; its alpha is left out.
///
/// The bytes depend on the version of the encoder.
pub fn encode_jpeg(image: &Image<Straight>, quality: u8) -> Vec<u8> {
    let colors: Vec<u8> = image
        .pixels()
        .iter()
        .flat_map(|p| [p.0[0], p.0[1], p.0[2]])
        .collect();
    let mut out = Vec::new();
    let mut encoder = ::image::codecs::jpeg::JpegEncoder::new_with_quality(&mut out, quality);
    encoder
        .encode(
            &colors,
            image.width(),
            image.height(),
            ::image::ExtendedColorType::Rgb8,
        )
        .expect("a Vec takes all bytes, and an image's pixels fill it");
    out
}

/// `image` as the bytes of an 8-bit grey PNG file.
pub fn encode_grey_png(image: &Image<u8>, compression: Compression) -> Vec<u8> {
    let bytes = Cow::Borrowed(image.pixels());
    encoded(
        image.width(),
        image.height(),
        png::ColorType::Grayscale,
        bytes,
        compression,
    )
}

fn encoded(
    width: u32,
    height: u32,
    color: png::ColorType,
    bytes: Cow<'_, [u8]>,
    compression: Compression,
) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, width, height);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(compression.of_png());
    let bug = "a Vec takes all bytes, and an image's pixels fill it";
    let mut writer = encoder.write_header().expect(bug);
    writer.write_image_data(&bytes).expect(bug);
    writer.finish().expect(bug);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_comes_back_as_it_was() {
        let pixels = (0..6u8)
            .map(|i| Straight([i, 2 * i, 255 - i, 40 * i]))
            .collect();
        let image = Image::from_pixels(3, 2, pixels);
        for compression in [Compression::Fast, Compression::Small] {
            let file = encode_png(&image, compression);
            let back = image::load_from_memory(&file).unwrap().into_rgba8();
            assert_eq!(
                back.as_raw().as_slice(),
                bytemuck::cast_slice::<_, u8>(image.pixels())
            );
            let file = encode_opaque_png(&image, compression);
            let back = image::load_from_memory(&file).unwrap().into_rgb8();
            let colors = back.pixels().zip(image.pixels());
            assert!(colors.into_iter().all(|(b, p)| b.0 == p.0[..3]));
        }
    }
}
