//! One grid of the multigrid hierarchy, and the operations on it.
//!
//! Fields are rows of single-precision numbers with [`PAD`] empty pixels around the frame; they are
//! zero wherever there is no unknown. Rows of the matrix are 7 × 7 stencils: far from the border all
//! the same, near it each its own.
//!
//! Rows of pixels are shared out between threads; every number is made by one thread alone.

use rayon::prelude::*;
use std::ops::{AddAssign, Mul};

/// Empty pixels around the frame: more than a stencil or a transfer reaches.
pub(super) const PAD: usize = 4;

/// How far a stencil reaches, and its side.
pub(super) const REACH: usize = 3;
pub(super) const SIDE: usize = 2 * REACH + 1;

/// Coefficients of a row of the matrix: at (dx, dy) stands `[(dy + 3) * 7 + dx + 3]`.
pub(super) type Row = [f32; SIDE * SIDE];

/// Rows of pixels that a thread takes at once, and pixels from which on there are threads.
const ROWS_AT_ONCE: usize = 16;
const WORTH_THREADS: usize = 1 << 15;

/// Parts of the smoothed spectrum: from a sixth of the largest eigenvalue up.
const SPECTRUM: f32 = 6.0;

/// A grid with its matrix.
pub(super) struct Level {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) unknown: Vec<bool>,
    /// 1 where there is an unknown, 0 elsewhere.
    pub(super) mask: Vec<f32>,
    pub(super) inverse_diagonal: Vec<f32>,
    /// The row of every unknown far from the border.
    pub(super) common: Row,
    /// The other rows: place and coefficients, by ascending place.
    pub(super) special: Vec<(usize, Row)>,
    /// The number of the special row at a place, `u32::MAX` for a common one.
    pub(super) special_at: Vec<u32>,
    /// A bound of the largest eigenvalue of the matrix over its diagonal.
    pub(super) largest: f32,
}

/// The fields that one visit of a level needs.
#[derive(Default)]
pub(super) struct Fields {
    pub(super) solution: Vec<f32>,
    pub(super) right: Vec<f32>,
    pub(super) product: Vec<f32>,
    step: Vec<f32>,
}

impl Fields {
    pub(super) fn new(level: &Level) -> Self {
        let zero = vec![0.0; level.mask.len()];
        Self {
            solution: zero.clone(),
            right: zero.clone(),
            product: zero.clone(),
            step: zero,
        }
    }
}

/// Steps and coefficients of the entries of `row` that are not zero, filled up to groups of four.
pub(super) fn entries<T: From<f32>>(row: &Row, width: usize) -> Vec<(isize, T)> {
    let mut entries: Vec<(isize, T)> = (0..SIDE * SIDE)
        .filter(|&i| row[i] != 0.0)
        .map(|i| {
            let (dx, dy) = ((i % SIDE) as isize - 3, (i / SIDE) as isize - 3);
            (dy * width as isize + dx, T::from(row[i]))
        })
        .collect();
    while !entries.len().is_multiple_of(4) {
        entries.push((0, T::from(0.0)));
    }
    entries
}

/// `work` on every row inside the frame of `width` pixels: its number and its pixels in `out`.
pub(super) fn for_rows<T: Send>(
    out: &mut [T],
    width: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    let large = out.len() >= WORTH_THREADS;
    let count = out.len() / width;
    let inside = &mut out[PAD * width..(count - PAD) * width];
    let several = |(part, rows): (usize, &mut [T])| {
        for (i, row) in rows.chunks_exact_mut(width).enumerate() {
            work(PAD + part * ROWS_AT_ONCE + i, row);
        }
    };
    if large {
        inside
            .par_chunks_mut(ROWS_AT_ONCE * width)
            .enumerate()
            .for_each(several);
    } else {
        inside
            .chunks_mut(ROWS_AT_ONCE * width)
            .enumerate()
            .for_each(several);
    }
}

/// Row `y` of the common stencil's product with `field`.
#[inline(always)]
pub(super) fn stencil_row<T>(entries: &[(isize, T)], field: &[T], start: usize, out: &mut [T])
where
    T: Copy + Default + Mul<Output = T> + AddAssign + std::ops::Add<Output = T>,
{
    let inside = PAD..out.len() - PAD;
    let count = inside.len();
    let out = &mut out[inside];
    out.fill(T::default());
    for group in entries.as_chunks::<4>().0 {
        let from = |i: usize| {
            let first = (start + PAD).wrapping_add_signed(group[i].0);
            &field[first..first + count]
        };
        let [a, b, c, d] = [from(0), from(1), from(2), from(3)];
        let [ka, kb, kc, kd] = group.map(|entry| entry.1);
        for i in 0..count {
            out[i] += (a[i] * ka + b[i] * kb) + (c[i] * kc + d[i] * kd);
        }
    }
}

impl Level {
    /// The row of the matrix at `place`, which has an unknown.
    pub(super) fn row(&self, place: usize) -> &Row {
        match self.special_at[place] {
            u32::MAX => &self.common,
            number => &self.special[number as usize].1,
        }
    }

