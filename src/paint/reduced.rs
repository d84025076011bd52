//! Looking at a mask from afar: labels as colours, reduced by powers of two, and the sides of pixels
//! between inside and outside.
//!
//! A screen shows a mask of 8192² at an eighth of its size. What a pixel of the screen then gets is the
//! mean of the colours of all labels under it, so that a thin twig fades instead of flickering. Tiles of
//! one label cost nothing, so a look after each step of a brush costs what the brush changed.

use super::tiled::{TILE, Tile, TiledMask};
use crate::raster::{Image, Mask, Premultiplied, Rect};

/// The largest level of [`mean_colors`]: a tile then is one pixel.
pub const MOST_REDUCED: u32 = TILE.trailing_zeros();

/// `rect` of `mask` at 1/2^`level` of its size, each pixel the mean of `colors` over the labels
/// under it; at the border only what is there counts. `rect` is in pixels of the level, which has
/// ⌈width / 2^level⌉ columns and as many rows accordingly.
///
/// ```
/// use boscage::paint::{TiledMask, mean_colors};
/// use boscage::raster::{Image, Premultiplied};
/// let mask = TiledMask::from_image(&Image::from_pixels(4, 2, vec![1, 1, 0, 0, 1, 0, 0, 0]));
/// let mut colors = [Premultiplied([0; 4]); 256];
/// colors[1] = Premultiplied([40, 80, 0, 100]);
/// let half = mean_colors(&mask, 1, mask.rect_at(1), &colors);
/// assert_eq!(half.pixels(), &[Premultiplied([30, 60, 0, 75]), Premultiplied([0; 4])]);
/// ```
///
/// # Panics
/// When `rect` is empty or not inside, or the level is above [`MOST_REDUCED`].
pub fn mean_colors(
    mask: &TiledMask,
    level: u32,
    rect: Rect,
    colors: &[Premultiplied; 256],
) -> Image<Premultiplied> {
    assert!(level <= MOST_REDUCED, "a pixel lies in one tile");
    let whole = mask.rect_at(level);
    assert!(
        rect.x + rect.width <= whole.width && rect.y + rect.height <= whole.height,
        "{rect:?} is inside"
    );
    let mut reduced = Image::filled(rect.width, rect.height, Premultiplied([0; 4]));
    let side = TILE >> level;
    for row in rect.y / side..(rect.y + rect.height).div_ceil(side) {
        for column in rect.x / side..(rect.x + rect.width).div_ceil(side) {
            let index = (row * mask.across() + column) as usize;
            let own = mask.tile_rect(index);
            let left = (column * side).max(rect.x);
            let right = (column * side + own.width.div_ceil(1 << level)).min(rect.x + rect.width);
            let top = (row * side).max(rect.y);
            let bottom = (row * side + own.height.div_ceil(1 << level)).min(rect.y + rect.height);
            for y in top..bottom {
                let to = &mut reduced.row_mut(y - rect.y);
                let to = &mut to[(left - rect.x) as usize..(right - rect.x) as usize];
                match &mask.tiles()[index] {
                    Tile::Uniform(label) => to.fill(colors[usize::from(*label)]),
                    Tile::Varied(labels) => {
                        let place = (left - column * side, y - row * side);
                        mean_row(labels, own, level, place, colors, to);
                    }
                }
            }
        }
    }
    reduced
}

/// A row of a tile at `level`, from `place` on.
fn mean_row(
    labels: &[u8],
    tile: Rect,
    level: u32,
    place: (u32, u32),
    colors: &[Premultiplied; 256],
    to: &mut [Premultiplied],
) {
    let side = 1 << level;
    let top = place.1 << level;
    let rows = side.min(tile.height - top);
    for (x, pixel) in (place.0..).zip(to) {
        let left = x << level;
        let columns = side.min(tile.width - left);
        let mut sum = [0_u32; 4];
        for y in top..top + rows {
            let from = (y * tile.width + left) as usize;
            for &label in &labels[from..from + columns as usize] {
                let color = colors[usize::from(label)].0;
                for (sum, own) in sum.iter_mut().zip(color) {
                    *sum += u32::from(own);
                }
            }
        }
        let count = rows * columns;
        *pixel = Premultiplied(sum.map(|sum| ((sum + count / 2) / count) as u8));
    }
}

/// The tiles whose labels may differ between masks of one picture, told by their handles alone: a
/// glance even at 8192². Tiles that both share are not among them.
///
/// # Panics
/// When the sizes differ.
pub fn changed_tiles(before: &TiledMask, after: &TiledMask) -> Vec<Rect> {
    assert_eq!(before.rect(), after.rect(), "masks of one picture");
    let indices = 0..before.tiles().len();
    indices
        .filter(|&index| !before.tiles()[index].is_shared_with(&after.tiles()[index]))
        .map(|index| before.tile_rect(index))
        .collect()
}

