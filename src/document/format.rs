//! The container of `.boscage` files: named sections, each with its digest.
//!
//! ```text
//! 8  magic: 89 "BSCG" 0D 0A 1A     found damaged by text transfers, as PNG's
//! 4  version of the format         little-endian, as all numbers
//! 4  number of sections
//!    for each section: 4 kind, 1 flags, 3 zero, 8 bytes stored, 8 bytes plain, 32 digest as stored
//! 32 digest of all of the above
//!    the sections as stored, without gaps; nothing follows
//! ```
//!
//! Flags: 1 *required*: a reader that does not know the kind must refuse the file; others are kept and
//! written again as they were. 2 *compressed* with LZ4. A reader believes no length before the
//! digest of the table is right, and never asks for more memory than the limits of a kind allow.

use crate::base::{Digest, asking_for_memory};
use std::sync::Arc;

/// The version that is written, and the newest that is read.
pub const VERSION: u32 = 1;

/// First bytes of every file.
const MAGIC: [u8; 8] = *b"\x89BSCG\r\n\x1a";

/// Most sections: a mask and a picture for each photograph, and some more.
const MOST_SECTIONS: u32 = 32_768;

/// Bytes of a section's entry in the table.
const ENTRY: usize = 56;

/// Most plain bytes of a compressed section.
const MOST_PLAIN_BYTES: u64 = 1 << 30;

/// Most plain bytes of all compressed sections: LZ4 makes uniform bytes 255 times smaller, so a small
/// file could ask for any memory. Masks of 1,000 photographs of 24 megapixels, each painted to the
/// last tile with noise, keep below it.
const MOST_PLAIN_BYTES_IN_ALL: u64 = 4 << 30;

const REQUIRED: u8 = 1;
const COMPRESSED: u8 = 2;

/// Bytes that were to be a project are none.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FormatError {
    /// Something else altogether.
    #[error("not a Boscage project")]
    NotOurs,
    /// A newer version wrote it.
    #[error(
        "saved by a newer version of Boscage (format {version}, this one reads up to {VERSION}); \
         update Boscage to open it"
    )]
    Newer {
        /// The format's version.
        version: u32,
    },
    /// It holds something that must be understood and is not.
    #[error("holds \"{kind}\", which only a newer version of Boscage understands")]
    Unknown {
        /// The section's kind.
        kind: String,
    },
    /// Bytes are missing at the end.
    #[error("the project is cut short; copy or download it again")]
    CutShort,
    /// It would take more memory than there is, or than a project may.
    #[error("the project needs more memory than there is")]
    TooLarge,
    /// Its digests do not match, or its parts contradict one another.
    #[error("the project is damaged: {0}")]
    Damaged(String),
}

impl FormatError {
    pub(super) fn damaged(what: impl Into<String>) -> Self {
        Self::Damaged(what.into())
    }
}

/// One section.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Section {
    pub(super) kind: [u8; 4],
    pub(super) is_required: bool,
    pub(super) is_compressed: bool,
    /// The content, not compressed.
    pub(super) bytes: Arc<[u8]>,
}

impl Section {
    pub(super) fn new(kind: &[u8; 4], bytes: impl Into<Arc<[u8]>>) -> Self {
        Self {
            kind: *kind,
            is_required: true,
            is_compressed: false,
            bytes: bytes.into(),
        }
    }

    pub(super) fn optional(self) -> Self {
        Self {
            is_required: false,
            ..self
        }
    }

    pub(super) fn compressed(self) -> Self {
        Self {
            is_compressed: true,
            ..self
        }
    }

    /// The kind as text for messages.
    pub(super) fn name(&self) -> String {
        self.kind.escape_ascii().to_string()
    }
}

/// The file that holds `sections`.
pub(super) fn container(sections: &[Section]) -> Vec<u8> {
    let stored: Vec<_> = sections
        .iter()
        .map(|section| {
            if section.is_compressed {
                lz4_flex::block::compress(&section.bytes).into()
            } else {
                Arc::clone(&section.bytes)
            }
        })
        .collect();
    let mut file = MAGIC.to_vec();
    file.extend(VERSION.to_le_bytes());
    file.extend((sections.len() as u32).to_le_bytes());
    for (section, stored) in sections.iter().zip(&stored) {
        let required = if section.is_required { REQUIRED } else { 0 };
        let compressed = if section.is_compressed { COMPRESSED } else { 0 };
        file.extend(section.kind);
        file.extend([required | compressed, 0, 0, 0]);
        file.extend((stored.len() as u64).to_le_bytes());
        file.extend((section.bytes.len() as u64).to_le_bytes());
        file.extend(Digest::of(stored).bytes());
    }
    let digest = Digest::of(&file);
    file.extend(digest.bytes());
    for stored in stored {
        file.extend_from_slice(&stored);
    }
    file
}

