//! One loader for every picture a user may have.
//!
//! PNG, JPEG, WebP, TGA, TIFF, BMP and DDS of any depth become 8-bit RGBA with straight alpha,
//! turned upright. The content decides what a file is, not its name; only TGA, which has no magic
//! number, is also known by its extension. Of an animation, a volume or a cubemap the first picture
//! is taken. Colour profiles are not applied: values are taken as sRGB, those above 1 as white.
//!
//! A file is judged by its header before anything is allocated for its pixels, then memory is asked
//! for in a way that may fail, and the decoders, which others wrote, may panic without harm. All
//! that can go wrong becomes one line that says what and, where it helps, what to do.

use super::envelope;
use super::{Image, Straight, dds, decode, palette_tiff};
use crate::base::{FileError, asking_for_memory, one_line, read_limited, without_panics};
use std::fmt;
use std::path::{Path, PathBuf};

/// A picture could not be read. Prints as one line, `FILE: reason`.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file itself could not be read.
    #[error("{}", one_line(&.0.to_string()))]
    File(#[from] FileError),
    /// The file was read, but no picture came out of it.
    #[error("{}: {reason}", one_line(&path.display().to_string()))]
    Refused {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: Refusal,
    },
}

/// Why some bytes give no picture.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Refusal {
    /// No bytes at all.
    #[error("the file is empty")]
    Empty,
    /// None of the formats that are read.
    #[error("{found}; Boscage reads PNG, JPEG, WebP, TGA, TIFF, BMP and DDS")]
    Unknown {
        /// What it is instead, as far as can be told.
        found: &'static str,
    },
    /// Zero pixels wide or high.
    #[error("{width}×{height} pixels are no picture")]
    NoPixels {
        /// Width the header tells.
        width: u32,
        /// Height the header tells.
        height: u32,
    },
    /// More pixels than [`ReadLimits::pixels`].
    #[error("{width}×{height} pixels are more than the limit of {limit} in all")]
    TooManyPixels {
        /// Width the header tells.
        width: u32,
        /// Height the header tells.
        height: u32,
        /// The most that is accepted.
        limit: u64,
    },
    /// Far more pixels than so few bytes can honestly hold.
    #[error("{width}×{height} pixels in {bytes} bytes: damaged, or made to exhaust the memory")]
    Bomb {
        /// Width the header tells.
        width: u32,
        /// Height the header tells.
        height: u32,
        /// Size of the file.
        bytes: u64,
    },
    /// The memory for decoding cannot be had; on another machine it may work.
    #[error("{width}×{height} pixels need more memory than there is")]
    OutOfMemory {
        /// Width the header tells.
        width: u32,
        /// Height the header tells.
        height: u32,
    },
    /// The file ends too early.
    #[error("the {format} file is cut short; copy or download it again")]
    Truncated {
        /// What the file is.
        format: PictureFormat,
    },
    /// A valid file, perhaps, of a kind that is not read.
    #[error("this kind of {format} is not read ({detail}); save it as an 8-bit RGBA PNG")]
    Unsupported {
        /// What the file is.
        format: PictureFormat,
        /// What about it.
        detail: String,
    },
    /// The content contradicts the format.
    #[error("damaged {format} file: {detail}")]
    Damaged {
        /// What the file is.
        format: PictureFormat,
        /// What the decoder found.
        detail: String,
    },
    /// The decoder panicked: its bug, though the file is mostly an odd one.
    #[error("the {format} decoder fails on this file; save it as an 8-bit RGBA PNG")]
    Crashed {
        /// What the file is.
        format: PictureFormat,
    },
}

/// The formats that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PictureFormat {
    /// Portable Network Graphics.
    Png,
    /// JPEG in its JFIF and Exif wrappings.
    Jpeg,
    /// WebP, lossy and lossless.
    WebP,
    /// Truevision Targa.
    Tga,
    /// Tagged Image File Format.
    Tiff,
    /// Windows bitmap.
    Bmp,
    /// `DirectDraw` surface, the texture format of games.
    Dds,
}

impl fmt::Display for PictureFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::WebP => "WebP",
            Self::Tga => "TGA",
            Self::Tiff => "TIFF",
            Self::Bmp => "BMP",
            Self::Dds => "DDS",
        })
    }
}

/// How large a picture may be.
#[derive(Debug, Clone, Copy)]
pub struct ReadLimits {
    /// Most bytes of the file.
    pub file_bytes: u64,
    /// Most pixels after decoding.
    pub pixels: u64,
}

impl Default for ReadLimits {
    fn default() -> Self {
        Self {
            file_bytes: 1 << 30,
            pixels: 20_000 * 20_000,
        }
    }
}

/// The picture in the file `path`, upright, as 8-bit RGBA with straight alpha.
///
/// # Errors
/// [`ImageError`], one line that names the file.
pub fn read_image(path: &Path, limits: ReadLimits) -> Result<Image<Straight>, ImageError> {
    let bytes = read_limited(path, limits.file_bytes)?;
    read_image_from_memory(&bytes, path, limits)
}

