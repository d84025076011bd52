//! Which pixels of a tree picture are background, trunk and crown.
//!
//! The labels are what everything later is built on: the pins of the outline (Argudo, Andújar &
//! Chica 2017, *Tree Variations*, §4.3–4.4) come from the crown baseline, the crown's volume and
//! its foliage from the crown's pixels only. A [`Segmenter`] makes them: [`Learned`] is a network, [`Classical`]
//! needs nothing but the picture, [`Auto`] asks the first and, where that is unsure, the second.
//! Hand-painted corrections are labels too.
//!
//! Imports `base` and `raster`.

mod auto;
mod classical;
mod colour;
mod foot;
mod label;
mod onnx;
mod segmenter;
mod sketch;
mod stem;

pub use auto::{Auto, standard};
pub use classical::Classical;
pub use colour::BarkLikelihood;
pub use label::{
    Label, Labels, crown_baseline, crown_count, grey_from_labels, labels_from_grey, trunk_count,
};
pub use onnx::{Card, Learned, ModelError, Runtime};
pub use segmenter::{Provenance, SegmentError, Segmented, Segmenter, Source};
