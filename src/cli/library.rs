//! Folders of tree pictures: which files, where prepared exemplars are kept, what is wrong.

use super::failure::Failure;
use crate::variation::LibraryPicture;
use clap::Args;
use std::path::{Path, PathBuf};

/// Endings of the files that a library folder is searched for.
const ENDINGS: [&str; 9] = [
    "png", "jpg", "jpeg", "webp", "tga", "tif", "tiff", "bmp", "dds",
];

/// Where prepared exemplars are kept between runs.
#[derive(Debug, Args)]
pub(super) struct CacheFlags {
    /// Folder where prepared exemplars are kept [default: the system's folder for caches]
    #[arg(long, env = "BOSCAGE_CACHE", value_name = "DIR")]
    cache: Option<PathBuf>,
    /// Prepare every exemplar anew and keep nothing
    #[arg(long)]
    no_cache: bool,
}

impl CacheFlags {
    /// The folder, if one is to be used.
    pub(super) fn folder(&self) -> Option<PathBuf> {
        if self.no_cache {
            return None;
        }
        let system = || {
            let folders = directories::ProjectDirs::from("", "", "boscage")?;
            Some(folders.cache_dir().join("exemplars"))
        };
        self.cache.clone().or_else(system)
    }
}

/// The picture files in `folder`, by name.
///
/// # Errors
/// [`Failure::BadInput`] when it cannot be listed or holds no picture files.
pub(super) fn picture_files(folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let failed = |error: std::io::Error| Failure::of(folder.display(), error);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let ending = path
            .extension()
            .unwrap_or_default()
            .to_string_lossy()
            .to_lowercase();
        let is_hidden = entry_is_hidden(&path);
        // Label pictures lie beside the pictures they belong to.
        let is_labels = path
            .file_stem()
            .is_some_and(|stem| stem.to_string_lossy().ends_with(".labels"));
        if ENDINGS.contains(&ending.as_str()) && !is_labels && !is_hidden && path.is_file() {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(Failure::of(
            folder.display(),
            "no picture files in this folder",
        ));
    }
    files.sort();
    Ok(files)
}

/// Whether the file's name begins with a dot.
fn entry_is_hidden(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default();
    name.as_encoded_bytes().starts_with(b".")
}

/// The pictures that lie in `files`.
pub(super) fn pictures(files: &[PathBuf]) -> Vec<LibraryPicture> {
    let of_file = |path: &PathBuf| LibraryPicture {
        path: path.clone(),
        bytes: None,
        pins: None,
    };
    files.iter().map(of_file).collect()
}
