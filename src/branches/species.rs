//! The species table: every number that makes an oak an oak.
//!
//! Names say "like": these are characters for pictures, not botany. Leaves are a third larger
//! than in nature, as they are in games, so that they can be read at a distance.

use super::bark::{Bark, BarkKind};
use super::crown::Crown;
use super::foliage::{Foliage, LeafTint, Phyllotaxis};
use super::sprite::LeafShape;
use super::whorls::Whorls;

/// How a skeleton is made.
#[derive(Debug, Clone, Copy)]
pub enum Habit {
    /// By space colonisation of a lobed crown.
    Crown(Crown),
    /// By rule, in whorls.
    Whorls(Whorls),
}

/// One species character.
#[derive(Debug, Clone, Copy)]
pub struct Species {
    /// Height in metres, of the envelope: a grown tree differs by a few per cent.
    pub height_m: f32,
    /// Radius of the stem above the flare in metres.
    pub stem_m: f32,
    /// Radius of the thinnest skeleton limbs in metres.
    pub tip_m: f32,
    /// Growth.
    pub habit: Habit,
    /// Bark.
    pub bark: Bark,
    /// Leaves.
    pub foliage: Foliage,
}

/// Broad, gnarled, with a short stem and dense lobed foliage.
pub const OAK: Species = Species {
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
        leaf_m: 0.16,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 3.2,
        twig_m: 0.36,
        leaves: 8,
        bearing_tips: 5,
        droop: 0.25,
        tint: LeafTint {
            main: [84, 106, 50],
            other: [118, 132, 62],
            through: [150, 160, 60],
            share: 0.38,
            patchy: 0.45,
        },
    },
};

/// Slender, white-stemmed, airy, with drooping outer twigs.
pub const BIRCH: Species = Species {
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
        leaf_m: 0.11,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 1.5,
        twig_m: 0.26,
        leaves: 6,
        bearing_tips: 5,
        droop: 0.75,
        tint: LeafTint {
            main: [98, 118, 60],
            other: [134, 146, 78],
            through: [150, 158, 70],
            share: 0.40,
            patchy: 0.3,
        },
    },
};

/// A tight column of rising limbs.
pub const POPLAR: Species = Species {
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
        lobes: 240,
        lobe: (0.035, 0.06),
        flatness: 1.5,
        loose: 0.2,
        spacing_m: 0.42,
        leader: 0.93,
        stems: 1,
        crook: 0.14,
        rise: 0.75,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Furrowed,
        low: [116, 108, 96],
        high: [126, 120, 106],
    },
    foliage: Foliage {
        shape: LeafShape::Round,
        leaf_m: 0.15,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 2.2,
        twig_m: 0.30,
        leaves: 7,
        bearing_tips: 5,
        droop: 0.2,
        tint: LeafTint {
            main: [88, 114, 60],
            other: [122, 142, 74],
            through: [150, 166, 66],
            share: 0.35,
            patchy: 0.35,
        },
    },
};

/// Round-headed and dense, with pointed leaves in pairs.
pub const MAPLE: Species = Species {
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
        leaf_m: 0.18,
        phyllotaxis: Phyllotaxis::Opposite,
        twigs: 2.2,
        twig_m: 0.36,
        leaves: 8,
        bearing_tips: 4,
        droop: 0.5,
        tint: LeafTint {
            main: [82, 106, 56],
            other: [114, 132, 66],
            through: [134, 158, 58],
            share: 0.35,
            patchy: 0.4,
        },
    },
};

/// A tall dome of round leaves, low over the ground.
pub const LINDEN: Species = Species {
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
        leaf_m: 0.135,
        phyllotaxis: Phyllotaxis::Rows,
        twigs: 2.7,
        twig_m: 0.36,
        leaves: 7,
        bearing_tips: 5,
        droop: 0.45,
        tint: LeafTint {
            main: [92, 112, 52],
            other: [130, 142, 66],
            through: [156, 166, 60],
            share: 0.36,
            patchy: 0.45,
        },
    },
    ..MAPLE
};

/// The maple in October.
pub const MAPLE_AUTUMN: Species = Species {
    foliage: Foliage {
        leaves: 7,
        twigs: 2.0,
        tint: LeafTint {
            main: [150, 76, 42],
            other: [186, 142, 66],
            through: [206, 132, 52],
            share: 0.42,
            patchy: 0.85,
        },
        ..MAPLE.foliage
    },
    ..MAPLE
};

