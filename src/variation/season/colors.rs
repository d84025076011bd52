//! Leaves that turn: which first, and to which colours.
//!
//! Each leaf has an *earliness*, made of its height, its distance from the crown's middle, its clump (smooth
//! noise) and whether light reaches it; the earliest share of the crown has turned. What a leaf turns to
//! is a place on the season's path of palettes: green, yellow-green, gold, orange, russet. Along a
//! path colours are mixed; which end a tree reaches is drawn, and differs a little between clumps.

use super::Season;
use super::leaves::Leaves;
use crate::base::{Cancel, Cancelled, Random, Seed};
use crate::raster::Straight;
use crate::segment::Label;
use crate::variation::noise::Noise;
use crate::variation::{Histogram, Transfer, Tree};
use rayon::prelude::*;

/// Colours of leaves from shade to light: at the darkest, the middle and the lightest of them.
pub(super) type Ramp = [[f64; 3]; 3];

const SPRING: [Ramp; 1] = [[
    [30.0, 44.0, 12.0],
    [98.0, 126.0, 40.0],
    [190.0, 210.0, 108.0],
]];
const SUMMER: [Ramp; 1] = [[[18.0, 30.0, 10.0], [66.0, 92.0, 36.0], [158.0, 180.0, 92.0]]];
const AUTUMN: [Ramp; 4] = [
    [
        [38.0, 40.0, 10.0],
        [132.0, 128.0, 36.0],
        [214.0, 204.0, 92.0],
    ],
    [
        [58.0, 42.0, 8.0],
        [182.0, 140.0, 30.0],
        [244.0, 214.0, 92.0],
    ],
    [[56.0, 28.0, 8.0], [186.0, 98.0, 28.0], [240.0, 172.0, 78.0]],
    [
        [42.0, 16.0, 10.0],
        [146.0, 56.0, 28.0],
        [216.0, 122.0, 66.0],
    ],
];

/// How soft the border between turned and green leaves is, in shares of the crown.
const SOFTNESS: f64 = 0.55;

/// How much of a leaf's own difference from others of its light remains.
const OWN_COLOR: f64 = 0.45;

/// Clumps across the height of a crown.
const CLUMPS: f64 = 7.0;

/// Turns the leaves of `tree`.
pub(super) fn turn(
    tree: &mut Tree,
    leaves: &Leaves,
    season: Season,
    amount: f64,
    like: Option<&Histogram>,
    seed: Seed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    let mut random = seed.derive("season", 0).random();
    let path = Path::new(tree, leaves, season, like);
    let ends = match (season, like) {
        (Season::Autumn, None) => random.between(0.25, 0.95),
        _ => 1.0,
    };
    // In autumn each leaf turns in its time, otherwise all alike.
    let field = match season {
        Season::Autumn => Some(Field::new(tree, leaves, &mut random, cancel)?),
        _ => None,
    };
    let width = tree.image.width() as usize;
    let rows = tree.image.pixels_mut().par_chunks_mut(width).enumerate();
    rows.try_for_each(|(y, row)| {
        cancel.check()?;
        for (x, pixel) in row.iter_mut().enumerate() {
            let at = y * width + x;
            let share = f64::from(leaves.share.pixels()[at]);
            if share <= 0.0 || pixel.alpha() == 0 {
                continue;
            }
            let (turned, place) = match &field {
                Some(Field { ranks, tint }) => {
                    let own = ends + 0.3 * (tint[at] - 0.5) + 0.1 * (ranks[at] - 0.5);
                    (turned(ranks[at], amount), own.clamp(0.0, 1.0))
                }
                None => (amount, 1.0),
            };
            *pixel = path.color(*pixel, leaves.light.pixels()[at], turned * share, place);
        }
        Ok(())
    })
}

