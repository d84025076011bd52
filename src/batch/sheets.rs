//! Sheets of pictures that were just written.

use super::failure::Failure;
use super::run::Run;
use crate::raster::{
    Compression, Image, Premultiplied, ReadLimits, encode_png, read_image, scaled,
};
use crate::sheet::{Cell, contact_sheet};
use std::path::{Path, PathBuf};

/// Side of a picture on a sheet, in pixels.
const CELL_PX: u32 = 256;

/// Pictures on a sheet at most; of more, some evenly spread. Beyond, a sheet is too large to look at.
const MOST: usize = 200;

/// Draws the pictures in `files` on one sheet and writes it to `path`.
///
/// # Errors
/// [`Failure`] when a picture cannot be read back, the sheet cannot be written, or on cancellation.
pub(crate) fn draw(files: &[PathBuf], path: &Path, session: &Run<'_>) -> Result<(), Failure> {
    let shown = files.len().min(MOST);
    let stage = session.progress.stage("sheet", shown as u64);
    let trees: Vec<Image<Premultiplied>> = (0..shown)
        .map(|i| {
            session.cancel.check()?;
            let tree = small(&files[i * files.len() / shown])?;
            stage.advance();
            Ok(tree)
        })
        .collect::<Result<_, Failure>>()?;
    let cells: Vec<Cell<'_>> = trees.iter().map(Cell::new).collect();
    // About half again as wide as high, and rows as even as can be.
    let rows = (shown as f64 / 1.5).sqrt().round().max(1.0) as usize;
    let sheet = contact_sheet(&cells, shown.div_ceil(rows), CELL_PX);
    session
        .output
        .write(path, &encode_png(&sheet, Compression::Fast))
}

/// The picture in `file`, no larger than a cell.
fn small(file: &Path) -> Result<Image<Premultiplied>, Failure> {
    let image = read_image(file, ReadLimits::default())?.premultiplied();
    let longer = image.width().max(image.height());
    let scale = (f64::from(CELL_PX) / f64::from(longer)).min(1.0);
    Ok(scaled(&image, scale))
}