/// The lines between pixels that are inside and pixels that are not, as straight runs from corner to
/// corner; corner (x, y) is the upper left one of pixel (x, y). The image's own border is no such line.
///
/// ```
/// use boscage::paint::pixel_borders;
/// use boscage::raster::Image;
/// let mask = Image::from_pixels(3, 2, vec![false, true, false, false, true, false]);
/// assert_eq!(pixel_borders(&mask), [[(1, 0), (1, 2)], [(2, 0), (2, 2)]]);
/// ```
pub fn pixel_borders(inside: &Mask) -> Vec<[(u32, u32); 2]> {
    let (width, height) = (inside.width(), inside.height());
    let mut borders = Vec::new();
    for y in 1..height {
        let (upper, lower) = (inside.row(y - 1), inside.row(y));
        let differs = |x: u32| upper[x as usize] != lower[x as usize];
        runs(width, differs, |from, to| {
            borders.push([(from, y), (to, y)])
        });
    }
    for x in 1..width {
        let differs = |y: u32| inside.at(x - 1, y) != inside.at(x, y);
        runs(height, differs, |from, to| {
            borders.push([(x, from), (x, to)])
        });
    }
    borders
}

/// Calls `found` with the ends of each run of numbers below `count` that fulfil `is_in`.
fn runs(count: u32, is_in: impl Fn(u32) -> bool, mut found: impl FnMut(u32, u32)) {
    let mut start = None;
    for at in 0..=count {
        let is_in = at < count && is_in(at);
        match (start, is_in) {
            (None, true) => start = Some(at),
            (Some(from), false) => {
                found(from, at);
                start = None;
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::{Paint, painted};

    fn colors() -> [Premultiplied; 256] {
        std::array::from_fn(|label| {
            let l = (label * 37 % 200) as u8;
            Premultiplied([l, l / 2, 200 - l, 200])
        })
    }

    /// A mask of odd sides with several labels and tiles of one label.
    fn mask() -> TiledMask {
        TiledMask::from_image(&Image::from_pixels(
            301,
            277,
            (0..301 * 277)
                .map(|i| {
                    let (x, y) = (i % 301, i / 301);
                    if x < 140 { 1 } else { ((x * y / 97) % 4) as u8 }
                })
                .collect(),
        ))
    }

    #[test]
    fn means_are_those_of_all_pixels_below() {
        let (mask, colors) = (mask(), colors());
        let labels = mask.image();
        for level in [0, 1, 3, 7] {
            let rect = mask.rect_at(level);
            let reduced = mean_colors(&mask, level, rect, &colors);
            for y in 0..rect.height {
                for x in 0..rect.width {
                    let mut sum = [0_u32; 4];
                    let mut count = 0;
                    for py in y << level..((y + 1) << level).min(277) {
                        for px in x << level..((x + 1) << level).min(301) {
                            count += 1;
                            let color = colors[usize::from(labels.at(px, py))].0;
                            sum = std::array::from_fn(|c| sum[c] + u32::from(color[c]));
                        }
                    }
                    let mean = sum.map(|sum| ((sum + count / 2) / count) as u8);
                    assert_eq!(reduced.at(x, y).0, mean, "({x}, {y}) at {level}");
                }
            }
        }
    }

    #[test]
    fn a_part_is_a_part_of_the_whole() {
        let (mask, colors) = (mask(), colors());
        let whole = mean_colors(&mask, 1, mask.rect_at(1), &colors);
        let rect = Rect {
            x: 13,
            y: 50,
            width: 101,
            height: 80,
        };
        let part = mean_colors(&mask, 1, rect, &colors);
        assert_eq!(part, whole.cropped(13, 50, 101, 80));
    }

    #[test]
    fn only_tiles_that_were_painted_on_have_changed() {
        let before = TiledMask::filled(500, 300, 0);
        let mut after = before.clone();
        let mut dot = TiledMask::filled(500, 300, 0);
        let pixel = Rect {
            x: 130,
            y: 5,
            width: 1,
            height: 1,
        };
        dot.edit(pixel, |_, _, row| row.fill(1));
        painted(&mut after, &dot, Paint::of(3));
        let tile = Rect {
            x: 128,
            y: 0,
            width: 128,
            height: 128,
        };
        assert_eq!(changed_tiles(&before, &after), [tile]);
        assert!(changed_tiles(&after, &after.clone()).is_empty());
    }

    #[test]
    fn a_pixel_has_four_sides() {
        let mut mask = Image::filled(3, 3, false);
        mask.set(1, 1, true);
        let mut borders = pixel_borders(&mask);
        borders.sort_unstable();
        let sides = [
            [(1, 1), (1, 2)],
            [(1, 1), (2, 1)],
            [(1, 2), (2, 2)],
            [(2, 1), (2, 2)],
        ];
        assert_eq!(borders, sides);
    }
}
