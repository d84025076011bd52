//! The pictures that leaves are drawn with: twigs, or whole fronds and boughs.

use super::boughs::boughs;
use super::fronds::fronds;
use super::needles::{Needles, needle_twigs};
use crate::base::Seed;
use crate::branches::leaf_name::LeafName;
use crate::branches::sprite::LeafShape;
use crate::branches::twig_canvas::TwigTexel;
use crate::branches::twigs::twigs;
use crate::raster::Image;

/// Whether leaves are thinner than most, and want larger pictures.
pub(super) fn is_fine(leaf: LeafName) -> bool {
    matches!(
        leaf,
        LeafName::Brush | LeafName::Tuft | LeafName::Frond | LeafName::Bough
    )
}

/// `count` different pictures of `leaf`, `size` × `size` texels each. Twigs keep within the disc that touches
/// the edges, and may be turned; fronds and boughs go from the lower edge to the upper one.
pub(crate) fn leaf_pictures(
    leaf: LeafName,
    size: u32,
    count: u32,
    seed: Seed,
) -> Vec<Image<TwigTexel>> {
    let of_shape = |shape| twigs(shape, size, count, seed);
    match leaf {
        LeafName::Ovate => of_shape(LeafShape::Ovate),
        LeafName::Round => of_shape(LeafShape::Round),
        LeafName::Lobed => of_shape(LeafShape::Lobed),
        LeafName::Palmate => of_shape(LeafShape::Palmate),
        LeafName::Lance => of_shape(LeafShape::Lance),
        LeafName::Brush => needle_twigs(Needles::Comb, size, count, seed),
        LeafName::Tuft => needle_twigs(Needles::Fan, size, count, seed),
        LeafName::Frond => fronds(size, count, seed),
        LeafName::Bough => boughs(size, count, seed),
    }
}

/// Whether nothing reaches the edges of a picture.
#[cfg(test)]
pub(super) fn is_clear_at_the_edges(picture: &Image<TwigTexel>) -> bool {
    let last = picture.width() - 1;
    (0..=last).all(|i| {
        let edges = [(0, i), (last, i), (i, 0), (i, last)];
        edges.map(|(x, y)| picture.at(x, y).coverage) == [0; 4]
    })
}
