//! What a job holds while it runs.

use super::queue::{JobId, Shared};
use crate::base::{Cancel, Cancelled, Progress, Reporter, Update};
use std::sync::Arc;
use std::thread::{self, ThreadId};

/// Why a job gave no result.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum JobError {
    /// It was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// It could not do its work; one line for the user.
    #[error("{0}")]
    Failed(String),
    /// It panicked, which is our bug; the other jobs go on.
    #[error("internal failure: {0}")]
    Panicked(String),
}

impl JobError {
    /// A failure for the user to read.
    pub fn failed(reason: impl std::fmt::Display) -> Self {
        Self::Failed(reason.to_string())
    }
}

/// A running job's ties to those who started it.
pub struct Context<T> {
    pub(super) shared: Arc<Shared<T>>,
    pub(super) id: JobId,
    pub(super) cancel: Cancel,
    /// The thread that the job was given; only there may it pause.
    thread: ThreadId,
}

impl<T: Send + 'static> Context<T> {
    pub(super) fn new(shared: Arc<Shared<T>>, id: JobId, cancel: Cancel) -> Self {
        Self {
            shared,
            id,
            cancel,
            thread: thread::current().id(),
        }
    }

    /// The job's number.
    pub fn id(&self) -> JobId {
        self.id
    }

    /// The flag to hand to algorithms.
    pub fn cancel(&self) -> &Cancel {
        &self.cancel
    }

    /// Progress to hand to algorithms.
    ///
    /// While the job is paused, a step of progress that its own thread tells does not return; what
    /// other threads tell does, for they may belong to everybody.
    pub fn progress(&self) -> Progress<'_> {
        Progress::to(self)
    }

    /// Waits while the job is paused.
    ///
    /// # Errors
    /// [`Cancelled`] once the job is to stop.
    pub fn check(&self) -> Result<(), Cancelled> {
        self.shared.wait_while_paused(self.id, &self.cancel);
        self.cancel.check()
    }

    /// Sends a first or partial result; more may follow. One of a superseded job does not arrive.
    pub fn publish(&self, result: T) {
        self.shared.publish(self.id, result);
    }
}

impl<T: Send + 'static> Reporter for Context<T> {
    fn report(&self, update: Update<'_>) {
        self.shared.report(self.id, update);
        if thread::current().id() == self.thread {
            self.shared.wait_while_paused(self.id, &self.cancel);
        }
    }
}
