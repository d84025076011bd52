//! What can go wrong while drawing.

use crate::base::Cancelled;

/// A picture could not be drawn.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// There is no graphics adapter, or none that this program can use.
    #[error("no graphics card can be used: {0}")]
    NoAdapter(String),
    /// The card ran out of memory.
    #[error("the graphics card is out of memory: {0}")]
    OutOfMemory(String),
    /// The card was taken away, reset or stopped answering.
    #[error("the graphics card was lost: {0}")]
    DeviceLost(String),
    /// The picture is larger than the card can draw.
    #[error(
        "a picture of {width}×{height} samples is more than the graphics card can draw ({most})"
    )]
    TooLarge {
        /// Samples across.
        width: u32,
        /// Samples down.
        height: u32,
        /// Most samples of a side.
        most: u32,
    },
    /// A shader could not be read or compiled; the one before is still in use.
    #[error("a shader cannot be used: {0}")]
    Shader(String),
    /// The work was asked to stop.
    #[error("{0}")]
    Cancelled(#[from] Cancelled),
}

impl RenderError {
    /// Whether the processor could draw where the graphics card could not.
    pub fn is_of_device(&self) -> bool {
        !matches!(self, Self::Cancelled(_) | Self::Shader(_))
    }
}
