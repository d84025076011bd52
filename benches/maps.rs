//! Maps between cages compared on the worst pairs of real trees: `cargo bench --bench maps` prints the
//! table of `docs/maps.md`.
//!
//! The rivals of our composite mean value maps live here and not in the library: the plain mean value
//! map (Hormann & Floater 2006), the harmonic and the biharmonic map (two Laplace or bilaplace systems
//! on the pixels of the target, with the source's cage on the border), and the harmonic map made as
//! rigid as possible (Sorkine & Alexa, *As-rigid-as-possible surface modeling*, 2007) by ten rounds of
//! local turns and one solve. All are measured in one way, on the same grid.

#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a report to be read; the data are ours"
)]

use boscage::base::{Cancel, Progress};
use boscage::geometry::Point;
use boscage::raster::{Mask, ReadLimits, dilated, read_image};
use boscage::segment::Classical;
use boscage::solve::{GridSystem, Method, Solver, Stencil};
use boscage::variation::{
    Cage, Exemplar, ExemplarSettings, Layout, Shape, Warp, are_of_a_kind, inside_polygons,
};
use rayon::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

/// Side of the grid that maps are solved and measured on.
const GRID: u32 = 256;

/// Pixels beside the border that are not measured.
const BESIDE_PX: u8 = 3;

/// Pairs in each table.
const WORST: usize = 20;

/// Rounds of the rigid refinement.
const ROUNDS: usize = 10;

/// A map on the grid: where each pixel inside the target goes, row by row.
type Grid = Vec<Option<Point>>;

/// A way to make a map.
type Scheme = fn(&Pair) -> Grid;

fn main() {
    let shapes = shapes();
    let count = shapes.len();
    println!("{count} trees");
    let mut pairs: Vec<(f64, usize, usize)> = (0..count * count)
        .into_par_iter()
        .map(|i| (i / count, i % count))
        .filter(|(a, b)| a != b && has_same_trunk(&shapes[*a], &shapes[*b]))
        .map(|(a, b)| {
            let layout = Layout::new(&[(&shapes[a], 0.5, 1.0), (&shapes[b], 0.5, 0.0)]);
            (layout.unwrap().distortion.penalty(), a, b)
        })
        .collect();
    pairs.sort_by(|x, y| y.0.total_cmp(&x.0).then((x.1, x.2).cmp(&(y.1, y.2))));
    table("any pair", &shapes, &pairs);
    pairs.retain(|&(_, a, b)| are_of_a_kind(&shapes[a], &shapes[b]));
    table("of a kind", &shapes, &pairs);
}

/// The outlines of the real trees of `BOSCAGE_DATA`.
fn shapes() -> Vec<Shape> {
    let data = std::env::var("BOSCAGE_DATA").unwrap_or("../shared/data".to_owned());
    let folder = std::fs::read_dir(PathBuf::from(data).join("billboards")).unwrap();
    let mut files: Vec<PathBuf> = folder.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let settings = ExemplarSettings::default();
    let prepared = files.par_iter().map(|file| {
        let picture = read_image(file, ReadLimits::default()).unwrap();
        let (silent, cancel) = (Progress::silent(), Cancel::new());
        let exemplar = Exemplar::prepare(&picture, &settings, &Classical, silent, &cancel);
        exemplar.unwrap().shape.resized(GRID)
    });
    prepared.collect()
}

fn has_same_trunk(a: &Shape, b: &Shape) -> bool {
    let trunk = |s: &Shape| (s.contour.pins.has_trunk(), s.cage.pins.has_trunk());
    trunk(a) == trunk(b)
}

/// Prints how each map does on the worst of `pairs`.
fn table(title: &str, shapes: &[Shape], pairs: &[(f64, usize, usize)]) {
    let schemes: [(&str, Scheme); 5] = [
        ("mean value, one step", plain),
        ("mean value, composite", composite),
        ("harmonic", |pair| solved(pair, Stencil::Laplacian)),
        ("biharmonic", |pair| solved(pair, Stencil::Bilaplacian)),
        ("as rigid as possible", rigid),
    ];
    println!("\nthe {WORST} worst pairs, {title}");
    println!(
        "| Map | Pairs that fold | Folded area | Area, 95 % | Angle, 95 % | Angle, median | ms |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (name, scheme) in schemes {
        let mut sums = [0.0; 6];
        for &(_, a, b) in pairs.iter().take(WORST) {
            let pair = Pair::new(&shapes[a], &shapes[b]);
            let start = Instant::now();
            let map = scheme(&pair);
            let ms = start.elapsed().as_secs_f64() * 1e3;
            let [folded, area, angle, median] = measured(&map, &pair.inner);
            let values = [
                f64::from(u8::from(folded > 0.0)),
                folded,
                area,
                angle,
                median,
                ms,
            ];
            sums.iter_mut()
                .zip(values)
                .for_each(|(sum, value)| *sum += value);
        }
        let count = pairs.len().min(WORST) as f64;
        let [folds, folded, area, angle, median, ms] = sums;
        println!(
            "| {name} | {folds} | {:.3} % | {:.2} | {:.2} | {:.2} | {:.0} |",
            100.0 * folded / count,
            area / count,
            angle / count,
            median / count,
            ms / count
        );
    }
}

