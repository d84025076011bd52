//! Taking the large-scale light out of an exemplar.
//!
//! One side of a crown is in the sun, its underside is dark, and its top may be more yellow. A
//! texture that goes round the tree cannot keep that: it would become a patchwork. Each channel of
//! each pixel is divided by the channel's mean around it, to a power: 0 leaves the picture alone, 1
//! makes every large neighbourhood equal. Local contrast, which is what foliage is, stays in
//! proportion.
//!
//! The mean is taken over foliage only, on a coarse grid, by three passes of a box (nearly a
//! Gaussian), and interpolated between the cells.

use crate::raster::Mask;

/// Side of a cell of the coarse grid, pixels: far below the scale that is taken out.
const CELL: usize = 8;

/// The width of the neighbourhood as a share of the crown's size (the square root of its area).
/// Smaller, and clumps of leaves lose their shape; larger, and the gradient stays.
const RADIUS_SHARE: f64 = 0.11;

/// Largest change of a channel: more shows the noise and the compression of deep shade.
const LARGEST_GAIN: f32 = 1.9;

/// Added to both means before one is divided by the other, 8-bit steps: the least channel of a deep
/// green is nearly 0, and its ratios mean nothing.
const FLOOR: f32 = 10.0;

/// The large-scale light of an exemplar: what its colours are multiplied by to even it out.
#[derive(Debug, Clone)]
pub(super) struct Light {
    /// The mean around each cell of the grid.
    around: Vec<[f32; 3]>,
    columns: usize,
    rows: usize,
    /// The mean of all.
    mean: [f32; 3],
    amount: f32,
}

impl Light {
    /// The light over the `usable` pixels of `colors` (0 … 255, rows of `usable`); `amount`, 0 … 1, of
    /// it is to be taken out.
    pub(super) fn of(colors: &[[f32; 3]], usable: &Mask, amount: f32) -> Self {
        let (width, height) = (usable.width() as usize, usable.height() as usize);
        let (columns, rows) = (width.div_ceil(CELL), height.div_ceil(CELL));
        // Sums of red, green and blue, and the number of pixels.
        let mut cells = vec![[0.0f32; 4]; columns * rows];
        for (index, [r, g, b]) in colors.iter().enumerate() {
            if usable.pixels()[index] {
                let cell = &mut cells[index / width / CELL * columns + index % width / CELL];
                *cell = added(*cell, [*r, *g, *b, 1.0]);
            }
        }
        let mut total = [0.0f64; 4];
        for cell in &cells {
            total = [0, 1, 2, 3].map(|i| total[i] + f64::from(cell[i]));
        }
        let count = total[3];
        let mean = [0, 1, 2].map(|i| (total[i] / count.max(1.0)) as f32);
        let radius = (RADIUS_SHARE * count.sqrt() / CELL as f64).round().max(1.0) as usize;
        if amount > 0.0 {
            for _ in 0..3 {
                cells = boxed(&cells, (columns, 1), (rows, columns), radius);
                cells = boxed(&cells, (rows, columns), (columns, 1), radius);
            }
        }
        let around = |cell: &[f32; 4]| match cell[3] > 0.0 {
            true => [0, 1, 2].map(|i| cell[i] / cell[3]),
            false => mean,
        };
        Self {
            around: cells.iter().map(around).collect(),
            columns,
            rows,
            mean,
            amount: amount.clamp(0.0, 1.0),
        }
    }

    /// What a colour at (x, y), pixels of the exemplar, is multiplied by.
    pub(super) fn gain(&self, x: f32, y: f32) -> [f32; 3] {
        if self.amount <= 0.0 {
            return [1.0; 3];
        }
        let local = interpolated(&self.around, self.columns, self.rows, x, y);
        [0, 1, 2].map(|i| {
            let ratio = (self.mean[i] + FLOOR) / (local[i] + FLOOR);
            libm::powf(ratio, self.amount).clamp(1.0 / LARGEST_GAIN, LARGEST_GAIN)
        })
    }

