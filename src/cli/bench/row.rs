//! A measurement: timing a piece of work, and a line about it.

use super::super::failure::Failure;
use crate::base::Cancel;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Runs of a measurement at least, after one that is not counted.
const FEWEST_RUNS: usize = 7;

/// Runs of a long measurement, after one that is not counted.
const LONG_RUNS: usize = 3;

/// Runs of a measurement at most.
const MOST_RUNS: usize = 100;

/// How long a measurement goes on when it has its fewest runs.
const LONG_ENOUGH: Duration = Duration::from_millis(700);

/// What others need for a piece of work.
pub(super) struct Baseline {
    pub(super) what: &'static str,
    pub(super) ms: f64,
}

/// One measurement.
pub(super) struct Row {
    pub(super) name: &'static str,
    pub(super) median_ms: f64,
    pub(super) min_ms: f64,
    runs: usize,
    /// `ms`, or what a number without a duration counts.
    unit: &'static str,
    target_ms: Option<f64>,
    baseline: Option<Baseline>,
}

/// Times `work`.
pub(super) fn measured<E: Into<Failure>>(
    name: &'static str,
    cancel: &Cancel,
    work: impl FnMut() -> Result<(), E>,
) -> Result<Row, Failure> {
    measured_at_least(FEWEST_RUNS, name, cancel, work)
}

/// Times `work` that takes a second or more, a few times only.
pub(super) fn measured_long<E: Into<Failure>>(
    name: &'static str,
    cancel: &Cancel,
    work: impl FnMut() -> Result<(), E>,
) -> Result<Row, Failure> {
    measured_at_least(LONG_RUNS, name, cancel, work)
}

fn measured_at_least<E: Into<Failure>>(
    fewest: usize,
    name: &'static str,
    cancel: &Cancel,
    mut work: impl FnMut() -> Result<(), E>,
) -> Result<Row, Failure> {
    work().map_err(Into::into)?;
    let begin = Instant::now();
    let mut times = Vec::new();
    while times.len() < fewest || (times.len() < MOST_RUNS && begin.elapsed() < LONG_ENOUGH) {
        cancel.check()?;
        let start = Instant::now();
        work().map_err(Into::into)?;
        times.push(start.elapsed().as_secs_f64() * 1e3);
    }
    Ok(Row::of_times(name, times))
}

impl Row {
    /// A measurement from its times, milliseconds, of which there is one at least.
    pub(super) fn of_times(name: &'static str, mut times: Vec<f64>) -> Self {
        times.sort_by(f64::total_cmp);
        Self::new(name, &times)
    }

    fn new(name: &'static str, times: &[f64]) -> Self {
        Row {
            name,
            median_ms: times[times.len() / 2],
            min_ms: times[0],
            runs: times.len(),
            unit: "ms",
            target_ms: None,
            baseline: None,
        }
    }

    /// A number that is no duration.
    pub(super) fn number(name: &'static str, value: f64, unit: &'static str) -> Self {
        Self {
            unit,
            ..Self::new(name, &[value])
        }
    }

    pub(super) fn target(self, ms: f64) -> Self {
        Self {
            target_ms: Some(ms),
            ..self
        }
    }

    pub(super) fn against(self, baseline: Baseline) -> Self {
        Self {
            baseline: Some(baseline),
            ..self
        }
    }

    /// How many times longer the baseline takes.
    fn ratio(&self) -> Option<f64> {
        self.baseline.as_ref().map(|b| b.ms / self.median_ms)
    }

    pub(super) fn json(&self) -> Value {
        if self.unit != "ms" {
            return json!({"name": self.name, "value": self.median_ms, "unit": self.unit});
        }
        let baseline = self
            .baseline
            .as_ref()
            .map(|b| json!({"what": b.what, "ms": b.ms}));
        json!({
            "name": self.name,
            "median_ms": self.median_ms,
            "min_ms": self.min_ms,
            "runs": self.runs,
            "target_ms": self.target_ms,
            "baseline": baseline,
            "ratio": self.ratio(),
        })
    }

    pub(super) fn line(&self) -> String {
        let number = |value: Option<f64>, decimals: usize| {
            value.map_or_else(String::new, |value| format!("{value:.decimals$}"))
        };
        if self.unit != "ms" {
            return format!("{:<38} {:>10.3} {}\n", self.name, self.median_ms, self.unit);
        }
        format!(
            "{:<38} {:>10.2} {:>10.2} {:>10} {:>8}  {}\n",
            self.name,
            self.median_ms,
            self.min_ms,
            number(self.target_ms, 0),
            number(self.ratio(), 1),
            self.baseline.as_ref().map_or("", |b| b.what),
        )
    }
}
