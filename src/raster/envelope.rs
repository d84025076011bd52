//! What surrounds the pixels in a file, read to learn whether the file is all there.
//!
//! Decoders stop as soon as they have their pixels, or make up grey ones where a JPEG ends early;
//! a half-copied photograph would then be cut out and varied with its lower half missing. So the
//! chunks of a PNG and the markers of a JPEG are followed to the end mark, and the length that a
//! WebP claims is compared with the one it has.

use super::read::{PictureFormat, Refusal};

/// What must be known of a file before it is decoded.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Envelope {
    /// The marker that began a JPEG's frame and tells how it is coded.
    frame: Option<u8>,
}

impl Envelope {
    /// A JPEG whose decoder keeps all coefficients of the picture until the last scan.
    pub(super) fn is_progressive(self) -> bool {
        self.frame == Some(0xc2)
    }

    /// The coding of a JPEG that hardly any decoder reads, and ours would call damaged.
    fn rare_coding(self) -> Option<&'static str> {
        match self.frame? {
            0xc3 => Some("lossless coding"),
            0xc5..=0xc7 => Some("hierarchical coding"),
            0xc9..=0xcf => Some("arithmetic coding"),
            _ => None,
        }
    }
}

/// Looks through the file; [`Refusal::Truncated`] when its end is missing.
pub(super) fn open(bytes: &[u8], format: PictureFormat) -> Result<Envelope, Refusal> {
    let mut envelope = Envelope::default();
    let complete = match format {
        PictureFormat::Png => png_has_end(bytes),
        PictureFormat::WebP => webp_has_end(bytes),
        PictureFormat::Jpeg => jpeg_has_end(bytes, &mut envelope),
        _ => true,
    };
    if !complete {
        return Err(Refusal::Truncated { format });
    }
    match envelope.rare_coding() {
        None => Ok(envelope),
        Some(coding) => Err(Refusal::Unsupported {
            format,
            detail: coding.to_owned(),
        }),
    }
}

/// Whether the chunks (length, name, content, checksum) lead to one named IEND.
fn png_has_end(bytes: &[u8]) -> bool {
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]);
        at += 12 + length as usize;
        if &head[4..] == b"IEND" {
            return at <= bytes.len();
        }
    }
    false
}

/// Whether the file is as long as its RIFF header says.
fn webp_has_end(bytes: &[u8]) -> bool {
    bytes.get(4..8).is_some_and(|b| {
        8 + u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])) <= bytes.len() as u64
    })
}

/// Whether the markers lead to an EOI: segments are stepped over by their length, the coded data
/// after each start of scan is searched for the next marker.
fn jpeg_has_end(bytes: &[u8], envelope: &mut Envelope) -> bool {
    const RESTARTS: std::ops::RangeInclusive<u8> = 0xd0..=0xd7;
    const END_OF_IMAGE: u8 = 0xd9;
    let mut at = 2;
    loop {
        // Between segments this skips padding and junk as all decoders do; within coded data,
        // FF 00 is a value and FF D0 … FF D7 are restarts, no segments.
        let Some(found) = bytes[at.min(bytes.len())..].iter().position(|&b| b == 0xff) else {
            return false;
        };
        let Some(&marker) = bytes.get(at + found + 1) else {
            return false;
        };
        at += found + 1;
        match marker {
            END_OF_IMAGE => return true,
            // The second FF of two may begin the marker.
            0xff => {}
            0 | 1 => at += 1,
            marker if RESTARTS.contains(&marker) => at += 1,
            marker => {
                // C4, C8 and CC are tables and an extension, no frames.
                if (0xc0..=0xcf).contains(&marker) && !matches!(marker, 0xc4 | 0xc8 | 0xcc) {
                    envelope.frame.get_or_insert(marker);
                }
                let Some(length) = bytes.get(at + 1..at + 3) else {
                    return false;
                };
                at += 1 + usize::from(u16::from_be_bytes([length[0], length[1]])).max(2);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_jpeg_ends_at_its_end_mark_not_at_one_inside_a_segment() {
        let head: &[u8] = &[0xff, 0xd8, 0xff, 0xe1, 0, 4, 0xff, 0xd9, 0xff, 0xda, 0, 2];
        let coded: &[u8] = &[7, 0xff, 0, 0xff, 0xd3, 9];
        let mut bytes = [head, coded].concat();
        let cut = Refusal::Truncated {
            format: PictureFormat::Jpeg,
        };
        assert_eq!(open(&bytes, PictureFormat::Jpeg), Err(cut));
        bytes.extend([0xff, 0xff, 0xd9]);
        assert_eq!(open(&bytes, PictureFormat::Jpeg), Ok(Envelope::default()));
    }

    #[test]
    fn a_chunk_length_beyond_the_file_is_no_end() {
        let mut bytes = b"\x89PNG\r\n\x1a\n\xff\xff\xff\xffIDAT".to_vec();
        assert!(!png_has_end(&bytes));
        bytes.truncate(8);
        bytes.extend(b"\0\0\0\x01IDATxCRC1\0\0\0\0IENDCRC2");
        assert!(png_has_end(&bytes));
    }
}
