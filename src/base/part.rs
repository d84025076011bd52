//! Files while they are written: under hidden names, which go with whoever writes them.

use super::file::{FileError, changed_at, folder_of, unwritten};
use std::collections::BTreeSet;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard};
use std::time::Duration;

/// First and last letters of the hidden names that files have while they are written.
const PART_BEGIN: &str = ".boscage-";
const PART_END: &str = ".part";

/// A part that was touched so recently may be somebody's who has not locked it yet.
const PART_IS_FRESH: Duration = Duration::from_secs(10);

/// Bytes that go to the disk at once: a system neither removes a file nor ends a process before the
/// step is done that it is in, and a command that is cancelled has 100 ms.
const STEP_BYTES: usize = 2 << 20;

/// Removes what processes that were killed left of files they were writing, in `folder` and, to
/// `depth` levels, the folders in it. What cannot be read or removed stays.
///
/// A living process, on this machine or through a share that knows locks, keeps its files: it has
/// them locked.
pub fn remove_left_parts(folder: &Path, depth: usize) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let Ok(kind) = entry.file_type() else {
            continue;
        };
        if kind.is_dir() && depth > 0 {
            remove_left_parts(&entry.path(), depth - 1);
        } else if kind.is_file() && is_part(&entry.file_name()) && is_left(&entry.path()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_part(name: &OsStr) -> bool {
    let name = name.as_encoded_bytes();
    name.starts_with(PART_BEGIN.as_bytes()) && name.ends_with(PART_END.as_bytes())
}

/// Whether nobody writes the part `path` any more.
fn is_left(path: &Path) -> bool {
    let age = changed_at(path).and_then(|then| then.elapsed().ok());
    age.is_some_and(|age| age > PART_IS_FRESH)
        && File::open(path).is_ok_and(|file| file.try_lock().is_ok())
}

/// The bytes of a file on disk under a hidden name, which goes when it is dropped.
pub(super) struct Part<'a> {
    path: &'a Path,
    file: tempfile::NamedTempFile,
    _hidden: Hidden,
}

/// An entry in [`HIDDEN`].
struct Hidden(PathBuf);

impl Hidden {
    fn new(path: &Path) -> Self {
        hidden().insert(path.to_owned());
        Self(path.to_owned())
    }
}

impl Drop for Hidden {
    fn drop(&mut self) {
        hidden().remove(&self.0);
    }
}

/// The right to give files names and to make hidden ones: nobody has it once the process ends.
static NAMING: RwLock<()> = RwLock::new(());

/// The hidden files of this process.
static HIDDEN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn hidden() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    HIDDEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The right to give files their names, for as long as it is held; waits for ever once
/// [`end_writing`] was called.
pub(super) fn may_name() -> RwLockReadGuard<'static, ()> {
    NAMING.read().unwrap_or_else(PoisonError::into_inner)
}

/// Removes the files that this process is writing, and lets it write no more: for whoever is about to
/// end it while it works. Files that have their names stay, and batches of them are whole.
pub fn end_writing() {
    // Kept for ever.
    std::mem::forget(NAMING.write().unwrap_or_else(PoisonError::into_inner));
    for path in std::mem::take(&mut *hidden()) {
        let _ = fs::remove_file(path);
    }
}

impl<'a> Part<'a> {
    /// Puts `bytes` on the disk step by step, asking `go_on` before each.
    pub(super) fn written<E: From<FileError>>(
        path: &'a Path,
        bytes: &[u8],
        mut go_on: impl FnMut() -> Result<(), E>,
    ) -> Result<Self, E> {
        let failed = |reason| unwritten(path, reason);
        let folder = folder_of(path);
        fs::create_dir_all(folder).map_err(failed)?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(PART_BEGIN).suffix(PART_END);
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // What a plain `File::create` would ask for; the umask takes its share.
            builder.permissions(fs::Permissions::from_mode(0o666));
        }
        let named = may_name();
        let file = builder.tempfile_in(folder).map_err(failed)?;
        let mut part = Self {
            path,
            _hidden: Hidden::new(file.path()),
            file,
        };
        drop(named);
        let file = &mut part.file;
        // Tells those who clear up that somebody is at work; where there are no locks its age does.
        #[cfg(unix)]
        let _ = file.as_file().try_lock();
        for step in bytes.chunks(STEP_BYTES) {
            go_on()?;
            file.write_all(step).map_err(failed)?;
            file.as_file().sync_data().map_err(failed)?;
        }
        Ok(part)
    }

    /// Takes the name.
    pub(super) fn persist(self, _: &RwLockReadGuard<'_, ()>) -> Result<(), FileError> {
        let persisted = self.file.persist(self.path);
        persisted.map_err(|error| unwritten(self.path, error.error))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_limited;
    use super::*;

    #[test]
    #[cfg(unix)]
    fn what_killed_processes_left_goes_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("textures");
        let target = below.join("tree.png");
        let writing = Part::written::<FileError>(&target, b"half", || Ok(())).unwrap();
        let old = std::time::SystemTime::now() - 2 * PART_IS_FRESH;
        writing.file.as_file().set_modified(old).unwrap();
        let file = |name: &str, is_old: bool| {
            let path = below.join(name);
            let file = File::create(&path).unwrap();
            if is_old {
                file.set_modified(old).unwrap();
            }
            path
        };
        let left = file(".boscage-abc.part", true);
        let kept = [
            file(".boscage-new.part", false),
            file("boscage-abc.part", true),
            file(".boscage-abc", true),
            writing.file.path().to_owned(),
        ];
        remove_left_parts(folder.path(), 0);
        assert!(left.exists(), "too deep");
        remove_left_parts(folder.path(), 1);
        assert!(!left.exists());
        assert!(kept.iter().all(|path| path.exists()));
        writing.persist(&may_name()).unwrap();
        assert!(hidden().iter().all(|path| path.parent() != Some(&below)));
        assert_eq!(read_limited(&target, 9).unwrap(), b"half");
    }
}
