//! A crown moved by smooth waves: limbs sway, the outline swells and shrinks.
//!
//! An eye knows a tree by its outline and its stem first, so those are moved most. Three fields displace
//! the picture: *sway*, noise in both directions, long waves and short ones; *swell*, along the normal of the
//! crown's rounded outline by noise that changes along that only, which makes lobes and bays and smears no leaf
//! on its way out; and the *stem*, which leans and bends a little and lifts its crown or lets
//! it down. The foot stays; the first two fade in above the crown's lower end. Nothing grows out of
//! the picture. A slender part is moved as little as it is wide.
//!
//! What stands about one straight stem ([`Habit`]) is moved otherwise: its tiers come higher or lower, its
//! boughs reach farther or less far, both sides much alike, and hang more or less. So a spire keeps its
//! tip, narrows to it, and has its tiers level.
//!
//! Limits: where waves of all kinds come together the picture may fold over a few pixels; foliage hides it.

use super::Tree;
use super::habit::Habit;
use super::noise::Noise;
use super::rounded::Rounded;
use crate::base::{Cancel, Cancelled, Random};
use crate::raster::{Image, Straight, opaque_bounds};
use crate::segment::crown_baseline;
use rayon::prelude::*;

/// Length and height of the waves in which limbs sway, in cell sizes, at full strength.
const SWAY: [[f64; 2]; 2] = [[5.5, 1.0], [2.4, 0.4]];

/// The same of the waves in which the outline swells.
const SWELL: [[f64; 2]; 2] = [[3.2, 0.9], [1.6, 0.3]];

/// How much less what stands straight sways, swells, leans and bends.
const STRAIGHT_SWAY: f64 = 0.8;
const STRAIGHT_SWELL: f64 = 0.45;
const STRAIGHT_LEAN: f64 = 0.6;

/// Crowns narrower than twice this many cell sizes are moved less if they stand straight.
const SLENDER: f64 = 1.6;

/// Of what stands straight: length and height of the waves in which boughs reach out, in cell sizes and
/// as a share of their length; both sides together, and each by itself.
const REACH: [[f64; 2]; 2] = [[3.4, 0.18], [1.3, 0.06]];
const REACH_OF_SIDE: [[f64; 2]; 2] = [[2.6, 0.13], [0.9, 0.05]];

/// How much wider or narrower the whole of it becomes, and its foot against its tip.
const BROAD: f64 = 0.3;
const SPREAD: f64 = 0.24;

/// Length and height of the waves in which its tiers move up and down, in cell sizes: where they are steeper, boughs
/// are smeared.
const TIERS: [[f64; 2]; 2] = [[3.6, 0.9], [1.4, 0.12]];

/// How much its boughs rise or hang, as a slope.
const DROOP: f64 = 0.2;

/// How much more the boughs of a tree without leaves rise or hang, and reach out, all alike: neither makes them
/// thicker or crooked.
const BARE: f64 = 1.6;
const BARE_REACH: f64 = 1.25;

/// How far the top may lean and the middle of the tree bend aside, in cell sizes, at full strength.
const LEAN: f64 = 0.8;
const BEND: f64 = 0.6;

/// Length and height of the waves in which a bare stem winds, in cell sizes, and how far its bark moves up
/// or down, as a share of it: knots and bends by which one knows a stem again come elsewhere.
const WINDS: [[f64; 2]; 2] = [[1.4, 0.12], [0.6, 0.05]];
const BARK: f64 = 0.16;

/// How much less the stem of a palm winds, which has no boughs to bend it, and how much shorter it may be, as a share
/// of its length, at full strength: its crown comes down whole.
const PALM_WINDS: f64 = 0.3;
const PALM_SHORTER: f64 = 0.5;

/// How far the crown's lower end may move up or down, in cell sizes, and as shares of the stem below and
/// of the crown above it.
const LIFT: f64 = 1.4;
const MOST_OF_STEM: f64 = 0.45;
const MOST_OF_CROWN: f64 = 0.18;

/// Standard deviation of the Gaussian that rounds the outline before its normal is taken, in cell sizes.
const ROUNDED: f64 = 1.3;

/// Nodes in a cell size at which the moves are reckoned: many to the shortest wave.
const FIELD_NODES: f64 = 12.0;

/// Share of its height that the tree draws in from the frame, if it touches that above: new leaves stand out of
/// their outline, and would be cut off straight.
const HEADROOM: f64 = 0.025;

