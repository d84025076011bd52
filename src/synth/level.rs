//! One level of detail of an exemplar, laid out so that every window is a block of memory.
//!
//! Levels are blurred, not shrunk (a Gaussian stack, Lefebvre & Hoppe 2006): at level l the
//! neighbours of a pixel lie 2^l pixels away, so a coordinate can be any pixel of the photograph at
//! every level and nothing is lost between the levels. To have those neighbours side by side, the
//! pixels of the level are sorted by their remainders modulo 2^l into 4^l small pictures, each with
//! a border of [`BORDER`] pixels, stacked from top to bottom. A coordinate at a level is the index
//! of a pixel in this stack: one step right is + 1, one step down is + `stride`, at every level.

use rayon::prelude::*;

/// Half of the side of the windows that are compared, pixels.
pub(super) const RADIUS: usize = 3;

/// Pixels around each small picture. Steps from a usable pixel by at most this many stay inside the
/// small picture and its border.
const BORDER: usize = RADIUS;

/// A colour, 0 … 255 each; the fourth number is always 0 and makes rows of windows whole vectors.
pub(super) type Color = [i16; 4];

/// One level.
#[derive(Debug, Clone)]
pub(super) struct Level {
    /// Pixels between neighbours, a power of two.
    pub(super) step: usize,
    /// Index distance between a pixel and the one below.
    pub(super) stride: usize,
    /// Colours, small picture by small picture, and one more pixel at the end.
    pub(super) colors: Vec<Color>,
    /// Whether a pixel is foliage; never in borders.
    pub(super) usable: Vec<bool>,
    /// Rows of a small picture with its border.
    rows: usize,
    /// Size of the photograph.
    size: (usize, usize),
}

impl Level {
    /// The level of `step` of a picture of `size` pixels, already blurred.
    pub(super) fn new(
        blurred: &[[f32; 3]],
        usable: &[bool],
        size: (usize, usize),
        step: usize,
    ) -> Self {
        let stride = size.0.div_ceil(step) + 2 * BORDER;
        let rows = size.1.div_ceil(step) + 2 * BORDER;
        let mut level = Self {
            step,
            stride,
            colors: vec![[0; 4]; stride * rows * step * step],
            usable: vec![false; stride * rows * step * step],
            rows,
            size,
        };
        let mut colors = std::mem::take(&mut level.colors);
        let mut flags = std::mem::take(&mut level.usable);
        let lines = colors
            .par_chunks_mut(stride)
            .zip(flags.par_chunks_mut(stride));
        lines.enumerate().for_each(|(line, (colors, flags))| {
            for column in 0..stride {
                let (x, y) = level.place(line * stride + column);
                let inside = (0..size.0 as i64).contains(&x) && (0..size.1 as i64).contains(&y);
                let at = y.clamp(0, size.1 as i64 - 1) as usize * size.0
                    + x.clamp(0, size.0 as i64 - 1) as usize;
                let [r, g, b] = blurred[at].map(|value| (value + 0.5) as i16);
                colors[column] = [r, g, b, 0];
                let border = column < BORDER || column >= stride - BORDER;
                flags[column] = inside && !border && !level.in_border_row(line) && usable[at];
            }
        });
        // Windows are read in rows of whole vectors, one pixel longer than they are.
        colors.push([0; 4]);
        level.colors = colors;
        level.usable = flags;
        level
    }

    /// Takes back what `still_usable` (rows of the photograph) does not hold.
    pub(super) fn restrict(&mut self, still_usable: &[bool]) {
        for index in 0..self.usable.len() {
            if self.usable[index] {
                let (x, y) = self.place(index);
                self.usable[index] = still_usable[y as usize * self.size.0 + x as usize];
            }
        }
    }

    fn in_border_row(&self, line: usize) -> bool {
        let row = line % self.rows;
        row < BORDER || row >= self.rows - BORDER
    }

    /// Where pixel `index` lies in the photograph; outside of it for borders.
    #[inline]
    pub(super) fn place(&self, index: usize) -> (i64, i64) {
        let (line, column) = (index / self.stride, index % self.stride);
        let (phase, row) = (line / self.rows, line % self.rows);
        let along = |part: usize, phase: usize| {
            (part as i64 - BORDER as i64) * self.step as i64 + phase as i64
        };
        (
            along(column, phase % self.step),
            along(row, phase / self.step),
        )
    }

