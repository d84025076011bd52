//! KTX2 textures, each level packed by Zstandard: pictures as BC7, BC3 or UASTC blocks with all mip
//! levels, and cubemaps of colours (8-bit sRGB, all mip levels) and of radii (32-bit floats, one level).
//!
//! Cubemaps are not in blocks, so that web pages and phones read them as well, and radii exactly.
//! Faces are in the order of the format, +X −X +Y −Y +Z −Z, which is ours.
//!
//! BC7 is for cards that read it (desktops): the best pictures, no transcoding. UASTC is for all
//! others and for glTF, whose `KHR_texture_basisu` takes nothing but the Basis Universal family. The other
//! member of that, ETC1S, has smaller files and worse pictures; its one encoder is a C++ library,
//! and the project builds with Rust alone. The packer is `ruzstd` (plain Rust), at its one level.
//!
//! Rows run down and columns to the right (`KTXorientation` `rd`); alpha is straight.

use super::blocks::{BlockFormat, CompressedLevels};
use super::mips::data_mips;
use super::uastc;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Cubemap, Image, Straight};
use ktx2::{
    ColorModel, ColorPrimaries, Format, Header, Index, LevelIndex, SupercompressionScheme,
    TransferFunction, dfd,
};
use rayon::prelude::*;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use std::num::NonZeroU8;

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
            Ok(zstd(blocks))
        })
        .collect::<Result<_, Cancelled>>()?;
    let format = match (texture.format, srgb) {
        (BlockFormat::Bc3, false) => Texels::Of(Format::BC3_UNORM_BLOCK),
        (BlockFormat::Bc3, true) => Texels::Of(Format::BC3_SRGB_BLOCK),
        (BlockFormat::Bc7, false) => Texels::Of(Format::BC7_UNORM_BLOCK),
        (BlockFormat::Bc7, true) => Texels::Of(Format::BC7_SRGB_BLOCK),
        (BlockFormat::Uastc, srgb) => Texels::Uastc {
            srgb,
            has_alpha: texture.has_alpha,
        },
    };
    let texture = Texture {
        format,
        type_size: 1,
        size: texture.size,
        faces: 1,
    };
    Ok(written(&texture, &packed))
}

/// The colours of a crown as a KTX2 cubemap with all mip levels, 8-bit sRGB.
///
/// # Errors
/// [`Cancelled`].
pub fn encode_ktx2_colors(map: &Cubemap<Straight>, cancel: &Cancel) -> Result<Vec<u8>, Cancelled> {
    let chains: Vec<Vec<Image<Straight>>> = map
        .faces()
        .par_iter()
        .map(|face| data_mips(face, cancel))
        .collect::<Result<_, Cancelled>>()?;
    let levels: Vec<usize> = (0..chains[0].len()).collect();
    let packed: Vec<(u64, Vec<u8>)> = levels
        .par_iter()
        .map(|&level| {
            let texels = chains.iter().flat_map(|chain| chain[level].pixels());
            let bytes: Vec<u8> = texels.flat_map(|texel| texel.0).collect();
            zstd(&bytes)
        })
        .collect();
    let texture = Texture {
        format: Texels::Of(Format::R8G8B8A8_SRGB),
        type_size: 1,
        size: [map.size(); 2],
        faces: 6,
    };
    Ok(written(&texture, &packed))
}

/// The radii of a crown as a KTX2 cubemap of one level, 32-bit floats, metres.
pub fn encode_ktx2_radii(map: &Cubemap<f32>) -> Vec<u8> {
    let texels = map.faces().iter().flat_map(|face| face.pixels());
    let bytes: Vec<u8> = texels.flat_map(|radius| radius.to_le_bytes()).collect();
    let texture = Texture {
        format: Texels::Of(Format::R32_SFLOAT),
        type_size: 4,
        size: [map.size(); 2],
        faces: 6,
    };
    written(&texture, &[zstd(&bytes)])
}

/// The number of bytes before packing, and the packed bytes.
fn zstd(bytes: &[u8]) -> (u64, Vec<u8>) {
    let packed = compress_to_vec(bytes, CompressionLevel::Fastest);
    (bytes.len() as u64, packed)
}

/// What the texels are.
#[derive(Clone, Copy)]
enum Texels {
    /// Of a format that Vulkan has a number for.
    Of(Format),
    /// UASTC, which has none.
    Uastc { srgb: bool, has_alpha: bool },
}

/// What a file holds.
struct Texture {
    format: Texels,
    /// Bytes of a number.
    type_size: u32,
    /// Width and height of the first level.
    size: [u32; 2],
    faces: u32,
}

/// The file of packed levels, the largest first.
fn written(texture: &Texture, packed: &[(u64, Vec<u8>)]) -> Vec<u8> {
    let descriptor = descriptor(texture.format);
    let keys = keys();
    let descriptor_at = Header::LENGTH + LevelIndex::LENGTH * packed.len();
    let keys_at = descriptor_at + descriptor.len();
    let header = Header {
        format: match texture.format {
            Texels::Of(format) => Some(format),
            Texels::Uastc { .. } => None,
        },
        type_size: texture.type_size,
        pixel_width: texture.size[0],
        pixel_height: texture.size[1],
        pixel_depth: 0,
        layer_count: 0,
        face_count: texture.faces,
        level_count: packed.len() as u32,
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
    out
}

/// The data format descriptor, with its total length in front.
fn descriptor(format: Texels) -> Vec<u8> {
    let basic = match format {
        Texels::Of(format) => dfd::Basic::from_format(format)
            .map(|(basic, _)| basic)
            .unwrap_or_else(|_| unreachable!("the crate knows all formats that are written here")),
        Texels::Uastc { srgb, has_alpha } => uastc_descriptor(srgb, has_alpha),
    };
    let block = dfd::Block::Basic(basic).to_vec();
    let total = (block.len() + 4) as u32;
    [total.to_le_bytes().as_slice(), &block].concat()
}

/// What UASTC texels are.
fn uastc_descriptor(srgb: bool, has_alpha: bool) -> dfd::Basic {
    /// `KHR_DF_CHANNEL_UASTC_RGB` and `_RGBA`.
    const CHANNELS: [u8; 2] = [0, 3];
    const SIDE: NonZeroU8 = NonZeroU8::new(4).unwrap();
    const BITS: NonZeroU8 = NonZeroU8::new(8 * uastc::BLOCK_BYTES as u8).unwrap();
    let sample = dfd::SampleInformation {
        bit_offset: 0,
        bit_length: BITS,
        channel_type: CHANNELS[usize::from(has_alpha)],
        channel_type_qualifiers: dfd::ChannelTypeQualifiers::empty(),
        sample_positions: [0; 4],
        lower: 0,
        upper: u32::MAX,
    };
    dfd::Basic {
        color_model: Some(ColorModel::UASTC),
        color_primaries: Some(ColorPrimaries::BT709),
        transfer_function: Some(if srgb {
            TransferFunction::SRGB
        } else {
            TransferFunction::Linear
        }),
        flags: dfd::DataFormatFlags::empty(),
        texel_block_dimensions: [SIDE, SIDE, NonZeroU8::MIN, NonZeroU8::MIN],
        bytes_planes: [uastc::BLOCK_BYTES as u8, 0, 0, 0, 0, 0, 0, 0],
        sample_information: vec![sample],
    }
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
