//! The project itself: a state, its history, and what was last saved.

use super::content::{PhotoId, State};
use super::edit::{Edit, EditError, edited};
use super::format::Section;
use super::history::{Changed, Step, digests};
use super::settings::ViewState;
use crate::base::Digest;
use crate::paint::Side;
use std::collections::{BTreeMap, VecDeque};
use std::sync::Arc;

/// Most bytes of the history, photographs that only it needs included. A long stroke over a
/// photograph of 8192² takes some hundred thousand.
const HISTORY_BYTES: usize = 180 << 20;

/// A state's number: two states with the same one are equal.
type Revision = u64;

/// A project that is being worked on.
#[derive(Debug, Clone)]
pub struct Document {
    state: State,
    blobs: BTreeMap<Digest, Arc<[u8]>>,
    view: ViewState,
    undo: VecDeque<Done>,
    redo: Vec<Done>,
    open: Option<Open>,
    revision: Revision,
    next_revision: Revision,
    saved: Option<Revision>,
    history_bytes: usize,
    /// Sections of the file that a newer version wrote and that may be kept.
    unknown: Vec<Section>,
}

/// A step and the revisions on its two sides.
#[derive(Debug, Clone)]
struct Done {
    step: Arc<Step>,
    before: Revision,
    after: Revision,
}

/// A gesture in progress.
#[derive(Debug, Clone)]
struct Open {
    label: String,
    before: State,
}

/// All that a save needs: cheap to take, and independent of what is done next.
#[derive(Debug, Clone)]
pub struct Snapshot {
    pub(super) state: State,
    pub(super) blobs: BTreeMap<Digest, Arc<[u8]>>,
    pub(super) view: ViewState,
    /// Steps to undo, the last one last.
    pub(super) undo: Vec<Arc<Step>>,
    /// Steps to redo, the next one last.
    pub(super) redo: Vec<Arc<Step>>,
    pub(super) unknown: Vec<Section>,
    revision: Revision,
}

impl Snapshot {
    /// A state without history.
    pub(super) fn new(state: State, blobs: BTreeMap<Digest, Arc<[u8]>>) -> Self {
        Self {
            state,
            blobs,
            view: ViewState::default(),
            undo: Vec::new(),
            redo: Vec::new(),
            unknown: Vec::new(),
            revision: 0,
        }
    }

    pub(super) fn with_view(self, view: ViewState) -> Self {
        Self { view, ..self }
    }

    pub(super) fn with_history(self, undo: Vec<Arc<Step>>, redo: Vec<Arc<Step>>) -> Self {
        Self { undo, redo, ..self }
    }

    pub(super) fn with_unknown(self, unknown: Vec<Section>) -> Self {
        Self { unknown, ..self }
    }

    /// What to give to [`Document::mark_saved`] when the snapshot is safely on disk.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The title of the project.
    pub fn title(&self) -> &str {
        &self.state.content.title
    }

    /// The photographs by the digest of their bytes.
    pub fn photos(&self) -> &BTreeMap<Digest, Arc<[u8]>> {
        &self.blobs
    }
}

impl Default for Document {
    fn default() -> Self {
        Self::new()
    }
}

impl Document {
    /// An empty project that needs no saving.
    pub fn new() -> Self {
        Self {
            state: State::default(),
            blobs: BTreeMap::new(),
            view: ViewState::default(),
            undo: VecDeque::new(),
            redo: Vec::new(),
            open: None,
            revision: 0,
            next_revision: 1,
            saved: Some(0),
            history_bytes: 0,
            unknown: Vec::new(),
        }
    }

    /// A project from a file. The history is dropped when it does not fit; whether it was kept.
    pub(super) fn restored(snapshot: Snapshot) -> (Self, bool) {
        let mut document = Self {
            state: snapshot.state,
            blobs: snapshot.blobs,
            view: snapshot.view,
            unknown: snapshot.unknown,
            ..Self::new()
        };
        let fits = document.fits(&snapshot.undo, Side::Before)
            && document.fits(&snapshot.redo, Side::After);
        if fits {
            // Revisions count up through both lists; the present one lies between them.
            let present = snapshot.undo.len() as Revision;
            let undo = snapshot.undo.into_iter().zip(0..);
            document.undo = undo
                .map(|(step, before)| Done::from(step, before))
                .collect();
            let redo = snapshot.redo.into_iter().rev().zip(present..);
            document.redo = redo
                .map(|(step, before)| Done::from(step, before))
                .collect();
            document.redo.reverse();
            document.revision = present;
            document.next_revision = present + document.redo.len() as Revision + 1;
        }
        document.saved = Some(document.revision);
        document.trim();
        (document, fits)
    }

