//! Colours of one tree given to another by matching histograms.
//!
//! Each channel's values are replaced so that their distribution becomes that of the reference:
//! value v of the source, below or at which a share q of its pixels lies, becomes the value below
//! or at which the same share of the reference lies, interpolated between the values that the
//! reference has. Only pixels that show (alpha above 0) count. The rule, to the last bit, is that
//! of scikit-image's `match_histograms`, fractions cut off as there, so that results can be
//! compared.
//!
//! Several references are blended as distributions, not as pictures: the share q becomes the
//! weighted mean of the values that it has in each of them (Σ wᵢ·qᵢ, the barycentre in one
//! dimension), which keeps contrast where a mean of pictures would turn grey.
//!
//! Limits: channels are matched one by one, so colours that neither picture has can come up.

use crate::raster::{Image, Straight};
use crate::segment::{Label, Labels};

/// Added before fractions are cut off: a weighted mean of equal values may miss them by a rounding
/// error. Far below any fraction that a picture of real size can give.
const ROUNDING_SLACK: f64 = 1e-9;

/// How many pixels have each value of each colour channel.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Histogram {
    counts: [[u64; 256]; 3],
}

impl Histogram {
    /// The histogram of some pixels, those of alpha 0 left out.
    pub fn of_pixels(pixels: impl IntoIterator<Item = Straight>) -> Self {
        let mut counts = [[0; 256]; 3];
        for pixel in pixels {
            if pixel.alpha() > 0 {
                for (channel, counts) in counts.iter_mut().enumerate() {
                    counts[usize::from(pixel.0[channel])] += 1;
                }
            }
        }
        Self { counts }
    }

    /// The histogram of all pixels of `image` that show.
    pub fn of(image: &Image<Straight>) -> Self {
        Self::of_pixels(image.pixels().iter().copied())
    }

    /// The histogram of the pixels of `image` that show and have this `label`.
    ///
    /// # Panics
    /// When `labels` has another number of pixels than `image`.
    pub fn of_label(image: &Image<Straight>, labels: &Labels, label: Label) -> Self {
        assert_eq!(image.pixels().len(), labels.pixels().len(), "one for each");
        let pixels = image.pixels().iter().zip(labels.pixels());
        Self::of_pixels(
            pixels
                .filter(|(_, l)| **l == label)
                .map(|(pixel, _)| *pixel),
        )
    }

    /// The share of the pixels in each of `bins` equal ranges of red, green and blue; the last bin is
    /// open where 256 is no multiple of `bins`.
    pub fn shares(&self, bins: usize) -> [Vec<f64>; 3] {
        let width = 256usize.div_ceil(bins.max(1));
        let all = self.pixel_count().max(1) as f64;
        let of = |counts: &[u64; 256]| {
            let bins = counts.chunks(width);
            bins.map(|bin| bin.iter().sum::<u64>() as f64 / all)
                .collect()
        };
        [
            of(&self.counts[0]),
            of(&self.counts[1]),
            of(&self.counts[2]),
        ]
    }

    /// Number of pixels counted.
    pub fn pixel_count(&self) -> u64 {
        self.counts[0].iter().sum()
    }
}

/// For each channel and value the value that takes its place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Transfer {
    table: [[u8; 256]; 3],
}

impl Transfer {
    /// The transfer that changes nothing.
    pub fn identity() -> Self {
        let row = std::array::from_fn(|value| value as u8);
        Self { table: [row; 3] }
    }

    /// The transfer that gives pixels of histogram `source` the histogram `reference`; the
    /// identity when either is empty.
    ///
    /// ```
    /// use boscage::raster::Straight;
    /// use boscage::variation::{Histogram, Transfer};
    /// let grey = |values: &[u8]| {
    ///     Histogram::of_pixels(values.iter().map(|&v| Straight([v, v, v, 255])))
    /// };
    /// let transfer = Transfer::between(&grey(&[10, 20]), &grey(&[100, 180]));
    /// assert_eq!(transfer.applied(Straight([10, 20, 20, 9])), Straight([100, 180, 180, 9]));
    /// ```
    pub fn between(source: &Histogram, reference: &Histogram) -> Self {
        Self::towards(source, &[(reference, 1.0)])
    }

    /// The transfer that gives pixels of histogram `source` the blend of several histograms;
    /// weights are non-negative and of any positive sum, empty histograms are left out. The identity
    /// when nothing remains.
    pub fn towards(source: &Histogram, references: &[(&Histogram, f64)]) -> Self {
        let used = references
            .iter()
            .filter(|(reference, weight)| reference.pixel_count() > 0 && *weight > 0.0);
        let used: Vec<(&Histogram, f64)> = used.copied().collect();
        let sum: f64 = used.iter().map(|(_, weight)| weight).sum();
        let mut transfer = Self::identity();
        if source.pixel_count() == 0 || used.is_empty() {
            return transfer;
        }
        for (channel, row) in transfer.table.iter_mut().enumerate() {
            let mut blend = [0.0; 256];
            for (reference, weight) in &used {
                let matched = matched(&source.counts[channel], &reference.counts[channel]);
                for (value, matched) in blend.iter_mut().zip(matched) {
                    *value += matched * (weight / sum);
                }
            }
            *row = blend.map(|value| (value + ROUNDING_SLACK) as u8);
        }
        transfer
    }

