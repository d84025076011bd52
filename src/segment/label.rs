//! Labels: what a pixel shows, how labels are stored as grey, and where the crown ends.

use crate::raster::Image;

/// What a pixel shows. The numbers are the grey values of label files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[repr(u8)]
pub enum Label {
    /// No part of the tree.
    #[default]
    Background = 0,
    /// The stem and main limbs below the lowest foliage.
    Trunk = 128,
    /// Foliage, and the branches seen inside it.
    Crown = 255,
}

impl Label {
    /// The label's grey value: 0 background, 128 trunk, 255 crown.
    #[inline]
    pub fn grey(self) -> u8 {
        self as u8
    }

    /// The label that `grey` stands for: below 64 background, below 192 trunk, else crown.
    ///
    /// Half-way thresholds, so that files that were compressed with loss or saved in another grey
    /// scale still read as they were meant.
    ///
    /// ```
    /// use boscage::segment::Label;
    /// assert_eq!([3, 127, 192].map(Label::from_grey), [Label::Background, Label::Trunk, Label::Crown]);
    /// ```
    #[inline]
    pub fn from_grey(grey: u8) -> Self {
        match grey {
            0..64 => Self::Background,
            64..192 => Self::Trunk,
            192.. => Self::Crown,
        }
    }
}

/// The label of each pixel.
pub type Labels = Image<Label>;

/// The labels as a grey picture, as label files hold it.
pub fn grey_from_labels(labels: &Labels) -> Image<u8> {
    labels.map(|label| label.grey())
}

/// The labels that a grey picture stands for; any picture will do (see [`Label::from_grey`]).
pub fn labels_from_grey(grey: &Image<u8>) -> Labels {
    grey.map(|&value| Label::from_grey(value))
}

/// Number of crown pixels.
pub fn crown_count(labels: &Labels) -> usize {
    count(labels, Label::Crown)
}

/// Number of trunk pixels.
pub fn trunk_count(labels: &Labels) -> usize {
    count(labels, Label::Trunk)
}

fn count(labels: &Labels, wanted: Label) -> usize {
    labels.pixels().iter().filter(|&&l| l == wanted).count()
}

/// The share of the places where crown stands on trunk that lie at or above the baseline.
///
/// 1 would be the lowest such place, decided by a single leaf in front of the trunk; below about
/// 0.7 the baseline of a forked tree climbs into the fork. With 0.85 the 49 hand-drawn label
/// pictures we have give the baselines that were published with them, 48 of them to the pixel.
const BASELINE_SHARE: f64 = 0.85;

/// The row where the crown begins above the trunk, `None` where no crown stands on a trunk.
///
/// It is the 85th percentile, counted from the top and rounded to the nearest rank, of the rows of
/// those crown pixels that have a trunk pixel directly below them. Not simply the lowest crown
/// row, as the paper has it (*Tree Variations*, §4.4): the drooping branch of a spruce, the strands
/// of a willow or one stray leaf beside the trunk reach far below the place where the trunk enters
/// the crown, often to the ground, and pins at the ground would leave no trunk between them. Crown
/// that touches the trunk from the side does not count for the same reason.
///
/// ```
/// use boscage::raster::Image;
/// use boscage::segment::{crown_baseline, labels_from_grey};
/// let grey = Image::from_pixels(3, 3, vec![255, 255, 255, 255, 255, 255, 0, 128, 0]);
/// assert_eq!(crown_baseline(&labels_from_grey(&grey)), Some(1));
/// ```
pub fn crown_baseline(labels: &Labels) -> Option<u32> {
    let mut rows = Vec::new();
    for y in 1..labels.height() {
        let standing = labels.row(y - 1).iter().zip(labels.row(y));
        let places =
            standing.filter(|&(&above, &below)| above == Label::Crown && below == Label::Trunk);
        // Rows are visited from the top: they come out sorted.
        rows.extend(places.map(|_| y - 1));
    }
    let last = rows.len().checked_sub(1)?;
    Some(rows[(BASELINE_SHARE * last as f64 + 0.5) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(rows: &[&str]) -> Labels {
        let pixels = rows.iter().flat_map(|row| row.bytes()).map(|b| match b {
            b'#' => Label::Crown,
            b'|' => Label::Trunk,
            _ => Label::Background,
        });
        Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels.collect())
    }

    #[test]
    fn labels_survive_grey() {
        let labels = labels(&["###", ".|.", ".|."]);
        assert_eq!(labels_from_grey(&grey_from_labels(&labels)), labels);
        assert_eq!((crown_count(&labels), trunk_count(&labels)), (3, 2));
    }

    #[test]
    fn drooping_branches_do_not_lower_the_baseline() {
        let drooping = ["#####", "#||.#", "#||.#", "#||.#"];
        assert_eq!(crown_baseline(&labels(&drooping)), Some(0));
    }

    #[test]
    fn without_trunk_or_crown_there_is_no_baseline() {
        assert_eq!(crown_baseline(&labels(&["##", "##"])), None);
        assert_eq!(crown_baseline(&labels(&["||", "||"])), None);
    }
}