/// `tree`, which has that habit and is to have those boughs, with its crown moved; without boughs the crown
/// only goes with its stem. `side` is the size of a cell, pixels; the strengths are that of the crown and that
/// of the stem.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn swayed(
    tree: &Tree,
    (habit, boughs): (&Habit, Option<&Boughs>),
    side: f64,
    [strength, of_stem]: [f64; 2],
    random: &mut Random,
    cancel: &Cancel,
) -> Result<Tree, Cancelled> {
    let (image, labels) = (&tree.image, &tree.labels);
    let moves = Moves {
        sway: [0; 2].map(|_| Waves::new(SWAY, random)),
        swell: Waves::new(SWELL, random),
        stem: Stem::new((tree, habit), boughs.is_none(), side, of_stem, random),
        boughs,
        rounded: Rounded::of(image, side, ROUNDED, cancel)?,
        habit,
        width: f64::from(image.width()),
        side,
        strength,
    };
    let field = Field::of(&moves, image.width(), image.height());
    let width = image.width() as usize;
    let mut swayed = tree.clone();
    let rows = swayed.image.pixels_mut().par_chunks_mut(width);
    rows.zip(swayed.labels.pixels_mut().par_chunks_mut(width))
        .enumerate()
        .for_each(|(y, (pixels, out))| {
            for (x, (pixel, label)) in pixels.iter_mut().zip(out).enumerate() {
                let [u, v] = field.source(x, y);
                *pixel = between_pixels(image, u, v);
                let near = |value: f64| (value + 0.5).floor() as i64;
                *label = labels.get(near(u), near(v)).unwrap_or_default();
            }
        });
    Ok(swayed)
}

/// All that moves a tree.
struct Moves<'a> {
    sway: [Waves; 2],
    swell: Waves,
    stem: Stem,
    boughs: Option<&'a Boughs>,
    rounded: Rounded,
    habit: &'a Habit,
    /// Of the picture, pixels.
    width: f64,
    side: f64,
    strength: f64,
}

impl Moves<'_> {
    /// The place that pixel (x, y) of the moved tree comes from.
    fn source(&self, x: f64, y: f64) -> [f64; 2] {
        let Self {
            side, stem, habit, ..
        } = self;
        let [leant, lifted] = stem.at(y);
        let free = ((stem.low - y) / (2.0 * side)).clamp(0.0, 1.0) * self.strength * side;
        let (mut dx, mut dy) = (leant, lifted);
        if let Some(boughs) = self.boughs.filter(|_| free > 0.0) {
            let place = [x / side, y / side];
            let inwards = self.rounded.inwards(x, y);
            let straight = habit.straight();
            let room = 1.0 - straight * (1.0 - (habit.half(y) / (SLENDER * side)).min(1.0));
            let on_outline = habit.on_outline([x, y]).map(|along| along / side);
            let swell = room * (1.0 - STRAIGHT_SWELL * straight) * self.swell.at(on_outline);
            let sway = room * (1.0 - STRAIGHT_SWAY * straight);
            // Boughs reach farther but grow no thicker.
            let swells = [swell, swell * (1.0 - straight)];
            let [across, down] =
                [0, 1].map(|axis| sway * self.sway[axis].at(place) + swells[axis] * inwards[axis]);
            let [outwards, level] = boughs.at(habit, x, y, *side);
            dx += free * (across + straight * outwards);
            dy += free * (down + straight * level);
        }
        // Towards the frame the tree may shrink but not grow.
        let near = |gap: f64| (gap / (1.2 * side)).clamp(0.0, 1.0);
        let toward = |move_in: f64, gap: f64| {
            if move_in > 0.0 {
                move_in * near(gap)
            } else {
                move_in
            }
        };
        let dx = if dx > 0.0 {
            toward(dx, x)
        } else {
            -toward(-dx, self.width - 1.0 - x)
        };
        // A spire may touch the frame with its tip.
        let headroom = (1.0 - habit.straight()) * stem.headroom(y);
        [x + dx, y + toward(dy, y) - headroom]
    }
}

/// Where the pixels of a moved tree come from, reckoned at nodes; bilinear between.
struct Field {
    /// From a node to its source.
    offsets: Vec<[f64; 2]>,
    columns: usize,
    /// Pixels between nodes.
    step: usize,
}