    /// The pixel with its colours replaced; alpha stays, and a pixel of alpha 0 stays as it is.
    #[inline]
    pub fn applied(&self, pixel: Straight) -> Straight {
        let [r, g, b, a] = pixel.0;
        if a == 0 {
            return pixel;
        }
        let [red, green, blue] = &self.table;
        Straight([
            red[usize::from(r)],
            green[usize::from(g)],
            blue[usize::from(b)],
            a,
        ])
    }

    /// Replaces the colours of all pixels of `image` that show.
    pub fn apply(&self, image: &mut Image<Straight>) {
        for pixel in image.pixels_mut() {
            *pixel = self.applied(*pixel);
        }
    }
}

/// For each value of a source channel the value of the same rank in the reference channel; neither
/// may be empty.
fn matched(source: &[u64; 256], reference: &[u64; 256]) -> [f64; 256] {
    let shares = shares(source);
    let present: Vec<usize> = (0..256).filter(|&value| reference[value] > 0).collect();
    let reference_shares = self::shares(reference);
    let knots: Vec<(f64, f64)> = present
        .iter()
        .map(|&value| (reference_shares[value], value as f64))
        .collect();
    shares.map(|share| interpolated(&knots, share))
}

/// For each value the share of pixels at or below it.
fn shares(counts: &[u64; 256]) -> [f64; 256] {
    let total: u64 = counts.iter().sum();
    let mut sum = 0;
    counts.map(|count| {
        sum += count;
        sum as f64 / total as f64
    })
}

/// The piecewise linear function through `knots`, constant before the first and after the last.
///
/// The order of operations is that of NumPy's `interp`: the fractions are cut off later, so the
/// last bit may matter.
fn interpolated(knots: &[(f64, f64)], x: f64) -> f64 {
    let after = knots.partition_point(|knot| knot.0 <= x);
    match (
        after.checked_sub(1).map(|before| knots[before]),
        knots.get(after),
    ) {
        (None, Some(first)) => first.1,
        (Some(before), Some(after)) => {
            let slope = (after.1 - before.1) / (after.0 - before.0);
            slope * (x - before.0) + before.1
        }
        (Some(last), None) => last.1,
        (None, None) => unreachable!("a histogram that is not empty has a value"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_of_bins_sum_to_one() {
        let pixels = [[0, 10, 255, 255], [3, 200, 255, 255], [9, 9, 9, 0]];
        let histogram = Histogram::of_pixels(pixels.map(Straight));
        let [red, green, blue] = histogram.shares(64);
        assert_eq!(red[0], 1.0);
        assert_eq!((green[2], green[50]), (0.5, 0.5));
        assert_eq!(blue[63], 1.0);
        assert_eq!(Histogram::of_pixels([]).shares(64)[0], [0.0; 64]);
    }
    use crate::base::Seed;

    fn noise(seed: u64, low: f64, high: f64) -> Image<Straight> {
        let mut random = Seed(seed).random();
        let pixels = (0..900).map(|_| {
            let mut value = || random.between(low, high) as u8;
            Straight([value(), value(), value(), value() | 1])
        });
        Image::from_pixels(30, 30, pixels.collect())
    }

    #[test]
    fn a_picture_matched_to_itself_stays_whatever_the_weights() {
        let image = noise(1, 0.0, 256.0);
        let own = Histogram::of(&image);
        let thirds = [(&own, 0.1), (&own, 0.2), (&own, 0.4)];
        for transfer in [
            Transfer::between(&own, &own),
            Transfer::towards(&own, &thirds),
        ] {
            let mut changed = image.clone();
            transfer.apply(&mut changed);
            assert_eq!(changed, image);
        }
    }

    #[test]
    fn transfers_are_monotone_and_stay_in_the_range_of_the_reference() {
        let (source, reference) = (noise(2, 0.0, 200.0), noise(3, 90.0, 120.0));
        let transfer = Transfer::between(&Histogram::of(&source), &Histogram::of(&reference));
        for row in &transfer.table {
            assert!(row.is_sorted());
            assert!(row[0] >= 90 && row[255] < 120);
        }
    }

    #[test]
    fn clear_pixels_neither_count_nor_change() {
        let clear = Straight([200, 200, 200, 0]);
        let mut image = Image::from_pixels(2, 1, vec![clear, Straight([10, 10, 10, 255])]);
        let histogram = Histogram::of(&image);
        assert_eq!(histogram.pixel_count(), 1);
        let reference = Histogram::of_pixels([Straight([50, 60, 70, 1])]);
        Transfer::between(&histogram, &reference).apply(&mut image);
        assert_eq!(image.pixels(), [clear, Straight([50, 60, 70, 255])]);
    }

    #[test]
    fn nothing_to_match_changes_nothing() {
        let some = Histogram::of(&noise(4, 0.0, 99.0));
        let empty = Histogram::of_pixels([]);
        assert_eq!(Transfer::between(&empty, &some), Transfer::identity());
        assert_eq!(Transfer::between(&some, &empty), Transfer::identity());
        let with_empty = Transfer::towards(&some, &[(&empty, 5.0), (&some, 1.0)]);
        assert_eq!(with_empty, Transfer::between(&some, &some));
    }

    #[test]
    fn labels_choose_the_pixels() {
        let image = noise(5, 0.0, 256.0);
        let labels = Image::from_pixels(30, 30, [Label::Crown, Label::Trunk].repeat(450));
        let parts = [Label::Crown, Label::Trunk, Label::Background]
            .map(|label| Histogram::of_label(&image, &labels, label).pixel_count());
        assert_eq!(parts, [450, 450, 0]);
    }
}