    /// Whether all of `steps`, the last first, lead to valid states with photographs that are there.
    fn fits(&self, steps: &[Arc<Step>], side: Side) -> bool {
        let mut state = self.state.clone();
        steps.iter().rev().all(|step| {
            step.apply(&mut state, side).is_ok()
                && state.complaint().is_none()
                && digests(&state)
                    .iter()
                    .all(|digest| self.blobs.contains_key(digest))
        })
    }

    /// The present state, gestures in progress included.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The bytes of a photograph's file.
    pub fn photo_bytes(&self, photo: PhotoId) -> Option<&Arc<[u8]>> {
        self.blobs
            .get(&self.state.content.photos.get(&photo)?.digest)
    }

    /// How the project is looked at.
    pub fn view(&self) -> &ViewState {
        &self.view
    }

    /// How the project is looked at, to be changed: no edit.
    pub fn view_mut(&mut self) -> &mut ViewState {
        &mut self.view
    }

    /// Begins a gesture: all edits until [`Document::commit`] become one step. One that is still
    /// open, because its end was missed, is committed first.
    pub fn begin(&mut self, label: impl Into<String>) {
        self.commit();
        self.open = Some(Open {
            label: label.into(),
            before: self.state.clone(),
        });
    }

    /// Makes an edit: within the open gesture, or as a step of its own called `label` otherwise.
    /// Whether anything is different.
    ///
    /// # Errors
    /// [`EditError`]; nothing has changed.
    pub fn apply(&mut self, label: &str, edit: Edit) -> Result<bool, EditError> {
        let (new, blobs) = edited(&self.state, edit)?;
        let alone = self.open.is_none();
        if alone {
            self.begin(label);
        }
        let is_different = new != self.state;
        if is_different {
            self.state = new;
            self.blobs.extend(blobs);
        }
        if alone {
            self.commit();
        }
        Ok(is_different)
    }

    /// Ends the open gesture; whether there is a new step. A gesture that changed nothing in the end
    /// leaves none, and what could be redone stays.
    pub fn commit(&mut self) -> bool {
        let Some(open) = self.open.take() else {
            return false;
        };
        let Some(step) = Step::between(&open.label, &open.before, &self.state) else {
            self.state = open.before;
            return false;
        };
        let before = self.revision;
        self.revision = self.next_revision;
        self.next_revision += 1;
        let step = Arc::new(step);
        self.undo.push_back(Done {
            step,
            before,
            after: self.revision,
        });
        self.redo.clear();
        self.trim();
        true
    }

    /// Gives the open gesture up: the state is as it was when it began. Whether there was one.
    pub fn abort(&mut self) -> bool {
        let Some(open) = self.open.take() else {
            return false;
        };
        self.state = open.before;
        self.trim();
        true
    }

    /// Drops all steps: what was done so far is how the project begins.
    pub fn forget_history(&mut self) {
        self.commit();
        self.undo.clear();
        self.redo.clear();
        self.trim();
    }

    /// Whether a gesture is open.
    pub fn is_in_gesture(&self) -> bool {
        self.open.is_some()
    }

    /// Takes back the last step, or the open gesture; what changed, `None` when there is nothing to
    /// take back.
    pub fn undo(&mut self) -> Option<Changed> {
        if let Some(open) = &self.open {
            let step = Step::between("", &open.before, &self.state);
            let mut scratch = self.state.clone();
            let changed = step.and_then(|step| step.apply(&mut scratch, Side::Before).ok());
            self.abort();
            return Some(changed.unwrap_or_default());
        }
        let done = self.undo.pop_back()?;
        let changed = done.step.apply(&mut self.state, Side::Before);
        self.revision = done.before;
        self.redo.push(done);
        Some(changed.expect("a step leads back to where it came from"))
    }

