//! Distances to a set of pixels, in two sweeps.
//!
//! The 3-4 chamfer (G. Borgefors, *Distance transformations in digital images*, 1986): steps to the
//! side cost 3, diagonal ones 4, so distances are in thirds of a pixel and within 8 % of Euclid's.

use crate::raster::{Image, Mask};

/// What a step to the side costs.
pub(super) const PIXEL: u32 = 3;

/// The distance of each pixel to the nearest one of `targets`, in thirds of a pixel; what lies beyond
/// the frame counts as a target when `beyond` is. Without any target distances are huge.
pub(super) fn chamfer(targets: &Mask, beyond: bool) -> Image<u32> {
    const FAR: u32 = u32::MAX / 2;
    let (width, height) = (targets.width() as usize, targets.height() as usize);
    // A frame of one pixel around, so that no neighbour is outside.
    let stride = width + 2;
    let mut distance = vec![if beyond { 0 } else { FAR }; stride * (height + 2)];
    for y in 0..height {
        let row = &mut distance[(y + 1) * stride + 1..][..width];
        for (distance, &is_target) in row.iter_mut().zip(targets.row(y as u32)) {
            *distance = if is_target { 0 } else { FAR };
        }
    }
    let steps = [(1, 3), (stride, 3), (stride - 1, 4), (stride + 1, 4)];
    // Without the frame's own columns: their neighbours are at the other end of a row.
    let inner = (1..=height).flat_map(|y| (1..=width).map(move |x| y * stride + x));
    for at in inner.clone() {
        let least = steps.map(|(step, cost)| distance[at - step] + cost);
        distance[at] = least.into_iter().fold(distance[at], u32::min);
    }
    for at in inner.rev() {
        let least = steps.map(|(step, cost)| distance[at + step] + cost);
        distance[at] = least.into_iter().fold(distance[at], u32::min);
    }
    let rows = distance.chunks(stride).skip(1).take(height);
    let pixels = rows.flat_map(|row| &row[1..=width]).copied().collect();
    Image::from_pixels(targets.width(), targets.height(), pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_near_euclids_and_know_the_frame() {
        let mut targets = Image::filled(21, 15, false);
        targets.set(4, 5, true);
        let alone = chamfer(&targets, false);
        let framed = chamfer(&targets, true);
        for y in 0..15 {
            for x in 0..21 {
                let (dx, dy) = (f64::from(x) - 4.0, f64::from(y) - 5.0);
                let found = f64::from(alone.at(x, y)) / f64::from(PIXEL);
                assert!((found - dx.hypot(dy)).abs() <= 0.081 * dx.hypot(dy) + 1e-9);
                let to_frame = (x + 1).min(21 - x).min(y + 1).min(15 - y);
                assert_eq!(framed.at(x, y), alone.at(x, y).min(PIXEL * to_frame));
            }
        }
    }
}
