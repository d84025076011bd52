//! Operations on a whole mask: fill holes, drop specks, invert, mirror.

use super::tiled::{BACKGROUND, TiledMask};
use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Rect};

/// Rows between two looks at the cancel flag.
const BETWEEN_CHECKS: u32 = 64;

/// How a mask is mirrored at a vertical axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mirror {
    /// Left and right change places.
    Flip,
    /// The right side becomes the mirror image of the left.
    LeftToRight,
    /// The left side becomes the mirror image of the right.
    RightToLeft,
}

/// Exchanges `label` and background; other labels stay. Returns what changed.
pub fn inverted(mask: &mut TiledMask, label: u8) -> Option<Rect> {
    mask.edit(mask.rect(), |_, _, row| {
        for pixel in row {
            *pixel = match *pixel {
                BACKGROUND => label,
                own if own == label => BACKGROUND,
                other => other,
            };
        }
    })
}

/// Mirrors `mask` at the axis half-way between columns `x` and `axis_sum − x`; what has no
/// counterpart in the picture becomes background. Returns what changed.
///
/// The middle of a picture is `axis_sum = width − 1`.
pub fn mirrored(mask: &mut TiledMask, mirror: Mirror, axis_sum: i64) -> Option<Rect> {
    let before = mask.image();
    mask.edit(mask.rect(), |first, y, row| {
        for (x, pixel) in (i64::from(first)..).zip(row) {
            let is_replaced = match mirror {
                Mirror::Flip => true,
                Mirror::LeftToRight => 2 * x > axis_sum,
                Mirror::RightToLeft => 2 * x < axis_sum,
            };
            if is_replaced {
                *pixel = before.get(axis_sum - x, i64::from(y)).unwrap_or(BACKGROUND);
            }
        }
    })
}

/// Gives `label` to all background that labelled pixels enclose, up to `most_pixels` a hole; what
/// changed. Background hangs together over the four neighbours; what reaches the border of the
/// picture is no hole.
///
/// # Errors
/// [`Cancelled`]; the mask is then unchanged.
pub fn holes_filled(
    mask: &mut TiledMask,
    label: u8,
    most_pixels: u64,
    cancel: &Cancel,
) -> Result<Option<Rect>, Cancelled> {
    let Some(bounds) = mask.bounds(|own| own != BACKGROUND) else {
        return Ok(None);
    };
    // No hole reaches the bounds: there the labelled pixels end, or the picture does.
    let pieces = Pieces::find(mask, bounds, |own| own == BACKGROUND, Touch::Sides, cancel)?;
    let is_hole = |piece: &Piece| !piece.at_border && piece.pixels <= most_pixels;
    Ok(pieces.give(mask, bounds, label, is_hole))
}

/// Makes background of all pieces of `label` with fewer than `least_pixels`; what changed. Pieces
/// hang together over the eight neighbours.
///
/// # Errors
/// [`Cancelled`]; the mask is then unchanged.
pub fn without_specks(
    mask: &mut TiledMask,
    label: u8,
    least_pixels: u64,
    cancel: &Cancel,
) -> Result<Option<Rect>, Cancelled> {
    let Some(bounds) = mask.bounds(|own| own == label) else {
        return Ok(None);
    };
    let pieces = Pieces::find(mask, bounds, |own| own == label, Touch::Corners, cancel)?;
    Ok(pieces.give(mask, bounds, BACKGROUND, |piece| {
        piece.pixels < least_pixels
    }))
}

/// What makes two pixels neighbours.
#[derive(Clone, Copy, PartialEq)]
enum Touch {
    Sides,
    Corners,
}

/// A run of pixels in a row, in columns of the window.
struct Run {
    y: u32,
    start: u32,
    end: u32,
}

/// What is known of pixels that hang together.
#[derive(Clone, Copy, Default)]
struct Piece {
    pixels: u64,
    at_border: bool,
}

/// Runs of pixels and the piece that each belongs to.
struct Pieces {
    runs: Vec<Run>,
    /// A run of the same piece that is nearer to the piece's first, or the run itself.
    parents: Vec<usize>,
}

impl Pieces {
    /// The pieces of the pixels of `window` that `wanted` wants.
    fn find(
        mask: &TiledMask,
        window: Rect,
        wanted: impl Fn(u8) -> bool,
        touch: Touch,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let (x, y) = (i64::from(window.x), i64::from(window.y));
        let labels = mask.window(x, y, window.width, window.height, BACKGROUND);
        let mut pieces = Self {
            runs: Vec::new(),
            parents: Vec::new(),
        };
        let mut above = 0..0;
        for y in 0..labels.height() {
            if y.is_multiple_of(BETWEEN_CHECKS) {
                cancel.check()?;
            }
            let start = pieces.runs.len();
            pieces.add_runs(&labels, y, &wanted);
            let end = pieces.runs.len();
            pieces.join(above, start..end, touch);
            above = start..end;
        }
        Ok(pieces)
    }

    fn add_runs(&mut self, labels: &Image<u8>, y: u32, wanted: impl Fn(u8) -> bool) {
        let mut x = 0;
        let row = labels.row(y);
        for stretch in row.chunk_by(|a, b| wanted(*a) == wanted(*b)) {
            let end = x + stretch.len() as u32;
            if wanted(stretch[0]) {
                self.parents.push(self.runs.len());
                self.runs.push(Run { y, start: x, end });
            }
            x = end;
        }
    }

