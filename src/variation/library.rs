//! A set of exemplars: all their vectors at hand, their pixels when they are needed.

use super::cache::{self, Cache};
use super::{Exemplar, ExemplarError, ExemplarSettings, Shape};
use crate::base::{Cancel, Cancelled, Digest, FileError, Progress, read_limited};
use crate::raster::{ImageError, ReadLimits, read_image_from_memory};
use crate::segment::{SegmentError, Segmenter};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Exemplars whose pixels are kept in memory: 5 MB each at 1,024 pixels. With fewer than the
/// threads times the mix they would be read again and again.
const KEPT: usize = 48;

/// Why an exemplar cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum LibraryError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file is no picture.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The picture is no exemplar.
    #[error("{}: {reason}", path.display())]
    Exemplar {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: ExemplarError,
    },
    /// The file is another one than when the library was opened.
    #[error("{}: the file changed while it was in use", path.display())]
    Changed {
        /// The file.
        path: PathBuf,
    },
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A file that did not become part of a library.
#[derive(Debug)]
pub struct Refused {
    /// The file.
    pub path: PathBuf,
    /// Why; its text names the file.
    pub reason: LibraryError,
}

/// One exemplar of a library.
#[derive(Debug, Clone)]
pub struct Entry {
    /// The picture's file.
    pub path: PathBuf,
    /// Digest of the file's content.
    pub digest: Digest,
    /// The exemplar's vectors.
    pub shape: Arc<Shape>,
    key: Digest,
}

impl Entry {
    /// The file's name without its folder.
    pub fn file_name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }
}

/// Exemplars prepared with the same settings, in the order in which their files were given.
pub struct Library<'a> {
    entries: Vec<Entry>,
    settings: ExemplarSettings,
    segmenter: &'a (dyn Segmenter + Sync),
    cache: Option<Cache>,
    /// Index and pixels of the exemplars used last, the latest at the end.
    used: Mutex<Vec<(usize, Arc<Exemplar>)>>,
}

impl<'a> Library<'a> {
    /// Prepares the pictures in `files`, or finds them prepared in the folder `cache`.
    ///
    /// Files that cannot be exemplars are returned beside the library, with the reason; an empty
    /// library is no error here. A cache that cannot be written is warned of.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn open(
        files: &[PathBuf],
        settings: ExemplarSettings,
        segmenter: &'a (dyn Segmenter + Sync),
        cache: Option<&Path>,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<(Self, Vec<Refused>), Cancelled> {
        let mut library = Self {
            entries: Vec::new(),
            settings,
            segmenter,
            cache: cache.map(Cache::new),
            used: Mutex::new(Vec::new()),
        };
        let stage = progress.stage("prepare", files.len() as u64);
        let opened: Vec<_> = files
            .par_iter()
            .with_max_len(1)
            .map(|path| {
                let entry = library.entry(path, progress, cancel);
                stage.advance();
                entry
            })
            .collect();
        let mut refused = Vec::new();
        for (path, entry) in files.iter().zip(opened) {
            match entry {
                Ok(entry) => library.entries.push(entry),
                Err(LibraryError::Cancelled(cancelled)) => return Err(cancelled),
                Err(reason) => refused.push(Refused {
                    path: path.clone(),
                    reason,
                }),
            }
        }
        Ok((library, refused))
    }

    /// The exemplars.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// How the exemplars were prepared.
    pub fn settings(&self) -> &ExemplarSettings {
        &self.settings
    }

    /// Exemplar `index` with its pixels.
    ///
    /// # Errors
    /// [`LibraryError`] when it has to be prepared again and its file is gone or another.
    pub fn exemplar(&self, index: usize, cancel: &Cancel) -> Result<Arc<Exemplar>, LibraryError> {
        if let Some(exemplar) = self.recently_used(index) {
            return Ok(exemplar);
        }
        let entry = &self.entries[index];
        let cached = self
            .cache
            .as_ref()
            .and_then(|c| c.exemplar(entry.key, &entry.shape));
        let exemplar = match cached {
            Some(exemplar) => exemplar,
            None => {
                let (digest, exemplar) = self.prepared(&entry.path, cancel)?;
                if digest != entry.digest {
                    return Err(LibraryError::Changed {
                        path: entry.path.clone(),
                    });
                }
                exemplar
            }
        };
        let exemplar = Arc::new(exemplar);
        let mut used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        if used.len() >= KEPT {
            used.remove(0);
        }
        used.push((index, Arc::clone(&exemplar)));
        Ok(exemplar)
    }

    /// The exemplar if its pixels are in memory; it becomes the latest.
    fn recently_used(&self, index: usize) -> Option<Arc<Exemplar>> {
        let mut used = self.used.lock().unwrap_or_else(PoisonError::into_inner);
        let position = used.iter().position(|(i, _)| *i == index)?;
        let found = used.remove(position);
        let exemplar = Arc::clone(&found.1);
        used.push(found);
        Some(exemplar)
    }

    fn entry(
        &self,
        path: &Path,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Entry, LibraryError> {
        cancel.check()?;
        let bytes = read_limited(path, ReadLimits::default().file_bytes)?;
        let digest = Digest::of(&bytes);
        let key = cache::key(digest, &self.settings, self.segmenter.name());
        let entry = |shape| Entry {
            path: path.to_owned(),
            digest,
            shape: Arc::new(shape),
            key,
        };
        if let Some(shape) = self.cache.as_ref().and_then(|cache| cache.shape(key)) {
            return Ok(entry(shape));
        }
        let exemplar = self.prepared_from(path, &bytes, cancel)?;
        if let Some(Err(error)) = self.cache.as_ref().map(|cache| cache.keep(key, &exemplar)) {
            progress.warn(&error.to_string());
        }
        Ok(entry(exemplar.shape))
    }

    fn prepared(&self, path: &Path, cancel: &Cancel) -> Result<(Digest, Exemplar), LibraryError> {
        let bytes = read_limited(path, ReadLimits::default().file_bytes)?;
        Ok((
            Digest::of(&bytes),
            self.prepared_from(path, &bytes, cancel)?,
        ))
    }

    fn prepared_from(
        &self,
        path: &Path,
        bytes: &[u8],
        cancel: &Cancel,
    ) -> Result<Exemplar, LibraryError> {
        let picture = read_image_from_memory(bytes, path, ReadLimits::default())?;
        let silent = Progress::silent();
        Exemplar::prepare(&picture, &self.settings, self.segmenter, silent, cancel).map_err(
            |reason| match reason {
                ExemplarError::Segment(SegmentError::Cancelled(cancelled)) => cancelled.into(),
                reason => LibraryError::Exemplar {
                    path: path.to_owned(),
                    reason,
                },
            },
        )
    }
}