/// The picture in `bytes`, the content of a file `path` that is not opened: its name is for
/// messages and, where the bytes do not tell, for the format.
///
/// Whoever keys a cache by the content reads the file once and gives the same bytes to both.
///
/// # Errors
/// [`ImageError::Refused`].
pub fn read_image_from_memory(
    bytes: &[u8],
    path: &Path,
    limits: ReadLimits,
) -> Result<Image<Straight>, ImageError> {
    decoded(bytes, path, limits).map_err(|reason| ImageError::Refused {
        path: path.to_owned(),
        reason,
    })
}

fn decoded(bytes: &[u8], path: &Path, limits: ReadLimits) -> Result<Image<Straight>, Refusal> {
    let format = format_of(bytes, path)?;
    let envelope = envelope::open(bytes, format)?;
    let check =
        |width, height, channels| check_size((width, height), channels, bytes.len() as u64, limits);
    without_panics(|| match format {
        PictureFormat::Dds => dds::decode(bytes, check),
        PictureFormat::Tiff => palette_tiff::decode(bytes, check)
            .unwrap_or_else(|| decode::decode(bytes, format, envelope, check)),
        _ => decode::decode(bytes, format, envelope, check),
    })
    .unwrap_or(Err(Refusal::Crashed { format }))
}

/// What `bytes` are.
fn format_of(bytes: &[u8], path: &Path) -> Result<PictureFormat, Refusal> {
    const MAGIC: [(&[u8], PictureFormat); 8] = [
        (b"\x89PNG", PictureFormat::Png),
        (b"\xff\xd8", PictureFormat::Jpeg),
        (b"II*\0", PictureFormat::Tiff),
        (b"MM\0*", PictureFormat::Tiff),
        // BigTIFF, for files beyond 4 GiB.
        (b"II+\0", PictureFormat::Tiff),
        (b"MM\0+", PictureFormat::Tiff),
        (b"DDS ", PictureFormat::Dds),
        (b"BM", PictureFormat::Bmp),
    ];
    /// Ends a TGA file of version 2; older ones are known by nothing but their name.
    const TGA_FOOTER: &[u8] = b"TRUEVISION-XFILE.\0";

    if bytes.is_empty() {
        return Err(Refusal::Empty);
    }
    if let Some((_, format)) = MAGIC.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        return Ok(*format);
    }
    if bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") {
        return Ok(PictureFormat::WebP);
    }
    if let Some(found) = known_stranger(bytes) {
        return Err(Refusal::Unknown { found });
    }
    let named_tga = path.extension().is_some_and(|extension| {
        ["tga", "icb", "vda", "vst"]
            .iter()
            .any(|known| extension.eq_ignore_ascii_case(known))
    });
    if named_tga || bytes.ends_with(TGA_FOOTER) {
        return Ok(PictureFormat::Tga);
    }
    Err(Refusal::Unknown {
        found: "not a picture",
    })
}

/// A word for files that users often take for a picture that we read.
fn known_stranger(bytes: &[u8]) -> Option<&'static str> {
    const STRANGERS: [(usize, &[u8], &str); 9] = [
        (
            0,
            b"version https://git-lfs",
            "a Git LFS pointer, not the picture itself: run `git lfs pull`",
        ),
        (0, b"GIF8", "a GIF"),
        (0, b"8BPS", "a Photoshop document"),
        (0, b"gimp xcf", "a GIMP document"),
        (0, b"v/1\x01", "an OpenEXR picture"),
        (4, b"ftypavif", "an AVIF picture"),
        (4, b"ftyphei", "a HEIC picture"),
        (0, b"%PDF", "a PDF document"),
        (0, b"<svg", "an SVG drawing"),
    ];
    STRANGERS
        .iter()
        .find(|(at, magic, _)| bytes.get(*at..).is_some_and(|rest| rest.starts_with(magic)))
        .map(|&(_, _, found)| found)
}

/// Judges a picture by what its header tells, before memory is asked for.
fn check_size(
    (width, height): (u32, u32),
    channels: u8,
    bytes: u64,
    limits: ReadLimits,
) -> Result<(), Refusal> {
    /// Below this a lie costs less than half a gigabyte.
    const HARMLESS_PIXELS: u64 = 100_000_000;
    /// Photographs hold less than 20 pixels in a byte, trees cut out on clear ground less than 100.
    const HONEST_PIXELS_PER_BYTE: u64 = 200;
    /// A mask may be flat and have one bit a pixel: then a byte holds what Deflate can make of it.
    const HONEST_GREYS_PER_BYTE: u64 = 8 * 1032;

    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 {
        return Err(Refusal::NoPixels { width, height });
    }
    if pixels > limits.pixels {
        return Err(Refusal::TooManyPixels {
            width,
            height,
            limit: limits.pixels,
        });
    }
    let honest = match channels {
        1 => HONEST_GREYS_PER_BYTE,
        _ => HONEST_PIXELS_PER_BYTE,
    };
    if pixels > HARMLESS_PIXELS && pixels / honest > bytes {
        return Err(Refusal::Bomb {
            width,
            height,
            bytes,
        });
    }
    Ok(())
}

/// Black, clear pixels for a picture, or an error where the process would otherwise be aborted.
pub(super) fn blank(width: u32, height: u32, pixels: u64) -> Result<Vec<Straight>, Refusal> {
    usize::try_from(pixels)
        .ok()
        .and_then(|count| asking_for_memory(|| bytemuck::allocation::try_zeroed_vec(count)).ok())
        .ok_or(Refusal::OutOfMemory { width, height })
}

#[cfg(test)]
mod tests;
