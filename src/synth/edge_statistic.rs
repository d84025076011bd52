//! Whether the edges and corners of a cubemap can be seen: a statistic.
//!
//! A seam shows when neighbouring texels differ more across it than elsewhere. The mean difference
//! across the twelve edges is set beside that across twelve lines drawn at random inside the faces,
//! again and again: the share of such draws below it says how unusual the edges are. Corners likewise,
//! with the few pairs of texels nearest to them.
//!
//! The lines run near the edges and along them, because a cubemap's texels are smaller there than in
//! the middle of a face and hence differ less.

use super::cube_seam::{Texel, cube_edges};
use super::seam::distance;
use crate::base::{Random, Seed};
use crate::raster::{CubeFace, Cubemap, Straight};

/// How the edges of a cubemap compare with lines inside its faces. Differences are means over pairs of
/// neighbouring texels of the sum over red, green and blue, 0 … 765.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct EdgeStatistic {
    /// Difference across the twelve edges.
    pub edges: f64,
    /// Difference across the three edges at each of the eight corners, next to the corner.
    pub corners: f64,
    /// Difference across lines inside the faces.
    pub interior: f64,
    /// Share of draws of twelve lines whose difference is smaller than that of the edges: 0.5 is
    /// usual, 1 is a visible edge.
    pub edge_rank: f64,
    /// The same for corners.
    pub corner_rank: f64,
}

/// Draws that ranks are made of.
const DRAWS: usize = 2000;

/// Pairs of texels next to a corner, along each of its edges.
const AT_CORNER: usize = 4;

/// The statistic of `map`, whose faces must have 32 texels a side at least.
///
/// # Panics
/// When the faces are smaller.
pub fn edge_statistic(map: &Cubemap<Straight>) -> EdgeStatistic {
    assert!(map.size() >= 32, "faces are too small");
    let edges: Vec<Vec<f64>> = cube_edges(map.size())
        .iter()
        .map(|edge| edge.iter().map(|&pair| difference(map, pair)).collect())
        .collect();
    let lines = lines(map);
    let mut random = Seed(0).derive("lines", 0).random();
    let edge_mean = mean(edges.iter().flatten());
    let ends = edges.iter().flat_map(|edge| {
        let end = edge.len() - AT_CORNER;
        edge[..AT_CORNER].iter().chain(&edge[end..])
    });
    let corner_mean = mean(ends);
    let line_means: Vec<f64> = lines.iter().map(mean).collect();
    let drawn_edges = |random: &mut Random| {
        let drawn: Vec<f64> = edges
            .iter()
            .map(|_| line_means[random.below(line_means.len())])
            .collect();
        mean(&drawn)
    };
    let drawn_corners = |random: &mut Random| {
        let pieces: Vec<f64> = (0..2 * edges.len())
            .map(|_| {
                let line = &lines[random.below(lines.len())];
                let first = random.below(line.len() - AT_CORNER);
                mean(&line[first..first + AT_CORNER])
            })
            .collect();
        mean(&pieces)
    };
    EdgeStatistic {
        edges: edge_mean,
        corners: corner_mean,
        interior: mean(&line_means),
        edge_rank: rank(edge_mean, &mut random, drawn_edges),
        corner_rank: rank(corner_mean, &mut random, drawn_corners),
    }
}

/// The differences across the lines parallel to the edges, from two texels inside to a sixteenth of
/// the face.
fn lines(map: &Cubemap<Straight>) -> Vec<Vec<f64>> {
    let size = map.size();
    let mut lines = Vec::new();
    for face in CubeFace::ALL {
        for near in 2..=size / 16 {
            for first in [near, size - 2 - near] {
                let across = |i| {
                    (
                        Texel {
                            face,
                            x: first,
                            y: i,
                        },
                        Texel {
                            face,
                            x: first + 1,
                            y: i,
                        },
                    )
                };
                let down = |i| {
                    (
                        Texel {
                            face,
                            x: i,
                            y: first,
                        },
                        Texel {
                            face,
                            x: i,
                            y: first + 1,
                        },
                    )
                };
                lines.push((0..size).map(|i| difference(map, across(i))).collect());
                lines.push((0..size).map(|i| difference(map, down(i))).collect());
            }
        }
    }
    lines
}

fn difference(map: &Cubemap<Straight>, (s, t): (Texel, Texel)) -> f64 {
    f64::from(distance(s.of(map), t.of(map)))
}

/// The share of draws below `value`.
fn rank(value: f64, random: &mut Random, draw: impl Fn(&mut Random) -> f64) -> f64 {
    let below = (0..DRAWS).filter(|_| draw(random) < value).count();
    below as f64 / DRAWS as f64
}

fn mean<'a>(values: impl IntoIterator<Item = &'a f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
    sum / f64::from(count.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Waves in all directions, with no regard for the cube's: −1 … 1 mostly.
    fn wavy() -> impl Fn(DVec3) -> f64 {
        let mut random = Seed(4).random();
        let mut number = move || random.between(-1.0, 1.0);
        let waves: Vec<(DVec3, f64)> = (0..40)
            .map(|_| {
                let way = DVec3::new(number(), number(), number()).normalize();
                (way * 14.0, 4.0 * number())
            })
            .collect();
        move |d: DVec3| {
            let d = d.normalize();
            let sum: f64 = waves
                .iter()
                .map(|(way, phase)| libm::sin(way.dot(d) + phase))
                .sum();
            sum / 10.0
        }
    }

    #[test]
    fn what_goes_over_edges_is_not_seen_and_a_step_is() {
        let wave = wavy();
        let seamless = Cubemap::from_directions(64, |d| {
            let value = (128.0 + 40.0 * wave(d)) as u8;
            Straight([value, value, value, 255])
        });
        let good = edge_statistic(&seamless);
        assert!(good.edge_rank < 0.99 && good.corner_rank < 0.99, "{good:?}");
        let mut stepped = seamless;
        for pixel in stepped.face_mut(CubeFace::PosY).pixels_mut() {
            pixel.0[1] = pixel.0[1].saturating_add(25);
        }
        let bad = edge_statistic(&stepped);
        assert!(bad.edge_rank > 0.99, "{bad:?}");
    }
}
