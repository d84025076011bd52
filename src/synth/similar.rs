//! For each place of an exemplar a few other places that look alike: where a texture may jump.
//!
//! Windows of 7×7 pixels are described by sixteen numbers, the lowest coefficients of an orthonormal
//! cosine transform: ten of luma, three of each of two colour differences. Their squared distance
//! never exceeds that of the windows in the same colour space, and one comparison reads one cache
//! line. The most similar places are found by PatchMatch (Barnes, Shechtman, Finkelstein & Goldman
//! 2009): start anywhere, take over what neighbours found, look around what was found.
//!
//! Departure: all places move at once, from one array into the next, so that neither order nor
//! number of threads matters. The result is approximate, which suffices: it only proposes.
//!
//! The use of such sets for synthesis is k-coherence (Tong, Zhang, Liu, Wang, Guo & Shum 2002).

use super::level::{Color, Level, RADIUS};
use crate::base::{Cancel, Cancelled, Seed};
use rayon::prelude::*;

/// Places found for each place.
pub(super) const SIMILAR: usize = 2;

/// No place.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Numbers that describe a window.
const FEATURES: usize = 16;

/// Coefficients of luma (u + v ≤ 3) and of each colour difference (u + v ≤ 1), as (u, v).
const LUMA: [(usize, usize); 10] = [
    (0, 0),
    (0, 1),
    (1, 0),
    (0, 2),
    (1, 1),
    (2, 0),
    (0, 3),
    (1, 2),
    (2, 1),
    (3, 0),
];
const HUE: [(usize, usize); 3] = [(0, 0), (0, 1), (1, 0)];

/// From how far away each round takes over what neighbours found, steps: what is found spreads by
/// their sum. None is longer than the border of a level. More rounds change few places.
const ROUNDS: [i32; 4] = [3, 3, 2, 1];

/// Places closer than this many steps are the same place seen twice.
const APART: i64 = 4;

/// Side of the windows.
const SIDE: usize = 2 * RADIUS + 1;

type Features = [f32; FEATURES];

/// A place and how far its window is from the one it was found for.
#[derive(Debug, Clone, Copy)]
struct Match {
    index: u32,
    distance: f32,
}

const NO_MATCH: Match = Match {
    index: NOWHERE,
    distance: f32::INFINITY,
};

type Matches = [Match; SIMILAR];

/// What was found for the pixels of a level.
#[derive(Debug, Clone)]
pub(super) struct Similar {
    /// For each pixel the usable pixels most like it, from the best; [`NOWHERE`] for what is not
    /// usable and where too few were found.
    pub(super) places: Vec<[u32; SIMILAR]>,
    /// The squared distance of the best; infinite where there is none.
    pub(super) distances: Vec<f32>,
}

/// For each pixel of `level` the usable pixels most like it.
pub(super) fn similar(level: &Level, seed: Seed, cancel: &Cancel) -> Result<Similar, Cancelled> {
    let search = Search::new(level, seed, cancel)?;
    let mut found = vec![[NO_MATCH; SIMILAR]; level.usable.len()];
    for round in 0..=ROUNDS.len() {
        let next: Result<Vec<Vec<Matches>>, Cancelled> = (0..level.usable.len() / level.stride)
            .into_par_iter()
            .map(|line| {
                cancel.check()?;
                let line = line * level.stride..(line + 1) * level.stride;
                Ok(line
                    .map(|index| search.improved(&found, index, round))
                    .collect())
            })
            .collect();
        found = next?.concat();
    }
    Ok(Similar {
        places: found
            .iter()
            .map(|found| found.map(|one| one.index))
            .collect(),
        distances: found.iter().map(|found| found[0].distance).collect(),
    })
}

struct Search<'a> {
    level: &'a Level,
    features: Vec<Features>,
    /// Usable pixels.
    places: Vec<u32>,
    seed: Seed,
}

