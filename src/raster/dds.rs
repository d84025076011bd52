//! DDS, the texture format of games: what tree billboards are mostly shipped as.
//!
//! Reads the largest level of the first surface in any of the block compressions BC1 to BC7 (also
//! under their old names DXT1 to DXT5, ATI1 and ATI2), packed pixels of 8 to 32 bits described by
//! masks, grey, 256-colour palettes, and the 16-bit and float layouts. The blocks themselves are
//! decoded by `bcdec_rs`. Textures marked as premultiplied become straight; signed values are
//! shifted to 0…255; a missing blue is 0, as in two-channel normal maps.
//!
//! Layout: Microsoft, *Programming Guide for DDS* and *Reference for DDS*.

use super::decode::unit_to_u8;
use super::read::{PictureFormat, Refusal, blank};
use super::{Image, Premultiplied, Straight};

const FORMAT: PictureFormat = PictureFormat::Dds;

/// Decodes `bytes` once `check` agrees to the width and height in the header.
pub(super) fn decode(
    bytes: &[u8],
    check: impl Fn(u32, u32, u8) -> Result<(), Refusal>,
) -> Result<Image<Straight>, Refusal> {
    let cut_short = Refusal::Truncated { format: FORMAT };
    let header = Header::read(bytes).ok_or_else(|| cut_short.clone())?;
    let Surface {
        layout,
        premultiplied,
        start,
    } = header.surface(bytes)?;
    let (width, height) = (header.width, header.height);
    // The content is measured before memory is asked for, so no header can claim what is not there.
    check(width, height, 4)?;
    let data = bytes.get(start..).unwrap_or_default();
    if (data.len() as u64) < layout.bytes(width, height) {
        return Err(cut_short);
    }
    let mut pixels = blank(width, height, u64::from(width) * u64::from(height))?;
    match layout {
        Layout::Blocks(block) => decode_blocks(block, data, width as usize, &mut pixels),
        Layout::Packed(packed) => {
            decode_texels(packed.bytes, data, &mut pixels, |texel| packed.rgba(texel))
        }
        Layout::Words(words) => {
            decode_texels(words.bytes(), data, &mut pixels, |texel| words.rgba(texel))
        }
        Layout::Palette => {
            let (palette, indices) = data.split_at(PALETTE_BYTES);
            decode_texels(1, indices, &mut pixels, |texel| {
                let entry = &palette[usize::from(texel[0]) * 4..];
                [entry[0], entry[1], entry[2], entry[3]]
            });
        }
    }
    if premultiplied {
        for pixel in &mut pixels {
            *pixel = Premultiplied(pixel.0).straight();
        }
    }
    Ok(Image::from_pixels(width, height, pixels))
}

/// 256 entries of RGBA.
const PALETTE_BYTES: usize = 1024;

/// The fields of the file header that matter here.
struct Header {
    width: u32,
    height: u32,
    flags: u32,
    four_cc: [u8; 4],
    bits: u32,
    masks: [u32; 4],
}

/// Where the pixels begin and what they are.
struct Surface {
    layout: Layout,
    premultiplied: bool,
    start: usize,
}

impl Header {
    const BYTES: usize = 128;
    /// The header that follows when the code is `DX10`.
    const BYTES_WITH_EXTENSION: usize = Self::BYTES + 20;

    /// The header, `None` when the file is shorter than one.
    fn read(bytes: &[u8]) -> Option<Self> {
        let fixed = bytes.get(..Self::BYTES)?;
        let word = |at: usize| word_at(fixed, at);
        Some(Self {
            height: word(12),
            width: word(16),
            flags: word(80),
            four_cc: word(84).to_le_bytes(),
            bits: word(88),
            masks: [word(92), word(96), word(100), word(104)],
        })
    }

