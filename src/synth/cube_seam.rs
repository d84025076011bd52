//! The best seam between two cubemaps: on the texels of all six faces at once.
//!
//! Costs are those of [`super::seam`]; each texel has four neighbours, those at an edge one of them
//! on the next face, so a seam goes over edges and corners as if they were not there.

use super::seam::{Side, StepCost, step_cost};
use crate::base::{Cancel, Cancelled};
use crate::raster::{CubeFace, Cubemap, Straight};
use crate::solve::{Edge, HARD, Network};
use glam::DVec3;

/// Two cubemaps' best seam: `true` where the texel comes from the second, and what it costs.
///
/// `side` says which texels are settled; only open ones and those next to them enter the cut. An open
/// texel that comes from the second costs what `preference` says there, so that the first is not given
/// up merely because a short seam is cheap.
///
/// # Errors
/// [`Cancelled`] when the work was asked to stop.
///
/// # Panics
/// When the cubemaps have different sizes.
pub fn cube_seam(
    first: &Cubemap<Straight>,
    second: &Cubemap<Straight>,
    side: &Cubemap<Side>,
    preference: &Cubemap<u8>,
    cost: StepCost,
    cancel: &Cancel,
) -> Result<(Cubemap<bool>, i64), Cancelled> {
    let size = first.size();
    assert_eq!(
        [size, size],
        [second.size(), side.size()],
        "cubemaps of one size"
    );
    let mut nodes = Cubemap::filled(size, NO_NODE);
    let mut count = 0u32;
    let mut edges = Vec::new();
    let mut held = Vec::new();
    let mut node_of = |place: Texel, held: &mut Vec<(Side, u8)>| {
        let found = place.of(&nodes);
        if found != NO_NODE {
            return found;
        }
        nodes.face_mut(place.face).set(place.x, place.y, count);
        held.push((place.of(side), place.of(preference)));
        count += 1;
        count - 1
    };
    cancel.check()?;
    for (s, t) in neighbours(size) {
        let open = [s, t].iter().any(|place| place.of(side) == Side::Either);
        if !open {
            continue;
        }
        let at = |place: Texel| [place.of(first), place.of(second)];
        let capacity = step_cost(at(s), at(t), cost);
        edges.push(Edge {
            a: node_of(s, &mut held),
            b: node_of(t, &mut held),
            forward: capacity,
            backward: capacity,
        });
    }
    let mut network = Network::new(held.len(), &edges);
    for (node, (side, preference)) in held.iter().enumerate() {
        match side {
            Side::Either => network.join_source(node, i32::from(*preference)),
            Side::First => network.join_source(node, HARD),
            Side::Second => network.join_sink(node, HARD),
        }
    }
    let cut = network.min_cut(cancel)?;
    let mut from_second = side.map(|&side| side == Side::Second);
    for face in CubeFace::ALL {
        let placed = from_second.face_mut(face).pixels_mut().iter_mut();
        for (from_second, &node) in placed.zip(nodes.face(face).pixels()) {
            if node != NO_NODE {
                *from_second = !cut.on_source_side[node as usize];
            }
        }
    }
    Ok((from_second, cut.flow))
}

const NO_NODE: u32 = u32::MAX;

/// A place in a cubemap.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Texel {
    pub(super) face: CubeFace,
    pub(super) x: u32,
    pub(super) y: u32,
}

impl Texel {
    /// The value of `map` there.
    #[inline]
    pub(super) fn of<P: Copy>(self, map: &Cubemap<P>) -> P {
        map.face(self.face).at(self.x, self.y)
    }

    /// The texel on the other side of the edge that lies `step` away (one of its parts ±1, the other
    /// 0), for a texel at that edge; `size` texels a face.
    pub(super) fn over_edge(self, [right, down]: [f64; 2], size: u32) -> Self {
        let [axis_x, axis_y, out] = self.face.axes();
        let centre = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
        // One texel out of the face and half a texel down its other side.
        let along = axis_x * (centre(self.x) * (1.0 - right.abs()))
            + axis_y * (centre(self.y) * (1.0 - down.abs()));
        let position: DVec3 =
            along + axis_x * right + axis_y * down + out * (1.0 - 1.0 / f64::from(size));
        let (face, u, v) = CubeFace::of(position);
        let texel = |u: f64| (((u + 1.0) / 2.0 * f64::from(size)) as u32).min(size - 1);
        Self {
            face,
            x: texel(u),
            y: texel(v),
        }
    }
}

