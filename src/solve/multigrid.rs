//! Solution of large systems: conjugate gradients, preconditioned by one multigrid cycle.
//!
//! The cycle works in single precision with two smoothing steps before and after; the iteration
//! around it in double precision. It needs 11 to 18 iterations at 256 to 1024 pixels; memory is
//! about 90 bytes a pixel of the shape's bounds.
//!
//! Sources: U. Trottenberg, C. Oosterlee, A. Schüller, *Multigrid*, 2001; O. Tatebe, *The multigrid
//! preconditioned conjugate gradient method*, 1993.
//!
//! Limits: a shape whose unknowns form lines one pixel wide has no good coarse grid. The iteration
//! may stall there; [`super::Solver`] then factorises.

use super::dense::{self, Packed};
use super::galerkin::{coarser, finest};
use super::grid::GridSystem;
use super::level::{Fields, Level, PAD, entries, for_rows, prolong, restricted, stencil_row};
use crate::base::{Cancel, Cancelled, Kernel, with_level_of_cpu};

/// Unknowns below which a level is solved directly.
const COARSEST: usize = 500;

/// Levels at most; each has a quarter of the pixels of the one above.
const MOST_LEVELS: usize = 12;

/// How far the error, measured by the preconditioner, is reduced. The largest error of a solution is
/// then near 1e-8 of its largest value.
const TOLERANCE: f64 = 1e-7;

/// Iterations after which the system is given up: four times what a difficult shape needs.
const MOST_ITERATIONS: usize = 80;

/// The hierarchy of grids for one system.
pub struct Multigrid {
    levels: Vec<Level>,
    /// Cholesky factor of the last level, column-major, and the places of its unknowns.
    coarsest: Vec<f64>,
    coarsest_places: Vec<usize>,
    /// Place on the finest level of each unknown.
    places: Vec<usize>,
}

/// What an iteration ended with.
pub struct Iterated {
    /// One value an unknown; `None` when the iteration stalled.
    pub solution: Option<Vec<f64>>,
    /// Iterations done.
    pub iterations: usize,
}

