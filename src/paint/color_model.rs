//! What colours a region has, and where: a mixture of Gaussians in RGB whose weights vary over the
//! photograph.
//!
//! That the grass below is green says nothing against a green twig before the sky: the part of the
//! mixture that stands for grass counts little where no grass is near. The weights are kept for a grid
//! of cells, each from all samples, those near it counting most.
//!
//! Samples are parted by k-means from centres that lie far from one another, then each part becomes a
//! Gaussian. No randomness, sums in the order of the samples.

/// Gaussians of a model; the number of Rother, Kolmogorov & Blake (2004).
const PARTS: usize = 5;

/// Rounds of k-means; it rarely moves after as many.
const ROUNDS: usize = 8;

/// Most samples that are looked at, taken evenly.
const MOST_SAMPLES: usize = 20_000;

/// Added to all variances (in squared 8-bit steps): no region is purer than a photograph's noise.
const NOISE_VARIANCE: f64 = 12.0;

/// Cells of the grid of weights, across and down.
const CELLS: usize = 10;

/// Reach of a sample in cells: the standard deviation of its weight.
const REACH_CELLS: f64 = 1.3;

/// Share of the weights that is the same everywhere.
const EVERYWHERE: f64 = 0.03;

type Color = [f64; 3];

/// A place as shares of the photograph's width and height.
pub(super) type Place = [f32; 2];

/// How likely colours are in a region.
#[derive(Debug, Clone)]
pub(super) struct ColorModel {
    parts: Vec<Gaussian>,
}

#[derive(Debug, Clone)]
struct Gaussian {
    mean: Color,
    /// The inverse covariance: xx, yy, zz, xy, xz, yz.
    inverse: [f64; 6],
    /// Logarithm of the normalisation.
    log_scale: f64,
    /// Logarithm of the weight in each cell.
    log_weights: Vec<f64>,
}

impl ColorModel {
    /// The model of `samples`, `None` when there are none.
    pub(super) fn fit(samples: &[([u8; 3], Place)]) -> Option<Self> {
        let stride = samples.len().div_ceil(MOST_SAMPLES).max(1);
        let chosen = || samples.iter().step_by(stride);
        let cells: Vec<usize> = chosen().map(|&(_, place)| cell_of(place)).collect();
        let samples: Vec<Color> = chosen().map(|(color, _)| color.map(f64::from)).collect();
        let mut centers = spread_centers(&samples)?;
        let mut nearest = vec![0; samples.len()];
        for _ in 0..ROUNDS {
            for (own, sample) in nearest.iter_mut().zip(&samples) {
                *own = nearest_of(&centers, sample);
            }
            for (index, center) in centers.iter_mut().enumerate() {
                let own = members(&samples, &nearest, index);
                *center = mean(own).map_or(*center, |(mean, _)| mean);
            }
        }
        let mut parts = Vec::new();
        for index in 0..centers.len() {
            let Some((mean, _)) = mean(members(&samples, &nearest, index)) else {
                continue;
            };
            let mut part = Gaussian::new(mean, members(&samples, &nearest, index));
            let own = cells.iter().zip(&nearest).filter(|(_, own)| **own == index);
            part.log_weights = spread_counts(own.map(|(cell, _)| *cell));
            parts.push(part);
        }
        let mut model = Self { parts };
        model.normalize_weights();
        Some(model)
    }

    /// Minus the logarithm of the density of a colour at a place.
    pub(super) fn cost(&self, color: [u8; 3], place: Place) -> f64 {
        let (color, cell) = (color.map(f64::from), cell_of(place));
        // The parts' maximum within a factor of five of their sum: enough, and one logarithm less.
        let best = self
            .parts
            .iter()
            .map(|part| part.log_weights[cell] + part.log_density(&color));
        -best.fold(f64::NEG_INFINITY, f64::max)
    }

