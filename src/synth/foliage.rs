//! Which pixels of a photograph are foliage: the only ones that a texture may be made of.
//!
//! A mask drawn around a crown holds more than leaves: a rim of pixels mixed with what lies behind,
//! and patches of sky that show through. The rim is eroded. Sky is told from leaves by comparing two
//! colour histograms, one of what lies outside the mask and one of what lies inside: a colour that
//! is more at home outside, is at least as blue as it is green, and is brighter than half of the
//! crown, is sky. Where the sky is bluer than the leaves, so is what has more of its hue than of theirs; and
//! the neighbours of all that, in which lens and camera mixed both.
//!
//! Limits: grass and other trees behind gaps have the colours of leaves and stay. A cut-out without a
//! background has nothing to compare with; nothing is taken for sky.

use crate::raster::{Image, Mask, Straight, component_sizes, dilated, labelled_components};

/// Bits a channel of a histogram's bin: 16 levels. Finer ones are empty on small pictures, coarser
/// ones mix haze with silver leaves.
const BITS: u32 = 4;
const SIDE: usize = 1 << BITS;

/// How much larger blue's share must be in the sky than in leaves for mixtures to be told.
const BLUER: f32 = 0.06;

/// How far from leaves to sky blue's share must be for a mixture: half of the way.
const MIXTURE: f32 = 0.5;

/// How much less blue than green a colour may be and still be sky, of 255: white clouds have none.
const BLUE_SLACK: i32 = 10;

/// Islands of fewer pixels than this cannot be recognised in a window of 7×7 and are left out.
const SMALLEST_ISLAND: usize = 12;

/// Share of the eroded mask that must stay when sky is taken out; below, the comparison was wrong
/// (a white tree before a blue wall) and nothing is.
const LEAST_SHARE: f64 = 0.3;

/// Pixels around sky that may be mixed with it: lens, camera and resizing each spread it by about one.
const AROUND_SKY: u8 = 2;

/// How much more blue than red and green a pixel must be to be taken for a mixture with a blue sky
/// wherever it is, of 255: even shade, which the sky lights, is hardly bluer than green in leaves.
const BLUER_THAN_LEAVES: i32 = 5;

/// How much of a pixel near sky must be leaf for its colour to be told. Lower, and the noise of the
/// sky is seen in it; higher, and a thin crown has nothing left to show.
const LEAST_COVER: f32 = 0.5;

/// The colours around a crown, which sky is told by.
#[derive(Debug, Clone)]
pub(super) struct Backdrop(Vec<f32>);

impl Backdrop {
    /// Those of the opaque pixels of `photo` outside `mask`; `None` for a cut-out.
    pub(super) fn of(photo: &Image<Straight>, mask: &Mask) -> Option<Self> {
        let outside = both(photo, mask, |pixel, inside| !inside && pixel.alpha() >= 128);
        histogram(photo, &outside).map(Self)
    }
}

/// The foliage of `photo` inside `mask`: opaque pixels at least `erosion` pixels from the mask's
/// edge, without sky when there is a `backdrop` (it grows by one pixel), and without tiny islands.
pub(super) fn foliage(
    photo: &Image<Straight>,
    mask: &Mask,
    erosion: u8,
    backdrop: Option<&Backdrop>,
) -> Mask {
    let outside = both(photo, mask, |pixel, inside| !inside || pixel.alpha() < 128);
    let grown = dilated(&outside, erosion);
    let inner = grown.map(|&outside| !outside);
    let mut kept = inner.clone();
    if let Some(sky) = backdrop.and_then(|backdrop| sky(photo, &inner, backdrop)) {
        let sky = dilated(&sky, 1);
        let without = both(&inner, &sky, |inside, sky| inside && !sky);
        if without.count() as f64 >= LEAST_SHARE * inner.count() as f64 {
            kept = without;
        }
    }
    without_islands(&kept)
}

