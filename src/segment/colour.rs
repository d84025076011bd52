//! Bark against foliage: two colour histograms and what they say of a pixel.
//!
//! Both classes are learned from the picture at hand, since no colour is bark everywhere: birch is
//! white, snow is on everything, larches are as brown as their trunks. Foliage in snow has two
//! colours, so histograms and not Gaussians (Swain & Ballard 1991, *Color indexing*), in an opponent
//! space whose two chroma axes do not change with the light.
//!
//! Limits: where trunk and crown have the same colours the histograms overlap
//! ([`BarkLikelihood::overlap`] near 1) and the ratio says nothing.

use crate::raster::Straight;

/// Bins along each of the three axes.
///
/// With 8, dark green and dark brown share a bin; with 32, the few hundred pixels of a short trunk
/// fill too few of them even when blurred.
const BINS: usize = 16;
const CELLS: usize = BINS * BINS * BINS;

/// Number of [1 2 1] passes over the histograms: a standard deviation of about a bin.
const BLURS: usize = 2;

/// Probability of a colour neither class has shown, over that of all colours being alike.
///
/// It bounds the ratio: a single odd pixel must not outvote its neighbours.
const UNSEEN: f64 = 0.3;

/// Overlap of the colours of bark and crown up to which they are told apart by colour.
///
/// Leafless trees have 0.89–0.98, trees in leaf mostly 0.25–0.65. Below 0.65 forked trees of dull
/// green lose their limbs; above 0.75 foliage beside short trunks is taken for bark.
const DISTINCT: f64 = 0.7;

/// How many times likelier a colour is on bark than in the crown, as a logarithm; learned from one picture.
pub struct BarkLikelihood {
    log_ratio: Vec<f32>,
    overlap: f64,
}

impl BarkLikelihood {
    /// Learns from pixels of the trunk and of the crown.
    pub fn learned(
        trunk: impl Iterator<Item = Straight>,
        crown: impl Iterator<Item = Straight>,
    ) -> Self {
        let (trunk, crown) = (histogram(trunk), histogram(crown));
        let pairs = || trunk.iter().zip(&crown);
        let floor = UNSEEN / CELLS as f64;
        Self {
            log_ratio: pairs()
                .map(|(t, c)| libm::log((t + floor) / (c + floor)) as f32)
                .collect(),
            overlap: pairs().map(|(t, c)| (t * c).sqrt()).sum(),
        }
    }

    /// Above 0 for colours that bark has more often, below 0 for those of foliage.
    #[inline]
    pub fn of(&self, pixel: Straight) -> f32 {
        self.log_ratio[cell(pixel)]
    }

    /// Whether colours tell bark from the crown.
    pub fn is_distinct(&self) -> bool {
        self.overlap < DISTINCT
    }

    /// The Bhattacharyya coefficient of the two histograms: 0 when no colour is shared, 1 when
    /// trunk and crown cannot be told apart by colour.
    pub(super) fn overlap(&self) -> f64 {
        self.overlap
    }
}

/// The bin of a colour: brightness, red against green, blue against yellow.
#[inline]
fn cell(pixel: Straight) -> usize {
    let [r, g, b, _] = pixel.0.map(i32::from);
    let sum = r + g + b;
    // Chroma relative to brightness, so that shadow keeps its hue; the constant keeps near-black,
    // where a step of one grey value would be a whole bin, in the middle.
    let axis = |chroma: i32| bin((chroma * 512) / (sum + 48) + 128);
    let brightness = bin(sum / 3);
    (brightness * BINS + axis(r - g)) * BINS + axis((r + g) / 2 - b)
}

#[inline]
fn bin(value: i32) -> usize {
    value.clamp(0, 255) as usize * BINS / 256
}

fn histogram(pixels: impl Iterator<Item = Straight>) -> Vec<f64> {
    let mut counts = vec![0.0; CELLS];
    let mut total = 0.0;
    for pixel in pixels {
        counts[cell(pixel)] += 1.0;
        total += 1.0;
    }
    for stride in [1, BINS, BINS * BINS] {
        for _ in 0..BLURS {
            counts = blurred(&counts, stride);
        }
    }
    let scale = if total > 0.0 { 1.0 / total } else { 0.0 };
    counts.iter().map(|count| count * scale).collect()
}

/// One [1 2 1] / 4 pass along the axis of `stride`; what would leave the cube stays at its border.
fn blurred(counts: &[f64], stride: usize) -> Vec<f64> {
    (0..CELLS)
        .map(|i| {
            let position = i / stride % BINS;
            let before = if position > 0 { i - stride } else { i };
            let after = if position + 1 < BINS { i + stride } else { i };
            (counts[before] + 2.0 * counts[i] + counts[after]) / 4.0
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GREEN: Straight = Straight([60, 130, 40, 255]);
    const BROWN: Straight = Straight([110, 70, 50, 255]);

    fn learned(trunk: Straight, crown: Straight) -> BarkLikelihood {
        BarkLikelihood::learned([trunk; 9].into_iter(), [crown; 99].into_iter())
    }

    #[test]
    fn brown_is_bark_and_green_is_not() {
        let bark = learned(BROWN, GREEN);
        assert!(bark.of(BROWN) > 1.0 && bark.of(GREEN) < -1.0);
        assert!(bark.overlap() < 0.2);
    }

    #[test]
    fn equal_colours_say_nothing() {
        let bark = learned(GREEN, GREEN);
        assert!((bark.overlap() - 1.0).abs() < 1e-9);
        assert!(bark.of(GREEN).abs() < 1e-6);
    }

    #[test]
    fn shadow_keeps_the_hue() {
        let [brown, dark] = [BROWN, Straight([55, 35, 25, 255])].map(cell);
        let chroma = BINS * BINS;
        assert!((brown % chroma).abs_diff(dark % chroma) <= BINS + 1);
    }

    #[test]
    fn no_pixels_at_all_are_no_trouble() {
        let none = BarkLikelihood::learned([].into_iter(), [].into_iter());
        assert_eq!(none.of(BROWN), 0.0);
    }
}
