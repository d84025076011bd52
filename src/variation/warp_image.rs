//! One picture, warped.
//!
//! The canvas is cut into bands of [`TILE`] rows that are worked on in parallel, tile by tile; each
//! pixel depends on nothing but its own position, so the number of threads never shows.

use super::mean_value::{LANES, Lanes};
use super::sampling::bilinear_lanes;
use super::warp::{TILE, Warp, WarpPrecision, WarpTile, needed_pixels};
use crate::base::{Cancel, Cancelled};
use crate::geometry::{Point, Polygon};
use crate::raster::{Image, Mask, Premultiplied};
use rayon::prelude::*;

/// `image` seen through `warp`, on a canvas of the size of `inside`: the pixels that belong to
/// `inside` take the colour of the source position that `warp` gives them, all others stay clear.
///
/// # Errors
/// [`Cancelled`] within a band of rows after `cancel` was raised.
pub fn warped(
    image: &Image<Premultiplied>,
    warp: &Warp,
    inside: &Mask,
    precision: WarpPrecision,
    cancel: &Cancel,
) -> Result<Image<Premultiplied>, Cancelled> {
    let clear = Premultiplied::default();
    let mut canvas = Image::filled(inside.width(), inside.height(), clear);
    let width = inside.width() as usize;
    canvas
        .pixels_mut()
        .par_chunks_mut(width * TILE)
        .enumerate()
        .try_for_each_init(WarpTile::new, |tile, (band, pixels)| {
            cancel.check()?;
            let top = band * TILE;
            match precision {
                WarpPrecision::Exact => warp_band_exactly(image, warp, inside, top, pixels),
                WarpPrecision::Interpolated => {
                    warp_band(image, warp, inside, top, pixels, tile);
                }
            }
            Ok(())
        })?;
    Ok(canvas)
}

/// Fills the rows from `top` on, `pixels`, with interpolated positions.
fn warp_band(
    image: &Image<Premultiplied>,
    warp: &Warp,
    inside: &Mask,
    top: usize,
    pixels: &mut [Premultiplied],
    tile: &mut WarpTile,
) {
    let width = inside.width() as usize;
    for left in (0..width).step_by(TILE) {
        let needed = needed_pixels(inside, left, top);
        if needed == [0; TILE] {
            continue;
        }
        warp.fill_tile(tile, left, top, &needed, WarpPrecision::Interpolated);
        for (row, line) in pixels.chunks_mut(width).enumerate() {
            let (x, y) = tile.row(row);
            for first in (0..TILE).step_by(LANES) {
                let group =
                    |values: &[f32]| -> Lanes { std::array::from_fn(|i| values[first + i]) };
                let colors = bilinear_lanes(image, &group(x), &group(y));
                for lane in (0..LANES).filter(|lane| needed[row] >> (first + lane) & 1 == 1) {
                    line[left + first + lane] = rounded(colors.map(|channel| channel[lane]));
                }
            }
        }
    }
}

/// The same in double precision.
fn warp_band_exactly(
    image: &Image<Premultiplied>,
    warp: &Warp,
    inside: &Mask,
    top: usize,
    pixels: &mut [Premultiplied],
) {
    let width = inside.width() as usize;
    for (row, line) in pixels.chunks_mut(width).enumerate() {
        let y = top + row;
        for (x, pixel) in line.iter_mut().enumerate() {
            if inside.at(x as u32, y as u32) {
                let source = warp.position(Point::new(x as f64, y as f64));
                *pixel = precise(image, source);
            }
        }
    }
}

/// A colour with each channel rounded to the nearest whole number.
#[inline(always)]
fn rounded(colour: [f32; 4]) -> Premultiplied {
    Premultiplied(colour.map(|channel| (channel + 0.5) as u8))
}

/// The colour of `image` at a position in double precision, rounded; clear outside the picture and
/// where a coordinate is not a number.
fn precise(image: &Image<Premultiplied>, position: Point) -> Premultiplied {
    let corner = position.floor();
    let (u, v) = (position.x - corner.x, position.y - corner.y);
    // Infinite and other far values end at the ends of i64's range, where there are no pixels.
    let (x, y) = (corner.x as i64, corner.y as i64);
    let at = |dx: i64, dy: i64| image.get(x.saturating_add(dx), y.saturating_add(dy));
    let corners = [at(0, 0), at(1, 0), at(0, 1), at(1, 1)].map(Option::unwrap_or_default);
    let mut colour = [0; 4];
    for (channel, value) in colour.iter_mut().enumerate() {
        let [a, b, c, d] = corners.map(|pixel| f64::from(pixel.0[channel]));
        let (upper, lower) = (a + (b - a) * u, c + (d - c) * u);
        // NaN becomes 0.
        *value = (upper + (lower - upper) * v + 0.5) as u8;
    }
    Premultiplied(colour)
}

