//! Why a command ends without having done its work, in the three classes that pipelines tell
//! apart by exit code.
//!
//! The question is always the same: would the same call work later, or on another machine? A bad
//! file or a path that cannot be a path will fail again (2); a full disk, lost memory or a network
//! share that went away will not (1). Permissions count as the user's choice of path: 2.

use crate::base::{Cancelled, FileError, brief_line};
use crate::export::CrownFilesError;
use crate::raster::{ImageError, Refusal};
use crate::render::RenderError;
use crate::segment::SegmentError;
use std::fmt;
use std::io::{self, ErrorKind};
use std::process::ExitCode;

/// Why a command failed. Prints as one line, without the leading `error: `.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Failure {
    /// Bad usage or bad input: will fail again. `FILE: reason`.
    BadInput(String),
    /// SIGINT or SIGTERM; nothing half-written is left.
    Cancelled,
    /// Disk, memory, threads: worth another try.
    Environment(String),
}

impl Failure {
    /// Bad input in the file or setting `name`.
    pub(crate) fn of(name: impl fmt::Display, reason: impl fmt::Display) -> Self {
        Self::BadInput(format!("{name}: {reason}"))
    }

    /// The crown `name` could not be made into files.
    pub(crate) fn of_crown_files(name: impl fmt::Display, error: &CrownFilesError) -> Self {
        match error {
            CrownFilesError::Mesh(reason) => Self::of(name, reason),
            CrownFilesError::Cancelled(_) => Self::Cancelled,
        }
    }

    /// What the process ends with.
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.status())
    }

    /// 2, 3 or 1.
    pub(crate) fn status(&self) -> u8 {
        match self {
            Self::BadInput(_) => 2,
            Self::Cancelled => 3,
            Self::Environment(_) => 1,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BadInput(message) | Self::Environment(message) => {
                f.write_str(&brief_line(message))
            }
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl From<Cancelled> for Failure {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let transient = match &error {
            FileError::Read { reason, .. } => read_may_work_later(reason),
            FileError::Write { reason, .. } => write_may_work_later(reason),
            FileError::TooLarge { .. } => false,
        };
        Self::classed(transient, error.to_string())
    }
}

impl From<ImageError> for Failure {
    fn from(error: ImageError) -> Self {
        match error {
            ImageError::File(error) => error.into(),
            ImageError::Refused { ref reason, .. } => {
                let transient = matches!(reason, Refusal::OutOfMemory { .. });
                Self::classed(transient, error.to_string())
            }
        }
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        match error {
            RenderError::Cancelled(cancelled) => cancelled.into(),
            RenderError::TooLarge { .. } => Self::of("--size", error),
            _ => Self::Environment(error.to_string()),
        }
    }
}

impl From<SegmentError> for Failure {
    fn from(error: SegmentError) -> Self {
        match error {
            SegmentError::Cancelled(cancelled) => cancelled.into(),
            SegmentError::Model(_) => Self::BadInput(error.to_string()),
        }
    }
}

impl Failure {
    fn classed(transient: bool, message: String) -> Self {
        if transient {
            Self::Environment(message)
        } else {
            Self::BadInput(message)
        }
    }
}

/// Whether a read that failed for `reason` may work later: not when the path is no readable file.
fn read_may_work_later(reason: &io::Error) -> bool {
    /// EIO, ENFILE, EMFILE: a failing disk, no file handles left; std has no names for them.
    const OF_THE_SYSTEM: [i32; 3] = [5, 23, 24];
    let by_code = reason
        .raw_os_error()
        .is_some_and(|code| cfg!(unix) && OF_THE_SYSTEM.contains(&code));
    let by_kind = matches!(
        reason.kind(),
        ErrorKind::OutOfMemory
            | ErrorKind::TimedOut
            | ErrorKind::Interrupted
            | ErrorKind::ResourceBusy
            | ErrorKind::StaleNetworkFileHandle
    );
    by_code || by_kind
}

/// Whether a write that failed for `reason` may work later: not when the path cannot be written by
/// this user at all.
fn write_may_work_later(reason: &io::Error) -> bool {
    !matches!(
        reason.kind(),
        ErrorKind::NotADirectory
            | ErrorKind::IsADirectory
            | ErrorKind::AlreadyExists
            | ErrorKind::PermissionDenied
            | ErrorKind::ReadOnlyFilesystem
            | ErrorKind::InvalidFilename
            | ErrorKind::InvalidInput
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(kind: ErrorKind) -> Failure {
        FileError::Write {
            path: "a/b.png".into(),
            reason: kind.into(),
        }
        .into()
    }

    #[test]
    fn a_full_disk_is_worth_a_retry_and_a_bad_path_is_not() {
        assert!(matches!(
            written(ErrorKind::StorageFull),
            Failure::Environment(_)
        ));
        assert!(matches!(
            written(ErrorKind::NotADirectory),
            Failure::BadInput(_)
        ));
    }

    #[test]
    fn a_missing_file_is_bad_input_and_a_failing_disk_is_not() {
        let read = |reason: io::Error| -> Failure {
            FileError::Read {
                path: "a.png".into(),
                reason,
            }
            .into()
        };
        assert!(matches!(
            read(ErrorKind::NotFound.into()),
            Failure::BadInput(_)
        ));
        #[cfg(unix)]
        assert!(matches!(
            read(io::Error::from_raw_os_error(5)),
            Failure::Environment(_)
        ));
    }

    #[test]
    fn a_failure_is_one_line() {
        let failure = Failure::of("a\nb.png", "no\r picture");
        assert_eq!(failure.to_string(), r"a\u{a}b.png: no\u{d} picture");
    }
}
