//! Direct solution: multifrontal Cholesky over the fronts of a nested dissection.
//!
//! Each front is a small dense matrix: its own unknowns and the later ones they touch. Eliminating
//! its own unknowns leaves an update that is added into the front above; the halves of a grid are
//! independent until then and go to different threads.
//!
//! Source: J. Liu, *The multifrontal method for sparse matrix solution*, 1992.
//!
//! Cost for n unknowns of the bilaplacian: about n^1.5 operations and n log n memory; a disc across
//! 1024 pixels needs about a gigabyte, which is where [`super::Multigrid`] takes over.

use super::dense::{self, Packed};
use super::dissection::{Dissection, Front};
use super::grid::GridSystem;
use crate::base::{Cancel, Cancelled};

/// Unknowns in a subtree from which on its halves are worth a thread each.
const WORTH_A_THREAD: usize = 2_000;

/// A factorised system, ready for any number of right-hand sides.
pub struct Factor {
    dissection: Dissection,
    root: Columns,
}

/// The columns of L that belong to a front, and those of the fronts below it.
struct Columns {
    /// Column-major: the front's own unknowns wide, the whole front high.
    panel: Vec<f64>,
    halves: Vec<Columns>,
}

/// What the elimination of a front leaves for its boundary: a lower triangle, column-major.
type Update = Vec<f64>;

impl Factor {
    /// Factorises `system`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn new(system: &GridSystem, cancel: &Cancel) -> Result<Self, Cancelled> {
        let dissection = Dissection::new(system, cancel)?;
        let mut places = vec![0; system.len()];
        for (place, &unknown) in dissection.order.iter().enumerate() {
            places[unknown as usize] = place as u32;
        }
        let work = Work {
            system,
            order: &dissection.order,
            places: &places,
            cancel,
        };
        let (root, _) = work.eliminated(&dissection.root)?;
        Ok(Self { dissection, root })
    }

    /// Numbers in the factor.
    pub fn len(&self) -> usize {
        self.root.len()
    }

    /// Whether the system has no unknowns.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The solution for the right-hand side `right`, one value an unknown.
    ///
    /// # Panics
    /// When `right` has another length than the system.
    pub fn solution(&self, right: &[f64]) -> Vec<f64> {
        let order = &self.dissection.order;
        assert_eq!(right.len(), order.len(), "one value an unknown");
        let mut values: Vec<f64> = order.iter().map(|&i| right[i as usize]).collect();
        let front = &self.dissection.root;
        forward(front, &self.root, &mut values);
        backward(front, &self.root, &mut values, &[]);
        let mut solution = vec![0.0; right.len()];
        for (&unknown, &value) in order.iter().zip(&values) {
            solution[unknown as usize] = value;
        }
        solution
    }
}

impl Columns {
    fn len(&self) -> usize {
        self.panel.len() + self.halves.iter().map(Self::len).sum::<usize>()
    }
}

/// What the elimination needs everywhere.
struct Work<'a> {
    system: &'a GridSystem,
    order: &'a [u32],
    places: &'a [u32],
    cancel: &'a Cancel,
}

impl Work<'_> {
    /// Eliminates `front` and all below it.
    fn eliminated(&self, front: &Front) -> Result<(Columns, Update), Cancelled> {
        self.cancel.check()?;
        let below = both(front, |_, half| self.eliminated(half));
        let (height, rest) = (front.size(), front.boundary.len());
        let mut panel = self.assembled(front);
        let mut update = vec![0.0; rest * rest];
        let mut halves = Vec::with_capacity(2);
        for (half, result) in front.halves.iter().zip(below) {
            let (columns, child) = result?;
            add(half, &child, &mut panel, &mut update, front.own, height);
            halves.push(columns);
        }
        let mut packed = Packed::default();
        dense::factorize(&mut panel, height, front.own, &mut packed, self.cancel)?;
        let (own, cancel) = (front.own, self.cancel);
        dense::subtract_product(
            &panel,
            height,
            own,
            &mut update,
            rest,
            0,
            rest,
            &mut packed,
            cancel,
        )?;
        Ok((Columns { panel, halves }, update))
    }

    /// The columns of the matrix for the front's own unknowns, from the diagonal down.
    fn assembled(&self, front: &Front) -> Vec<f64> {
        let (first, height) = (front.first(), front.size());
        let mut panel = vec![0.0; front.own * height];
        for (j, place) in (first..front.subtree.end).enumerate() {
            for (unknown, coefficient) in self.system.row(self.order[place] as usize) {
                let other = self.places[unknown] as usize;
                if other < place {
                    continue;
                }
                let row = if other < front.subtree.end {
                    other - first
                } else {
                    front.own + front.boundary.partition_point(|&b| (b as usize) < other)
                };
                panel[j * height + row] = coefficient;
            }
        }
        panel
    }
}