/// For each pixel how far it has turned, or fallen, when `amount` of the crown's leaves have.
///
/// # Errors
/// [`Cancelled`].
pub(super) fn turned_shares(
    tree: &Tree,
    leaves: &Leaves,
    amount: f64,
    seed: Seed,
    cancel: &Cancel,
) -> Result<Vec<f64>, Cancelled> {
    let random = &mut seed.derive("season", 1).random();
    let field = Field::new(tree, leaves, random, cancel)?;
    let shares = field.ranks.into_par_iter();
    Ok(shares.map(|rank| turned(rank, amount)).collect())
}

/// How far leaves of this rank, 1 for the earliest, have turned when `amount` of the crown has.
fn turned(rank: f64, amount: f64) -> f64 {
    let t = ((amount * (1.0 + SOFTNESS) - (1.0 - rank)) / SOFTNESS).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// The colours that leaves go through.
struct Path {
    /// The palettes of the path: for each light of the crown the colour of its rank.
    ramps: Vec<[[f64; 3]; 256]>,
    /// Mean colour of the crown's pixels of each light.
    mean: [[f64; 3]; 256],
    like: Option<Transfer>,
}

impl Path {
    fn new(tree: &Tree, leaves: &Leaves, season: Season, like: Option<&Histogram>) -> Self {
        let mut counts = [0.0f64; 256];
        let mut sums = [[0.0f64; 3]; 256];
        let pixels = tree.image.pixels().iter().zip(leaves.light.pixels());
        for ((pixel, light), share) in pixels.zip(leaves.share.pixels()) {
            if *share > 0.0 {
                let light = usize::from(*light);
                counts[light] += f64::from(*share);
                for (sum, value) in sums[light].iter_mut().zip(pixel.0) {
                    *sum += f64::from(*share) * f64::from(value);
                }
            }
        }
        let all: f64 = counts.iter().sum::<f64>().max(1e-9);
        let mut below = 0.0;
        let rank = counts.map(|count| {
            below += count;
            (below - 0.5 * count) / all
        });
        let mut mean = [[0.0; 3]; 256];
        for ((mean, sums), count) in mean.iter_mut().zip(sums).zip(counts) {
            *mean = sums.map(|sum| sum / count.max(1e-9));
        }
        let ramps: &[Ramp] = match season {
            Season::Spring => &SPRING,
            Season::Autumn => &AUTUMN,
            Season::Summer | Season::Winter => &SUMMER,
        };
        let of_lights = |ramp: &Ramp| rank.map(|rank| on_ramp(ramp, rank));
        Self {
            mean,
            ramps: ramps.iter().map(of_lights).collect(),
            like: like.map(|like| {
                let crown = Histogram::of_label(&tree.image, &tree.labels, Label::Crown);
                Transfer::between(&crown, like)
            }),
        }
    }

    /// The pixel's colour when it is `turned` by that share to `place` of the path.
    fn color(&self, pixel: Straight, light: u8, turned: f64, place: f64) -> Straight {
        let [r, g, b, alpha] = pixel.0;
        let own = [r, g, b].map(f64::from);
        let target = match &self.like {
            Some(transfer) => {
                let [r, g, b, _] = transfer.applied(pixel).0;
                [r, g, b].map(f64::from)
            }
            None => {
                let light = usize::from(light);
                let ramp = self.on_path(place * turned, light);
                let rest = |c: usize| OWN_COLOR * (own[c] - self.mean[light][c]);
                [0, 1, 2].map(|c| ramp[c] + rest(c))
            }
        };
        let mixed = |c: usize| (own[c] + (target[c] - own[c]) * turned + 0.5).clamp(0.0, 255.0);
        Straight([mixed(0) as u8, mixed(1) as u8, mixed(2) as u8, alpha])
    }

    /// The colour of leaves of this light at `place` of the path.
    fn on_path(&self, place: f64, light: usize) -> [f64; 3] {
        let last = self.ramps.len() - 1;
        let along = place * last as f64;
        let at = (along as usize).min(last.saturating_sub(1));
        let (from, to) = (self.ramps[at][light], self.ramps[(at + 1).min(last)][light]);
        let share = (along - at as f64).clamp(0.0, 1.0);
        [0, 1, 2].map(|c| from[c] + (to[c] - from[c]) * share)
    }
}

/// A smooth curve through the three colours of a ramp.
fn on_ramp(ramp: &Ramp, rank: f64) -> [f64; 3] {
    let weights = if rank < 0.5 {
        [1.0 - 2.0 * rank, 2.0 * rank, 0.0]
    } else {
        [0.0, 2.0 - 2.0 * rank, 2.0 * rank - 1.0]
    };
    [0, 1, 2].map(|c| weights[0] * ramp[0][c] + weights[1] * ramp[1][c] + weights[2] * ramp[2][c])
}

/// What decides when and how leaves turn, pixel by pixel.
struct Field {
    /// For each leaf the share of the crown that turns later.
    ranks: Vec<f64>,
    /// Where on the path a clump ends compared with others, 0 to 1.
    tint: Vec<f64>,
}

impl Field {
    fn new(
        tree: &Tree,
        leaves: &Leaves,
        random: &mut Random,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let bounds = leaves.bounds;
        let height = f64::from(bounds.height);
        let middle = f64::from(bounds.x) + 0.5 * f64::from(bounds.width);
        let [clumps, leafage, tints] = [0; 3].map(|_| Noise::new(random));
        let width = tree.image.width() as usize;
        let count = tree.image.pixels().len();
        // Larger for leaves that turn earlier; what is no leaf is out of the count.
        let (mut earliness, mut tint) = (vec![f64::NEG_INFINITY; count], vec![0.0; count]);
        let rows = earliness.par_chunks_mut(width);
        let rows = rows.zip(tint.par_chunks_mut(width)).enumerate();
        rows.try_for_each(|(row, (earliness, tint))| {
            cancel.check()?;
            let y = row as f64;
            let down = (y - f64::from(bounds.y)) / height;
            let high = y / height * CLUMPS;
            let mut clumps = clumps.row(high);
            let mut leafage = leafage.row(3.1 * high);
            let mut tints = tints.row(0.8 * high);
            let (shares, relief) = (leaves.share.row(row as u32), leaves.relief.row(row as u32));
            for x in (0..width).filter(|&x| shares[x] > 0.0) {
                let aside = 2.0 * (x as f64 - middle).abs() / f64::from(bounds.width);
                let along = x as f64 / height * CLUMPS;
                let clump = clumps.at(along) + 0.5 * leafage.at(3.1 * along);
                earliness[x] = 0.95 * (1.0 - down)
                    + 0.45 * aside * aside
                    + 1.1 * clump
                    + 0.12 * f64::from(relief[x]).clamp(-2.0, 2.0);
                tint[x] = tints.at(0.8 * along);
            }
            Ok(())
        })?;
        let ranks = ranks(&earliness);
        Ok(Self { ranks, tint })
    }
}

/// For each of `values` the share of those that are not larger; of the finite ones.
fn ranks(values: &[f64]) -> Vec<f64> {
    const BINS: usize = 4096;
    let (low, high) = (-1.5, 4.0);
    let bin = |value: f64| {
        (((value - low) / (high - low) * BINS as f64) as i64).clamp(0, BINS as i64 - 1) as usize
    };
    let mut counts = vec![0.0f64; BINS];
    for value in values.iter().filter(|value| value.is_finite()) {
        counts[bin(*value)] += 1.0;
    }
    let all: f64 = counts.iter().sum::<f64>().max(1.0);
    let mut below = 0.0;
    for count in &mut counts {
        below += *count;
        *count = below / all;
    }
    values.par_iter().map(|value| counts[bin(*value)]).collect()
}

/// The colour of a ramp where light has this rank.
pub(super) fn ramp_of(ramp: &Ramp, rank: f64) -> [u8; 3] {
    on_ramp(ramp, rank).map(|v| (v + 0.5).clamp(0.0, 255.0) as u8)
}
