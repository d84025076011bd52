//! Local features: the clumps, gaps and limbs by which one knows a tree again, although it was
//! stretched, recoloured or mirrored.
//!
//! Blobs of a difference-of-Gaussians pyramid, each described by the directions of its gradients in
//! 3 × 3 cells; after D. Lowe, *Distinctive Image Features from Scale-Invariant Keypoints* (2004).
//! Departures: upright, since trees are; a mirrored descriptor is a permutation of the plain one,
//! so mirrored pairs cost no second picture; instead of one similarity for the whole tree a match
//! needs neighbours that moved with it, since warped copies move differently at top and foot.

use super::correlation::dot;
use super::view::luma;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Premultiplied, scaled, smoothed};

/// Longer side of the tree in the picture that features are found in.
const TREE_PX: u32 = 128;

/// Clear pixels around the tree.
const MARGIN_PX: u32 = 8;

/// Standard deviations of the pyramid's Gaussians, a half octave apart, in pixels.
const SIGMAS: [f64; 5] = [1.2, 1.7, 2.4, 3.4, 4.8];

/// Least contrast of a blob, of 0 to 1: fainter ones nobody sees.
const LEAST_CONTRAST: f32 = 0.008;

/// Features of a tree at most, the strongest.
const MOST: usize = 160;

/// Cells along a side of a descriptor, directions in each.
const CELLS: usize = 3;
const DIRECTIONS: usize = 8;
const LENGTH: usize = CELLS * CELLS * DIRECTIONS;

/// Samples along a side of a cell, one standard deviation of the blob apart.
const SAMPLES: usize = 4;

/// Farthest that a feature may have moved, as a share of the tree's height.
const FARTHEST: f32 = 0.3;

/// Largest squared distance of two unit descriptors that may be the same thing.
const LARGEST_DISTANCE: f32 = 0.5;

/// A match must be this much nearer, squared, than the best one elsewhere.
const RATIO: f32 = 0.7;

/// How near, in pixels, are the neighbours that must have moved alike, and how many they must be.
const NEIGHBOURHOOD_PX: f32 = 26.0;
const NEIGHBOURS: usize = 4;

/// How unlike they may have moved: so many pixels, and this share of the distance between them.
const SLACK_PX: f32 = 2.0;
const SLACK_SHARE: f32 = 0.18;

/// How much lighter than the tree the sky behind it is taken to be: so that outline and gaps count as
/// much as clumps, whatever the tree's own light.
const SKY: f32 = 0.4;

/// Fewest features that a share is told of: of three, two are easily found by chance.
const FEWEST: usize = 40;

/// One feature.
#[derive(Debug, Clone)]
struct Feature {
    x: f32,
    y: f32,
    level: usize,
    contrast: f32,
    descriptor: [f32; LENGTH],
}

/// The features of a tree.
#[derive(Debug, Clone)]
pub(super) struct Features {
    own: Vec<Feature>,
    mirrored: Vec<Feature>,
}

impl Features {
    /// The features of the tree that fills `tree`.
    pub(super) fn of(tree: &Image<Premultiplied>, cancel: &Cancel) -> Result<Self, Cancelled> {
        let grey = grey(tree);
        let levels = SIGMAS
            .iter()
            .map(|&sigma| smoothed(&grey, sigma, cancel))
            .collect::<Result<Vec<_>, _>>()?;
        let mut own = blobs(&levels);
        // Of equals the upper: the order of the rows.
        own.sort_by(|a, b| b.contrast.total_cmp(&a.contrast));
        own.truncate(MOST);
        for feature in &mut own {
            feature.descriptor = descriptor(&levels[feature.level], feature);
        }
        let width = grey.width() as f32 - 1.0;
        let mirrored = own.iter().map(|feature| feature.mirrored(width)).collect();
        Ok(Self { own, mirrored })
    }
}

impl Feature {
    fn mirrored(&self, last_column: f32) -> Self {
        let mut descriptor = [0.0; LENGTH];
        for (index, &value) in self.descriptor.iter().enumerate() {
            let (cell, direction) = (index / DIRECTIONS, index % DIRECTIONS);
            let (row, column) = (cell / CELLS, cell % CELLS);
            // Direction k points at k · 45° from the right.
            let direction = (DIRECTIONS / 2 + DIRECTIONS - direction) % DIRECTIONS;
            let cell = row * CELLS + (CELLS - 1 - column);
            descriptor[cell * DIRECTIONS + direction] = value;
        }
        Self {
            x: last_column - self.x,
            descriptor,
            ..self.clone()
        }
    }
}