    /// Evens out `colors`, rows of `width`.
    pub(super) fn even_out(&self, colors: &mut [[f32; 3]], width: usize) {
        if self.amount <= 0.0 {
            return;
        }
        for (index, color) in colors.iter_mut().enumerate() {
            let gain = self.gain((index % width) as f32, (index / width) as f32);
            *color = [0, 1, 2].map(|i| (color[i] * gain[i]).min(255.0));
        }
    }
}

fn added(a: [f32; 4], b: [f32; 4]) -> [f32; 4] {
    [0, 1, 2, 3].map(|i| a[i] + b[i])
}

/// Sums over 2 · `radius` + 1 cells along one axis, whose length and stride are `along`, for all
/// lines of the other axis.
fn boxed(
    cells: &[[f32; 4]],
    (length, stride): (usize, usize),
    (lines, line_stride): (usize, usize),
    radius: usize,
) -> Vec<[f32; 4]> {
    let mut sums = vec![[0.0f32; 4]; cells.len()];
    for line in 0..lines {
        for i in 0..length {
            let range = i.saturating_sub(radius)..(i + radius + 1).min(length);
            let cell = |at: usize| cells[line * line_stride + at * stride];
            sums[line * line_stride + i * stride] =
                range.fold([0.0; 4], |sum, at| added(sum, cell(at)));
        }
    }
    sums
}

/// The value at (x, y), pixels, of a grid whose cells cover [`CELL`] pixels.
fn interpolated(cells: &[[f32; 3]], columns: usize, rows: usize, x: f32, y: f32) -> [f32; 3] {
    let place = |pixel: f32, count: usize| {
        let at = ((pixel + 0.5) / CELL as f32 - 0.5).clamp(0.0, (count - 1) as f32);
        let first = (at as usize).min(count.saturating_sub(2));
        (first, (first + 1).min(count - 1), at - first as f32)
    };
    let ((left, right, u), (top, bottom, v)) = (place(x, columns), place(y, rows));
    [0, 1, 2].map(|i| {
        let cell = |row: usize, column: usize| cells[row * columns + column][i];
        let across = |row: usize| cell(row, left) * (1.0 - u) + cell(row, right) * u;
        across(top) * (1.0 - v) + across(bottom) * v
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    /// Columns of alternating contrast under light that falls from left to right.
    fn lit() -> Vec<[f32; 3]> {
        (0..128 * 64)
            .map(|index| {
                let x = index % 128;
                let light = 200.0 - x as f32;
                [light * if x % 2 == 0 { 1.0 } else { 0.8 }; 3]
            })
            .collect()
    }

    fn mean(colors: &[[f32; 3]], columns: std::ops::Range<usize>) -> f32 {
        let row = &colors[128 * 32..128 * 33][columns];
        row.iter().map(|color| color[0]).sum::<f32>() / row.len() as f32
    }

    fn flatten(colors: &mut [[f32; 3]], usable: &Mask, amount: f32) {
        Light::of(colors, usable, amount).even_out(colors, usable.width() as usize);
    }

    #[test]
    fn light_is_evened_out_and_contrast_stays() {
        let mut colors = lit();
        flatten(&mut colors, &Image::filled(128, 64, true), 1.0);
        let (left, right) = (mean(&colors, 20..40), mean(&colors, 90..110));
        assert!((left / right - 1.0).abs() < 0.1, "{left} {right}");
        let at = 128 * 32 + 60;
        let contrast = colors[at + 1][0] / colors[at][0];
        assert!((contrast - 0.8).abs() < 0.02, "{contrast}");
    }

    #[test]
    fn nothing_changes_without_an_amount_or_without_foliage() {
        for (amount, usable) in [(0.0, true), (1.0, false)] {
            let mut colors = lit();
            flatten(&mut colors, &Image::filled(128, 64, usable), amount);
            assert_eq!(colors, lit());
        }
    }
}
