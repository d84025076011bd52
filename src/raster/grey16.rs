//! 16-bit grey PNG files, for what is measured and not seen: heights and radii.

use super::Image;
use super::write::Compression;
use png::{BitDepth, ColorType};
use std::io::Cursor;

/// Why some bytes are no 16-bit grey picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Grey16Error {
    /// Not a PNG file, or a damaged one.
    #[error("not a whole PNG file: {0}")]
    Damaged(String),
    /// A PNG file of another kind.
    #[error("expected 16-bit grey, found {found}")]
    OtherKind {
        /// Its colours and depth.
        found: String,
    },
    /// More pixels than are accepted.
    #[error("{width}×{height} pixels are more than the limit of {limit}×{limit}")]
    TooLarge {
        /// Width the header tells.
        width: u32,
        /// Height the header tells.
        height: u32,
        /// Longest side that is accepted.
        limit: u32,
    },
}

/// `image` as the bytes of a 16-bit grey PNG file. Its values are linear: it is not marked as sRGB.
pub fn encode_grey16_png(image: &Image<u16>, compression: Compression) -> Vec<u8> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, image.width(), image.height());
    encoder.set_color(ColorType::Grayscale);
    encoder.set_depth(BitDepth::Sixteen);
    encoder.set_source_gamma(png::ScaledFloat::new(1.0));
    encoder.set_compression(compression.of_png());
    let bytes: Vec<u8> = image
        .pixels()
        .iter()
        .flat_map(|value| value.to_be_bytes())
        .collect();
    let bug = "a Vec takes all bytes, and an image's pixels fill it";
    let mut writer = encoder.write_header().expect(bug);
    writer.write_image_data(&bytes).expect(bug);
    writer.finish().expect(bug);
    out
}

/// The picture in `bytes`, a 16-bit grey PNG file with sides of `longest_side` pixels at most.
///
/// Values stay as they stand in the file, whatever it says about gamma.
///
/// # Errors
/// [`Grey16Error`].
pub fn decode_grey16_png(bytes: &[u8], longest_side: u32) -> Result<Image<u16>, Grey16Error> {
    let damaged = |error: png::DecodingError| Grey16Error::Damaged(error.to_string());
    let mut reader = png::Decoder::new(Cursor::new(bytes))
        .read_info()
        .map_err(damaged)?;
    let info = reader.info();
    let (width, height) = (info.width, info.height);
    if (info.color_type, info.bit_depth) != (ColorType::Grayscale, BitDepth::Sixteen) {
        let found = format!("{:?} of {} bits", info.color_type, info.bit_depth as u8);
        return Err(Grey16Error::OtherKind { found });
    }
    if width.max(height) > longest_side {
        return Err(Grey16Error::TooLarge {
            width,
            height,
            limit: longest_side,
        });
    }
    let mut raw = vec![0; 2 * width as usize * height as usize];
    reader.next_frame(&mut raw).map_err(damaged)?;
    let values = raw
        .chunks_exact(2)
        .map(|pair| u16::from_be_bytes([pair[0], pair[1]]));
    Ok(Image::from_pixels(width, height, values.collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_come_back_as_they_were() {
        let image = Image::from_pixels(3, 2, vec![0, 1, 255, 256, 40_000, 65_535]);
        for compression in [Compression::Fast, Compression::Small] {
            let file = encode_grey16_png(&image, compression);
            assert_eq!(decode_grey16_png(&file, 3).unwrap(), image);
            assert!(matches!(
                decode_grey16_png(&file, 2),
                Err(Grey16Error::TooLarge { .. })
            ));
        }
    }

    #[test]
    fn other_files_and_damage_are_refused() {
        let eight_bit = super::super::encode_grey_png(&Image::filled(2, 2, 1), Compression::Fast);
        assert!(matches!(
            decode_grey16_png(&eight_bit, 9),
            Err(Grey16Error::OtherKind { .. })
        ));
        let whole = encode_grey16_png(&Image::filled(9, 9, 77), Compression::Fast);
        for end in 0..whole.len() - 12 {
            assert!(decode_grey16_png(&whole[..end], 9).is_err(), "cut at {end}");
        }
    }
}
