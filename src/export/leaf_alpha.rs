//! Leaves that neither thin out nor clump in the smaller copies that a reader makes by itself.
//!
//! A picture inside a glTF file has no mip levels of its own: readers average, and small leaves on
//! clear ground fall below the alpha test from some level on. A little alpha everywhere, far below
//! the test, changes nothing near by and lifts the averages just enough from afar. How much is tried
//! out on the picture itself.
//!
//! Limit: one number serves all levels, so some keep a little too much and the last too little.

use super::mips::ALPHA_CUTOFF;
use crate::raster::{Image, Straight};

/// Levels that are compared with the first.
const LEVELS: u32 = 6;

/// Alphas that are tried: multiples of this, up to the last.
const STEP: u8 = 8;
const LAST: u8 = 96;

/// `picture` with an alpha of at least the value that keeps most of its coverage in smaller copies.
pub(super) fn lasting(picture: &Image<Straight>) -> Image<Straight> {
    let alpha = picture.map(|pixel| pixel.alpha());
    let least = (0..=LAST / STEP)
        .map(|step| step * STEP)
        .min_by(|&a, &b| deviation(&alpha, a).total_cmp(&deviation(&alpha, b)))
        .unwrap_or(0);
    picture.map(|&Straight([r, g, b, a])| Straight([r, g, b, a.max(least)]))
}

/// How far the coverage of averaged copies is from that of the picture: sum of squared relative
/// errors.
fn deviation(alpha: &Image<u8>, least: u8) -> f64 {
    let mut level = alpha.map(|&alpha| f32::from(alpha.max(least)));
    let share = |level: &Image<f32>| {
        let passing = level.pixels().iter();
        let passing = passing.filter(|&&alpha| alpha >= f32::from(ALPHA_CUTOFF) - 0.5);
        passing.count() as f64 / level.pixels().len() as f64
    };
    let wanted = share(&level).max(1e-9);
    let mut sum = 0.0;
    for _ in 0..LEVELS {
        if level.width() < 2 || level.height() < 2 {
            break;
        }
        level = halved(&level);
        sum += (share(&level) / wanted - 1.0).powi(2);
    }
    sum
}

/// Means of 2 × 2 pixels; an odd last line is left out.
fn halved(image: &Image<f32>) -> Image<f32> {
    let (width, height) = (image.width() / 2, image.height() / 2);
    let mean = |i: u32| {
        let (x, y) = (2 * (i % width), 2 * (i / width));
        let upper = image.at(x, y) + image.at(x + 1, y);
        (upper + image.at(x, y + 1) + image.at(x + 1, y + 1)) / 4.0
    };
    Image::from_pixels(width, height, (0..width * height).map(mean).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sparse_leaves_last_and_what_shows_stays_the_same() {
        // A twig: leaves of 4 × 4 pixels on a third of a disc.
        let texel = |i: u32| {
            let (x, y) = (i % 256, i / 256);
            let inside = f64::hypot(f64::from(x) - 128.0, f64::from(y) - 128.0) < 100.0;
            let leaf = inside && ((x / 4 * 7919) ^ (y / 4 * 104_729)) % 11 < 4;
            Straight([90, 140, 60, if leaf { 255 } else { 0 }])
        };
        let picture = Image::from_pixels(256, 256, (0..256 * 256).map(texel).collect());
        let kept = lasting(&picture);
        let alpha = |picture: &Image<Straight>| picture.map(|pixel| pixel.alpha());
        let (before, after) = (deviation(&alpha(&picture), 0), deviation(&alpha(&kept), 0));
        assert!(after < 0.3 * before, "{before} {after}");
        for (old, new) in picture.pixels().iter().zip(kept.pixels()) {
            assert_eq!(old.alpha() >= ALPHA_CUTOFF, new.alpha() >= ALPHA_CUTOFF);
        }
    }

    #[test]
    fn a_solid_picture_is_left_alone() {
        let solid = Image::filled(64, 64, Straight([1, 2, 3, 255]));
        assert_eq!(lasting(&solid), solid);
    }
}
