//! The picture as the classical segmenter looks at it: cropped, small, cut into runs.

use crate::raster::{Image, Mask, Premultiplied, Rect, Straight, opaque_bounds, resized};

/// Longest side of the sketch, pixels.
///
/// The thinnest trunks are 2 % of the tree's height: 8 pixels here. With 256 they are 5 and the
/// colour of their bark is mixed with the background's; with 512 everything takes twice as long.
const LONGEST_SIDE: u32 = 384;

/// Gaps up to this part of the longest side are taken for holes of the cut-out, not for air.
///
/// Without it a pixel missing in a trunk looks like a fork; from about 1 % on, the drooping branch
/// beside a spruce's trunk is joined to it.
const GAP: f64 = 0.004;

/// Alpha from which on a pixel belongs to the tree.
pub(super) const OPAQUE: u8 = 128;

/// Columns `left..right` of row `y`; never empty.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) y: u32,
    pub(super) left: u32,
    pub(super) right: u32,
}

impl Span {
    /// Number of columns.
    pub(super) fn width(self) -> u32 {
        self.right - self.left
    }

    /// Whether the two share a column or touch at a corner, whatever their rows.
    pub(super) fn meets(self, other: Span) -> bool {
        self.left <= other.right && other.left <= self.right
    }

    /// The middle column.
    pub(super) fn centre(self) -> f64 {
        f64::from(self.left + self.right) / 2.0
    }
}

/// A small copy of the tree.
pub(super) struct Sketch {
    /// What part of the picture it shows.
    pub(super) crop: Rect,
    /// The tree, reduced; its background is meaningless.
    pub(super) image: Image<Straight>,
    /// Where the tree is opaque.
    pub(super) mask: Mask,
    /// The opaque runs of every row, from the left, small gaps closed.
    pub(super) runs: Vec<Vec<Span>>,
}

impl Sketch {
    /// The sketch of what is opaque in `picture`, `None` where nothing is.
    pub(super) fn of(picture: &Image<Straight>) -> Option<Self> {
        let crop = opaque_bounds(&picture.map(|p| p.alpha() >= OPAQUE))?;
        let longest = crop.width.max(crop.height);
        let side = |length: u32| {
            if longest <= LONGEST_SIDE {
                length
            } else {
                (length * LONGEST_SIDE).div_ceil(longest)
            }
        };
        let small = reduced(picture, crop, side(crop.width), side(crop.height));
        let mask = small.map(|p| p.alpha() >= OPAQUE);
        let gap = (GAP * f64::from(side(longest))) as u32;
        let runs = (0..mask.height()).map(|y| runs(&mask, y, gap)).collect();
        Some(Self {
            crop,
            image: small.straight(),
            mask,
            runs,
        })
    }

    /// The pixels of `spans` as a mask.
    pub(super) fn covered(&self, spans: &[Span]) -> Mask {
        let mut covered = Image::filled(self.width(), self.height(), false);
        for span in spans {
            covered.row_mut(span.y)[span.left as usize..span.right as usize].fill(true);
        }
        covered
    }

    /// Columns of the sketch.
    pub(super) fn width(&self) -> u32 {
        self.mask.width()
    }

    /// Rows of the sketch.
    pub(super) fn height(&self) -> u32 {
        self.mask.height()
    }
}

fn reduced(picture: &Image<Straight>, crop: Rect, width: u32, height: u32) -> Image<Premultiplied> {
    let part = picture.cropped(crop.x, crop.y, crop.width, crop.height);
    let all = Rect { x: 0, y: 0, ..crop };
    resized(&part.premultiplied(), all, width, height)
}

fn runs(mask: &Mask, y: u32, gap: u32) -> Vec<Span> {
    let mut runs: Vec<Span> = Vec::new();
    for (x, _) in (0u32..).zip(mask.row(y)).filter(|&(_, &inside)| inside) {
        match runs.last_mut() {
            Some(run) if x - run.right <= gap => run.right = x + 1,
            _ => runs.push(Span {
                y,
                left: x,
                right: x + 1,
            }),
        }
    }
    runs
}
