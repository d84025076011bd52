//! The texels of a cubemap as one closed grid: what lies beyond the edge of a face, and smoothing
//! that knows no edges.
//!
//! The cube's surface is unfolded: a column beyond an edge is the neighbouring face's first column,
//! texel for texel, so that every texel has exactly four neighbours and neighbourhood is mutual.
//! ([`Cubemap::beyond`] follows directions instead, which is right for sampling but pairs texels
//! unevenly.) Distances are those along the cube's surface, in texels: a texel near a corner covers
//! about a fifth of the solid angle of one in the middle, and smoothing shrinks with it, as the
//! features of a picture painted on the cube do.

use super::{CubeFace, Cubemap, Image};
use rayon::prelude::*;

/// The texel that lies at (`x`, `y`) of `face` when its neighbours are unfolded into its plane.
///
/// At most one of `x` and `y` may be outside 0 … `size` − 1, by `size` at most; beyond a corner
/// there is nothing.
///
/// ```
/// use boscage::raster::{CubeFace, folded};
/// assert_eq!(folded(CubeFace::PosZ, 8, 3, 8), (CubeFace::PosX, 0, 3));
/// assert_eq!(folded(CubeFace::PosZ, 5, -1, 8), (CubeFace::PosY, 5, 7));
/// ```
pub fn folded(face: CubeFace, x: i64, y: i64, size: u32) -> (CubeFace, u32, u32) {
    let n = i64::from(size);
    let inside = |i: i64| (0..n).contains(&i);
    if inside(x) && inside(y) {
        return (face, x as u32, y as u32);
    }
    // In half texels from the middle of the face, so that all is exact.
    let centre = |i: i64| (2 * i + 1 - n) as f64;
    let edge = n as f64;
    let (mut u, mut v, mut out) = (centre(x), centre(y), edge);
    if inside(y) {
        out = 2.0 * edge - u.abs();
        u = edge.copysign(u);
    } else {
        out -= v.abs() - edge;
        v = edge.copysign(v);
    }
    let [right, down, outward] = face.axes();
    let (there, u, v) = CubeFace::of(right * u + down * v + outward * out);
    let texel = |u: f64| ((u * edge + edge - 1.0) / 2.0).round() as u32;
    (there, texel(u), texel(v))
}

/// A face with one more row and column on each side, taken from its neighbours; the four corners,
/// which do not exist, are the means of the texels on both their sides.
pub(super) fn framed(map: &Cubemap<f32>, face: CubeFace) -> Image<f32> {
    let n = map.size();
    let mut frame = Image::filled(n + 2, n + 2, 0.0);
    for y in 0..n {
        frame.row_mut(y + 1)[1..=n as usize].copy_from_slice(map.face(face).row(y));
    }
    let beyond = |x: i64, y: i64| {
        let (there, x, y) = folded(face, x, y, n);
        map.face(there).at(x, y)
    };
    let end = i64::from(n);
    for i in 0..end {
        let at = i as u32 + 1;
        frame.set(0, at, beyond(-1, i));
        frame.set(n + 1, at, beyond(end, i));
        frame.set(at, 0, beyond(i, -1));
        frame.set(at, n + 1, beyond(i, end));
    }
    for (x, beside_x) in [(0, 1), (n + 1, n)] {
        for (y, beside_y) in [(0, 1), (n + 1, n)] {
            let mean = 0.5 * (frame.at(beside_x, y) + frame.at(x, beside_y));
            frame.set(x, y, mean);
        }
    }
    frame
}

/// `map` smoothed as by a Gaussian of standard deviation `sigma`, in texels along the cube's surface;
/// no step and no crease appears at edges or corners, and the mean is kept.
///
/// Steps of diffusion on a map that is halved until `sigma` is about two of its texels, then doubled
/// with linear weights. The width of the kernel is right to some hundredths of `sigma`. Sides that
/// cannot be halved cost more: time grows with `sigma` squared there.
pub fn smoothed_cubemap(map: &Cubemap<f32>, sigma: f64) -> Cubemap<f32> {
    /// Below this many texels at the coarse level the grid would show through the doubling.
    const COARSE_SIGMA: f64 = 2.0;
    /// Variance of the steps from one level to the next and back, in coarse texels: a box of two
    /// fine texels (1/16) and a linear tent over them (about 3/16).
    const VARIANCE_OF_LEVEL: f64 = 0.25;
    let size = map.size();
    if sigma >= 2.0 * COARSE_SIGMA && size.is_multiple_of(2) && size >= 8 {
        let rest = (0.25 * sigma * sigma - VARIANCE_OF_LEVEL).max(0.0);
        return doubled(&smoothed_cubemap(&halved(map), rest.sqrt()));
    }
    diffused(map, sigma * sigma)
}

/// Explicit steps of the heat equation until each texel has spread to `variance`, in texels².
fn diffused(map: &Cubemap<f32>, variance: f64) -> Cubemap<f32> {
    /// Variance of one step at most: 2 w with w = 0.2, which smooths every frequency.
    const MOST: f64 = 0.4;
    let steps = (variance / MOST).ceil() as u32;
    if steps == 0 {
        return map.clone();
    }
    let w = (variance / f64::from(steps) / 2.0) as f32;
    (0..steps).fold(map.clone(), |map, _| {
        per_face(|face| diffused_once(&framed(&map, face), w))
    })
}

