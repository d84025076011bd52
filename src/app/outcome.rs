//! The jobs of the window, and what becomes of their results.

use super::live::LiveOutcome;
use super::mask_jobs::MaskResult;
use super::own_model::ReadModel;
use super::photo_jobs::decoded;
use super::photos::Thumbnail;
use super::studio::{Effect, Question, Severity, SharedAutosave, Studio};
use super::vary_jobs::VaryOutcome;
use crate::base::{Cancel, Digest};
use crate::document::store::{
    self, LockError, OnDisk, Over, Recoverable, Recovery, Stamp, StoreError,
};
use crate::document::{Decoded, Document, Edit, NewPhoto, PhotoId, Snapshot};
use crate::jobs::{Context, JobError, Message, Priority, Report, Request, Topic};
use crate::paint::TiledMask;
use crate::raster::{Image, Pyramid, Straight};
use crate::segment::{Segmenter as _, standard};
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

/// What a job gives back.
pub(super) enum Outcome {
    /// A photograph's pixels.
    Whole(Digest, Arc<Image<Straight>>),
    /// A photograph's thumbnail.
    Thumb(Digest, Thumbnail),
    /// Pictures to add, and what could not be read.
    Pictures(Vec<NewPhoto>, Vec<String>),
    /// The thumbnails that were in sight are there.
    Seen,
    /// A project from a file.
    Opened(PathBuf, Box<Decoded>, Stamp),
    /// The project of the sample library: no file holds it.
    Sample(Box<Document>),
    /// A project from an autosave.
    Recovered(Recoverable, Box<Decoded>),
    /// A revision of the project of this number was written.
    Saved(u64, PathBuf, Stamp, u64),
    /// It was not, and why.
    NotSaved(u64, StoreError),
    /// An autosave of a revision of the project of this number was written.
    Autosaved(u64, u64),
    /// How the project's file stands to what was read or written last.
    Looked(PathBuf, OnDisk),
    /// An autosave was thrown away.
    Discarded(PathBuf),
    /// A photograph's smaller versions, for the canvas.
    Reduced(Digest, Arc<Pyramid>),
    /// Something about a mask.
    Mask(MaskResult),
    /// About the crown.
    Live(LiveOutcome),
    /// What a job of the variations gave.
    Vary(VaryOutcome),
    /// A segmentation model was read.
    Model(Box<ReadModel>),
}

fn topic(kind: &'static str, item: u64) -> Topic {
    Topic { kind, item }
}

impl Studio {
    fn add_pictures(&mut self, pictures: Vec<NewPhoto>, failures: Vec<String>) {
        let first = self.document.state().content().next_photo;
        let label = match pictures.len() {
            1 => "Add Picture",
            _ => "Add Pictures",
        };
        self.end_gesture();
        match self.document.apply(label, Edit::AddPhotos(pictures)) {
            Ok(true) => {
                self.document.view_mut().photo = Some(PhotoId(first));
                self.effects.push(Effect::ZoomToFit);
                self.changed();
            }
            Ok(false) => {}
            Err(error) => self.notify(Severity::Error, error.to_string()),
        }
        for failure in failures {
            self.notify(Severity::Error, failure);
        }
    }

    /// Takes up what jobs tell. Whether anything did.
    pub fn take_outcomes(&mut self) -> bool {
        let mut took = false;
        while let Some(message) = self.jobs.poll() {
            self.take(message);
            took = true;
        }
        if took {
            self.follow_live();
        }
        self.autosave_if_due();
        took
    }

    fn take(&mut self, message: Message<Outcome>) {
        if matches!(message.report, Report::Ended(_)) {
            self.live_job_ended(message.id);
        }
        match message.report {
            Report::Partial(outcome) | Report::Ended(Ok(outcome)) => self.accept(outcome),
            Report::Ended(Err(JobError::Cancelled(_))) => {}
            Report::Ended(Err(error)) => self.notify(Severity::Error, error.to_string()),
        }
    }