impl<'a> Search<'a> {
    fn new(level: &'a Level, seed: Seed, cancel: &Cancel) -> Result<Self, Cancelled> {
        let basis = basis();
        let lines = level.usable.par_chunks(level.stride).enumerate();
        let features: Result<Vec<Vec<Features>>, Cancelled> = lines
            .map(|(line, usable)| {
                cancel.check()?;
                let columns = usable.iter().enumerate();
                Ok(columns
                    .map(|(column, &usable)| match usable {
                        true => features(level, line * level.stride + column, &basis),
                        false => [0.0; FEATURES],
                    })
                    .collect())
            })
            .collect();
        let places = (0u32..).zip(&level.usable).filter(|(_, usable)| **usable);
        Ok(Self {
            level,
            features: features?.concat(),
            places: places.map(|(index, _)| index).collect(),
            seed,
        })
    }

    /// What is known of pixel `index` after one more round.
    fn improved(&self, found: &[Matches], index: usize, round: usize) -> Matches {
        if !self.level.usable[index] {
            return [NO_MATCH; SIMILAR];
        }
        let mut random = Seed(self.seed.0 ^ (index as u64) << 8 ^ round as u64).random();
        let mut best = found[index];
        if round == 0 {
            for _ in 0..2 * SIMILAR {
                self.consider(
                    &mut best,
                    index,
                    self.places[random.below(self.places.len())],
                );
            }
            return best;
        }
        let far = ROUNDS[round - 1];
        for (dx, dy) in [(far, 0), (-far, 0), (0, far), (0, -far)] {
            let Some(neighbour) = self.level.moved(index as u32, dx, dy) else {
                continue;
            };
            for there in found[neighbour as usize] {
                let back = (there.index != NOWHERE)
                    .then(|| self.level.moved(there.index, -dx, -dy))
                    .flatten();
                if let Some(candidate) = back {
                    self.consider(&mut best, index, candidate);
                }
            }
        }
        let (width, height) = self.level.size();
        let mut reach = width.max(height) as i64 / 2;
        while reach > 2 {
            let (x, y) = self.level.place(best[0].index as usize);
            let around = |random: &mut crate::base::Random, at: i64, size: usize| {
                let to = at - reach + random.below(2 * reach as usize + 1) as i64;
                to.clamp(0, size as i64 - 1) as usize
            };
            let candidate = self.level.index(
                around(&mut random, x, width),
                around(&mut random, y, height),
            );
            if self.level.usable[candidate] {
                self.consider(&mut best, index, candidate as u32);
            }
            reach /= 3;
        }
        best
    }

    /// Takes `candidate` into the `best` of pixel `index` if it belongs there.
    #[inline]
    fn consider(&self, best: &mut Matches, index: usize, candidate: u32) {
        let own = &self.features[index];
        let other = &self.features[candidate as usize];
        let mut sums = [0.0f32; 4];
        for (own, other) in own.chunks_exact(4).zip(other.chunks_exact(4)) {
            for i in 0..4 {
                sums[i] += (own[i] - other[i]) * (own[i] - other[i]);
            }
        }
        let distance = (sums[0] + sums[1]) + (sums[2] + sums[3]);
        if distance >= best[SIMILAR - 1].distance || self.are_near(index, candidate) {
            return;
        }
        // One that is near another found place replaces it or gives way to it.
        let near = best
            .iter()
            .position(|one| one.index != NOWHERE && self.are_near(one.index as usize, candidate));
        let last = near.unwrap_or(SIMILAR - 1);
        if distance >= best[last].distance {
            return;
        }
        best[last] = Match {
            index: candidate,
            distance,
        };
        for i in (1..=last).rev() {
            if best[i].distance < best[i - 1].distance {
                best.swap(i, i - 1);
            }
        }
    }

    fn are_near(&self, index: usize, other: u32) -> bool {
        let (x, y) = self.level.place(index);
        let (u, v) = self.level.place(other as usize);
        let apart = APART * self.level.step as i64;
        (x - u).abs() < apart && (y - v).abs() < apart
    }
}

