//! How like its exemplar a texture is, and how much it repeats itself, in numbers.

use super::texture::Texture;
use crate::base::Seed;
use crate::raster::{Image, Mask, Straight};
use rayon::prelude::*;

/// Side of the windows that are compared, pixels.
const WINDOW: usize = 7;
/// Directions onto which windows are projected.
const DIRECTIONS: usize = 64;
/// Quantiles at which projections are compared.
const QUANTILES: usize = 512;

/// The sliced Wasserstein distance between the 7×7 windows of two pictures, root mean square in
/// 8-bit steps: windows are projected onto 64 fixed random directions of unit length, and sorted
/// projections are compared quantile by quantile (Rabin, Peyré, Delon & Bernot 2011). Only windows
/// that lie inside the masks count (`None`: all); infinite when there is none.
///
/// 0 for a picture and itself; two crops of one foliage are some steps apart.
pub fn patch_distance(
    (a, a_mask): (&Image<Straight>, Option<&Mask>),
    (b, b_mask): (&Image<Straight>, Option<&Mask>),
) -> f64 {
    let (a_corners, b_corners) = (corners(a, a_mask), corners(b, b_mask));
    if a_corners.is_empty() || b_corners.is_empty() {
        return f64::INFINITY;
    }
    let sums: Vec<f64> = (0..DIRECTIONS)
        .into_par_iter()
        .map(|number| {
            let direction = direction(number as u64);
            let a = quantiles(a, &a_corners, &direction);
            let b = quantiles(b, &b_corners, &direction);
            let squares = a
                .iter()
                .zip(&b)
                .map(|(p, q)| f64::from(p - q) * f64::from(p - q));
            squares.sum::<f64>() / QUANTILES as f64
        })
        .collect();
    (sums.iter().sum::<f64>() / DIRECTIONS as f64).sqrt()
}

/// Upper left corners of the windows inside the mask.
fn corners(image: &Image<Straight>, mask: Option<&Mask>) -> Vec<(u32, u32)> {
    let side = WINDOW as u32;
    let (width, height) = (image.width(), image.height());
    let inside = |x: u32, y: u32| {
        mask.is_none_or(|mask| (y..y + side).all(|y| (x..x + side).all(|x| mask.at(x, y))))
    };
    (0..(height + 1).saturating_sub(side))
        .flat_map(|y| (0..(width + 1).saturating_sub(side)).map(move |x| (x, y)))
        .filter(|&(x, y)| inside(x, y))
        .collect()
}

/// A direction of unit length in the space of windows.
fn direction(number: u64) -> [f32; WINDOW * WINDOW * 3] {
    let mut random = Seed(0x5eed).derive("direction", number).random();
    // Sums of uniform numbers are nearly normal, so directions are nearly uniform.
    let values: [f64; WINDOW * WINDOW * 3] =
        std::array::from_fn(|_| (0..4).map(|_| random.unit() - 0.5).sum());
    let length = values.iter().map(|value| value * value).sum::<f64>().sqrt();
    values.map(|value| (value / length) as f32)
}

/// Evenly spaced quantiles of the projections of all windows.
fn quantiles(
    image: &Image<Straight>,
    corners: &[(u32, u32)],
    direction: &[f32; WINDOW * WINDOW * 3],
) -> Vec<f32> {
    let mut projections: Vec<f32> = corners
        .iter()
        .map(|&(x, y)| {
            let mut sum = 0.0;
            for (dy, weights) in (0..).zip(direction.chunks_exact(WINDOW * 3)) {
                let row = &image.row(y + dy)[x as usize..x as usize + WINDOW];
                for (pixel, weights) in row.iter().zip(weights.chunks_exact(3)) {
                    for (value, weight) in pixel.0.iter().zip(weights) {
                        sum += f32::from(*value) * weight;
                    }
                }
            }
            sum
        })
        .collect();
    projections.sort_unstable_by(f32::total_cmp);
    let at = |i: usize| projections[(2 * i + 1) * projections.len() / (2 * QUANTILES)];
    (0..QUANTILES).map(at).collect()
}

