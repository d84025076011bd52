//! What happens to files that are there already, in one place for all commands.
//!
//! By default nothing is replaced. With `--overwrite` everything is. With `--resume` a file stays
//! when it was made by the same version from the same inputs and settings and is whole; all others
//! are made again. What a file was made from stands in the file itself (see [`super::stamp`]), so
//! there is no record beside it that could be lost, go stale or be fought over by shards.

use super::failure::Failure;
use super::stamp;
use crate::base::{Cancel, Digest, Hasher, read_limited, write_all_atomic, write_atomic_while};
use std::path::{Path, PathBuf};

/// What to do when an output exists.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Policy {
    /// Fail before the work begins.
    Refuse,
    /// Replace it.
    Overwrite,
    /// Keep it if it is what would be made, else replace it.
    Resume,
}

/// Largest file that is read to see whether it can stay; a larger one is made again.
const LARGEST_KEPT_BYTES: u64 = 1 << 32;

/// Writes files under a [`Policy`], until it is cancelled.
#[derive(Debug, Clone)]
pub(crate) struct Output {
    policy: Policy,
    cancel: Cancel,
}

impl Output {
    /// An output with this policy; once `cancel` is raised it writes no more.
    pub(crate) fn new(policy: Policy, cancel: &Cancel) -> Self {
        Self {
            policy,
            cancel: cancel.clone(),
        }
    }

    /// Fails when one of `paths` may not be written because it exists; to be called with all paths
    /// that are known, before the work.
    ///
    /// # Errors
    /// [`Failure::BadInput`] naming the first such file.
    pub(crate) fn check<P: AsRef<Path>>(
        &self,
        paths: impl IntoIterator<Item = P>,
    ) -> Result<(), Failure> {
        let mut paths = paths.into_iter();
        let refused = paths.find(|path| {
            let path = path.as_ref();
            path.is_dir() || (self.policy == Policy::Refuse && path.symlink_metadata().is_ok())
        });
        match refused {
            None => Ok(()),
            Some(path) if path.as_ref().is_dir() => {
                Err(Failure::of(path.as_ref().display(), "is a folder"))
            }
            Some(path) => Err(Failure::of(
                path.as_ref().display(),
                "exists already; give --overwrite to replace it or --resume to keep what is done",
            )),
        }
    }

    /// Like [`Output::check`], but a file that holds exactly `content` may stay: several shards of
    /// a job write the same record.
    ///
    /// # Errors
    /// As [`Output::check`].
    pub(crate) fn check_same(&self, path: &Path, content: &[u8]) -> Result<(), Failure> {
        let is_same = read_limited(path, content.len() as u64).is_ok_and(|bytes| bytes == content);
        if is_same { Ok(()) } else { self.check([path]) }
    }

    /// Writes `content` unless the file holds it already.
    ///
    /// # Errors
    /// As [`Output::write_item`].
    pub(crate) fn write_same(&self, path: &Path, content: &[u8]) -> Result<(), Failure> {
        self.check_same(path, content)?;
        self.put(path, content)
    }

    /// Whether `path` can stay: `--resume` was given, and the file is whole and was made by
    /// [`Output::write_item`] with this `recipe`.
    pub(crate) fn is_ready(&self, path: &Path, recipe: Digest) -> bool {
        self.policy == Policy::Resume
            && read_limited(path, LARGEST_KEPT_BYTES)
                .is_ok_and(|bytes| stamp::is_intact(&bytes, recipe))
    }

    /// The note in `path`, if the file can stay (see [`Output::is_ready`]) and holds one.
    pub(crate) fn ready_note(&self, path: &Path, recipe: Digest) -> Option<String> {
        if self.policy != Policy::Resume {
            return None;
        }
        let bytes = read_limited(path, LARGEST_KEPT_BYTES).ok()?;
        let is_ready = stamp::is_intact(&bytes, recipe);
        stamp::note(&bytes).filter(|_| is_ready).map(str::to_owned)
    }

