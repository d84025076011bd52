//! Which segmenter a command uses, and what is told of its labels.

use super::failure::Failure;
use crate::base::Cancel;
use crate::batch::model::learned_from;
use crate::batch::records::SegmenterRecord;
use crate::segment::{
    Auto, Classical, Learned, ModelError, Provenance, SegmentError, Segmenter, standard,
};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Which segmenter to use; shared by all commands that segment.
#[derive(Debug, Args)]
pub(super) struct SegmenterFlags {
    /// What tells crown from trunk
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    segmenter: SegmenterName,
    /// A segmentation model to use instead of the one built in; FILE.json beside it or its metadata
    /// describe it
    #[arg(long, value_name = "FILE.onnx")]
    model: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum SegmenterName {
    /// The learned model; where it is unsure, the rules
    #[default]
    Auto,
    /// The learned model, however unsure
    Onnx,
    /// Rules: colour, width profile and height
    Classical,
}

impl SegmenterFlags {
    /// Whether something else than the default is asked for.
    pub(super) fn is_chosen(&self) -> bool {
        self.model.is_some() || self.segmenter != SegmenterName::Auto
    }

    /// The segmenter asked for.
    ///
    /// # Errors
    /// [`Failure::BadInput`] for a model that is none; [`Failure::Cancelled`].
    pub(super) fn checked(&self, cancel: &Cancel) -> Result<Box<dyn Segmenter>, Failure> {
        let own = self.model.as_deref();
        let own = own
            .map(|path| learned_from(path, None, cancel))
            .transpose()?;
        Ok(match (self.segmenter, own) {
            (SegmenterName::Classical, None) => Box::new(Classical),
            (SegmenterName::Classical, Some(_)) => {
                let reason = "the classical segmenter uses no model";
                return Err(Failure::of("--model", reason));
            }
            (SegmenterName::Auto, None) => Box::new(standard().clone()),
            (SegmenterName::Auto, Some(own)) => Box::new(Auto::with(own)),
            (SegmenterName::Onnx, own) => Box::new(match own {
                Some(own) => own,
                None => built_in()?,
            }),
        })
    }

    /// The segmenter that `record`, read from `file`, tells of.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it is not to be had.
    pub(super) fn recorded(
        &self,
        record: &SegmenterRecord,
        file: &Path,
        cancel: &Cancel,
    ) -> Result<Box<dyn Segmenter>, Failure> {
        let failed = |reason: String| Failure::of(file.display(), reason);
        if record.name == Classical.name() {
            return Ok(Box::new(Classical));
        }
        let learned = match &self.model {
            Some(path) => learned_from(path, None, cancel)?,
            None => built_in()?,
        };
        if record.model.as_deref() != Some(learned.digest().to_string().as_str()) {
            let digest = record.model.as_deref().unwrap_or("none");
            let reason = format!(
                "was made with another segmentation model ({}…); name that with --model",
                digest.get(..12).unwrap_or(digest)
            );
            return Err(failed(reason));
        }
        match record.name.as_str() {
            "auto" => Ok(Box::new(Auto::with(learned))),
            "learned" => Ok(Box::new(learned)),
            other => Err(failed(format!("no segmenter is named {other}"))),
        }
    }
}

fn built_in() -> Result<Learned, Failure> {
    let failed = |error: ModelError| Failure::of("the model built in", error);
    Learned::built_in().map_err(failed)
}

/// The failure that `error` about the picture in the file `path` is.
pub(super) fn failed(path: &Path, error: SegmentError) -> Failure {
    match error {
        SegmentError::Cancelled(cancelled) => cancelled.into(),
        error => Failure::of(path.display(), error),
    }
}

/// What JSON says of who made labels.
pub(super) fn provenance_json(provenance: &Provenance) -> Value {
    json!({
        "source": provenance.source,
        "confidence": provenance.confidence,
        "reason": provenance.reason,
    })
}

/// Adds the keys of the object `more` to the object `object`.
pub(super) fn add(object: &mut Value, more: Value) {
    if let (Value::Object(object), Value::Object(more)) = (object, more) {
        object.extend(more);
    }
}