/// The pixels of `photo` inside `mask` that show the crown: opaque, no sky, and near sky at least
/// [`LEAST_COVER`] leaf; without islands that are too small to tell what they show. And the photograph
/// with the sky taken out of those that are mixed with it.
pub(super) fn shown(
    photo: &Image<Straight>,
    mask: &Mask,
    backdrop: Option<&Backdrop>,
) -> (Mask, Image<Straight>) {
    let inner = both(photo, mask, |pixel, inside| inside && pixel.alpha() >= 128);
    let Some(sky) = backdrop.and_then(|backdrop| sky(photo, &inner, backdrop)) else {
        return (inner, photo.clone());
    };
    let near = dilated(&sky, AROUND_SKY);
    let leaves = both(&inner, &near, |inside, near| inside && !near);
    let clear = both(&inner, &sky, |inside, sky| inside && !sky);
    let colors = median_color(photo, &leaves)
        .or_else(|| median_color(photo, &clear))
        .zip(median_color(photo, &sky));
    let Some((leaf, behind)) = colors else {
        return (clear, photo.clone());
    };
    let (mut shown, mut pure) = (clear.clone(), photo.clone());
    for y in 0..photo.height() {
        for x in (0..photo.width()).filter(|&x| clear.at(x, y)) {
            let pixel = photo.at(x, y);
            if is_bluer(pixel, leaf, behind) {
                shown.set(x, y, false);
            } else if near.at(x, y) {
                let behind = mean_around(photo, &sky, [x, y]).unwrap_or(behind);
                match unmixed(pixel, leaf, behind) {
                    Some(color) => pure.set(x, y, color),
                    None => shown.set(x, y, false),
                }
            }
        }
    }
    (without_islands(&shown), pure)
}

/// Whether `pixel` is blue and no leaf can be: where the colour `behind` is bluer than `leaf`, and that
/// of the pixel nearer to it than to the other.
fn is_bluer(pixel: Straight, leaf: [f32; 3], behind: [f32; 3]) -> bool {
    let [r, g, b, _] = pixel.0.map(i32::from);
    b > r.max(g) + BLUER_THAN_LEAVES
        && cover_by_blue(pixel, leaf, behind).is_some_and(|cover| cover < 1.0 - MIXTURE)
}

/// As [`cover`], told by the share of blue, which light leaves and shade have alike; `None` where the
/// two colours hardly differ in it.
fn cover_by_blue(pixel: Straight, leaf: [f32; 3], behind: [f32; 3]) -> Option<f32> {
    let blue = |[r, g, b]: [f32; 3]| b / (r + g + b).max(1.0);
    let (leaf, behind) = (blue(leaf), blue(behind));
    (behind - leaf > BLUER).then(|| (behind - blue_share(pixel)) / (behind - leaf))
}