    fn surface(&self, bytes: &[u8]) -> Result<Surface, Refusal> {
        const FOUR_CC: u32 = 0x4;
        if self.flags & FOUR_CC == 0 {
            return Ok(Surface {
                layout: self.uncompressed().ok_or_else(|| {
                    unsupported(format!("{} bits, flags {:#x}", self.bits, self.flags))
                })?,
                premultiplied: false,
                start: Self::BYTES,
            });
        }
        if &self.four_cc == b"DX10" {
            let extended = bytes
                .get(..Self::BYTES_WITH_EXTENSION)
                .ok_or(Refusal::Truncated { format: FORMAT })?;
            let code = word_at(extended, Self::BYTES);
            const ALPHA_MODE: u32 = 7;
            const PREMULTIPLIED: u32 = 2;
            return Ok(Surface {
                layout: layout_of_dxgi(code)
                    .ok_or_else(|| unsupported(format!("DXGI format {code}")))?,
                premultiplied: word_at(extended, Self::BYTES + 16) & ALPHA_MODE == PREMULTIPLIED,
                start: Self::BYTES_WITH_EXTENSION,
            });
        }
        Ok(Surface {
            layout: layout_of_four_cc(self.four_cc)
                .ok_or_else(|| unsupported(format!("code {}", self.four_cc.escape_ascii())))?,
            premultiplied: matches!(&self.four_cc, b"DXT2" | b"DXT4"),
            start: Self::BYTES,
        })
    }

    /// The layout that the masks describe.
    fn uncompressed(&self) -> Option<Layout> {
        const ALPHA_PIXELS: u32 = 0x1;
        const ALPHA_ONLY: u32 = 0x2;
        const PALETTE: u32 = 0x20;
        const RGB: u32 = 0x40;
        const LUMINANCE: u32 = 0x2_0000;

        if self.flags & PALETTE != 0 {
            return Some(Layout::Palette);
        }
        let [r, g, b, a] = self.masks;
        let a = if self.flags & (ALPHA_PIXELS | ALPHA_ONLY) == 0 {
            0
        } else {
            a
        };
        let masks = match self.bits {
            // Some writers leave nonsense in the masks of plain grey.
            8 if self.flags & LUMINANCE != 0 && a == 0 => [0xff, 0xff, 0xff, 0],
            8 | 16 if self.flags & LUMINANCE != 0 => [r, r, r, a],
            8 | 16 | 24 | 32 if self.flags & RGB != 0 => [r, g, b, a],
            8 if self.flags & ALPHA_ONLY != 0 => [0, 0, 0, 0xff],
            _ => return None,
        };
        let colored = masks != [0; 4];
        colored.then(|| packed(self.bits as usize / 8, masks))
    }
}

fn word_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn unsupported(detail: String) -> Refusal {
    Refusal::Unsupported {
        format: FORMAT,
        detail,
    }
}

/// How pixels are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Layout {
    Blocks(Block),
    Packed(Packed),
    Words(Words),
    Palette,
}

fn packed(bytes: usize, masks: [u32; 4]) -> Layout {
    Layout::Packed(Packed { bytes, masks })
}

impl Layout {
    /// Size of the largest level.
    fn bytes(self, width: u32, height: u32) -> u64 {
        let pixels = u64::from(width) * u64::from(height);
        match self {
            Self::Blocks(block) => {
                let blocks = u64::from(width.div_ceil(4)) * u64::from(height.div_ceil(4));
                blocks.saturating_mul(block.bytes() as u64)
            }
            Self::Packed(packed) => pixels.saturating_mul(packed.bytes as u64),
            Self::Words(words) => pixels.saturating_mul(words.bytes() as u64),
            Self::Palette => pixels.saturating_add(PALETTE_BYTES as u64),
        }
    }
}

fn layout_of_four_cc(code: [u8; 4]) -> Option<Layout> {
    Some(match &code {
        b"DXT1" => Layout::Blocks(Block::Bc1),
        b"DXT2" | b"DXT3" => Layout::Blocks(Block::Bc2),
        b"DXT4" | b"DXT5" => Layout::Blocks(Block::Bc3),
        b"ATI1" | b"BC4U" => Layout::Blocks(Block::Bc4 { signed: false }),
        b"BC4S" => Layout::Blocks(Block::Bc4 { signed: true }),
        b"ATI2" | b"BC5U" => Layout::Blocks(Block::Bc5 { signed: false }),
        b"BC5S" => Layout::Blocks(Block::Bc5 { signed: true }),
        // Numbers of the old D3DFORMAT stand in for letters.
        [36, 0, 0, 0] => Layout::Words(Words::Unorm16),
        [113, 0, 0, 0] => Layout::Words(Words::Float16),
        [116, 0, 0, 0] => Layout::Words(Words::Float32),
        _ => return None,
    })
}