/// The first four cosines over a window, orthonormal.
fn basis() -> [[f32; SIDE]; 4] {
    let cosine = |u: usize, i: usize| {
        let angle = std::f64::consts::PI * (i as f64 + 0.5) * u as f64 / SIDE as f64;
        let scale = if u == 0 { 1.0 } else { 2.0 };
        ((scale / SIDE as f64).sqrt() * libm::cos(angle)) as f32
    };
    std::array::from_fn(|u| std::array::from_fn(|i| cosine(u, i)))
}

/// The description of the window around pixel `index`.
fn features(level: &Level, index: usize, basis: &[[f32; SIDE]; 4]) -> Features {
    // Along rows first: sums[u][channel] for each row.
    let mut rows = [[[0.0f32; 3]; 4]; SIDE];
    for (dy, row) in rows.iter_mut().enumerate() {
        let start = index + dy * level.stride - RADIUS * level.stride - RADIUS;
        for (i, &color) in level.colors[start..start + SIDE].iter().enumerate() {
            let channels = opponent(color);
            for (u, sums) in row.iter_mut().enumerate() {
                for (sum, channel) in sums.iter_mut().zip(channels) {
                    *sum += channel * basis[u][i];
                }
            }
        }
    }
    let coefficient = |u: usize, v: usize, channel: usize| -> f32 {
        rows.iter()
            .zip(&basis[v])
            .map(|(row, weight)| row[u][channel] * weight)
            .sum()
    };
    let mut features = [0.0; FEATURES];
    let names = LUMA.iter().map(|&at| (at, 0));
    let hues = [1, 2]
        .into_iter()
        .flat_map(|channel| HUE.iter().map(move |&at| (at, channel)));
    for (feature, ((u, v), channel)) in features.iter_mut().zip(names.chain(hues)) {
        *feature = coefficient(u, v, channel);
    }
    features
}

/// Luma and two colour differences.
#[inline]
fn opponent([r, g, b, _]: Color) -> [f32; 3] {
    let [r, g, b] = [r, g, b].map(f32::from);
    [
        (r + 2.0 * g + b) * 0.25,
        (r - b) * 0.5,
        (2.0 * g - r - b) * 0.25,
    ]
}

#[cfg(test)]
mod tests {
    use super::super::level::blurred;
    use super::*;

    /// A picture whose right half repeats its left half.
    fn twice() -> Level {
        let mut random = Seed(4).random();
        let half: Vec<[f32; 3]> = (0..32 * 40)
            .map(|_| [0; 3].map(|_| random.below(256) as f32))
            .collect();
        let half = blurred(&half, 32, 1);
        let pixels: Vec<[f32; 3]> = (0..64 * 40).map(|i| half[i / 64 * 32 + i % 32]).collect();
        Level::new(&pixels, &[true; 64 * 40], (64, 40), 1)
    }

    #[test]
    fn the_copy_of_a_place_is_found() {
        let level = twice();
        let found = similar(&level, Seed(1), &Cancel::new()).unwrap().places;
        let mut right = 0;
        for y in 4..36 {
            for x in 4..28 {
                let copy = level.index(x + 32, y) as u32;
                right += usize::from(found[level.index(x, y)][0] == copy);
            }
        }
        // By chance it would be one.
        assert!(right > 32 * 24 / 3, "{right}");
    }

    #[test]
    fn descriptions_never_exceed_the_distance_of_windows() {
        let level = twice();
        let basis = basis();
        let mut random = Seed(9).random();
        for _ in 0..50 {
            let mut place = || level.index(4 + random.below(56), 4 + random.below(32));
            let (a, b) = (place(), place());
            let described: f32 = features(&level, a, &basis)
                .iter()
                .zip(features(&level, b, &basis))
                .map(|(p, q)| (p - q) * (p - q))
                .sum();
            let mut exact = 0.0;
            for offset in (0..SIDE * SIDE).map(|i| i / SIDE * level.stride + i % SIDE) {
                let corner = RADIUS * level.stride + RADIUS;
                let p = opponent(level.colors[a + offset - corner]);
                let q = opponent(level.colors[b + offset - corner]);
                exact += p.iter().zip(q).map(|(p, q)| (p - q) * (p - q)).sum::<f32>();
            }
            assert!(described <= exact * 1.001, "{described} {exact}");
        }
    }
}
