//! Files: read behind a limit, written so that a reader sees the old content or the new, whole.

use super::asking_for_memory;
use super::part::{Part, may_name};
use std::fs::{self, File};
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// A file could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    /// The file could not be opened or read.
    #[error("{}: cannot be read: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
    /// The file is larger than the reader accepts.
    #[error("{}: larger than the limit of {limit_bytes} bytes", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The most that is accepted.
        limit_bytes: u64,
    },
    /// The file could not be written; what was there before is untouched.
    #[error("{}: cannot be written: {reason}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: std::io::Error,
    },
}

/// The content of `path`, which must be a regular file of at most `limit_bytes`.
///
/// # Errors
/// [`FileError::Read`] when it cannot be read or is a folder, a pipe or a device;
/// [`FileError::TooLarge`] beyond the limit.
pub fn read_limited(path: &Path, limit_bytes: u64) -> Result<Vec<u8>, FileError> {
    let failed = |reason| FileError::Read {
        path: path.to_owned(),
        reason,
    };
    // Asked by name first: opening a pipe would wait for a writer.
    let metadata = fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        return Err(failed(std::io::Error::other("not a regular file")));
    }
    if metadata.len() > limit_bytes {
        return Err(FileError::TooLarge {
            path: path.to_owned(),
            limit_bytes,
        });
    }
    let mut bytes = Vec::new();
    asking_for_memory(|| bytes.try_reserve_exact(metadata.len() as usize))
        .map_err(|_| failed(std::io::ErrorKind::OutOfMemory.into()))?;
    // One byte more than allowed: a file that grows meanwhile is noticed.
    File::open(path)
        .and_then(|file| file.take(limit_bytes + 1).read_to_end(&mut bytes))
        .map_err(failed)?;
    if bytes.len() as u64 > limit_bytes {
        return Err(FileError::TooLarge {
            path: path.to_owned(),
            limit_bytes,
        });
    }
    Ok(bytes)
}

/// When `path` was last changed; `None` where it is not there or the system does not tell.
pub fn changed_at(path: &Path) -> Option<std::time::SystemTime> {
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

/// Writes `bytes` to `path`, making its folder where needed, all or nothing.
///
/// The bytes go to a hidden file beside `path`, are flushed to disk, and take the name `path` in
/// one step; whatever fails, `path` keeps its old content and nothing else is left behind.
///
/// # Errors
/// [`FileError::Write`].
pub fn write_atomic(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_atomic_while(path, bytes, || Ok(()))
}

/// [`write_atomic`] that asks `go_on` every few milliseconds until the bytes are on the disk; what it
/// says no with is given back, and nothing is left behind.
///
/// # Errors
/// Those of `go_on`, and [`FileError::Write`].
pub fn write_atomic_while<E: From<FileError>>(
    path: &Path,
    bytes: &[u8],
    go_on: impl FnMut() -> Result<(), E>,
) -> Result<(), E> {
    let part = Part::written(path, bytes, go_on)?;
    Ok(part.persist(&may_name())?)
}

/// Makes the names in the folder of `path` survive a loss of power: until then a file that was
/// written to the disk may still be found under its old name, or not at all.
///
/// # Errors
/// [`FileError::Write`]; the file is there all the same. Folders that cannot be flushed (other
/// systems, some network shares) are no error.
#[cfg(unix)]
pub fn sync_names(path: &Path) -> Result<(), FileError> {
    use std::io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    match File::open(folder_of(path)).and_then(|folder| folder.sync_all()) {
        Err(error) if ![InvalidInput, PermissionDenied, Unsupported].contains(&error.kind()) => {
            Err(unwritten(path, error))
        }
        _ => Ok(()),
    }
}

/// Elsewhere folders cannot be flushed.
#[cfg(not(unix))]
pub fn sync_names(_: &Path) -> Result<(), FileError> {
    Ok(())
}

/// The folder that `path` lies in.
pub fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Writes `files` (path and content), making their folders where needed, all or nothing: no name
/// is taken before all bytes are on the disk. `go_on` is asked as in [`write_atomic_while`]; when it
/// says no, no file and no folder is left behind.
///
/// A disk that fails between the names being taken leaves the first of the files.
///
/// # Errors
/// Those of `go_on`, and [`FileError::Write`].
pub fn write_all_atomic<E: From<FileError>>(
    files: &[(PathBuf, Vec<u8>)],
    mut go_on: impl FnMut() -> Result<(), E>,
) -> Result<(), E> {
    let folders = missing_folders(files.iter().map(|(path, _)| path.as_path()));
    let mut parts = Vec::with_capacity(files.len());
    let outcome = files.iter().try_for_each(|(path, bytes)| {
        parts.push(Part::written(path, bytes, &mut go_on)?);
        Ok(())
    });
    let outcome = outcome.and_then(|()| go_on());
    if let Err(error) = outcome {
        drop(parts);
        for folder in folders {
            // One that somebody else has filled meanwhile stays.
            let _ = fs::remove_dir(folder);
        }
        return Err(error);
    }
    let named = may_name();
    Ok(parts
        .into_iter()
        .try_for_each(|part| part.persist(&named))?)
}

/// The folders of `paths` that do not exist, the innermost first.
fn missing_folders<'a>(paths: impl Iterator<Item = &'a Path>) -> Vec<PathBuf> {
    let mut missing: Vec<PathBuf> = paths
        .flat_map(|path| path.ancestors().skip(1))
        .filter(|folder| !folder.as_os_str().is_empty() && !folder.exists())
        .map(Path::to_owned)
        .collect();
    missing.sort_unstable_by_key(|folder| std::cmp::Reverse(folder.components().count()));
    missing.dedup();
    missing
}

