//! Work beside the window: worker threads, a queue with priorities, progress, pause, cancellation,
//! and results that come back through a channel.
//!
//! A job belongs to a *topic* ("the preview of photo 3"). A newer job of a topic supersedes the older
//! ones: those that wait are dropped, one that runs is asked to stop, and nothing that it still
//! publishes arrives. So a stale picture never replaces a fresh one, whatever order threads finish in.
//!
//! Threads exist only while there is work: each takes jobs until none is left and ends. A window that
//! does nothing therefore costs nothing. Whoever shows results gives a waker, which is called after
//! each message so that it can ask for a repaint; nobody ever waits for a job.
//!
//! Imports `base`.

mod board;
mod context;
mod queue;

pub use board::{JobView, Phase};
pub use context::{Context, JobError};
pub use queue::{JobId, Jobs, Message, Priority, Report, Request, Topic};
