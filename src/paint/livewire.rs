//! Livewire: a line that clings to edges while the pointer goes along them.
//!
//! Pixels are the nodes of a graph; a step to one of the eight neighbours is cheap where the picture
//! has a strong edge and where the step runs along it. The shortest path from the anchor to the
//! pointer is the line. Paths are found by Dijkstra's algorithm outwards from the anchor, only as far
//! as the pointer has been, and kept: moving on costs what is new, moving back nothing. Costs are small
//! integers in a ring of buckets, so paths are the same everywhere.
//!
//! This work is based on: E. Mortensen & W. Barrett, *Intelligent Scissors for Image Composition*,
//! SIGGRAPH 1995. Departures: the gradient is the largest of the three channels' and is measured
//! against the strongest of the neighbourhood instead of the picture, so that weak outlines against the
//! sky hold as well as strong ones; no Laplacian zero-crossings and no training.
//!
//! Limits: looks at a window around the anchor only (memory and time then do not depend on the size
//! of the picture). Beyond it the line goes straight: set an anchor, as the hand does anyway.

use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Straight};

/// Half the side of the window around the anchor, pixels.
const REACH: u32 = 384;

/// Most cost of a step to a side neighbour, besides [`STEP`].
const MOST_COST: u32 = 255;

/// Cost of a step of itself: a detour must be worth it.
const STEP: u32 = 6;

/// Share of the cost that the strength of the edge decides, of 256; its direction decides the rest.
const STRENGTH_SHARE: u32 = 190;

/// Largest cost of a diagonal step: √2 as 181/128, rounded up.
const MOST_STEP: usize = ((MOST_COST + STEP) * 181 / 128 + 1) as usize;

/// Nodes settled between two looks at the cancel flag: some milliseconds.
const BETWEEN_CHECKS: usize = 1 << 14;

/// Side of the squares whose strongest gradient is the measure for their pixels.
const NEIGHBOURHOOD: usize = 32;

/// The weakest gradient that may count as an edge: the noise of a photograph.
const NOISE: u16 = 40;

/// The eight steps, and whether they are diagonal.
const STEPS: [(i64, i64); 8] = [
    (1, 0),
    (-1, 0),
    (0, 1),
    (0, -1),
    (1, 1),
    (-1, 1),
    (1, -1),
    (-1, -1),
];

/// No step leads here: the anchor, or a node that was not reached.
const NO_STEP: u8 = u8::MAX;

/// The shortest paths from one anchor.
#[derive(Debug, Clone)]
pub struct Livewire {
    /// The window's first pixel.
    origin: (u32, u32),
    width: usize,
    height: usize,
    anchor: usize,
    /// Strength of the edge at each pixel, 0 (none) to 255.
    strength: Vec<u8>,
    /// Its direction, as the gradient's components.
    gradient: Vec<(i16, i16)>,
    distance: Vec<u32>,
    /// Which of [`STEPS`] leads to each node.
    step: Vec<u8>,
    is_settled: Vec<bool>,
    /// Nodes by their distance modulo the number of buckets.
    buckets: Vec<Vec<u32>>,
    /// The distance that is being settled.
    front: u32,
    waiting: usize,
}

impl Livewire {
    /// Begins at `anchor` in `photo`.
    ///
    /// # Panics
    /// When the anchor is outside.
    pub fn new(photo: &Image<Straight>, anchor: (u32, u32)) -> Self {
        let (x, y) = anchor;
        assert!(
            x < photo.width() && y < photo.height(),
            "the anchor is outside"
        );
        let origin = (x.saturating_sub(REACH), y.saturating_sub(REACH));
        let width = (x + REACH + 1).min(photo.width()) - origin.0;
        let height = (y + REACH + 1).min(photo.height()) - origin.1;
        let (width, height) = (width as usize, height as usize);
        let gradient = gradients(photo, origin, width, height);
        let anchor = (y - origin.1) as usize * width + (x - origin.0) as usize;
        let mut livewire = Self {
            origin,
            width,
            height,
            anchor,
            strength: strengths(&gradient, width, height),
            gradient,
            distance: vec![u32::MAX; width * height],
            step: vec![NO_STEP; width * height],
            is_settled: vec![false; width * height],
            buckets: vec![Vec::new(); MOST_STEP + 1],
            front: 0,
            waiting: 1,
        };
        livewire.distance[anchor] = 0;
        livewire.buckets[0].push(anchor as u32);
        livewire
    }

