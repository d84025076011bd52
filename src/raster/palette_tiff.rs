//! TIFF files with a palette, which the crates `image` and `tiff` refuse.
//!
//! To all but their colours such files are grey ones: in a copy of the file the one number that
//! says "palette" is made to say "grey", the `tiff` crate reads it, and its greys are looked up in
//! the palette.
//!
//! Palettes of 1, 2, 4 and 8 bits; colours of 16 bits are rounded to 8. Nothing is transparent: the
//! format has no place for it.

use super::decode::upright;
use super::read::{PictureFormat, Refusal, blank};
use super::{Image, Straight};
use crate::base::asking_for_memory;
use image::metadata::Orientation;
use std::io::Cursor;
use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;

/// Decodes `bytes` if they are a TIFF file with a palette, once `check` agrees to the width and
/// height; `None` for all other files, damaged ones too.
pub(super) fn decode(
    bytes: &[u8],
    check: impl Fn(u32, u32, u8) -> Result<(), Refusal>,
) -> Option<Result<Image<Straight>, Refusal>> {
    let grey = declared_grey(bytes)?;
    let mut decoder = Decoder::new(Cursor::new(grey.as_slice())).ok()?;
    let Ok(ColorType::Gray(bits @ (1 | 2 | 4 | 8))) = decoder.colortype() else {
        return None;
    };
    let (width, height) = decoder.dimensions().ok()?;
    let palette: Vec<u16> = decoder.find_tag_unsigned_vec(Tag::ColorMap).ok()??;
    if palette.len() != 3 << bits {
        return None;
    }
    let orientation = decoder
        .find_tag_unsigned::<u8>(Tag::Orientation)
        .ok()
        .flatten();
    let orientation = orientation.and_then(Orientation::from_exif);
    Some(check(width, height, 3).and_then(|()| {
        let row_bytes = (width as usize * usize::from(bits)).div_ceil(8);
        let packed = unpacked(decoder, row_bytes * height as usize)?;
        let image = colored(&packed, row_bytes, bits, &palette, width, height)?;
        upright(image, orientation.unwrap_or(Orientation::NoTransforms))
    }))
}

/// A copy of the TIFF file in which the first picture is said to be grey; `None` unless the file
/// says that it has a palette.
fn declared_grey(bytes: &[u8]) -> Option<Vec<u8>> {
    const PHOTOMETRIC: u16 = 262;
    const PALETTE: u16 = 3;
    const BLACK_IS_ZERO: u16 = 1;
    let is_little = bytes.starts_with(b"II*\0");
    if !is_little && !bytes.starts_with(b"MM\0*") {
        return None;
    }
    let short = |at: usize| {
        let pair = bytes.get(at..at.checked_add(2)?)?.try_into().ok()?;
        Some(if is_little {
            u16::from_le_bytes(pair)
        } else {
            u16::from_be_bytes(pair)
        })
    };
    let first = bytes.get(4..8)?.try_into().ok()?;
    let directory = if is_little {
        u32::from_le_bytes(first)
    } else {
        u32::from_be_bytes(first)
    };
    let directory = directory as usize;
    let entries = (0..usize::from(short(directory)?)).map(|i| directory + 2 + 12 * i);
    let entry = entries
        .into_iter()
        .find(|&entry| short(entry) == Some(PHOTOMETRIC))?;
    if short(entry + 8)? != PALETTE {
        return None;
    }
    let mut copy = Vec::new();
    asking_for_memory(|| copy.try_reserve_exact(bytes.len())).ok()?;
    copy.extend_from_slice(bytes);
    let grey = if is_little {
        BLACK_IS_ZERO.to_le_bytes()
    } else {
        BLACK_IS_ZERO.to_be_bytes()
    };
    copy[entry + 8..entry + 10].copy_from_slice(&grey);
    Some(copy)
}

/// The numbers of colours, as they are packed in the file.
fn unpacked(decoder: Decoder<Cursor<&[u8]>>, count: usize) -> Result<Vec<u8>, Refusal> {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = count + 1024;
    limits.intermediate_buffer_size = 2 * count + (1 << 20);
    let damaged = |detail: String| Refusal::Damaged {
        format: PictureFormat::Tiff,
        detail,
    };
    match decoder.with_limits(limits).read_image() {
        Ok(DecodingResult::U8(packed)) if packed.len() >= count => Ok(packed),
        Ok(_) => Err(damaged(
            "its pixels are not numbers of its palette".to_owned(),
        )),
        Err(error) => Err(damaged(crate::base::one_line(&error.to_string()))),
    }
}

fn colored(
    packed: &[u8],
    row_bytes: usize,
    bits: u8,
    palette: &[u16],
    width: u32,
    height: u32,
) -> Result<Image<Straight>, Refusal> {
    let colors = palette.len() / 3;
    let rounded = |value: u16| ((u32::from(value) + 128) / 257) as u8;
    let color = |index: usize| {
        let channel = |number: usize| rounded(palette[number * colors + index]);
        Straight([channel(0), channel(1), channel(2), 255])
    };
    let mut pixels = blank(width, height, u64::from(width) * u64::from(height))?;
    let rows = packed
        .chunks(row_bytes)
        .zip(pixels.chunks_mut(width as usize));
    for (row, pixels) in rows {
        for (x, pixel) in pixels.iter_mut().enumerate() {
            let bit = x * usize::from(bits);
            let shift = 8 - usize::from(bits) - bit % 8;
            let index = usize::from(row[bit / 8]) >> shift & (colors - 1);
            *pixel = color(index);
        }
    }
    Ok(Image::from_pixels(width, height, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A TIFF file of 3×1 pixels with a palette of `bits`, its only strip being `strip`.
    fn file(bits: u16, strip: &[u8], palette: &[u16]) -> Vec<u8> {
        let entries: [(u16, u16, u32, u32); 9] = [
            (256, 3, 1, 3),
            (257, 3, 1, 1),
            (258, 3, 1, u32::from(bits)),
            (259, 3, 1, 1),
            (262, 3, 1, 3),
            (273, 4, 1, 8),
            (277, 3, 1, 1),
            (279, 4, 1, strip.len() as u32),
            (320, 3, palette.len() as u32, 16),
        ];
        let directory = 16 + 2 * palette.len() as u32;
        let mut bytes = b"II*\0".to_vec();
        bytes.extend(directory.to_le_bytes());
        bytes.extend(strip);
        bytes.resize(16, 0);
        bytes.extend(palette.iter().flat_map(|value| value.to_le_bytes()));
        bytes.extend((entries.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in entries {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(kind.to_le_bytes());
            bytes.extend(count.to_le_bytes());
            bytes.extend(value.to_le_bytes());
        }
        bytes.extend([0; 4]);
        bytes
    }

    #[test]
    fn packed_numbers_become_their_colours() {
        let gradient = |bits: u16| -> Vec<u16> {
            (0..3u16 << bits).map(|i| (i % (1 << bits)) * 257).collect()
        };
        let cases: [(u16, &[u8], [u8; 3]); 3] = [
            (1, &[0b0100_0000], [0, 1, 0]),
            (4, &[0x1f, 0x30], [1, 15, 3]),
            (8, &[7, 200, 255], [7, 200, 255]),
        ];
        for (bits, strip, expected) in cases {
            let file = file(bits, strip, &gradient(bits));
            let image = decode(&file, |_, _, _| Ok(())).unwrap().unwrap();
            let found: Vec<u8> = image.pixels().iter().map(|pixel| pixel.0[1]).collect();
            assert_eq!(found, expected, "{bits} bits");
        }
    }
}
