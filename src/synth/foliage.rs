//! Which pixels of a photograph are foliage: the only ones that a texture may be made of.
//!
//! A mask drawn around a crown holds more than leaves: a rim of pixels mixed with what lies behind,
//! and patches of sky that show through. The rim is eroded. Sky is told from leaves by comparing two
//! colour histograms, one of what lies outside the mask and one of what lies inside: a colour that
//! is more at home outside, is at least as blue as it is green, and is brighter than half of the
//! crown, is sky, and so are its neighbours, in which lens and camera mixed both.
//!
//! Limits: grass and other trees behind gaps have the colours of leaves and stay. A cut-out without a
//! background has nothing to compare with; nothing is taken for sky.

use crate::raster::{Image, Mask, Straight, dilated, labelled_components};

/// Bits a channel of a histogram's bin: 16 levels. Finer ones are empty on small pictures, coarser
/// ones mix haze with silver leaves.
const BITS: u32 = 4;
const SIDE: usize = 1 << BITS;

/// How much less blue than green a colour may be and still be sky, of 255: white clouds have none.
const BLUE_SLACK: i32 = 10;

/// Islands of fewer pixels than this cannot be recognised in a window of 7×7 and are left out.
const SMALLEST_ISLAND: usize = 12;

/// Share of the eroded mask that must stay when sky is taken out; below, the comparison was wrong
/// (a white tree before a blue wall) and nothing is.
const LEAST_SHARE: f64 = 0.3;

/// The foliage of `photo` inside `mask`: opaque pixels at least `erosion` pixels from the mask's
/// edge, without sky when `without_sky` (which grows by one pixel), and without tiny islands.
pub(super) fn foliage(
    photo: &Image<Straight>,
    mask: &Mask,
    erosion: u8,
    without_sky: bool,
) -> Mask {
    let outside = paired(photo, mask, |pixel, inside| !inside || pixel.alpha() < 128);
    let grown = dilated(&outside, erosion);
    let inner = grown.map(|&outside| !outside);
    let mut kept = inner.clone();
    if without_sky && let Some(sky) = sky(photo, mask, &inner) {
        let sky = dilated(&sky, 1);
        let without = both(&inner, &sky, |inside, sky| inside && !sky);
        if without.count() as f64 >= LEAST_SHARE * inner.count() as f64 {
            kept = without;
        }
    }
    without_islands(&kept)
}

/// The pixels of `inner` whose colours are those of the sky around the crown; `None` when there is
/// no background to learn them from.
fn sky(photo: &Image<Straight>, mask: &Mask, inner: &Mask) -> Option<Mask> {
    let behind = histogram(
        photo,
        &paired(photo, mask, |pixel, inside| !inside && pixel.alpha() >= 128),
    )?;
    let before = histogram(photo, inner)?;
    let middle = median_luma(photo, inner);
    Some(paired(photo, inner, |pixel, inside| {
        let [r, g, b, _] = pixel.0.map(i32::from);
        inside
            && b + BLUE_SLACK >= g
            && b + BLUE_SLACK >= r
            && luma(pixel) > middle
            && behind[bin(pixel)] > before[bin(pixel)]
    }))
}

/// Share of the pixels of `mask` in each bin, smoothed over neighbouring bins; `None` when the mask
/// is empty.
fn histogram(photo: &Image<Straight>, mask: &Mask) -> Option<Vec<f32>> {
    let mut counts = vec![0u32; SIDE * SIDE * SIDE];
    for (&pixel, _) in photo
        .pixels()
        .iter()
        .zip(mask.pixels())
        .filter(|(_, inside)| **inside)
    {
        counts[bin(pixel)] += 1;
    }
    let total: u32 = counts.iter().sum();
    if total == 0 {
        return None;
    }
    let mut shares: Vec<f32> = counts.iter().map(|&n| n as f32 / total as f32).collect();
    for stride in [1, SIDE, SIDE * SIDE] {
        shares = smoothed(&shares, stride);
    }
    Some(shares)
}

