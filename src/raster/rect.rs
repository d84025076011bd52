//! A rectangle of whole pixels.

use serde::{Deserialize, Serialize};

/// `width` × `height` pixels with the top-left one at (`x`, `y`).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Rect {
    /// Column of the left edge's pixels.
    pub x: u32,
    /// Row of the top edge's pixels.
    pub y: u32,
    /// Number of columns.
    pub width: u32,
    /// Number of rows.
    pub height: u32,
}
