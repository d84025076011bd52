//! `boscage samples --photos`: photographs of grown trees, with the masks of their crowns.

use super::failure::Failure;
use super::items::made;
use super::output::recipe;
use super::session::Session;
use crate::branches::photo::{Photo, photos};
use crate::raster::{Compression, encode_grey_png, encode_jpeg};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Quality of the JPEG files: what telephones keep.
const QUALITY: u8 = 88;

/// Writes NAME.jpg and NAME.mask.png of this shard's photographs into `folder`.
///
/// # Errors
/// [`Failure`].
pub(super) fn write_photos(
    folder: &Path,
    session: &Session<'_>,
) -> Result<Vec<(usize, Value)>, Failure> {
    let paths = |photo: &Photo| ["jpg", "mask.png"].map(|end| path(folder, photo, end));
    let shard = session.options.shard;
    let ours = (0u64..).zip(photos()).filter(|(i, _)| shard.contains(*i));
    session
        .output
        .check(ours.flat_map(|(_, photo)| paths(photo)))?;
    let made = made(session, "grow", photos(), |_, photo| {
        let [file, mask] = paths(photo);
        let recipe = recipe("photo").with(photo.name().as_bytes()).finish();
        // The mask is written last and, as a PNG file, tells what both were made from.
        if !(file.is_file() && session.output.is_ready(&mask, recipe)) {
            let developed = photo.developed(1.0, session.cancel)?;
            let jpeg = encode_jpeg(&developed.image, QUALITY);
            session.output.write_item(&file, jpeg, recipe)?;
            let png = encode_grey_png(&developed.mask, Compression::Small);
            session.output.write_item(&mask, png, recipe)?;
        }
        Ok(json!({
            "name": photo.name(),
            "file": file.display().to_string(),
            "mask": mask.display().to_string(),
        }))
    })?;
    Ok(made.ready)
}

fn path(folder: &Path, photo: &Photo, end: &str) -> PathBuf {
    folder.join(format!("{}.{end}", photo.name()))
}
