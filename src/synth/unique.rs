//! What occurs only once in an exemplar.
//!
//! A texture uses each part of its exemplar several times. For leaves nobody sees it; a red flower, a
//! road sign behind a gap, a nest are seen to repeat at once. They give themselves away: no other
//! place of the exemplar looks like them. Where the distance to the most similar place is far above
//! the usual, the surroundings are left out.
//!
//! Limits: what occurs twice, far apart, stays. At most a few percent are left out, those with the
//! largest distances.

use super::level::Level;
use crate::raster::{Image, Mask, dilated};

/// How many times the median squared distance is far above the usual: three times the distance. Lower,
/// and strong highlights go; higher, and signs stay.
const FAR_ABOVE: f32 = 9.0;

/// Most pixels that are found unique, as a share.
const MOST: f32 = 0.05;

/// How far around such a pixel pixels are left out, steps of the level: half a window and one.
const AROUND: usize = 3;

/// The pixels of the photograph's crop around places of `level` whose most similar place is at an
/// unusual squared distance.
pub(super) fn unique(level: &Level, distances: &[f32]) -> Mask {
    let (width, height) = level.size();
    let mut odd = Image::filled(width as u32, height as u32, false);
    let finite = |distance: &f32| distance.is_finite();
    let mut sorted: Vec<f32> = distances.iter().copied().filter(finite).collect();
    if sorted.is_empty() {
        return odd;
    }
    sorted.sort_unstable_by(f32::total_cmp);
    let median = sorted[sorted.len() / 2];
    let last_kept = sorted[((1.0 - MOST) * (sorted.len() - 1) as f32) as usize];
    let limit = last_kept.max(FAR_ABOVE * median);
    for (index, &distance) in distances.iter().enumerate() {
        if distance.is_finite() && distance > limit {
            let (x, y) = level.place(index);
            odd.set(x as u32, y as u32, true);
        }
    }
    dilated(&odd, (AROUND * level.step).min(255) as u8)
}

#[cfg(test)]
mod tests {
    use super::super::similar::similar;
    use super::*;
    use crate::base::{Cancel, Seed};

    #[test]
    fn a_spot_on_a_regular_ground_is_found_and_the_ground_stays() {
        let size = (80, 64);
        let mut random = Seed(3).random();
        let colors: Vec<[f32; 3]> = (0..80 * 64)
            .map(|i| {
                let (x, y) = (i % 80, i / 80);
                let spot = (40..46).contains(&x) && (30..36).contains(&y);
                let leaf =
                    60.0 + 40.0 * ((x / 4 + y / 4) % 2) as f32 + random.between(0.0, 30.0) as f32;
                if spot {
                    [250.0, 20.0, 20.0]
                } else {
                    [leaf * 0.6, leaf, leaf * 0.3]
                }
            })
            .collect();
        let level = Level::new(&colors, &[true; 80 * 64], size, 1);
        let found = similar(&level, Seed(1), &Cancel::new()).unwrap();
        let odd = unique(&level, &found.distances);
        assert!((41..45).all(|x| (31..35).all(|y| odd.at(x, y))));
        assert!(odd.count() < 80 * 64 / 4, "{}", odd.count());
    }
}
