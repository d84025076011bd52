//! What all segmenters promise.

use super::Labels;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight};

/// A picture could not be segmented.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SegmentError {
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A learned model refused the picture; one line of its own words.
    #[error("the segmentation model failed: {0}")]
    Model(String),
}

/// Something that tells crown from trunk.
///
/// A segmenter depends on nothing but the picture: the same picture gets the same labels on every
/// machine and with any number of threads.
pub trait Segmenter {
    /// The name users see and recipes record, lower case.
    fn name(&self) -> &'static str;

    /// The label of every pixel of `image`.
    ///
    /// Pixels of alpha below 128 are background and all others are not. No trunk pixels means that
    /// the picture shows no trunk, or none that could be told from the crown.
    ///
    /// # Errors
    /// [`SegmentError::Cancelled`] soon after `cancel` was raised.
    fn segment(&self, image: &Image<Straight>, cancel: &Cancel) -> Result<Labels, SegmentError>;
}
