//! Input files, read once: the same bytes are hashed and decoded.

use super::failure::Failure;
use crate::base::{Digest, read_limited};
use crate::raster::{Image, Mask, ReadLimits, Straight, read_image_from_memory};
use std::path::{Path, PathBuf};

/// A picture file that was read but not decoded yet.
pub(super) struct PictureFile {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl PictureFile {
    /// Reads the file.
    ///
    /// # Errors
    /// As [`read_limited`].
    pub(super) fn read(path: &Path) -> Result<Self, Failure> {
        Ok(Self {
            path: path.to_owned(),
            bytes: read_limited(path, ReadLimits::default().file_bytes)?,
        })
    }

    /// The file.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The digest of the content; the name has no part in it.
    pub(super) fn digest(&self) -> Digest {
        Digest::of(&self.bytes)
    }

    /// The picture.
    ///
    /// # Errors
    /// As [`read_image_from_memory`].
    pub(super) fn decoded(&self) -> Result<Image<Straight>, Failure> {
        Ok(read_image_from_memory(
            &self.bytes,
            &self.path,
            ReadLimits::default(),
        )?)
    }
}

/// The mask that `picture` shows: where it is opaque, if any of it is clear, else where its red is
/// 128 or more.
pub(super) fn mask_from(picture: &Image<Straight>) -> Mask {
    let has_alpha = picture.pixels().iter().any(|pixel| pixel.alpha() < 255);
    picture.map(|pixel| {
        let value = if has_alpha { pixel.alpha() } else { pixel.0[0] };
        value >= 128
    })
}
