//! What a tree looks like, in a few numbers taken from its pixels when it is prepared.

use crate::geometry::{Point, signed_area};
use crate::raster::{Image, Mask, Premultiplied};
use crate::segment::{Label, Labels};
use imageproc::geometry::convex_hull;
use imageproc::point::Point as Pixel;

/// Share of the convex hull of the crown that its opaque pixels cover, 0 to 1: a dense crown has 0.8,
/// a bare tree 0.2. Without a crown that of the whole tree.
pub(super) fn fullness(mask: &Mask, labels: &Labels) -> f64 {
    let is_crown = |x: u32, y: u32| labels.at(x, y) == Label::Crown;
    let crown = |x: u32, y: u32| mask.at(x, y) && is_crown(x, y);
    let (count, hull) = covered(mask, crown);
    if count > 0.0 && hull > 0.0 {
        return (count / hull).min(1.0);
    }
    let (count, hull) = covered(mask, |x, y| mask.at(x, y));
    (count / hull.max(1.0)).min(1.0)
}

/// How many pixels of `mask` are `wanted`, and the area of their convex hull.
fn covered(mask: &Mask, wanted: impl Fn(u32, u32) -> bool) -> (f64, f64) {
    let mut count = 0u32;
    let mut ends = Vec::new();
    for y in 0..mask.height() {
        let mut row = (0..mask.width()).filter(|&x| wanted(x, y));
        let Some(first) = row.next() else { continue };
        let (inner, last) = row.fold((1, first), |(count, _), x| (count + 1, x));
        count += inner;
        // The pixels' corners, so that a single row has an area too.
        for (x, y) in [(first, y), (last + 1, y), (first, y + 1), (last + 1, y + 1)] {
            ends.push(Pixel::new(x as i32, y as i32));
        }
    }
    if ends.is_empty() {
        return (0.0, 0.0);
    }
    let hull: Vec<Point> = convex_hull(ends)
        .iter()
        .map(|p| Point::new(f64::from(p.x), f64::from(p.y)))
        .collect();
    (f64::from(count), signed_area(&hull).abs())
}

/// Distances at which pixels are compared, for pictures of 1,024 pixels.
const LAGS_AT_1024: [u32; 7] = [1, 2, 4, 8, 16, 32, 64];

/// Only every third pixel of every third row is looked at.
const STRIDE: usize = 3;

/// How coarse the foliage is, as a share of the picture's side: the distance at which two pixels of
/// it differ half as much as they do far apart.
pub(super) fn texture(image: &Image<Premultiplied>, mask: &Mask, labels: &Labels) -> f64 {
    let size = image.width();
    let mut lags: Vec<u32> = LAGS_AT_1024
        .iter()
        .map(|lag| (lag * size / 1024).max(1))
        .collect();
    lags.dedup();
    let differences: Vec<f64> = lags
        .iter()
        .map(|&lag| difference_at(image, mask, labels, lag))
        .collect();
    let half = 0.5 * differences.iter().copied().fold(0.0, f64::max);
    let mut before = (0.0, 0.0);
    for (&lag, &difference) in lags.iter().zip(&differences) {
        if difference >= half && difference > before.1 {
            let (lag_before, difference_before) = before;
            let share = (half - difference_before) / (difference - difference_before);
            let lag = lag_before + (f64::from(lag) - lag_before) * share.clamp(0.0, 1.0);
            return lag / f64::from(size);
        }
        before = (f64::from(lag), difference);
    }
    f64::from(lags[0]) / f64::from(size)
}

/// Mean square difference of the lightness of opaque crown pixels `lag` apart.
fn difference_at(image: &Image<Premultiplied>, mask: &Mask, labels: &Labels, lag: u32) -> f64 {
    let light = |x: u32, y: u32| {
        let [r, g, b, _] = image.at(x, y).0;
        2 * i64::from(r) + 7 * i64::from(g) + i64::from(b)
    };
    let counts = |x: u32, y: u32| mask.at(x, y) && labels.at(x, y) == Label::Crown;
    let (mut sum, mut count) = (0i64, 0i64);
    let (width, height) = (image.width(), image.height());
    for y in (0..height).step_by(STRIDE) {
        for x in (0..width).step_by(STRIDE).filter(|&x| counts(x, y)) {
            for (x2, y2) in [(x + lag, y), (x, y + lag)] {
                if x2 < width && y2 < height && counts(x2, y2) {
                    let difference = light(x, y) - light(x2, y2);
                    sum += difference * difference;
                    count += 1;
                }
            }
        }
    }
    sum as f64 / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all_crown(size: u32) -> Labels {
        Image::filled(size, size, Label::Crown)
    }

    #[test]
    fn a_full_square_is_full_and_a_cross_is_not() {
        let square = Image::filled(8, 8, true);
        assert!((fullness(&square, &all_crown(8)) - 1.0).abs() < 1e-9);
        let mut cross = Image::filled(9, 9, false);
        for i in 0..9 {
            cross.set(4, i, true);
            cross.set(i, 4, true);
        }
        // 17 pixels; the hull is the octagon of 81 − 4·8.
        assert!((fullness(&cross, &all_crown(9)) - 17.0 / 49.0).abs() < 1e-9);
    }

    #[test]
    fn coarser_stripes_are_coarser() {
        let stripes = |width: u32| {
            let pixels = (0..256 * 256).map(|i| {
                let value = [200, 20][((i % 256) / width % 2) as usize];
                Premultiplied([value, value, value, 255])
            });
            Image::from_pixels(256, 256, pixels.collect())
        };
        let mask = Image::filled(256, 256, true);
        let [fine, coarse] = [2, 8].map(|w| texture(&stripes(w), &mask, &all_crown(256)));
        assert!(coarse > 2.0 * fine, "{fine} {coarse}");
    }
}
