//! Bringing coarse likelihoods to the edges of a picture: the guided filter.
//!
//! He, Sun & Tang, *Guided image filtering* (IEEE TPAMI 2013): in every window the likelihood is the
//! linear function of the picture's colours that fits best, so that it steps where the picture steps
//! and stays flat where that is flat. As in He & Sun, *Fast guided filter* (2015), the functions are
//! fitted on the reduced picture, which the likelihoods come from, and applied to the full one: that is
//! where edges get their place, and it costs one product a pixel.
//!
//! Departure: windows are weighted, so that what is clear has no say about what is not.

use super::letterbox::Letterbox;
use crate::raster::{Image, Straight};
use rayon::prelude::*;

/// Likelihoods that are filtered together.
pub(super) const PLANES: usize = 2;

/// How far a window reaches and how much of the picture's texture it ignores.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// Pixels of the reduced picture from its middle to its edge.
    pub(super) radius: usize,
    /// Variance of colour, of 1, below which there is no edge.
    pub(super) epsilon: f32,
}

/// For each plane the likelihood as a linear function of red, green, blue, and a constant.
pub(super) type Linear = [[f32; 4]; PLANES];

/// Sums over a window: weight, colours, products of colours, likelihoods, products of the two.
const SUMS: usize = 1 + 3 + 6 + PLANES + 3 * PLANES;

/// A function and, first, how much of the picture its window saw.
type Weighted = [f32; 1 + 4 * PLANES];

/// The function of each pixel of `guide`, whose fourth numbers are the weights.
pub(super) fn fitted(
    guide: &Image<[f32; 4]>,
    values: &Image<[f32; PLANES]>,
    window: Window,
) -> Image<Linear> {
    let (width, height) = (guide.width(), guide.height());
    let size = [width as usize, height as usize];
    let mut functions: Vec<Weighted> = Vec::with_capacity(guide.pixels().len());
    let moments_of = |y: usize, out: &mut Vec<[f32; SUMS]>| {
        let pixels = guide.row(y as u32).iter().zip(values.row(y as u32));
        out.extend(pixels.map(|(pixel, values)| moments(pixel, values)));
    };
    box_sums(size, window.radius, moments_of, |_, sums| {
        functions.extend(sums.iter().map(|sums| weighted(sums, window.epsilon)));
    });
    let mut linear = Vec::with_capacity(functions.len());
    let functions_of = |y: usize, out: &mut Vec<Weighted>| {
        out.extend_from_slice(&functions[y * size[0]..][..size[0]]);
    };
    box_sums(size, window.radius, functions_of, |y, sums| {
        let pixels = sums.iter().zip(values.row(y as u32));
        linear.extend(pixels.map(|(sums, values)| mean(sums, values)));
    });
    Image::from_pixels(width, height, linear)
}

/// What a pixel adds to the sums of the windows around it.
fn moments(&[r, g, b, weight]: &[f32; 4], values: &[f32; PLANES]) -> [f32; SUMS] {
    let colour = [r, g, b];
    let mut sums = [0.0f32; SUMS];
    sums[0] = weight;
    let mut next = 1;
    let mut add = |value: f32| {
        sums[next] = weight * value;
        next += 1;
    };
    colour.iter().for_each(|&c| add(c));
    for (i, a) in colour.iter().enumerate() {
        colour[i..].iter().for_each(|b| add(a * b));
    }
    values.iter().for_each(|&v| add(v));
    for value in values {
        colour.iter().for_each(|c| add(c * value));
    }
    sums
}

/// The function that fits in a window of these sums, times how much of the picture it saw.
fn weighted(sums: &[f32; SUMS], epsilon: f32) -> Weighted {
    let mut weighted = [0.0f32; 1 + 4 * PLANES];
    if sums[0] > 1e-3 {
        weighted[0] = sums[0];
        let function = function(sums, epsilon);
        for (own, value) in weighted[1..].iter_mut().zip(function.as_flattened()) {
            *own = sums[0] * value;
        }
    }
    weighted
}

/// The mean function of the windows that a pixel lies in; where they saw nothing, its own `values`.
fn mean(sums: &Weighted, values: &[f32; PLANES]) -> Linear {
    let mut linear = [[0.0; 4]; PLANES];
    for (plane, own) in linear.iter_mut().enumerate() {
        if sums[0] > 1e-3 {
            let from = 1 + 4 * plane;
            *own = [0, 1, 2, 3].map(|i| sums[from + i] / sums[0]);
        } else {
            own[3] = values[plane];
        }
    }
    linear
}

