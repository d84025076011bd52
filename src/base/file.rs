//! Files: read behind a limit, written so that a reader sees the old content or the new, whole.

use super::asking_for_memory;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

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
    Part::written(path, bytes)?.persist()
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
/// is taken before all bytes are on the disk. `go_on` is asked before each; what it says no with
/// is given back, and no file and no folder is left behind.
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
        go_on()?;
        parts.push(Part::written(path, bytes)?);
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
    Ok(parts.into_iter().try_for_each(Part::persist)?)
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

/// First and last letters of the hidden names that files have while they are written.
const PART_BEGIN: &str = ".boscage-";
const PART_END: &str = ".part";

/// A part that was touched so recently may be somebody's who has not locked it yet.
const PART_IS_FRESH: Duration = Duration::from_secs(10);

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
struct Part<'a> {
    path: &'a Path,
    file: tempfile::NamedTempFile,
}

impl<'a> Part<'a> {
    fn written(path: &'a Path, bytes: &[u8]) -> Result<Self, FileError> {
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
        let mut file = builder.tempfile_in(folder).map_err(failed)?;
        // Tells those who clear up that somebody is at work; where there are no locks its age does.
        #[cfg(unix)]
        let _ = file.as_file().try_lock();
        file.write_all(bytes).map_err(failed)?;
        file.as_file().sync_data().map_err(failed)?;
        Ok(Self { path, file })
    }

    /// Takes the name.
    fn persist(self) -> Result<(), FileError> {
        let Self { path, file } = self;
        let persisted = file.persist(path);
        persisted.map_err(|error| unwritten(path, error.error))?;
        Ok(())
    }
}

fn unwritten(path: &Path, reason: std::io::Error) -> FileError {
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
    #[cfg(unix)]
    fn what_killed_processes_left_goes_and_what_is_being_written_stays() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("textures");
        let target = below.join("tree.png");
        let writing = Part::written(&target, b"half").unwrap();
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
        writing.persist().unwrap();
        assert_eq!(read_limited(&target, 9).unwrap(), b"half");
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
                match asked > stop {
                    true => Err(FileError::Read {
                        path: PathBuf::from("stopped"),
                        reason: std::io::ErrorKind::Interrupted.into(),
                    }),
                    false => Ok(()),
                }
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
