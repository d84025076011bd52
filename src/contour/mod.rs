//! The outline of a tree as a vector of fixed length, comparable between trees.
//!
//! mask → outlines (border following) → pins → resampled and simplified contours → contour space.
//! After Argudo, Andújar & Chica, *Tree Variations* (2017), §4.2 and §4.4–4.6, §5.1.
//!
//! A contour is a closed list of points, **counter-clockwise as seen on screen**, starting at the
//! foot of the tree (pin B): right side of the trunk, crown, left side of the trunk.
//!
//! Imports `base`, `raster`, `geometry`.

mod outline;
mod pinned;
mod pins;

pub use outline::{Outline, Outlines, filled, outlines};
pub use pinned::{CROWN_SHARE, FOOT_SHARE, PinnedContour, TRUNK_SHARE};
pub use pins::{HandPins, Pins, pins};