/// Two cages that correspond: of the tree half way, and of the one that gives the picture.
struct Pair {
    layout: Layout,
    target: Cage,
    source: Cage,
    inside: Mask,
    /// Those of the pixels inside that are measured: not beside the border, which the grid cuts into
    /// steps for the maps that are solved on it.
    inner: Mask,
}

impl Pair {
    fn new(a: &Shape, b: &Shape) -> Self {
        let layout = Layout::new(&[(a, 0.5, 1.0), (b, 0.5, 0.0)]).unwrap();
        let polygon = layout.cage.points.clone();
        let target = Cage::new(std::slice::from_ref(&polygon)).unwrap();
        let source = target.moved(a.cage.points.clone()).unwrap();
        let inside = inside_polygons(&[polygon], GRID, GRID);
        let outside = inside.map(|is_inside| !is_inside);
        let inner = dilated(&outside, BESIDE_PX).map(|is_outside| !is_outside);
        Self {
            layout,
            target,
            source,
            inside,
            inner,
        }
    }

    /// What `map` makes of the pixels inside.
    fn grid(&self, map: impl Fn(Point) -> Point) -> Grid {
        let places = (0..GRID).flat_map(|y| (0..GRID).map(move |x| (x, y)));
        let mapped = places.map(|(x, y)| {
            let point = Point::new(f64::from(x), f64::from(y));
            self.inside.at(x, y).then(|| map(point))
        });
        mapped.collect()
    }

    /// Where a point on or just outside the border goes: with the nearest edge, and as far from it.
    fn border(&self, point: Point) -> Point {
        let (target, source) = (self.target.points(), self.source.points());
        let count = target.len();
        let of_edge = |i: usize| {
            let (a, b) = (target[i], target[(i + 1) % count]);
            let share = (point - a).dot(b - a) / a.distance_squared(b).max(1e-12);
            let share = share.clamp(0.0, 1.0);
            (a.lerp(b, share).distance(point), share)
        };
        let nearest = (0..count).min_by(|&i, &j| of_edge(i).0.total_cmp(&of_edge(j).0));
        let i = nearest.unwrap();
        let (distance, share) = of_edge(i);
        let (a, b) = (source[i], source[(i + 1) % count]);
        // Counter-clockwise on screen, y down: outside lies to the right of an edge.
        let outwards = Point::new(-(b - a).y, (b - a).x).normalize_or_zero();
        a.lerp(b, share) + outwards * distance
    }
}

fn plain(pair: &Pair) -> Grid {
    let warp = Warp::new(&pair.target, &pair.source, 1).unwrap();
    pair.grid(|point| warp.position(point))
}

fn composite(pair: &Pair) -> Grid {
    pair.grid(|point| pair.layout.warps[0].position(point))
}

/// The map of which the stencil's operator is nothing, with the source's cage on the border.
fn solved(pair: &Pair, stencil: Stencil) -> Grid {
    let nothing = vec![Point::ZERO; GRID as usize * GRID as usize];
    let system = GridSystem::new(&pair.inside, stencil);
    let solver = Solver::new(system, Method::Direct, &Cancel::new()).unwrap();
    solution(pair, &solver, &nothing)
}

