//! The queue, its threads, and the messages they send.

use super::board::{JobView, Phase};
use super::context::{Context, JobError};
use crate::base::{Cancel, Cancelled, Update, return_free_memory, without_panics};
use std::collections::BTreeMap;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// A job's number: never used twice, larger for later jobs. It is also its generation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct JobId(pub u64);

/// What a job is about; of one topic only the newest job counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Topic {
    /// The kind of work.
    pub kind: &'static str,
    /// What it is done for: the number of a photo, say.
    pub item: u64,
}

/// Which jobs go first; of equals the one that came first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Priority {
    /// The user's hand waits for it: never waits for jobs of the other kinds.
    Interactive,
    /// The user sees it when ready: thumbnails, refinements.
    Preview,
    /// Batches and exports. Leaves one thread to the others where there are several.
    Background,
}

type Work<T> = Box<dyn FnOnce(&Context<T>) -> Result<T, JobError> + Send>;

/// A job that is to be done.
pub struct Request<T> {
    /// What the user sees as its name.
    pub name: String,
    /// What it is about.
    pub topic: Topic,
    /// Its place in the queue.
    pub priority: Priority,
    /// The work itself, on a snapshot that it owns.
    pub work: Work<T>,
}

impl<T> Request<T> {
    /// A job named for the user.
    pub fn new(
        name: impl Into<String>,
        topic: Topic,
        priority: Priority,
        work: impl FnOnce(&Context<T>) -> Result<T, JobError> + Send + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            topic,
            priority,
            work: Box::new(work),
        }
    }
}

/// Something that a job tells.
#[derive(Debug, PartialEq)]
pub struct Message<T> {
    /// The job.
    pub id: JobId,
    /// What it is about.
    pub topic: Topic,
    /// What it tells.
    pub report: Report<T>,
}

/// What a job tells.
#[derive(Debug, PartialEq)]
pub enum Report<T> {
    /// A first or partial result; more follows.
    Partial(T),
    /// The result, or why there is none; nothing follows. Every job that was submitted tells this
    /// once, also when it was cancelled or superseded (then as [`JobError::Cancelled`]).
    Ended(Result<T, JobError>),
}

/// A job between its submission and its end.
struct Entry<T> {
    view: JobView,
    cancel: Cancel,
    is_paused: bool,
    /// `None` once a thread has it.
    work: Option<Work<T>>,
    /// Whether its thread stands still in a pause and leaves its place to another.
    is_standing: bool,
}

impl<T> Entry<T> {
    fn is_running(&self) -> bool {
        self.work.is_none() && !self.is_standing
    }
}

struct State<T> {
    /// In the order of submission.
    jobs: BTreeMap<JobId, Entry<T>>,
    /// The newest job of each topic there ever was.
    newest: BTreeMap<Topic, JobId>,
    next_id: u64,
    threads: usize,
    is_all_paused: bool,
    is_closed: bool,
}

/// What threads and owner share.
pub(super) struct Shared<T> {
    state: Mutex<State<T>>,
    /// Told when a pause may be over, and when a thread ends.
    changed: Condvar,
    messages: Sender<Message<T>>,
    waker: Box<dyn Fn() + Send + Sync>,
    limit: usize,
}

/// The owner's end of the queue. Dropping it asks all jobs to stop and does not wait for them.
pub struct Jobs<T> {
    shared: Arc<Shared<T>>,
    messages: Receiver<Message<T>>,
}