/// The mean colour of the pixels of `mask` within [`AROUND_SKY`] of (x, y).
fn mean_around(photo: &Image<Straight>, mask: &Mask, [x, y]: [u32; 2]) -> Option<[f32; 3]> {
    let reach = u32::from(AROUND_SKY);
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for v in y.saturating_sub(reach)..(y + reach + 1).min(photo.height()) {
        for u in x.saturating_sub(reach)..(x + reach + 1).min(photo.width()) {
            if mask.at(u, v) {
                let pixel = photo.at(u, v).0;
                sum = [0, 1, 2].map(|i| sum[i] + f32::from(pixel[i]));
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| sum.map(|sum| sum / count))
}

/// What is before the colour `behind` in a pixel that is mixed of it and of leaves, whose colour is
/// about `leaf`; `None` when that is too little of it.
fn unmixed(pixel: Straight, leaf: [f32; 3], behind: [f32; 3]) -> Option<Straight> {
    let by_blue = cover_by_blue(pixel, leaf, behind).unwrap_or(0.0);
    let cover = cover(pixel, leaf, behind).max(by_blue);
    if cover >= 1.0 {
        return Some(pixel);
    }
    let channel = |i: usize| {
        let value = (f32::from(pixel.0[i]) - (1.0 - cover) * behind[i]) / cover;
        (value + 0.5).clamp(0.0, 255.0) as u8
    };
    (cover >= LEAST_COVER).then(|| Straight([channel(0), channel(1), channel(2), pixel.alpha()]))
}

/// How much of `pixel` is covered by what has the colour `leaf` before what has the colour `behind`: 0
/// … 1 in between, and beyond for other colours.
fn cover(pixel: Straight, leaf: [f32; 3], behind: [f32; 3]) -> f32 {
    let (mut along, mut whole) = (0.0, 0.0);
    for i in 0..3 {
        let towards = leaf[i] - behind[i];
        along += (f32::from(pixel.0[i]) - behind[i]) * towards;
        whole += towards * towards;
    }
    along / whole.max(1.0)
}

/// The median of each channel over the pixels of `mask`; `None` when there are none.
fn median_color(photo: &Image<Straight>, mask: &Mask) -> Option<[f32; 3]> {
    let channel = |i: usize| median(photo, mask, |pixel| f32::from(pixel.0[i]));
    Some([channel(0)?, channel(1)?, channel(2)?])
}

/// The pixels of `inner` whose colours are those of the sky around the crown; `None` when `inner` is
/// empty.
fn sky(photo: &Image<Straight>, inner: &Mask, Backdrop(behind): &Backdrop) -> Option<Mask> {
    let before = histogram(photo, inner)?;
    let middle = median(photo, inner, |pixel| luma(pixel) as f32)?;
    let is_sky = |pixel: Straight, inside: bool| {
        let [r, g, b, _] = pixel.0.map(i32::from);
        inside
            && b + BLUE_SLACK >= g
            && b + BLUE_SLACK >= r
            && luma(pixel) as f32 > middle
            && behind[bin(pixel)] > before[bin(pixel)]
    };
    let sky = both(photo, inner, is_sky);
    Some(with_mixtures(photo, inner, &sky, middle))
}

/// `sky` and the pixels of `inner` that are a mixture of it and leaves, told by the share of blue:
/// light and shade leave it alone.
fn with_mixtures(photo: &Image<Straight>, inner: &Mask, sky: &Mask, middle: f32) -> Mask {
    let leaves = both(inner, sky, |inside, sky| inside && !sky);
    let shares = median(photo, &leaves, blue_share).zip(median(photo, sky, blue_share));
    let Some((of_leaves, of_sky)) = shares.filter(|(leaves, sky)| sky - leaves > BLUER) else {
        return sky.clone();
    };
    let limit = of_leaves + MIXTURE * (of_sky - of_leaves);
    // Shade is blue as well, but not brighter than half of the crown, nor are lit leaves less green.
    let mixed = both(photo, inner, |pixel, inside| {
        let [_, g, b, _] = pixel.0.map(i32::from);
        let is_light = luma(pixel) as f32 > middle;
        inside && is_light && b + BLUE_SLACK >= g && blue_share(pixel) > limit
    });
    both(sky, &mixed, |sky, mixed| sky || mixed)
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

/// Blue's share of the sum of the channels.
fn blue_share(pixel: Straight) -> f32 {
    let [r, g, b, _] = pixel.0.map(f32::from);
    b / (r + g + b).max(1.0)
}

/// The median of `value` over the pixels of `mask`; `None` when there are none.
fn median(photo: &Image<Straight>, mask: &Mask, value: impl Fn(Straight) -> f32) -> Option<f32> {
    let inside = photo
        .pixels()
        .iter()
        .zip(mask.pixels())
        .filter(|(_, inside)| **inside);
    let mut values: Vec<f32> = inside.map(|(&pixel, _)| value(pixel)).collect();
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

fn without_islands(mask: &Mask) -> Mask {
    let labels = labelled_components(mask);
    let sizes = component_sizes(&labels);
    both(mask, &labels, |inside, label| {
        inside && sizes[label as usize] >= SMALLEST_ISLAND
    })
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
        let backdrop = Backdrop::of(&photo, &mask);
        let kept = foliage(&photo, &mask, 1, backdrop.as_ref());
        assert!(!kept.at(6, 20) && kept.at(7, 20));
        assert!(!kept.at(19, 19), "sky");
        assert!(!kept.at(17, 19), "next to sky");
        assert!(kept.at(16, 19));
        let with_sky = foliage(&photo, &mask, 1, None);
        assert_eq!(with_sky.count(), 26 * 26);
        assert_eq!(kept.count(), 26 * 26 - 6 * 6);
    }

    #[test]
    fn what_is_shown_is_leaf_for_the_most_part() {
        let (mut photo, mask) = crown();
        let mixed = |leaf: f32| {
            let channel = |i: usize| {
                let (a, b) = (f32::from(LEAF.0[i]), f32::from(SKY.0[i]));
                (a * leaf + b * (1.0 - leaf)) as u8
            };
            Straight([channel(0), channel(1), channel(2), 255])
        };
        photo.set(17, 19, mixed(0.3));
        photo.set(17, 20, mixed(0.8));
        let backdrop = Backdrop::of(&photo, &mask);
        let (kept, pure) = shown(&photo, &mask, backdrop.as_ref());
        assert!(kept.at(6, 20), "the rim");
        let unmixed = pure.at(17, 20).0.into_iter().zip(LEAF.0);
        assert!(
            unmixed
                .into_iter()
                .all(|(found, leaf)| found.abs_diff(leaf) <= 4)
        );
        assert!(!kept.at(19, 19) && !kept.at(17, 19) && kept.at(17, 20));
        assert_eq!(kept.count(), 28 * 28 - 17);
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
        let backdrop = Backdrop::of(&cut, &mask);
        assert!(backdrop.is_none());
        let kept = foliage(&cut, &mask, 1, None);
        assert_eq!(kept.count(), 26 * 26 - 6 * 6);
    }
}