impl Field {
    fn of(moves: &Moves<'_>, width: u32, height: u32) -> Self {
        let step = ((moves.side / FIELD_NODES) as usize).max(1);
        let [columns, rows] = [width, height].map(|pixels| pixels as usize / step + 2);
        let node = |i: usize| {
            let [x, y] = [i % columns, i / columns].map(|at| (at * step) as f64);
            let [u, v] = moves.source(x, y);
            [u - x, v - y]
        };
        Self {
            offsets: (0..columns * rows).into_par_iter().map(node).collect(),
            columns,
            step,
        }
    }

    /// The place that pixel (x, y) comes from.
    fn source(&self, x: usize, y: usize) -> [f64; 2] {
        let [s, t] = [x, y].map(|at| (at % self.step) as f64 / self.step as f64);
        let first = y / self.step * self.columns + x / self.step;
        let [upper, lower] = [first, first + self.columns].map(|left| {
            let (a, b) = (self.offsets[left], self.offsets[left + 1]);
            [a[0] + s * (b[0] - a[0]), a[1] + s * (b[1] - a[1])]
        });
        [
            x as f64 + upper[0] + t * (lower[0] - upper[0]),
            y as f64 + upper[1] + t * (lower[1] - upper[1]),
        ]
    }
}

/// How the boughs of what stands straight lie.
pub(super) struct Boughs {
    reach: Waves,
    of_sides: [Waves; 2],
    tiers: Waves,
    broad: f64,
    spread: f64,
    droop: f64,
}

impl Boughs {
    pub(super) fn new(random: &mut Random) -> Self {
        Self {
            reach: Waves::new(REACH, random),
            of_sides: [0; 2].map(|_| Waves::new(REACH_OF_SIDE, random)),
            tiers: Waves::new(TIERS, random),
            broad: BROAD * random.between(-1.0, 1.0),
            spread: SPREAD * random.between(-1.0, 1.0),
            droop: DROOP * random.between(-1.0, 1.0),
        }
    }

    /// The same of a tree without leaves.
    pub(super) fn bare(self) -> Self {
        Self {
            broad: BARE_REACH * self.broad,
            spread: BARE_REACH * self.spread,
            droop: BARE * self.droop,
            ..self
        }
    }

    /// How far aside and below place (x, y) comes from, in cell sizes.
    fn at(&self, habit: &Habit, x: f64, y: f64, side: f64) -> [f64; 2] {
        let out = (x - habit.axis(y)) / side;
        let row = [0.0, y / side];
        // Both sides meet smoothly on the axis.
        let share = 0.5 + 0.5 * (out / 0.5).clamp(-1.0, 1.0);
        let [left, right] = [0, 1].map(|of| self.of_sides[of].at(row));
        let spread = self.spread * (2.0 * habit.share(y) - 1.0);
        let longer = self.broad + spread + self.reach.at(row) + left + share * (right - left);
        // The tip stays where it is.
        let below_tip = ((y - habit.top()) / (2.0 * side)).clamp(0.0, 1.0);
        let hangs = self.droop * ((out * out + 0.06).sqrt() - 0.245);
        [
            -out * longer / (1.0 + longer),
            below_tip * self.tiers.at(row) - hangs,
        ]
    }
}

/// How the stem stands.
struct Stem {
    top: f64,
    /// Where the crown begins.
    low: f64,
    foot: f64,
    lean: f64,
    bend: f64,
    lift: f64,
    /// How far the whole crown comes down, pixels.
    sinks: f64,
    winds: Waves,
    /// How much of that.
    wind: f64,
    bark: f64,
    side: f64,
    strength: f64,
}

impl Stem {
    fn new(
        (tree, habit): (&Tree, &Habit),
        is_palm: bool,
        side: f64,
        strength: f64,
        random: &mut Random,
    ) -> Self {
        let aside = side * (1.0 - STRAIGHT_LEAN * habit.straight());
        let bounds = opaque_bounds(&tree.image.map(|pixel| pixel.alpha() >= 96));
        let (top, foot) = bounds.map_or((0.0, 1.0), |bounds| {
            let top = f64::from(bounds.y);
            (top, top + f64::from(bounds.height))
        });
        let baseline = crown_baseline(&tree.labels);
        let low = baseline.map_or(f64::from(tree.image.height()), f64::from);
        let [lean, bend, lift, bark] = [0; 4].map(|_| random.between(-1.0, 1.0));
        let most = (MOST_OF_STEM * (foot - low)).min(MOST_OF_CROWN * (low - top));
        let winds = Waves::new(WINDS, random);
        let sinks = PALM_SHORTER * (foot - low).max(0.0) * strength * random.unit();
        Self {
            top,
            low,
            foot,
            lean: LEAN * aside * strength * lean,
            bend: BEND * aside * strength * bend,
            lift: (LIFT * side).min(most.max(0.0)) * strength * lift,
            sinks: if is_palm { sinks } else { 0.0 },
            winds,
            wind: if is_palm { PALM_WINDS } else { 1.0 },
            bark: BARK * (foot - low).max(0.0) * strength * bark,
            side,
            strength,
        }
    }