    /// The matrix times `field`.
    pub(super) fn product(&self, field: &[f32], out: &mut [f32]) {
        let entries = entries::<f32>(&self.common, self.width);
        for_rows(out, self.width, |y, row| {
            let start = y * self.width;
            crate::base::with_level_of_cpu(ProductRow {
                entries: &entries,
                field,
                mask: &self.mask,
                start,
                row,
            });
        });
        for (place, row) in &self.special {
            let mut sum = 0.0;
            for (dy, part) in row.as_chunks::<SIDE>().0.iter().enumerate() {
                let start = place + dy * self.width - REACH * self.width - REACH;
                for (value, coefficient) in field[start..start + SIDE].iter().zip(part) {
                    sum += value * coefficient;
                }
            }
            out[*place] = sum;
        }
    }

    /// Two steps of Chebyshev's iteration on the solution, from zero or from where it is.
    ///
    /// Source: M. Adams et al., *Parallel multigrid smoothing: polynomial versus Gauss–Seidel*, 2003.
    pub(super) fn smooth(&self, fields: &mut Fields, from_zero: bool) {
        let (high, low) = (self.largest, self.largest / SPECTRUM);
        let (middle, half) = ((high + low) / 2.0, (high - low) / 2.0);
        let ratio = middle / half;
        let first = 1.0 / ratio;
        let second = 1.0 / (2.0 * ratio - first);
        if from_zero {
            fields.solution.fill(0.0);
            fields.product.fill(0.0);
        } else {
            self.product(&fields.solution, &mut fields.product);
        }
        self.advance(fields, 0.0, 1.0 / middle);
        self.product(&fields.solution, &mut fields.product);
        self.advance(fields, second * first, 2.0 * second / half);
    }

    /// step = keep · step + scale · (right − product) / diagonal; solution += step.
    fn advance(&self, fields: &mut Fields, keep: f32, scale: f32) {
        let Fields {
            solution,
            right,
            product,
            step,
        } = fields;
        let (right, product) = (&*right, &*product);
        for_rows(step, self.width, |y, step| {
            let range = y * self.width..(y + 1) * self.width;
            let sources = right[range.clone()].iter().zip(&product[range.clone()]);
            for ((step, (right, product)), inverse) in step
                .iter_mut()
                .zip(sources)
                .zip(&self.inverse_diagonal[range])
            {
                *step = keep * *step + scale * inverse * (right - product);
            }
        });
        let step = &*step;
        for_rows(solution, self.width, |y, solution| {
            let step = &step[y * self.width..(y + 1) * self.width];
            for (value, step) in solution.iter_mut().zip(step) {
                *value += step;
            }
        });
    }
}

struct ProductRow<'a> {
    entries: &'a [(isize, f32)],
    field: &'a [f32],
    mask: &'a [f32],
    start: usize,
    row: &'a mut [f32],
}

impl crate::base::Kernel for ProductRow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        stencil_row(self.entries, self.field, self.start, self.row);
        let mask = &self.mask[self.start..self.start + self.row.len()];
        for (value, mask) in self.row.iter_mut().zip(mask) {
            *value *= mask;
        }
    }
}

/// Brings `fine` to the grid of half the size with the cubic B-spline's weights: 1, 4, 6, 4, 1
/// eighths along each axis.
pub(super) fn restricted(fine: &[f32], width: usize, coarse: &Level, out: &mut [f32]) {
    for_rows(out, coarse.width, |y, row| {
        let start = (2 * (y - PAD) + PAD) * width;
        let line = |dy: usize| &fine[start + dy * width - 2 * width..][..width];
        let [a, b, c, d, e] = [line(0), line(1), line(2), line(3), line(4)];
        let sums: Vec<f32> = (0..width)
            .map(|x| 0.125 * (a[x] + e[x]) + 0.5 * (b[x] + d[x]) + 0.75 * c[x])
            .collect();
        let mask = &coarse.mask[y * coarse.width..(y + 1) * coarse.width];
        for x in (PAD..coarse.width - PAD).filter(|&x| mask[x] != 0.0) {
            let s = &sums[2 * (x - PAD) + PAD - 2..][..5];
            row[x] = 0.125 * (s[0] + s[4]) + 0.5 * (s[1] + s[3]) + 0.75 * s[2];
        }
    });
}

/// Adds `coarse`, a field of `coarse_width`, to the solution of the grid of twice the size.
pub(super) fn prolong(coarse: &[f32], coarse_width: usize, fine: &Level, solution: &mut [f32]) {
    for_rows(solution, fine.width, |y, row| {
        let at = (y - PAD) / 2 + PAD;
        let line = |y: usize| &coarse[y * coarse_width..(y + 1) * coarse_width];
        let [before, here, after] = [line(at - 1), line(at), line(at + 1)];
        let is_odd = (y - PAD) % 2 == 1;
        let sums: Vec<f32> = (0..coarse_width)
            .map(|x| {
                if is_odd {
                    0.5 * (here[x] + after[x])
                } else {
                    0.125 * (before[x] + after[x]) + 0.75 * here[x]
                }
            })
            .collect();
        let mask = &fine.mask[y * fine.width..(y + 1) * fine.width];
        for x in (PAD..fine.width - PAD).step_by(2) {
            let s = &sums[(x - PAD) / 2 + PAD - 1..][..3];
            row[x] += mask[x] * (0.125 * (s[0] + s[2]) + 0.75 * s[1]);
            row[x + 1] += mask[x + 1] * (0.5 * (s[1] + s[2]));
        }
    });
}