impl<T: Send + 'static> Jobs<T> {
    /// A queue that runs up to `threads` jobs at once, and as many interactive ones beside them.
    /// `waker` is called after each message, from any thread; it must be quick.
    pub fn new(threads: usize, waker: impl Fn() + Send + Sync + 'static) -> Self {
        let (sender, messages) = channel();
        let state = State {
            jobs: BTreeMap::new(),
            newest: BTreeMap::new(),
            next_id: 1,
            threads: 0,
            is_all_paused: false,
            is_closed: false,
        };
        let shared = Shared {
            state: Mutex::new(state),
            changed: Condvar::new(),
            messages: sender,
            waker: Box::new(waker),
            limit: threads.max(1),
        };
        Self {
            shared: Arc::new(shared),
            messages,
        }
    }

    /// Adds a job; older ones of its topic are superseded.
    pub fn submit(&self, request: Request<T>) -> JobId {
        let mut state = self.shared.lock();
        let id = JobId(state.next_id);
        state.next_id += 1;
        let superseded = state.newest.insert(request.topic, id);
        let entry = Entry {
            view: JobView {
                id,
                name: request.name,
                topic: request.topic,
                priority: request.priority,
                phase: Phase::Queued,
                stage: None,
                done: 0,
                total: 0,
                warnings: Vec::new(),
            },
            cancel: Cancel::new(),
            is_paused: false,
            work: Some(request.work),
            is_standing: false,
        };
        state.jobs.insert(id, entry);
        drop(state);
        if let Some(older) = superseded {
            self.cancel(older);
        }
        Shared::start_threads(&self.shared);
        id
    }

    /// Asks a job to stop. One that waits ends at once; one that is done already is left alone.
    pub fn cancel(&self, id: JobId) {
        let mut state = self.shared.lock();
        let Some(entry) = state.jobs.get_mut(&id) else {
            return;
        };
        entry.cancel.cancel();
        // Someone else's code is dropped without the lock.
        let waiting = entry.work.take();
        let topic = entry.view.topic;
        if waiting.is_some() {
            state.jobs.remove(&id);
        }
        drop(state);
        self.shared.changed.notify_all();
        if waiting.is_some() {
            self.shared.send(Message {
                id,
                topic,
                report: Report::Ended(Err(JobError::Cancelled(Cancelled))),
            });
        }
    }

    /// Asks all jobs to stop.
    pub fn cancel_all(&self) {
        let ids: Vec<JobId> = self.shared.lock().jobs.keys().copied().collect();
        ids.into_iter().for_each(|id| self.cancel(id));
    }

    /// Pauses a job or lets it go on. A paused job that waits is not begun; one that runs stands
    /// still at its next look and gives its place to another.
    pub fn set_paused(&self, id: JobId, is_paused: bool) {
        if let Some(entry) = self.shared.lock().jobs.get_mut(&id) {
            entry.is_paused = is_paused;
        }
        self.shared.changed.notify_all();
        Shared::start_threads(&self.shared);
    }

    /// Pauses all jobs but the interactive ones, those to come included, or lets them go on.
    pub fn set_all_paused(&self, is_paused: bool) {
        self.shared.lock().is_all_paused = is_paused;
        self.shared.changed.notify_all();
        Shared::start_threads(&self.shared);
    }

    /// The next message, if there is one; never waits.
    pub fn poll(&self) -> Option<Message<T>> {
        while let Ok(message) = self.messages.try_recv() {
            if let Some(fresh) = self.fresh(message) {
                return Some(fresh);
            }
        }
        None
    }

    /// The next message within `patience`: for tests and for work without a window.
    pub fn wait(&self, patience: Duration) -> Option<Message<T>> {
        let until = Instant::now() + patience;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            let message = self.messages.recv_timeout(left).ok()?;
            if let Some(fresh) = self.fresh(message) {
                return Some(fresh);
            }
        }
    }

    /// `message` without a result that was superseded while it lay in the channel.
    fn fresh(&self, message: Message<T>) -> Option<Message<T>> {
        let newest = self.shared.lock().newest.get(&message.topic).copied();
        let is_stale = newest.is_some_and(|newest| newest > message.id);
        match message.report {
            Report::Partial(_) if is_stale => None,
            Report::Ended(Ok(_)) if is_stale => Some(Message {
                report: Report::Ended(Err(JobError::Cancelled(Cancelled))),
                ..message
            }),
            _ => Some(message),
        }
    }

    /// All unfinished jobs, in the order of their submission.
    pub fn snapshot(&self) -> Vec<JobView> {
        let state = self.shared.lock();
        let view = |entry: &Entry<T>| {
            let mut view = entry.view.clone();
            view.phase = state.phase(entry);
            view
        };
        state.jobs.values().map(view).collect()
    }

    /// Whether nothing waits or runs.
    pub fn is_idle(&self) -> bool {
        self.shared.lock().jobs.is_empty()
    }

    /// Stops all jobs and waits up to `patience` for them; whether all have stopped. Jobs that are
    /// submitted afterwards end at once.
    pub fn shut_down(&self, patience: Duration) -> bool {
        self.shared.lock().is_closed = true;
        self.cancel_all();
        let until = Instant::now() + patience;
        let mut state = self.shared.lock();
        while state.threads > 0 {
            let left = until.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            let waited = self.shared.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
        true
    }
}

impl<T> Drop for Jobs<T> {
    fn drop(&mut self) {
        let mut state = self.shared.lock();
        state.is_closed = true;
        let waiting: Vec<_> = state
            .jobs
            .values_mut()
            .filter_map(|entry| {
                entry.cancel.cancel();
                entry.work.take()
            })
            .collect();
        drop(state);
        drop(waiting);
        self.shared.changed.notify_all();
    }
}

impl<T> State<T> {
    fn must_pause(&self, entry: &Entry<T>) -> bool {
        let all = self.is_all_paused && entry.view.priority != Priority::Interactive;
        (entry.is_paused || all) && !entry.cancel.is_cancelled()
    }

    fn phase(&self, entry: &Entry<T>) -> Phase {
        if entry.cancel.is_cancelled() {
            Phase::Stopping
        } else if self.must_pause(entry) {
            Phase::Paused
        } else if entry.work.is_some() {
            Phase::Queued
        } else {
            Phase::Running
        }
    }

