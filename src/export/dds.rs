//! DirectDraw surfaces: block-compressed textures with all their mip levels.
//!
//! BC3 is written with the old `DXT5` code, which every reader knows but which cannot say whether
//! values are sRGB; BC7 with the header of DirectX 10, which can.

use super::blocks::{BlockFormat, compressed};
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight};

/// Caps, height, width, pixel format, mip count, linear size are given.
const FLAGS: u32 = 0x1 | 0x2 | 0x4 | 0x1000 | 0x2_0000 | 0x8_0000;

/// Texture, complex, mipmap.
const CAPS: u32 = 0x1000 | 0x8 | 0x40_0000;

/// `DXGI_FORMAT_BC7_UNORM` and `DXGI_FORMAT_BC7_UNORM_SRGB`.
const DXGI_BC7: u32 = 98;

/// The mip chain `levels` as a DDS file; `srgb` says whether its values are colours.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// When there is no level.
pub fn encode_dds(
    levels: &[Image<Straight>],
    format: BlockFormat,
    srgb: bool,
    cancel: &Cancel,
) -> Result<Vec<u8>, Cancelled> {
    let first = &levels[0];
    let blocks = first.width().div_ceil(4) * first.height().div_ceil(4);
    let mut header = vec![124, FLAGS, first.height(), first.width(), blocks * 16, 0];
    header.push(levels.len() as u32);
    header.extend([0; 11]);
    // The pixel format: 32 bytes, a code of four letters.
    let code = match format {
        BlockFormat::Bc3 => b"DXT5",
        BlockFormat::Bc7 => b"DX10",
    };
    header.extend([32, 0x4, u32::from_le_bytes(*code), 0, 0, 0, 0, 0]);
    header.extend([CAPS, 0, 0, 0, 0]);
    if format == BlockFormat::Bc7 {
        // Format, two-dimensional, no flags, one surface, straight alpha.
        header.extend([DXGI_BC7 + u32::from(srgb), 3, 0, 1, 1]);
    }
    let mut out = b"DDS ".to_vec();
    out.extend(header.into_iter().flat_map(u32::to_le_bytes));
    for level in levels {
        out.extend(compressed(level, format, cancel)?);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{ReadLimits, read_image_from_memory};
    use std::path::Path;

    #[test]
    fn our_reader_gets_the_first_level_back() {
        let pixels = (0..64u8).map(|i| Straight([i * 2, 100, 50 + i, 255 - i]));
        let image = Image::from_pixels(8, 8, pixels.collect());
        let levels = super::super::data_mips(&image, &Cancel::new()).unwrap();
        for format in [BlockFormat::Bc3, BlockFormat::Bc7] {
            let file = encode_dds(&levels, format, true, &Cancel::new()).unwrap();
            let header = if format == BlockFormat::Bc3 { 128 } else { 148 };
            assert_eq!(file.len(), header + 64 + 3 * 16);
            let back = read_image_from_memory(&file, Path::new("a.dds"), ReadLimits::default());
            let back = back.unwrap();
            for (found, wanted) in back.pixels().iter().zip(image.pixels()) {
                let far = |(f, w): (&u8, &u8)| f.abs_diff(*w) > 20;
                assert!(
                    !found.0.iter().zip(&wanted.0).any(far),
                    "{found:?} {wanted:?}"
                );
            }
        }
    }
}
