//! `boscage bench`: how long the main pieces of work take here, beside what others need.

mod crown;
mod live;
mod paint;
mod render;
mod row;
mod segment;
mod synth;
mod variation;

use super::failure::Failure;
use super::segmenter::SegmenterFlags;
use super::session::Session;
use super::{Job, Stages};
use clap::{Args, ValueEnum};
use row::Row;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::PathBuf;

/// Measure how fast this machine makes trees
///
/// Times the main pieces of work on the built-in samples, each several times, and prints them
/// beside their targets and what others need. `boscage bench segment --labels DIR` tells how well
/// crown and trunk are told apart in pictures that a person has labelled.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage bench crown --json
  boscage bench segment --labels trees")]
pub(super) struct Flags {
    /// What to measure [default: everything]
    #[arg(value_enum, value_name = "TOPIC")]
    topic: Option<Topic>,
    /// Folder of pictures and labels, NAME.png or NAME.jpg beside NAME.labels.png
    #[arg(long, value_name = "DIR")]
    labels: Option<PathBuf>,
    #[command(flatten)]
    segmenter: SegmenterFlags,
}

/// A group of measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Topic {
    /// New trees from tree pictures
    Variation,
    /// A crown from a photograph
    Crown,
    /// Foliage around a crown
    Synth,
    /// Crowns on a graphics card
    Render,
    /// Crown and trunk
    Segment,
    /// The brush on a large photograph
    Paint,
}

impl Topic {
    const ALL: [Self; 6] = [
        Self::Variation,
        Self::Crown,
        Self::Synth,
        Self::Render,
        Self::Segment,
        Self::Paint,
    ];

    fn rows(self, session: &Session<'_>) -> Result<Vec<Row>, Failure> {
        let cancel = session.cancel;
        match self {
            Self::Variation => variation::rows(cancel),
            Self::Crown => {
                let mut rows = crown::rows(cancel)?;
                rows.extend(live::rows(cancel)?);
                Ok(rows)
            }
            Self::Synth => synth::rows(cancel),
            Self::Render => render::rows(session),
            Self::Segment => segment::rows(cancel),
            Self::Paint => paint::rows(cancel),
        }
    }
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("bench", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        if let Some(folder) = &self.labels {
            if self.topic.is_some_and(|topic| topic != Topic::Segment) {
                return Err(Failure::of("--labels", "is for the topic segment"));
            }
            let own = self.segmenter.checked(session.cancel)?;
            let own = self.segmenter.is_chosen().then_some(own.as_ref());
            return segment::table(folder, own, session);
        }
        let topics = match self.topic {
            Some(topic) => vec![topic],
            None => Topic::ALL.to_vec(),
        };
        let stage = session.progress.stage("bench", topics.len() as u64);
        let mut rows = Vec::new();
        for topic in topics {
            rows.extend(topic.rows(session)?);
            stage.advance();
        }
        drop(stage);
        if session.options.json {
            return session.print_json(|| {
                json!({"results": rows.iter().map(Row::json).collect::<Vec<_>>(), "machine": machine()})
            });
        }
        let mut table = format!(
            "{:<38} {:>10} {:>10} {:>10} {:>8}  baseline\n",
            "ms", "median", "min", "target", "ratio"
        );
        for row in &rows {
            table.push_str(&row.line());
        }
        write!(std::io::stdout(), "{table}")
            .map_err(|error| Failure::Environment(format!("stdout: cannot be written: {error}")))
    }
}

fn machine() -> Value {
    json!({
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "threads": rayon::current_num_threads(),
        "arch": std::env::consts::ARCH,
        "os": std::env::consts::OS,
        "optimized": !cfg!(debug_assertions),
    })
}