    /// The job that a free thread should take.
    fn next(&self, limit: usize) -> Option<JobId> {
        let running = |wanted: &dyn Fn(Priority) -> bool| {
            let jobs = self.jobs.values().filter(|entry| entry.is_running());
            jobs.filter(|entry| wanted(entry.view.priority)).count()
        };
        let interactive = running(&|priority| priority == Priority::Interactive);
        let others = running(&|priority| priority != Priority::Interactive);
        let has_place = |priority| match priority {
            Priority::Interactive => interactive < limit,
            Priority::Preview => others < limit,
            Priority::Background => others < (limit - 1).max(1),
        };
        let ready = self.jobs.values().filter(|entry| {
            entry.work.is_some() && !self.must_pause(entry) && has_place(entry.view.priority)
        });
        let first = ready.min_by_key(|entry| (entry.view.priority, entry.view.id))?;
        Some(first.view.id)
    }
}

impl<T> Shared<T> {
    /// The state, also after a panic of ours: it is never left half-changed across a call.
    fn lock(&self) -> MutexGuard<'_, State<T>> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn send(&self, message: Message<T>) {
        // Nobody listens any more: then nobody misses it.
        let _ = self.messages.send(message);
        (self.waker)();
    }

    /// Sends a partial result, unless the job is to stop.
    pub(super) fn publish(&self, id: JobId, result: T) {
        let topic = {
            let state = self.lock();
            let current = state.jobs.get(&id).filter(|job| !job.cancel.is_cancelled());
            match current {
                Some(entry) => entry.view.topic,
                None => return,
            }
        };
        self.send(Message {
            id,
            topic,
            report: Report::Partial(result),
        });
    }

    pub(super) fn report(&self, id: JobId, update: Update<'_>) {
        if let Some(entry) = self.lock().jobs.get_mut(&id) {
            entry.view.take(update);
        }
    }
}

impl<T: Send + 'static> Shared<T> {
    /// Starts a thread for each job that may begin now.
    fn start_threads(shared: &Arc<Self>) {
        loop {
            let mut state = shared.lock();
            let Some((id, work, cancel)) = state.begin(shared.limit) else {
                return;
            };
            state.threads += 1;
            drop(state);
            let own = Arc::clone(shared);
            let body = move || Self::run_jobs(&own, id, work, cancel);
            let started = thread::Builder::new()
                .name("boscage job".to_owned())
                .spawn(body);
            if let Err(error) = started {
                let reason = format!("no thread can be had: {error}");
                shared.lock().threads -= 1;
                shared.end(id, Err(JobError::Failed(reason)));
            }
        }
    }

    /// A thread: the given job, then others as long as there are any.
    fn run_jobs(shared: &Arc<Self>, id: JobId, work: Work<T>, cancel: Cancel) {
        let mut next = Some((id, work, cancel));
        let mut is_last = false;
        while let Some((id, work, cancel)) = next {
            let context = Context::new(Arc::clone(shared), id, cancel);
            let result = without_panics(|| {
                // Not begun at all when it was cancelled between the queue and here.
                context.cancel.check()?;
                work(&context)
            });
            let result =
                result.unwrap_or_else(|panicked| Err(JobError::Panicked(panicked.message)));
            shared.end(id, result);
            let mut state = shared.lock();
            next = state.begin(shared.limit);
            if next.is_none() {
                // Counted off under the same lock: a job that comes now finds no thread to wait for.
                state.threads -= 1;
                is_last = state.threads == 0;
            }
        }
        shared.changed.notify_all();
        if is_last {
            // Nothing is to be done: what the work needed lies about in as many heaps as there were threads.
            return_free_memory();
        }
    }

    fn end(&self, id: JobId, result: Result<T, JobError>) {
        let mut state = self.lock();
        let Some(entry) = state.jobs.get(&id) else {
            return;
        };
        let topic = entry.view.topic;
        // What a superseded job brings is stale, though it brings it whole.
        let result = entry.cancel.check().map_err(JobError::from).and(result);
        state.jobs.remove(&id);
        drop(state);
        self.send(Message {
            id,
            topic,
            report: Report::Ended(result),
        });
    }

    /// Stands still while job `id` is paused.
    pub(super) fn wait_while_paused(self: &Arc<Self>, id: JobId, cancel: &Cancel) {
        let mut state = self.lock();
        let must_pause = |state: &State<T>| {
            !cancel.is_cancelled() && state.jobs.get(&id).is_some_and(|job| state.must_pause(job))
        };
        if !must_pause(&state) {
            return;
        }
        let set_standing = |state: &mut State<T>, is_standing| {
            if let Some(entry) = state.jobs.get_mut(&id) {
                entry.is_standing = is_standing;
            }
        };
        set_standing(&mut state, true);
        drop(state);
        Self::start_threads(self);
        let mut state = self.lock();
        while must_pause(&state) {
            let waited = self.changed.wait(state);
            state = waited.unwrap_or_else(PoisonError::into_inner);
        }
        // For a while there may be one more running than the limit: better than to wait again.
        set_standing(&mut state, false);
    }
}

impl<T> State<T> {
    /// Takes the next job out of the queue.
    fn begin(&mut self, limit: usize) -> Option<(JobId, Work<T>, Cancel)> {
        let id = self.next(limit)?;
        let entry = self.jobs.get_mut(&id)?;
        let work = entry.work.take()?;
        if self.is_closed {
            entry.cancel.cancel();
        }
        Some((id, work, entry.cancel.clone()))
    }
}

#[cfg(test)]
mod tests;