/// The layout of a number of `DXGI_FORMAT`; typeless ones are taken as plain, sRGB is what files
/// hold anyway.
fn layout_of_dxgi(code: u32) -> Option<Layout> {
    Some(match code {
        2 => Layout::Words(Words::Float32),
        10 => Layout::Words(Words::Float16),
        11 => Layout::Words(Words::Unorm16),
        24 => packed(4, [0x3ff, 0x3ff << 10, 0x3ff << 20, 3 << 30]),
        27..=29 => packed(4, [0xff, 0xff << 8, 0xff << 16, 0xff << 24]),
        49 => packed(2, [0xff, 0xff << 8, 0, 0]),
        61 => packed(1, [0xff, 0xff, 0xff, 0]),
        65 => packed(1, [0, 0, 0, 0xff]),
        70..=72 => Layout::Blocks(Block::Bc1),
        73..=75 => Layout::Blocks(Block::Bc2),
        76..=78 => Layout::Blocks(Block::Bc3),
        79 | 80 => Layout::Blocks(Block::Bc4 { signed: false }),
        81 => Layout::Blocks(Block::Bc4 { signed: true }),
        82 | 83 => Layout::Blocks(Block::Bc5 { signed: false }),
        84 => Layout::Blocks(Block::Bc5 { signed: true }),
        85 => packed(2, [0x1f << 11, 0x3f << 5, 0x1f, 0]),
        86 => packed(2, [0x1f << 10, 0x1f << 5, 0x1f, 1 << 15]),
        87 | 90 | 91 => packed(4, [0xff << 16, 0xff << 8, 0xff, 0xff << 24]),
        88 | 92 | 93 => packed(4, [0xff << 16, 0xff << 8, 0xff, 0]),
        94 | 95 => Layout::Blocks(Block::Bc6 { signed: false }),
        96 => Layout::Blocks(Block::Bc6 { signed: true }),
        97..=99 => Layout::Blocks(Block::Bc7),
        115 => packed(2, [0xf << 8, 0xf << 4, 0xf, 0xf << 12]),
        _ => return None,
    })
}

/// Bits of one small-endian number: red, green, blue, alpha; an empty alpha is opaque.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Packed {
    bytes: usize,
    masks: [u32; 4],
}

impl Packed {
    fn rgba(self, texel: &[u8]) -> [u8; 4] {
        let mut word = [0; 4];
        word[..self.bytes].copy_from_slice(texel);
        let word = u32::from_le_bytes(word);
        let [r, g, b, a] = self.masks;
        let alpha = if a == 0 { 255 } else { scaled(word, a) };
        [scaled(word, r), scaled(word, g), scaled(word, b), alpha]
    }
}

/// The bits of `word` under `mask` as 0…255, rounded to nearest.
fn scaled(word: u32, mask: u32) -> u8 {
    if mask == 0 {
        return 0;
    }
    let shift = mask.trailing_zeros();
    let (value, most) = (u64::from((word & mask) >> shift), u64::from(mask >> shift));
    ((value * 255 + most / 2) / most) as u8
}

/// Four numbers of more than 8 bits for each pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Words {
    Unorm16,
    Float16,
    Float32,
}

impl Words {
    fn bytes(self) -> usize {
        match self {
            Self::Unorm16 | Self::Float16 => 8,
            Self::Float32 => 16,
        }
    }

    fn rgba(self, texel: &[u8]) -> [u8; 4] {
        let half = |c: usize| u16::from_le_bytes([texel[2 * c], texel[2 * c + 1]]);
        std::array::from_fn(|c| match self {
            Self::Unorm16 => ((u32::from(half(c)) + 128) / 257) as u8,
            Self::Float16 => unit_to_u8(half_to_f32(half(c))),
            Self::Float32 => unit_to_u8(f32::from_bits(word_at(texel, 4 * c))),
        })
    }
}