/// Adds the update `child` that `half` left to the front above it.
fn add(
    half: &Front,
    child: &[f64],
    panel: &mut [f64],
    update: &mut [f64],
    own: usize,
    height: usize,
) {
    let count = half.boundary.len();
    let rest = height - own;
    for (j, child) in child.chunks_exact(count.max(1)).enumerate() {
        let column = half.in_parent[j] as usize;
        let rows = &half.in_parent[j..];
        if column < own {
            let target = &mut panel[column * height..(column + 1) * height];
            for (&row, value) in rows.iter().zip(&child[j..]) {
                target[row as usize] += value;
            }
        } else {
            let target = &mut update[(column - own) * rest..(column - own + 1) * rest];
            for (&row, value) in rows.iter().zip(&child[j..]) {
                target[row as usize - own] += value;
            }
        }
    }
}

/// `work` on both halves of `front`, in two threads when they are large.
fn both<T: Send>(front: &Front, work: impl Fn(usize, &Front) -> T + Sync) -> Vec<T> {
    match front.halves.as_slice() {
        [before, after] if front.subtree.len() > WORTH_A_THREAD => {
            let (before, after) = rayon::join(|| work(0, before), || work(1, after));
            vec![before, after]
        }
        halves => halves
            .iter()
            .enumerate()
            .map(|(i, half)| work(i, half))
            .collect(),
    }
}

/// Solves with L: `values` are those of the front's subtree; gives what its boundary receives.
fn forward(front: &Front, columns: &Columns, values: &mut [f64]) -> Vec<f64> {
    let (below, own) = values.split_at_mut(values.len() - front.own);
    let received = both_with(front, below, |i, half, values| {
        forward(half, &columns.halves[i], values)
    });
    let mut local = vec![0.0; front.size()];
    local[..front.own].copy_from_slice(own);
    for (half, received) in front.halves.iter().zip(received) {
        for (&row, value) in half.in_parent.iter().zip(received) {
            local[row as usize] += value;
        }
    }
    dense::forward(&columns.panel, front.own, &mut local);
    own.copy_from_slice(&local[..front.own]);
    local.split_off(front.own)
}

/// Solves with the transpose of L; `known` are the values of the front's boundary.
fn backward(front: &Front, columns: &Columns, values: &mut [f64], known: &[f64]) {
    let (below, own) = values.split_at_mut(values.len() - front.own);
    let mut local = [own, known].concat();
    dense::backward(&columns.panel, front.own, &mut local);
    own.copy_from_slice(&local[..front.own]);
    both_with(front, below, |i, half, values| {
        let known: Vec<f64> = half
            .in_parent
            .iter()
            .map(|&row| local[row as usize])
            .collect();
        backward(half, &columns.halves[i], values, &known);
    });
}

/// `work` on both halves of `front` with their share of `values`.
fn both_with<T: Send>(
    front: &Front,
    values: &mut [f64],
    work: impl Fn(usize, &Front, &mut [f64]) -> T + Sync,
) -> Vec<T> {
    let [before, after] = front.halves.as_slice() else {
        return Vec::new();
    };
    let (first, second) = values.split_at_mut(before.subtree.len());
    let (first, second) = if front.subtree.len() > WORTH_A_THREAD {
        rayon::join(|| work(0, before, first), || work(1, after, second))
    } else {
        (work(0, before, first), work(1, after, second))
    };
    vec![first, second]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;
    use crate::raster::Image;
    use crate::solve::Stencil;

    #[test]
    fn the_solution_satisfies_its_system() {
        let mut random = Seed(3).random();
        for (width, height, share) in [(1, 1, 1.0), (9, 4, 0.7), (70, 50, 0.9), (90, 40, 1.0)] {
            let pixels = (0..width * height).map(|_| random.between(0.0, 1.0) <= share);
            let mask = Image::from_pixels(width, height, pixels.collect());
            for stencil in [Stencil::Laplacian, Stencil::Bilaplacian] {
                let system = GridSystem::new(&mask, stencil);
                let right: Vec<f64> = (0..system.len())
                    .map(|_| random.between(-1.0, 1.0))
                    .collect();
                let factor = Factor::new(&system, &Cancel::new()).unwrap();
                let product = system.product(&factor.solution(&right));
                for (product, right) in product.iter().zip(&right) {
                    assert!((product - right).abs() < 1e-8, "{product} {right}");
                }
            }
        }
    }

    #[test]
    fn a_cancelled_factorisation_gives_nothing() {
        let system = GridSystem::new(&Image::filled(30, 30, true), Stencil::Laplacian);
        let cancel = Cancel::new();
        cancel.cancel();
        assert!(Factor::new(&system, &cancel).is_err());
    }
}
