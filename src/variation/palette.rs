//! The colours of a new tree: crown and trunk each get the distribution they should have.
//!
//! A mean of two pictures loses contrast. Matching its histogram to the blend of the exemplars'
//! *distributions* (Σ wᵢ·qᵢ of their quantiles) gives it back; matching it to another picture's
//! changes the season. Crown and trunk are matched separately: on whole trees a trunk takes the
//! crown's colour (Argudo, Andújar & Chica 2017, *Tree Variations*, §5.3).

use super::{Exemplar, Histogram, Transfer};
use crate::raster::{Image, Straight};
use crate::segment::{Label, Labels};

/// Fewest pixels that are a distribution; with fewer a class keeps its colours.
const LEAST_PIXELS: u64 = 64;

/// The distributions of a tree's colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Palette {
    crown: Histogram,
    trunk: Histogram,
}

impl Palette {
    /// The palette of a picture with its labels.
    pub fn of(image: &Image<Straight>, labels: &Labels) -> Self {
        Self {
            crown: Histogram::of_label(image, labels, Label::Crown),
            trunk: Histogram::of_label(image, labels, Label::Trunk),
        }
    }

    /// The palette of an exemplar.
    pub fn of_exemplar(exemplar: &Exemplar) -> Self {
        Self::of(&exemplar.image.straight(), &exemplar.labels)
    }

    /// The distribution of the crown's colours.
    pub fn crown(&self) -> &Histogram {
        &self.crown
    }

    /// Gives `image` the blend of the `references`, each with its weight.
    pub fn apply(image: &mut Image<Straight>, labels: &Labels, references: &[(&Self, f64)]) {
        let own = Self::of(image, labels);
        let class = |pick: fn(&Self) -> &Histogram| {
            let references: Vec<(&Histogram, f64)> = references
                .iter()
                .map(|(palette, weight)| (pick(palette), *weight))
                .filter(|(histogram, _)| histogram.pixel_count() >= LEAST_PIXELS)
                .collect();
            if references.is_empty() || pick(&own).pixel_count() < LEAST_PIXELS {
                Transfer::identity()
            } else {
                Transfer::towards(pick(&own), &references)
            }
        };
        let (crown, trunk) = (class(|p| &p.crown), class(|p| &p.trunk));
        for (pixel, label) in image.pixels_mut().iter_mut().zip(labels.pixels()) {
            match label {
                Label::Background => {}
                Label::Crown => *pixel = crown.applied(*pixel),
                Label::Trunk => *pixel = trunk.applied(*pixel),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crown_and_trunk_keep_apart() {
        let colors = |crown: u8, trunk: u8| {
            let pixel = |i: usize| {
                let value = if i < 100 { crown } else { trunk };
                Straight([value, value, value, 255])
            };
            Image::from_pixels(200, 1, (0..200).map(pixel).collect())
        };
        let label = |i: usize| if i < 100 { Label::Crown } else { Label::Trunk };
        let labels = Image::from_pixels(200, 1, (0..200).map(label).collect());
        let reference = Palette::of(&colors(200, 30), &labels);
        let mut image = colors(90, 100);
        Palette::apply(&mut image, &labels, &[(&reference, 1.0)]);
        assert_eq!(image.at(0, 0).0, [200, 200, 200, 255]);
        assert_eq!(image.at(150, 0).0, [30, 30, 30, 255]);
    }
}
