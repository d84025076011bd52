//! Broad-crowned trees: oak, maple, apple, linden, robinia.

use super::super::bark::{Bark, BarkKind};
use super::super::crown::Crown;
use super::super::foliage::{Foliage, LeafTint, Phyllotaxis};
use super::super::ornament::{Ornament, OrnamentKind};
use super::super::sprite::LeafShape;
use super::{Habit, Season, Species, Spread};

/// Broad, gnarled, with a short stem and dense lobed foliage.
pub(super) const OAK: Species = Species {
    name: "oak",
    height_m: 13.0,
    stem_m: 0.42,
    tip_m: 0.011,
    habit: Habit::Crown(Crown {
        base: 0.20,
        outline: &[
            (0.0, 0.20),
            (0.12, 0.37),
            (0.35, 0.45),
            (0.6, 0.42),
            (0.82, 0.30),
            (0.95, 0.14),
            (1.0, 0.02),
        ],
        lobes: 110,
        lobe: (0.085, 0.15),
        flatness: 0.62,
        loose: 0.10,
        spacing_m: 0.44,
        leader: 0.24,
        stems: 1,
        crook: 0.32,
        rise: 0.02,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Furrowed,
        low: [122, 108, 92],
        high: [104, 94, 80],
    },
    foliage: Foliage {
        shape: LeafShape::Lobed,
        leaf_m: 0.135,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 3.6,
        twig_m: 0.36,
        leaves: 10,
        bearing_tips: 5,
        droop: 0.25,
    },
    seasons: &[Season::plain(LeafTint {
        main: [84, 106, 50],
        other: [118, 132, 62],
        through: [150, 160, 60],
        share: 0.38,
        patchy: 0.45,
    })],
    spread: Spread {
        height: (0.72, 1.12),
        breadth: (0.85, 1.12),
        bare: (0.8, 1.35),
        density: (0.8, 1.15),
        lean: 0.05,
    },
    seed: 1,
};

/// Round-headed and dense, with pointed leaves in pairs.
pub(super) const MAPLE: Species = Species {
    name: "maple",
    height_m: 12.0,
    stem_m: 0.25,
    tip_m: 0.010,
    habit: Habit::Crown(Crown {
        base: 0.21,
        outline: &[
            (0.0, 0.13),
            (0.12, 0.27),
            (0.35, 0.36),
            (0.6, 0.345),
            (0.82, 0.24),
            (0.95, 0.11),
            (1.0, 0.02),
        ],
        lobes: 150,
        lobe: (0.075, 0.13),
        flatness: 0.72,
        loose: 0.16,
        spacing_m: 0.42,
        leader: 0.36,
        stems: 1,
        crook: 0.20,
        rise: 0.22,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Furrowed,
        low: [118, 110, 100],
        high: [110, 102, 92],
    },
    foliage: Foliage {
        shape: LeafShape::Palmate,
        leaf_m: 0.155,
        phyllotaxis: Phyllotaxis::Opposite,
        twigs: 2.5,
        twig_m: 0.36,
        leaves: 10,
        bearing_tips: 4,
        droop: 0.5,
    },
    seasons: &[
        Season::plain(MAPLE_LEAF),
        Season::plain(MAPLE_LEAF),
        Season {
            tint: LeafTint {
                main: [150, 76, 42],
                other: [186, 142, 66],
                through: [206, 132, 52],
                share: 0.42,
                patchy: 0.85,
            },
            leaves: 0.85,
            ornament: None,
        },
    ],
    spread: Spread {
        height: (0.7, 1.15),
        breadth: (0.85, 1.15),
        bare: (0.75, 1.4),
        density: (0.75, 1.2),
        lean: 0.05,
    },
    seed: 1,
};

/// Maple leaves in summer.
const MAPLE_LEAF: LeafTint = LeafTint {
    main: [82, 106, 56],
    other: [114, 132, 66],
    through: [134, 158, 58],
    share: 0.35,
    patchy: 0.4,
};

/// A tall dome of round leaves, low over the ground.
pub(super) const LINDEN: Species = Species {
    name: "linden",
    height_m: 14.0,
    stem_m: 0.30,
    habit: Habit::Crown(Crown {
        base: 0.14,
        outline: &[
            (0.0, 0.15),
            (0.10, 0.26),
            (0.3, 0.315),
            (0.6, 0.27),
            (0.85, 0.15),
            (1.0, 0.02),
        ],
        lobes: 150,
        lobe: (0.06, 0.115),
        flatness: 0.66,
        loose: 0.08,
        spacing_m: 0.44,
        leader: 0.62,
        stems: 1,
        crook: 0.2,
        rise: 0.1,
        strands_m: 0.0,
    }),
    foliage: Foliage {
        shape: LeafShape::Round,
        leaf_m: 0.115,
        phyllotaxis: Phyllotaxis::Rows,
        twigs: 2.7,
        twig_m: 0.36,
        leaves: 9,
        bearing_tips: 5,
        droop: 0.45,
    },
    seasons: &[Season::plain(LeafTint {
        main: [92, 112, 52],
        other: [130, 142, 66],
        through: [156, 166, 60],
        share: 0.36,
        patchy: 0.45,
    })],
    spread: Spread {
        height: (0.7, 1.1),
        breadth: (0.85, 1.15),
        bare: (0.7, 1.6),
        density: (0.8, 1.15),
        lean: 0.04,
    },
    seed: 1,
    ..MAPLE
};

/// Open crown on a light scaffold: sky shows between its boughs.
pub(super) const ROBINIA: Species = Species {
    name: "robinia",
    height_m: 13.0,
    stem_m: 0.22,
    tip_m: 0.009,
    habit: Habit::Crown(Crown {
        base: 0.34,
        outline: &[
            (0.0, 0.12),
            (0.2, 0.25),
            (0.55, 0.31),
            (0.85, 0.20),
            (1.0, 0.04),
        ],
        lobes: 60,
        lobe: (0.065, 0.11),
        flatness: 0.55,
        loose: 0.07,
        spacing_m: 0.44,
        leader: 0.42,
        stems: 1,
        crook: 0.32,
        rise: 0.12,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Furrowed,
        low: [112, 100, 84],
        high: [98, 86, 72],
    },
    foliage: Foliage {
        shape: LeafShape::Ovate,
        leaf_m: 0.105,
        phyllotaxis: Phyllotaxis::Rows,
        twigs: 2.4,
        twig_m: 0.42,
        leaves: 12,
        bearing_tips: 5,
        droop: 0.35,
    },
    seasons: &[Season::plain(LeafTint {
        main: [100, 122, 64],
        other: [136, 150, 80],
        through: [166, 176, 72],
        share: 0.4,
        patchy: 0.35,
    })],
    spread: Spread {
        height: (0.7, 1.1),
        breadth: (0.85, 1.2),
        bare: (0.8, 1.25),
        density: (0.8, 1.2),
        lean: 0.08,
    },
    seed: 1,
};

/// Low and broad on a short stem, crooked: an orchard tree in blossom, in leaf and in fruit.
pub(super) const APPLE: Species = Species {
    name: "apple",
    height_m: 6.0,
    stem_m: 0.15,
    tip_m: 0.007,
    habit: Habit::Crown(Crown {
        base: 0.26,
        outline: &[
            (0.0, 0.22),
            (0.12, 0.40),
            (0.4, 0.47),
            (0.7, 0.39),
            (0.9, 0.22),
            (1.0, 0.05),
        ],
        lobes: 120,
        lobe: (0.09, 0.15),
        flatness: 0.68,
        loose: 0.12,
        spacing_m: 0.235,
        leader: 0.28,
        stems: 1,
        crook: 0.42,
        rise: 0.06,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Plates,
        low: [118, 108, 98],
        high: [112, 100, 88],
    },
    foliage: Foliage {
        shape: LeafShape::Ovate,
        leaf_m: 0.082,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 2.5,
        twig_m: 0.2,
        leaves: 8,
        bearing_tips: 5,
        droop: 0.3,
    },
    seasons: &[
        Season {
            tint: LeafTint {
                main: [112, 134, 66],
                other: [146, 158, 84],
                through: [170, 182, 78],
                share: 0.4,
                patchy: 0.3,
            },
            leaves: 0.62,
            ornament: Some(Ornament {
                kind: OrnamentKind::Blossom,
                size_m: 0.062,
                per_twig: 5.0,
                colours: [[236, 226, 228], [226, 178, 194]],
            }),
        },
        Season::plain(APPLE_LEAF),
        Season {
            tint: APPLE_LEAF,
            leaves: 0.95,
            ornament: Some(Ornament {
                kind: OrnamentKind::Fruit,
                size_m: 0.098,
                per_twig: 0.085,
                colours: [[158, 28, 26], [172, 92, 44]],
            }),
        },
    ],
    spread: Spread {
        height: (0.8, 1.15),
        breadth: (0.85, 1.1),
        bare: (0.8, 1.25),
        density: (0.8, 1.1),
        lean: 0.12,
    },
    seed: 1,
};

/// Apple leaves in summer.
const APPLE_LEAF: LeafTint = LeafTint {
    main: [88, 112, 58],
    other: [126, 140, 78],
    through: [150, 164, 66],
    share: 0.36,
    patchy: 0.35,
};
