//! The user's own segmentation model: read and tried out in a job, kept for the next start.
//!
//! Until a model is ready, and where it is refused, the one that is built in labels pictures.

use super::outcome::Outcome;
use super::studio::{Severity, Studio};
use crate::batch::failure::Failure;
use crate::batch::model::learned_from;
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use crate::segment::{Auto, Learned, standard};
use std::path::{Path, PathBuf};

/// What came of reading a model.
pub(super) struct ReadModel {
    path: PathBuf,
    /// Or why it is refused.
    learned: Result<Learned, String>,
    /// Whether the user asked just now; else it is the choice of an earlier session.
    is_new: bool,
}

/// A model that the user brought.
pub(super) struct OwnModel {
    /// What users call it.
    name: String,
    segmenter: &'static Auto,
}

impl Studio {
    /// What labels pictures: the user's model, or the one that is built in.
    pub(super) fn segmenter(&self) -> &'static Auto {
        self.own_model
            .as_ref()
            .map_or_else(standard, |own| own.segmenter)
    }

    /// The name of the user's model, if that labels pictures.
    pub fn model_name(&self) -> Option<&str> {
        self.own_model.as_ref().map(|own| own.name.as_str())
    }

    /// What learned labels are said to come from.
    pub(super) fn learned_title(&self) -> String {
        self.model_name().map_or_else(
            || "the learned segmenter".to_owned(),
            |name| format!("the model {name}"),
        )
    }

    /// Has models tried out by `program`, which must be Boscage; else by the program that runs.
    pub fn try_models_with(&mut self, program: PathBuf) {
        self.trial_program = Some(program);
    }

    /// Reads the model in the file `path` and uses it if it is sound.
    pub(super) fn read_model(&mut self, path: PathBuf, is_new: bool) {
        let program = self.trial_program.clone();
        let work = move |context: &Context<Outcome>| {
            let learned = learned_from(&path, program.as_deref(), context.cancel());
            let learned = match learned {
                Err(Failure::Cancelled) => return Err(JobError::Cancelled(crate::base::Cancelled)),
                learned => learned.map_err(|failure| failure.to_string()),
            };
            Ok(Outcome::Model(Box::new(ReadModel {
                path,
                learned,
                is_new,
            })))
        };
        let topic = Topic {
            kind: "model",
            item: 0,
        };
        let priority = Priority::Interactive;
        let request = Request::new("Trying the segmentation model", topic, priority, work);
        self.jobs.submit(request);
    }

    /// Takes up a model, or tells why not.
    pub(super) fn accept_model(&mut self, read: ReadModel) {
        let ReadModel {
            path,
            learned,
            is_new,
        } = read;
        match learned {
            Ok(learned) => {
                let name = name_of(&learned, &path);
                if is_new {
                    let told = format!("The model {name} finds crown and trunk from now on.");
                    self.notify(Severity::Info, told);
                }
                self.preferences.segmentation_model = Some(path);
                // Kept for good: trees prepared with it may outlive the choice, and hands make few.
                let segmenter = Box::leak(Box::new(Auto::with(learned)));
                self.use_model(Some(OwnModel { name, segmenter }));
            }
            Err(reason) => {
                let told = format!("The segmentation model is not used. {reason}");
                self.notify(Severity::Error, told);
            }
        }
    }

    /// Labels pictures with the model that is built in, from now on.
    pub(super) fn use_built_in_model(&mut self) {
        self.preferences.segmentation_model = None;
        self.use_model(None);
        let told = "The model that is built in finds crown and trunk from now on.";
        self.notify(Severity::Info, told);
    }

    fn use_model(&mut self, own: Option<OwnModel>) {
        self.own_model = own;
        // What another model found is found again.
        self.vary.prepared = None;
        self.mask_work.shape_asked = None;
        self.changed();
    }
}

/// What the model calls itself, or else the name of its file.
fn name_of(learned: &Learned, path: &Path) -> String {
    let own = learned.card().name.trim();
    if own.is_empty() {
        let stem = path.file_stem().unwrap_or_default();
        stem.to_string_lossy().into_owned()
    } else {
        crate::base::one_line(own)
    }
}