    fn accept(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Whole(digest, image) => {
                self.photos.put_whole(digest, image);
                self.ask_for_shape();
            }
            Outcome::Reduced(digest, pyramid) => self.photos.put_pyramid(digest, pyramid),
            Outcome::Mask(result) => self.accept_mask(result),
            Outcome::Thumb(digest, thumbnail) => self.photos.put_thumbnail(digest, thumbnail),
            Outcome::Pictures(pictures, failures) => self.add_pictures(pictures, failures),
            Outcome::Seen => {}
            Outcome::Opened(path, decoded, stamp) => self.opened(path, *decoded, stamp),
            Outcome::Sample(document) => self.replace(*document),
            Outcome::Recovered(left, decoded) => self.recovered(left, *decoded),
            Outcome::Saved(project, path, stamp, revision) => {
                self.saved(project, path, (stamp, revision));
            }
            Outcome::NotSaved(project, error) => self.not_saved(project, error),
            Outcome::Autosaved(project, revision) => {
                if project == self.project {
                    self.autosave_clock.wrote(revision);
                }
            }
            Outcome::Live(outcome) => self.accept_live(outcome),
            Outcome::Looked(path, on_disk) => self.looked(&path, on_disk),
            Outcome::Discarded(folder) => self.recoverable.retain(|left| left.folder != folder),
            Outcome::Vary(outcome) => self.accept_variation(outcome),
            Outcome::Model(read) => self.accept_model(*read),
        }
    }

    fn opened(&mut self, path: PathBuf, decoded: Decoded, stamp: Stamp) {
        let lock = match store::Lock::acquire(&path) {
            Ok(lock) => Some(lock),
            Err(error @ LockError::Held { .. }) => {
                let why = format!("{error}. You can look at it and save it under another name.");
                self.notify(Severity::Warning, why);
                None
            }
            Err(error) => {
                self.notify(Severity::Warning, error.to_string());
                None
            }
        };
        self.show(decoded);
        self.preferences.remember(&path);
        self.file.path = Some(path);
        self.file.stamp = Some(stamp);
        self.file.lock = lock;
    }

    /// What a crash left behind is the project again. Its autosave goes once there is a new one.
    fn recovered(&mut self, left: Recoverable, decoded: Decoded) {
        self.show(decoded);
        self.document.mark_unsaved();
        if let Some(file) = &left.file {
            self.file.lock = store::Lock::acquire(file).ok();
            self.file.path = Some(file.clone());
        }
        self.write_autosave(self.document.snapshot(), Some(left));
    }

    fn looked(&mut self, path: &Path, on_disk: OnDisk) {
        if self.file.path.as_deref() != Some(path) {
            return;
        }
        let name = path.display();
        match on_disk {
            OnDisk::Same => {}
            OnDisk::Changed => {
                let text = format!("{name} was changed by another program; saving will ask.");
                self.notify(Severity::Warning, text);
            }
            OnDisk::Missing => {
                self.document.mark_unsaved();
                let text = format!("{name} is gone; saving writes it again.");
                self.notify(Severity::Warning, text);
            }
        }
    }

    /// Makes `decoded` the project, with no file.
    fn show(&mut self, decoded: Decoded) {
        self.replace(decoded.document);
        for note in decoded.notes {
            self.notify(Severity::Warning, note);
        }
    }

    /// Makes `document` the project, with no file.
    pub(super) fn replace(&mut self, document: Document) {
        self.discard_autosave();
        self.document = document;
        self.project += 1;
        self.file = super::studio::ProjectFile::default();
        self.after_save = None;
        self.question = None;
        self.painting = None;
        self.mask_work.sketch = None;
        self.mask_work.held.clear();
        self.vary = super::vary::Vary::default();
        self.autosave_clock = store::AutosaveClock::default();
        self.autosave_clock
            .wrote(self.document.snapshot().revision());
        if self.document.view().canvas.is_none() {
            self.effects.push(Effect::ZoomToFit);
        }
        self.changed();
    }

    fn saved(&mut self, project: u64, path: PathBuf, (stamp, revision): (Stamp, u64)) {
        self.preferences.remember(&path);
        self.notify(Severity::Info, format!("Saved {}", path.display()));
        // Where another project has taken its place, its file is not this one's.
        if project != self.project {
            return;
        }
        if self.file.path.as_deref() != Some(&path) {
            self.file.lock = store::Lock::acquire(&path).ok();
        }
        self.document.mark_saved(revision);
        self.autosave_clock.wrote(revision);
        self.file.path = Some(path);
        self.file.stamp = Some(stamp);
        if !self.document.is_dirty() {
            self.discard_autosave();
        }
        if let Some(next) = self.after_save.take() {
            self.go_on(next);
        }
    }

    fn not_saved(&mut self, project: u64, error: StoreError) {
        let is_own = project == self.project;
        if is_own {
            self.after_save = None;
        }
        match error {
            StoreError::ChangedOnDisk { path } if is_own => {
                self.question = Some(Question::ChangedOnDisk(path));
            }
            error => self.notify(Severity::Error, error.to_string()),
        }
    }

    /// Reads the project in `path`.
    pub(super) fn read_project(&mut self, path: PathBuf) {
        let work = move |_: &Context<Outcome>| {
            let (decoded, stamp) = store::open(&path).map_err(JobError::failed)?;
            Ok(Outcome::Opened(path, Box::new(decoded), stamp))
        };
        let topic = topic("open", 0);
        self.jobs
            .submit(Request::new("Opening", topic, Priority::Interactive, work));
    }

    /// Reads what a crash left behind in `folder`.
    pub(super) fn recover(&mut self, folder: &Path) {
        let Some(left) = self.recoverable.iter().find(|left| left.folder == folder) else {
            return;
        };
        let (recovery, left) = (self.recovery.clone(), left.clone());
        let work = move |_: &Context<Outcome>| {
            let decoded = recovery.open(&left).map_err(JobError::failed)?;
            Ok(Outcome::Recovered(left, Box::new(decoded)))
        };
        let topic = topic("open", 0);
        self.jobs.submit(Request::new(
            "Recovering",
            topic,
            Priority::Interactive,
            work,
        ));
    }

    /// Makes the project of the trees that come with the studio.
    pub(super) fn make_sample(&mut self) {
        let work = |context: &Context<Outcome>| Ok(Outcome::Sample(Box::new(sample(context)?)));
        let topic = topic("open", 0);
        let name = "Opening the sample";
        self.jobs
            .submit(Request::new(name, topic, Priority::Interactive, work));
    }

    /// Writes the project to `path`.
    pub(super) fn write_project(&mut self, path: PathBuf, over: Over) {
        let (snapshot, project) = (self.document.snapshot(), self.project);
        let work = move |context: &Context<Outcome>| {
            let revision = snapshot.revision();
            match store::save(&path, &snapshot, over, context.cancel()) {
                Ok(stamp) => Ok(Outcome::Saved(project, path, stamp, revision)),
                Err(StoreError::Cancelled(cancelled)) => Err(cancelled.into()),
                Err(error) => Ok(Outcome::NotSaved(project, error)),
            }
        };
        let topic = topic("save", 0);
        self.jobs
            .submit(Request::new("Saving", topic, Priority::Interactive, work));
    }

    /// Looks whether somebody else wrote the project's file.
    pub(super) fn look_at_file(&mut self) {
        let (Some(path), Some(stamp)) = (self.file.path.clone(), self.file.stamp) else {
            return;
        };
        let work = move |_: &Context<Outcome>| {
            let on_disk = store::on_disk(&path, stamp).map_err(JobError::failed)?;
            Ok(Outcome::Looked(path, on_disk))
        };
        let topic = topic("look at file", 0);
        self.jobs.submit(Request::new(
            "Looking at the file",
            topic,
            Priority::Preview,
            work,
        ));
    }

    /// The project is safe without it.
    pub(super) fn discard_autosave(&mut self) {
        let taken = self
            .autosave
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .take();
        if let Some(autosave) = taken
            && let Err(error) = autosave.discard()
        {
            self.notify(Severity::Warning, error.to_string());
        }
    }

    fn autosave_if_due(&mut self) {
        if self.autosave_due_in() == Some(Duration::ZERO) {
            let snapshot = self.document.snapshot();
            // Not again before the next change, even when this one fails: the user is told.
            self.autosave_clock.wrote(snapshot.revision());
            self.write_autosave(snapshot, None);
        }
    }

    /// How long until an autosave is due; nothing when all is safe, or the hand is down.
    pub(super) fn autosave_due_in(&mut self) -> Option<Duration> {
        if self.document.is_in_gesture() || !self.document.is_dirty() {
            return None;
        }
        let revision = self.document.revision();
        self.autosave_clock.due_in(revision, Instant::now())
    }

    /// Writes an autosave; then throws `replaced` away, which it stands for.
    fn write_autosave(&mut self, snapshot: Snapshot, replaced: Option<Recoverable>) {
        let (recovery, shared) = (self.recovery.clone(), Arc::clone(&self.autosave));
        let (file, project) = (self.file.path.clone(), self.project);
        let work = move |context: &Context<Outcome>| {
            let file = file.as_deref();
            autosaved(&shared, &recovery, &snapshot, file, context.cancel())
                .map_err(JobError::failed)?;
            if let Some(left) = &replaced {
                recovery.discard(left).map_err(JobError::failed)?;
                context.publish(Outcome::Discarded(left.folder.clone()));
            }
            Ok(Outcome::Autosaved(project, snapshot.revision()))
        };
        let topic = topic("autosave", 0);
        self.jobs
            .submit(Request::new("Autosave", topic, Priority::Preview, work));
    }

    /// Writes what no file holds to the autosaves, at once: the program is about to end.
    pub(super) fn rescue(&mut self) {
        if self.may_not_close() {
            let (snapshot, file) = (self.document.snapshot(), self.file.path.as_deref());
            // There is nobody left to tell: the autosave before it stays.
            let _ = autosaved(
                &self.autosave,
                &self.recovery,
                &snapshot,
                file,
                &Cancel::new(),
            );
        }
    }
}