    /// The pixels from the anchor to `target`, both included, each a neighbour of the one before.
    ///
    /// A target outside of the window is reached by a straight line from the window's nearest pixel.
    ///
    /// # Errors
    /// [`Cancelled`]; what was found so far is kept.
    pub fn path_to(
        &mut self,
        target: (u32, u32),
        cancel: &Cancel,
    ) -> Result<Vec<(u32, u32)>, Cancelled> {
        let nearest = (
            target
                .0
                .clamp(self.origin.0, self.origin.0 + self.width as u32 - 1),
            target
                .1
                .clamp(self.origin.1, self.origin.1 + self.height as u32 - 1),
        );
        let column = (nearest.0 - self.origin.0) as usize;
        let node = (nearest.1 - self.origin.1) as usize * self.width + column;
        self.settle(node, cancel)?;
        let mut path = vec![nearest];
        let mut at = node;
        while at != self.anchor {
            let (dx, dy) = STEPS[usize::from(self.step[at])];
            at = (at as i64 - dy * self.width as i64 - dx) as usize;
            path.push(self.pixel(at));
        }
        path.reverse();
        path.extend(straight(nearest, target));
        Ok(path)
    }

    /// What the path to a pixel that was reached costs.
    #[cfg(test)]
    fn cost_to(&self, node: usize) -> u32 {
        self.distance[node]
    }

    fn pixel(&self, node: usize) -> (u32, u32) {
        let (x, y) = (node % self.width, node / self.width);
        (self.origin.0 + x as u32, self.origin.1 + y as u32)
    }

    /// Settles nodes in the order of their distance until `node` is.
    fn settle(&mut self, node: usize, cancel: &Cancel) -> Result<(), Cancelled> {
        let mut settled = 0;
        while !self.is_settled[node] && self.waiting > 0 {
            let bucket = self.front as usize % self.buckets.len();
            let Some(next) = self.buckets[bucket].pop() else {
                self.front += 1;
                continue;
            };
            self.waiting -= 1;
            let next = next as usize;
            if self.is_settled[next] {
                continue;
            }
            self.is_settled[next] = true;
            self.relax(next);
            settled += 1;
            if usize::is_multiple_of(settled, BETWEEN_CHECKS) {
                cancel.check()?;
            }
        }
        Ok(())
    }

    /// Shortens the ways to the neighbours of a node that is settled.
    fn relax(&mut self, node: usize) {
        let (x, y) = ((node % self.width) as i64, (node / self.width) as i64);
        for (index, (dx, dy)) in (0..).zip(STEPS) {
            let (to_x, to_y) = (x + dx, y + dy);
            let inside =
                (0..self.width as i64).contains(&to_x) && (0..self.height as i64).contains(&to_y);
            if !inside {
                continue;
            }
            let to = to_y as usize * self.width + to_x as usize;
            if self.is_settled[to] {
                continue;
            }
            let distance = self.distance[node] + self.cost(node, to, (dx, dy));
            if distance < self.distance[to] {
                self.distance[to] = distance;
                self.step[to] = index;
                let bucket = distance as usize % self.buckets.len();
                self.buckets[bucket].push(to as u32);
                self.waiting += 1;
            }
        }
    }

    /// The cost of one step, the same in both directions.
    fn cost(&self, from: usize, to: usize, (dx, dy): (i64, i64)) -> u32 {
        let strength = (u32::from(self.strength[from]) + u32::from(self.strength[to])) / 2;
        let weakness = MOST_COST - strength;
        let turn = (turned(self.gradient[from], dx, dy) + turned(self.gradient[to], dx, dy)) / 2;
        let side = (weakness * STRENGTH_SHARE + turn * (256 - STRENGTH_SHARE)) / 256 + STEP;
        if dx != 0 && dy != 0 {
            side * 181 / 128
        } else {
            side
        }
    }
}

