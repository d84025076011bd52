//! What can be shown of a job while it waits and runs.

use super::queue::{JobId, Priority, Topic};
use crate::base::Update;

/// Warnings that are kept of a job; a batch over broken files would fill the memory.
const MOST_WARNINGS: usize = 100;

/// What a job is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Waits for a thread.
    Queued,
    /// Runs.
    Running,
    /// Was asked to pause; stops at its next look at [`super::Context::check`] or step of progress.
    Paused,
    /// Was asked to stop and has not yet.
    Stopping,
}

/// A job as it stood at one moment.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JobView {
    /// Its number.
    pub id: JobId,
    /// What the user sees as its name.
    pub name: String,
    /// What it is about.
    pub topic: Topic,
    /// Its place in the queue.
    pub priority: Priority,
    /// What it is doing.
    pub phase: Phase,
    /// The step it is in, `None` before the first.
    pub stage: Option<&'static str>,
    /// Items of the step that are ready.
    pub done: u64,
    /// Items of the step in all, 0 when not known.
    pub total: u64,
    /// What the user should know.
    pub warnings: Vec<String>,
}

impl JobView {
    /// The share of the present step that is ready, `None` when it is not known.
    pub fn fraction(&self) -> Option<f64> {
        (self.total > 0).then(|| (self.done as f64 / self.total as f64).min(1.0))
    }

    pub(super) fn take(&mut self, update: Update<'_>) {
        match update {
            Update::Began { stage, total } => {
                (self.stage, self.done, self.total) = (Some(stage), 0, total);
            }
            Update::Advanced { stage, done, total } => {
                // Told by several threads: an older number may come after a newer.
                let is_older = self.stage == Some(stage) && done < self.done;
                if !is_older {
                    (self.stage, self.done, self.total) = (Some(stage), done, total);
                }
            }
            Update::Ended { .. } => {}
            Update::Warning { message } => {
                if self.warnings.len() < MOST_WARNINGS {
                    self.warnings.push(message.to_owned());
                }
            }
        }
    }
}
