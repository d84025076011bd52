//! Autosaves, and finding them after a crash.
//!
//! Every running project has a folder of its own below one root:
//!
//! ```text
//! ROOT/SESSION/about.json        what it is: title, file, when, how often it was tried
//! ROOT/SESSION/document.boscage  the project, without photographs
//! ROOT/SESSION/DIGEST.photo      each photograph, written once
//! ROOT/SESSION/…lock             held while the project is open
//! ```
//!
//! The index of what can be recovered is the list of folders whose lock nobody holds; no single file
//! can be damaged so that all is lost, and two instances never write the same one. Listing reads only
//! the small `about.json` and never fails: recovery must not be what stops the start. A project that
//! crashes when it is opened is offered again with the number of its tries, and never opened unasked.

use super::lock::Lock;
use super::{Decoded, StoreError, decode};
use crate::base::{Cancel, Digest, FileError, read_limited, sync_names, write_atomic};
use crate::document::encode::encode_without_photos;
use crate::document::project::Snapshot;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Largest autosave and photograph that is read.
const MOST_BYTES: u64 = 2 << 30;

/// Largest `about.json`.
const MOST_ABOUT_BYTES: u64 = 64 << 10;

/// Most sessions that are listed.
const MOST_SESSIONS: usize = 1000;

/// Time between a change and its autosave at most: with the time that writing takes, less than the
/// 30 seconds of work that may be lost.
const INTERVAL: Duration = Duration::from_secs(20);

const ABOUT: &str = "about.json";
const DOCUMENT: &str = "document.boscage";

/// What an autosave is of.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
struct About {
    title: String,
    file: Option<PathBuf>,
    saved_at: u64,
    tries: u32,
}

/// The folder for autosaves.
#[derive(Debug, Clone)]
pub struct Recovery {
    root: PathBuf,
}

/// A project that was left behind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recoverable {
    /// Its folder.
    pub folder: PathBuf,
    /// Its title; empty when nothing is known of it.
    pub title: String,
    /// The file it was opened from or saved to.
    pub file: Option<PathBuf>,
    /// When it was written, in seconds since 1970; 0 when not known.
    pub saved_at: u64,
    /// How often it was opened after the crash without being put in order since: above 0 it may be
    /// the cause of the crash.
    pub tries: u32,
}

impl Recovery {
    /// Autosaves below the folder `root`, which need not exist.
    pub fn at(root: impl Into<PathBuf>) -> Self {
        Self { root: root.into() }
    }

    /// What can be recovered, the newest first. Never fails: what cannot be read is left out or told
    /// with what is known.
    pub fn list(&self) -> Vec<Recoverable> {
        let Ok(folders) = fs::read_dir(&self.root) else {
            return Vec::new();
        };
        let folders = folders.flatten().map(|entry| entry.path());
        let folders = folders.filter(|path| path.is_dir()).take(MOST_SESSIONS);
        let mut found: Vec<Recoverable> =
            folders.filter_map(|folder| recoverable(&folder)).collect();
        found.sort_by(|a, b| b.saved_at.cmp(&a.saved_at).then(a.folder.cmp(&b.folder)));
        found
    }

    /// Begins the autosaves of a project that is open now; `session` names its folder.
    ///
    /// # Errors
    /// [`StoreError::File`] when the folder cannot be made or is another project's.
    pub fn begin(&self, session: &str) -> Result<Autosave, StoreError> {
        let folder = self.root.join(session);
        let failed = |reason| FileError::Write {
            path: folder.clone(),
            reason,
        };
        fs::create_dir_all(&folder).map_err(failed)?;
        let lock = Lock::take_over(&folder.join(DOCUMENT));
        let lock = lock.map_err(|error| failed(std::io::Error::other(error.to_string())))?;
        Ok(Autosave {
            folder,
            _lock: lock,
            photos: BTreeSet::new(),
        })
    }

    /// Opens what was left behind, and counts the try before it does.
    ///
    /// # Errors
    /// [`StoreError`]; the files stay.
    pub fn open(&self, left: &Recoverable) -> Result<Decoded, StoreError> {
        let about = About {
            title: left.title.clone(),
            file: left.file.clone(),
            saved_at: left.saved_at,
            tries: left.tries + 1,
        };
        write_about(&left.folder, &about)?;
        let path = left.folder.join(DOCUMENT);
        let bytes = read_limited(&path, MOST_BYTES)?;
        let photo = |digest: Digest| {
            let bytes = read_limited(&photo_path(&left.folder, digest), MOST_BYTES);
            bytes.ok().map(Arc::from)
        };
        decode(&bytes, photo).map_err(|reason| StoreError::Format { path, reason })
    }