/// How far a step turns away from the edge that stands across `gradient`: 0 along it, 255 across.
fn turned(gradient: (i16, i16), dx: i64, dy: i64) -> u32 {
    let (gx, gy) = (i64::from(gradient.0), i64::from(gradient.1));
    let across = (gx * dx + gy * dy).pow(2);
    let whole = (gx * gx + gy * gy) * (dx * dx + dy * dy);
    // The square of a cosine; where there is no gradient all ways are alike.
    if whole == 0 {
        128
    } else {
        (255 * across / whole) as u32
    }
}

/// Sobel's gradient of the channel where it is strongest, for each pixel of the window.
fn gradients(
    photo: &Image<Straight>,
    origin: (u32, u32),
    width: usize,
    height: usize,
) -> Vec<(i16, i16)> {
    let (right, bottom) = (i64::from(photo.width()) - 1, i64::from(photo.height()) - 1);
    let value = |x: i64, y: i64| {
        let pixel = photo.at(x.clamp(0, right) as u32, y.clamp(0, bottom) as u32);
        // What is clear is black, so that cut-out pictures have edges too.
        pixel.premultiplied().0
    };
    let one = |index: usize| {
        let x = i64::from(origin.0) + (index % width) as i64;
        let y = i64::from(origin.1) + (index / width) as i64;
        let around: [[[u8; 4]; 3]; 3] = std::array::from_fn(|j| {
            std::array::from_fn(|i| value(x + i as i64 - 1, y + j as i64 - 1))
        });
        let of_channel = |c: usize| {
            let v = |i: usize, j: usize| i16::from(around[j][i][c]);
            let gx = v(2, 0) + 2 * v(2, 1) + v(2, 2) - v(0, 0) - 2 * v(0, 1) - v(0, 2);
            let gy = v(0, 2) + 2 * v(1, 2) + v(2, 2) - v(0, 0) - 2 * v(1, 0) - v(2, 0);
            (gx, gy)
        };
        let channels = [of_channel(0), of_channel(1), of_channel(2), of_channel(3)];
        channels
            .into_iter()
            .max_by_key(|&gradient| length(gradient))
            .unwrap_or_default()
    };
    (0..width * height).map(one).collect()
}

/// The length of a gradient to within a few per cent, in whole numbers: the longer side and half of
/// the shorter one, 0 to 1530.
fn length((x, y): (i16, i16)) -> u16 {
    let (x, y) = (x.unsigned_abs(), y.unsigned_abs());
    x.max(y) + x.min(y) / 2
}

/// Gradients measured against the strongest ones in their part of the window, 0 to 255.
fn strengths(gradient: &[(i16, i16)], width: usize, height: usize) -> Vec<u8> {
    let across = width.div_ceil(NEIGHBOURHOOD);
    let down = height.div_ceil(NEIGHBOURHOOD);
    let mut strongest = vec![NOISE; across * down];
    for (index, &gradient) in gradient.iter().enumerate() {
        let square = index / width / NEIGHBOURHOOD * across + index % width / NEIGHBOURHOOD;
        strongest[square] = strongest[square].max(length(gradient));
    }
    let around = |square: usize| {
        let (x, y) = (square % across, square / across);
        let rows = y.saturating_sub(1)..(y + 2).min(down);
        let columns = x.saturating_sub(1)..(x + 2).min(across);
        let all = rows.flat_map(|row| columns.clone().map(move |column| row * across + column));
        all.map(|square| strongest[square]).max().unwrap_or(NOISE)
    };
    let measures: Vec<u16> = (0..strongest.len()).map(around).collect();
    let strength = |(index, &gradient): (usize, &(i16, i16))| {
        let square = index / width / NEIGHBOURHOOD * across + index % width / NEIGHBOURHOOD;
        (u32::from(length(gradient)) * 255 / u32::from(measures[square])).min(255) as u8
    };
    gradient.iter().enumerate().map(strength).collect()
}