/// The solution with the border of `pair` and `forces` on the right-hand side.
fn solution(pair: &Pair, solver: &Solver, forces: &[Point]) -> Grid {
    let system = solver.system();
    let radius = system.stencil().radius() as u8;
    let ring = dilated(&pair.inside, radius);
    let at = |&(x, y): &(u32, u32)| forces[(y * GRID + x) as usize];
    let mut right_x: Vec<f64> = system.pixels().iter().map(|p| at(p).x).collect();
    let mut right_y: Vec<f64> = system.pixels().iter().map(|p| at(p).y).collect();
    let places = (0..GRID).flat_map(|y| (0..GRID).map(move |x| (x, y)));
    for (x, y) in places.filter(|&(x, y)| ring.at(x, y) && !pair.inside.at(x, y)) {
        let goes = pair.border(Point::new(f64::from(x), f64::from(y)));
        system.spread(i64::from(x), i64::from(y), goes.x, &mut right_x);
        system.spread(i64::from(x), i64::from(y), goes.y, &mut right_y);
    }
    let cancel = Cancel::new();
    let xs = solver.solution(&right_x, None, &cancel).unwrap();
    let ys = solver.solution(&right_y, None, &cancel).unwrap();
    let mut grid: Grid = vec![None; GRID as usize * GRID as usize];
    for (&(x, y), (&to_x, &to_y)) in system.pixels().iter().zip(xs.iter().zip(&ys)) {
        grid[(y * GRID + x) as usize] = Some(Point::new(to_x, to_y));
    }
    grid
}

/// The harmonic map, made as rigid as possible.
fn rigid(pair: &Pair) -> Grid {
    const AROUND: [(i64, i64); 4] = [(1, 0), (-1, 0), (0, 1), (0, -1)];
    let system = GridSystem::new(&pair.inside, Stencil::Laplacian);
    let solver = Solver::new(system, Method::Direct, &Cancel::new()).unwrap();
    let size = GRID as usize * GRID as usize;
    let mut grid = solution(pair, &solver, &vec![Point::ZERO; size]);
    let get = |grid: &Grid, x: i64, y: i64| {
        let side = 0..i64::from(GRID);
        let is_there = side.contains(&x) && side.contains(&y);
        is_there
            .then(|| grid[(y * i64::from(GRID) + x) as usize])
            .flatten()
    };
    for _ in 0..ROUNDS {
        let places = (0..i64::from(GRID)).flat_map(|y| (0..i64::from(GRID)).map(move |x| (x, y)));
        let turns: Vec<Option<Point>> = places
            .clone()
            .map(|(x, y)| {
                let own = get(&grid, x, y)?;
                let mut turn = Point::ZERO;
                for (dx, dy) in AROUND {
                    if let Some(other) = get(&grid, x + dx, y + dy) {
                        let (before, after) = (Point::new(dx as f64, dy as f64), other - own);
                        turn += Point::new(before.dot(after), before.perp_dot(after));
                    }
                }
                Some(turn.normalize_or(Point::X))
            })
            .collect();
        let forces: Vec<Point> = places
            .map(|(x, y)| {
                let Some(own) = get(&turns, x, y) else {
                    return Point::ZERO;
                };
                let push = |(dx, dy): (i64, i64)| {
                    let other = get(&turns, x + dx, y + dy).unwrap_or(own);
                    // Turned by half of both: what the edge to this neighbour should be, negated.
                    ((own + other) / 2.0).rotate(Point::new(-dx as f64, -dy as f64))
                };
                AROUND.into_iter().map(push).sum()
            })
            .collect();
        grid = solution(pair, &solver, &forces);
    }
    grid
}

/// Of a map: share of folded area; 95 % quantile of how many times larger or smaller than the median an
/// area gets; 95 % quantile and median of how many times longer than wide a circle gets.
fn measured(grid: &Grid, inner: &Mask) -> [f64; 4] {
    let side = GRID as usize;
    let mut areas = Vec::new();
    let mut angles = Vec::new();
    let mut folded = 0;
    for index in (side + 1..grid.len() - side - 1).filter(|&i| inner.pixels()[i]) {
        let ends = [index - 1, index + 1, index - side, index + side].map(|i| grid[i]);
        let [Some(left), Some(right), Some(above), Some(below)] = ends else {
            continue;
        };
        let (x, y) = ((right - left) / 2.0, (below - above) / 2.0);
        let area = x.perp_dot(y);
        folded += usize::from(area <= 0.0);
        let sum = Point::new(x.x + y.y, y.x - x.y).length();
        let difference = Point::new(x.x - y.y, y.x + x.y).length();
        angles.push((sum + difference) / (sum - difference).abs().max(1e-9));
        areas.push(area.abs().max(1e-9));
    }
    let count = areas.len();
    areas.sort_by(f64::total_cmp);
    let middle = areas[count / 2];
    let mut ratios: Vec<f64> = areas.iter().map(|a| (a / middle).max(middle / a)).collect();
    ratios.sort_by(f64::total_cmp);
    angles.sort_by(f64::total_cmp);
    let high = |values: &[f64]| values[count * 95 / 100];
    [
        folded as f64 / count as f64,
        high(&ratios),
        high(&angles),
        angles[count / 2],
    ]
}