    /// Joins the runs of two neighbouring rows that touch.
    fn join(&mut self, above: std::ops::Range<usize>, below: std::ops::Range<usize>, touch: Touch) {
        let slack = u32::from(touch == Touch::Corners);
        let (mut a, mut b) = (above.start, below.start);
        while a < above.end && b < below.end {
            let (upper, lower) = (&self.runs[a], &self.runs[b]);
            if upper.start < lower.end + slack && lower.start < upper.end + slack {
                let (first, second) = (self.root(a), self.root(b));
                self.parents[first.max(second)] = first.min(second);
            }
            if self.runs[a].end <= self.runs[b].end {
                a += 1;
            } else {
                b += 1;
            }
        }
    }

    /// The first run of the piece that run `index` belongs to.
    fn root(&mut self, mut index: usize) -> usize {
        while self.parents[index] != index {
            // Halving the way for those who come after.
            self.parents[index] = self.parents[self.parents[index]];
            index = self.parents[index];
        }
        index
    }

    /// Gives `label` to the pixels of the pieces that `chosen` chooses.
    fn give(
        mut self,
        mask: &mut TiledMask,
        window: Rect,
        label: u8,
        chosen: impl Fn(&Piece) -> bool,
    ) -> Option<Rect> {
        let roots: Vec<usize> = (0..self.runs.len()).map(|index| self.root(index)).collect();
        let mut pieces = vec![Piece::default(); self.runs.len()];
        for (run, &root) in self.runs.iter().zip(&roots) {
            let piece = &mut pieces[root];
            piece.pixels += u64::from(run.end - run.start);
            let at_side = run.start == 0 || run.end == window.width;
            piece.at_border |= at_side || run.y == 0 || run.y + 1 == window.height;
        }
        let mut rows: Vec<Vec<(u32, u32)>> = vec![Vec::new(); window.height as usize];
        for (run, &root) in self.runs.iter().zip(&roots) {
            if chosen(&pieces[root]) {
                rows[run.y as usize].push((window.x + run.start, window.x + run.end));
            }
        }
        mask.edit(window, |first, y, row| {
            let last = first + row.len() as u32;
            for &(start, end) in &rows[(y - window.y) as usize] {
                let (start, end) = (start.max(first), end.min(last));
                if start < end {
                    row[(start - first) as usize..(end - first) as usize].fill(label);
                }
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::CROWN;
    use crate::raster::{flooded_from_outside, labelled_components};
    use proptest::prelude::*;

    fn cells() -> impl Strategy<Value = Image<u8>> {
        prop::collection::vec(prop::bool::weighted(0.55), 14 * 11)
            .prop_map(|cells| Image::from_pixels(14, 11, cells.into_iter().map(u8::from).collect()))
    }

    proptest! {
        #[test]
        fn holes_are_what_the_outside_cannot_reach(image in cells()) {
            let mut mask = TiledMask::from_image(&image);
            holes_filled(&mut mask, CROWN, u64::MAX, &Cancel::new()).unwrap();
            let barrier = image.map(|&label| label == CROWN);
            prop_assert_eq!(mask.mask(|l| l == CROWN), flooded_from_outside(&barrier));
        }

        #[test]
        fn specks_are_small_components(image in cells(), least in 0u64..8) {
            let mut mask = TiledMask::from_image(&image);
            without_specks(&mut mask, CROWN, least, &Cancel::new()).unwrap();
            let components = labelled_components(&image.map(|&label| label == CROWN));
            for (label, &component) in mask.image().pixels().iter().zip(components.pixels()) {
                let size = components.pixels().iter().filter(|&&c| c == component).count() as u64;
                prop_assert_eq!(*label == CROWN, component != 0 && size >= least);
            }
        }

        #[test]
        fn inverting_and_flipping_twice_change_nothing(image in cells(), axis in -3i64..30) {
            let mut mask = TiledMask::from_image(&image);
            inverted(&mut mask, CROWN);
            prop_assert_eq!(mask.count(|l| l == CROWN), 154 - u64::from(image.pixels().iter().map(|&l| u32::from(l)).sum::<u32>()));
            inverted(&mut mask, CROWN);
            mirrored(&mut mask, Mirror::Flip, 13);
            mirrored(&mut mask, Mirror::Flip, 13);
            prop_assert_eq!(mask.image(), image);
            mirrored(&mut mask, Mirror::LeftToRight, axis);
            let symmetric = mask.image();
            mirrored(&mut mask, Mirror::LeftToRight, axis);
            prop_assert_eq!(mask.image(), symmetric);
        }
    }

    #[test]
    fn a_side_is_mirrored_onto_the_other() {
        let image = Image::from_pixels(5, 1, vec![1, 2, 3, 4, 5]);
        let mut mask = TiledMask::from_image(&image);
        mirrored(&mut mask, Mirror::RightToLeft, 4);
        assert_eq!(mask.image().pixels(), &[5, 4, 3, 4, 5]);
        mirrored(&mut mask, Mirror::Flip, 3);
        assert_eq!(mask.image().pixels(), &[4, 3, 4, 5, 0]);
    }
}
