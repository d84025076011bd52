//! What can be asked of masks and of the tools that change them.

use super::tools::ToolOption;
use crate::paint::Sample;
use std::path::PathBuf;

/// A command of the mask menu that changes labels or brings them in and out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum MaskCommand {
    /// Labels what the picture itself tells.
    Propose,
    /// Widens the label.
    Grow,
    /// Narrows the label.
    Shrink,
    /// Rounds the label's outline.
    Smooth,
    /// Labels what labels enclose.
    FillHoles,
    /// Clears small pieces.
    RemoveSpecks,
    /// Exchanges left and right.
    Flip,
    /// Makes the right half the mirror image of the left.
    MirrorLeft,
    /// Makes the left half the mirror image of the right.
    MirrorRight,
    /// Labels from a picture file.
    Import,
    /// Labels to a picture file.
    Export,
}

/// Something to be done with a mask.
#[derive(Debug, Clone, PartialEq)]
pub enum MaskAction {
    /// Sets a tool.
    Set(ToolOption),
    /// The hand moved over the canvas with nothing pressed.
    Hover(Sample),
    /// Closes the line in progress, or takes the smart selection.
    Close,
    /// Takes the last click of the line in progress back.
    Back,
    /// Labels from this picture file.
    Import(PathBuf),
    /// Labels to this picture file.
    Export(PathBuf),
}
