//! The colour of a picture between its pixels.

use super::mean_value::{LANES, Lanes};
use crate::raster::{Image, Premultiplied};

/// The premultiplied colours of `image` at [`LANES`] places, 0 to 255, channel by channel: bilinear
/// between pixel centres; transparent outside.
#[inline(always)]
pub(super) fn bilinear_lanes(image: &Image<Premultiplied>, x: &Lanes, y: &Lanes) -> [Lanes; 4] {
    let (width, height) = (image.width(), image.height());
    let (mut s, mut t): (Lanes, Lanes) = ([0.0; LANES], [0.0; LANES]);
    let (mut columns, mut rows) = ([0i32; LANES], [0i32; LANES]);
    for lane in 0..LANES {
        let (left, top) = (x[lane].floor(), y[lane].floor());
        s[lane] = x[lane] - left;
        t[lane] = y[lane] - top;
        // NaN becomes 0 in the cast and is sampled there: no position is ever out of bounds.
        columns[lane] = left as i32;
        rows[lane] = top as i32;
    }
    let mut outside = 0;
    for lane in 0..LANES {
        // Negative numbers are large ones without their sign.
        outside |= u32::from(columns[lane] as u32 >= width - 1);
        outside |= u32::from(rows[lane] as u32 >= height - 1);
    }
    let corners = if outside == 0 {
        corners_inside(image, &columns, &rows)
    } else {
        corners_anywhere(image, &columns, &rows)
    };
    let mut colors = [[0.0; LANES]; 4];
    for (channel, color) in colors.iter_mut().enumerate() {
        for lane in 0..LANES {
            let a = value(corners[0][lane], channel);
            let b = value(corners[1][lane], channel);
            let c = value(corners[2][lane], channel);
            let d = value(corners[3][lane], channel);
            let upper = a + (b - a) * s[lane];
            let lower = c + (d - c) * s[lane];
            color[lane] = upper + (lower - upper) * t[lane];
        }
    }
    colors
}

/// One channel of a pixel.
#[inline(always)]
fn value(pixel: u32, channel: usize) -> f32 {
    (pixel >> (8 * channel) & 255) as i32 as f32
}

/// Four neighbouring pixels for each lane: upper left, upper right, lower left, lower right; each
/// with its red in the lowest byte.
type Corners = [[u32; LANES]; 4];

/// The pixels at and beside (column, row), which must all be inside.
#[inline(always)]
fn corners_inside(
    image: &Image<Premultiplied>,
    columns: &[i32; LANES],
    rows: &[i32; LANES],
) -> Corners {
    let width = image.width() as usize;
    let mut corners = [[0; LANES]; 4];
    for lane in 0..LANES {
        let index = rows[lane] as usize * width + columns[lane] as usize;
        let four = &image.pixels()[index..index + width + 2];
        corners[0][lane] = u32::from_le_bytes(four[0].0);
        corners[1][lane] = u32::from_le_bytes(four[1].0);
        corners[2][lane] = u32::from_le_bytes(four[width].0);
        corners[3][lane] = u32::from_le_bytes(four[width + 1].0);
    }
    corners
}

/// Likewise for pixels that may be outside, where all is transparent.
#[inline(never)]
fn corners_anywhere(
    image: &Image<Premultiplied>,
    columns: &[i32; LANES],
    rows: &[i32; LANES],
) -> Corners {
    let mut corners = [[0; LANES]; 4];
    for (number, corner) in (0i64..).zip(&mut corners) {
        for lane in 0..LANES {
            let column = i64::from(columns[lane]) + number % 2;
            let row = i64::from(rows[lane]) + number / 2;
            corner[lane] = u32::from_le_bytes(image.get(column, row).unwrap_or_default().0);
        }
    }
    corners
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