/// Writes an autosave, the first one of a session into a new folder.
fn autosaved(
    shared: &SharedAutosave,
    recovery: &Recovery,
    snapshot: &Snapshot,
    file: Option<&Path>,
    cancel: &Cancel,
) -> Result<(), StoreError> {
    let mut autosave = shared.lock().unwrap_or_else(PoisonError::into_inner);
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let now = now.map_or(0, |since| since.as_secs());
    if autosave.is_none() {
        let session = format!("{now}-{}", std::process::id());
        *autosave = Some(recovery.begin(&session)?);
    }
    match autosave.as_mut() {
        Some(autosave) => autosave.write(snapshot, file, now, cancel),
        None => Ok(()),
    }
}

/// The trees that come with the studio, each with its crown and trunk labelled.
fn sample(context: &Context<Outcome>) -> Result<Document, JobError> {
    let starters: Vec<_> = crate::branches::samples::starters().collect();
    let trees: Result<Vec<_>, JobError> = starters
        .par_iter()
        .map(|sample| {
            context.cancel().check()?;
            let image = decoded(sample.bundled(), sample.name()).map_err(JobError::failed)?;
            let labels = standard().segment(&image, context.cancel());
            let labels = labels.map_err(JobError::failed)?;
            Ok((sample, Arc::new(TiledMask::from_labels(&labels))))
        })
        .collect();
    let mut document = Document::new();
    for (sample, mask) in trees? {
        let id = PhotoId(document.state().content().next_photo);
        let size = (mask.width(), mask.height());
        let photo = NewPhoto::new(sample.name(), sample.bundled().into(), size);
        for edit in [Edit::AddPhotos(vec![photo]), Edit::SetMask(id, mask)] {
            document.apply("Sample", edit).map_err(JobError::failed)?;
        }
    }
    document.forget_history();
    document.mark_saved(document.snapshot().revision());
    Ok(document)
}
