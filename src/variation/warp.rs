//! The map from pixels of a new tree back to pixels of an exemplar.
//!
//! *Plain map.* f = Σ λᵢ(p′)·vᵢ: mean value coordinates of the target pixel with respect to the
//! target cage, applied to the source cage (Argudo, Andújar & Chica 2017, *Tree Variations*, §5.2).
//! Between cages that differ much it folds: a tree then shows mirrored fans at the concavities.
//!
//! *Composite map.* Going from cage to cage in several small steps, each a plain map between
//! neighbouring blends of the two cages, keeps every step nearly an identity and so free of folds:
//! T. Schneider, K. Hormann and M. S. Floater, *Bijective composite mean value mappings*, Computer
//! Graphics Forum 32 (2013). With one step it is the plain map.
//!
//! *Interpolation.* The map is smooth except at cage vertices, so a [`TILE`]×[`TILE`] block of
//! pixels is cut into squares until bilinear interpolation of the exact corners meets the exact
//! midpoints within [`TOLERANCE_PX`]; squares without needed pixels cost nothing. On the real library
//! some 2–6 % of the pixels are mapped exactly. [`WarpPrecision::Exact`] maps all.

use super::mean_value::{Cage, CageError, LANES, LaneMap, Lanes, mapped_exactly};
use crate::base::{Kernel, with_level_of_cpu};
use crate::geometry::Point;
use crate::raster::Mask;

/// Side of the block of pixels that is mapped together, a power of two. Larger blocks save corners
/// where the map is smooth, but a band of them is also the unit of parallel work.
pub(super) const TILE: usize = 32;

/// Points of a tile in a row: both borders belong.
const POINTS: usize = TILE + 1;

/// Largest distance between interpolated and exact position at the midpoints of a square. The
/// promise is 0.25 px; near cage vertices the error between midpoints was seen to reach 1.7 times
/// that at them, hence not more.
const TOLERANCE_PX: f32 = 0.12;

/// Whether positions may be interpolated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WarpPrecision {
    /// Within 0.25 pixel of the exact position.
    #[default]
    Interpolated,
    /// The coordinates are evaluated in double precision at every pixel.
    Exact,
}

/// A map from target points to source points.
#[derive(Debug, Clone)]
pub struct Warp {
    steps: Vec<(Cage, Cage)>,
    lanes: Vec<LaneMap>,
}

impl Warp {
    /// The map that takes the vertices of `target` to those of `source` in `steps` equal steps
    /// (1: plain mean value coordinates; 0 counts as 1).
    ///
    /// # Errors
    /// [`CageError`] when the cages do not correspond.
    pub fn new(target: &Cage, source: &Cage, steps: usize) -> Result<Self, CageError> {
        target.check_corresponds(source)?;
        let steps = steps.max(1);
        let blend = |i: usize| {
            let t = i as f64 / steps as f64;
            let pairs = target.points().iter().zip(source.points());
            target.moved(pairs.map(|(a, b)| a.lerp(*b, t)).collect())
        };
        let steps: Vec<(Cage, Cage)> = (0..steps)
            .map(|i| Ok((blend(i)?, blend(i + 1)?)))
            .collect::<Result<_, CageError>>()?;
        let lanes = steps
            .iter()
            .map(|(a, b)| LaneMap::new(a.clone(), b.clone()))
            .collect();
        Ok(Self { steps, lanes })
    }

    /// The source point of one target point, in double precision.
    pub fn position(&self, point: Point) -> Point {
        self.steps
            .iter()
            .fold(point, |p, (from, to)| mapped_exactly(from, to, p))
    }

    /// Number of plain maps one after the other.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Maps points (x, y) in place, in single precision.
    pub(super) fn map(&self, points: &mut [(Lanes, Lanes)]) {
        with_level_of_cpu(MapPoints {
            steps: &self.lanes,
            points,
        });
    }

    /// The source positions of the needed pixels of the tile whose top-left pixel is
    /// (`left`, `top`).
    pub(super) fn fill_tile(
        &self,
        tile: &mut WarpTile,
        left: usize,
        top: usize,
        needed: &[u32; TILE],
        precision: WarpPrecision,
    ) {
        tile.start(left, top);
        match precision {
            WarpPrecision::Interpolated => self.fill_interpolated(tile, needed),
            WarpPrecision::Exact => self.fill_exactly(tile, needed),
        }
    }

    fn fill_exactly(&self, tile: &mut WarpTile, needed: &[u32; TILE]) {
        for (row, bits) in needed.iter().enumerate() {
            for column in (0..TILE).filter(|column| bits >> column & 1 == 1) {
                let target = Point::new((tile.left + column) as f64, (tile.top + row) as f64);
                let source = self.position(target);
                tile.put(row * POINTS + column, source.x as f32, source.y as f32);
            }
        }
    }

