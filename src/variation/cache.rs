//! Prepared exemplars on disk, so that a library opens at once the second time.
//!
//! Two files for each exemplar, named by the digest of everything that went into it: `KEY.shape`
//! holds the vectors and is read when a library opens; `KEY.pixels` holds picture and labels and
//! is read when the exemplar is used. Each begins with the digest of its content: a damaged or
//! foreign file counts as absent. Deleting the folder costs time and nothing else.

use super::{Exemplar, ExemplarSettings, Shape};
use crate::base::{Digest, FileError, Hasher, read_limited, write_atomic};
use crate::contour::HandPins;
use crate::raster::Image;
use crate::segment::{Provenance, grey_from_labels, labels_from_grey};
use std::path::{Path, PathBuf};

/// Part of every key: raise it whenever preparation gives other results than before.
const PREPARATION: &[u8] = b"exemplar 6";

/// Largest file that is read back: a picture of 8,192² barely compressed.
const LARGEST_BYTES: u64 = 1 << 29;

/// The name of a prepared exemplar.
pub(super) fn key(
    file: Digest,
    by_hand: Option<&HandPins>,
    settings: &ExemplarSettings,
    segmenter: &str,
) -> Digest {
    let hasher = Hasher::new("boscage exemplar")
        .with(PREPARATION)
        .with(env!("CARGO_PKG_VERSION").as_bytes())
        .with(file.bytes())
        .with(&settings.size.to_le_bytes())
        .with(&settings.threshold.to_le_bytes())
        .with(&settings.points.to_le_bytes())
        .with(&settings.simplified.to_le_bytes())
        .with(segmenter.as_bytes());
    let pinned = by_hand.map(|pins| [pins.bottom, pins.left, pins.right]);
    let shares = pinned.as_ref().map(|pins| pins.as_flattened());
    let shares = shares.unwrap_or_default().iter();
    shares
        .fold(hasher, |hasher, share| hasher.with(&share.to_le_bytes()))
        .finish()
}

/// A folder of prepared exemplars.
#[derive(Debug, Clone)]
pub(super) struct Cache(PathBuf);

impl Cache {
    pub(super) fn new(folder: &Path) -> Self {
        Self(folder.to_owned())
    }

    /// The vectors of `key` and who labelled its picture, if they are there and whole.
    pub(super) fn shape(&self, key: Digest) -> Option<(Shape, Provenance)> {
        postcard::from_bytes(&self.content(key, "shape")?).ok()
    }

    /// The whole exemplar `key` whose vectors are `shape`, if it is there and whole.
    pub(super) fn exemplar(
        &self,
        key: Digest,
        shape: &Shape,
        provenance: &Provenance,
    ) -> Option<Exemplar> {
        let count = shape.size as usize * shape.size as usize;
        let bytes = lz4_flex::decompress(&self.content(key, "pixels")?, 5 * count).ok()?;
        let (image, labels) = bytes.split_at_checked(4 * count)?;
        if labels.len() != count {
            return None;
        }
        let image = bytemuck::cast_slice(image).to_vec();
        let labels = Image::from_pixels(shape.size, shape.size, labels.to_vec());
        Some(Exemplar {
            shape: shape.clone(),
            image: Image::from_pixels(shape.size, shape.size, image),
            labels: labels_from_grey(&labels),
            provenance: provenance.clone(),
        })
    }

    /// Keeps `exemplar` under `key`.
    ///
    /// # Errors
    /// [`FileError::Write`].
    pub(super) fn keep(&self, key: Digest, exemplar: &Exemplar) -> Result<(), FileError> {
        let mut pixels = bytemuck::cast_slice(exemplar.image.pixels()).to_vec();
        pixels.extend(grey_from_labels(&exemplar.labels).pixels());
        self.write(key, "pixels", &lz4_flex::compress(&pixels))?;
        let shape = postcard::to_stdvec(&(&exemplar.shape, &exemplar.provenance))
            .unwrap_or_else(|_| unreachable!("a shape is numbers and text only"));
        self.write(key, "shape", &shape)
    }

    fn path(&self, key: Digest, extension: &str) -> PathBuf {
        self.0.join(format!("{key}.{extension}"))
    }

    fn content(&self, key: Digest, extension: &str) -> Option<Vec<u8>> {
        let mut bytes = read_limited(&self.path(key, extension), LARGEST_BYTES).ok()?;
        let (digest, content) = bytes.split_at_checked(32)?;
        if Digest::of(content).bytes() != digest {
            return None;
        }
        Some(bytes.split_off(32))
    }

    fn write(&self, key: Digest, extension: &str, content: &[u8]) -> Result<(), FileError> {
        let mut bytes = Digest::of(content).bytes().to_vec();
        bytes.extend(content);
        write_atomic(&self.path(key, extension), &bytes)
    }
}
