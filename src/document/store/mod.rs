//! Projects on disk: opening, saving, backups, locks, autosaves.
//!
//! A save never leaves less than there was: the new file is complete on disk before it takes the name,
//! and the file that had the name is kept as `NAME.boscage~`. A file that somebody else changed since
//! it was opened is noticed by its digest (times lie: synchronised folders, coarse clocks, restored
//! backups) and not overwritten unasked. All functions may take as long as the disk does: call them
//! from a job.

mod lock;
mod recovery;

pub use lock::{Lock, LockError, Owner};
pub use recovery::{Autosave, AutosaveClock, Recoverable, Recovery};

use super::encode::{Decoded, decode, encode};
use super::format::FormatError;
use super::project::Snapshot;
use crate::base::{
    Cancel, Cancelled, Digest, FileError, folder_of, one_line, read_limited, remove_left_parts,
    sync_names, write_atomic,
};
use std::ffi::OsString;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

/// Largest file that is opened.
const MOST_FILE_BYTES: u64 = 8 << 30;

/// A project could not be opened or saved. Prints as one line that names the file.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The file could not be read or written.
    #[error("{}", one_line(&.0.to_string()))]
    File(#[from] FileError),
    /// The file is no project, or not one that is understood.
    #[error("{}: {reason}", one_line(&path.display().to_string()))]
    Format {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: FormatError,
    },
    /// Somebody else changed the file since it was opened or saved here.
    #[error("{}: changed on disk since it was opened", one_line(&path.display().to_string()))]
    ChangedOnDisk {
        /// The file.
        path: PathBuf,
    },
    /// The previous version could not be kept; the file is untouched.
    #[error("{}: its backup cannot be made: {reason}", one_line(&path.display().to_string()))]
    Backup {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// The save was asked to stop; the file is untouched.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// What a file held when it was last read or written here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stamp(Digest);

/// How a file stands to its stamp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnDisk {
    /// As it was left.
    Same,
    /// Somebody else wrote it.
    Changed,
    /// It is gone.
    Missing,
}

/// What a save does with a file that is there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// Replaces it only if it is still what the stamp says: *save*.
    Unchanged(Stamp),
    /// Replaces whatever is there: the user was asked, *save as* or *overwrite*.
    Anything,
}

/// The project in the file `path`, and its stamp.
///
/// # Errors
/// [`StoreError::File`], [`StoreError::Format`].
pub fn open(path: &Path) -> Result<(Decoded, Stamp), StoreError> {
    let bytes = read_limited(path, MOST_FILE_BYTES)?;
    let decoded = decode(&bytes, |_| None).map_err(|reason| StoreError::Format {
        path: path.to_owned(),
        reason,
    })?;
    Ok((decoded, Stamp(Digest::of(&bytes))))
}

/// Writes a project to `path`; the previous file there stays as [`backup_path`].
///
/// # Errors
/// [`StoreError`]; whatever it is, the file `path` is then as it was, or the new one whole where the
/// disk failed after that.
pub fn save(
    path: &Path,
    snapshot: &Snapshot,
    over: Over,
    cancel: &Cancel,
) -> Result<Stamp, StoreError> {
    let bytes = encode(snapshot, cancel)?;
    if let Over::Unchanged(stamp) = over
        && on_disk(path, stamp)? == OnDisk::Changed
    {
        let path = path.to_owned();
        return Err(StoreError::ChangedOnDisk { path });
    }
    cancel.check()?;
    remove_left_parts(folder_of(path), 0);
    keep_backup(path)?;
    write_atomic(path, &bytes)?;
    sync_names(path)?;
    Ok(Stamp(Digest::of(&bytes)))
}

/// Whether the file is still what it was. Reads all of it.
///
/// # Errors
/// [`StoreError::File`] when it is there and cannot be read.
pub fn on_disk(path: &Path, stamp: Stamp) -> Result<OnDisk, StoreError> {
    match read_limited(path, MOST_FILE_BYTES) {
        Ok(bytes) if Digest::of(&bytes) == stamp.0 => Ok(OnDisk::Same),
        Ok(_) | Err(FileError::TooLarge { .. }) => Ok(OnDisk::Changed),
        Err(FileError::Read { reason, .. }) if reason.kind() == ErrorKind::NotFound => {
            Ok(OnDisk::Missing)
        }
        Err(error) => Err(error.into()),
    }
}

/// Where the previous version of `path` is kept: the name with a tilde, as editors do.
pub fn backup_path(path: &Path) -> PathBuf {
    beside(path, "", "~")
}

/// Gives the present file a second name before the first is taken by the new one.
fn keep_backup(path: &Path) -> Result<(), StoreError> {
    let backup = backup_path(path);
    let new = beside(path, ".", "~new");
    let failed = |reason| StoreError::Backup {
        path: path.to_owned(),
        reason,
    };
    if !fs::exists(path).map_err(failed)? {
        return Ok(());
    }
    // Left over from a crash between the two steps below.
    match fs::remove_file(&new) {
        Err(error) if error.kind() != ErrorKind::NotFound => return Err(failed(error)),
        _ => {}
    }
    // A link costs nothing; some file systems have none.
    fs::hard_link(path, &new)
        .or_else(|_| fs::copy(path, &new).map(|_| ()))
        .map_err(failed)?;
    fs::rename(&new, &backup).map_err(failed)
}

/// The path with something before and behind its file name.
fn beside(path: &Path, before: &str, behind: &str) -> PathBuf {
    let mut name = OsString::from(before);
    name.push(path.file_name().unwrap_or_default());
    name.push(behind);
    path.with_file_name(name)
}

#[cfg(test)]
mod tests;
