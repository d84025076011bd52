//! Tables: every tree crossed with every other (*Tree Variations*, 2017, Fig. 13–14).

use super::contact::common_scale;
use super::paint::Canvas;
use super::scene::{Standing, backdrop, draw_shadows, tree_bounds};
use crate::raster::{Image, Premultiplied, Rect, Straight};

/// How much darker the heads' band is than the backdrop.
const HEAD_SHADE: f64 = 0.90;

/// How much lighter the diagonal's tiles are: the part of the way to white.
const DIAGONAL_LIGHT: f64 = 0.38;

/// A table of trees: the heads of rows to the left, those of columns above, on a darker band; in
/// `cells`, row by row, the crossings. A cell where both heads show the same picture's tree (row
/// and column of one index, in a square table) stands on a lighter tile. `None` stays empty.
///
/// Each tree has a square of `cell_px`; all have one scale, never above their own size. The sheet
/// is (columns + 1) · `cell_px` wide and (rows + 1) · `cell_px` high, with a margin of a fifth of
/// a cell all round and as much between the heads and the rest.
///
/// # Panics
/// When there are no rows or columns, or `cells` has another length than rows × columns.
pub fn table_sheet(
    row_heads: &[&Image<Premultiplied>],
    column_heads: &[&Image<Premultiplied>],
    cells: &[Option<Image<Premultiplied>>],
    cell_px: u32,
) -> Image<Straight> {
    let (rows, columns) = (row_heads.len(), column_heads.len());
    assert!(rows > 0 && columns > 0, "a table has rows and columns");
    assert_eq!(cells.len(), rows * columns, "a table has no gaps");
    let grid = Grid {
        cell_px: cell_px.max(8),
    };
    let mut canvas = backdrop(grid.side(columns), grid.side(rows));
    grid.shade_heads(&mut canvas, rows, columns);
    if rows == columns {
        (0..rows).for_each(|i| grid.light_tile(&mut canvas, i));
    }
    // Place of each tree as (row, column), the heads in row and column 0.
    let heads_above = column_heads
        .iter()
        .enumerate()
        .map(|(j, image)| ((0, j + 1), *image));
    let heads_left = row_heads
        .iter()
        .enumerate()
        .map(|(i, image)| ((i + 1, 0), *image));
    let crossings = cells.iter().enumerate().filter_map(|(index, image)| {
        let place = (index / columns + 1, index % columns + 1);
        image.as_ref().map(|image| (place, image))
    });
    let trees: Vec<_> = heads_above.chain(heads_left).chain(crossings).collect();
    grid.draw_trees(&mut canvas, &trees);
    canvas.into_image()
}

/// Row and column of a tree, and its picture.
type Placed<'a> = ((usize, usize), &'a Image<Premultiplied>);

/// Where everything goes.
struct Grid {
    cell_px: u32,
}

impl Grid {
    /// Margin around the table and gap behind the heads.
    fn gap(&self) -> u32 {
        self.cell_px / 5
    }

    /// Side of the sheet for `count` trees and their heads.
    fn side(&self, count: usize) -> u32 {
        (count as u32 + 1) * self.cell_px + 3 * self.gap()
    }

    /// First pixel of cell `index` along either axis; 0 is the head.
    fn start(&self, index: usize) -> u32 {
        let behind_heads = if index > 0 { self.gap() } else { 0 };
        self.gap() + index as u32 * self.cell_px + behind_heads
    }

    fn shade_heads(&self, canvas: &mut Canvas, rows: usize, columns: usize) {
        let band = 0..self.start(1) - self.gap() / 2;
        let darker = |_: u32, _: u32, color: [f64; 3]| color.map(|value| value * HEAD_SHADE);
        canvas.shade_part(0..self.side(columns), band.clone(), darker);
        canvas.shade_part(band.clone(), band.end..self.side(rows), darker);
    }

    fn light_tile(&self, canvas: &mut Canvas, index: usize) {
        let inset = self.cell_px / 40;
        let start = self.start(index + 1);
        let along = start + inset..start + self.cell_px - inset;
        canvas.shade_part(along.clone(), along, |_, _, color| {
            color.map(|value| value + (255.0 - value) * DIAGONAL_LIGHT)
        });
    }

    fn draw_trees(&self, canvas: &mut Canvas, trees: &[Placed<'_>]) {
        let bounds: Vec<Option<Rect>> = trees.iter().map(|(_, image)| tree_bounds(image)).collect();
        let scale = common_scale(bounds.iter().flatten(), self.cell_px - self.cell_px / 6);
        let standing = trees
            .iter()
            .zip(&bounds)
            .filter_map(|((place, image), bounds)| {
                let middle = f64::from(self.start(place.1)) + f64::from(self.cell_px) / 2.0;
                let ground = self.start(place.0) + self.cell_px - self.cell_px / 12;
                Some((Standing::new(image, (*bounds)?, scale), middle, ground))
            });
        let standing: Vec<(Standing, f64, u32)> = standing.collect();
        for (tree, middle, ground) in &standing {
            draw_shadows(canvas, &tree.shadows(*middle, *ground));
        }
        for (tree, middle, ground) in &standing {
            tree.draw(canvas, *middle, *ground);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_its_size_and_a_lighter_diagonal() {
        let tree = Image::filled(8, 8, Premultiplied([0, 90, 0, 255]));
        let cells = vec![None, None, None, None];
        let sheet = table_sheet(&[&tree, &tree], &[&tree, &tree], &cells, 40);
        assert_eq!((sheet.width(), sheet.height()), (144, 144));
        let light =
            |row: u32, column: u32| sheet.at(56 + 40 * column + 20, 56 + 40 * row + 20).0[0];
        assert!(light(0, 0) > light(0, 1) + 8 && light(1, 1) > light(1, 0) + 8);
        assert!(light(0, 1) > sheet.at(2, 76).0[0] + 8, "heads are darker");
    }
}