    /// The index of the photograph's pixel (x, y), which must be inside.
    #[inline]
    pub(super) fn index(&self, x: usize, y: usize) -> usize {
        let phase = y % self.step * self.step + x % self.step;
        let line = phase * self.rows + y / self.step + BORDER;
        line * self.stride + x / self.step + BORDER
    }

    /// The index `dx` steps right of and `dy` below `index`, if it is usable.
    #[inline]
    pub(super) fn moved(&self, index: u32, dx: i32, dy: i32) -> Option<u32> {
        let moved = i64::from(index) + i64::from(dy) * self.stride as i64 + i64::from(dx);
        let usable = self.usable.get(usize::try_from(moved).ok()?)?;
        usable.then_some(moved as u32)
    }

    /// Size of the photograph, pixels.
    pub(super) fn size(&self) -> (usize, usize) {
        self.size
    }
}

/// `colors` (rows of `width`) blurred by the binomial filter 1 4 6 4 1 with `spacing` pixels between
/// its taps, along both axes; pixels beyond the edge count as those at the edge.
pub(super) fn blurred(colors: &[[f32; 3]], width: usize, spacing: usize) -> Vec<[f32; 3]> {
    let height = colors.len() / width;
    let clamped = |i: usize, tap: usize, count: usize| {
        (i + tap * spacing)
            .saturating_sub(2 * spacing)
            .min(count - 1)
    };
    let mut across = vec![[0.0f32; 3]; colors.len()];
    across
        .par_chunks_mut(width)
        .enumerate()
        .for_each(|(y, row)| {
            let source = &colors[y * width..(y + 1) * width];
            for (x, sum) in row.iter_mut().enumerate() {
                *sum = weighted([0, 1, 2, 3, 4].map(|tap| source[clamped(x, tap, width)]));
            }
        });
    let mut down = vec![[0.0f32; 3]; colors.len()];
    down.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        let lines = [0, 1, 2, 3, 4].map(|tap| clamped(y, tap, height) * width);
        for (x, sum) in row.iter_mut().enumerate() {
            *sum = weighted(lines.map(|line| across[line + x]));
        }
    });
    down
}

#[inline]
fn weighted([a, b, c, d, e]: [[f32; 3]; 5]) -> [f32; 3] {
    [0, 1, 2].map(|i| (a[i] + e[i]) * 0.0625 + (b[i] + d[i]) * 0.25 + c[i] * 0.375)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_indices_are_inverse_and_steps_are_neighbours() {
        let size = (13, 10);
        let colors: Vec<[f32; 3]> = (0..130).map(|i| [i as f32, 0.0, 0.0]).collect();
        for step in [1, 2, 4] {
            let level = Level::new(&colors, &[true; 130], size, step);
            assert_eq!(level.usable.iter().filter(|&&usable| usable).count(), 130);
            for y in 0..10 {
                for x in 0..13 {
                    let index = level.index(x, y);
                    assert_eq!(level.place(index), (x as i64, y as i64));
                    assert_eq!(level.colors[index][0], (y * 13 + x) as i16);
                    let right = level.moved(index as u32, 1, 0);
                    assert_eq!(right.is_some(), x + step < 13);
                    if let Some(right) = right {
                        assert_eq!(level.place(right as usize), ((x + step) as i64, y as i64));
                    }
                    let above = level.moved(index as u32, 0, -1);
                    assert_eq!(above.is_some(), y >= step);
                }
            }
        }
    }

    #[test]
    fn blurring_keeps_flat_colours_and_spreads_a_point() {
        assert_eq!(blurred(&[[7.0; 3]; 30], 6, 2), vec![[7.0; 3]; 30]);
        let mut point = vec![[0.0; 3]; 81];
        point[40] = [256.0; 3];
        let spread = blurred(&point, 9, 2);
        assert_eq!(spread[40][0], 36.0);
        assert_eq!(spread[42][0], 24.0);
        assert_eq!(spread[41][0], 0.0);
    }
}