/// The version of the file and its sections, all checked.
pub(super) fn sections(file: &[u8]) -> Result<(u32, Vec<Section>), FormatError> {
    let mut rest = file;
    let magic = &MAGIC[..MAGIC.len().min(file.len())];
    if file.is_empty() || !file.starts_with(magic) {
        return Err(FormatError::NotOurs);
    }
    taken(&mut rest, MAGIC.len())?;
    let version = number32(&mut rest)?;
    if version > VERSION {
        return Err(FormatError::Newer { version });
    }
    let count = number32(&mut rest)?;
    if version == 0 || count > MOST_SECTIONS {
        return Err(FormatError::damaged("its table of contents"));
    }
    let table = taken(&mut rest, count as usize * ENTRY)?;
    let head = &file[..file.len() - rest.len()];
    if taken(&mut rest, 32)? != Digest::of(head).bytes() {
        return Err(FormatError::damaged("its table of contents"));
    }
    if plain_bytes(table) > MOST_PLAIN_BYTES_IN_ALL {
        return Err(FormatError::TooLarge);
    }
    let sections: Result<Vec<_>, _> = table
        .chunks_exact(ENTRY)
        .map(|entry| section(entry, &mut rest))
        .collect();
    if !rest.is_empty() {
        return Err(FormatError::damaged("bytes after its end"));
    }
    Ok((version, sections?))
}

/// What the compressed sections of a table hold by its account.
fn plain_bytes(table: &[u8]) -> u64 {
    let of_entry = |entry: &[u8]| {
        let is_compressed = entry[4] & COMPRESSED != 0;
        let mut length = &entry[16..];
        number64(&mut length).ok().filter(|_| is_compressed)
    };
    let lengths = table.chunks_exact(ENTRY).filter_map(of_entry);
    lengths.fold(0, u64::saturating_add)
}

/// `length` zeros, where the memory can be had.
fn zeros(length: usize) -> Result<Vec<u8>, FormatError> {
    let mut bytes = Vec::new();
    asking_for_memory(|| bytes.try_reserve_exact(length)).map_err(|_| FormatError::TooLarge)?;
    bytes.resize(length, 0);
    Ok(bytes)
}

/// The section of a table's entry, from the front of `rest`.
fn section(mut entry: &[u8], rest: &mut &[u8]) -> Result<Section, FormatError> {
    let kind = taken(&mut entry, 4)?;
    let kind = [kind[0], kind[1], kind[2], kind[3]];
    let flags = taken(&mut entry, 4)?[0];
    let (stored_length, plain_length) = (number64(&mut entry)?, number64(&mut entry)?);
    let length = usize::try_from(stored_length).map_err(|_| FormatError::CutShort)?;
    let stored = taken(rest, length)?;
    let name = kind.escape_ascii();
    if Digest::of(stored).bytes() != entry {
        return Err(FormatError::Damaged(format!("its section {name}")));
    }
    let is_compressed = flags & COMPRESSED != 0;
    let wrong = || FormatError::Damaged(format!("the length of its section {name}"));
    let bytes: Arc<[u8]> = if is_compressed {
        // LZ4 makes nothing more than 255 times smaller.
        if plain_length > MOST_PLAIN_BYTES || plain_length / 256 > stored_length {
            return Err(wrong());
        }
        let mut plain = zeros(plain_length as usize)?;
        let length = lz4_flex::block::decompress_into(stored, &mut plain).map_err(|_| wrong())?;
        plain.truncate(length);
        plain.into()
    } else {
        stored.into()
    };
    if bytes.len() as u64 != plain_length {
        return Err(wrong());
    }
    Ok(Section {
        kind,
        is_required: flags & REQUIRED != 0,
        is_compressed,
        bytes,
    })
}

/// The first `length` bytes of `rest`, which then begins behind them.
pub(super) fn taken<'a>(rest: &mut &'a [u8], length: usize) -> Result<&'a [u8], FormatError> {
    let (first, after) = rest.split_at_checked(length).ok_or(FormatError::CutShort)?;
    *rest = after;
    Ok(first)
}

pub(super) fn number32(rest: &mut &[u8]) -> Result<u32, FormatError> {
    let bytes = taken(rest, 4)?.iter().rev();
    Ok(bytes.fold(0, |number, &byte| number << 8 | u32::from(byte)))
}

fn number64(rest: &mut &[u8]) -> Result<u64, FormatError> {
    let bytes = taken(rest, 8)?.iter().rev();
    Ok(bytes.fold(0, |number, &byte| number << 8 | u64::from(byte)))
}
