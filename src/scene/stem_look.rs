//! What a picture shows of a stem.

use crate::branches::bark::BarkKind;
use serde::{Deserialize, Serialize};

/// How thick a stem is, and the colour of its bark.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StemLook {
    /// Radius above the root flare, metres.
    pub base_radius_m: f64,
    /// Radius where it ends in the crown, metres.
    pub top_radius_m: f64,
    /// Mean colour, sRGB.
    pub bark: [u8; 3],
    /// Structure of its bark; furrowed in records of before there was a choice.
    #[serde(default)]
    pub bark_kind: BarkKind,
}

impl StemLook {
    /// Whether it is one that stems can have.
    pub fn is_sound(&self) -> bool {
        let is_radius = |radius: f64| (1e-4..=100.0).contains(&radius);
        is_radius(self.base_radius_m) && is_radius(self.top_radius_m)
    }
}
