//! Dense parts of the factorisation: Cholesky of the first columns of a symmetric matrix, and
//! triangular solves with them.
//!
//! Matrices are column-major; of symmetric ones only the lower triangle counts. The factorisation
//! halves its columns until [`NARROW`] are left, so nearly all work is the product in
//! [`subtract_product`], which packs its operand into tiles of [`ROWS`] × [`COLUMNS`].
//!
//! Source of the tiling: K. Goto, R. van de Geijn, *Anatomy of high-performance matrix
//! multiplication*, 2008.

use crate::base::{Cancel, Cancelled, Kernel, with_level_of_cpu};

/// Rows of a tile: two AVX-512 registers, four of AVX2.
const ROWS: usize = 16;

/// Columns of a tile. With [`ROWS`], eight AVX-512 sums are under way at once, which hides the time
/// an addition takes.
const COLUMNS: usize = 4;

/// Columns that are factorised one by one; fewer make more small products, more make the slow part
/// larger.
const NARROW: usize = 8;

/// Columns of the operand that are packed at once: a tile's share stays in the first-level cache.
const DEPTH: usize = 128;

/// Columns that a triangular solve takes at once.
const GROUP: usize = 4;

/// Buffers for packed operands, to be used again.
#[derive(Default)]
pub(super) struct Packed {
    rows: Vec<f64>,
    columns: Vec<f64>,
}

/// Factorises the `own` columns of `panel`, `height` rows each: afterwards they hold L. Leaves
/// alone what lies above the diagonal, which may hold anything.
///
/// # Panics
/// When the matrix is not positive definite, which no [`super::GridSystem`] is.
pub(super) fn factorize(
    panel: &mut [f64],
    height: usize,
    own: usize,
    packed: &mut Packed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    factorize_columns(panel, height, 0, own, packed, cancel)
}

/// Factorises `count` columns, of which the first is column `first` of the whole.
fn factorize_columns(
    columns: &mut [f64],
    height: usize,
    first: usize,
    count: usize,
    packed: &mut Packed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    if count <= NARROW {
        with_level_of_cpu(Narrow {
            columns,
            height,
            first,
            count,
        });
        return Ok(());
    }
    cancel.check()?;
    // A multiple of the tile, so that few tiles are half empty.
    let left = (count / 2).next_multiple_of(NARROW);
    let (done, rest) = columns.split_at_mut(left * height);
    factorize_columns(done, height, first, left, packed, cancel)?;
    let from = first + left;
    subtract_product(
        done,
        height,
        from,
        rest,
        height,
        from,
        count - left,
        packed,
        cancel,
    )?;
    factorize_columns(rest, height, from, count - left, packed, cancel)
}

struct Narrow<'a> {
    columns: &'a mut [f64],
    height: usize,
    first: usize,
    count: usize,
}

impl Kernel for Narrow<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        for j in 0..self.count {
            let (done, rest) = self.columns.split_at_mut((j + 1) * self.height);
            let diagonal = self.first + j;
            let column = &mut done[j * self.height + diagonal..];
            assert!(column[0] > 0.0, "a grid system is positive definite");
            let inverse = 1.0 / column[0].sqrt();
            for value in column.iter_mut() {
                *value *= inverse;
            }
            for (k, other) in rest
                .chunks_exact_mut(self.height)
                .take(self.count - j - 1)
                .enumerate()
            {
                let row = k + 1;
                let factor = column[row];
                for (value, &below) in other[diagonal + row..].iter_mut().zip(&column[row..]) {
                    *value -= below * factor;
                }
            }
        }
    }
}

/// Subtracts L·Lᵀ, L being rows `from..height` of `operand`, from the lower triangle of the matrix
/// whose corner is row `at` of the `count` first columns of `target`, each `target_height` long.
#[expect(clippy::too_many_arguments, reason = "the shape of a matrix product")]
pub(super) fn subtract_product(
    operand: &[f64],
    height: usize,
    from: usize,
    target: &mut [f64],
    target_height: usize,
    at: usize,
    count: usize,
    packed: &mut Packed,
    cancel: &Cancel,
) -> Result<(), Cancelled> {
    for operand in operand.chunks((DEPTH * height).max(1)) {
        cancel.check()?;
        with_level_of_cpu(Product {
            operand,
            height,
            from,
            target,
            target_height,
            at,
            count,
            packed,
        });
    }
    Ok(())
}

struct Product<'a> {
    operand: &'a [f64],
    height: usize,
    from: usize,
    target: &'a mut [f64],
    target_height: usize,
    at: usize,
    count: usize,
    packed: &'a mut Packed,
}

