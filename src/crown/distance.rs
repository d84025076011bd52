//! Baseline: the distance to the silhouette as height (thesis, Fig. 4.9).
//!
//! Exact Euclidean distances by the lower envelope of parabolas, along columns and then rows:
//! Felzenszwalb & Huttenlocher, *Distance transforms of sampled functions*, 2012. Linear in the
//! number of pixels. Known weakness, which is why the inflation exists: ridges along the medial axis.

use super::domain::Domain;
use super::inflation::Sheet;
use crate::base::{Cancel, Cancelled};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

/// How distance becomes height.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DistanceShape {
    /// z = d.
    Linear,
    /// z = D sin(π/2 · d/D), D being the largest distance.
    Sine,
}

/// The distance from each pixel of `domain` to the nearest silhouette pixel, in pixels, by rows.
///
/// # Errors
/// When the work is cancelled.
pub fn distances_to_silhouette(domain: &Domain, cancel: &Cancel) -> Result<Vec<f64>, Cancelled> {
    let mask = domain.mask();
    let (width, height) = (mask.width() as usize, mask.height() as usize);
    let mut squares = vec![f64::INFINITY; width * height];
    for (pixel, &(x, y)) in domain.pixels().iter().enumerate() {
        if domain.is_silhouette(pixel) {
            squares[y as usize * width + x as usize] = 0.0;
        }
    }
    let mut envelope = Envelope::default();
    let mut line = vec![0.0; width.max(height)];
    for x in 0..width {
        cancel.check()?;
        for y in 0..height {
            line[y] = squares[y * width + x];
        }
        envelope.lower(&mut line[..height]);
        for y in 0..height {
            squares[y * width + x] = line[y];
        }
    }
    for row in squares.chunks_mut(width) {
        cancel.check()?;
        envelope.lower(row);
    }
    let at = |&(x, y): &(u32, u32)| squares[y as usize * width + x as usize].sqrt();
    Ok(domain.pixels().iter().map(at).collect())
}

/// The heights of [`distances_to_silhouette`] over `domain`.
///
/// # Errors
/// When the work is cancelled.
pub fn distance_sheet(
    domain: &Arc<Domain>,
    shape: DistanceShape,
    cancel: &Cancel,
) -> Result<Sheet, Cancelled> {
    let distances = distances_to_silhouette(domain, cancel)?;
    let largest = distances.iter().copied().fold(0.0, f64::max);
    let height = |d: f64| match shape {
        DistanceShape::Linear => d,
        DistanceShape::Sine if largest > 0.0 => largest * libm::sin(FRAC_PI_2 * d / largest),
        DistanceShape::Sine => 0.0,
    };
    let positions = domain.pixels().iter().zip(distances);
    Ok(Sheet {
        positions: positions
            .map(|(&(x, y), d)| DVec3::new(x.into(), y.into(), height(d)))
            .collect(),
        domain: Arc::clone(domain),
    })
}

/// The parabolas that are lowest somewhere, kept between lines to save memory.
#[derive(Default)]
struct Envelope {
    /// Apex and height of each, from the left.
    parabolas: Vec<(f64, f64)>,
    /// From where on each is the lowest.
    from: Vec<f64>,
}

impl Envelope {
    /// Replaces each value f(x) of `line` by the least f(v) + (x − v)² over all v.
    fn lower(&mut self, line: &mut [f64]) {
        self.parabolas.clear();
        self.from.clear();
        for (x, &height) in line.iter().enumerate() {
            if height.is_finite() {
                self.add(x as f64, height);
            }
        }
        if self.parabolas.is_empty() {
            return;
        }
        let mut lowest = 0;
        for (x, value) in line.iter_mut().enumerate() {
            let x = x as f64;
            while self.from.get(lowest + 1).is_some_and(|&from| from < x) {
                lowest += 1;
            }
            let (apex, height) = self.parabolas[lowest];
            *value = height + (x - apex) * (x - apex);
        }
    }

    fn add(&mut self, apex: f64, height: f64) {
        while let (Some(&(left, low)), Some(&from)) = (self.parabolas.last(), self.from.last()) {
            let meet = ((height + apex * apex) - (low + left * left)) / (2.0 * (apex - left));
            if meet > from {
                self.parabolas.push((apex, height));
                self.from.push(meet);
                return;
            }
            self.parabolas.pop();
            self.from.pop();
        }
        self.parabolas.push((apex, height));
        self.from.push(f64::NEG_INFINITY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn distances_are_those_of_looking_everywhere(
            width in 1u32..14, height in 1u32..14, bits in proptest::collection::vec(0u8..8, 196),
        ) {
            let pixels = bits.iter().take((width * height) as usize).map(|&b| b > 0).collect();
            let Ok(domain) = Domain::new(&Image::from_pixels(width, height, pixels)) else {
                return Ok(());
            };
            let found = distances_to_silhouette(&domain, &Cancel::new()).unwrap();
            let pixels = domain.pixels();
            let silhouette: Vec<_> = (0..pixels.len()).filter(|&p| domain.is_silhouette(p)).collect();
            for (&(x, y), found) in pixels.iter().zip(found) {
                let square = |&p: &usize| {
                    let (dx, dy) = (x.abs_diff(pixels[p].0), y.abs_diff(pixels[p].1));
                    dx * dx + dy * dy
                };
                let least = silhouette.iter().map(square).min().unwrap();
                prop_assert!((found - f64::from(least).sqrt()).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_sine_keeps_the_top_and_rounds_it() {
        let domain = Arc::new(Domain::new(&Image::filled(21, 21, true)).unwrap());
        let top = |shape| {
            let sheet = distance_sheet(&domain, shape, &Cancel::new()).unwrap();
            (
                sheet.positions[10 * 21 + 10].z,
                sheet.positions[10 * 21 + 5].z,
            )
        };
        assert_eq!(top(DistanceShape::Linear), (10.0, 5.0));
        let (middle, half) = top(DistanceShape::Sine);
        assert!((middle - 10.0).abs() < 1e-12 && (half - 10.0 * 0.5f64.sqrt()).abs() < 1e-12);
    }
}
