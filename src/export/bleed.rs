//! Colour continued under clear texels, so that no filter ever mixes in the colour of nothing.
//!
//! A texture unit interpolates colour and alpha separately: beside the last leaf it reads the
//! colour of a texel that nobody sees. If that is black, the leaf gets a dark fringe. Here each
//! clear texel gets the colour of the nearest one that is not clear, exactly: the distance
//! transform of Felzenszwalb & Huttenlocher (*Distance transforms of sampled functions*, 2012),
//! which keeps with each distance the texel it belongs to. Linear in the number of texels. (Push and
//! pull, which is smoother, mixes colours from beyond the gap as soon as two texels away.)
//!
//! Of several at the same distance any may be taken, always the same.

use crate::raster::{Image, Straight};
use rayon::prelude::*;

/// `image` with colour under its clear texels; alpha and the colours of all others stay.
///
/// ```
/// use boscage::export::bled;
/// use boscage::raster::{Image, Straight};
/// let image = Image::from_pixels(2, 1, vec![Straight([10, 200, 30, 255]), Straight([0; 4])]);
/// assert_eq!(bled(&image).at(1, 0), Straight([10, 200, 30, 0]));
/// ```
pub fn bled(image: &Image<Straight>) -> Image<Straight> {
    let alpha = image.map(|pixel| pixel.alpha());
    bled_with(image, &Nearest::of(&alpha))
}

/// [`bled`] with the nearest texels at hand.
pub(super) fn bled_with(image: &Image<Straight>, nearest: &Nearest) -> Image<Straight> {
    let mut out = nearest.continued(image);
    for (out, pixel) in out.pixels_mut().iter_mut().zip(image.pixels()) {
        out.0[3] = pixel.alpha();
    }
    out
}

/// `map` with all four channels continued from where `alpha` is above 0 to where it is 0: for maps
/// that belong to a picture of that alpha. Nothing changes where no alpha is above 0.
///
/// # Panics
/// When the two have different sizes.
pub fn bled_from(map: &Image<Straight>, alpha: &Image<u8>) -> Image<Straight> {
    Nearest::of(alpha).continued(map)
}

/// Where each clear texel of a picture takes its values from: found once, for all maps of it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Nearest {
    width: u32,
    height: u32,
    /// For each texel the place of the nearest one above 0 in the list of texels, its own if there
    /// is none.
    places: Vec<u32>,
}

impl Nearest {
    /// The nearest texels where `alpha` is above 0.
    pub(super) fn of(alpha: &Image<u8>) -> Self {
        let nearest_rows = nearest_rows(alpha);
        let width = alpha.width() as usize;
        let mut places: Vec<u32> = (0..alpha.pixels().len() as u32).collect();
        let each = places.par_chunks_mut(width).enumerate();
        each.for_each(|(y, places)| {
            if alpha.row(y as u32).iter().all(|&alpha| alpha > 0) {
                return;
            }
            let rows = &nearest_rows[y * width..(y + 1) * width];
            let Some(columns) = nearest_columns(rows, y) else {
                return;
            };
            for (place, column) in places.iter_mut().zip(columns) {
                *place = rows[column as usize] * width as u32 + column;
            }
        });
        Self {
            width: alpha.width(),
            height: alpha.height(),
            places,
        }
    }

    /// `map` continued under the clear texels.
    ///
    /// # Panics
    /// When `map` is not as large as the picture was.
    pub(super) fn continued<P: Copy>(&self, map: &Image<P>) -> Image<P> {
        assert_eq!(
            (map.width(), map.height()),
            (self.width, self.height),
            "a map is as large as its picture"
        );
        let texels = map.pixels();
        let nearest = self.places.iter().map(|&place| texels[place as usize]);
        Image::from_pixels(self.width, self.height, nearest.collect())
    }
}

/// Where a column has no texel above 0.
const NONE: u32 = u32::MAX;

/// For each texel the row of the nearest one above 0 in its column.
fn nearest_rows(alpha: &Image<u8>) -> Vec<u32> {
    let (width, height) = (alpha.width() as usize, alpha.height() as usize);
    let mut nearest = vec![NONE; width * height];
    // The last one above, then the next one below where that is nearer.
    let mut last = vec![NONE; width];
    for y in 0..height {
        for (x, &alpha) in alpha.row(y as u32).iter().enumerate() {
            if alpha > 0 {
                last[x] = y as u32;
            }
            nearest[y * width + x] = last[x];
        }
    }
    last.fill(NONE);
    for y in (0..height).rev() {
        for (x, next) in last.iter_mut().enumerate() {
            let above = nearest[y * width + x];
            if above == y as u32 {
                *next = above;
            }
            if *next != NONE && (above == NONE || *next - y as u32 <= y as u32 - above) {
                nearest[y * width + x] = *next;
            }
        }
    }
    nearest
}

/// For each texel of row `y` the column through which the nearest texel is reached: the lower
/// envelope of a parabola a column. `None` when there is no texel at all.
fn nearest_columns(rows: &[u32], y: usize) -> Option<Vec<u32>> {
    let squared = |column: usize| {
        let down = f64::from(rows[column]) - y as f64;
        let across = column as f64;
        down * down + across * across
    };
    // Columns on the envelope, and from where on each is the nearest.
    let mut envelope: Vec<(u32, f64)> = Vec::new();
    for column in (0..rows.len()).filter(|&column| rows[column] != NONE) {
        let mut from = f64::NEG_INFINITY;
        while let Some(&(before, begins)) = envelope.last() {
            let span = 2.0 * (column as f64 - f64::from(before));
            from = (squared(column) - squared(before as usize)) / span;
            if from > begins {
                break;
            }
            envelope.pop();
            from = f64::NEG_INFINITY;
        }
        envelope.push((column as u32, from));
    }
    let mut at = 0;
    let nearest = |x: usize| {
        while envelope
            .get(at + 1)
            .is_some_and(|(_, begins)| *begins <= x as f64)
        {
            at += 1;
        }
        envelope.get(at).map(|(column, _)| *column)
    };
    (0..rows.len()).map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_clear_texel_gets_a_nearest_colour(
            (width, alphas) in (1u32..12).prop_flat_map(|width| {
                let rows = 1usize..12;
                let texels = rows.prop_flat_map(move |rows| {
                    prop::collection::vec(prop_oneof![4 => Just(0u8), 1 => 1u8..], rows * width as usize)
                });
                (Just(width), texels)
            })
        ) {
            let height = alphas.len() as u32 / width;
            let place = |i: usize| (i as i64 % i64::from(width), i as i64 / i64::from(width));
            // The colour names the texel.
            let texel = |(i, &alpha): (usize, &u8)| Straight([i as u8, 7, 7, alpha]);
            let image = Image::from_pixels(width, height, alphas.iter().enumerate().map(texel).collect());
            let seen: Vec<usize> = (0..alphas.len()).filter(|&i| alphas[i] > 0).collect();
            let out = bled(&image);
            for (i, pixel) in out.pixels().iter().enumerate() {
                prop_assert_eq!(pixel.alpha(), alphas[i]);
                let squared = |j: usize| {
                    let ((x, y), (u, v)) = (place(i), place(j));
                    (x - u).pow(2) + (y - v).pow(2)
                };
                let nearest = seen.iter().map(|&j| squared(j)).min();
                let expected = nearest.unwrap_or(0);
                prop_assert_eq!(squared(usize::from(pixel.0[0])), expected);
            }
        }
    }
}
