//! The leaves that crowns are drawn and exported with, by the names that records and flags have for them.

use super::sprite::LeafShape;
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
    /// Short needles: spruce, fir.
    Brush,
    /// Long needles: pine.
    Tuft,
    /// Feathered, from the middle of the crown to its edge: palm.
    Frond,
}

impl LeafName {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Ovate,
        Self::Round,
        Self::Lobed,
        Self::Palmate,
        Self::Lance,
        Self::Brush,
        Self::Tuft,
        Self::Frond,
    ];

    /// The shape of that name; fronds are made of blades.
    pub fn shape(self) -> LeafShape {
        match self {
            Self::Ovate => LeafShape::Ovate,
            Self::Round => LeafShape::Round,
            Self::Lobed => LeafShape::Lobed,
            Self::Palmate => LeafShape::Palmate,
            Self::Lance => LeafShape::Lance,
            Self::Brush => LeafShape::Brush,
            Self::Tuft => LeafShape::Tuft,
            Self::Frond => LeafShape::Blade,
        }
    }
}
