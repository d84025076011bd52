//! Steps that can be undone: differences between states.

use super::content::{Content, PhotoId, State, packed_content};
use super::legacy;
use crate::base::Digest;
use crate::paint::{MaskPatch, Side, TiledMask};
use crate::raster::Rect;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Most bytes of one state's content; settings of a thousand favourites take a hundred thousand.
const MOST_CONTENT_BYTES: usize = 64 << 20;

/// First bytes of a content as it is packed now. Those of older ones cannot be: they begin with the
/// length of a title. The third counts up whenever a field comes or goes; see [`super::legacy`].
const MARK: [u8; 3] = [0xff, 0xff, 3];

/// The same before crowns had leaves.
const LEAFLESS: [u8; 3] = [0xff, 0xff, 2];

/// The same before outlines were moved.
const UNSHAPED: [u8; 3] = [0xff, 0xff, 1];

/// A step does not fit the state it is applied to: only files that lie can bring that about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("the history does not fit the project")]
pub(super) struct Misfit;

/// What a change, an undo or a redo made different.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changed {
    /// Whether anything but masks did.
    pub content: bool,
    /// Photographs whose labels did, and where; `None`: everywhere, for it came or went.
    pub masks: Vec<(PhotoId, Option<Rect>)>,
}

impl Changed {
    /// Whether nothing did.
    pub fn is_nothing(&self) -> bool {
        !self.content && self.masks.is_empty()
    }
}

/// One step: from the state before a gesture to the one after it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Step {
    /// What the menu calls it.
    pub(super) label: String,
    content: Option<(PackedContent, PackedContent)>,
    masks: Vec<(PhotoId, MaskChange)>,
    /// The photographs that either state needs, when they are not the same in both.
    blobs: BTreeSet<Digest>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum MaskChange {
    Painted(MaskPatch),
    /// The mask as it came, in the form of files.
    Came(Vec<u8>),
    Went(Vec<u8>),
}

/// A content, compressed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct PackedContent {
    length: u32,
    lz4: Vec<u8>,
}

impl PackedContent {
    fn of(content: &Content) -> Self {
        let bytes = [&MARK[..], &packed_content(content)].concat();
        Self {
            length: bytes.len() as u32,
            lz4: lz4_flex::block::compress(&bytes),
        }
    }

    fn content(&self) -> Result<Content, Misfit> {
        let length = self.length as usize;
        // LZ4 makes nothing more than 255 times smaller.
        if length > MOST_CONTENT_BYTES || length / 256 > self.lz4.len() {
            return Err(Misfit);
        }
        let bytes = lz4_flex::block::decompress(&self.lz4, length).map_err(|_| Misfit)?;
        if let Some(bytes) = bytes.strip_prefix(&MARK) {
            return postcard::from_bytes(bytes).map_err(|_| Misfit);
        }
        let older = if let Some(bytes) = bytes.strip_prefix(&LEAFLESS) {
            legacy::leafless_content(bytes)
        } else if let Some(bytes) = bytes.strip_prefix(&UNSHAPED) {
            legacy::unshaped_content(bytes)
        } else {
            legacy::content(&bytes)
        };
        older.ok_or(Misfit)
    }
}

impl Step {
    /// The difference of two states, `None` when there is none.
    pub(super) fn between(label: &str, before: &State, after: &State) -> Option<Self> {
        let is_same =
            Arc::ptr_eq(&before.content, &after.content) || before.content == after.content;
        let content = (!is_same).then(|| {
            (
                PackedContent::of(&before.content),
                PackedContent::of(&after.content),
            )
        });
        let ids: BTreeSet<PhotoId> = before
            .masks
            .keys()
            .chain(after.masks.keys())
            .copied()
            .collect();
        let change = |id: PhotoId| match (before.masks.get(&id), after.masks.get(&id)) {
            (Some(old), Some(new)) if Arc::ptr_eq(old, new) => None,
            (Some(old), Some(new)) => MaskPatch::between(old, new).map(MaskChange::Painted),
            (None, Some(new)) => Some(MaskChange::Came(new.to_bytes())),
            (Some(old), None) => Some(MaskChange::Went(old.to_bytes())),
            (None, None) => None,
        };
        let masks: Vec<_> = ids
            .into_iter()
            .filter_map(|id| Some((id, change(id)?)))
            .collect();
        let (old, new) = (digests(before), digests(after));
        let step = Self {
            label: label.to_owned(),
            content,
            masks,
            blobs: old.symmetric_difference(&new).copied().collect(),
        };
        (step.content.is_some() || !step.masks.is_empty()).then_some(step)
    }

    /// Makes `state`, which is the one on the other side, the one on `side`.
    pub(super) fn apply(&self, state: &mut State, side: Side) -> Result<Changed, Misfit> {
        let mut new = state.clone();
        let mut changed = Changed::default();
        if let Some((before, after)) = &self.content {
            let content = if side == Side::Before { before } else { after };
            new.content = Arc::new(content.content()?);
            changed.content = true;
        }
        for (id, change) in &self.masks {
            let comes = match change {
                MaskChange::Painted(patch) => {
                    let mask = new.masks.get_mut(id).ok_or(Misfit)?;
                    patch.apply(Arc::make_mut(mask), side).map_err(|_| Misfit)?;
                    changed.masks.push((*id, patch.bounds()));
                    continue;
                }
                MaskChange::Came(bytes) => (side == Side::After).then_some(bytes),
                MaskChange::Went(bytes) => (side == Side::Before).then_some(bytes),
            };
            match comes {
                Some(bytes) => {
                    let mask = TiledMask::from_bytes(bytes).map_err(|_| Misfit)?;
                    new.masks.insert(*id, Arc::new(mask));
                }
                None => {
                    new.masks.remove(id).ok_or(Misfit)?;
                }
            }
            changed.masks.push((*id, None));
        }
        *state = new;
        Ok(changed)
    }

    /// The photographs that must be kept for this step.
    pub(super) fn blobs(&self) -> impl Iterator<Item = &Digest> {
        self.blobs.iter()
    }

    /// Bytes in memory, photographs left out.
    pub(super) fn memory_bytes(&self) -> usize {
        let content = self.content.iter().map(|(a, b)| a.lz4.len() + b.lz4.len());
        let masks = self.masks.iter().map(|(_, change)| match change {
            MaskChange::Painted(patch) => patch.memory_bytes(),
            MaskChange::Came(bytes) | MaskChange::Went(bytes) => bytes.len(),
        });
        let own = size_of::<Self>() + self.label.len() + 32 * self.blobs.len();
        own + content.sum::<usize>() + masks.sum::<usize>()
    }
}

/// The contents that a state's photographs have.
pub(super) fn digests(state: &State) -> BTreeSet<Digest> {
    state
        .content
        .photos
        .values()
        .map(|photo| photo.digest)
        .collect()
}