/// The least-squares fit in a window of these sums.
fn function(sums: &[f32; SUMS], epsilon: f32) -> Linear {
    let weight = f64::from(sums[0]);
    let mean = |i: usize| f64::from(sums[i]) / weight;
    let colour = [mean(1), mean(2), mean(3)];
    // Places of the products rr, rg, rb, gg, gb, bb.
    let covariance = |at: usize, i: usize, j: usize| mean(at) - colour[i] * colour[j];
    let e = f64::from(epsilon);
    let (rr, rg, rb) = (
        covariance(4, 0, 0) + e,
        covariance(5, 0, 1),
        covariance(6, 0, 2),
    );
    let (gg, gb, bb) = (
        covariance(7, 1, 1) + e,
        covariance(8, 1, 2),
        covariance(9, 2, 2) + e,
    );
    // Cofactors of the symmetric matrix.
    let (c00, c01, c02) = (gg * bb - gb * gb, rb * gb - rg * bb, rg * gb - rb * gg);
    let (c11, c12, c22) = (rr * bb - rb * rb, rb * rg - rr * gb, rr * gg - rg * rg);
    let determinant = rr * c00 + rg * c01 + rb * c02;
    let mut linear = [[0.0; 4]; PLANES];
    for (plane, own) in linear.iter_mut().enumerate() {
        let value = mean(10 + plane);
        let products = 10 + PLANES + 3 * plane;
        let [x, y, z] = [0, 1, 2].map(|i| mean(products + i) - colour[i] * value);
        let slope = [
            (c00 * x + c01 * y + c02 * z) / determinant,
            (c01 * x + c11 * y + c12 * z) / determinant,
            (c02 * x + c12 * y + c22 * z) / determinant,
        ];
        let at_mean: f64 = slope.iter().zip(colour).map(|(s, c)| s * c).sum();
        *own = [slope[0], slope[1], slope[2], value - at_mean].map(|number| number as f32);
    }
    linear
}

/// Tells `take` for each row, from the top, the sums over the square windows around its pixels, cut off at
/// the border of a picture of `size` (columns, rows), whose rows `row_of` appends to an empty list.
///
/// Only the rows under a window are kept: these sums are twenty numbers a pixel.
fn box_sums<const N: usize>(
    [width, height]: [usize; 2],
    radius: usize,
    row_of: impl Fn(usize, &mut Vec<[f32; N]>),
    mut take: impl FnMut(usize, &[[f32; N]]),
) {
    let mut columns = vec![[0.0f64; N]; width];
    // Sums along the rows, of those under the window and of the one that leaves it.
    let mut across = vec![vec![[0.0f32; N]; width]; 2 * radius + 2];
    let kept = across.len();
    let (mut row, mut sums) = (Vec::with_capacity(width), vec![[0.0f32; N]; width]);
    let add = |columns: &mut [[f64; N]], row: &[[f32; N]], sign: f64| {
        for (sums, values) in columns.iter_mut().zip(row) {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += sign * f64::from(*value);
            }
        }
    };
    for entering in 0..height + radius {
        if entering < height {
            row.clear();
            row_of(entering, &mut row);
            sums_along(&row, radius, &mut across[entering % kept]);
            add(&mut columns, &across[entering % kept], 1.0);
        }
        let Some(y) = entering.checked_sub(radius) else {
            continue;
        };
        if y > radius {
            add(&mut columns, &across[(y - radius - 1) % kept], -1.0);
        }
        for (own, sums) in sums.iter_mut().zip(&columns) {
            *own = sums.map(|sum| sum as f32);
        }
        take(y, &sums);
    }
}

/// The sums over a window along a row.
fn sums_along<const N: usize>(row: &[[f32; N]], radius: usize, out: &mut [[f32; N]]) {
    let width = row.len();
    let mut sums = [0.0f64; N];
    let add = |sums: &mut [f64; N], i: usize, sign: f64| {
        for (sum, value) in sums.iter_mut().zip(&row[i]) {
            *sum += sign * f64::from(*value);
        }
    };
    for i in 0..radius.min(width) {
        add(&mut sums, i, 1.0);
    }
    for (i, out) in out.iter_mut().enumerate() {
        if i + radius < width {
            add(&mut sums, i + radius, 1.0);
        }
        if i > radius {
            add(&mut sums, i - radius - 1, -1.0);
        }
        *out = sums.map(|sum| sum as f32);
    }
}

/// The likelihoods at the picture's own size, within the letterbox's crop: the functions, interpolated
/// linearly, of the picture's colours.
pub(super) fn applied(
    functions: &Image<Linear>,
    letterbox: &Letterbox,
    picture: &Image<Straight>,
) -> Image<[f32; PLANES]> {
    let crop = letterbox.crop;
    let mut out = vec![[0.0; PLANES]; crop.width as usize * crop.height as usize];
    let columns: Vec<(usize, f32)> = (crop.x..crop.x + crop.width)
        .map(|x| neighbours(letterbox.column(x), functions.width()))
        .collect();
    out.par_chunks_mut(crop.width as usize)
        .zip(crop.y..crop.y + crop.height)
        .for_each_init(Vec::new, |between, (out, y)| {
            let (upper, share) = neighbours(letterbox.row(y), functions.height());
            let lower = (upper + 1).min(functions.height() as usize - 1);
            let rows = functions.row(upper as u32).iter();
            let rows = rows.zip(functions.row(lower as u32));
            between.clear();
            between.extend(rows.map(|(a, b)| mixed(a, b, share)));
            let colours = &picture.row(y)[crop.x as usize..];
            for ((out, pixel), &(left, share)) in out.iter_mut().zip(colours).zip(&columns) {
                let right = (left + 1).min(between.len() - 1);
                let function = mixed(&between[left], &between[right], share);
                let [r, g, b, _] = pixel.0.map(|c| f32::from(c) / 255.0);
                *out = function.map(|f| f[0] * r + f[1] * g + f[2] * b + f[3]);
            }
        });
    Image::from_pixels(crop.width, crop.height, out)
}

