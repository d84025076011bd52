//! The order in which the unknowns of a grid are eliminated: geometric nested dissection.
//!
//! Idea: a line of pixels, as wide as the stencil reaches, parts the grid in two halves that no
//! equation joins. The halves come first, each parted again, the line comes last. The fronts of the
//! tree that results are what the multifrontal factorisation works on.
//!
//! Source: A. George, *Nested dissection of a regular finite element mesh*, 1973. Departure: the
//! pixels are any set, so the line is sought along both axes, near the middle, where it is shortest.

use super::grid::GridSystem;
use crate::base::{Cancel, Cancelled};
use std::ops::Range;

/// Most unknowns that are eliminated without being parted.
const LEAF: usize = 48;

/// One front: unknowns that are eliminated together, and those of later fronts they touch.
pub(super) struct Front {
    /// Places, in the order of elimination, of everything in this front and those below it.
    pub(super) subtree: Range<usize>,
    /// How many of them, the last ones, are this front's own.
    pub(super) own: usize,
    /// Places of later unknowns that this front and those below it change, ascending.
    pub(super) boundary: Vec<u32>,
    /// For each place of `boundary`, its position in the front above: its own unknowns first, then
    /// its boundary. Empty at the root.
    pub(super) in_parent: Vec<u32>,
    /// The halves; none for a leaf, else two.
    pub(super) halves: Vec<Front>,
}

/// The fronts of a system, and which unknown is eliminated when.
pub(super) struct Dissection {
    /// The last front.
    pub(super) root: Front,
    /// The unknown at each place of the order.
    pub(super) order: Vec<u32>,
}

impl Dissection {
    /// The fronts of `system`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub(super) fn new(system: &GridSystem, cancel: &Cancel) -> Result<Self, Cancelled> {
        let unknowns: Vec<u32> = (0..system.len() as u32).collect();
        let mut order = Vec::with_capacity(unknowns.len());
        let mut root = parted(system, unknowns, &mut order, cancel)?;
        let mut places = vec![0; order.len()];
        for (place, &unknown) in order.iter().enumerate() {
            places[unknown as usize] = place as u32;
        }
        let row = |place: usize| {
            let unknown = order[place] as usize;
            system.row(unknown).map(|(other, _)| places[other])
        };
        join(&mut root, &row, cancel)?;
        Ok(Self { root, order })
    }
}

impl Front {
    /// Place of the first unknown of this front's own.
    pub(super) fn first(&self) -> usize {
        self.subtree.end - self.own
    }

    /// Unknowns of this front and its boundary.
    pub(super) fn size(&self) -> usize {
        self.own + self.boundary.len()
    }
}

/// The fronts of `unknowns`, which are appended to `order`; boundaries are still empty.
fn parted(
    system: &GridSystem,
    unknowns: Vec<u32>,
    order: &mut Vec<u32>,
    cancel: &Cancel,
) -> Result<Front, Cancelled> {
    cancel.check()?;
    let start = order.len();
    let mut halves = Vec::new();
    let own = if unknowns.len() <= LEAF {
        unknowns
    } else {
        let [before, line, after] = cut(system, unknowns);
        halves.push(parted(system, before, order, cancel)?);
        halves.push(parted(system, after, order, cancel)?);
        line
    };
    order.extend_from_slice(&own);
    Ok(Front {
        subtree: start..order.len(),
        own: own.len(),
        boundary: Vec::new(),
        in_parent: Vec::new(),
        halves,
    })
}

/// The unknowns before, on and behind the best line.
fn cut(system: &GridSystem, unknowns: Vec<u32>) -> [Vec<u32>; 3] {
    let pixel = |unknown: u32| {
        let (x, y) = system.pixels()[unknown as usize];
        [x, y]
    };
    let width = system.stencil().radius();
    let best = [0, 1].map(|axis| {
        let along = unknowns.iter().map(|&unknown| pixel(unknown)[axis]);
        line(along, width).map(|(cost, at)| (cost, axis, at))
    });
    let best = best.into_iter().flatten().min();
    let (_, axis, at) = best.unwrap_or_else(|| unreachable!("{LEAF} pixels are long enough"));
    let mut parts = [Vec::new(), Vec::new(), Vec::new()];
    for unknown in unknowns {
        let coordinate = pixel(unknown)[axis];
        let part = usize::from(coordinate >= at) + usize::from(coordinate >= at + width);
        parts[part].push(unknown);
    }
    parts
}

