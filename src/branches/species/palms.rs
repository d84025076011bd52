//! Palms.

use super::super::bark::{Bark, BarkKind};
use super::super::foliage::{Foliage, LeafTint, Phyllotaxis};
use super::super::palm::Palm;
use super::super::sprite::LeafShape;
use super::{Habit, Season, Species, Spread};

/// A bare, ringed stem under a head of arching feathers.
pub(super) const PALM: Species = Species {
    name: "palm",
    height_m: 9.0,
    stem_m: 0.20,
    tip_m: 0.004,
    habit: Habit::Palm(Palm {
        fronds: 46.0,
        frond_m: 3.1,
        leaflets: 84,
        bend: 1.05,
        dry: 0.08,
        bulge: 0.55,
    }),
    bark: Bark {
        kind: BarkKind::Rings,
        low: [128, 114, 98],
        high: [138, 118, 94],
    },
    foliage: Foliage {
        shape: LeafShape::Blade,
        leaf_m: 0.62,
        phyllotaxis: Phyllotaxis::Rows,
        twigs: 1.0,
        twig_m: 0.0,
        leaves: 1,
        bearing_tips: 1,
        droop: 0.3,
    },
    seasons: &[Season::plain(LeafTint {
        main: [70, 100, 56],
        other: [164, 142, 92],
        through: [150, 162, 70],
        share: 0.3,
        patchy: 0.3,
    })],
    spread: Spread {
        height: (0.5, 1.35),
        breadth: (0.85, 1.15),
        bare: (1.0, 1.0),
        density: (0.8, 1.2),
        lean: 0.16,
    },
    seed: 1,
};