impl Kernel for Product<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let depth = self.operand.len() / self.height;
        let rows = self.height - self.from;
        let (operand, height, from) = (self.operand, self.height, self.from);
        pack::<ROWS>(operand, height, from, rows, &mut self.packed.rows);
        pack::<COLUMNS>(operand, height, from, self.count, &mut self.packed.columns);
        for (tile_x, b) in self
            .packed
            .columns
            .chunks_exact(COLUMNS * depth)
            .enumerate()
        {
            let x = tile_x * COLUMNS;
            let above = x / ROWS;
            let tiles = self.packed.rows.chunks_exact(ROWS * depth).enumerate();
            for (tile_y, a) in tiles.skip(above) {
                let y = tile_y * ROWS;
                let sums = tile(a, b);
                let height = ROWS.min(rows - y);
                for (j, sums) in sums.iter().enumerate().take(self.count - x) {
                    let start = (x + j) * self.target_height + self.at + y;
                    let column = &mut self.target[start..start + height];
                    for (value, sum) in column.iter_mut().zip(sums) {
                        *value -= sum;
                    }
                }
            }
        }
    }
}

/// Rows `from..from + rows` of `operand` in groups of `N`: column by column in each group, with
/// zeros where the last group is not full.
#[inline(always)]
fn pack<const N: usize>(
    operand: &[f64],
    height: usize,
    from: usize,
    rows: usize,
    packed: &mut Vec<f64>,
) {
    let depth = operand.len() / height;
    packed.clear();
    packed.resize(rows.div_ceil(N) * N * depth, 0.0);
    for (group, packed) in packed.chunks_exact_mut(N * depth).enumerate() {
        let first = from + group * N;
        let count = N.min(from + rows - first);
        for (column, packed) in operand.chunks_exact(height).zip(packed.chunks_exact_mut(N)) {
            packed[..count].copy_from_slice(&column[first..first + count]);
        }
    }
}

/// The product of two packed groups.
#[inline(always)]
fn tile(a: &[f64], b: &[f64]) -> [[f64; ROWS]; COLUMNS] {
    // Names, not an array of arrays: only so do the sums stay in registers.
    let zero = [0.0; ROWS / 2];
    let [mut s0, mut s1, mut s2, mut s3] = [zero; COLUMNS];
    let [mut t0, mut t1, mut t2, mut t3] = [zero; COLUMNS];
    let (a, _) = a.as_chunks::<{ ROWS / 2 }>();
    let (b, _) = b.as_chunks::<COLUMNS>();
    for (a, b) in a.as_chunks::<2>().0.iter().zip(b) {
        s0 = plus(s0, &a[0], b[0]);
        t0 = plus(t0, &a[1], b[0]);
        s1 = plus(s1, &a[0], b[1]);
        t1 = plus(t1, &a[1], b[1]);
        s2 = plus(s2, &a[0], b[2]);
        t2 = plus(t2, &a[1], b[2]);
        s3 = plus(s3, &a[0], b[3]);
        t3 = plus(t3, &a[1], b[3]);
    }
    let whole = |s: [f64; ROWS / 2], t: [f64; ROWS / 2]| {
        std::array::from_fn(|i| if i < ROWS / 2 { s[i] } else { t[i - ROWS / 2] })
    };
    [whole(s0, t0), whole(s1, t1), whole(s2, t2), whole(s3, t3)]
}

/// `sums` + `a` · `b`.
#[inline(always)]
fn plus(sums: [f64; ROWS / 2], a: &[f64; ROWS / 2], b: f64) -> [f64; ROWS / 2] {
    std::array::from_fn(|i| sums[i] + a[i] * b)
}

/// Solves L y = v for the first `own` values of `values` and takes what they contribute from the
/// rest, as long as a column of `panel` in all.
pub(super) fn forward(panel: &[f64], own: usize, values: &mut [f64]) {
    with_level_of_cpu(Forward { panel, own, values });
}

struct Forward<'a> {
    panel: &'a [f64],
    own: usize,
    values: &'a mut [f64],
}

