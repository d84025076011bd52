//! Seconds for each stage, for the JSON that commands print.
//!
//! Algorithms read no clock; this reporter sits between them and the one that shows progress and
//! looks at the clock when a stage begins and ends.

use crate::base::{Reporter, Update};
use serde::{Serialize, Serializer};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Passes updates on to another reporter and adds up the time spent in each stage.
pub(super) struct StageClock<'a> {
    next: &'a dyn Reporter,
    spans: Mutex<Vec<Span>>,
}

struct Span {
    stage: &'static str,
    /// How many stages of this name are open now, on all threads.
    open: usize,
    since: Instant,
    total: Duration,
}

impl Span {
    fn duration(&self) -> Duration {
        match self.open {
            0 => self.total,
            _ => self.total + self.since.elapsed(),
        }
    }
}

impl<'a> StageClock<'a> {
    /// A clock in front of `next`.
    pub(super) fn new(next: &'a dyn Reporter) -> Self {
        Self {
            next,
            spans: Mutex::new(Vec::new()),
        }
    }

    /// Seconds for each stage so far, in the order in which they first began. Wall time: stages of
    /// one name that are open on several threads at once count once.
    pub(super) fn seconds(&self) -> Seconds {
        let spans = self.spans.lock().unwrap_or_else(PoisonError::into_inner);
        let seconds = spans
            .iter()
            .map(|span| (span.stage, span.duration().as_secs_f64()));
        Seconds(seconds.collect())
    }

    fn begin(&self, stage: &'static str) {
        let mut spans = self.spans.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        if let Some(span) = spans.iter_mut().find(|span| span.stage == stage) {
            if span.open == 0 {
                span.since = now;
            }
            span.open += 1;
        } else {
            spans.push(Span {
                stage,
                open: 1,
                since: now,
                total: Duration::ZERO,
            });
        }
    }

    fn end(&self, stage: &'static str) {
        let mut spans = self.spans.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(span) = spans.iter_mut().find(|span| span.stage == stage) {
            span.open = span.open.saturating_sub(1);
            if span.open == 0 {
                span.total += span.since.elapsed();
            }
        }
    }
}

impl Reporter for StageClock<'_> {
    fn report(&self, update: Update<'_>) {
        match update {
            Update::Began { stage, .. } => self.begin(stage),
            Update::Ended { stage } => self.end(stage),
            Update::Advanced { .. } | Update::Warning { .. } => {}
        }
        self.next.report(update);
    }
}

/// Stage names and seconds; in JSON an object in this order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Seconds(Vec<(&'static str, f64)>);

impl Serialize for Seconds {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().copied())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Progress;

    struct Nobody;

    impl Reporter for Nobody {
        fn report(&self, _: Update<'_>) {}
    }

    #[test]
    fn stages_of_one_name_are_added_and_not_counted_twice() {
        let clock = StageClock::new(&Nobody);
        let progress = Progress::to(&clock);
        let outer = progress.stage("warp", 1);
        let inner = progress.stage("warp", 1);
        std::thread::sleep(Duration::from_millis(20));
        drop((outer, inner));
        drop(progress.stage("write", 1));
        let Seconds(seconds) = clock.seconds();
        assert_eq!(seconds.len(), 2);
        assert_eq!((seconds[0].0, seconds[1].0), ("warp", "write"));
        assert!(seconds[0].1 >= 0.02 && seconds[0].1 < 2.0);
    }
}