    /// Makes the logarithms of weights of sum 1 in each cell from the counts that stand there.
    fn normalize_weights(&mut self) {
        let totals: Vec<f64> = self
            .parts
            .iter()
            .map(|part| part.log_weights.iter().sum())
            .collect();
        let all: f64 = totals.iter().sum();
        for cell in 0..CELLS * CELLS {
            let here: f64 = self.parts.iter().map(|part| part.log_weights[cell]).sum();
            for (part, total) in self.parts.iter_mut().zip(&totals) {
                let count = part.log_weights[cell];
                let near = if here > 0.0 {
                    count / here
                } else {
                    total / all
                };
                let weight = (1.0 - EVERYWHERE) * near + EVERYWHERE * total / all;
                part.log_weights[cell] = libm::log(weight);
            }
        }
    }
}

/// The cell that a place lies in.
fn cell_of([x, y]: Place) -> usize {
    let index = |share: f32| ((share * CELLS as f32) as usize).min(CELLS - 1);
    index(y) * CELLS + index(x)
}

/// For each cell the number of samples, those in other cells counting less with the distance.
fn spread_counts(cells: impl Iterator<Item = usize>) -> Vec<f64> {
    let mut counts = vec![0.0; CELLS * CELLS];
    for cell in cells {
        counts[cell] += 1.0;
    }
    let share = |from: usize, to: usize| {
        let (dx, dy) = (
            (from % CELLS).abs_diff(to % CELLS),
            (from / CELLS).abs_diff(to / CELLS),
        );
        libm::exp(-((dx * dx + dy * dy) as f64) / (2.0 * REACH_CELLS * REACH_CELLS))
    };
    let sum = |to: usize| -> f64 {
        (0..counts.len())
            .map(|from| counts[from] * share(from, to))
            .sum()
    };
    (0..counts.len()).map(sum).collect()
}

impl Gaussian {
    fn new<'a>(mean: Color, members: impl Iterator<Item = &'a Color>) -> Self {
        let mut sums = [0.0; 6];
        let mut count = 0.0;
        for member in members {
            let [x, y, z]: Color = std::array::from_fn(|i| member[i] - mean[i]);
            for (sum, value) in sums
                .iter_mut()
                .zip([x * x, y * y, z * z, x * y, x * z, y * z])
            {
                *sum += value;
            }
            count += 1.0;
        }
        let mut c = sums.map(|sum| sum / f64::max(count, 1.0));
        for variance in &mut c[..3] {
            *variance += NOISE_VARIANCE;
        }
        let [xx, yy, zz, xy, xz, yz] = c;
        let adjugate = [
            yy * zz - yz * yz,
            xx * zz - xz * xz,
            xx * yy - xy * xy,
            xz * yz - xy * zz,
            xy * yz - xz * yy,
            xy * xz - xx * yz,
        ];
        // At least the cube of the noise: a covariance has no negative eigenvalue.
        let determinant = xx * adjugate[0] + xy * adjugate[3] + xz * adjugate[4];
        Self {
            mean,
            inverse: adjugate.map(|value| value / determinant),
            log_scale: -0.5 * libm::log(determinant),
            log_weights: Vec::new(),
        }
    }

    fn log_density(&self, color: &Color) -> f64 {
        let [x, y, z]: Color = std::array::from_fn(|i| color[i] - self.mean[i]);
        let [xx, yy, zz, xy, xz, yz] = self.inverse;
        let squared = xx * x * x + yy * y * y + zz * z * z;
        let mixed = xy * x * y + xz * x * z + yz * y * z;
        self.log_scale - 0.5 * (squared + 2.0 * mixed)
    }
}

/// Up to [`PARTS`] samples: the one nearest the mean, then always the one farthest from all before.
fn spread_centers(samples: &[Color]) -> Option<Vec<Color>> {
    let (middle, _) = mean(samples.iter())?;
    let by = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
    let to_middle = samples
        .iter()
        .map(|sample| squared(sample, &middle))
        .enumerate();
    let mut centers = vec![samples[to_middle.min_by(by)?.0]];
    while centers.len() < PARTS {
        let away = samples.iter().map(|sample| {
            let all = centers.iter().map(|center| squared(sample, center));
            all.fold(f64::INFINITY, f64::min)
        });
        let (farthest, distance) = away.enumerate().max_by(by)?;
        if distance == 0.0 {
            break;
        }
        centers.push(samples[farthest]);
    }
    Some(centers)
}

