//! The colour of a picture between its pixels.

use crate::raster::{Image, Premultiplied};

/// The premultiplied colour of `image` at (`x`, `y`), 0 to 255 a channel, bilinear between pixel
/// centres; transparent outside.
#[inline(always)]
pub(super) fn bilinear(image: &Image<Premultiplied>, x: f32, y: f32) -> [f32; 4] {
    let (left, top) = (x.floor(), y.floor());
    let (column, row) = (left as i32, top as i32);
    let (width, height) = (image.width() as i32, image.height() as i32);
    // NaN becomes 0 in the cast and is sampled there: no position is ever out of bounds.
    if column < -1 || row < -1 || column >= width || row >= height {
        return [0.0; 4];
    }
    let (s, t) = (x - left, y - top);
    let corners = if column >= 0 && row >= 0 && column + 1 < width && row + 1 < height {
        let index = row as usize * width as usize + column as usize;
        let pixels = image.pixels();
        let below = index + width as usize;
        [
            pixels[index],
            pixels[index + 1],
            pixels[below],
            pixels[below + 1],
        ]
    } else {
        let at = |dx: i32, dy: i32| {
            let (x, y) = (i64::from(column + dx), i64::from(row + dy));
            image.get(x, y).unwrap_or_default()
        };
        [at(0, 0), at(1, 0), at(0, 1), at(1, 1)]
    };
    let mut colour = [0.0; 4];
    for (channel, value) in colour.iter_mut().enumerate() {
        let [a, b, c, d] = corners.map(|corner| f32::from(corner.0[channel]));
        let upper = a + (b - a) * s;
        let lower = c + (d - c) * s;
        *value = upper + (lower - upper) * t;
    }
    colour
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_are_exact_and_the_outside_is_transparent() {
        let pixels = vec![Premultiplied([8, 0, 0, 255]), Premultiplied([4, 0, 0, 255])];
        let image = Image::from_pixels(2, 1, pixels);
        assert_eq!(bilinear(&image, 0.0, 0.0), [8.0, 0.0, 0.0, 255.0]);
        assert_eq!(bilinear(&image, 0.5, 0.0), [6.0, 0.0, 0.0, 255.0]);
        assert_eq!(bilinear(&image, 1.5, 0.0), [2.0, 0.0, 0.0, 127.5]);
        assert_eq!(bilinear(&image, 0.0, -0.5), [4.0, 0.0, 0.0, 127.5]);
        assert_eq!(bilinear(&image, 2.0, 0.0), [0.0; 4]);
    }
}
