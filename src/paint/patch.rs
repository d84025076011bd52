//! The difference between two masks of one picture: what an undo step keeps.

use super::pack::{PackError, PackedTile};
use super::tiled::{TILE, Tile, TiledMask, area, joined};
use crate::raster::Rect;
use serde::{Deserialize, Serialize};

/// Most pixels of a mask that is read from a file: the most that pictures have.
const MOST_PIXELS: u64 = 20_000 * 20_000;

/// Which of the two masks a [`MaskPatch`] leads to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The older one: undo.
    Before,
    /// The newer one: redo.
    After,
}

/// The tiles in which two masks of equal size differ, as they were before and after.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct MaskPatch {
    /// Sides of both masks.
    size: (u32, u32),
    /// Index, before, after; ascending.
    tiles: Vec<(u32, PackedTile, PackedTile)>,
}

impl MaskPatch {
    /// What leads from `before` to `after`, which must be of one size; `None` when they are equal.
    ///
    /// Tiles that both share are told apart from others without a look at their pixels.
    ///
    /// # Panics
    /// When the sizes differ.
    pub fn between(before: &TiledMask, after: &TiledMask) -> Option<Self> {
        let size = |mask: &TiledMask| (mask.width(), mask.height());
        assert_eq!(size(before), size(after), "masks of one picture");
        let differing = (0..before.tiles().len()).filter(|&i| !before.has_same_tile(after, i));
        let packed = |mask: &TiledMask, i: usize| PackedTile::of(&mask.tiles()[i]);
        let tiles: Vec<_> = differing
            .map(|i| (i as u32, packed(before, i), packed(after, i)))
            .collect();
        (!tiles.is_empty()).then(|| Self {
            size: size(before),
            tiles,
        })
    }

    /// Makes `mask` the one on `side`, where it differs from the other.
    ///
    /// # Errors
    /// [`PackError::Damaged`] when the patch does not fit the mask; the mask is then unchanged.
    pub fn apply(&self, mask: &mut TiledMask, side: Side) -> Result<(), PackError> {
        if self.size != (mask.width(), mask.height()) {
            return Err(PackError::Damaged);
        }
        let tile = |(index, before, after): &(u32, PackedTile, PackedTile)| {
            let index = *index as usize;
            if index >= mask.tiles().len() {
                return Err(PackError::Damaged);
            }
            let packed = if side == Side::Before { before } else { after };
            Ok((index, packed.tile(area(mask.tile_rect(index)))?))
        };
        let tiles: Result<Vec<_>, _> = self.tiles.iter().map(tile).collect();
        for (index, tile) in tiles? {
            mask.set_tile(index, tile);
        }
        Ok(())
    }

    /// The smallest rectangle of whole tiles around what differs.
    pub fn bounds(&self) -> Option<Rect> {
        // Of a mask only its size counts here.
        let mask = TiledMask::filled(self.size.0, self.size.1, 0);
        let indices = self.tiles.iter().map(|(index, ..)| *index as usize);
        let rects = indices.filter(|&index| index < mask.tiles().len());
        rects.fold(None, |bounds, index| {
            joined(bounds, Some(mask.tile_rect(index)))
        })
    }

    /// Bytes in memory.
    pub fn memory_bytes(&self) -> usize {
        let tiles = self.tiles.iter();
        tiles
            .map(|(_, before, after)| {
                before.bytes().len()
                    + after.bytes().len()
                    + size_of::<(u32, PackedTile, PackedTile)>()
            })
            .sum()
    }
}

impl TiledMask {
    /// The mask as bytes for a file: width and height, then for each tile its length and bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = [self.width().to_le_bytes(), self.height().to_le_bytes()].concat();
        for tile in self.tiles() {
            let packed = PackedTile::of(tile);
            // At most 16 KiB and a byte.
            bytes.extend((packed.bytes().len() as u16).to_le_bytes());
            bytes.extend(packed.bytes());
        }
        bytes
    }

    /// The mask that [`TiledMask::to_bytes`] wrote.
    ///
    /// Memory is asked for tile by tile, as the bytes prove to hold them.
    ///
    /// # Errors
    /// [`PackError::Damaged`] for all other bytes.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, PackError> {
        let (width, rest) = number(bytes)?;
        let (height, mut rest) = number(rest)?;
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels > MOST_PIXELS {
            return Err(PackError::Damaged);
        }
        let count = u64::from(width.div_ceil(TILE)) * u64::from(height.div_ceil(TILE));
        // The shortest tile takes two bytes for its length and two for itself.
        if count > rest.len() as u64 / 4 {
            return Err(PackError::Damaged);
        }
        let mut mask = Self::from_tiles(width, height, vec![Tile::Uniform(0); count as usize]);
        for index in 0..count as usize {
            let (length, after) = rest.split_at_checked(2).ok_or(PackError::Damaged)?;
            let length = usize::from(u16::from_le_bytes([length[0], length[1]]));
            let (tile, after) = after.split_at_checked(length).ok_or(PackError::Damaged)?;
            let area = area(mask.tile_rect(index));
            mask.set_tile(index, PackedTile::from_bytes(tile).tile(area)?);
            rest = after;
        }
        rest.is_empty().then_some(mask).ok_or(PackError::Damaged)
    }
}

/// A number of four bytes and what follows it.
fn number(bytes: &[u8]) -> Result<(u32, &[u8]), PackError> {
    let (first, rest) = bytes.split_first_chunk::<4>().ok_or(PackError::Damaged)?;
    Ok((u32::from_le_bytes(*first), rest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn two_masks(x: u32, y: u32, label: u8) -> (TiledMask, TiledMask) {
        let before = TiledMask::filled(300, 200, 1);
        let mut after = before.clone();
        let rect = Rect {
            x,
            y,
            width: 90,
            height: 80,
        };
        after.edit(rect, |_, _, row| row.fill(label));
        (before, after)
    }

    #[test]
    fn equal_masks_have_no_difference() {
        let (before, after) = two_masks(3, 4, 1);
        assert_eq!(MaskPatch::between(&before, &after), None);
    }

    #[test]
    fn a_patch_for_another_size_changes_nothing() {
        let (before, after) = two_masks(3, 4, 2);
        let patch = MaskPatch::between(&before, &after).unwrap();
        let mut other = TiledMask::filled(100, 100, 0);
        assert!(patch.apply(&mut other, Side::After).is_err());
        assert_eq!(other, TiledMask::filled(100, 100, 0));
    }

    proptest! {
        #[test]
        fn a_patch_leads_both_ways(x in 0u32..280, y in 0u32..190, label in 0u8..4) {
            let (before, after) = two_masks(x, y, label);
            if let Some(patch) = MaskPatch::between(&before, &after) {
                let mut mask = before.clone();
                patch.apply(&mut mask, Side::After).unwrap();
                prop_assert_eq!(&mask, &after);
                patch.apply(&mut mask, Side::Before).unwrap();
                prop_assert_eq!(&mask, &before);
            }
            prop_assert_eq!(TiledMask::from_bytes(&after.to_bytes()), Ok(after));
        }

        #[test]
        fn damaged_bytes_are_no_mask_or_a_canonical_one(at in 0usize..400, flip in 1u8.., cut in 0usize..400) {
            let (_, mask) = two_masks(70, 60, 2);
            let mut bytes = mask.to_bytes();
            let at = at % bytes.len();
            prop_assert!(TiledMask::from_bytes(&bytes[..cut % bytes.len()]).is_err());
            bytes[at] ^= flip;
            if let Ok(read) = TiledMask::from_bytes(&bytes) {
                prop_assert!(read.is_canonical());
            }
        }
    }
}
