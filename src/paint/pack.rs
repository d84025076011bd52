//! A tile made small: how undo steps and files hold tiles.
//!
//! Most tiles hold two labels with smooth borders between them. Such a tile becomes one bit a pixel
//! (2 KiB) and then LZ4 (some hundred bytes); what LZ4 does not make smaller stays as it is, so that
//! noise costs a bit a pixel and not a byte.

use super::tiled::Tile;
use serde::{Deserialize, Serialize};

/// Bytes that were to be a tile are none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PackError {
    /// The kind is none of those known, or its parts are missing or too long.
    #[error("a tile of the mask is damaged")]
    Damaged,
}

const UNIFORM: u8 = 0;
const TWO_PLAIN: u8 = 1;
const TWO_LZ4: u8 = 2;
const MANY_PLAIN: u8 = 3;
const MANY_LZ4: u8 = 4;

/// A tile in as few bytes as may be: its kind, then what that kind needs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PackedTile(Box<[u8]>);

impl PackedTile {
    pub(super) fn of(tile: &Tile) -> Self {
        let pixels = match tile {
            Tile::Uniform(label) => return Self([UNIFORM, *label].into()),
            Tile::Varied(pixels) => pixels,
        };
        let packed = match two_labels(pixels) {
            Some((low, high)) => {
                let bits = bits_where(pixels, high);
                smaller(&[TWO_PLAIN, low, high], &[TWO_LZ4, low, high], &bits)
            }
            None => smaller(&[MANY_PLAIN], &[MANY_LZ4], pixels),
        };
        Self(packed.into())
    }

    /// The bytes, for a file.
    pub fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// A tile from a file; whether it holds one is found out when it is unpacked.
    pub fn from_bytes(bytes: &[u8]) -> Self {
        Self(bytes.into())
    }

    /// The tile of `area` pixels.
    ///
    /// # Errors
    /// [`PackError::Damaged`] when the bytes are no tile of that size in its one canonical form.
    pub(super) fn tile(&self, area: usize) -> Result<Tile, PackError> {
        let pixels: Vec<u8> = match *self.0 {
            [UNIFORM, label] => return Ok(Tile::Uniform(label)),
            [kind @ (TWO_PLAIN | TWO_LZ4), low, high, ref rest @ ..] => {
                let bytes = unpacked(rest, area.div_ceil(8), kind == TWO_LZ4)?;
                let bit = |index: usize| bytes[index / 8] >> (index % 8) & 1 == 1;
                (0..area).map(|i| if bit(i) { high } else { low }).collect()
            }
            [kind @ (MANY_PLAIN | MANY_LZ4), ref rest @ ..] => {
                unpacked(rest, area, kind == MANY_LZ4)?
            }
            _ => return Err(PackError::Damaged),
        };
        match Tile::of(&pixels) {
            Tile::Uniform(_) => Err(PackError::Damaged),
            varied @ Tile::Varied(_) => Ok(varied),
        }
    }
}

/// `plain` and the bytes, or `packed` and the bytes through LZ4, whichever is shorter.
fn smaller(plain: &[u8], packed: &[u8], bytes: &[u8]) -> Vec<u8> {
    let compressed = lz4_flex::block::compress(bytes);
    if compressed.len() < bytes.len() {
        [packed, &compressed].concat()
    } else {
        [plain, bytes].concat()
    }
}

/// Exactly `length` bytes out of `bytes`.
fn unpacked(bytes: &[u8], length: usize, is_compressed: bool) -> Result<Vec<u8>, PackError> {
    let plain = if is_compressed {
        // Never asks for more than `length`, whatever the bytes say.
        lz4_flex::block::decompress(bytes, length).map_err(|_| PackError::Damaged)?
    } else {
        bytes.to_vec()
    };
    (plain.len() == length)
        .then_some(plain)
        .ok_or(PackError::Damaged)
}

/// The two labels of `pixels`, the smaller first, `None` when there are more (or one).
fn two_labels(pixels: &[u8]) -> Option<(u8, u8)> {
    let first = *pixels.first()?;
    let second = *pixels.iter().find(|label| **label != first)?;
    let only = pixels
        .iter()
        .all(|label| *label == first || *label == second);
    only.then(|| (first.min(second), first.max(second)))
}

/// One bit a pixel, the first in the lowest bit: whether it is `label`.
fn bits_where(pixels: &[u8], label: u8) -> Vec<u8> {
    let byte = |eight: &[u8]| {
        let bits = eight.iter().enumerate();
        bits.fold(0, |byte, (i, pixel)| byte | u8::from(*pixel == label) << i)
    };
    pixels.chunks(8).map(byte).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use proptest::prelude::*;

    #[test]
    fn a_disc_takes_hundreds_of_bytes_and_noise_a_bit_a_pixel() {
        let disc = |i: i32| u8::from((i % 128 - 40).pow(2) + (i / 128 - 50).pow(2) < 1600);
        let disc: Vec<u8> = (0..128 * 128).map(disc).collect();
        assert!(PackedTile::of(&Tile::of(&disc)).bytes().len() < 800);
        let mut random = Seed(3).random();
        let noise: Vec<u8> = (0..128 * 128).map(|_| random.below(2) as u8).collect();
        assert!(PackedTile::of(&Tile::of(&noise)).bytes().len() <= 2048 + 3);
    }

    #[test]
    fn what_is_not_canonical_is_refused() {
        let plain = [&[MANY_PLAIN][..], &[7; 16]].concat();
        assert!(PackedTile(plain.into()).tile(16).is_err());
        assert!(PackedTile([9, 9].into()).tile(16).is_err());
        assert!(PackedTile([].into()).tile(16).is_err());
    }

    proptest! {
        #[test]
        fn tiles_come_back(pixels in prop::collection::vec(0u8..4, 1..600)) {
            let tile = Tile::of(&pixels);
            prop_assert!(PackedTile::of(&tile).tile(pixels.len()) == Ok(tile));
        }

        #[test]
        fn any_bytes_give_a_tile_of_the_right_size_or_an_error(
            bytes in prop::collection::vec(any::<u8>(), 0..200),
            area in 1usize..500,
        ) {
            if let Ok(Tile::Varied(pixels)) = PackedTile(bytes.into()).tile(area) {
                prop_assert_eq!(pixels.len(), area);
            }
        }
    }
}
