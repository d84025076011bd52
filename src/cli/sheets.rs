//! Sheets of pictures that were just written.

use super::failure::Failure;
use super::session::Session;
use crate::raster::{
    Compression, Image, ReadLimits, Rect, Straight, encode_png, read_image, resized,
};
use std::path::{Path, PathBuf};

/// Side of a picture on a sheet, in pixels.
const CELL_PX: u32 = 256;

/// Draws the pictures in `files` on one sheet and writes it to `path`.
pub(super) fn draw(files: &[PathBuf], path: &Path, session: &Session<'_>) -> Result<(), Failure> {
    let stage = session.progress.stage("sheet", files.len() as u64);
    let columns = ((files.len() as f64 * 1.5).sqrt().ceil() as u32).max(1);
    let rows = (files.len() as u32).div_ceil(columns).max(1);
    let mut sheet = Image::filled(
        columns * CELL_PX,
        rows * CELL_PX,
        Straight([200, 204, 208, 255]),
    );
    for (index, file) in (0u32..).zip(files) {
        session.cancel.check()?;
        let image = read_image(file, ReadLimits::default())?.premultiplied();
        let all = Rect {
            x: 0,
            y: 0,
            width: image.width(),
            height: image.height(),
        };
        let small = resized(&image, all, CELL_PX, CELL_PX);
        let (left, top) = (index % columns * CELL_PX, index / columns * CELL_PX);
        for y in 0..CELL_PX {
            for x in 0..CELL_PX {
                let [r, g, b, a] = small.at(x, y).0;
                let under = sheet.at(left + x, top + y).0;
                let over = |own: u8, under: u8| {
                    own + (u32::from(under) * (255 - u32::from(a)) / 255) as u8
                };
                let pixel = [over(r, under[0]), over(g, under[1]), over(b, under[2]), 255];
                sheet.set(left + x, top + y, Straight(pixel));
            }
        }
        stage.advance();
    }
    session
        .output
        .write(path, &encode_png(&sheet, Compression::Fast))
}