impl Multigrid {
    /// The hierarchy for `system`; `None` when it has no unknowns.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn new(system: &GridSystem, cancel: &Cancel) -> Result<Option<Self>, Cancelled> {
        if system.is_empty() {
            return Ok(None);
        }
        let (first, (left, top)) = finest(system);
        let place = |&(x, y): &(u32, u32)| {
            ((y - top) as usize + PAD) * first.width + (x - left) as usize + PAD
        };
        let places = system.pixels().iter().map(place).collect();
        let mut levels = vec![first];
        loop {
            cancel.check()?;
            let last = &levels[levels.len() - 1];
            let unknowns = last.unknown.iter().filter(|is| **is).count();
            if unknowns < COARSEST || levels.len() == MOST_LEVELS {
                break;
            }
            let next = coarser(last);
            // A shape of single lines may have no unknown on even pixels.
            if !next.unknown.contains(&true) {
                break;
            }
            levels.push(next);
        }
        let last = &levels[levels.len() - 1];
        let coarsest_places: Vec<usize> = (0..last.unknown.len())
            .filter(|&place| last.unknown[place])
            .collect();
        let coarsest = dense_factor(last, &coarsest_places, cancel)?;
        Ok(Some(Self {
            levels,
            coarsest,
            coarsest_places,
            places,
        }))
    }

    /// The solution for the right-hand side `right`, sought from `start`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn solution(
        &self,
        right: &[f64],
        start: Option<&[f64]>,
        cancel: &Cancel,
    ) -> Result<Iterated, Cancelled> {
        let mut fields: Vec<Fields> = self.levels.iter().map(Fields::new).collect();
        let mut x = self.field(start.unwrap_or(&[]));
        let mut residual = self.field(right);
        let mut product = vec![0.0; x.len()];
        let mut goal = None;
        if start.is_some() {
            self.preconditioned(&residual, &mut fields, cancel)?;
            goal = Some(self.dot_with(&residual, &fields[0].solution));
            self.product(&x, &mut product);
            for (residual, product) in residual.iter_mut().zip(&product) {
                *residual -= product;
            }
        }
        self.preconditioned(&residual, &mut fields, cancel)?;
        let mut energy = self.dot_with(&residual, &fields[0].solution);
        let goal = goal.unwrap_or(energy) * TOLERANCE * TOLERANCE;
        let mut direction: Vec<f64> = fields[0].solution.iter().map(|&v| v.into()).collect();
        let mut iterations = 0;
        while energy > goal && iterations < MOST_ITERATIONS {
            iterations += 1;
            self.product(&direction, &mut product);
            let step = energy / self.dot(&direction, &product);
            for_rows(&mut x, self.levels[0].width, |y, row| {
                self.add(row, step, &direction, y)
            });
            for_rows(&mut residual, self.levels[0].width, |y, row| {
                self.add(row, -step, &product, y)
            });
            self.preconditioned(&residual, &mut fields, cancel)?;
            let next = self.dot_with(&residual, &fields[0].solution);
            let keep = next / energy;
            energy = next;
            let solution = &fields[0].solution;
            let width = self.levels[0].width;
            for_rows(&mut direction, width, |y, row| {
                for (value, new) in row.iter_mut().zip(&solution[y * width..]) {
                    *value = keep * *value + f64::from(*new);
                }
            });
        }
        // Negative energy would mean that the cycle is indefinite, as rounding might make it.
        let is_solved = energy.abs() <= goal;
        let solution = || self.places.iter().map(|&place| x[place]).collect();
        Ok(Iterated {
            solution: is_solved.then(solution),
            iterations,
        })
    }

    /// `values` of the unknowns as a field; zero when there are none.
    fn field(&self, values: &[f64]) -> Vec<f64> {
        let mut field = vec![0.0; self.levels[0].mask.len()];
        for (&place, &value) in self.places.iter().zip(values) {
            field[place] = value;
        }
        field
    }

    #[inline(always)]
    fn add(&self, row: &mut [f64], factor: f64, field: &[f64], y: usize) {
        for (value, other) in row.iter_mut().zip(&field[y * self.levels[0].width..]) {
            *value += factor * other;
        }
    }

    /// Scalar product: the sums of the rows in their order.
    fn dot(&self, a: &[f64], b: &[f64]) -> f64 {
        self.row_sums(|x| a[x] * b[x])
    }

    fn dot_with(&self, a: &[f64], b: &[f32]) -> f64 {
        self.row_sums(|x| a[x] * f64::from(b[x]))
    }

    fn row_sums(&self, term: impl Fn(usize) -> f64) -> f64 {
        const LANES: usize = 8;
        let width = self.levels[0].width;
        let mut total = 0.0;
        for y in PAD..self.levels[0].height - PAD {
            let mut sums = [0.0; LANES];
            let (start, end) = (y * width, (y + 1) * width);
            for first in (start..end - LANES + 1).step_by(LANES) {
                for (lane, sum) in sums.iter_mut().enumerate() {
                    *sum += term(first + lane);
                }
            }
            let rest = width / LANES * LANES;
            total += sums.iter().sum::<f64>() + (start + rest..end).map(&term).sum::<f64>();
        }
        total
    }

    /// The matrix of the finest level times `field`, in double precision.
    fn product(&self, field: &[f64], out: &mut [f64]) {
        let level = &self.levels[0];
        let entries = entries::<f64>(&level.common, level.width);
        for_rows(out, level.width, |y, row| {
            with_level_of_cpu(ProductRow {
                entries: &entries,
                field,
                mask: &level.mask,
                start: y * level.width,
                row,
            });
        });
    }

    /// One cycle on `residual`; the result is the solution of the finest level's fields.
    fn preconditioned(
        &self,
        residual: &[f64],
        fields: &mut [Fields],
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        for (right, value) in fields[0].right.iter_mut().zip(residual) {
            *right = *value as f32;
        }
        self.cycle(0, fields, cancel)
    }

    fn cycle(
        &self,
        number: usize,
        fields: &mut [Fields],
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        cancel.check()?;
        let level = &self.levels[number];
        let [own, below @ ..] = fields else {
            unreachable!("fields for every level")
        };
        let [next, ..] = below else {
            self.solve_coarsest(own);
            return Ok(());
        };
        level.smooth(own, true);
        level.product(&own.solution, &mut own.product);
        let right = &own.right;
        for_rows(&mut own.product, level.width, |y, row| {
            for (value, right) in row.iter_mut().zip(&right[y * level.width..]) {
                *value = right - *value;
            }
        });
        let coarse = &self.levels[number + 1];
        restricted(&own.product, level.width, coarse, &mut next.right);
        self.cycle(number + 1, below, cancel)?;
        prolong(&below[0].solution, coarse.width, level, &mut own.solution);
        level.smooth(own, false);
        Ok(())
    }

    fn solve_coarsest(&self, fields: &mut Fields) {
        let places = &self.coarsest_places;
        let mut values: Vec<f64> = places.iter().map(|&p| fields.right[p].into()).collect();
        dense::forward(&self.coarsest, places.len(), &mut values);
        dense::backward(&self.coarsest, places.len(), &mut values);
        for (&place, value) in places.iter().zip(values) {
            fields.solution[place] = value as f32;
        }
    }
}

struct ProductRow<'a> {
    entries: &'a [(isize, f64)],
    field: &'a [f64],
    mask: &'a [f32],
    start: usize,
    row: &'a mut [f64],
}

impl Kernel for ProductRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        stencil_row(self.entries, self.field, self.start, self.row);
        let mask = &self.mask[self.start..self.start + self.row.len()];
        for (value, &mask) in self.row.iter_mut().zip(mask) {
            *value *= f64::from(mask);
        }
    }
}

/// The dense Cholesky factor of `level`'s matrix.
fn dense_factor(level: &Level, places: &[usize], cancel: &Cancel) -> Result<Vec<f64>, Cancelled> {
    let count = places.len();
    let mut matrix = vec![0.0; count * count];
    for (column, &place) in places.iter().enumerate() {
        for (step, coefficient) in entries::<f64>(level.row(place), level.width) {
            if let Ok(row) = places.binary_search(&place.wrapping_add_signed(step)) {
                matrix[column * count + row] += coefficient;
            }
        }
    }
    dense::factorize(&mut matrix, count, count, &mut Packed::default(), cancel)?;
    Ok(matrix)
}
