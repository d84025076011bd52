//! Input files, read once: the same bytes are hashed and decoded.

use super::failure::Failure;
use crate::base::{Digest, read_limited};
use crate::raster::{Image, ReadLimits, Straight, read_image_from_memory};
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
