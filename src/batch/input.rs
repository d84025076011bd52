//! Input files, read once: the same bytes are hashed and decoded.

use super::failure::Failure;
use super::output::recipe;
use super::run::Run;
use crate::base::{Digest, FileError, Hasher, read_limited};
use crate::export::{CrownFolderError, CrownRecord, crown_from_files};
use crate::raster::{Image, Mask, ReadLimits, Straight, read_image_from_memory};
use crate::scene::Crown;
use serde::Serialize;
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

/// The two files that a crown or a texture is made from.
pub(crate) struct PhotoWithMask {
    pub(crate) photo: PictureFile,
    pub(crate) mask: PictureFile,
}

impl PhotoWithMask {
    /// Reads both, as the stage `read`.
    ///
    /// # Errors
    /// As [`read_limited`].
    pub(crate) fn read(photo: &Path, mask: &Path, session: &Run<'_>) -> Result<Self, Failure> {
        let stage = session.progress.stage("read", 2);
        let photo = PictureFile::read(photo)?;
        stage.advance();
        let mask = PictureFile::read(mask)?;
        stage.advance();
        Ok(Self { photo, mask })
    }

    /// The digest of what `command` makes of them with `settings`.
    ///
    /// # Errors
    /// [`Failure::Environment`] when the settings cannot be written as JSON.
    pub(crate) fn recipe(
        &self,
        command: &str,
        settings: &impl Serialize,
        session: &Run<'_>,
    ) -> Result<Digest, Failure> {
        let settings = serde_json::to_vec(settings)
            .map_err(|error| Failure::Environment(error.to_string()))?;
        Ok(recipe(command)
            .with(self.photo.digest().bytes())
            .with(self.mask.digest().bytes())
            .with(&settings)
            .with(&session.seed.to_le_bytes())
            .finish())
    }

    /// The photograph, and the mask that the other file shows.
    ///
    /// # Errors
    /// As [`read_image_from_memory`].
    pub(crate) fn decoded(&self) -> Result<(Image<Straight>, Mask), Failure> {
        Ok((self.photo.decoded()?, mask_from(&self.mask.decoded()?)))
    }
}

/// The grey of each pixel: the mean of its colours, 0 where it is clear.
pub(crate) fn grey(image: &Image<Straight>) -> Image<u8> {
    image.map(|pixel| {
        let [r, g, b, alpha] = pixel.0;
        let sum = u32::from(r) + u32::from(g) + u32::from(b);
        if alpha < 128 {
            0
        } else {
            ((sum + 1) / 3) as u8
        }
    })
}

/// How far each pixel of a mask file belongs to the mask, 0 … 255: its alpha if the picture has clear
/// pixels, else its grey. All commands read masks so.
pub(crate) fn coverage(picture: &Image<Straight>) -> Image<u8> {
    if picture.pixels().iter().any(|pixel| pixel.alpha() < 255) {
        picture.map(|pixel| pixel.alpha())
    } else {
        grey(picture)
    }
}

/// The mask that `picture` shows: where its [`coverage`] is 128 or more.
pub(crate) fn mask_from(picture: &Image<Straight>) -> Mask {
    coverage(picture).map(|&value| value >= 128)
}

/// Largest file of a crown's folder that is read.
const LARGEST_CROWN_FILE: u64 = 1 << 30;

/// The crown in `folder`, its record, and the digest of all its files.
///
/// # Errors
/// [`Failure::BadInput`] naming the file that is missing or broken.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn row(pixels: &[[u8; 4]]) -> Image<Straight> {
        let pixels: Vec<Straight> = pixels.iter().copied().map(Straight).collect();
        Image::from_pixels(pixels.len() as u32, 1, pixels)
    }

    #[test]
    fn alpha_counts_only_where_something_is_clear() {
        let opaque = row(&[[200, 200, 200, 255], [0, 0, 0, 255], [0, 255, 0, 255]]);
        assert_eq!(coverage(&opaque).pixels(), &[200, 0, 85]);
        let clear = row(&[[0, 0, 0, 255], [255, 255, 255, 0]]);
        assert_eq!(coverage(&clear).pixels(), &[255, 0]);
    }

    #[test]
    fn a_mask_begins_at_half() {
        let grey = row(&[[127, 127, 127, 255], [128, 128, 128, 255]]);
        assert_eq!(mask_from(&grey).pixels(), &[false, true]);
        let alpha = row(&[[255, 255, 255, 127], [0, 0, 0, 128]]);
        assert_eq!(mask_from(&alpha).pixels(), &[false, true]);
    }
}