impl Kernel for Forward<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let height = self.values.len();
        if self.own == 0 {
            return;
        }
        for (group, columns) in self.panel[..self.own * height]
            .chunks(GROUP * height)
            .enumerate()
        {
            let first = group * GROUP;
            let count = columns.len() / height;
            for j in 0..count {
                let column = &columns[j * height..(j + 1) * height];
                let value = self.values[first + j] / column[first + j];
                self.values[first + j] = value;
                for i in j + 1..count {
                    self.values[first + i] -= column[first + i] * value;
                }
            }
            let below = first + count;
            let (known, rest) = self.values.split_at_mut(below);
            let known = &known[first..];
            let mut parts = columns.chunks_exact(height).map(|column| &column[below..]);
            if let (Some(a), Some(b), Some(c), Some(d)) =
                (parts.next(), parts.next(), parts.next(), parts.next())
            {
                for ((((value, a), b), c), d) in rest.iter_mut().zip(a).zip(b).zip(c).zip(d) {
                    *value -= (a * known[0] + b * known[1]) + (c * known[2] + d * known[3]);
                }
            } else {
                for (column, known) in columns.chunks_exact(height).zip(known) {
                    for (value, a) in rest.iter_mut().zip(&column[below..]) {
                        *value -= a * known;
                    }
                }
            }
        }
    }
}

/// Solves Lᵀ x = y for the first `own` values of `values`; the rest is known.
pub(super) fn backward(panel: &[f64], own: usize, values: &mut [f64]) {
    with_level_of_cpu(Backward { panel, own, values });
}

struct Backward<'a> {
    panel: &'a [f64],
    own: usize,
    values: &'a mut [f64],
}

impl Kernel for Backward<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let height = self.values.len();
        for j in (0..self.own).rev() {
            let column = &self.panel[j * height + j..(j + 1) * height];
            let sum = dot(&column[1..], &self.values[j + 1..]);
            self.values[j] = (self.values[j] - sum) / column[0];
        }
    }
}

/// The scalar product, in 32 interleaved sums: an order that every vector unit can follow.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 32;
    let mut sums = [0.0; LANES];
    let (mut a, mut b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    for (a, b) in (&mut a).zip(&mut b) {
        for i in 0..LANES {
            sums[i] += a[i] * b[i];
        }
    }
    let mut rest = 0.0;
    for (a, b) in a.remainder().iter().zip(b.remainder()) {
        rest += a * b;
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    /// A positive definite matrix of `n` rows, column-major.
    fn matrix(n: usize) -> Vec<f64> {
        let mut random = Seed(n as u64).random();
        let mut matrix = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..i {
                let value = random.between(-1.0, 1.0);
                matrix[j * n + i] = value;
                matrix[i * n + j] = value;
            }
            matrix[i * n + i] = n as f64;
        }
        matrix
    }

    #[test]
    fn a_matrix_is_the_product_of_its_factors_and_solves_agree() {
        for (n, own) in [(1, 1), (5, 3), (9, 9), (40, 17), (70, 61), (300, 270)] {
            let a = matrix(n);
            let mut panel = a[..own * n].to_vec();
            let (mut packed, cancel) = (Packed::default(), Cancel::new());
            factorize(&mut panel, n, own, &mut packed, &cancel).unwrap();
            let l = |i: usize, k: usize| panel[k * n + i];
            for j in 0..own {
                for i in j..n {
                    let product: f64 = (0..=j).map(|k| l(i, k) * l(j, k)).sum();
                    assert!((product - a[j * n + i]).abs() < 1e-10, "{n} {own} {i} {j}");
                }
            }
            if own == n {
                let mut x: Vec<f64> = (0..n).map(|i| i as f64).collect();
                let expected = x.clone();
                forward(&panel, own, &mut x);
                backward(&panel, own, &mut x);
                for i in 0..n {
                    let product: f64 = (0..n).map(|j| a[j * n + i] * x[j]).sum();
                    assert!((product - expected[i]).abs() < 1e-9);
                }
            }
        }
    }

    #[test]
    fn the_rest_of_the_matrix_becomes_the_schur_complement() {
        let (n, own) = (53, 20);
        let rest = n - own;
        let a = matrix(n);
        let mut panel = a[..own * n].to_vec();
        let (mut packed, cancel) = (Packed::default(), Cancel::new());
        factorize(&mut panel, n, own, &mut packed, &cancel).unwrap();
        let mut update = vec![0.0; rest * rest];
        subtract_product(
            &panel,
            n,
            own,
            &mut update,
            rest,
            0,
            rest,
            &mut packed,
            &cancel,
        )
        .unwrap();
        for j in 0..rest {
            for i in j..rest {
                let product: f64 = (0..own)
                    .map(|k| panel[k * n + own + i] * panel[k * n + own + j])
                    .sum();
                assert!((update[j * rest + i] + product).abs() < 1e-12);
            }
        }
    }
}
