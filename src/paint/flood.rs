//! Selecting by likeness: flood and colour range on the photograph, regions on the labels.

use super::tiled::TiledMask;
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Straight};

/// Rows or runs between two looks at the cancel flag: some milliseconds at most.
const BETWEEN_CHECKS: usize = 256;

/// How far a selection by colour reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reach {
    /// Only what hangs together with the place that was clicked, over the four neighbours.
    Contiguous,
    /// The whole picture.
    Everywhere,
}

/// The pixels whose colour is like the one at `seed`.
///
/// Two colours are alike when none of their four channels differs by more than `tolerance`, as
/// painting programs have it: 0 takes equal ones only. All clear pixels count as one colour.
///
/// ```
/// use boscage::base::Cancel;
/// use boscage::paint::{Reach, color_selection};
/// use boscage::raster::{Image, Straight};
/// let grey = |l: u8| Straight([l, l, l, 255]);
/// let photo = Image::from_pixels(4, 1, [10, 12, 99, 11].map(grey).to_vec());
/// let near = color_selection(&photo, (0, 0), 5, Reach::Contiguous, &Cancel::new()).unwrap();
/// let far = color_selection(&photo, (0, 0), 5, Reach::Everywhere, &Cancel::new()).unwrap();
/// assert_eq!(near.image().pixels(), &[1, 1, 0, 0]);
/// assert_eq!(far.image().pixels(), &[1, 1, 0, 1]);
/// ```
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// When the seed is outside.
pub fn color_selection(
    photo: &Image<Straight>,
    seed: (u32, u32),
    tolerance: u8,
    reach: Reach,
    cancel: &Cancel,
) -> Result<TiledMask, Cancelled> {
    let wanted = visible(photo.at(seed.0, seed.1));
    let alike = |pixel: Straight| {
        let pairs = visible(pixel).into_iter().zip(wanted);
        pairs.fold(0, |most, (a, b)| a.abs_diff(b).max(most)) <= tolerance
    };
    let (width, height) = (photo.width(), photo.height());
    let selected = match reach {
        Reach::Contiguous => flooded(width, height, seed, |x, y| alike(photo.at(x, y)), cancel)?,
        Reach::Everywhere => {
            let mut selected = Image::filled(width, height, false);
            for y in 0..height {
                if (y as usize).is_multiple_of(BETWEEN_CHECKS) {
                    cancel.check()?;
                }
                for (is_in, &pixel) in selected.row_mut(y).iter_mut().zip(photo.row(y)) {
                    *is_in = alike(pixel);
                }
            }
            selected
        }
    };
    Ok(TiledMask::from_mask(&selected, 1))
}

/// The pixels that have the label at `seed` and hang together with it over the four neighbours.
///
/// # Errors
/// [`Cancelled`].
///
/// # Panics
/// When the seed is outside.
pub fn region_selection(
    mask: &TiledMask,
    seed: (u32, u32),
    cancel: &Cancel,
) -> Result<TiledMask, Cancelled> {
    let labels = mask.image();
    let wanted = labels.at(seed.0, seed.1);
    let (width, height) = (mask.width(), mask.height());
    let selected = flooded(
        width,
        height,
        seed,
        |x, y| labels.at(x, y) == wanted,
        cancel,
    )?;
    Ok(TiledMask::from_mask(&selected, 1))
}

/// The colour as it shows: nothing where clear.
fn visible(pixel: Straight) -> [u8; 4] {
    if pixel.alpha() == 0 { [0; 4] } else { pixel.0 }
}

/// The accepted pixels that can be reached from `seed` in steps to the four neighbours.
fn flooded(
    width: u32,
    height: u32,
    seed: (u32, u32),
    accepts: impl Fn(u32, u32) -> bool,
    cancel: &Cancel,
) -> Result<Mask, Cancelled> {
    let mut reached = Image::filled(width, height, false);
    let mut seeds = vec![seed];
    let mut runs = 0;
    while let Some((x, y)) = seeds.pop() {
        if reached.at(x, y) || !accepts(x, y) {
            continue;
        }
        runs += 1;
        if usize::is_multiple_of(runs, BETWEEN_CHECKS) {
            cancel.check()?;
        }
        // The whole run of accepted pixels at once.
        let first = (0..x).rev().find(|&x| !accepts(x, y)).map_or(0, |x| x + 1);
        let end = (x..width).find(|&x| !accepts(x, y)).unwrap_or(width);
        reached.row_mut(y)[first as usize..end as usize].fill(true);
        for next in [y.wrapping_sub(1), y + 1] {
            if next >= height {
                continue;
            }
            let mut before = false;
            for x in first..end {
                let open = !reached.at(x, next) && accepts(x, next);
                if open && !before {
                    seeds.push((x, next));
                }
                before = open;
            }
        }
    }
    cancel.check()?;
    Ok(reached)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Grows by one pixel at a time until nothing is new.
    fn slow_flood(open: &Mask, seed: (u32, u32)) -> Mask {
        let mut reached = open.map(|_| false);
        reached.set(seed.0, seed.1, open.at(seed.0, seed.1));
        loop {
            let before = reached.clone();
            for y in 0..open.height() {
                for x in 0..open.width() {
                    let steps = [(-1, 0), (1, 0), (0, -1), (0, 1)];
                    let near = steps.iter().any(|(dx, dy)| {
                        before.get(i64::from(x) + dx, i64::from(y) + dy) == Some(true)
                    });
                    if near && open.at(x, y) {
                        reached.set(x, y, true);
                    }
                }
            }
            if reached == before {
                return reached;
            }
        }
    }

    proptest! {
        #[test]
        fn flooding_matches_the_slow_one(
            cells in prop::collection::vec(prop::bool::weighted(0.6), 12 * 9),
            x in 0u32..12,
            y in 0u32..9,
        ) {
            let open = Image::from_pixels(12, 9, cells);
            let fast = flooded(12, 9, (x, y), |x, y| open.at(x, y), &Cancel::new()).unwrap();
            prop_assert_eq!(fast, slow_flood(&open, (x, y)));
        }
    }

    #[test]
    fn regions_end_at_other_labels() {
        let labels = Image::from_pixels(5, 1, vec![1, 1, 2, 1, 1]);
        let region = region_selection(&TiledMask::from_image(&labels), (0, 0), &Cancel::new());
        assert_eq!(region.unwrap().image().pixels(), &[1, 1, 0, 0, 0]);
    }

    #[test]
    fn a_raised_flag_stops_the_flood() {
        let cancel = Cancel::new();
        cancel.cancel();
        let mask = TiledMask::filled(300, 300, 1);
        assert_eq!(region_selection(&mask, (0, 0), &cancel), Err(Cancelled));
    }
}