/// Each bin with half of its two neighbours along the axis of `stride` added.
fn smoothed(shares: &[f32], stride: usize) -> Vec<f32> {
    let at = |index: usize| {
        let level = index / stride % SIDE;
        let below = if level > 0 {
            shares[index - stride]
        } else {
            0.0
        };
        let above = if level + 1 < SIDE {
            shares[index + stride]
        } else {
            0.0
        };
        shares[index] + 0.5 * (below + above)
    };
    (0..shares.len()).map(at).collect()
}

fn bin(pixel: Straight) -> usize {
    let [r, g, b, _] = pixel.0.map(|value| usize::from(value >> (8 - BITS)));
    (r * SIDE + g) * SIDE + b
}

/// Rec. 709 luma of the encoded colour, 0 … 255.
fn luma(pixel: Straight) -> i32 {
    let [r, g, b, _] = pixel.0.map(i32::from);
    (54 * r + 183 * g + 19 * b) >> 8
}

fn median_luma(photo: &Image<Straight>, mask: &Mask) -> i32 {
    let inside = photo
        .pixels()
        .iter()
        .zip(mask.pixels())
        .filter(|(_, inside)| **inside);
    let mut lumas: Vec<i32> = inside.map(|(&pixel, _)| luma(pixel)).collect();
    let middle = lumas.len() / 2;
    if lumas.is_empty() {
        return 0;
    }
    *lumas.select_nth_unstable(middle).1
}

fn without_islands(mask: &Mask) -> Mask {
    let labels = labelled_components(mask);
    let count = labels
        .pixels()
        .iter()
        .max()
        .map_or(0, |&last| last as usize + 1);
    let mut sizes = vec![0usize; count];
    for &label in labels.pixels() {
        sizes[label as usize] += 1;
    }
    both(mask, &labels, |inside, label| {
        inside && sizes[label as usize] >= SMALLEST_ISLAND
    })
}

fn paired(photo: &Image<Straight>, mask: &Mask, decide: impl Fn(Straight, bool) -> bool) -> Mask {
    both(photo, mask, decide)
}

/// What `decide` says of the pixels of two images of one size.
fn both<P: Copy, Q: Copy>(a: &Image<P>, b: &Image<Q>, decide: impl Fn(P, Q) -> bool) -> Mask {
    let pixels = a
        .pixels()
        .iter()
        .zip(b.pixels())
        .map(|(&p, &q)| decide(p, q));
    Image::from_pixels(a.width(), a.height(), pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAF: Straight = Straight([60, 110, 40, 255]);
    const SHADE: Straight = Straight([30, 50, 25, 255]);
    const SKY: Straight = Straight([140, 180, 235, 255]);

    /// A square crown of leaves before the sky, with a gap of 4×4 in it.
    fn crown() -> (Image<Straight>, Mask) {
        let mut photo = Image::filled(40, 40, SKY);
        let mut mask = Image::filled(40, 40, false);
        for y in 6..34 {
            for x in 6..34 {
                let gap = (18..22).contains(&x) && (18..22).contains(&y);
                let leaf = if (x + y) % 3 == 0 { SHADE } else { LEAF };
                photo.set(x, y, if gap { SKY } else { leaf });
                mask.set(x, y, true);
            }
        }
        (photo, mask)
    }

    #[test]
    fn the_rim_and_the_sky_in_gaps_are_left_out() {
        let (photo, mask) = crown();
        let kept = foliage(&photo, &mask, 1, true);
        assert!(!kept.at(6, 20) && kept.at(7, 20));
        assert!(!kept.at(19, 19), "sky");
        assert!(!kept.at(17, 19), "next to sky");
        assert!(kept.at(16, 19));
        let with_sky = foliage(&photo, &mask, 1, false);
        assert_eq!(with_sky.count(), 26 * 26);
        assert_eq!(kept.count(), 26 * 26 - 6 * 6);
    }

    #[test]
    fn a_cut_out_has_no_sky_and_clear_pixels_are_no_foliage() {
        let (photo, mask) = crown();
        let cut = Image::from_pixels(
            40,
            40,
            photo
                .pixels()
                .iter()
                .map(|&pixel| {
                    if pixel == SKY {
                        Straight([0; 4])
                    } else {
                        pixel
                    }
                })
                .collect(),
        );
        let kept = foliage(&cut, &mask, 1, true);
        assert_eq!(kept.count(), 26 * 26 - 6 * 6);
    }
}