/// The coordinate at which a line of `width` pixels is best, with its cost before it; `None` when
/// nothing would remain on one side.
fn line(coordinates: impl Iterator<Item = u32> + Clone, width: u32) -> Option<((bool, u64), u32)> {
    let first = coordinates.clone().min()?;
    let last = coordinates.clone().max()?;
    let mut counts = vec![0u64; (last - first) as usize + 1];
    for coordinate in coordinates {
        counts[(coordinate - first) as usize] += 1;
    }
    let total: u64 = counts.iter().sum();
    let width = width as usize;
    let mut before = 0;
    let mut best = None;
    for at in 1..counts.len().saturating_sub(width) {
        before += counts[at - 1];
        let on: u64 = counts[at..at + width].iter().sum();
        let after = total - before - on;
        let cost = cost(total, on, before.abs_diff(after));
        if before > 0 && after > 0 && best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, first + at as u32));
        }
    }
    best
}

/// What a line through `on` of `total` pixels costs when its sides differ by `uneven`.
///
/// Never cutting off less than a fifth keeps the tree shallow; that is possible for any set of more
/// than [`LEAF`] pixels, along one axis or the other.
fn cost(total: u64, on: u64, uneven: u64) -> (bool, u64) {
    let length = 4 * on + total.isqrt();
    let excess = 4 * uneven * uneven / total;
    (5 * uneven > 3 * total, length * (total + excess))
}

/// Finds the boundary of every front and its positions in the front above.
fn join<I: Iterator<Item = u32>>(
    front: &mut Front,
    row: &impl Fn(usize) -> I,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    cancel.check()?;
    let end = front.subtree.end as u32;
    let mut boundary: Vec<u32> = Vec::new();
    for half in &mut front.halves {
        join(half, row, cancel)?;
        boundary.extend(half.boundary.iter().filter(|&&place| place >= end));
    }
    for place in front.first()..front.subtree.end {
        boundary.extend(row(place).filter(|&other| other >= end));
    }
    boundary.sort_unstable();
    boundary.dedup();
    front.boundary = boundary;
    let (first, own) = (front.first() as u32, front.own as u32);
    for half in &mut front.halves {
        let mut above = 0;
        half.in_parent = half
            .boundary
            .iter()
            .map(|&place| {
                if place < end {
                    return place - first;
                }
                while front.boundary[above] < place {
                    above += 1;
                }
                own + above as u32
            })
            .collect();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;
    use crate::solve::Stencil;

    fn check(front: &Front, system: &GridSystem, dissection: &Dissection) {
        for half in &front.halves {
            assert!(
                half.boundary
                    .iter()
                    .all(|&place| place as usize >= half.subtree.end)
            );
            for (&place, &position) in half.boundary.iter().zip(&half.in_parent) {
                let position = position as usize;
                let there = if position < front.own {
                    (front.first() + position) as u32
                } else {
                    front.boundary[position - front.own]
                };
                assert_eq!(there, place);
            }
            check(half, system, dissection);
        }
        if let [before, after] = front.halves.as_slice() {
            let of = |half: &Front| dissection.order[half.subtree.clone()].to_vec();
            let after = of(after);
            for unknown in of(before) {
                let row = system.row(unknown as usize);
                assert!(
                    row.into_iter()
                        .all(|(other, _)| !after.contains(&(other as u32)))
                );
            }
        }
    }

    #[test]
    fn halves_are_not_joined_and_boundaries_are_found_above() {
        let mask = Image::from_pixels(
            40,
            23,
            (0..920)
                .map(|i| (i * 7919) % 11 != 0 || i % 40 < 20)
                .collect(),
        );
        for stencil in [Stencil::Laplacian, Stencil::Bilaplacian] {
            let system = GridSystem::new(&mask, stencil);
            let dissection = Dissection::new(&system, &Cancel::new()).unwrap();
            let mut sorted = dissection.order.clone();
            sorted.sort_unstable();
            assert!(sorted.into_iter().eq(0..system.len() as u32));
            check(&dissection.root, &system, &dissection);
        }
    }
}