/// The value of an IEEE 754 half; infinities become large, not-a-numbers stay so.
fn half_to_f32(bits: u16) -> f32 {
    let sign = if bits & 0x8000 == 0 { 1.0 } else { -1.0 };
    let (exponent, fraction) = (u32::from(bits >> 10 & 0x1f), u32::from(bits & 0x3ff));
    sign * match exponent {
        0 => fraction as f32 / (1 << 24) as f32,
        31 if fraction != 0 => f32::NAN,
        _ => f32::from_bits((exponent + 112) << 23 | fraction << 13),
    }
}

fn decode_texels(
    bytes: usize,
    data: &[u8],
    pixels: &mut [Straight],
    rgba: impl Fn(&[u8]) -> [u8; 4],
) {
    for (pixel, texel) in pixels.iter_mut().zip(data.chunks_exact(bytes)) {
        *pixel = Straight(rgba(texel));
    }
}

/// A block compression: 4×4 pixels in 8 or 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Block {
    Bc1,
    Bc2,
    Bc3,
    Bc4 { signed: bool },
    Bc5 { signed: bool },
    Bc6 { signed: bool },
    Bc7,
}

impl Block {
    fn bytes(self) -> usize {
        match self {
            Self::Bc1 | Self::Bc4 { .. } => 8,
            _ => 16,
        }
    }

    /// The 16 pixels of a block, row by row.
    fn rgba(self, block: &[u8]) -> [[u8; 4]; 16] {
        let mut rgba = [[0; 4]; 16];
        let bytes = rgba.as_flattened_mut();
        match self {
            Self::Bc1 => bcdec_rs::bc1(block, bytes, 16),
            Self::Bc2 => bcdec_rs::bc2(block, bytes, 16),
            Self::Bc3 => bcdec_rs::bc3(block, bytes, 16),
            Self::Bc7 => bcdec_rs::bc7(block, bytes, 16),
            Self::Bc4 { signed } => {
                let mut grey = [0.0; 16];
                bcdec_rs::bc4_float(block, &mut grey, 4, signed);
                rgba = grey.map(|value| {
                    let l = shifted(value, signed);
                    [l, l, l, 255]
                });
            }
            Self::Bc5 { signed } => {
                let mut pairs = [[0.0; 2]; 16];
                bcdec_rs::bc5_float(block, pairs.as_flattened_mut(), 8, signed);
                rgba = pairs.map(|[r, g]| [shifted(r, signed), shifted(g, signed), 0, 255]);
            }
            Self::Bc6 { signed } => {
                let mut triples = [[0.0; 3]; 16];
                bcdec_rs::bc6h_float(block, triples.as_flattened_mut(), 12, signed);
                rgba = triples.map(|[r, g, b]| [unit_to_u8(r), unit_to_u8(g), unit_to_u8(b), 255]);
            }
        }
        rgba
    }
}

/// −1…1 or 0…1 as 0…255.
fn shifted(value: f32, signed: bool) -> u8 {
    unit_to_u8(if signed { value * 0.5 + 0.5 } else { value })
}

