//! Tree pictures opened as a library, with what cannot be used told.

use super::failure::Failure;
use super::run::Run;
use crate::segment::Segmenter;
use crate::variation::{ExemplarSettings, Library, LibraryError, LibraryPicture};
use std::path::Path;

/// Opens `pictures` as a library, warning of those that cannot be used.
///
/// # Errors
/// [`Failure::BadInput`] when none can be used; [`Failure::Cancelled`].
pub(crate) fn opened<'a>(
    pictures: &[LibraryPicture],
    settings: ExemplarSettings,
    segmenter: &'a dyn Segmenter,
    cache: Option<&Path>,
    session: &Run<'_>,
) -> Result<Library<'a>, Failure> {
    let (library, refused) = Library::of(
        pictures,
        settings,
        segmenter,
        cache,
        None,
        session.progress,
        session.cancel,
    )?;
    if library.entries().is_empty() {
        return Err(match refused.into_iter().next() {
            Some(only) if pictures.len() == 1 => only.reason.into(),
            _ => {
                let count = pictures.len();
                Failure::BadInput(format!("none of the {count} pictures can be used"))
            }
        });
    }
    for refused in &refused {
        session
            .progress
            .warn(&format!("{}; it is left out", refused.reason));
    }
    Ok(library)
}

impl From<LibraryError> for Failure {
    fn from(error: LibraryError) -> Self {
        match error {
            LibraryError::File(error) => error.into(),
            LibraryError::Image(error) => error.into(),
            LibraryError::Cancelled(cancelled) => cancelled.into(),
            LibraryError::Exemplar { .. } | LibraryError::Changed { .. } => {
                Self::BadInput(error.to_string())
            }
        }
    }
}
