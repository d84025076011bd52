//! KTX2 textures: BC7 (or BC3) blocks with all mip levels, each level packed by Zstandard.
//!
//! Why not BasisU (ETC1S, UASTC): the only encoder is a C++ library, and the project builds with
//! Rust alone. BC7 with supercompression is what the format offers beside it: larger files than
//! ETC1S, better pictures than both, no transcoding; but only for cards that read BC7 (desktops),
//! and not inside glTF, whose `KHR_texture_basisu` takes nothing but BasisU. The packer is `ruzstd`
//! (plain Rust), at its one level.
//!
//! Rows run down and columns to the right (`KTXorientation` `rd`); alpha is straight.

use super::blocks::{BlockFormat, CompressedLevels};
use crate::base::{Cancel, Cancelled};
use ktx2::{Format, Header, Index, LevelIndex, SupercompressionScheme, dfd};
use rayon::prelude::*;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

/// `texture` as a KTX2 file; `srgb` says whether its values are colours.
///
/// # Errors
/// [`Cancelled`].
pub fn encode_ktx2(
    texture: &CompressedLevels,
    srgb: bool,
    cancel: &Cancel,
) -> Result<Vec<u8>, Cancelled> {
    let levels = &texture.levels;
    let packed: Vec<(u64, Vec<u8>)> = levels
        .par_iter()
        .map(|blocks| {
            cancel.check()?;
            let packed = compress_to_vec(blocks.as_slice(), CompressionLevel::Fastest);
            Ok((blocks.len() as u64, packed))
        })
        .collect::<Result<_, Cancelled>>()?;
    let format = match (texture.format, srgb) {
        (BlockFormat::Bc3, false) => Format::BC3_UNORM_BLOCK,
        (BlockFormat::Bc3, true) => Format::BC3_SRGB_BLOCK,
        (BlockFormat::Bc7, false) => Format::BC7_UNORM_BLOCK,
        (BlockFormat::Bc7, true) => Format::BC7_SRGB_BLOCK,
    };
    let descriptor = descriptor(format);
    let keys = keys();
    let descriptor_at = Header::LENGTH + LevelIndex::LENGTH * levels.len();
    let keys_at = descriptor_at + descriptor.len();
    let header = Header {
        format: Some(format),
        type_size: 1,
        pixel_width: texture.size[0],
        pixel_height: texture.size[1],
        pixel_depth: 0,
        layer_count: 0,
        face_count: 1,
        level_count: levels.len() as u32,
        supercompression_scheme: Some(SupercompressionScheme::Zstandard),
        index: Index {
            dfd_byte_offset: descriptor_at as u32,
            dfd_byte_length: descriptor.len() as u32,
            kvd_byte_offset: keys_at as u32,
            kvd_byte_length: keys.len() as u32,
            sgd_byte_offset: 0,
            sgd_byte_length: 0,
        },
    };
    let mut out = header.as_bytes().to_vec();
    // The smallest level comes first in the file, the largest first in the index.
    let mut end = (keys_at + keys.len()) as u64;
    let mut index = Vec::new();
    for (length, bytes) in packed.iter().rev() {
        let level = LevelIndex {
            byte_offset: end,
            byte_length: bytes.len() as u64,
            uncompressed_byte_length: *length,
        };
        index.push(level.as_bytes());
        end += bytes.len() as u64;
    }
    out.extend(index.iter().rev().flatten());
    out.extend(descriptor);
    out.extend(keys);
    for (_, bytes) in packed.iter().rev() {
        out.extend(bytes);
    }
    Ok(out)
}

/// The data format descriptor, with its total length in front.
fn descriptor(format: Format) -> Vec<u8> {
    let (basic, _) = dfd::Basic::from_format(format)
        .unwrap_or_else(|_| unreachable!("the crate knows BC3, BC7 and their sRGB forms"));
    let block = dfd::Block::Basic(basic).to_vec();
    let total = (block.len() + 4) as u32;
    [total.to_le_bytes().as_slice(), &block].concat()
}

/// Keys and values, sorted by key, each padded to 4 bytes.
fn keys() -> Vec<u8> {
    let writer = concat!("boscage ", env!("CARGO_PKG_VERSION"));
    let mut out = Vec::new();
    for (key, value) in [("KTXorientation", "rd"), ("KTXwriter", writer)] {
        let entry = format!("{key}\0{value}\0");
        out.extend((entry.len() as u32).to_le_bytes());
        out.extend(entry.as_bytes());
        out.resize(out.len().next_multiple_of(4), 0);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Image, Straight};
    use block_compression::decode::decompress_blocks_as_rgba8;
    use block_compression::{BC7Settings, CompressionVariant};
    use std::io::Read as _;

    #[test]
    fn the_reader_crate_gets_every_level_back() {
        let pixels = (0..16 * 32).map(|i| Straight([(i / 4) as u8, 90, 30, 255 - (i / 8) as u8]));
        let image = Image::from_pixels(16, 32, pixels.collect());
        let levels = super::super::data_mips(&image, &Cancel::new()).unwrap();
        let texture = CompressedLevels::of(&levels, BlockFormat::Bc7, &Cancel::new()).unwrap();
        let file = encode_ktx2(&texture, true, &Cancel::new()).unwrap();
        let reader = ktx2::Reader::new(&file).unwrap();
        let header = reader.header();
        assert_eq!(header.format, Some(Format::BC7_SRGB_BLOCK));
        assert_eq!((header.pixel_width, header.pixel_height), (16, 32));
        assert_eq!(reader.is_alpha_premultiplied(), Some(false));
        assert!(
            reader
                .key_value_data()
                .any(|(key, value)| key == "KTXorientation" && value == b"rd\0")
        );
        assert_eq!(reader.levels().len(), levels.len());
        for (level, wanted) in reader.levels().zip(&levels) {
            let mut blocks = Vec::new();
            let mut unpacked = ruzstd::decoding::StreamingDecoder::new(level.data).unwrap();
            unpacked.read_to_end(&mut blocks).unwrap();
            assert_eq!(blocks.len() as u64, level.uncompressed_byte_length);
            let (w, h) = (
                wanted.width().next_multiple_of(4),
                wanted.height().next_multiple_of(4),
            );
            let mut back = vec![0; (w * h * 4) as usize];
            let variant = CompressionVariant::BC7(BC7Settings::alpha_ultrafast());
            decompress_blocks_as_rgba8(variant, w, h, &blocks, &mut back);
            for (channel, value) in wanted.at(0, 0).0.iter().enumerate() {
                assert!(back[channel].abs_diff(*value) < 12);
            }
        }
    }
}
