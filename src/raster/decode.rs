//! Pictures through the `image` crate: PNG, JPEG, WebP, TGA, TIFF and BMP.
//!
//! The crate's own `DynamicImage` aborts the process when memory runs out, so the pixels are
//! decoded into a buffer of ours, large enough for both what the file holds and for RGBA, and made
//! RGBA where they are.

use super::envelope::Envelope;
use super::read::{PictureFormat, Refusal, blank};
use super::{Image, Straight};
use crate::base::{asking_for_memory, one_line};
use image::error::UnsupportedErrorKind;
use image::metadata::Orientation;
use image::{ColorType, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::error::Error;
use std::io::Cursor;

/// Decodes `bytes` once `check` agrees to the width and height in the header.
pub(super) fn decode(
    bytes: &[u8],
    format: PictureFormat,
    envelope: Envelope,
    check: impl Fn(u32, u32, u8) -> Result<(), Refusal>,
) -> Result<Image<Straight>, Refusal> {
    /// For what comes before the pixels: colour profiles and texts, compressed by any factor.
    const HEADER_BYTES: u64 = 64 << 20;

    let refused = |error| refusal(&error, format);
    let mut limits = Limits::no_limits();
    limits.max_alloc = Some(HEADER_BYTES);
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format_there(format));
    reader.limits(limits.clone());
    let mut decoder = reader.into_decoder().map_err(refused)?;
    let (width, height) = decoder.dimensions();
    check(width, height, decoder.color_type().channel_count())?;

    // A damaged note on the orientation is no reason to refuse the picture.
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let color = decoder.color_type();
    let decoded_bytes = decoder.total_bytes();
    let pixels = u64::from(width) * u64::from(height);
    let mut buffer = blank(width, height, pixels.max(decoded_bytes.div_ceil(4)))?;
    let scratch_bytes = scratch_bytes(format, envelope, pixels, decoded_bytes);
    if !could_allocate(scratch_bytes) {
        return Err(Refusal::OutOfMemory { width, height });
    }
    limits.max_alloc = Some(decoded_bytes + scratch_bytes + HEADER_BYTES);
    decoder.set_limits(limits).map_err(refused)?;
    let raw: &mut [u8] = bytemuck::cast_slice_mut(&mut buffer);
    decoder
        .read_image(&mut raw[..decoded_bytes as usize])
        .map_err(refused)?;

    make_rgba(raw, color, pixels as usize).ok_or_else(|| Refusal::Unsupported {
        format,
        detail: format!("{color:?}"),
    })?;
    buffer.truncate(pixels as usize);
    upright(Image::from_pixels(width, height, buffer), orientation)
}

fn format_there(format: PictureFormat) -> ImageFormat {
    match format {
        PictureFormat::Png => ImageFormat::Png,
        PictureFormat::Jpeg => ImageFormat::Jpeg,
        PictureFormat::WebP => ImageFormat::WebP,
        PictureFormat::Tga => ImageFormat::Tga,
        PictureFormat::Tiff => ImageFormat::Tiff,
        PictureFormat::Bmp => ImageFormat::Bmp,
        PictureFormat::Dds => ImageFormat::Dds,
    }
}

/// What the decoder will ask for besides our buffer, rounded up.
fn scratch_bytes(format: PictureFormat, envelope: Envelope, pixels: u64, decoded: u64) -> u64 {
    /// Rows, tables and windows that do not grow with the picture's height.
    const STEADY: u64 = 16 << 20;
    let growing = match format {
        // Four components at most of 16-bit coefficients.
        PictureFormat::Jpeg if envelope.is_progressive() => 8 * pixels,
        // All planes or the ARGB words, and a copy where the picture is one frame of a canvas.
        PictureFormat::WebP => 2 * decoded,
        // One buffer for the picture (CMYK has a component more) and one for a strip, which may be
        // all of it.
        PictureFormat::Tiff => 3 * decoded,
        _ => 0,
    };
    STEADY + growing
}