/// The pixel before `place` and how far it is past that, within `count` pixels.
fn neighbours(place: f32, count: u32) -> (usize, f32) {
    let place = place.clamp(0.0, (count - 1) as f32);
    (place as usize, place - place.floor())
}

#[inline]
fn mixed(a: &Linear, b: &Linear, share: f32) -> Linear {
    let mut mixed = *a;
    let pairs = mixed.as_flattened_mut().iter_mut().zip(b.as_flattened());
    for (own, other) in pairs {
        *own += share * (other - *own);
    }
    mixed
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Rect;

    const WINDOW: Window = Window {
        radius: 2,
        epsilon: 1e-3,
    };

    #[test]
    fn box_sums_are_sums_over_boxes() {
        let image = Image::from_pixels(7, 5, (0..35).map(|i| [(i * i % 11) as f32]).collect());
        let mut sums = Vec::new();
        let rows = |y: usize, out: &mut Vec<[f32; 1]>| out.extend_from_slice(image.row(y as u32));
        box_sums([7, 5], 2, rows, |_, row| sums.extend_from_slice(row));
        let sums = Image::from_pixels(7, 5, sums);
        for (x, y) in [(0i64, 0i64), (3, 2), (6, 4), (1, 3)] {
            let window = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (x + dx, y + dy)));
            let expected: f32 = window
                .filter_map(|(x, y)| image.get(x, y))
                .map(|v| v[0])
                .sum();
            assert_eq!(sums.at(x as u32, y as u32)[0], expected);
        }
    }

    /// A picture of two colours with a step at column 17 of 32, and likelihoods on 8 columns whose step
    /// is blurred.
    #[test]
    fn a_blurred_step_comes_to_the_edge_of_the_picture() {
        let side = 32;
        let dark = Straight([60, 40, 30, 255]);
        let light = Straight([90, 160, 70, 255]);
        let pixels = (0..side * side).map(|i| if i % side < 17 { dark } else { light });
        let picture = Image::from_pixels(side, side, pixels.collect());
        let crop = Rect {
            x: 0,
            y: 0,
            width: side,
            height: side,
        };
        let letterbox = Letterbox::new(crop, 8, 8);
        let guide = letterbox.reduced(&picture);
        let blurred = [1.0, 1.0, 0.9, 0.7, 0.4, 0.1, 0.0, 0.0f32];
        let values = (0..64).map(|i| [blurred[i % 8], 1.0 - blurred[i % 8]]);
        let values = Image::from_pixels(8, 8, values.collect());
        let sharp = applied(&fitted(&guide, &values, WINDOW), &letterbox, &picture);
        for y in 0..side {
            let trunk = |x: u32| sharp.at(x, y)[0] > sharp.at(x, y)[1];
            assert!(trunk(16) && !trunk(17), "row {y}");
        }
    }

    #[test]
    fn a_flat_picture_only_smooths() {
        let guide = Image::filled(9, 9, [0.5, 0.5, 0.5, 1.0]);
        let mut values = Image::filled(9, 9, [0.0, 1.0]);
        values.set(4, 4, [1.0, 0.0]);
        let functions = fitted(&guide, &values, WINDOW);
        let [trunk, crown] = functions
            .at(4, 4)
            .map(|f| 0.5 * (f[0] + f[1] + f[2]) + f[3]);
        assert!(trunk > 0.0 && trunk < 0.1 && (trunk + crown - 1.0).abs() < 1e-4);
    }

    #[test]
    fn what_is_clear_has_no_say() {
        let mut guide = Image::filled(9, 9, [0.0, 0.0, 0.0, 0.0]);
        guide.set(4, 4, [0.2, 0.3, 0.4, 1.0]);
        let mut values = Image::filled(9, 9, [0.0, 0.0]);
        values.set(4, 4, [0.75, 0.25]);
        let function = fitted(&guide, &values, WINDOW).at(4, 4);
        let [trunk, _] = function.map(|f| 0.2 * f[0] + 0.3 * f[1] + 0.4 * f[2] + f[3]);
        assert!((trunk - 0.75).abs() < 1e-5);
    }
}