/// The tree in grey before a sky.
fn grey(tree: &Image<Premultiplied>) -> Image<f32> {
    let scale = f64::from(TREE_PX) / f64::from(tree.width().max(tree.height()));
    let small = scaled(tree, scale);
    let (mut sum, mut weight) = (0.0f32, 0.0f32);
    for pixel in small.pixels() {
        let alpha = f32::from(pixel.alpha());
        sum += alpha * luma(*pixel);
        weight += alpha;
    }
    let mean = sum / weight.max(1.0);
    let sky = mean + SKY;
    let side = TREE_PX + 2 * MARGIN_PX;
    let mut grey = Image::filled(side, side, sky);
    let (left, top) = (
        (side - small.width()) / 2,
        side - MARGIN_PX - small.height(),
    );
    for y in 0..small.height() {
        let row = &mut grey.row_mut(top + y)[left as usize..(left + small.width()) as usize];
        for (out, pixel) in row.iter_mut().zip(small.row(y)) {
            let alpha = f32::from(pixel.alpha()) / 255.0;
            *out = alpha * luma(*pixel) + (1.0 - alpha) * sky;
        }
    }
    grey
}

/// The extrema of the differences between neighbouring levels; descriptors are still to be filled.
fn blobs(levels: &[Image<f32>]) -> Vec<Feature> {
    let differences: Vec<Image<f32>> = levels
        .windows(2)
        .map(|pair| {
            let pixels = pair[1].pixels().iter().zip(pair[0].pixels());
            let (width, height) = (pair[0].width(), pair[0].height());
            Image::from_pixels(width, height, pixels.map(|(a, b)| a - b).collect())
        })
        .collect();
    let mut blobs = Vec::new();
    for level in 1..differences.len() - 1 {
        let around = &differences[level - 1..=level + 1];
        for y in 1..around[1].height() - 1 {
            for x in 1..around[1].width() - 1 {
                let value = around[1].at(x, y);
                if value.abs() >= LEAST_CONTRAST && is_extremum(around, x, y) {
                    blobs.push(Feature {
                        x: x as f32,
                        y: y as f32,
                        level,
                        contrast: value.abs(),
                        descriptor: [0.0; LENGTH],
                    });
                }
            }
        }
    }
    blobs
}

/// Whether the middle of three levels is extreme at (x, y) among its neighbours, and against the same
/// place of the other two.
fn is_extremum(around: &[Image<f32>], x: u32, y: u32) -> bool {
    let value = around[1].at(x, y);
    let sign = value.signum();
    let is_beyond = |other: f32| sign * other < sign * value;
    let beside = (y - 1..=y + 1)
        .all(|v| (x - 1..=x + 1).all(|u| (u, v) == (x, y) || is_beyond(around[1].at(u, v))));
    beside && is_beyond(around[0].at(x, y)) && is_beyond(around[2].at(x, y))
}

/// Directions of the gradients around `feature`, cell by cell; of length 1.
fn descriptor(level: &Image<f32>, feature: &Feature) -> [f32; LENGTH] {
    const SIDE: usize = CELLS * SAMPLES;
    let step = SIGMAS[feature.level] as f32;
    let at = |x: f32, y: f32| {
        let inside = |value: f32, last: u32| (value + 0.5).clamp(0.0, last as f32) as u32;
        level.at(inside(x, level.width() - 1), inside(y, level.height() - 1))
    };
    let mut cells = [0.0f32; LENGTH];
    for row in 0..SIDE {
        for column in 0..SIDE {
            let offset = |i: usize| (i as f32 + 0.5 - SIDE as f32 / 2.0) * step;
            let (x, y) = (feature.x + offset(column), feature.y + offset(row));
            let slope = [
                at(x + 1.0, y) - at(x - 1.0, y),
                at(x, y + 1.0) - at(x, y - 1.0),
            ];
            let along = directions(slope);
            for (cell, share) in shares_of_cells(row, column) {
                let cell = &mut cells[cell * DIRECTIONS..(cell + 1) * DIRECTIONS];
                for (sum, along) in cell.iter_mut().zip(along) {
                    *sum += share * along;
                }
            }
        }
    }
    // One strong edge shall not drown the rest.
    let unit = |cells: [f32; LENGTH]| {
        let length = dot(&cells, &cells).sqrt().max(1e-9);
        cells.map(|value| value / length)
    };
    unit(unit(cells).map(|value| value.min(0.25)))
}

