//! Who shows progress: a bar, JSON lines, Open Job Description lines, or nobody.
//!
//! All of them print warnings on stderr. Items may be reported late by a slow thread: numbers that
//! go backwards are not shown.

use super::Stages;
use super::failure::Failure;
use super::options::ProgressStyle;
use crate::base::{Reporter, Update, brief_line};
use indicatif::{ProgressBar, ProgressStyle as BarStyle};
use serde_json::json;
use std::io::Write as _;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// A reporter that also hears how the command ended.
pub(super) trait FinishingReporter: Reporter + Send {
    /// The command is over, with `failure` or without; called once.
    fn finish(&self, failure: Option<&Failure>);
}

/// The reporter for `style`, which is no longer `Auto`.
pub(super) fn new(style: ProgressStyle, stages: Stages) -> Arc<dyn FinishingReporter> {
    match style {
        ProgressStyle::Bar => Arc::new(Bar::new()),
        ProgressStyle::Json => Arc::new(JsonLines::default()),
        ProgressStyle::Openjd => Arc::new(OpenJd::new(stages)),
        ProgressStyle::Auto | ProgressStyle::None => Arc::new(WarningsOnly),
    }
}

/// Prints the one line of a failed command.
pub(super) fn print_failure(failure: &Failure) {
    to_stderr(&format!("error: {failure}"));
}

/// One line, whole even when several threads print. A closed stderr stops nothing.
fn to_stderr(line: &str) {
    let _ = std::io::stderr().write_all(format!("{line}\n").as_bytes());
}

fn to_stdout(line: &str) {
    let mut stdout = std::io::stdout().lock();
    let _ = stdout.write_all(format!("{line}\n").as_bytes());
    let _ = stdout.flush();
}

