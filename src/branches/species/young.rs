//! What is small: a young tree, a shrub.

use super::super::bark::{Bark, BarkKind};
use super::super::crown::Crown;
use super::super::foliage::{Foliage, LeafTint, Phyllotaxis};
use super::super::sprite::LeafShape;
use super::{Habit, Season, Species, Spread};

/// A few years old: thin stem, open, upright.
pub(super) const SAPLING: Species = Species {
    name: "sapling",
    height_m: 5.2,
    stem_m: 0.046,
    tip_m: 0.006,
    habit: Habit::Crown(Crown {
        base: 0.30,
        outline: &[
            (0.0, 0.10),
            (0.2, 0.20),
            (0.5, 0.22),
            (0.8, 0.13),
            (1.0, 0.02),
        ],
        lobes: 140,
        lobe: (0.055, 0.09),
        flatness: 0.9,
        loose: 0.15,
        spacing_m: 0.26,
        leader: 0.88,
        stems: 1,
        crook: 0.18,
        rise: 0.35,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Smooth,
        low: [128, 116, 98],
        high: [120, 104, 84],
    },
    foliage: Foliage {
        shape: LeafShape::Ovate,
        leaf_m: 0.07,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 3.2,
        twig_m: 0.2,
        leaves: 9,
        bearing_tips: 5,
        droop: 0.35,
    },
    seasons: &[Season::plain(LeafTint {
        main: [92, 118, 60],
        other: [128, 144, 78],
        through: [160, 176, 70],
        share: 0.4,
        patchy: 0.3,
    })],
    spread: Spread {
        height: (0.7, 1.25),
        breadth: (0.8, 1.3),
        bare: (0.7, 1.35),
        density: (0.6, 1.2),
        lean: 0.07,
    },
    seed: 1,
};

/// Many stems from the ground, leafy down to it.
pub(super) const SHRUB: Species = Species {
    name: "shrub",
    height_m: 3.0,
    stem_m: 0.045,
    tip_m: 0.005,
    habit: Habit::Crown(Crown {
        base: 0.05,
        outline: &[
            (0.0, 0.36),
            (0.15, 0.45),
            (0.4, 0.49),
            (0.7, 0.39),
            (0.9, 0.22),
            (1.0, 0.04),
        ],
        lobes: 200,
        lobe: (0.11, 0.18),
        flatness: 0.85,
        loose: 0.12,
        spacing_m: 0.15,
        leader: 0.30,
        stems: 7,
        crook: 0.25,
        rise: 0.15,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Smooth,
        low: [112, 100, 84],
        high: [108, 92, 74],
    },
    foliage: Foliage {
        shape: LeafShape::Ovate,
        leaf_m: 0.041,
        phyllotaxis: Phyllotaxis::Opposite,
        twigs: 3.7,
        twig_m: 0.12,
        leaves: 9,
        bearing_tips: 5,
        droop: 0.15,
    },
    seasons: &[Season::plain(LeafTint {
        main: [74, 100, 54],
        other: [112, 130, 72],
        through: [140, 156, 62],
        share: 0.35,
        patchy: 0.35,
    })],
    spread: Spread {
        height: (0.7, 1.2),
        breadth: (0.75, 1.05),
        bare: (0.8, 1.2),
        density: (0.75, 1.15),
        lean: 0.05,
    },
    seed: 1,
};
