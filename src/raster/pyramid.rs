//! A picture at half, a quarter, an eighth … of its size, for looking at it from afar.
//!
//! Each level is the mean of four pixels of the one before, of premultiplied colours, so that clear
//! pixels lend no colour. At an odd border the pixels that are there count. Memory: a third of the
//! picture's.

use super::image::{Image, Premultiplied, Straight};
use crate::base::{Cancel, Cancelled};
use rayon::prelude::*;

/// The smaller versions of a picture.
///
/// ```
/// use boscage::base::Cancel;
/// use boscage::raster::{Image, Premultiplied, Pyramid, Straight};
/// let picture = Image::from_pixels(3, 1, [10, 20, 99].map(|l| Straight([l, l, l, 255])).to_vec());
/// let pyramid = Pyramid::of(&picture, 1, &Cancel::new()).unwrap();
/// let half = pyramid.level(1).unwrap();
/// assert_eq!(half.pixels(), &[15, 99].map(|l| Premultiplied([l, l, l, 255])));
/// assert_eq!(pyramid.levels(), 2);
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pyramid {
    /// From the half on.
    smaller: Vec<Image<Premultiplied>>,
}

impl Pyramid {
    /// The pyramid over `picture`, down to the first level of which no side is longer than
    /// `enough_px`.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of(
        picture: &Image<Straight>,
        enough_px: u32,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let mut smaller: Vec<Image<Premultiplied>> = Vec::new();
        let enough = enough_px.max(1);
        let (mut width, mut height) = (picture.width(), picture.height());
        while width.max(height) > enough {
            let half = match smaller.last() {
                None => halved(picture, |pixel| pixel.premultiplied().0, cancel)?,
                Some(last) => halved(last, |pixel| pixel.0, cancel)?,
            };
            (width, height) = (half.width(), half.height());
            smaller.push(half);
        }
        Ok(Self { smaller })
    }

    /// The picture at 1/2^`level` of its size; `None` for the picture itself and beyond the last.
    pub fn level(&self, level: u32) -> Option<&Image<Premultiplied>> {
        self.smaller.get(level.checked_sub(1)? as usize)
    }

    /// The number of levels besides the picture itself: the last one's number.
    pub fn levels(&self) -> u32 {
        self.smaller.len() as u32
    }
}

/// The picture at half its size, rounded up.
fn halved<P: Copy + Sync>(
    picture: &Image<P>,
    premultiplied: impl Fn(P) -> [u8; 4] + Sync,
    cancel: &Cancel,
) -> Result<Image<Premultiplied>, Cancelled> {
    let (width, height) = (picture.width().div_ceil(2), picture.height().div_ceil(2));
    let mut half = Image::filled(width, height, Premultiplied([0; 4]));
    let rows = half.pixels_mut().par_chunks_exact_mut(width as usize);
    rows.enumerate().try_for_each(|(y, row)| {
        cancel.check()?;
        let upper = picture.row(2 * y as u32);
        let lower = picture.row((2 * y as u32 + 1).min(picture.height() - 1));
        let pairs = upper.chunks(2).zip(lower.chunks(2));
        for (pixel, (upper, lower)) in row.iter_mut().zip(pairs) {
            // At an odd border the last column or row counts twice: the mean stays the same.
            let four = [
                upper[0],
                upper[upper.len() - 1],
                lower[0],
                lower[lower.len() - 1],
            ];
            let sum = four
                .map(&premultiplied)
                .into_iter()
                .fold([2_u16; 4], |sum, own| {
                    std::array::from_fn(|c| sum[c] + u16::from(own[c]))
                });
            *pixel = Premultiplied(sum.map(|sum| (sum / 4) as u8));
        }
        Ok(())
    })?;
    Ok(half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clear_pixels_lend_no_colour() {
        let picture = Image::from_pixels(
            2,
            2,
            vec![
                Straight([200, 0, 0, 255]),
                Straight([0, 255, 0, 0]),
                Straight([0, 255, 0, 0]),
                Straight([200, 0, 0, 255]),
            ],
        );
        let pyramid = Pyramid::of(&picture, 1, &Cancel::new()).unwrap();
        assert_eq!(pyramid.level(1).unwrap().at(0, 0).0, [100, 0, 0, 128]);
    }

    #[test]
    fn sides_are_halved_rounding_up() {
        let picture = Image::filled(37, 5, Straight([9, 9, 9, 255]));
        let pyramid = Pyramid::of(&picture, 4, &Cancel::new()).unwrap();
        let sides: Vec<_> = (1..=pyramid.levels())
            .map(|level| pyramid.level(level).unwrap())
            .map(|image| (image.width(), image.height()))
            .collect();
        assert_eq!(sides, [(19, 3), (10, 2), (5, 1), (3, 1)]);
        assert_eq!(pyramid.level(0), None);
        assert_eq!(pyramid.level(5), None);
        for level in 1..=4 {
            let image = pyramid.level(level).unwrap();
            assert!(image.pixels().iter().all(|p| p.0 == [9, 9, 9, 255]));
        }
    }
}