fn warn(message: &str) {
    to_stderr(&format!("warning: {}", brief_line(message)));
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

struct WarningsOnly;

impl Reporter for WarningsOnly {
    fn report(&self, update: Update<'_>) {
        if let Update::Warning { message } = update {
            warn(message);
        }
    }
}

impl FinishingReporter for WarningsOnly {
    fn finish(&self, _: Option<&Failure>) {}
}

/// A bar for the outermost stage that is open.
struct Bar {
    bar: ProgressBar,
    shown: Mutex<Option<&'static str>>,
}

impl Bar {
    fn new() -> Self {
        let bar = ProgressBar::no_length();
        let style = BarStyle::with_template("{msg:12} {wide_bar} {pos}/{len}  {eta}");
        bar.set_style(style.unwrap_or_else(|_| BarStyle::default_bar()));
        Self {
            bar,
            shown: Mutex::new(None),
        }
    }
}

impl Reporter for Bar {
    fn report(&self, update: Update<'_>) {
        let mut shown = locked(&self.shown);
        match update {
            Update::Began { stage, total } if shown.is_none() => {
                *shown = Some(stage);
                self.bar.reset();
                self.bar.set_length(total);
                self.bar.set_message(stage);
            }
            Update::Advanced { stage, done, .. } if *shown == Some(stage) => {
                self.bar.set_position(done.max(self.bar.position()));
            }
            Update::Ended { stage } if *shown == Some(stage) => *shown = None,
            Update::Warning { message } => self.bar.suspend(|| warn(message)),
            _ => {}
        }
    }
}

impl FinishingReporter for Bar {
    fn finish(&self, _: Option<&Failure>) {
        self.bar.finish_and_clear();
    }
}

/// The newest number of each stage.
#[derive(Default)]
struct Newest(Vec<(&'static str, u64)>);

impl Newest {
    fn begin(&mut self, stage: &'static str) {
        self.0.retain(|(known, _)| *known != stage);
        self.0.push((stage, 0));
    }

    /// Notes `done`; whether it is news.
    fn advance(&mut self, stage: &'static str, done: u64) -> bool {
        match self.0.iter_mut().find(|(known, _)| *known == stage) {
            Some((_, newest)) if *newest < done => {
                *newest = done;
                true
            }
            _ => false,
        }
    }
}

/// Lines `{"stage":…,"done":…,"total":…}` on stderr, a thousand for a stage at the most.
#[derive(Default)]
struct JsonLines {
    newest: Mutex<Newest>,
}

fn progress_line(stage: &str, done: u64, total: u64) -> String {
    // By hand for the order of the keys.
    format!(
        r#"{{"stage":{},"done":{done},"total":{total}}}"#,
        json!(stage)
    )
}

impl Reporter for JsonLines {
    fn report(&self, update: Update<'_>) {
        // Held while printing, so that lines come in order.
        let mut newest = locked(&self.newest);
        let line = match update {
            Update::Began { stage, total } => {
                newest.begin(stage);
                progress_line(stage, 0, total)
            }
            Update::Advanced { stage, done, total } => {
                let step = total / 1000 + 1;
                let due = done % step == 0 || done == total;
                if !(due && newest.advance(stage, done)) {
                    return;
                }
                progress_line(stage, done, total)
            }
            Update::Warning { message } => json!({"warning": brief_line(message)}).to_string(),
            Update::Ended { .. } => return,
        };
        to_stderr(&line);
    }
}

impl FinishingReporter for JsonLines {
    fn finish(&self, _: Option<&Failure>) {}
}

/// `openjd_progress: 42.0`, `openjd_status: …` and `openjd_fail: …` on stdout.
///
/// <https://github.com/OpenJobDescription/openjd-specifications/wiki/How-Jobs-Are-Run>
struct OpenJd {
    stages: Stages,
    percent: Mutex<f64>,
}

impl OpenJd {
    fn new(stages: Stages) -> Self {
        Self {
            stages,
            percent: Mutex::new(0.0),
        }
    }

    /// Percentage of the whole command when `share` (0 to 1) of `stage` is done; `None` for a
    /// stage within another.
    fn percentage(&self, stage: &str, share: f64) -> Option<f64> {
        let index = self.stages.iter().position(|(name, _)| *name == stage)?;
        let sum = |stages: &[(&str, f64)]| stages.iter().map(|(_, part)| part).sum::<f64>();
        let done = sum(&self.stages[..index]) + self.stages[index].1 * share;
        Some(100.0 * done / sum(self.stages))
    }

    /// Prints `percent` when it has grown by a tenth at least.
    fn reach(&self, percent: f64) {
        let mut printed = locked(&self.percent);
        let tenths = (percent.min(100.0) * 10.0).floor() / 10.0;
        if tenths > *printed {
            *printed = tenths;
            to_stdout(&format!("openjd_progress: {tenths:.1}"));
        }
    }
}

impl Reporter for OpenJd {
    fn report(&self, update: Update<'_>) {
        match update {
            Update::Began { stage, .. } if self.percentage(stage, 0.0).is_some() => {
                to_stdout(&format!("openjd_status: {stage}"));
            }
            Update::Advanced { stage, done, total } if total > 0 => {
                if let Some(percent) = self.percentage(stage, done as f64 / total as f64) {
                    self.reach(percent);
                }
            }
            Update::Warning { message } => warn(message),
            _ => {}
        }
    }
}

impl FinishingReporter for OpenJd {
    fn finish(&self, failure: Option<&Failure>) {
        match failure {
            None => self.reach(100.0),
            Some(failure) => to_stdout(&format!("openjd_fail: {failure}")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentages_run_over_the_whole_command() {
        let openjd = OpenJd::new(&[("read", 1.0), ("make", 3.0)]);
        assert_eq!(openjd.percentage("read", 1.0), Some(25.0));
        assert_eq!(openjd.percentage("make", 0.5), Some(62.5));
        assert_eq!(openjd.percentage("within", 0.5), None);
    }

    #[test]
    fn late_numbers_are_no_news() {
        let mut newest = Newest::default();
        newest.begin("make");
        assert!(newest.advance("make", 2));
        assert!(!newest.advance("make", 1));
        newest.begin("make");
        assert!(newest.advance("make", 1));
    }
}
