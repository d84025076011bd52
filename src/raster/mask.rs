//! Masks: which pixels belong. Thresholds, bounds, dilation, components, flooding.

use super::{Image, Rect};
use imageproc::distance_transform::Norm;

/// `true` where a pixel belongs.
pub type Mask = Image<bool>;

impl Mask {
    /// The mask as 8-bit grey: 255 where a pixel belongs, 0 elsewhere.
    pub fn grey(&self) -> Image<u8> {
        self.map(|&inside| if inside { 255 } else { 0 })
    }

    /// Number of pixels that belong.
    pub fn count(&self) -> usize {
        self.pixels().iter().filter(|&&inside| inside).count()
    }

    pub(super) fn gray_image(&self) -> image::GrayImage {
        into_gray_image(self.grey())
    }
}

/// The smallest rectangle around all pixels that belong, `None` when there are none.
///
/// ```
/// use boscage::raster::{Image, Rect, opaque_bounds};
/// let mask = Image::from_pixels(3, 2, vec![false, false, false, false, true, true]);
/// let bounds = opaque_bounds(&mask).unwrap();
/// assert_eq!(bounds, Rect { x: 1, y: 1, width: 2, height: 1 });
/// ```
pub fn opaque_bounds(mask: &Mask) -> Option<Rect> {
    let occupied = |y: &u32| mask.row(*y).contains(&true);
    let top = (0..mask.height()).find(occupied)?;
    let bottom = (top..mask.height()).rev().find(occupied)?;
    let (mut left, mut right) = (u32::MAX, 0);
    for y in top..=bottom {
        if let Some([first, last]) = row_ends(mask.row(y), |&inside| inside) {
            (left, right) = (left.min(first as u32), right.max(last as u32));
        }
    }
    Some(Rect {
        x: left,
        y: top,
        width: right - left + 1,
        height: bottom - top + 1,
    })
}

/// First and last place in `row` that `is` what is looked for.
pub fn row_ends<T>(row: &[T], is: impl Fn(&T) -> bool) -> Option<[usize; 2]> {
    Some([row.iter().position(&is)?, row.iter().rposition(&is)?])
}

/// The mask grown by `radius` pixels in all eight directions: what `radius` dilations with a 3×3
/// square give.
pub fn dilated(mask: &Mask, radius: u8) -> Mask {
    let grown = imageproc::morphology::dilate(&mask.gray_image(), Norm::LInf, radius);
    Image::from_pixels(
        mask.width(),
        mask.height(),
        grown
            .into_raw()
            .into_iter()
            .map(|value| value != 0)
            .collect(),
    )
}

/// The mask shrunk by `radius` pixels in all eight directions, but not from the picture's edges: with
/// [`dilated`] before it, gaps up to twice `radius` wide are closed.
pub fn eroded(mask: &Mask, radius: u8) -> Mask {
    dilated(&mask.map(|inside| !inside), radius).map(|outside| !outside)
}

/// The mask with gaps and bays up to twice `radius` wide closed, and with all holes filled.
pub fn closed_and_filled(mask: &Mask, radius: u8) -> Mask {
    eroded(&flooded_from_outside(&dilated(mask, radius)), radius)
}

/// All pixels that cannot be reached from outside the image without crossing `barrier`; the
/// barrier itself is kept. Steps go to the four neighbours, so an 8-connected barrier holds.
///
/// This is how the outline of a synthetic tree becomes its mask, robust against an outline that
/// crosses itself (Argudo, Andújar & Chica 2017, *Tree Variations*, §5.1).
pub fn flooded_from_outside(barrier: &Mask) -> Mask {
    let (width, height) = (barrier.width() as usize, barrier.height() as usize);
    // What the flood cannot enter: the barrier, and where it has been.
    let mut closed = barrier.clone();
    let mut kept = Image::filled(barrier.width(), barrier.height(), true);
    let mut seeds: Vec<(usize, usize)> = Vec::new();
    for x in 0..width {
        seeds.extend([(x, 0), (x, height - 1)]);
    }
    for y in 0..height {
        seeds.extend([(0, y), (width - 1, y)]);
    }
    while let Some((x, y)) = seeds.pop() {
        let row = closed.row_mut(y as u32);
        if row[x] {
            continue;
        }
        // The whole run of open pixels around the seed at once.
        let is_closed = |closed: &bool| *closed;
        let first = row[..x].iter().rposition(is_closed).map_or(0, |i| i + 1);
        let end = row[x..].iter().position(is_closed).map_or(width, |i| x + i);
        row[first..end].fill(true);
        kept.row_mut(y as u32)[first..end].fill(false);
        for next in [y.wrapping_sub(1), y + 1] {
            if next < height {
                seed_runs(closed.row(next as u32), first, end, next, &mut seeds);
            }
        }
    }
    kept
}

/// Adds to `seeds` the first pixel of each open run between the columns `first` and `end` of `row`.
fn seed_runs(row: &[bool], first: usize, end: usize, y: usize, seeds: &mut Vec<(usize, usize)>) {
    let mut before = true;
    for (x, &closed) in row.iter().enumerate().take(end).skip(first) {
        if before && !closed {
            seeds.push((x, y));
        }
        before = closed;
    }
}

fn into_gray_image(image: Image<u8>) -> image::GrayImage {
    let (width, height) = (image.width(), image.height());
    image::GrayImage::from_raw(width, height, image.into_pixels())
        .unwrap_or_else(|| unreachable!("an image's pixels fill it"))
}

/// A mask drawn in rows of characters: `#` is set, anything else is not.
#[cfg(test)]
pub(crate) fn mask(rows: &[&str]) -> Mask {
    let pixels = rows.iter().flat_map(|row| row.bytes().map(|b| b == b'#'));
    Image::from_pixels(rows[0].len() as u32, rows.len() as u32, pixels.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dilation_is_square() {
        let grown = dilated(&mask(&[".....", ".....", "..#..", ".....", "....."]), 1);
        assert_eq!(grown, mask(&[".....", ".###.", ".###.", ".###.", "....."]));
    }

    #[test]
    fn flooding_keeps_what_the_barrier_encloses() {
        let barrier = mask(&[".#...", "#.#..", "#..#.", ".##..", "....."]);
        let kept = flooded_from_outside(&barrier);
        assert_eq!(kept, mask(&[".#...", "###..", "####.", ".##..", "....."]));
    }

    #[test]
    fn an_empty_mask_has_no_bounds() {
        assert_eq!(opaque_bounds(&mask(&["..", ".."])), None);
    }
}