/// The pairs of neighbouring texels of all faces, then those over the cube's twelve edges.
pub(super) fn neighbours(size: u32) -> impl Iterator<Item = (Texel, Texel)> {
    let inside = CubeFace::ALL.into_iter().flat_map(move |face| {
        (0..size).flat_map(move |y| {
            (0..size).flat_map(move |x| {
                let here = Texel { face, x, y };
                let right = (x + 1 < size).then_some((here, Texel { face, x: x + 1, y }));
                let down = (y + 1 < size).then_some((here, Texel { face, x, y: y + 1 }));
                [right, down].into_iter().flatten()
            })
        })
    });
    inside.chain(cube_edges(size).into_iter().flatten())
}

/// The pairs of texels over each of the twelve edges, in order along the edge.
pub(super) fn cube_edges(size: u32) -> Vec<Vec<(Texel, Texel)>> {
    const STEPS: [[f64; 2]; 4] = [[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0], [0.0, 1.0]];
    let last = size - 1;
    let mut edges = Vec::new();
    for face in CubeFace::ALL {
        for step in STEPS {
            let border = (0..size).map(|i| match step {
                [-1.0, _] => Texel { face, x: 0, y: i },
                [1.0, _] => Texel {
                    face,
                    x: last,
                    y: i,
                },
                [_, -1.0] => Texel { face, x: i, y: 0 },
                _ => Texel {
                    face,
                    x: i,
                    y: last,
                },
            });
            let pairs: Vec<_> = border
                .map(|here| (here, here.over_edge(step, size)))
                .collect();
            // Each edge belongs to two faces; the earlier one tells of it.
            if (face as usize) < pairs[0].1.face as usize {
                edges.push(pairs);
            }
        }
    }
    edges
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_over_edges_are_near_and_see_each_other() {
        let size = 8;
        let edges = cube_edges(size);
        assert_eq!(edges.len(), 12);
        let centre = |t: Texel| {
            let at = |i: u32| (2.0 * f64::from(i) + 1.0) / f64::from(size) - 1.0;
            t.face.direction(at(t.x), at(t.y))
        };
        for (s, t) in edges.into_iter().flatten() {
            assert_ne!(s.face, t.face);
            // Half a texel this side and half a texel beyond, around a right angle.
            let apart = centre(s).distance(centre(t)) * f64::from(size);
            assert!((apart - 2f64.sqrt()).abs() < 1e-9, "{s:?} {t:?} {apart}");
        }
        assert_eq!(neighbours(size).count(), 6 * 2 * 8 * 7 + 12 * 8);
    }

    #[test]
    fn a_seam_goes_round_a_corner_where_the_maps_agree() {
        // They differ everywhere but on a circle around the corner (1, 1, 1).
        let corner = DVec3::ONE.normalize();
        let near = |d: DVec3| d.normalize().dot(corner);
        let first = Cubemap::filled(16, Straight([100, 100, 100, 255]));
        let second = Cubemap::from_directions(16, |d| {
            let on_circle = (0.75..0.9).contains(&near(d));
            Straight([if on_circle { 100 } else { 200 }, 100, 100, 255])
        });
        let side = Cubemap::from_directions(16, |d| match near(d) {
            x if x > 0.97 => Side::First,
            x if x < 0.6 => Side::Second,
            _ => Side::Either,
        });
        let found = cube_seam(
            &first,
            &second,
            &side,
            &Cubemap::filled(16, 0),
            StepCost::Difference,
            &Cancel::new(),
        );
        let (from_second, cost) = found.unwrap();
        assert_eq!(cost, 0);
        assert!(from_second.nearest(-corner) && !from_second.nearest(corner));
    }
}