/// Decodes all blocks; those at the right and lower edge may reach beyond the picture.
fn decode_blocks(block: Block, data: &[u8], width: usize, pixels: &mut [Straight]) {
    let mut blocks = data.chunks_exact(block.bytes());
    for band in pixels.chunks_mut(4 * width) {
        for (left, bytes) in (0..width).step_by(4).zip(&mut blocks) {
            let rgba = block.rgba(bytes);
            for (row, decoded) in band.chunks_exact_mut(width).zip(rgba.chunks_exact(4)) {
                for (pixel, &rgba) in row[left..].iter_mut().zip(decoded) {
                    *pixel = Straight(rgba);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn any_size(_: u32, _: u32, _: u8) -> Result<(), Refusal> {
        Ok(())
    }

    /// A file: the words of its pixel format from the flags on, then what follows the header.
    fn file(width: u32, height: u32, format: [u32; 7], rest: &[u8]) -> Vec<u8> {
        let mut words = [0u32; 32];
        words[0] = u32::from_le_bytes(*b"DDS ");
        words[1] = 124;
        (words[3], words[4]) = (height, width);
        words[20..27].copy_from_slice(&format);
        let header = words.iter().flat_map(|word| word.to_le_bytes());
        header.chain(rest.iter().copied()).collect()
    }

    fn coded(four_cc: &[u8; 4]) -> [u32; 7] {
        [4, u32::from_le_bytes(*four_cc), 0, 0, 0, 0, 0]
    }

    fn dxgi(code: u32, alpha_mode: u32, rest: &[u8]) -> Vec<u8> {
        let extension = [code, 3, 0, 1, alpha_mode];
        let extension = extension.iter().flat_map(|word| word.to_le_bytes());
        extension.chain(rest.iter().copied()).collect()
    }

    fn pixels(bytes: &[u8]) -> Vec<[u8; 4]> {
        let image = decode(bytes, any_size).unwrap();
        image.pixels().iter().map(|pixel| pixel.0).collect()
    }

    #[test]
    fn masks_tell_where_the_colours_are() {
        let bgr = [0x40, 0, 24, 0xff_0000, 0xff00, 0xff, 0];
        let rows = pixels(&file(2, 1, bgr, &[3, 2, 1, 6, 5, 4]));
        assert_eq!(rows, [[1, 2, 3, 255], [4, 5, 6, 255]]);
        let four_bits = [0x41, 0, 16, 0xf00, 0xf0, 0xf, 0xf000];
        assert_eq!(
            pixels(&file(1, 1, four_bits, &[0x21, 0x8f])),
            [[255, 34, 17, 136]]
        );
        let grey = [0x2_0000, 0, 8, 0xff00_0000, 0, 0, 0];
        assert_eq!(pixels(&file(1, 1, grey, &[9])), [[9, 9, 9, 255]]);
    }

    #[test]
    fn blocks_may_reach_beyond_the_picture() {
        // Colour 0 is pure red and colour 1 pure blue; column 0 red, column 1 blue.
        let block = [0x00, 0xf8, 0x1f, 0x00, 0x04, 0x04, 0x04, 0x04];
        let data = [block, block].concat();
        let rows = pixels(&file(2, 5, coded(b"DXT1"), &data));
        assert_eq!(rows, [[255, 0, 0, 255], [0, 0, 255, 255]].repeat(5));
    }

    #[test]
    fn premultiplied_textures_become_straight() {
        let rows = pixels(&file(1, 1, coded(b"DX10"), &dxgi(28, 2, &[64, 0, 32, 128])));
        assert_eq!(rows, [[128, 0, 64, 128]]);
        let rows = pixels(&file(1, 1, coded(b"DX10"), &dxgi(28, 1, &[64, 0, 32, 128])));
        assert_eq!(rows, [[64, 0, 32, 128]]);
    }

    #[test]
    fn halves_have_their_values() {
        let values = [0x0000, 0x3c00, 0xc000, 0x3555, 0x0001, 0x7bff].map(half_to_f32);
        assert_eq!(values[..3], [0.0, 1.0, -2.0]);
        assert!((values[3] - 1.0 / 3.0).abs() < 1e-4);
        assert_eq!(values[4], 2f32.powi(-24));
        assert_eq!(values[5], 65504.0);
        assert!(half_to_f32(0x7e00).is_nan());
    }

    #[test]
    fn content_that_is_not_there_is_noticed_before_memory_is_asked_for() {
        let cut_short = Err(Refusal::Truncated { format: FORMAT });
        let huge = file(u32::MAX, u32::MAX, coded(b"DXT5"), &[0; 16]);
        assert_eq!(decode(&huge, any_size).map(drop), cut_short);
        assert_eq!(decode(&huge[..127], any_size).map(drop), cut_short);
        let no_extension = file(4, 4, coded(b"DX10"), &[]);
        assert_eq!(decode(&no_extension, any_size).map(drop), cut_short);
        let unknown = decode(&file(4, 4, coded(b"ABCD"), &[0; 64]), any_size);
        assert!(unknown.unwrap_err().to_string().contains("code ABCD"));
    }
}
