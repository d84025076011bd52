//! Contact sheets: many trees on one ground, all at one scale.

use super::font;
use super::paint::Rgba;
use super::scene::{Standing, backdrop, draw_shadows, tree_bounds};
use crate::raster::{Image, Premultiplied, Rect, Straight};

/// Colour of captions.
const INK: Rgba = [74, 70, 64, 255];

/// One tree of a sheet.
#[derive(Debug, Clone)]
pub struct Cell<'a> {
    /// The tree on clear ground; a picture without any opaque pixel leaves its cell empty.
    pub image: &'a Image<Premultiplied>,
    /// What stands below it, cut to the width of the cell.
    pub caption: Option<String>,
}

impl<'a> Cell<'a> {
    /// A tree without words.
    pub fn new(image: &'a Image<Premultiplied>) -> Self {
        Self {
            image,
            caption: None,
        }
    }
}

/// The trees of `cells` in rows of `columns`, each in a square of `cell_px`.
///
/// All trees have one scale, the largest at which every one fits its cell, and never above their
/// own size: what is taller in the pictures is taller on the sheet. The sheet is
/// `columns · cell_px` wide and a margin of an eighth of a cell all round; rows with captions are
/// higher by a line.
///
/// # Panics
/// When there are no cells or no columns, or `cell_px` is 0.
pub fn contact_sheet(cells: &[Cell<'_>], columns: usize, cell_px: u32) -> Image<Straight> {
    let grid = Grid::new(cells, columns, cell_px);
    let trees = standing(cells, grid.tree_px);
    let mut canvas = backdrop(grid.width, grid.height);
    let places: Vec<(f64, u32)> = (0..cells.len()).map(|i| grid.place(i)).collect();
    for (tree, &(middle, ground)) in trees.iter().zip(&places) {
        if let Some(tree) = tree {
            draw_shadows(&mut canvas, &tree.shadows(middle, ground));
        }
    }
    for (tree, &(middle, ground)) in trees.iter().zip(&places) {
        if let Some(tree) = tree {
            tree.draw(&mut canvas, middle, ground);
        }
    }
    for (cell, &(middle, ground)) in cells.iter().zip(&places) {
        if let Some(caption) = &cell.caption {
            let text = font::fitted(caption, grid.cap_px, f64::from(cell_px) * 0.92);
            let baseline = f64::from(ground + grid.caption_px) - 0.25 * grid.cap_px;
            font::write_centred(&mut canvas, &text, middle, baseline, grid.cap_px, INK);
        }
    }
    canvas.into_image()
}

/// The trees cut out, at their common scale.
fn standing(cells: &[Cell<'_>], tree_px: u32) -> Vec<Option<Standing>> {
    let bounds: Vec<Option<Rect>> = cells.iter().map(|cell| tree_bounds(cell.image)).collect();
    let scale = common_scale(bounds.iter().flatten(), tree_px);
    let trees = cells.iter().zip(&bounds);
    trees
        .map(|(cell, bounds)| bounds.map(|bounds| Standing::new(cell.image, bounds, scale)))
        .collect()
}

/// The largest scale, at most 1, at which all `bounds` fit a square of `side` pixels.
pub(super) fn common_scale<'a>(bounds: impl Iterator<Item = &'a Rect>, side: u32) -> f64 {
    let largest = bounds.map(|b| b.width.max(b.height)).max().unwrap_or(1);
    (f64::from(side) / f64::from(largest)).min(1.0)
}

/// Where everything goes.
pub(super) struct Grid {
    columns: usize,
    width: u32,
    height: u32,
    /// Margin around all cells.
    margin: u32,
    cell_px: u32,
    row_px: u32,
    /// Largest side of a tree.
    tree_px: u32,
    /// From the ground line to the line of captions' end.
    caption_px: u32,
    cap_px: f64,
}

impl Grid {
    pub(super) fn new(cells: &[Cell<'_>], columns: usize, cell_px: u32) -> Self {
        assert!(
            !cells.is_empty() && columns > 0 && cell_px > 0,
            "a sheet shows something"
        );
        let columns = columns.min(cells.len());
        let rows = cells.len().div_ceil(columns) as u32;
        let has_captions = cells.iter().any(|cell| cell.caption.is_some());
        let cap_px = (f64::from(cell_px) / 26.0).clamp(6.0, 15.0);
        let floor = cell_px / 12;
        let caption_px = floor + font::line_height(cap_px).ceil() as u32;
        let row_px = cell_px + if has_captions { caption_px } else { floor };
        let margin = (cell_px / 8).max(4);
        Self {
            columns,
            width: columns as u32 * cell_px + 2 * margin,
            height: rows * row_px + 2 * margin,
            margin,
            cell_px,
            row_px,
            tree_px: (cell_px - cell_px / 12).max(1),
            caption_px,
            cap_px,
        }
    }

    /// Middle and ground line of cell `index`.
    pub(super) fn place(&self, index: usize) -> (f64, u32) {
        let (row, column) = (index / self.columns, index % self.columns);
        let middle = self.margin as f64 + (column as f64 + 0.5) * f64::from(self.cell_px);
        (
            middle,
            self.margin + row as u32 * self.row_px + self.cell_px,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree(width: u32, height: u32) -> Image<Premultiplied> {
        let mut image = Image::filled(64, 64, Premultiplied::default());
        for y in 64 - height..64 {
            for x in 32 - width / 2..32 + width / 2 {
                image.set(x, y, Premultiplied([10, 200, 10, 255]));
            }
        }
        image
    }

    /// The columns and rows of `sheet` that show green.
    fn green(sheet: &Image<Straight>) -> Rect {
        tree_bounds(&sheet.map(|p| {
            let is_green = p.0[1] > 180 && p.0[0] < 60;
            Premultiplied([0, 0, 0, if is_green { 255 } else { 0 }])
        }))
        .unwrap()
    }

    #[test]
    fn trees_keep_their_proportion_to_each_other_and_stand_on_one_line() {
        let (large, small) = (tree(40, 60), tree(20, 30));
        let sheet = contact_sheet(&[Cell::new(&large), Cell::new(&small)], 2, 36);
        let half = sheet.width() / 2;
        let left = green(&sheet.cropped(0, 0, half, sheet.height()));
        let right = green(&sheet.cropped(half, 0, half, sheet.height()));
        assert_eq!(left.y + left.height, right.y + right.height);
        assert!(
            left.height.abs_diff(2 * right.height) <= 2,
            "{left:?} {right:?}"
        );
    }

    #[test]
    fn a_sheet_is_opaque_and_never_magnifies() {
        let small = tree(10, 12);
        let empty = Image::filled(4, 4, Premultiplied::default());
        let mut cells = vec![Cell::new(&small), Cell::new(&empty), Cell::new(&small)];
        cells[0].caption = Some("small_01".to_owned());
        let sheet = contact_sheet(&cells, 2, 96);
        assert!(sheet.pixels().iter().all(|pixel| pixel.alpha() == 255));
        let first = green(&sheet.cropped(0, 0, sheet.width() / 2, sheet.height() / 2));
        assert_eq!((first.width, first.height), (10, 12));
    }
}
