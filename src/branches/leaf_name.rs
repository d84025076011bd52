//! The leaves that crowns are drawn and exported with, by the names that records and flags have for them.

use serde::{Deserialize, Serialize};

/// Leaves of a crown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LeafName {
    /// Egg-shaped: birch, apple.
    #[default]
    Ovate,
    /// Nearly round: aspen, lime.
    Round,
    /// Wavy lobes: oak.
    Lobed,
    /// Pointed fingers: maple.
    Palmate,
    /// Long and narrow: willow.
    Lance,
    /// Short needles: yew, juniper.
    Brush,
    /// Long needles: pine.
    Tuft,
    /// Feathered, from the middle of the crown to its edge: palm.
    Frond,
    /// Boughs with short needles in tiers about the stem: spruce, fir.
    Bough,
}

impl LeafName {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Ovate,
        Self::Round,
        Self::Lobed,
        Self::Palmate,
        Self::Lance,
        Self::Brush,
        Self::Tuft,
        Self::Frond,
        Self::Bough,
    ];
}