    /// Throws away what was left behind.
    ///
    /// # Errors
    /// [`StoreError::File`].
    pub fn discard(&self, left: &Recoverable) -> Result<(), StoreError> {
        remove(&left.folder)
    }
}

/// The autosaves of a project that is open.
#[derive(Debug)]
pub struct Autosave {
    folder: PathBuf,
    _lock: Lock,
    /// Photographs that lie there already.
    photos: BTreeSet<Digest>,
}

impl Autosave {
    /// Writes the project as it is; `now` is in seconds since 1970.
    ///
    /// # Errors
    /// [`StoreError`]; the autosave before it stays.
    pub fn write(
        &mut self,
        snapshot: &Snapshot,
        file: Option<&Path>,
        now: u64,
        cancel: &Cancel,
    ) -> Result<(), StoreError> {
        for (digest, bytes) in snapshot.photos() {
            let path = photo_path(&self.folder, *digest);
            // Looked for each time: whoever cleans a disk may take the folder from under us.
            if !self.photos.contains(digest) || !path.is_file() {
                cancel.check()?;
                write_atomic(&path, bytes)?;
                self.photos.insert(*digest);
            }
        }
        let bytes = encode_without_photos(snapshot, cancel)?;
        write_atomic(&self.folder.join(DOCUMENT), &bytes)?;
        let about = About {
            title: snapshot.title().to_owned(),
            file: file.map(Path::to_owned),
            saved_at: now,
            tries: 0,
        };
        write_about(&self.folder, &about)?;
        Ok(sync_names(&self.folder.join(DOCUMENT))?)
    }

    /// Throws the autosaves away: the project was closed in order.
    ///
    /// # Errors
    /// [`StoreError::File`].
    pub fn discard(self) -> Result<(), StoreError> {
        let folder = self.folder.clone();
        drop(self);
        remove(&folder)
    }
}

/// When the next autosave is due. Knows no clock: it is told the time.
#[derive(Debug, Clone, Default)]
pub struct AutosaveClock {
    dirty_since: Option<Instant>,
    written: Option<u64>,
}

impl AutosaveClock {
    /// How long until the project of `revision` is to be written: some 20 seconds after it began to
    /// differ from what was written last; nothing while it does not.
    pub fn due_in(&mut self, revision: u64, now: Instant) -> Option<Duration> {
        if self.written == Some(revision) {
            self.dirty_since = None;
            return None;
        }
        let since = *self.dirty_since.get_or_insert(now);
        Some(INTERVAL.saturating_sub(now.saturating_duration_since(since)))
    }

    /// Remembers what was written, as an autosave or by the user.
    pub fn wrote(&mut self, revision: u64) {
        self.written = Some(revision);
        self.dirty_since = None;
    }
}

/// What the folder holds, `None` when its project is open or there is nothing in it.
fn recoverable(folder: &Path) -> Option<Recoverable> {
    let document = folder.join(DOCUMENT);
    if !document.is_file() {
        return None;
    }
    drop(Lock::take_over(&document).ok()?);
    let about = read_limited(&folder.join(ABOUT), MOST_ABOUT_BYTES).ok();
    let about = about.and_then(|json| serde_json::from_slice(&json).ok());
    let about: About = about.unwrap_or_default();
    Some(Recoverable {
        folder: folder.to_owned(),
        title: about.title,
        file: about.file,
        saved_at: about.saved_at,
        tries: about.tries,
    })
}

fn write_about(folder: &Path, about: &About) -> Result<(), StoreError> {
    // A path that is no text cannot be told in JSON: the rest can.
    let json = serde_json::to_vec_pretty(about).or_else(|_| {
        let file = None;
        serde_json::to_vec_pretty(&About {
            file,
            ..about.clone()
        })
    });
    let json = json.expect("plain data is JSON");
    Ok(write_atomic(&folder.join(ABOUT), &json)?)
}

fn photo_path(folder: &Path, digest: Digest) -> PathBuf {
    folder.join(format!("{digest}.photo"))
}

fn remove(folder: &Path) -> Result<(), StoreError> {
    let removed = fs::remove_dir_all(folder);
    removed.map_err(|reason| {
        let path = folder.to_owned();
        FileError::Write { path, reason }.into()
    })
}