/// How far a slope points in each of the eight directions, 0 where it points away.
fn directions([dx, dy]: [f32; 2]) -> [f32; DIRECTIONS] {
    const DIAGONAL: f32 = std::f32::consts::FRAC_1_SQRT_2;
    let (up, down) = (DIAGONAL * (dx + dy), DIAGONAL * (dx - dy));
    [dx, up, dy, -down, -dx, -up, -dy, down].map(|along| along.max(0.0))
}

/// The cells that a sample counts for, with its share: up to four, by its distance to their middles.
fn shares_of_cells(row: usize, column: usize) -> impl Iterator<Item = (usize, f32)> {
    let axis = |i: usize| {
        let place = (i as f32 + 0.5) / SAMPLES as f32 - 0.5;
        let low = place.floor();
        [(low, 1.0 - (place - low)), (low + 1.0, place - low)]
    };
    let columns = axis(column);
    axis(row).into_iter().flat_map(move |(v, share_v)| {
        columns.into_iter().filter_map(move |(u, share_u)| {
            let inside = |value: f32| (0.0..CELLS as f32).contains(&value);
            let cell = (v.max(0.0) as usize) * CELLS + u.max(0.0) as usize;
            (inside(u) && inside(v)).then_some((cell, share_u * share_v))
        })
    })
}

/// The share, 0 to 1, of features of `a` that are found again in `b`, and whether in a mirror.
pub(super) fn matched(a: &Features, b: &Features) -> (f64, bool) {
    let plain = share_matched(&a.own, &b.own);
    let mirrored = share_matched(&a.mirrored, &b.own);
    if mirrored > plain {
        (mirrored, true)
    } else {
        (plain, false)
    }
}

/// Where a feature was and where it is found again.
#[derive(Clone, Copy)]
struct Match {
    from: [f32; 2],
    to: [f32; 2],
}

fn share_matched(a: &[Feature], b: &[Feature]) -> f64 {
    let fewer = a.len().min(b.len()).max(FEWEST);
    let matches: Vec<Match> = a
        .iter()
        .filter_map(|feature| counterpart(feature, b))
        .collect();
    let kept = matches.iter().filter(|one| moved_in_company(one, &matches));
    (kept.count() as f64 / fewer as f64).min(1.0)
}

/// The feature of `among` that is what `feature` is, if it is clearly one.
fn counterpart(feature: &Feature, among: &[Feature]) -> Option<Match> {
    let farthest = FARTHEST * TREE_PX as f32;
    let mut best: Option<(f32, &Feature)> = None;
    let mut second = f32::INFINITY;
    for other in among {
        let (dx, dy) = ((other.x - feature.x).abs(), (other.y - feature.y).abs());
        if other.level.abs_diff(feature.level) > 1 || dx.max(dy) > farthest {
            continue;
        }
        let distance = 2.0 - 2.0 * dot(&feature.descriptor, &other.descriptor);
        match best {
            Some((least, known)) if distance >= least => {
                if !is_beside(known, other) {
                    second = second.min(distance);
                }
            }
            _ => {
                if let Some((least, known)) = best
                    && !is_beside(known, other)
                {
                    second = second.min(least);
                }
                best = Some((distance, other));
            }
        }
    }
    let (distance, other) = best?;
    let is_clear = distance <= LARGEST_DISTANCE && distance <= RATIO * second;
    is_clear.then_some(Match {
        from: [feature.x, feature.y],
        to: [other.x, other.y],
    })
}

/// Whether two features are about the same place, found twice.
fn is_beside(a: &Feature, b: &Feature) -> bool {
    (a.x - b.x).abs().max((a.y - b.y).abs()) < 5.0
}

/// Whether enough neighbours of `one` moved as it did.
fn moved_in_company(one: &Match, all: &[Match]) -> bool {
    let company = all.iter().filter(|other| {
        let apart = length(difference(other.from, one.from));
        let moved = difference(
            difference(other.to, other.from),
            difference(one.to, one.from),
        );
        apart > 1.0 && apart < NEIGHBOURHOOD_PX && length(moved) < SLACK_PX + SLACK_SHARE * apart
    });
    company.count() >= NEIGHBOURS
}

fn difference(a: [f32; 2], b: [f32; 2]) -> [f32; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn length([x, y]: [f32; 2]) -> f32 {
    (x * x + y * y).sqrt()
}