    /// How far the tree is drawn in at height `y`: by [`HEADROOM`] at its top, not at all at its foot.
    fn headroom(&self, y: f64) -> f64 {
        let height = (self.foot - self.top).max(1.0);
        let missing = (HEADROOM * height - self.top).max(0.0) * self.strength;
        missing * ((self.foot - y) / height).clamp(0.0, 1.0)
    }

    /// How far aside and below a row of the moved tree comes from.
    fn at(&self, y: f64) -> [f64; 2] {
        let height = ((self.foot - y) / (self.foot - self.top).max(1.0)).clamp(0.0, 1.0);
        let aside =
            self.lean * height * height + self.bend * libm::sin(std::f64::consts::PI * height);
        let low = self.low + self.sinks;
        if y < low {
            let share = (y - self.top) / (low - self.top).max(1.0);
            return [aside, self.lift * share.clamp(0.0, 1.0) - self.sinks];
        }
        let share = (self.foot - y) / (self.foot - low).max(1.0);
        let share = share.clamp(0.0, 1.0);
        // Foot and crown keep their places.
        let between = libm::sin(std::f64::consts::PI * share);
        // A short stem has no room to wind.
        let room = ((self.foot - self.low) / (3.0 * self.side)).min(1.0);
        let winds = self.winds.at([0.0, y / self.side]) * self.side * self.strength * room;
        let winds = self.wind * winds;
        [
            aside + winds * between,
            (self.lift - self.sinks) * share + self.bark * between * between,
        ]
    }
}

/// Noise of two wave lengths.
struct Waves {
    waves: [(Noise, [f64; 2]); 2],
}

impl Waves {
    fn new(waves: [[f64; 2]; 2], random: &mut Random) -> Self {
        Self {
            waves: waves.map(|wave| (Noise::new(random), wave)),
        }
    }

    /// From minus to plus the sum of their heights.
    fn at(&self, [x, y]: [f64; 2]) -> f64 {
        let wave = |(noise, [length, height]): &(Noise, [f64; 2])| {
            2.0 * height * (noise.at([x / length, y / length]) - 0.5)
        };
        self.waves.iter().map(wave).sum()
    }
}

/// The colour of `image` at a place between its pixels: bilinear, weighted by alpha.
pub(super) fn between_pixels(image: &Image<Straight>, x: f64, y: f64) -> Straight {
    between([x, y], |column, row| image.get(column, row))
}

/// The same of the pixels that `at` gives; others are clear.
pub(super) fn between([x, y]: [f64; 2], at: impl Fn(i64, i64) -> Option<Straight>) -> Straight {
    let (left, top) = (x.floor(), y.floor());
    let (s, t) = (x - left, y - top);
    let mut sums = [0.0f64; 4];
    let corners = [
        (0, 0, 1.0 - s, 1.0 - t),
        (1, 0, s, 1.0 - t),
        (0, 1, 1.0 - s, t),
        (1, 1, s, t),
    ];
    for (dx, dy, across, down) in corners {
        let Some(pixel) = at(left as i64 + dx, top as i64 + dy) else {
            continue;
        };
        let share = across * down * f64::from(pixel.alpha());
        for (sum, value) in sums.iter_mut().zip(pixel.0) {
            *sum += share * f64::from(value);
        }
        sums[3] += share - share * f64::from(pixel.alpha());
    }
    let alpha = sums[3];
    let color = |c: usize| (sums[c] / alpha.max(1e-9) + 0.5).clamp(0.0, 255.0) as u8;
    let alpha = (alpha + 0.5).clamp(0.0, 255.0) as u8;
    if alpha == 0 {
        return Straight([0; 4]);
    }
    Straight([color(0), color(1), color(2), alpha])
}
