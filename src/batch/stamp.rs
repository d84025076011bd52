//! What a PNG file was made from, written into the file.
//!
//! A `tEXt` chunk right behind the header holds two digests: of the recipe (inputs, settings,
//! version) and of the file as it was before the chunk (and, behind it, a note if there is one). The first tells whether the file is what
//! would be made, the second whether it is whole and untouched. Files of other formats are left as
//! they are and so count as never made: they are made again, which costs time but is always right.

use crate::base::Digest;

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Where the first chunk behind the header of 13 bytes begins.
const BEHIND_HEADER: usize = 8 + 12 + 13;

const KEYWORD: &[u8] = b"boscage-recipe\0";

const NOTE: &[u8] = b"boscage-note\0";

/// Bytes of the chunk's content: the keyword, and two digests in hexadecimal with a space between.
const CONTENT_BYTES: usize = KEYWORD.len() + 64 + 1 + 64;

/// Bytes of the whole chunk: length, name, content, checksum.
const CHUNK_BYTES: usize = CONTENT_BYTES + 12;

/// `bytes` with `recipe` and its own digest written into it, if it is a PNG file.
pub(crate) fn stamped(mut bytes: Vec<u8>, recipe: Digest) -> Vec<u8> {
    if is_png(&bytes) {
        let chunk = chunk(recipe, Digest::of(&bytes));
        bytes.splice(BEHIND_HEADER..BEHIND_HEADER, chunk);
    }
    bytes
}

/// Whether `bytes` is what [`stamped`] gave for `recipe`, bit for bit.
pub(crate) fn is_intact(bytes: &[u8], recipe: Digest) -> bool {
    let behind = BEHIND_HEADER + CHUNK_BYTES;
    let Some(found) = bytes.get(BEHIND_HEADER..behind) else {
        return false;
    };
    let original = [&bytes[..BEHIND_HEADER], &bytes[behind..]].concat();
    found == chunk(recipe, Digest::of(&original))
}

/// `bytes` with `note`, a text of ASCII letters, written into it, if it is a PNG file. To be done
/// before [`stamped`], whose digest covers it.
pub(crate) fn noted(mut bytes: Vec<u8>, note: &str) -> Vec<u8> {
    if is_png(&bytes) {
        let chunk = text_chunk(NOTE, note);
        bytes.splice(BEHIND_HEADER..BEHIND_HEADER, chunk);
    }
    bytes
}

/// What [`noted`] and then [`stamped`] wrote into `bytes`.
pub(crate) fn note(bytes: &[u8]) -> Option<&str> {
    let chunk = bytes.get(BEHIND_HEADER + CHUNK_BYTES..)?;
    let (length, chunk) = chunk.split_at_checked(4)?;
    let length = u32::from_be_bytes(length.try_into().ok()?) as usize;
    let content = chunk.strip_prefix(b"tEXt")?.get(..length)?;
    std::str::from_utf8(content.strip_prefix(NOTE)?).ok()
}

fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(PNG_MAGIC) && bytes.len() > BEHIND_HEADER
}

fn chunk(recipe: Digest, content: Digest) -> Vec<u8> {
    text_chunk(KEYWORD, &format!("{recipe} {content}"))
}

fn text_chunk(keyword: &[u8], text: &str) -> Vec<u8> {
    let length = keyword.len() + text.len();
    let mut chunk = (length as u32).to_be_bytes().to_vec();
    chunk.extend(b"tEXt");
    chunk.extend(keyword);
    chunk.extend(text.bytes());
    let checksum = crc32(&chunk[4..]);
    chunk.extend(checksum.to_be_bytes());
    chunk
}

/// The checksum of PNG chunks (ISO 3309), bit by bit: it is for a hundred bytes.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |sum, &byte| {
        (0..8).fold(sum ^ u32::from(byte), |sum, _| {
            (sum >> 1) ^ (0xedb8_8320 * (sum & 1))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Compression, Image, ReadLimits, encode_grey_png, read_image_from_memory};
    use std::path::Path;

    #[test]
    fn the_checksum_is_that_of_png() {
        // The end of every PNG file.
        assert_eq!(crc32(b"IEND"), 0xae42_6082);
    }

    #[test]
    fn a_note_is_read_back_from_a_stamped_picture_that_still_opens() {
        let png = encode_grey_png(&Image::filled(5, 4, 128u8), Compression::Fast);
        let recipe = Digest::of(b"recipe");
        let file = stamped(noted(png.clone(), "{\"a\":1}"), recipe);
        assert!(is_intact(&file, recipe));
        assert_eq!(note(&file), Some("{\"a\":1}"));
        assert!(read_image_from_memory(&file, Path::new("a.png"), ReadLimits::default()).is_ok());
        assert_eq!(note(&stamped(png, recipe)), None);
        for at in 0..file.len() {
            // Any bytes: no panic.
            note(&file[..at]);
        }
    }

    #[test]
    fn a_stamped_picture_still_opens_and_shows_every_change() {
        let png = encode_grey_png(&Image::filled(5, 4, 128u8), Compression::Fast);
        let recipe = Digest::of(b"recipe");
        let file = stamped(png.clone(), recipe);
        let image = read_image_from_memory(&file, Path::new("a.png"), ReadLimits::default());
        assert_eq!(image.unwrap().at(4, 3).0, [128, 128, 128, 255]);
        assert!(is_intact(&file, recipe));
        assert!(!is_intact(&file, Digest::of(b"other")));
        assert!(!is_intact(&png, recipe));
        for at in 0..file.len() {
            let mut damaged = file.clone();
            damaged[at] ^= 1;
            assert!(!is_intact(&damaged, recipe), "byte {at}");
            assert!(!is_intact(&file[..at], recipe), "cut at {at}");
        }
    }
}