/// The pixels after `from` on the straight line to `to`, each a neighbour of the one before.
fn straight(from: (u32, u32), to: (u32, u32)) -> impl Iterator<Item = (u32, u32)> {
    let (x, y) = (i64::from(from.0), i64::from(from.1));
    let (dx, dy) = (i64::from(to.0) - x, i64::from(to.1) - y);
    let count = dx.abs().max(dy.abs());
    (1..=count).map(move |i| {
        // Rounded to the nearest, halves up.
        let along = |d: i64| (2 * d * i + count).div_euclid(2 * count);
        ((x + along(dx)) as u32, (y + along(dy)) as u32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use proptest::prelude::*;

    fn grey(l: u8) -> Straight {
        Straight([l, l, l, 255])
    }

    fn noise(width: u32, height: u32, seed: u64) -> Image<Straight> {
        let mut random = Seed(seed).random();
        let pixels = (0..width * height)
            .map(|_| grey(random.below(256) as u8))
            .collect();
        Image::from_pixels(width, height, pixels)
    }

    #[test]
    fn the_line_follows_a_circle() {
        let inside = |x: i32, y: i32| (x - 100).pow(2) + (y - 100).pow(2) < 60 * 60;
        let pixels = (0..200 * 200).map(|i| grey(if inside(i % 200, i / 200) { 60 } else { 190 }));
        let photo = Image::from_pixels(200, 200, pixels.collect());
        let mut wire = Livewire::new(&photo, (100, 40));
        let path = wire.path_to((100, 160), &Cancel::new()).unwrap();
        let off = |&(x, y): &(u32, u32)| {
            let (dx, dy) = (f64::from(x) - 100.0, f64::from(y) - 100.0);
            ((dx * dx + dy * dy).sqrt() - 60.0).abs()
        };
        assert!(path.iter().map(off).fold(0.0, f64::max) < 2.5);
        assert!(
            path.len() > 120,
            "round the circle, not through it: {}",
            path.len()
        );
    }

    #[test]
    fn beyond_the_window_the_line_is_straight() {
        let photo = Image::filled(1000, 40, grey(9));
        let mut wire = Livewire::new(&photo, (10, 20));
        let path = wire.path_to((990, 3), &Cancel::new()).unwrap();
        assert_eq!((path[0], *path.last().unwrap()), ((10, 20), (990, 3)));
        let near = |pair: &[(u32, u32)]| {
            pair[0]
                .0
                .abs_diff(pair[1].0)
                .max(pair[0].1.abs_diff(pair[1].1))
                == 1
        };
        assert!(path.windows(2).all(near));
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(12))]

        /// Against Bellman and Ford, who relax every step until nothing gets shorter; and asking for
        /// other targets first does not change a path's cost.
        #[test]
        fn paths_are_the_shortest(seed in any::<u64>(), x in 0u32..18, y in 0u32..15, first in 0u32..18) {
            let photo = noise(18, 15, seed);
            let mut wire = Livewire::new(&photo, (x, y));
            wire.path_to((first, 7), &Cancel::new()).unwrap();
            let mut slow = vec![u32::MAX; 18 * 15];
            slow[(y * 18 + x) as usize] = 0;
            let mut is_shorter = true;
            while is_shorter {
                is_shorter = false;
                for from in 0..18 * 15usize {
                    for (dx, dy) in STEPS {
                        let (tx, ty) = ((from % 18) as i64 + dx, (from / 18) as i64 + dy);
                        if slow[from] == u32::MAX || !(0..18).contains(&tx) || !(0..15).contains(&ty) {
                            continue;
                        }
                        let to = (ty * 18 + tx) as usize;
                        let distance = slow[from] + wire.cost(from, to, (dx, dy));
                        if distance < slow[to] {
                            slow[to] = distance;
                            is_shorter = true;
                        }
                    }
                }
            }
            for (node, &cost) in slow.iter().enumerate() {
                let path = wire.path_to(wire.pixel(node), &Cancel::new()).unwrap();
                prop_assert_eq!(wire.cost_to(node), cost);
                prop_assert_eq!((path[0], *path.last().unwrap()), ((x, y), wire.pixel(node)));
            }
        }
    }
}
