//! The pixels of the project's photographs, decoded beside the window.
//!
//! The project holds files as they came. The photograph that is shown is decoded whole; of all
//! others only a thumbnail is kept.

use crate::base::Digest;
use crate::raster::{Image, Pyramid, Straight};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Longer side of a thumbnail, pixels: sharp at twice the usual density.
pub(super) const THUMBNAIL_PX: u32 = 160;

/// The decoded photographs, by the digest of their bytes.
#[derive(Debug, Default)]
pub(super) struct Photos {
    whole: Option<(Digest, Arc<Image<Straight>>)>,
    pyramid: Option<(Digest, Arc<Pyramid>)>,
    /// The one whose pixels were asked for last.
    asked: Option<Digest>,
    thumbnails: BTreeMap<Digest, Thumbnail>,
}

/// A small picture, or why there is none.
#[derive(Debug, Clone)]
pub(super) enum Thumbnail {
    /// It is being made.
    Pending,
    /// At most [`THUMBNAIL_PX`] wide and high.
    Ready(Arc<Image<Straight>>),
    /// The file cannot be decoded, and why.
    Failed(String),
}

impl Photos {
    /// The pixels of the photograph with this digest, if they are there.
    pub(super) fn whole(&self, digest: Digest) -> Option<&Arc<Image<Straight>>> {
        let (of, image) = self.whole.as_ref()?;
        (*of == digest).then_some(image)
    }

    /// The thumbnail of the photograph with this digest, `None` before it was asked for.
    pub(super) fn thumbnail(&self, digest: Digest) -> Option<&Thumbnail> {
        self.thumbnails.get(&digest)
    }

    /// Notes that the pixels of the photograph with this digest are needed; whether they must be asked
    /// for: those of one photograph at a time are kept or on their way.
    pub(super) fn ask(&mut self, digest: Digest) -> bool {
        self.asked.replace(digest) != Some(digest)
    }

    /// The smaller versions of the photograph with this digest, if they are there.
    pub(super) fn pyramid(&self, digest: Digest) -> Option<&Arc<Pyramid>> {
        let (of, pyramid) = self.pyramid.as_ref()?;
        (*of == digest).then_some(pyramid)
    }

    pub(super) fn put_pyramid(&mut self, digest: Digest, pyramid: Arc<Pyramid>) {
        self.pyramid = Some((digest, pyramid));
    }

    pub(super) fn put_whole(&mut self, digest: Digest, image: Arc<Image<Straight>>) {
        self.whole = Some((digest, image));
    }

    pub(super) fn put_thumbnail(&mut self, digest: Digest, thumbnail: Thumbnail) {
        self.thumbnails.insert(digest, thumbnail);
    }
}
