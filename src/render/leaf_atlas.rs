//! Pictures of twigs with their levels of detail.
//!
//! Halving a picture blurs its coverage towards the mean, and a threshold would make twigs vanish
//! with distance. As in I. Castaño, *Computing Alpha Mipmaps* (2010), each level's coverage is
//! scaled so that the share of texels above one half stays that of the first level.

use super::leaf_pictures::{is_fine, leaf_pictures};
use crate::base::Seed;
use crate::branches::leaf_name::LeafName;
use crate::branches::twig_canvas::TwigTexel;
use crate::raster::Image;

/// Texels along a side of a picture, and of one of thin leaves.
const LEAF_SIZE: u32 = 128;
const FINE_SIZE: u32 = 256;

/// Twigs of an atlas.
pub(crate) const VARIANTS: u32 = 8;

/// Texels along a side at the last level of detail.
const LAST_SIZE: u32 = 4;

/// Shade (128 keeps the colour) and coverage.
type Texel = [u8; 2];

/// Twigs, each with its levels of detail.
#[derive(Debug, Clone, PartialEq)]
pub struct LeafAtlas {
    /// Texels along a side at the first level.
    size: u32,
    /// Level by level, twig by twig.
    levels: Vec<Vec<Image<Texel>>>,
}

impl LeafAtlas {
    /// Pictures of `leaf`; takes about 30 ms, with thin ones 200 ms.
    pub fn new(leaf: LeafName, seed: Seed) -> Self {
        let texel = |&TwigTexel { shade, coverage }: &TwigTexel| [shade, coverage];
        let size = if is_fine(leaf) { FINE_SIZE } else { LEAF_SIZE };
        let drawn = leaf_pictures(leaf, size, VARIANTS, seed);
        let mut levels: Vec<Vec<Image<Texel>>> = vec![drawn.iter().map(|t| t.map(texel)).collect()];
        let wanted: Vec<f64> = levels[0].iter().map(covered).collect();
        let mut plain = levels[0].clone();
        for _ in 1..(size / LAST_SIZE).ilog2() + 1 {
            plain = plain.iter().map(halved).collect();
            let kept = plain.iter().zip(&wanted);
            levels.push(
                kept.map(|(twig, &share)| with_coverage(twig, share))
                    .collect(),
            );
        }
        Self { size, levels }
    }

    /// Texels along a side of a twig at level 0.
    pub(crate) fn size(&self) -> u32 {
        self.size
    }

    /// Levels of detail.
    pub(crate) fn level_count(&self) -> u32 {
        self.levels.len() as u32
    }

    /// The texels of a level, twig after twig.
    pub(crate) fn texels(&self, level: u32) -> Vec<Texel> {
        let twigs = &self.levels[level as usize];
        twigs
            .iter()
            .flat_map(|twig| twig.pixels())
            .copied()
            .collect()
    }

    /// Shade and coverage, each 0 … 1, at (`u`, `v`), 0 … 1, bilinear; clear outside.
    #[inline(always)]
    pub(crate) fn sampled(&self, twig: u32, level: u32, u: f32, v: f32) -> (f32, f32) {
        let image = &self.levels[level as usize][twig as usize];
        let size = (self.size >> level) as f32;
        let (x, y) = (u * size - 0.5, v * size - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let (right, down) = (x - left, y - top);
        let at = |dx: i32, dy: i32| {
            let texel = image.get(i64::from(left as i32 + dx), i64::from(top as i32 + dy));
            let [shade, coverage] = texel.unwrap_or([128, 0]);
            (f32::from(shade) / 255.0, f32::from(coverage) / 255.0)
        };
        let mixed = |a: (f32, f32), b: (f32, f32), share: f32| {
            (a.0 + (b.0 - a.0) * share, a.1 + (b.1 - a.1) * share)
        };
        let upper = mixed(at(0, 0), at(1, 0), right);
        let lower = mixed(at(0, 1), at(1, 1), right);
        mixed(upper, lower, down)
    }
}

/// Share of the texels that are covered by half at least.
fn covered(twig: &Image<Texel>) -> f64 {
    let count = twig.pixels().iter().filter(|texel| texel[1] >= 128).count();
    count as f64 / twig.pixels().len() as f64
}

/// A twig of half the size; the shade is that of what is covered.
fn halved(twig: &Image<Texel>) -> Image<Texel> {
    let size = twig.width() / 2;
    let texels = (0..size * size).map(|i| {
        let (x, y) = (i % size * 2, i / size * 2);
        let four = [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(dx, dy)| twig.at(x + dx, y + dy));
        let coverage: u32 = four.iter().map(|texel| u32::from(texel[1])).sum();
        let shades = four
            .iter()
            .map(|texel| u32::from(texel[0]) * u32::from(texel[1]));
        let shade = shades.sum::<u32>().checked_div(coverage).unwrap_or(128);
        [shade as u8, ((coverage + 2) / 4) as u8]
    });
    Image::from_pixels(size, size, texels.collect())
}

/// The twig with its coverage scaled so that a share `wanted` of the texels is covered by half.
fn with_coverage(twig: &Image<Texel>, wanted: f64) -> Image<Texel> {
    let mut coverages: Vec<u8> = twig.pixels().iter().map(|texel| texel[1]).collect();
    coverages.sort_unstable_by(|a, b| b.cmp(a));
    let count = (wanted * coverages.len() as f64).round() as usize;
    let least = f64::from(coverages[count.clamp(1, coverages.len()) - 1].max(1));
    let scale = 128.0 / least;
    twig.map(|&[shade, coverage]| {
        let scaled = (f64::from(coverage) * scale).round().min(255.0);
        [shade, scaled as u8]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_stays_from_level_to_level() {
        for leaf in LeafName::ALL {
            let atlas = LeafAtlas::new(leaf, Seed(1));
            for twig in 0..VARIANTS as usize {
                let first = covered(&atlas.levels[0][twig]);
                for level in &atlas.levels[1..] {
                    let texel = 1.0 / level[twig].pixels().len() as f64;
                    let found = covered(&level[twig]);
                    assert!((found - first).abs() <= 0.04 + texel, "{first} {found}");
                }
            }
            assert_eq!(atlas.size() >> (atlas.level_count() - 1), LAST_SIZE);
        }
    }

    #[test]
    fn outside_is_clear() {
        let atlas = LeafAtlas::new(LeafName::Ovate, Seed(1));
        assert_eq!(atlas.sampled(0, 0, -0.5, 0.5).1, 0.0);
        assert_eq!(atlas.sampled(3, 2, 0.5, 1.5).1, 0.0);
        let row = (0..32).map(|i| atlas.sampled(0, 3, (i as f32 + 0.5) / 32.0, 0.5).1);
        assert!(row.fold(0.0, f32::max) > 0.5);
    }
}