/// The share of a texture's pixels that stand in a square of `side` pixels which occurs a second
/// time in the texture, pixel by pixel from the same place of the photograph.
pub fn repeated_share(texture: &Texture, side: u32) -> f64 {
    let sources = &texture.sources;
    let (width, height) = (sources.width(), sources.height());
    if width < side || height < side {
        return 0.0;
    }
    // Runs of continued pixels to the left give squares that are one piece.
    let follows = |a: Option<[u32; 2]>, b: Option<[u32; 2]>, step: [u32; 2]| {
        a.zip(b)
            .is_some_and(|(a, b)| b == [a[0] + step[0], a[1] + step[1]])
    };
    let mut whole = vec![0u32; (width * height) as usize];
    for y in 0..height {
        for x in 0..width {
            let at = |x: u32, y: u32| (y * width + x) as usize;
            let here = sources.at(x, y);
            whole[at(x, y)] = match here {
                None => 0,
                Some(_) if x == 0 || y == 0 => 1,
                Some(_) => {
                    let joined = |u: u32, v: u32, step| match follows(sources.at(u, v), here, step)
                    {
                        true => whole[at(u, v)],
                        false => 0,
                    };
                    let left = joined(x - 1, y, [1, 0]);
                    let above = joined(x, y - 1, [0, 1]);
                    let corner = joined(x - 1, y - 1, [1, 1]);
                    1 + left.min(above).min(corner)
                }
            };
        }
    }
    let squares: Vec<(u32, u32, [u32; 2])> = (0..width * height)
        .filter(|&i| whole[i as usize] >= side)
        .filter_map(|i| Some((i % width, i / width, sources.at(i % width, i / width)?)))
        .collect();
    let mut keys: Vec<[u32; 2]> = squares.iter().map(|&(_, _, source)| source).collect();
    keys.sort_unstable();
    let mut repeated = Image::filled(width, height, false);
    for &(x, y, source) in &squares {
        let first = keys.partition_point(|key| *key < source);
        if keys.get(first + 1) == Some(&source) {
            for row in y + 1 - side..=y {
                repeated.row_mut(row)[(x + 1 - side) as usize..=x as usize].fill(true);
            }
        }
    }
    repeated.count() as f64 / f64::from(width * height)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(seed: u64, low: f64, high: f64) -> Image<Straight> {
        let mut random = Seed(seed).random();
        let pixels = (0..60 * 60).map(|_| {
            let value = random.between(low, high) as u8;
            Straight([value, value, value, 255])
        });
        Image::from_pixels(60, 60, pixels.collect())
    }

    #[test]
    fn like_pictures_are_near_and_others_far() {
        let (a, b, c) = (
            noise(1, 0.0, 200.0),
            noise(2, 0.0, 200.0),
            noise(3, 80.0, 120.0),
        );
        assert_eq!(patch_distance((&a, None), (&a, None)), 0.0);
        let near = patch_distance((&a, None), (&b, None));
        let far = patch_distance((&a, None), (&c, None));
        assert!(near * 5.0 < far, "{near} {far}");
        let nothing = Image::filled(60, 60, false);
        assert!(patch_distance((&a, Some(&nothing)), (&b, None)).is_infinite());
    }

    #[test]
    fn squares_that_occur_twice_are_counted() {
        // Two columns of 8 pixels from the same place, and 4 columns from elsewhere.
        let source = |x: u32, y: u32| Some([if x < 16 { x % 8 } else { x + 50 }, y]);
        let sources = (0..20 * 8).map(|i| source(i % 20, i / 20)).collect();
        let texture = Texture {
            image: Image::filled(20, 8, Straight::default()),
            sources: Image::from_pixels(20, 8, sources),
        };
        assert_eq!(repeated_share(&texture, 8), 16.0 / 20.0);
        assert_eq!(repeated_share(&texture, 4), 16.0 / 20.0);
        assert_eq!(repeated_share(&texture, 9), 0.0);
    }
}