    fn fill_interpolated(&self, tile: &mut WarpTile, needed: &[u32; TILE]) {
        let mut squares = std::mem::take(&mut tile.squares);
        let mut next = std::mem::take(&mut tile.next);
        squares.push((0, 0));
        let mut side = TILE;
        while side >= 2 && !squares.is_empty() {
            squares.retain(|&(column, row)| any_needed(needed, column, row, side));
            for &(column, row) in &squares {
                tile.want_grid(column, row, side);
            }
            tile.evaluate(self);
            for &(column, row) in &squares {
                if side == 2 || tile.is_bilinear(column, row, side) {
                    tile.interpolate(column, row, side);
                } else {
                    let half = side / 2;
                    next.extend(
                        [(0, 0), (half, 0), (0, half), (half, half)]
                            .map(|(x, y)| (column + x, row + y)),
                    );
                }
            }
            std::mem::swap(&mut squares, &mut next);
            next.clear();
            side /= 2;
        }
        squares.clear();
        (tile.squares, tile.next) = (squares, next);
    }
}

/// Points to be sent through all steps of a map.
struct MapPoints<'a> {
    steps: &'a [LaneMap],
    points: &'a mut [(Lanes, Lanes)],
}

impl Kernel for MapPoints<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for (x, y) in self.points {
            for step in self.steps {
                step.map(x, y);
            }
        }
    }
}

/// Which pixels of the tile at (`left`, `top`) belong to `inside`: bit x of row y.
pub(super) fn needed_pixels(inside: &Mask, left: usize, top: usize) -> [u32; TILE] {
    let mut needed = [0; TILE];
    let right = (left + TILE).min(inside.width() as usize);
    for (y, bits) in (top..inside.height() as usize).zip(&mut needed) {
        let row = &inside.row(y as u32)[left..right];
        for (column, _) in row.iter().enumerate().filter(|(_, own)| **own) {
            *bits |= 1 << column;
        }
    }
    needed
}

/// Whether a pixel of the square at (`column`, `row`) of side `side` is needed.
fn any_needed(needed: &[u32; TILE], column: usize, row: usize, side: usize) -> bool {
    let columns = (u32::MAX >> (TILE - side)) << column;
    needed[row..row + side]
        .iter()
        .any(|bits| bits & columns != 0)
}

/// Source positions of a tile, in the making.
pub(super) struct WarpTile {
    left: usize,
    top: usize,
    x: Vec<f32>,
    y: Vec<f32>,
    known: Vec<bool>,
    wanted: Vec<u16>,
    points: Vec<(Lanes, Lanes)>,
    squares: Vec<(usize, usize)>,
    next: Vec<(usize, usize)>,
}

impl WarpTile {
    /// A tile to be filled again and again.
    pub(super) fn new() -> Self {
        Self {
            left: 0,
            top: 0,
            x: vec![0.0; POINTS * POINTS],
            y: vec![0.0; POINTS * POINTS],
            known: vec![false; POINTS * POINTS],
            wanted: Vec::new(),
            points: Vec::new(),
            squares: Vec::new(),
            next: Vec::new(),
        }
    }

    /// Source positions (x, y) of the tile's row `row`; only needed pixels hold a value.
    pub(super) fn row(&self, row: usize) -> (&[f32], &[f32]) {
        let range = row * POINTS..row * POINTS + TILE;
        (&self.x[range.clone()], &self.y[range])
    }

    /// Gives the pixel at (`column`, `row`) of the tile another place in the source.
    pub(super) fn set(&mut self, column: usize, row: usize, [x, y]: [f32; 2]) {
        self.put(row * POINTS + column, x, y);
    }

    fn start(&mut self, left: usize, top: usize) {
        (self.left, self.top) = (left, top);
        self.known.fill(false);
    }

    fn put(&mut self, index: usize, x: f32, y: f32) {
        self.x[index] = x;
        self.y[index] = y;
    }

    /// Asks for the nine points of a square: corners, midpoints of the sides, centre.
    fn want_grid(&mut self, column: usize, row: usize, side: usize) {
        for y in [row, row + side / 2, row + side] {
            for x in [column, column + side / 2, column + side] {
                let index = y * POINTS + x;
                if !self.known[index] {
                    self.known[index] = true;
                    self.wanted.push(index as u16);
                }
            }
        }
    }

