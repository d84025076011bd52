//! The colour of a picture between its pixels.

use super::mean_value::{LANES, Lanes};
use crate::raster::{Image, Premultiplied};

/// The premultiplied colours of `image` at [`LANES`] places, 0 to 255, channel by channel: bilinear
/// between pixel centres; transparent outside.
#[inline(always)]
pub(super) fn bilinear_lanes(image: &Image<Premultiplied>, x: &Lanes, y: &Lanes) -> [Lanes; 4] {
    let (width, height) = (image.width() as i32, image.height() as i32);
    let (mut s, mut t): (Lanes, Lanes) = ([0.0; LANES], [0.0; LANES]);
    let (mut columns, mut rows) = ([0i32; LANES], [0i32; LANES]);
    let mut all_inside = true;
    for lane in 0..LANES {
        let (left, top) = (x[lane].floor(), y[lane].floor());
        (s[lane], t[lane]) = (x[lane] - left, y[lane] - top);
        // NaN becomes 0 in the cast and is sampled there: no position is ever out of bounds.
        (columns[lane], rows[lane]) = (left as i32, top as i32);
        all_inside &= columns[lane] >= 0 && columns[lane] < width - 1;
        all_inside &= rows[lane] >= 0 && rows[lane] < height - 1;
    }
    let mut corners = [[0u32; LANES]; 4];
    for lane in 0..LANES {
        let four = if all_inside {
            let index = rows[lane] as usize * width as usize + columns[lane] as usize;
            let upper = &image.pixels()[index..index + 2];
            let lower = &image.pixels()[index + width as usize..index + width as usize + 2];
            [upper[0], upper[1], lower[0], lower[1]]
        } else {
            corners_anywhere(image, columns[lane], rows[lane])
        };
        for (corner, pixel) in corners.iter_mut().zip(four) {
            corner[lane] = u32::from_le_bytes(pixel.0);
        }
    }
    let mut colors = [[0.0; LANES]; 4];
    for (channel, color) in colors.iter_mut().enumerate() {
        for lane in 0..LANES {
            let value =
                |corner: usize| (corners[corner][lane] >> (8 * channel) & 255) as i32 as f32;
            let upper = value(0) + (value(1) - value(0)) * s[lane];
            let lower = value(2) + (value(3) - value(2)) * s[lane];
            color[lane] = upper + (lower - upper) * t[lane];
        }
    }
    colors
}

/// The four pixels from (`column`, `row`) on, which may be outside.
#[inline(never)]
fn corners_anywhere(image: &Image<Premultiplied>, column: i32, row: i32) -> [Premultiplied; 4] {
    let (column, row) = (i64::from(column), i64::from(row));
    let at = |dx: i64, dy: i64| image.get(column + dx, row + dy).unwrap_or_default();
    [at(0, 0), at(1, 0), at(0, 1), at(1, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_are_exact_and_the_outside_is_transparent() {
        let pixels = vec![Premultiplied([8, 0, 0, 255]), Premultiplied([4, 0, 0, 255])];
        let image = Image::from_pixels(2, 1, pixels);
        let bilinear =
            |x: f32, y: f32| bilinear_lanes(&image, &[x; LANES], &[y; LANES]).map(|c| c[3]);
        assert_eq!(bilinear(0.0, 0.0), [8.0, 0.0, 0.0, 255.0]);
        assert_eq!(bilinear(0.5, 0.0), [6.0, 0.0, 0.0, 255.0]);
        assert_eq!(bilinear(1.5, 0.0), [2.0, 0.0, 0.0, 127.5]);
        assert_eq!(bilinear(0.0, -0.5), [4.0, 0.0, 0.0, 127.5]);
        assert_eq!(bilinear(2.0, 0.0), [0.0; 4]);
    }
}