fn nearest_of(centers: &[Color], color: &Color) -> usize {
    let distances = centers
        .iter()
        .map(|center| squared(center, color))
        .enumerate();
    distances
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(0, |(index, _)| index)
}

fn members<'a>(
    samples: &'a [Color],
    nearest: &'a [usize],
    index: usize,
) -> impl Iterator<Item = &'a Color> {
    let pairs = samples.iter().zip(nearest);
    pairs
        .filter(move |(_, own)| **own == index)
        .map(|(sample, _)| sample)
}

/// The mean and the number of some colours, `None` without any.
fn mean<'a>(colors: impl Iterator<Item = &'a Color>) -> Option<(Color, f64)> {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for color in colors {
        for (sum, value) in sum.iter_mut().zip(color) {
            *sum += value;
        }
        count += 1.0;
    }
    (count > 0.0).then(|| (sum.map(|sum| sum / count), count))
}

fn squared(a: &Color, b: &Color) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    #[test]
    fn colours_of_the_samples_are_likelier_than_others() {
        let mut random = Seed(5).random();
        let mut near = |c: [u8; 3]| c.map(|v| v.saturating_add(random.below(9) as u8));
        let samples: Vec<_> = (0..900)
            .map(|i| {
                (
                    near([[30, 90, 20], [200, 180, 40], [90, 60, 30]][i % 3]),
                    [0.5, 0.5],
                )
            })
            .collect();
        let model = ColorModel::fit(&samples).unwrap();
        let costs =
            [[34, 94, 24], [204, 184, 44], [120, 160, 240]].map(|c| model.cost(c, [0.5, 0.5]));
        assert!(
            costs[0] < costs[2] - 20.0 && costs[1] < costs[2] - 20.0,
            "{costs:?}"
        );
    }

    #[test]
    fn the_density_is_that_of_a_gaussian() {
        let samples = [[10, 20, 30], [14, 20, 30], [10, 26, 30], [14, 26, 32]];
        let (center, _) = mean(samples.map(|c: [u8; 3]| c.map(f64::from)).iter()).unwrap();
        let colors = samples.map(|c| c.map(f64::from));
        let part = Gaussian::new(center, colors.iter());
        // By the definition, with the covariance written out.
        let cov = |i: usize, j: usize| {
            let sum: f64 = colors
                .iter()
                .map(|c| (c[i] - center[i]) * (c[j] - center[j]))
                .sum();
            sum / 4.0 + if i == j { NOISE_VARIANCE } else { 0.0 }
        };
        let [xx, yy, zz, xy, xz, yz] = part.inverse;
        let rows = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        for (i, row) in rows.iter().enumerate() {
            for j in 0..3 {
                let product: f64 = (0..3).map(|k| row[k] * cov(k, j)).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn few_or_equal_samples_do() {
        assert!(ColorModel::fit(&[]).is_none());
        let model = ColorModel::fit(&[([7, 7, 7], [0.0, 1.0]); 40]).unwrap();
        assert!(model.cost([7, 7, 7], [1.0, 0.0]).is_finite());
    }

    #[test]
    fn grass_below_says_little_of_green_above() {
        let (sky, grass) = ([150, 170, 220], [60, 110, 40]);
        let samples: Vec<_> = (0..200)
            .map(|i| {
                if i % 2 == 0 {
                    (sky, [0.5, 0.1])
                } else {
                    (grass, [0.5, 0.9])
                }
            })
            .collect();
        let model = ColorModel::fit(&samples).unwrap();
        assert!(model.cost(grass, [0.5, 0.1]) > model.cost(grass, [0.5, 0.9]) + 3.0);
    }
}