    /// Maps all points asked for.
    fn evaluate(&mut self, warp: &Warp) {
        let (left, top) = (self.left, self.top);
        let groups = self.wanted.chunks(LANES);
        self.points.clear();
        self.points.extend(groups.map(|group| {
            // The last group is filled up with its last point.
            let index = |lane: usize| usize::from(group[lane.min(group.len() - 1)]);
            (
                std::array::from_fn(|lane| (left + index(lane) % POINTS) as f32),
                std::array::from_fn(|lane| (top + index(lane) / POINTS) as f32),
            )
        }));
        warp.map(&mut self.points);
        for (group, (x, y)) in self.wanted.chunks(LANES).zip(&self.points) {
            for (lane, &index) in group.iter().enumerate() {
                self.x[usize::from(index)] = x[lane];
                self.y[usize::from(index)] = y[lane];
            }
        }
        self.wanted.clear();
    }

    /// Whether the corners of a square predict its five midpoints within the tolerance.
    fn is_bilinear(&self, column: usize, row: usize, side: usize) -> bool {
        let at = |x: usize, y: usize| {
            let index = (row + y) * POINTS + column + x;
            (self.x[index], self.y[index])
        };
        let (half, full) = (side / 2, side);
        let corners = [at(0, 0), at(full, 0), at(0, full), at(full, full)];
        let near = |x: usize, y: usize, from: &[usize]| {
            let count = from.len() as f32;
            let (real_x, real_y) = at(x, y);
            let dx = from.iter().map(|&i| corners[i].0).sum::<f32>() / count - real_x;
            let dy = from.iter().map(|&i| corners[i].1).sum::<f32>() / count - real_y;
            dx * dx + dy * dy < TOLERANCE_PX * TOLERANCE_PX
        };
        near(half, half, &[0, 1, 2, 3])
            && near(half, 0, &[0, 1])
            && near(half, full, &[2, 3])
            && near(0, half, &[0, 2])
            && near(full, half, &[1, 3])
    }

    /// Fills a square from its corners; points already mapped stay.
    fn interpolate(&mut self, column: usize, row: usize, side: usize) {
        let corner = |x: usize, y: usize| (row + y) * POINTS + column + x;
        let corners = [
            corner(0, 0),
            corner(side, 0),
            corner(0, side),
            corner(side, side),
        ];
        let x = corners.map(|i| self.x[i]);
        let y = corners.map(|i| self.y[i]);
        let scale = 1.0 / side as f32;
        for v in 0..side {
            let t = v as f32 * scale;
            let (x0, x1) = (x[0] + (x[2] - x[0]) * t, x[1] + (x[3] - x[1]) * t);
            let (y0, y1) = (y[0] + (y[2] - y[0]) * t, y[1] + (y[3] - y[1]) * t);
            for u in 0..side {
                let index = corner(u, v);
                if !self.known[index] {
                    let s = u as f32 * scale;
                    self.put(index, x0 + (x1 - x0) * s, y0 + (y1 - y0) * s);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn star(radius: f64, teeth: f64, count: usize) -> Cage {
        let points = (0..count).map(|i| {
            let angle = i as f64 / count as f64 * std::f64::consts::TAU;
            let r = radius * (1.0 + 0.2 * libm::cos(teeth * angle));
            Point::new(64.0 + r * libm::cos(angle), 64.0 - r * libm::sin(angle))
        });
        Cage::new(&[points.collect()]).unwrap()
    }

    #[test]
    fn interpolation_stays_within_a_quarter_pixel_everywhere() {
        let (target, source) = (star(50.0, 5.0, 60), star(40.0, 3.0, 60));
        for steps in [1, 3] {
            let warp = Warp::new(&target, &source, steps).unwrap();
            let mut tile = WarpTile::new();
            for (left, top) in (0..4).flat_map(|i| (0..4).map(move |j| (i * TILE, j * TILE))) {
                let needed = [u32::MAX; TILE];
                let precision = WarpPrecision::Interpolated;
                warp.fill_tile(&mut tile, left, top, &needed, precision);
                for row in 0..TILE {
                    for column in 0..TILE {
                        let target = Point::new((left + column) as f64, (top + row) as f64);
                        let exact = warp.position(target);
                        let (x, y) = tile.row(row);
                        let found = Point::new(f64::from(x[column]), f64::from(y[column]));
                        assert!(exact.distance(found) < 0.25, "{target}: {exact} {found}");
                    }
                }
            }
        }
    }

    #[test]
    fn equal_cages_give_the_identity() {
        let cage = star(50.0, 4.0, 40);
        let warp = Warp::new(&cage, &cage, 4).unwrap();
        let point = Point::new(70.0, 60.0);
        assert!(warp.position(point).distance(point) < 1e-9);
    }
}
