//! A set of exemplars: all their vectors at hand, their pixels when they are needed.

use super::cache::{self, Cache};
use super::{Exemplar, ExemplarError, ExemplarSettings, Shape};
use crate::base::{Cancel, Cancelled, Digest, FileError, Progress, read_limited};
use crate::contour::HandPins;
use crate::raster::{ImageError, ReadLimits, read_image_from_memory};
use crate::segment::{Provenance, SegmentError, Segmenter};
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

/// A picture that is to join a library.
#[derive(Debug, Clone)]
pub struct LibraryPicture {
    /// Its file; with `bytes` the name that it stands under in messages and records.
    pub path: PathBuf,
    /// What the file holds, where that is at hand: then no file is read.
    pub bytes: Option<Arc<[u8]>>,
    /// Pins that somebody set in it.
    pub pins: Option<HandPins>,
}

/// A file that did not become part of a library.
#[derive(Debug)]
pub struct Refused {
    /// Its place among the pictures that were given.
    pub index: usize,
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
    /// Who labelled its picture.
    pub provenance: Provenance,
    /// See [`LibraryPicture::pins`].
    pub pins: Option<HandPins>,
    key: Digest,
    /// See [`LibraryPicture::bytes`].
    bytes: Option<Arc<[u8]>>,
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
    segmenter: &'a dyn Segmenter,
    /// See [`Segmenter::key`].
    segmenter_key: String,
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
        segmenter: &'a dyn Segmenter,
        cache: Option<&Path>,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<(Self, Vec<Refused>), Cancelled> {
        let of_file = |path: &PathBuf| LibraryPicture {
            path: path.clone(),
            bytes: None,
            pins: None,
        };
        let pictures: Vec<LibraryPicture> = files.iter().map(of_file).collect();
        Self::of(
            &pictures, settings, segmenter, cache, None, progress, cancel,
        )
    }

    /// Like [`Library::open`] with pictures that may lie in memory. What `known`, a library that was
    /// opened before, has of the same pictures with the same settings is taken from it.
    ///
    /// Without a folder `cache` the exemplars' pixels are kept from the start, as many as there is
    /// place for.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn of(
        pictures: &[LibraryPicture],
        settings: ExemplarSettings,
        segmenter: &'a dyn Segmenter,
        cache: Option<&Path>,
        known: Option<&Library<'_>>,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<(Self, Vec<Refused>), Cancelled> {
        let mut library = Self {
            entries: Vec::new(),
            settings,
            segmenter,
            segmenter_key: segmenter.key(),
            cache: cache.map(Cache::new),
            used: Mutex::new(Vec::new()),
        };
        let stage = progress.stage("prepare", pictures.len() as u64);
        let opened: Vec<_> = pictures
            .par_iter()
            .with_max_len(1)
            .map(|picture| {
                let entry = library.entry(picture, known, progress, cancel);
                stage.advance();
                entry
            })
            .collect();
        let mut refused = Vec::new();
        let mut used = Vec::new();
        for (index, (picture, opened)) in pictures.iter().zip(opened).enumerate() {
            match opened {
                Ok((entry, pixels)) => {
                    let own = library.entries.len();
                    used.extend(pixels.map(|exemplar| (own, exemplar)));
                    library.entries.push(entry);
                }
                Err(LibraryError::Cancelled(cancelled)) => return Err(cancelled),
                Err(reason) => refused.push(Refused {
                    index,
                    path: picture.path.clone(),
                    reason,
                }),
            }
        }
        used.truncate(KEPT);
        library.used = Mutex::new(used);
        Ok((library, refused))
    }

    /// The exemplars.
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }

    /// What told crown from trunk in their pictures.
    pub fn segmenter(&self) -> &'a dyn Segmenter {
        self.segmenter
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
            .and_then(|c| c.exemplar(entry.key, &entry.shape, &entry.provenance));
        let exemplar = match cached {
            Some(exemplar) => exemplar,
            None => {
                let (digest, exemplar) = self.prepared(entry, cancel)?;
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

    /// The entry of `picture`; with its pixels where they were made or found on the way and no
    /// cache keeps them.
    fn entry(
        &self,
        picture: &LibraryPicture,
        known: Option<&Library<'_>>,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<(Entry, Option<Arc<Exemplar>>), LibraryError> {
        cancel.check()?;
        let path = &picture.path;
        let bytes = match &picture.bytes {
            Some(bytes) => Arc::clone(bytes),
            None => read_limited(path, ReadLimits::default().file_bytes)?.into(),
        };
        let digest = Digest::of(&bytes);
        let pins = picture.pins;
        let key = cache::key(digest, pins.as_ref(), &self.settings, &self.segmenter_key);
        let entry = |shape, provenance| Entry {
            path: path.clone(),
            digest,
            shape,
            provenance,
            pins,
            key,
            bytes: picture.bytes.clone(),
        };
        if let Some((known, pixels)) = known.and_then(|known| known.prepared_before(key)) {
            let known = entry(Arc::clone(&known.shape), known.provenance.clone());
            return Ok((known, pixels));
        }
        if let Some((shape, provenance)) = self.cache.as_ref().and_then(|cache| cache.shape(key)) {
            return Ok((entry(Arc::new(shape), provenance), None));
        }
        let exemplar = self.prepared_from(path, &bytes, pins, cancel)?;
        let shape = Arc::new(exemplar.shape.clone());
        let entry = entry(shape, exemplar.provenance.clone());
        let Some(cache) = &self.cache else {
            return Ok((entry, Some(Arc::new(exemplar))));
        };
        if let Err(error) = cache.keep(key, &exemplar) {
            progress.warn(&error.to_string());
        }
        Ok((entry, None))
    }

    /// What this library has of the exemplar `key`.
    fn prepared_before(&self, key: Digest) -> Option<(&Entry, Option<Arc<Exemplar>>)> {
        let index = self.entries.iter().position(|entry| entry.key == key)?;
        Some((&self.entries[index], self.recently_used(index)))
    }

    fn prepared(&self, entry: &Entry, cancel: &Cancel) -> Result<(Digest, Exemplar), LibraryError> {
        let bytes = match &entry.bytes {
            Some(bytes) => Arc::clone(bytes),
            None => read_limited(&entry.path, ReadLimits::default().file_bytes)?.into(),
        };
        Ok((
            Digest::of(&bytes),
            self.prepared_from(&entry.path, &bytes, entry.pins, cancel)?,
        ))
    }

    fn prepared_from(
        &self,
        path: &Path,
        bytes: &[u8],
        pins: Option<HandPins>,
        cancel: &Cancel,
    ) -> Result<Exemplar, LibraryError> {
        let picture = read_image_from_memory(bytes, path, ReadLimits::default())?;
        let silent = Progress::silent();
        let (settings, segmenter) = (&self.settings, self.segmenter);
        let made = Exemplar::prepare_pinned(&picture, pins, settings, segmenter, silent, cancel);
        made.map_err(|reason| match reason {
            ExemplarError::Segment(SegmentError::Cancelled(cancelled)) => cancelled.into(),
            reason => LibraryError::Exemplar {
                path: path.to_owned(),
                reason,
            },
        })
    }
}
