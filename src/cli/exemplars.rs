//! Tree pictures as commands take them: settings of preparation as flags, pictures prepared.

use super::failure::Failure;
use super::input::PictureFile;
use super::session::Session;
use crate::base::{Digest, Hasher};
use crate::segment::{SegmentError, Segmenter};
use crate::variation::{Exemplar, ExemplarError, ExemplarSettings};
use clap::Args;
use std::path::Path;

/// How pictures are prepared.
#[derive(Debug, Clone, Args)]
pub(super) struct SettingsFlags {
    #[command(flatten)]
    size: SizeFlag,
    /// Alpha above which a pixel is opaque, between 0 and 1
    #[arg(long, default_value_t = 0.5, value_name = "ALPHA")]
    threshold: f64,
    /// Points of the resampled contour
    #[arg(long, default_value_t = 2000, value_name = "N", value_parser = clap::value_parser!(u32).range(10..=100_000))]
    points: u32,
    /// Vertices of the simplified contour, at most as many as points [default: 100]
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u32).range(10..=100_000))]
    simplified: Option<u32>,
}

/// The size of normalised pictures, for commands with no other setting.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct SizeFlag {
    /// Side of the square that pictures are brought to, in pixels
    #[arg(long, default_value_t = 1024, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(16..=8192))]
    size: u32,
}

impl SizeFlag {
    /// The settings: this size, all else by default.
    pub(super) fn settings(self) -> ExemplarSettings {
        ExemplarSettings {
            size: self.size,
            ..ExemplarSettings::default()
        }
    }
}

impl SettingsFlags {
    /// The settings asked for.
    ///
    /// # Errors
    /// [`Failure::BadInput`] for numbers that mean nothing.
    pub(super) fn checked(&self) -> Result<ExemplarSettings, Failure> {
        let defaults = self.size.settings();
        let points = self.points as usize;
        let simplified = match self.simplified {
            Some(simplified) => simplified as usize,
            None => defaults.simplified.min(points),
        };
        if !(self.threshold > 0.0 && self.threshold < 1.0) {
            return Err(Failure::of("--threshold", "must lie between 0 and 1"));
        }
        if simplified > points {
            let reason = format!("{simplified} are more than the {points} of --points");
            return Err(Failure::of("--simplified", reason));
        }
        Ok(ExemplarSettings {
            threshold: self.threshold,
            points,
            simplified,
            ..defaults
        })
    }
}

/// Adds all that preparation depends on, but for the picture itself, to a recipe.
pub(super) fn with_settings(
    recipe: Hasher,
    settings: &ExemplarSettings,
    segmenter: &dyn Segmenter,
) -> Hasher {
    recipe
        .with(&settings.size.to_le_bytes())
        .with(&settings.threshold.to_le_bytes())
        .with(&(settings.points as u64).to_le_bytes())
        .with(&(settings.simplified as u64).to_le_bytes())
        .with(segmenter.key().as_bytes())
}

/// The picture in the file `path`, prepared, and the digest of the file.
///
/// # Errors
/// [`Failure`] naming the file.
pub(super) fn prepared(
    path: &Path,
    settings: &ExemplarSettings,
    segmenter: &dyn Segmenter,
    session: &Session<'_>,
) -> Result<(Exemplar, Digest), Failure> {
    let file = PictureFile::read(path)?;
    let picture = file.decoded()?;
    let exemplar = Exemplar::prepare(
        &picture,
        settings,
        segmenter,
        session.progress,
        session.cancel,
    )
    .map_err(|error| refused(path, error))?;
    Ok((exemplar, file.digest()))
}

/// The failure that `error` about the picture in the file `path` is.
pub(super) fn refused(path: &Path, error: ExemplarError) -> Failure {
    match error {
        ExemplarError::Segment(SegmentError::Cancelled(cancelled)) => cancelled.into(),
        error => Failure::of(path.display(), error),
    }
}
