//! DirectDraw surfaces: block-compressed textures with all their mip levels.
//!
//! BC3 is written with the old `DXT5` code, which every reader knows but which cannot say whether
//! values are sRGB; BC7 with the header of DirectX 10, which can.

use super::blocks::{BlockFormat, CompressedLevels};

/// Caps, height, width, pixel format, mip count, linear size are given.
const FLAGS: u32 = 0x1 | 0x2 | 0x4 | 0x1000 | 0x2_0000 | 0x8_0000;

/// Texture, complex, mipmap.
const CAPS: u32 = 0x1000 | 0x8 | 0x40_0000;

/// `DXGI_FORMAT_BC7_UNORM` and `DXGI_FORMAT_BC7_UNORM_SRGB`.
const DXGI_BC7: u32 = 98;

/// `texture` as a DDS file; `srgb` says whether its values are colours.
///
/// # Panics
/// For UASTC, which the format does not know.
pub fn encode_dds(texture: &CompressedLevels, srgb: bool) -> Vec<u8> {
    let [width, height] = texture.size;
    let blocks = width.div_ceil(4) * height.div_ceil(4);
    let mut header = vec![124, FLAGS, height, width, blocks * 16, 0];
    header.push(texture.levels.len() as u32);
    header.extend([0; 11]);
    // The pixel format: 32 bytes, a code of four letters.
    let code = match texture.format {
        BlockFormat::Bc3 => b"DXT5",
        BlockFormat::Bc7 => b"DX10",
        BlockFormat::Uastc => panic!("there is no UASTC in DDS files"),
    };
    header.extend([32, 0x4, u32::from_le_bytes(*code), 0, 0, 0, 0, 0]);
    header.extend([CAPS, 0, 0, 0, 0]);
    if texture.format == BlockFormat::Bc7 {
        // Format, two-dimensional, no flags, one surface, straight alpha.
        header.extend([DXGI_BC7 + u32::from(srgb), 3, 0, 1, 1]);
    }
    let mut out = b"DDS ".to_vec();
    out.extend(header.into_iter().flat_map(u32::to_le_bytes));
    out.extend(texture.levels.iter().flatten());
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Cancel;
    use crate::raster::{Image, ReadLimits, Straight, read_image_from_memory};
    use std::path::Path;

    #[test]
    fn our_reader_gets_the_first_level_back() {
        let pixels = (0..64u8).map(|i| Straight([i * 2, 100, 50 + i, 255 - i]));
        let image = Image::from_pixels(8, 8, pixels.collect());
        let levels = super::super::data_mips(&image, &Cancel::new()).unwrap();
        for format in [BlockFormat::Bc3, BlockFormat::Bc7] {
            let texture = CompressedLevels::of(&levels, format, &Cancel::new()).unwrap();
            let file = encode_dds(&texture, true);
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