/// A few years old: thin stem, open, upright.
pub const SAPLING: Species = Species {
    height_m: 5.2,
    stem_m: 0.055,
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
        leaf_m: 0.088,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 2.8,
        twig_m: 0.2,
        leaves: 7,
        bearing_tips: 5,
        droop: 0.35,
        tint: LeafTint {
            main: [92, 118, 60],
            other: [128, 144, 78],
            through: [160, 176, 70],
            share: 0.4,
            patchy: 0.3,
        },
    },
};

/// Many stems from the ground, leafy down to it.
pub const SHRUB: Species = Species {
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
        leaf_m: 0.052,
        phyllotaxis: Phyllotaxis::Opposite,
        twigs: 3.0,
        twig_m: 0.12,
        leaves: 8,
        bearing_tips: 5,
        droop: 0.15,
        tint: LeafTint {
            main: [74, 100, 54],
            other: [112, 130, 72],
            through: [140, 156, 62],
            share: 0.35,
            patchy: 0.35,
        },
    },
};

/// Weeping: a few rising limbs under curtains of narrow leaves.
pub const WILLOW: Species = Species {
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
        leaf_m: 0.135,
        phyllotaxis: Phyllotaxis::Spiral,
        twigs: 1.35,
        twig_m: 0.17,
        leaves: 7,
        bearing_tips: 9,
        droop: 0.95,
        tint: LeafTint {
            main: [104, 120, 68],
            other: [136, 146, 90],
            through: [152, 160, 80],
            share: 0.4,
            patchy: 0.3,
        },
    },
};

/// Open crown on a light scaffold: sky shows between its boughs.
pub const ROBINIA: Species = Species {
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
        leaf_m: 0.125,
        phyllotaxis: Phyllotaxis::Rows,
        twigs: 2.4,
        twig_m: 0.42,
        leaves: 10,
        bearing_tips: 5,
        droop: 0.35,
        tint: LeafTint {
            main: [100, 122, 64],
            other: [136, 150, 80],
            through: [166, 176, 72],
            share: 0.4,
            patchy: 0.35,
        },
    },
};

/// Dark, conical, with sinking boughs down to the ground.
pub const SPRUCE: Species = Species {
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
        tint: LeafTint {
            main: [64, 88, 54],
            other: [100, 120, 70],
            through: [96, 116, 52],
            share: 0.35,
            patchy: 0.35,
        },
    },
};

/// Blue-green, tighter, with level boughs.
pub const FIR: Species = Species {
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
        tint: LeafTint {
            main: [70, 94, 74],
            other: [112, 132, 104],
            through: [104, 124, 70],
            share: 0.35,
            patchy: 0.3,
        },
        ..SPRUCE.foliage
    },
    ..SPRUCE
};

/// A tall bare stem, orange above, with a crown of flat clouds.
pub const PINE: Species = Species {
    height_m: 16.0,
    stem_m: 0.25,
    tip_m: 0.012,
    habit: Habit::Crown(Crown {
        base: 0.56,
        outline: &[
            (0.0, 0.10),
            (0.2, 0.22),
            (0.5, 0.23),
            (0.8, 0.16),
            (1.0, 0.03),
        ],
        lobes: 46,
        lobe: (0.065, 0.11),
        flatness: 0.42,
        loose: 0.02,
        spacing_m: 0.33,
        leader: 0.78,
        stems: 1,
        crook: 0.24,
        rise: 0.05,
        strands_m: 0.0,
    }),
    bark: Bark {
        kind: BarkKind::Plates,
        low: [124, 104, 88],
        high: [176, 116, 76],
    },
    foliage: Foliage {
        shape: LeafShape::Tuft,
        leaf_m: 0.40,
        phyllotaxis: Phyllotaxis::Cards,
        twigs: 4.5,
        twig_m: 0.0,
        leaves: 1,
        bearing_tips: 3,
        droop: 0.0,
        tint: LeafTint {
            main: [72, 94, 62],
            other: [110, 126, 78],
            through: [112, 128, 62],
            share: 0.35,
            patchy: 0.3,
        },
    },
};