/// Whether that much memory can be had now: decoders abort the process where it cannot.
fn could_allocate(bytes: u64) -> bool {
    usize::try_from(bytes).is_ok_and(|bytes| {
        let mut rehearsal = Vec::<u8>::new();
        let had = asking_for_memory(|| rehearsal.try_reserve_exact(bytes)).is_ok();
        // Kept from the compiler, which may leave out an allocation that nobody looks at.
        std::hint::black_box(&rehearsal);
        had
    })
}

/// Turns the first `count` pixels in `raw` from `color` into RGBA, in place.
fn make_rgba(raw: &mut [u8], color: ColorType, count: usize) -> Option<()> {
    let half = |high, low| ((u32::from(u16::from_ne_bytes([high, low])) + 128) / 257) as u8;
    let unit = |bytes: [u8; 4]| unit_to_u8(f32::from_ne_bytes(bytes));
    match color {
        ColorType::L8 => spread(raw, count, |[l]| [l, l, l, 255]),
        ColorType::La8 => spread(raw, count, |[l, a]| [l, l, l, a]),
        ColorType::Rgb8 => spread(raw, count, |[r, g, b]| [r, g, b, 255]),
        ColorType::Rgba8 => {}
        ColorType::L16 => spread(raw, count, |[l0, l1]| {
            let l = half(l0, l1);
            [l, l, l, 255]
        }),
        ColorType::La16 => spread(raw, count, |[l0, l1, a0, a1]| {
            let l = half(l0, l1);
            [l, l, l, half(a0, a1)]
        }),
        ColorType::Rgb16 => spread(raw, count, |[r0, r1, g0, g1, b0, b1]| {
            [half(r0, r1), half(g0, g1), half(b0, b1), 255]
        }),
        ColorType::Rgba16 => spread(raw, count, |[r0, r1, g0, g1, b0, b1, a0, a1]| {
            [half(r0, r1), half(g0, g1), half(b0, b1), half(a0, a1)]
        }),
        ColorType::Rgb32F => spread(raw, count, |texel: [u8; 12]| {
            let [r, g, b] = bytemuck::cast::<_, [[u8; 4]; 3]>(texel).map(unit);
            [r, g, b, 255]
        }),
        ColorType::Rgba32F => spread(raw, count, |texel: [u8; 16]| {
            bytemuck::cast::<_, [[u8; 4]; 4]>(texel).map(unit)
        }),
        // The enum may grow.
        _ => return None,
    }
    Some(())
}

/// 0…1 as 0…255; what is outside goes to the nearer end, not-a-number to 0.
pub(super) fn unit_to_u8(value: f32) -> u8 {
    (value * 255.0 + 0.5) as u8
}

/// Replaces `count` texels of N bytes by 4 bytes each, where they are: from the back when they
/// grow and from the front when they shrink, so that none is overwritten before it was read.
fn spread<const N: usize>(raw: &mut [u8], count: usize, rgba: impl Fn([u8; N]) -> [u8; 4]) {
    let mut one = |index: usize| {
        let mut texel = [0; N];
        texel.copy_from_slice(&raw[index * N..][..N]);
        raw[index * 4..][..4].copy_from_slice(&rgba(texel));
    };
    if N < 4 {
        (0..count).rev().for_each(&mut one);
    } else {
        (0..count).for_each(&mut one);
    }
}

