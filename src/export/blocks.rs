//! Block compression: 4×4 texels in 16 bytes: BC3 or BC7, as graphics cards read them, or UASTC.
//!
//! The encoder of the former is `block_compression`, a port of Intel's ISPC texture compressor to
//! plain Rust; that of the latter is ours.
//! Sides that are no multiples of 4 (the last mip levels) are continued by their last texel.

use super::uastc;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight};
use block_compression::encode::compress_rgba8;
use block_compression::{BC7Settings, CompressionVariant};
use rayon::prelude::*;

/// A format of blocks of 16 bytes with colour and alpha.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BlockFormat {
    /// DXT5: 5:6:5 colours and alpha of 8 levels a block; every card and old engines read it.
    Bc3,
    /// Better colours and sharper alpha; cards since 2010.
    Bc7,
    /// What readers turn into the blocks that their card knows; for KTX2 files alone.
    Uastc,
}

/// All mip levels of a texture as blocks: encoded once, for all files that hold them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CompressedLevels {
    pub(super) format: BlockFormat,
    /// Width and height of the first level, in texels.
    pub(super) size: [u32; 2],
    /// Whether any texel of the first level is not solid.
    pub(super) has_alpha: bool,
    /// Blocks of each level, row by row, the largest level first.
    pub(super) levels: Vec<Vec<u8>>,
}

impl CompressedLevels {
    /// The blocks of the mip chain `levels`.
    ///
    /// # Errors
    /// [`Cancelled`].
    ///
    /// # Panics
    /// When there is no level.
    pub fn of(
        levels: &[Image<Straight>],
        format: BlockFormat,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let blocks = levels
            .iter()
            .map(|level| compressed(level, format, cancel))
            .collect::<Result<_, Cancelled>>()?;
        Ok(Self {
            format,
            size: [levels[0].width(), levels[0].height()],
            has_alpha: levels[0].pixels().iter().any(|p| p.alpha() < u8::MAX),
            levels: blocks,
        })
    }

    /// Of which blocks.
    pub fn format(&self) -> BlockFormat {
        self.format
    }
}

/// Rows of blocks between two looks at the cancel flag.
const ROWS_AT_ONCE: u32 = 4;

/// `image` as blocks, row by row.
///
/// # Errors
/// [`Cancelled`].
pub fn compressed(
    image: &Image<Straight>,
    format: BlockFormat,
    cancel: &Cancel,
) -> Result<Vec<u8>, Cancelled> {
    let (width, height) = (
        image.width().next_multiple_of(4),
        image.height().next_multiple_of(4),
    );
    let mut texels = vec![Straight([0; 4]); width as usize * height as usize];
    for (y, row) in texels.chunks_exact_mut(width as usize).enumerate() {
        let from = image.row((y as u32).min(image.height() - 1));
        row[..from.len()].copy_from_slice(from);
        row[from.len()..].fill(from[from.len() - 1]);
    }
    let strip = width as usize * 4 * ROWS_AT_ONCE as usize;
    let mut blocks = vec![0; width as usize * height as usize];
    texels
        .par_chunks(strip)
        .zip(blocks.par_chunks_mut(strip))
        .try_for_each(|(texels, blocks)| {
            cancel.check()?;
            let rows = (texels.len() / width as usize) as u32;
            let bytes = bytemuck::cast_slice(texels);
            match variant(format) {
                Some(variant) => compress_rgba8(variant, bytes, blocks, width, rows, width * 4),
                None => uastc_rows(texels, width as usize, blocks),
            }
            Ok(())
        })?;
    Ok(blocks)
}

/// The library's name of a format that it knows.
fn variant(format: BlockFormat) -> Option<CompressionVariant> {
    match format {
        BlockFormat::Bc3 => Some(CompressionVariant::BC3),
        BlockFormat::Bc7 => Some(CompressionVariant::BC7(BC7Settings::alpha_ultrafast())),
        BlockFormat::Uastc => None,
    }
}

/// Rows of texels as rows of UASTC blocks.
fn uastc_rows(texels: &[Straight], width: usize, blocks: &mut [u8]) {
    let columns = width / 4;
    let places = blocks.chunks_exact_mut(uastc::BLOCK_BYTES).enumerate();
    for (at, place) in places {
        let first = at / columns * 4 * width + at % columns * 4;
        let block = std::array::from_fn(|i| texels[first + i / 4 * width + i % 4]);
        place.copy_from_slice(&uastc::block(&block));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use block_compression::decode::decompress_blocks_as_rgba8;

    #[test]
    fn smooth_pictures_survive_and_sides_need_no_multiple_of_four() {
        for format in [BlockFormat::Bc3, BlockFormat::Bc7] {
            for (width, height) in [(16, 8), (6, 3), (1, 1)] {
                let pixels = (0..width * height).map(|i| {
                    let (x, y) = ((i % width) as u8, (i / width) as u8);
                    Straight([40 + 3 * x, 120 - 2 * y, 60, 200 + 3 * y])
                });
                let image = Image::from_pixels(width, height, pixels.collect());
                let blocks = compressed(&image, format, &Cancel::new()).unwrap();
                let (w, h) = (width.next_multiple_of(4), height.next_multiple_of(4));
                assert_eq!(blocks.len(), (w * h) as usize);
                let mut back = vec![0; (w * h * 4) as usize];
                let variant = variant(format).unwrap();
                decompress_blocks_as_rgba8(variant, w, h, &blocks, &mut back);
                for y in 0..height {
                    for x in 0..width {
                        let at = ((y * w + x) * 4) as usize;
                        let found: [u8; 4] = back[at..at + 4].try_into().unwrap();
                        for (found, wanted) in found.iter().zip(image.at(x, y).0) {
                            assert!(found.abs_diff(wanted) <= 8, "{format:?} {width} ({x}, {y})");
                        }
                    }
                }
            }
        }
    }
}