/// The pixels of a canvas whose centres are inside `polygons` by the even–odd rule: inside the
/// outer one and not in a hole. Of two polygons with a common edge each pixel is in one at most.
///
/// ```
/// use boscage::geometry::Point;
/// use boscage::variation::inside_polygons;
/// let square = [(0.5, 0.5), (0.5, 2.5), (2.5, 2.5), (2.5, 0.5)].map(Point::from).to_vec();
/// let mask = inside_polygons(&[square], 4, 4);
/// assert_eq!(mask.count(), 4);
/// assert!(mask.at(1, 1) && mask.at(2, 2));
/// ```
pub fn inside_polygons(polygons: &[Polygon], width: u32, height: u32) -> Mask {
    let mut mask = Image::filled(width, height, false);
    let mut crossings = Vec::new();
    for row in 0..height {
        let y = f64::from(row);
        crossings.clear();
        for polygon in polygons {
            let before = polygon.iter().cycle().skip(polygon.len().saturating_sub(1));
            let edges = polygon.iter().zip(before);
            let crossing = edges.filter(|(a, b)| (a.y > y) != (b.y > y));
            crossings.extend(crossing.map(|(a, b)| (b.x - a.x) * (y - a.y) / (b.y - a.y) + a.x));
        }
        crossings.sort_by(f64::total_cmp);
        // A pixel is inside when an odd number of crossings lies to its right.
        for pair in crossings.chunks_exact(2) {
            let column = |x: f64| x.ceil().clamp(0.0, f64::from(width)) as usize;
            mask.row_mut(row)[column(pair[0])..column(pair[1])].fill(true);
        }
    }
    mask
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::contains;
    use crate::variation::Cage;

    fn polygon(points: &[(f64, f64)]) -> Polygon {
        points.iter().copied().map(Point::from).collect()
    }

    fn checker(width: u32, height: u32) -> Image<Premultiplied> {
        let pixels = (0..width * height).map(|i| {
            let (x, y) = (i % width, i / width);
            Premultiplied([(x * 7) as u8, (y * 5) as u8, ((x ^ y) & 1) as u8 * 200, 255])
        });
        Image::from_pixels(width, height, pixels.collect())
    }

    #[test]
    fn equal_cages_copy_what_is_inside() {
        let image = checker(70, 45);
        let shape = polygon(&[
            (3.2, 2.1),
            (8.0, 41.3),
            (60.7, 40.0),
            (30.0, 22.0),
            (65.1, 4.4),
        ]);
        let cage = Cage::new(std::slice::from_ref(&shape)).unwrap();
        let inside = inside_polygons(&[shape], 70, 45);
        let warp = Warp::new(&cage, &cage, 1).unwrap();
        let cancel = Cancel::new();
        let exact = warped(&image, &warp, &inside, WarpPrecision::Exact, &cancel).unwrap();
        for y in 0..45 {
            for x in 0..70 {
                let expected = match inside.at(x, y) {
                    true => image.at(x, y),
                    false => Premultiplied::default(),
                };
                assert_eq!(exact.at(x, y), expected, "{x}, {y}");
            }
        }
    }

    #[test]
    fn a_shift_is_a_shift_in_both_precisions() {
        let image = checker(64, 64);
        let target = polygon(&[(10.5, 10.5), (10.5, 50.5), (50.5, 50.5), (50.5, 10.5)]);
        let source: Polygon = target.iter().map(|p| *p + Point::new(-3.0, 5.0)).collect();
        let inside = inside_polygons(std::slice::from_ref(&target), 64, 64);
        let cages = [target, source].map(|shape| Cage::new(&[shape]).unwrap());
        let warp = Warp::new(&cages[0], &cages[1], 1).unwrap();
        for precision in [WarpPrecision::Exact, WarpPrecision::Interpolated] {
            let moved = warped(&image, &warp, &inside, precision, &Cancel::new()).unwrap();
            for (x, y) in [(11, 11), (30, 30), (50, 50), (11, 50)] {
                assert_eq!(moved.at(x, y), image.at(x - 3, y + 5));
            }
            assert_eq!(moved.at(5, 5), Premultiplied::default());
        }
    }

    #[test]
    fn the_inside_of_many_shapes_is_that_of_the_point_test() {
        let shapes = [
            polygon(&[(1.0, 1.0), (1.0, 9.0), (5.0, 3.0), (9.0, 9.0), (9.0, 1.0)]),
            polygon(&[(-5.0, 2.5), (6.3, 30.0), (20.0, -4.0)]),
            polygon(&[(2.0, 2.0), (8.0, 8.0), (8.0, 2.0), (2.0, 8.0)]),
        ];
        for shape in shapes {
            let mask = inside_polygons(std::slice::from_ref(&shape), 12, 11);
            for y in 0..11 {
                for x in 0..12 {
                    let point = Point::new(f64::from(x), f64::from(y));
                    assert_eq!(mask.at(x, y), contains(&shape, point), "{point}");
                }
            }
        }
    }

    #[test]
    fn both_precisions_sample_alike_inside_at_the_edge_and_beyond() {
        let image = checker(5, 4);
        for step in 0..100 {
            let (x, y) = (-1.5 + f64::from(step) * 0.08, 5.0 - f64::from(step) * 0.07);
            let lanes = bilinear_lanes(&image, &[x as f32; LANES], &[y as f32; LANES]);
            let single = rounded(lanes.map(|channel| channel[0])).0;
            let double = precise(&image, Point::new(x, y)).0;
            let near = single.iter().zip(double).all(|(a, b)| a.abs_diff(b) <= 1);
            assert!(near, "{x}, {y}: {single:?} {double:?}");
        }
        for odd in [f64::NAN, f64::INFINITY, -1e300] {
            assert_eq!(precise(&image, Point::new(odd, 1.0)).alpha(), 0);
        }
    }

    /// The polygons `dst` and `src` of the reference warp, where the folder of references is there.
    fn reference_cage() -> Option<[Polygon; 2]> {
        let data = std::env::var("BOSCAGE_DATA").unwrap_or("../shared/data".to_owned());
        let folder = std::env::var("BOSCAGE_ORACLE").unwrap_or(format!("{data}/../oracle"));
        let Ok(text) = std::fs::read(format!("{folder}/in/cage_100.json")) else {
            println!("{folder} is not there: nothing is compared");
            return None;
        };
        let json: serde_json::Value = serde_json::from_slice(&text).unwrap();
        Some(["dst", "src"].map(|key| {
            let points: Vec<[f64; 2]> = serde_json::from_value(json[key].clone()).unwrap();
            points.into_iter().map(Point::from).collect()
        }))
    }

    #[test]
    fn no_pixel_of_the_reference_warp_is_off_by_a_quarter_pixel() {
        let Some([target, source]) = reference_cage() else {
            return;
        };
        let inside = inside_polygons(std::slice::from_ref(&target), 1024, 1024);
        let cages = [target, source].map(|shape| Cage::new(&[shape]).unwrap());
        let warp = Warp::new(&cages[0], &cages[1], 1).unwrap();
        let mut tile = WarpTile::new();
        let mut worst = 0.0f64;
        let origins = (0..1024).step_by(TILE);
        for (left, top) in origins
            .clone()
            .flat_map(|y| origins.clone().map(move |x| (x, y)))
        {
            let needed = needed_pixels(&inside, left, top);
            let precision = WarpPrecision::Interpolated;
            warp.fill_tile(&mut tile, left, top, &needed, precision);
            for (row, bits) in needed.iter().enumerate() {
                let (x, y) = tile.row(row);
                for column in (0..TILE).filter(|column| bits >> column & 1 == 1) {
                    let found = Point::new(f64::from(x[column]), f64::from(y[column]));
                    let at = Point::new((left + column) as f64, (top + row) as f64);
                    worst = worst.max(warp.position(at).distance(found));
                }
            }
        }
        println!("interpolated positions are off by {worst:.3} px at most");
        assert!(worst < 0.25, "{worst} px");
    }

    #[test]
    fn a_raised_flag_stops_it() {
        let cage = Cage::new(&[polygon(&[(0.0, 0.0), (0.0, 9.0), (9.0, 0.0)])]).unwrap();
        let warp = Warp::new(&cage, &cage, 1).unwrap();
        let cancel = Cancel::new();
        cancel.cancel();
        let inside = Image::filled(9, 9, true);
        let result = warped(
            &checker(9, 9),
            &warp,
            &inside,
            WarpPrecision::Exact,
            &cancel,
        );
        assert_eq!(result, Err(Cancelled));
    }
}
