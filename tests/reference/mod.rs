//! What tests compare with and nobody here made: real pictures in the folder `BOSCAGE_DATA` (default
//! `../shared/data`), results of public tools in `BOSCAGE_ORACLE` (default `oracle` beside it). Where
//! a folder is missing, tests say so and pass.
#![allow(dead_code, reason = "each test needs a part of it")]

use boscage::raster::{Image, Mask, ReadLimits, Straight, read_image};
use std::path::{Path, PathBuf};

/// The folder of real pictures, absolute, if `part` is in it.
pub(crate) fn data(part: &str) -> Option<PathBuf> {
    let folder = data_folder();
    let found = folder.join(part).exists();
    if !found {
        eprintln!("left out: no {part} in {}", folder.display());
    }
    found.then_some(folder)
}

/// A few of `all`, spread evenly, for the time it takes; with `BOSCAGE_ALL_PHOTOS` all of them, for
/// whoever changes the synthesis.
pub(crate) fn some<T>(all: &[T]) -> Vec<&T> {
    let step = match std::env::var_os("BOSCAGE_ALL_PHOTOS") {
        Some(_) => 1,
        None => (all.len() / 4).max(2),
    };
    all.iter().step_by(step).collect()
}

/// The folder of reference results, absolute.
pub(crate) fn oracle() -> Option<PathBuf> {
    let named = std::env::var_os("BOSCAGE_ORACLE").map(|folder| absolute(Path::new(&folder)));
    let folder = named.or_else(|| Some(data_folder().parent()?.join("oracle")))?;
    let found = folder.is_dir();
    if !found {
        eprintln!("left out: {} is not there", folder.display());
    }
    found.then_some(folder)
}

/// The photograph `name` of [`data`] and the mask of its crown.
pub(crate) fn photo_and_mask(data: &Path, name: &str) -> (Image<Straight>, Mask) {
    let read = |path: PathBuf| read_image(&path, ReadLimits::default()).unwrap();
    let photo = read(data.join(format!("photos/{name}.jpg")));
    let mask = read(data.join(format!("masks/{name}.mask.png")));
    (photo, mask.map(|pixel| pixel.0[0] >= 128))
}

fn data_folder() -> PathBuf {
    let named = std::env::var_os("BOSCAGE_DATA").map(PathBuf::from);
    absolute(&named.unwrap_or_else(|| "../shared/data".into()))
}

/// Commands under test run in other folders.
fn absolute(folder: &Path) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)
}
