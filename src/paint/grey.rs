//! Masks as grey pictures, for other programs.
//!
//! Background is 0, trunk 128, crown 255, as in all label files; sub-crowns are eight steps of grey
//! apart below the crown. Other programs write what they like: only when every pixel is exactly one of
//! our greys are sub-crowns believed, otherwise each is the nearest of the three. So a mask in black and
//! white, or one saved with loss, reads as it was meant.

use super::tiled::{BACKGROUND, CROWN, TRUNK, TiledMask};
use crate::raster::{Image, Straight};
use crate::segment::Label;

/// The largest label that has a grey of its own; larger ones are written like it.
pub const LAST_GREY_LABEL: u8 = 9;

/// Difference between the greys of two sub-crowns.
const STEP: u8 = 8;

/// The grey that stands for `label`.
pub fn grey_of(label: u8) -> u8 {
    match label {
        BACKGROUND => Label::Background.grey(),
        CROWN => Label::Crown.grey(),
        TRUNK => Label::Trunk.grey(),
        _ => Label::Crown.grey() - (label.min(LAST_GREY_LABEL) - TRUNK) * STEP,
    }
}

/// The label that has exactly this grey.
fn exact(grey: u8) -> Option<u8> {
    (BACKGROUND..=LAST_GREY_LABEL).find(|&label| grey_of(label) == grey)
}

fn nearest(grey: u8) -> u8 {
    match Label::from_grey(grey) {
        Label::Background => BACKGROUND,
        Label::Trunk => TRUNK,
        Label::Crown => CROWN,
    }
}

/// The labels as a grey picture.
pub fn grey_from_mask(mask: &TiledMask) -> Image<u8> {
    mask.image().map(|&label| grey_of(label))
}

/// The labels that a grey picture stands for; any will do.
///
/// ```
/// use boscage::paint::{TiledMask, grey_from_mask, mask_from_grey};
/// use boscage::raster::Image;
/// let mask = TiledMask::from_image(&Image::from_pixels(5, 1, vec![0, 1, 2, 3, 9]));
/// assert_eq!(mask_from_grey(&grey_from_mask(&mask)), mask);
/// let foreign = Image::from_pixels(4, 1, vec![3, 247, 130, 201]);
/// assert_eq!(mask_from_grey(&foreign).image().pixels(), &[0, 1, 2, 1]);
/// ```
pub fn mask_from_grey(grey: &Image<u8>) -> TiledMask {
    let mut seen = [false; 256];
    for &grey in grey.pixels() {
        seen[usize::from(grey)] = true;
    }
    let is_ours = (0..=255).all(|grey| !seen[usize::from(grey)] || exact(grey).is_some());
    let label = |grey: u8| {
        exact(grey)
            .filter(|_| is_ours)
            .unwrap_or_else(|| nearest(grey))
    };
    let labels: [u8; 256] = std::array::from_fn(|grey| label(grey as u8));
    TiledMask::from_image(&grey.map(|&grey| labels[usize::from(grey)]))
}

/// The labels that a picture stands for: what is opaque where there are clear pixels, its
/// brightness otherwise.
pub fn mask_from_picture(picture: &Image<Straight>) -> TiledMask {
    let is_cut_out = picture.pixels().iter().any(|pixel| pixel.alpha() < 128);
    let grey = picture.map(|pixel| {
        let [r, g, b, alpha] = pixel.0;
        if is_cut_out {
            return if alpha < 128 { 0 } else { 255 };
        }
        // Rec. 601, in whole numbers; grey stays what it is.
        ((299 * u32::from(r) + 587 * u32::from(g) + 114 * u32::from(b) + 500) / 1000) as u8
    });
    mask_from_grey(&grey)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn greys_are_apart_from_each_other() {
        let mut greys: Vec<u8> = (0..=LAST_GREY_LABEL).map(grey_of).collect();
        greys.sort_unstable();
        greys.dedup();
        assert_eq!(greys.len(), usize::from(LAST_GREY_LABEL) + 1);
        // Programs that know three labels take sub-crowns for crown.
        assert!((3..=LAST_GREY_LABEL).all(|label| nearest(grey_of(label)) == CROWN));
    }

    #[test]
    fn a_cut_out_picture_is_its_alpha() {
        let pixels = vec![Straight([0, 0, 0, 255]), Straight([255, 255, 255, 0])];
        let mask = mask_from_picture(&Image::from_pixels(2, 1, pixels));
        assert_eq!(mask.image().pixels(), &[CROWN, BACKGROUND]);
    }
}