pub(super) fn unwritten(path: &Path, reason: std::io::Error) -> FileError {
    FileError::Write {
        path: path.to_owned(),
        reason: of_system(reason),
    }
}

/// What the system said, without the hidden name that the file had when it did.
fn of_system(reason: std::io::Error) -> std::io::Error {
    // `tempfile` puts the name behind the words and keeps the error to itself.
    match reason.to_string().split_once(" at path \"") {
        Some((words, _)) => std::io::Error::new(reason.kind(), words),
        None => reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_replaces_the_old_one_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/tree.json");
        write_atomic(&path, b"one").unwrap();
        write_atomic(&path, b"two").unwrap();
        assert_eq!(read_limited(&path, 3).unwrap(), b"two");
        assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
    }

    #[test]
    fn limits_and_odd_files_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        write_atomic(&path, &[0; 10]).unwrap();
        let error = read_limited(&path, 9).unwrap_err().to_string();
        assert!(
            error.contains("a.bin") && error.contains("9 bytes"),
            "{error}"
        );
        assert!(matches!(
            read_limited(folder.path(), 9),
            Err(FileError::Read { .. })
        ));
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("name");
        fs::create_dir(&path).unwrap();
        fs::write(path.join("keep"), b"").unwrap();
        assert!(write_atomic(&path, b"x").is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_large_file_is_given_up_on_the_way_and_the_old_one_stays() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("crown.obj");
        write_atomic(&path, b"old").unwrap();
        let large = vec![7u8; 5 << 20];
        let mut asked = 0;
        let outcome = write_atomic_while(&path, &large, || {
            asked += 1;
            (asked < 3).then_some(()).ok_or_else(stopped)
        });
        assert!(matches!(outcome, Err(FileError::Read { .. })));
        assert_eq!(asked, 3, "two steps were on the disk");
        assert_eq!(read_limited(&path, 3).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        write_atomic(&path, &large).unwrap();
        assert_eq!(read_limited(&path, 5 << 20).unwrap(), large);
    }

    fn stopped() -> FileError {
        FileError::Read {
            path: PathBuf::from("stopped"),
            reason: std::io::ErrorKind::Interrupted.into(),
        }
    }

    #[test]
    fn a_batch_is_written_whole_or_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let files: Vec<(PathBuf, Vec<u8>)> = ["a/b/one", "a/b/two", "a/three"]
            .map(|name| (folder.path().join(name), name.as_bytes().to_vec()))
            .into();
        for stop in 0..4 {
            let mut asked = 0;
            let outcome = write_all_atomic(&files, || {
                asked += 1;
                (asked <= stop).then_some(()).ok_or_else(stopped)
            });
            assert!(matches!(outcome, Err(FileError::Read { .. })));
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "{stop}");
        }
        write_all_atomic::<FileError>(&files, || Ok(())).unwrap();
        for (path, bytes) in &files {
            assert_eq!(&read_limited(path, 100).unwrap(), bytes);
        }
        assert_eq!(fs::read_dir(folder.path().join("a/b")).unwrap().count(), 2);
    }
}