    /// Makes the step again that was taken back last; what changed. Nothing during a gesture.
    pub fn redo(&mut self) -> Option<Changed> {
        if self.open.is_some() {
            return None;
        }
        let done = self.redo.pop()?;
        let changed = done.step.apply(&mut self.state, Side::After);
        self.revision = done.after;
        self.undo.push_back(done);
        Some(changed.expect("a step leads again to where it led"))
    }

    /// What would be undone, as the menu calls it.
    pub fn undo_label(&self) -> Option<&str> {
        let last = self.undo.back().map(|done| done.step.label.as_str());
        self.open.as_ref().map(|open| open.label.as_str()).or(last)
    }

    /// What would be redone, as the menu calls it.
    pub fn redo_label(&self) -> Option<&str> {
        self.redo.last().map(|done| done.step.label.as_str())
    }

    /// Steps that can be undone and redone.
    pub fn history_steps(&self) -> (usize, usize) {
        (self.undo.len(), self.redo.len())
    }

    /// Bytes of the history, photographs that only it needs included.
    pub fn history_bytes(&self) -> usize {
        self.history_bytes
    }

    /// The number of what a snapshot taken now holds: see [`Document::mark_saved`].
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// Whether there is something to lose. Undoing to what was saved makes it clean again.
    pub fn is_dirty(&self) -> bool {
        let in_gesture = self
            .open
            .as_ref()
            .is_some_and(|open| open.before != self.state);
        in_gesture || self.saved != Some(self.revision)
    }

    /// Remembers that a snapshot is safely on disk. A save that failed or was cancelled says nothing
    /// and leaves the project dirty; edits made meanwhile do too.
    pub fn mark_saved(&mut self, revision: u64) {
        self.saved = Some(revision);
    }

    /// Remembers that no file holds the project: it was recovered, or its file is gone.
    pub fn mark_unsaved(&mut self) {
        self.saved = None;
    }

    /// The project as it is, or as it was before the open gesture.
    pub fn snapshot(&self) -> Snapshot {
        let state = self.open.as_ref().map_or(&self.state, |open| &open.before);
        let needed = digests(state);
        let blobs = self
            .blobs
            .iter()
            .filter(|(digest, _)| needed.contains(digest));
        let steps = |done: &Done| Arc::clone(&done.step);
        Snapshot {
            state: state.clone(),
            blobs: blobs
                .map(|(digest, bytes)| (*digest, Arc::clone(bytes)))
                .collect(),
            view: self.view.clone(),
            undo: self.undo.iter().map(steps).collect(),
            redo: self.redo.iter().map(steps).collect(),
            unknown: self.unknown.clone(),
            revision: self.revision,
        }
    }

    /// The digest of the present state.
    pub fn digest(&self) -> Digest {
        self.state.digest()
    }

    /// What is wrong, if anything: for tests to sweep after every edit.
    pub fn complaint(&self) -> Option<String> {
        let missing = digests(&self.state);
        let missing = missing
            .iter()
            .find(|digest| !self.blobs.contains_key(digest));
        missing
            .map(|digest| format!("the bytes {digest} are missing"))
            .or_else(|| self.state.complaint())
    }

    /// Drops the oldest steps beyond the limit, and photographs that nothing needs any more.
    fn trim(&mut self) {
        loop {
            self.drop_unneeded_blobs();
            let own = digests(&self.state);
            let steps = self.undo.iter().chain(&self.redo);
            let steps: usize = steps.map(|done| done.step.memory_bytes()).sum();
            let photos = self
                .blobs
                .iter()
                .filter(|(digest, _)| !own.contains(digest));
            self.history_bytes = steps + photos.map(|(_, bytes)| bytes.len()).sum::<usize>();
            if self.history_bytes <= HISTORY_BYTES || self.undo.len() <= 1 {
                return;
            }
            self.undo.pop_front();
        }
    }

    fn drop_unneeded_blobs(&mut self) {
        let mut needed = digests(&self.state);
        if let Some(open) = &self.open {
            needed.extend(digests(&open.before));
        }
        for done in self.undo.iter().chain(&self.redo) {
            needed.extend(done.step.blobs());
        }
        self.blobs.retain(|digest, _| needed.contains(digest));
    }
}

impl Done {
    fn from(step: Arc<Step>, before: Revision) -> Self {
        Self {
            step,
            before,
            after: before + 1,
        }
    }
}

#[cfg(test)]
mod tests;
