//! One loader for every picture a user may have.

use super::{Image, Straight};
use crate::base::{FileError, read_limited};
use std::path::{Path, PathBuf};

/// A picture could not be read.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file itself could not be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The bytes are no picture of a known kind, or a damaged one.
    #[error("{}: {reason}", path.display())]
    Undecodable {
        /// The file.
        path: PathBuf,
        /// What is wrong, one line.
        reason: String,
    },
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
    let failed = |reason: String| ImageError::Undecodable {
        path: path.to_owned(),
        reason,
    };
    let decoded = image::load_from_memory(&bytes)
        .map_err(|e| failed(e.to_string()))?
        .into_rgba8();
    let (width, height) = decoded.dimensions();
    Ok(Image::from_pixels(
        width,
        height,
        bytemuck::cast_vec(decoded.into_raw()),
    ))
}
