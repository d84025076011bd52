//! One instance a file.
//!
//! Beside an open project lies `.NAME.boscage.lock`, which names its owner for people and which the
//! operating system locks for programs. That lock ends with its process, however it dies, so a file
//! that was left behind blocks nobody. Only when the owner named is another machine and the system
//! nevertheless grants the lock is the truth unknown (some network shares lock on one machine only):
//! then the user decides.

use super::beside;
use crate::base::one_line;
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

/// Longest content of a lock file that is looked at, bytes.
const MOST_BYTES: u64 = 4096;

/// Tries to lock a file that others remove at the same moment.
const TRIES: u32 = 10;

/// Who holds a lock.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// The process.
    pub pid: u32,
    /// The machine.
    pub host: String,
}

impl Owner {
    fn this_process() -> Self {
        Self {
            pid: std::process::id(),
            host: host(),
        }
    }
}

/// A project is open elsewhere, or its lock cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// A living process has it open.
    #[error("{}: open in another window ({})", one_line(&path.display().to_string()), told(owner))]
    Held {
        /// The project.
        path: PathBuf,
        /// Who holds it, when the lock tells.
        owner: Option<Owner>,
    },
    /// Another machine had it open and perhaps still has: [`Lock::take_over`] after asking.
    #[error("{}: perhaps open on {}", one_line(&path.display().to_string()), one_line(&owner.host))]
    Unsure {
        /// The project.
        path: PathBuf,
        /// Who held it.
        owner: Owner,
    },
    /// No lock can be made there; the project can be opened for reading all the same.
    #[error("{}: cannot be locked: {reason}", one_line(&path.display().to_string()))]
    Unlockable {
        /// The project.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
}

fn told(owner: &Option<Owner>) -> String {
    owner
        .as_ref()
        .map_or("unknown process".to_owned(), |owner| {
            format!("process {} on {}", owner.pid, one_line(&owner.host))
        })
}

/// The right to write a project; ends when dropped.
#[derive(Debug)]
pub struct Lock {
    file: File,
    path: PathBuf,
}

impl Lock {
    /// Locks the project `path`, which need not exist.
    ///
    /// # Errors
    /// [`LockError`].
    pub fn acquire(path: &Path) -> Result<Self, LockError> {
        Self::locked(path, false)
    }

    /// As [`Lock::acquire`], though another machine may have it open: the user said that it has not.
    ///
    /// # Errors
    /// [`LockError`], never [`LockError::Unsure`].
    pub fn take_over(path: &Path) -> Result<Self, LockError> {
        Self::locked(path, true)
    }

    fn locked(path: &Path, is_sure: bool) -> Result<Self, LockError> {
        let failed = |reason| LockError::Unlockable {
            path: path.to_owned(),
            reason,
        };
        let lock_path = beside(path, ".", ".lock");
        for _ in 0..TRIES {
            let mut options = OpenOptions::new();
            options.read(true).write(true).create(true).truncate(false);
            let mut file = options.open(&lock_path).map_err(failed)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    let path = path.to_owned();
                    let owner = owner_in(&mut file);
                    return Err(LockError::Held { path, owner });
                }
                Err(TryLockError::Error(error)) => return Err(failed(error)),
            }
            // Its last owner may have removed it between our opening and our locking it.
            if !is_still_there(&file, &lock_path) {
                continue;
            }
            let ours = Owner::this_process();
            match owner_in(&mut file) {
                Some(owner) if !is_sure && owner.host != ours.host => {
                    let path = path.to_owned();
                    return Err(LockError::Unsure { path, owner });
                }
                _ => {}
            }
            let text = serde_json::to_vec(&ours).expect("plain data is JSON");
            file.set_len(0).map_err(failed)?;
            file.seek(SeekFrom::Start(0)).map_err(failed)?;
            file.write_all(&text).map_err(failed)?;
            return Ok(Self {
                file,
                path: lock_path,
            });
        }
        Err(failed(std::io::ErrorKind::ResourceBusy.into()))
    }
}

impl Drop for Lock {
    fn drop(&mut self) {
        // Emptied first: where a locked file cannot be removed it names nobody.
        let _ = self.file.set_len(0);
        let _ = fs::remove_file(&self.path);
        let _ = self.file.unlock();
    }
}

fn owner_in(file: &mut File) -> Option<Owner> {
    let mut text = Vec::new();
    file.seek(SeekFrom::Start(0)).ok()?;
    file.take(MOST_BYTES).read_to_end(&mut text).ok()?;
    serde_json::from_slice(&text).ok()
}

/// Whether `path` still names the open file.
#[cfg(unix)]
fn is_still_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let same = |a: &fs::Metadata, b: &fs::Metadata| a.ino() == b.ino() && a.dev() == b.dev();
    let (ours, there) = (file.metadata(), fs::metadata(path));
    matches!((ours, there), (Ok(ours), Ok(there)) if same(&ours, &there))
}

/// Elsewhere an open file keeps its name.
#[cfg(not(unix))]
fn is_still_there(_: &File, path: &Path) -> bool {
    path.exists()
}

/// The name of this machine, empty when it has none that can be found.
fn host() -> String {
    let files = ["/proc/sys/kernel/hostname", "/etc/hostname"];
    let named = files.iter().find_map(|file| fs::read_to_string(file).ok());
    let name = named.or_else(|| std::env::var("COMPUTERNAME").ok());
    name.unwrap_or_default().trim().to_owned()
}
