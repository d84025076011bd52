//! Conifers: spruce, pine, cypress, fir.

use super::super::bark::{Bark, BarkKind};
use super::super::crown::Crown;
use super::super::foliage::{Foliage, LeafTint, Phyllotaxis};
use super::super::sprite::LeafShape;
use super::super::whorls::Whorls;
use super::{Habit, Season, Species, Spread};

/// Dark, conical, with sinking boughs down to the ground.
pub(super) const SPRUCE: Species = Species {
    name: "spruce",
    height_m: 15.0,
    stem_m: 0.24,
    tip_m: 0.007,
    habit: Habit::Whorls(Whorls {
        base: 0.115,
        outline: &[
            (0.0, 0.215),
            (0.08, 0.235),
            (0.5, 0.135),
            (0.9, 0.035),
            (1.0, 0.008),
        ],
        interval_m: 0.44,
        boughs: 9,
        slope: (-0.05, 1.05),
        sink: 0.42,
        lift: 0.24,
        spread: 0.55,
        hang: 0.75,
        twig_step_m: 0.16,
    }),
    bark: Bark {
        kind: BarkKind::Plates,
        low: [112, 92, 76],
        high: [116, 92, 72],
    },
    foliage: Foliage {
        shape: LeafShape::Brush,
        leaf_m: 0.24,
        phyllotaxis: Phyllotaxis::Cards,
        twigs: 1.6,
        twig_m: 0.0,
        leaves: 1,
        bearing_tips: 30,
        droop: 0.25,
    },
    seasons: &[Season::plain(LeafTint {
        main: [64, 88, 54],
        other: [100, 120, 70],
        through: [96, 116, 52],
        share: 0.35,
        patchy: 0.35,
    })],
    spread: Spread {
        height: (0.62, 1.15),
        breadth: (0.85, 1.2),
        bare: (0.5, 1.5),
        density: (0.85, 1.15),
        lean: 0.02,
    },
    seed: 1,
};

/// Blue-green, tighter, with level boughs.
pub(super) const FIR: Species = Species {
    name: "fir",
    height_m: 11.0,
    stem_m: 0.19,
    habit: Habit::Whorls(Whorls {
        base: 0.08,
        outline: &[
            (0.0, 0.18),
            (0.1, 0.24),
            (0.45, 0.19),
            (0.85, 0.065),
            (1.0, 0.01),
        ],
        interval_m: 0.40,
        boughs: 8,
        slope: (0.10, 0.95),
        sink: 0.24,
        lift: 0.12,
        spread: 0.62,
        hang: 0.3,
        twig_step_m: 0.15,
    }),
    foliage: Foliage {
        leaf_m: 0.20,
        twigs: 1.6,
        ..SPRUCE.foliage
    },
    seasons: &[Season::plain(LeafTint {
        main: [70, 94, 74],
        other: [112, 132, 104],
        through: [104, 124, 70],
        share: 0.35,
        patchy: 0.3,
    })],
    spread: Spread {
        height: (0.6, 1.2),
        breadth: (0.85, 1.15),
        bare: (0.5, 1.8),
        density: (0.8, 1.15),
        lean: 0.02,
    },
    seed: 1,
    ..SPRUCE
};

/// A tall bare stem, orange above, with a crown of flat clouds.
pub(super) const PINE: Species = Species {
    name: "pine",
    height_m: 16.0,
    stem_m: 0.25,
    tip_m: 0.009,
    habit: Habit::Crown(Crown {
        base: 0.56,
        outline: &[
            (0.0, 0.10),
            (0.2, 0.22),
            (0.5, 0.23),
            (0.8, 0.16),
            (1.0, 0.03),
        ],
        lobes: 70,
        lobe: (0.065, 0.11),
        flatness: 0.5,
        loose: 0.07,
        spacing_m: 0.33,
        leader: 0.78,
        stems: 1,
        crook: 0.2,
        rise: 0.05,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Plates,
        low: [124, 104, 88],
        high: [166, 112, 80],
    },
    foliage: Foliage {
        shape: LeafShape::Tuft,
        leaf_m: 0.33,
        phyllotaxis: Phyllotaxis::Cards,
        twigs: 7.5,
        twig_m: 0.0,
        leaves: 1,
        bearing_tips: 4,
        droop: 0.0,
    },
    seasons: &[Season::plain(LeafTint {
        main: [72, 94, 62],
        other: [110, 126, 78],
        through: [112, 128, 62],
        share: 0.35,
        patchy: 0.3,
    })],
    spread: Spread {
        height: (0.72, 1.0),
        breadth: (0.85, 1.3),
        bare: (0.75, 1.12),
        density: (0.8, 1.2),
        lean: 0.07,
    },
    seed: 3,
};

/// A dark, close column of upright plumes.
pub(super) const CYPRESS: Species = Species {
    name: "cypress",
    height_m: 14.0,
    stem_m: 0.19,
    tip_m: 0.008,
    habit: Habit::Crown(Crown {
        base: 0.02,
        outline: &[
            (0.0, 0.055),
            (0.10, 0.085),
            (0.4, 0.102),
            (0.75, 0.078),
            (0.93, 0.035),
            (1.0, 0.005),
        ],
        lobes: 420,
        lobe: (0.018, 0.036),
        flatness: 2.4,
        loose: 0.25,
        spacing_m: 0.25,
        leader: 0.95,
        stems: 1,
        crook: 0.12,
        rise: 0.95,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Strips,
        low: [122, 106, 90],
        high: [112, 96, 80],
    },
    foliage: Foliage {
        shape: LeafShape::Spray,
        leaf_m: 0.29,
        phyllotaxis: Phyllotaxis::Cards,
        twigs: 4.4,
        twig_m: 0.0,
        leaves: 1,
        bearing_tips: 22,
        droop: -1.6,
    },
    seasons: &[Season::plain(LeafTint {
        main: [62, 84, 50],
        other: [98, 114, 62],
        through: [96, 112, 50],
        share: 0.34,
        patchy: 0.45,
    })],
    spread: Spread {
        height: (0.7, 1.15),
        breadth: (0.85, 1.6),
        bare: (0.5, 1.9),
        density: (0.9, 1.15),
        lean: 0.02,
    },
    seed: 1,
};
