//! Slender and weeping trees: birch, poplar, willow.

use super::super::bark::{Bark, BarkKind};
use super::super::crown::Crown;
use super::super::foliage::{Foliage, LeafTint, Phyllotaxis};
use super::super::sprite::LeafShape;
use super::{Habit, Season, Species, Spread};

/// Slender, white-stemmed, airy, with drooping outer twigs.
pub(super) const BIRCH: Species = Species {
    name: "birch",
    height_m: 14.0,
    stem_m: 0.17,
    tip_m: 0.008,
    habit: Habit::Crown(Crown {
        base: 0.26,
        outline: &[
            (0.0, 0.10),
            (0.2, 0.20),
            (0.45, 0.215),
            (0.75, 0.14),
            (0.93, 0.06),
            (1.0, 0.01),
        ],
        lobes: 110,
        lobe: (0.05, 0.09),
        flatness: 0.75,
        loose: 0.12,
        spacing_m: 0.46,
        leader: 0.90,
        stems: 1,
        crook: 0.16,
        rise: 0.20,
        strands_m: 0.75,
    }),
    bark: Bark {
        kind: BarkKind::Birch,
        low: [216, 211, 202],
        high: [176, 160, 146],
    },
    foliage: Foliage {
        shape: LeafShape::Ovate,
        leaf_m: 0.09,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 1.8,
        twig_m: 0.26,
        leaves: 8,
        bearing_tips: 5,
        droop: 0.75,
    },
    seasons: &[
        Season::plain(BIRCH_LEAF),
        Season::plain(BIRCH_LEAF),
        Season {
            tint: LeafTint {
                main: [172, 136, 52],
                other: [140, 138, 66],
                through: [206, 168, 60],
                share: 0.35,
                patchy: 0.7,
            },
            leaves: 0.85,
            ornament: None,
        },
    ],
    spread: Spread {
        height: (0.7, 1.12),
        breadth: (0.8, 1.25),
        bare: (0.7, 1.35),
        density: (0.75, 1.2),
        lean: 0.06,
    },
    seed: 1,
};

/// Birch leaves in summer.
const BIRCH_LEAF: LeafTint = LeafTint {
    main: [98, 118, 60],
    other: [134, 146, 78],
    through: [150, 158, 70],
    share: 0.40,
    patchy: 0.3,
};

/// A tight column of rising limbs.
pub(super) const POPLAR: Species = Species {
    name: "poplar",
    height_m: 18.0,
    stem_m: 0.26,
    tip_m: 0.010,
    habit: Habit::Crown(Crown {
        base: 0.07,
        outline: &[
            (0.0, 0.055),
            (0.12, 0.095),
            (0.45, 0.125),
            (0.75, 0.10),
            (0.93, 0.05),
            (1.0, 0.008),
        ],
        lobes: 420,
        lobe: (0.028, 0.05),
        flatness: 1.5,
        loose: 0.28,
        spacing_m: 0.36,
        leader: 0.96,
        stems: 1,
        crook: 0.14,
        rise: 0.9,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Furrowed,
        low: [116, 108, 96],
        high: [126, 120, 106],
    },
    foliage: Foliage {
        shape: LeafShape::Round,
        leaf_m: 0.105,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 2.9,
        twig_m: 0.30,
        leaves: 10,
        bearing_tips: 8,
        droop: 0.2,
    },
    seasons: &[Season::plain(LeafTint {
        main: [88, 114, 60],
        other: [122, 142, 74],
        through: [150, 166, 66],
        share: 0.35,
        patchy: 0.35,
    })],
    spread: Spread {
        height: (0.7, 1.1),
        breadth: (0.72, 1.12),
        bare: (0.5, 1.3),
        density: (0.8, 1.1),
        lean: 0.015,
    },
    seed: 1,
};

/// Weeping: a few rising limbs under curtains of narrow leaves.
pub(super) const WILLOW: Species = Species {
    name: "willow",
    height_m: 10.5,
    stem_m: 0.33,
    tip_m: 0.007,
    habit: Habit::Crown(Crown {
        base: 0.38,
        outline: &[
            (0.0, 0.20),
            (0.25, 0.36),
            (0.6, 0.36),
            (0.85, 0.22),
            (1.0, 0.04),
        ],
        lobes: 60,
        lobe: (0.09, 0.14),
        flatness: 0.7,
        loose: 0.12,
        spacing_m: 0.48,
        leader: 0.24,
        stems: 1,
        crook: 0.28,
        rise: 0.12,
        strands_m: 2.7,
    }),
    bark: Bark {
        kind: BarkKind::Furrowed,
        low: [118, 108, 92],
        high: [132, 122, 84],
    },
    foliage: Foliage {
        shape: LeafShape::Lance,
        leaf_m: 0.125,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 1.35,
        twig_m: 0.17,
        leaves: 8,
        bearing_tips: 9,
        droop: 0.95,
    },
    seasons: &[Season::plain(LeafTint {
        main: [104, 120, 68],
        other: [136, 146, 90],
        through: [152, 160, 80],
        share: 0.4,
        patchy: 0.3,
    })],
    spread: Spread {
        height: (0.8, 1.15),
        breadth: (0.85, 1.15),
        bare: (0.85, 1.15),
        density: (0.8, 1.15),
        lean: 0.09,
    },
    seed: 1,
};
