//! Input files, read once: the same bytes are hashed and decoded.

use super::failure::Failure;
use crate::base::{Digest, FileError, Hasher, read_limited};
use crate::export::{CrownFolderError, CrownRecord, crown_from_files};
use crate::raster::{Image, Mask, ReadLimits, Straight, read_image_from_memory};
use crate::scene::Crown;
use std::path::{Path, PathBuf};

/// A picture file that was read but not decoded yet.
pub(crate) struct PictureFile {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl PictureFile {
    /// Reads the file.
    ///
    /// # Errors
    /// As [`read_limited`].
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        Ok(Self {
            path: path.to_owned(),
            bytes: read_limited(path, ReadLimits::default().file_bytes)?,
        })
    }

    /// The file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The digest of the content; the name has no part in it.
    pub(crate) fn digest(&self) -> Digest {
        Digest::of(&self.bytes)
    }

    /// The picture.
    ///
    /// # Errors
    /// As [`read_image_from_memory`].
    pub(crate) fn decoded(&self) -> Result<Image<Straight>, Failure> {
        Ok(read_image_from_memory(
            &self.bytes,
            &self.path,
            ReadLimits::default(),
        )?)
    }
}

/// The mask that `picture` shows: where it is opaque, if any of it is clear, else where its red is
/// 128 or more.
pub(crate) fn mask_from(picture: &Image<Straight>) -> Mask {
    let has_alpha = picture.pixels().iter().any(|pixel| pixel.alpha() < 255);
    picture.map(|pixel| {
        let value = if has_alpha { pixel.alpha() } else { pixel.0[0] };
        value >= 128
    })
}

/// Largest file of a crown's folder that is read.
const LARGEST_CROWN_FILE: u64 = 1 << 30;

/// The crown in `folder`, and the digest of all its files.
///
/// # Errors
/// [`Failure::BadInput`] naming the file that is missing or broken.
pub(crate) fn read_crown(folder: &Path) -> Result<(Crown, Digest), Failure> {
    read_crown_and_record(folder).map(|(crown, _, digest)| (crown, digest))
}

/// The crown in `folder`, its record, and the digest of all its files.
///
/// # Errors
/// As [`read_crown`].
pub(crate) fn read_crown_and_record(
    folder: &Path,
) -> Result<(Crown, CrownRecord, Digest), Failure> {
    let mut digest = Hasher::new("boscage crown folder");
    let outcome = crown_from_files(|name| {
        let bytes = read_limited(&folder.join(name), LARGEST_CROWN_FILE)?;
        digest = std::mem::replace(&mut digest, Hasher::new("")).with(&bytes);
        Ok(bytes)
    });
    match outcome {
        Ok((crown, record)) => Ok((crown, record, digest.finish())),
        Err(CrownReadFailure::File(error)) => Err(error.into()),
        Err(CrownReadFailure::Content(error)) => Err(Failure::of(folder.display(), error)),
    }
}

/// Why a crown could not be read.
enum CrownReadFailure {
    File(FileError),
    Content(CrownFolderError),
}

impl From<FileError> for CrownReadFailure {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}

impl From<CrownFolderError> for CrownReadFailure {
    fn from(error: CrownFolderError) -> Self {
        Self::Content(error)
    }
}