/// `image` turned as `orientation` tells to show it.
pub(super) fn upright(
    image: Image<Straight>,
    orientation: Orientation,
) -> Result<Image<Straight>, Refusal> {
    let (width, height) = (image.width(), image.height());
    // Where the pixel shown at (x, y) is stored.
    let (right, bottom) = (width - 1, height - 1);
    let stored = |x: u32, y: u32| match orientation {
        Orientation::NoTransforms => (x, y),
        Orientation::FlipHorizontal => (right - x, y),
        Orientation::Rotate180 => (right - x, bottom - y),
        Orientation::FlipVertical => (x, bottom - y),
        Orientation::Rotate90FlipH => (y, x),
        Orientation::Rotate90 => (y, bottom - x),
        Orientation::Rotate270FlipH => (right - y, bottom - x),
        Orientation::Rotate270 => (right - y, x),
    };
    let (shown_width, shown_height) = match orientation {
        Orientation::NoTransforms => return Ok(image),
        Orientation::FlipHorizontal | Orientation::Rotate180 | Orientation::FlipVertical => {
            (width, height)
        }
        _ => (height, width),
    };
    let mut pixels = blank(width, height, u64::from(width) * u64::from(height))?;
    for (y, row) in (0..).zip(pixels.chunks_exact_mut(shown_width as usize)) {
        for (x, pixel) in (0..).zip(row) {
            let (x, y) = stored(x, y);
            *pixel = image.at(x, y);
        }
    }
    Ok(Image::from_pixels(shown_width, shown_height, pixels))
}

/// What a decoder's error means to the user.
fn refusal(error: &image::ImageError, format: PictureFormat) -> Refusal {
    if ends_early(error) {
        return Refusal::Truncated { format };
    }
    // The crate wraps the decoder's own words in "Format error decoding Png:".
    let words = |error: &dyn Error| {
        let inner = error.source().map(ToString::to_string);
        short_line(&inner.unwrap_or_else(|| error.to_string()))
    };
    match error {
        image::ImageError::Unsupported(error) => Refusal::Unsupported {
            format,
            detail: short_line(&match error.kind() {
                UnsupportedErrorKind::Color(color) => format!("{color:?}"),
                UnsupportedErrorKind::GenericFeature(feature) => feature,
                _ => error.to_string(),
            }),
        },
        image::ImageError::Limits(_) => Refusal::Damaged {
            format,
            detail: "it asks for far more memory than its picture needs".to_owned(),
        },
        image::ImageError::Decoding(error) => Refusal::Damaged {
            format,
            detail: words(error),
        },
        error => Refusal::Damaged {
            format,
            detail: words(error),
        },
    }
}

/// Whether the decoder wanted more bytes than there are, however deep it says so.
fn ends_early(error: &(dyn Error + 'static)) -> bool {
    let mut next = Some(error);
    while let Some(error) = next {
        if let Some(error) = error.downcast_ref::<std::io::Error>()
            && error.kind() == std::io::ErrorKind::UnexpectedEof
        {
            return true;
        }
        next = error.source();
    }
    false
}

/// A decoder's words on one line of bearable length.
fn short_line(words: &str) -> String {
    const LONGEST: usize = 120;
    // Some decoders quote their own words, line break and all.
    let words = words.trim_matches('"').trim().trim_end_matches("\\n");
    let line = one_line(words.trim_end_matches('.'));
    match line.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}…", &line[..end]),
        None => line,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_grow_and_shrink_in_place() {
        let mut raw = [1, 2, 3, 4, 5, 6, 0, 0];
        spread(&mut raw, 2, |[r, g, b]: [u8; 3]| [r, g, b, 255]);
        assert_eq!(raw, [1, 2, 3, 255, 4, 5, 6, 255]);
        let mut raw = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        spread(&mut raw, 2, |t: [u8; 6]| [t[0], t[2], t[4], 255]);
        assert_eq!(raw[..8], [0, 2, 4, 255, 6, 8, 10, 255]);
    }

    #[test]
    fn floats_are_clamped_and_rounded() {
        let values = [-1.0, 0.0, 0.5, 1.0, 7.0, f32::NAN, f32::INFINITY];
        assert_eq!(values.map(unit_to_u8), [0, 0, 128, 255, 255, 0, 255]);
    }

    #[test]
    fn memory_that_does_not_exist_is_not_had() {
        assert!(could_allocate(1 << 20));
        assert!(!could_allocate(1 << 60));
        assert!(blank(1, 1, 1 << 60).is_err());
    }
}
