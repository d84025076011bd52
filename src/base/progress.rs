//! Progress of long work, told to whoever wants to show it.
//!
//! An algorithm gets a [`Progress`], opens a [`Stage`] for each of its named steps and advances
//! it. It does not know whether a bar, a JSON line, a window or nobody listens, and it reads no
//! clock: a reporter that wants seconds takes them when a stage begins and ends.

use std::sync::atomic::{AtomicU64, Ordering};

/// What a [`Reporter`] is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Update<'a> {
    /// A named step begins; it will advance `total` times (0: not known).
    Began {
        /// Name of the step, stable: pipelines read it.
        stage: &'static str,
        /// Number of items in the step, 0 when not known.
        total: u64,
    },
    /// `done` of `total` items of the step are ready.
    Advanced {
        /// Name of the step.
        stage: &'static str,
        /// Items ready.
        done: u64,
        /// Items in all.
        total: u64,
    },
    /// The step is over.
    Ended {
        /// Name of the step.
        stage: &'static str,
    },
    /// Something the user should know, though the work goes on.
    Warning {
        /// One line, naming the file or the setting.
        message: &'a str,
    },
}

/// Somebody who shows progress. Called from any thread.
pub trait Reporter: Sync {
    /// Takes one update; must be quick.
    fn report(&self, update: Update<'_>);
}

/// The end of the line that algorithms hold: forwards to a [`Reporter`], or to nobody.
#[derive(Clone, Copy, Default)]
pub struct Progress<'a> {
    reporter: Option<&'a dyn Reporter>,
}

impl<'a> Progress<'a> {
    /// Progress that nobody listens to.
    pub const fn silent() -> Self {
        Self { reporter: None }
    }

    /// Progress that `reporter` is told of.
    pub const fn to(reporter: &'a dyn Reporter) -> Self {
        Self {
            reporter: Some(reporter),
        }
    }

    /// Begins the step `stage` of `total` items; it ends when the returned value is dropped.
    pub fn stage(&self, stage: &'static str, total: u64) -> Stage<'a> {
        self.tell(Update::Began { stage, total });
        Stage {
            progress: *self,
            stage,
            total,
            done: AtomicU64::new(0),
        }
    }

    /// Tells of something that is wrong but does not stop the work.
    pub fn warn(&self, message: &str) {
        self.tell(Update::Warning { message });
    }

    fn tell(&self, update: Update<'_>) {
        if let Some(reporter) = self.reporter {
            reporter.report(update);
        }
    }
}

/// One named step in progress. May be advanced from several threads.
pub struct Stage<'a> {
    progress: Progress<'a>,
    stage: &'static str,
    total: u64,
    done: AtomicU64,
}

impl Stage<'_> {
    /// One more item is ready.
    pub fn advance(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.progress.tell(Update::Advanced {
            stage: self.stage,
            done,
            total: self.total,
        });
    }
}

impl Drop for Stage<'_> {
    fn drop(&mut self) {
        self.progress.tell(Update::Ended { stage: self.stage });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    struct Log(Mutex<Vec<String>>);

    impl Reporter for Log {
        fn report(&self, update: Update<'_>) {
            self.0.lock().unwrap().push(format!("{update:?}"));
        }
    }

    #[test]
    fn a_stage_tells_its_beginning_every_item_and_its_end() {
        let log = Log(Mutex::new(Vec::new()));
        let progress = Progress::to(&log);
        let stage = progress.stage("warp", 2);
        stage.advance();
        stage.advance();
        drop(stage);
        let told = log.0.into_inner().unwrap();
        assert_eq!(told.len(), 4);
        assert!(told[0].starts_with("Began"));
        assert!(told[2].contains("done: 2"));
        assert!(told[3].starts_with("Ended"));
    }
}