    /// [`Output::write_item`] with a note of ASCII letters in the file, if it is a PNG.
    ///
    /// # Errors
    /// As [`Output::write_item`].
    pub(crate) fn write_noted_item(
        &self,
        path: &Path,
        bytes: Vec<u8>,
        note: &str,
        recipe: Digest,
    ) -> Result<(), Failure> {
        self.write_item(path, stamp::noted(bytes, note), recipe)
    }

    /// Takes away an item that is to be made again before the files that belong to it are replaced: a
    /// run that is killed on the way must not leave the mark of the old ones beside new ones.
    ///
    /// # Errors
    /// As [`Output::write_item`].
    pub(super) fn outdate(&self, path: &Path) -> Result<(), Failure> {
        self.check([path])?;
        match std::fs::remove_file(path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Failure::of(path.display(), error))
            }
            _ => Ok(()),
        }
    }

    /// Writes an item of a job, atomically; a PNG file carries its `recipe`, see [`recipe`].
    ///
    /// # Errors
    /// [`Failure::BadInput`] when the file exists and may not be replaced, or when the path cannot
    /// be written; [`Failure::Environment`] when the disk fails; [`Failure::Cancelled`].
    pub(crate) fn write_item(
        &self,
        path: &Path,
        bytes: Vec<u8>,
        recipe: Digest,
    ) -> Result<(), Failure> {
        self.write(path, &stamp::stamped(bytes, recipe))
    }

    /// Writes the items of a job that belong together, all or none.
    ///
    /// # Errors
    /// As [`Output::write_item`].
    pub(crate) fn write_items(
        &self,
        items: Vec<(PathBuf, Vec<u8>)>,
        recipe: Digest,
    ) -> Result<(), Failure> {
        self.check(items.iter().map(|(path, _)| path))?;
        let stamped = items
            .into_iter()
            .map(|(path, bytes)| (path, stamp::stamped(bytes, recipe)))
            .collect::<Vec<_>>();
        write_all_atomic(&stamped, || Ok(self.cancel.check()?))
    }

    /// Writes a file that is made anew by every run (sheets, lists), atomically.
    ///
    /// # Errors
    /// As [`Output::write_item`].
    pub(crate) fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        self.check([path])?;
        self.put(path, bytes)
    }

    fn put(&self, path: &Path, bytes: &[u8]) -> Result<(), Failure> {
        write_atomic_while(path, bytes, || Ok(self.cancel.check()?))
    }
}

/// Begins the digest of all that goes into an item: add the digests of the inputs and all settings
/// with [`Hasher::with`]. `command` keeps commands apart; the version is part of it.
pub(crate) fn recipe(command: &str) -> Hasher {
    Hasher::new("boscage output")
        .with(env!("CARGO_PKG_VERSION").as_bytes())
        .with(command.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Compression, Image, encode_grey_png};
    use std::fs;

    fn png() -> Vec<u8> {
        encode_grey_png(&Image::filled(3, 3, 9u8), Compression::Fast)
    }

    #[test]
    fn what_exists_is_refused_replaced_or_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let made = Digest::of(b"one");
        let refuse = Output::new(Policy::Refuse, &Cancel::new());
        refuse.write_item(&path, png(), made).unwrap();
        assert!(refuse.write_item(&path, png(), made).is_err());
        assert!(refuse.check([&path]).is_err());
        assert!(!refuse.is_ready(&path, made));
        let resume = Output::new(Policy::Resume, &Cancel::new());
        assert!(resume.is_ready(&path, made));
        assert!(!resume.is_ready(&path, Digest::of(b"two")));
        Output::new(Policy::Overwrite, &Cancel::new())
            .write(&path, b"x")
            .unwrap();
        assert!(!resume.is_ready(&path, made));
        resume.write_item(&path, png(), made).unwrap();
        assert!(resume.is_ready(&path, made));
    }

    #[test]
    fn a_folder_in_the_place_of_a_file_is_never_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let output = Output::new(Policy::Overwrite, &Cancel::new());
        assert!(output.check([folder.path()]).is_err());
        assert!(output.write(folder.path(), b"x").is_err());
        assert!(fs::read_dir(folder.path()).unwrap().next().is_none());
    }
}
