//! What all segmenters promise.

use super::Labels;
use crate::base::{Cancel, Cancelled, Digest};
use crate::raster::{Image, Straight};
use serde::{Deserialize, Serialize};
use std::fmt;

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

/// What labels come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// A trained network.
    Learned,
    /// Rules: colour, width and height.
    Classical,
}

impl Source {
    /// The name that users see and records keep.
    pub fn name(self) -> &'static str {
        match self {
            Self::Learned => "learned",
            Self::Classical => "classical",
        }
    }
}

impl fmt::Display for Source {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Who labelled a picture, how sure it was, and why it was asked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Who.
    pub source: Source,
    /// How good the learned labels are expected to be, 0 to 1 (see [`super::Learned`]); also where
    /// they were not taken because of it. `None` when no network was asked.
    pub confidence: Option<f32>,
    /// Why it was not the network, for people; one line.
    pub reason: Option<String>,
}

/// The label of each pixel, and who says so.
#[derive(Debug, Clone, PartialEq)]
pub struct Segmented {
    /// The labels.
    pub labels: Labels,
    /// Who says so.
    pub provenance: Provenance,
}

/// Something that tells crown from trunk.
///
/// A segmenter depends on nothing but the picture: on one machine the same picture gets the same
/// labels with any number of threads. Rules give the same labels on every machine, too. A network's
/// sums differ in their last bits from processor to processor and from runtime to runtime; its
/// labels are made of rounded numbers, so that at most one pixel in a thousand may differ.
pub trait Segmenter: Sync {
    /// The name users see, lower case.
    fn name(&self) -> &'static str;

    /// All that the labels depend on besides the picture, for caches and records: the same key means
    /// the same labels for the same picture.
    fn key(&self) -> String;

    /// The network that it may ask, by its digest (see [`super::Learned::digest`]).
    fn model(&self) -> Option<Digest> {
        None
    }

    /// Makes ready what the first picture waits for; for a thread of its own, while that is read.
    fn prepare(&self) {}

    /// The label of every pixel of `image`, and who says so.
    ///
    /// In a picture with clear ground, pixels of alpha below 128 are background and all others are
    /// not. No trunk pixels means that the picture shows no trunk, or none that could be told from
    /// the crown.
    ///
    /// # Errors
    /// [`SegmentError::Cancelled`] soon after `cancel` was raised.
    fn segmented(
        &self,
        image: &Image<Straight>,
        cancel: &Cancel,
    ) -> Result<Segmented, SegmentError>;

    /// The labels alone.
    ///
    /// # Errors
    /// As [`Segmenter::segmented`].
    fn segment(&self, image: &Image<Straight>, cancel: &Cancel) -> Result<Labels, SegmentError> {
        self.segmented(image, cancel).map(|found| found.labels)
    }
}