fn diffused_once(frame: &Image<f32>, w: f32) -> Image<f32> {
    let n = frame.width() - 2;
    let mut face = Image::filled(n, n, 0.0);
    for y in 0..n {
        let (above, here, below) = (frame.row(y), frame.row(y + 1), frame.row(y + 2));
        let columns = n as usize;
        let (above, below) = (&above[1..=columns], &below[1..=columns]);
        let (left, right) = (&here[..columns], &here[2..]);
        let here = &here[1..=columns];
        for (x, texel) in face.row_mut(y).iter_mut().enumerate() {
            let around = (above[x] + below[x]) + (left[x] + right[x]);
            *texel = here[x] + w * (around - 4.0 * here[x]);
        }
    }
    face
}

/// Half the size: the means of 2×2 texels.
fn halved(map: &Cubemap<f32>) -> Cubemap<f32> {
    per_face(|face| {
        let fine = map.face(face);
        let n = fine.width() / 2;
        let mut coarse = Image::filled(n, n, 0.0);
        for y in 0..n {
            let (upper, lower) = (fine.row(2 * y), fine.row(2 * y + 1));
            for (x, texel) in coarse.row_mut(y).iter_mut().enumerate() {
                let sum = (upper[2 * x] + upper[2 * x + 1]) + (lower[2 * x] + lower[2 * x + 1]);
                *texel = 0.25 * sum;
            }
        }
        coarse
    })
}

/// Twice the size, with linear weights.
fn doubled(map: &Cubemap<f32>) -> Cubemap<f32> {
    per_face(|face| {
        let frame = framed(map, face);
        let n = 2 * map.size();
        let mut fine = Image::filled(n, n, 0.0);
        for y in 0..n {
            // The nearer of the two coarse rows and columns weighs 3/4.
            let near = frame.row(y / 2 + 1);
            let far = frame.row(if y % 2 == 0 { y / 2 } else { y / 2 + 2 });
            let column = |x: usize| 0.75 * near[x] + 0.25 * far[x];
            for (x, texel) in fine.row_mut(y).iter_mut().enumerate() {
                let beside = if x % 2 == 0 { x / 2 } else { x / 2 + 2 };
                *texel = 0.75 * column(x / 2 + 1) + 0.25 * column(beside);
            }
        }
        fine
    })
}

/// A cubemap whose faces are made side by side, each by a thread of its own where there are as many.
pub fn per_face<P: Copy + Send>(make: impl Fn(CubeFace) -> Image<P> + Sync) -> Cubemap<P> {
    let faces: Vec<Image<P>> = CubeFace::ALL.par_iter().map(|&face| make(face)).collect();
    let faces: [Image<P>; 6] = faces
        .try_into()
        .unwrap_or_else(|_| unreachable!("a cube has six faces"));
    Cubemap::from_faces(faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbourhood_is_mutual_and_everyone_has_four() {
        let n = 5u32;
        let mut seen = std::collections::BTreeMap::new();
        for face in CubeFace::ALL {
            for y in 0..i64::from(n) {
                for x in 0..i64::from(n) {
                    for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                        let (there, u, v) = folded(face, x + dx, y + dy, n);
                        let pair = [(face as u8, x as u32, y as u32), (there as u8, u, v)];
                        *seen.entry(pair).or_insert(0) += 1;
                    }
                }
            }
        }
        assert_eq!(seen.len(), 6 * 25 * 4);
        for ([a, b], count) in &seen {
            assert_eq!((*count, seen.get(&[*b, *a])), (1, Some(&1)));
        }
    }

    #[test]
    fn smoothing_keeps_the_mean_and_has_the_width_asked_for() {
        for sigma in [1.5, 3.0, 6.0, 9.0] {
            let mut map = Cubemap::filled(64, 0.0f32);
            map.face_mut(CubeFace::PosZ).set(31, 31, 1.0);
            let smooth = smoothed_cubemap(&map, sigma);
            let face = smooth.face(CubeFace::PosZ);
            let (mut sum, mut spread, mut mean) = (0.0, 0.0, 0.0);
            for y in 0..64 {
                for x in 0..64u32 {
                    let value = f64::from(face.at(x, y));
                    sum += value;
                    mean += value * f64::from(x);
                }
            }
            mean /= sum;
            for y in 0..64 {
                for x in 0..64u32 {
                    spread += f64::from(face.at(x, y)) * (f64::from(x) - mean).powi(2);
                }
            }
            let found = (spread / sum).sqrt();
            assert!((found / sigma - 1.0).abs() < 0.05, "{sigma}: {found}");
            let all: f64 = smooth
                .faces()
                .iter()
                .flat_map(|f| f.pixels())
                .map(|&v| f64::from(v))
                .sum();
            assert!((all - 1.0).abs() < 1e-4, "{sigma}: {all}");
        }
    }

    #[test]
    fn a_spot_on_an_edge_spreads_alike_to_both_sides() {
        let mut map = Cubemap::filled(32, 0.0f32);
        map.face_mut(CubeFace::PosZ).set(31, 16, 1.0);
        map.face_mut(CubeFace::PosX).set(0, 16, 1.0);
        let smooth = smoothed_cubemap(&map, 5.0);
        for i in 0..16 {
            let left = smooth.face(CubeFace::PosZ).at(31 - i, 16);
            let right = smooth.face(CubeFace::PosX).at(i, 16);
            assert!((left - right).abs() < 1e-6, "{i}: {left} {right}");
        }
    }
}
