//! The command line: one file a command, and the frame that all commands stand in.
//!
//! A command is a `clap` struct of flags *as typed* that implements [`Job`]. Its `run` first makes
//! a *checked* job of the flags (paths exist, sizes are sensible, nothing would be overwritten) and
//! then works; so nothing is begun that cannot be finished. To add a command: write its file, list
//! it below with `mod`, give it a variant of [`Command`] and an arm in [`Command::job`].
//!
//! The frame promises, for every command alike: exit codes and one-line errors ([`Failure`]),
//! progress ([`reporter`]), cancellation by SIGINT and SIGTERM, threads, shards and what happens to
//! files that are there already ([`Output`]).
//!
//! Imports everything; nothing imports it.

mod bench;
mod clock;
mod crown;
mod cubemap;
mod demo;
mod demo_crown;
mod exemplars;
mod export;
mod inflate;
mod inspect;
mod library;
mod morph;
mod options;
mod photos;
mod polygons;
#[doc(hidden)]
pub mod readers;
mod recolor;
mod regions;
mod render;
mod reporter;
mod samples;
mod score;
mod season;
mod season_flags;
mod segment;
mod segmenter;
mod session;
mod synthesize;
mod table;
mod try_model;
mod usage;
mod vary;
mod vary_again;
mod vary_flags;
mod vary_parents;
mod warp;

use crate::app;
use crate::base::{
    Cancel, Progress, end_writing, folder_of, limit_vector_level, remove_left_parts, with_threads,
};
use crate::batch::run::Run;
use crate::batch::{failure, input, items, output, records};
use crate::render::Backend;
use crate::segment::Runtime;
use clap::{Parser, Subcommand};
use clock::StageClock;
use failure::Failure;
use options::{BackendName, CommonOptions};
use output::Output;
use session::Session;
use std::io::IsTerminal as _;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

/// New trees from a few tree pictures.
#[derive(Debug, Parser)]
#[command(name = "boscage", version, max_term_width = 100)]
struct Cli {
    #[command(flatten)]
    options: CommonOptions,
    /// A project or pictures to open in the studio.
    #[arg(value_name = "FILE")]
    files: Vec<PathBuf>,
    /// Who draws the studio's window
    #[arg(long, value_enum, value_name = "NAME")]
    backend: Option<BackendName>,
    #[command(subcommand)]
    command: Option<Command>,
}

/// What can be asked for.
#[derive(Debug, Subcommand)]
enum Command {
    Vary(Box<vary::Flags>),
    Morph(morph::Flags),
    Table(table::Flags),
    Demo(demo::Flags),
    Samples(samples::Flags),
    Inflate(inflate::Flags),
    Inspect(inspect::Flags),
    Segment(segment::Flags),
    Score(score::Flags),
    Season(season::Flags),
    Warp(warp::Flags),
    Recolor(recolor::Flags),
    Render(render::Flags),
    Synthesize(synthesize::Flags),
    Cubemap(cubemap::Flags),
    Export(Box<export::Flags>),
    Crown(crown::Flags),
    Bench(bench::Flags),
    #[command(hide = true)]
    TryModel(try_model::Flags),
}

impl Command {
    fn job(&self) -> &dyn Job {
        match self {
            Self::Vary(flags) => flags.as_ref(),
            Self::Morph(flags) => flags,
            Self::Table(flags) => flags,
            Self::Demo(flags) => flags,
            Self::Samples(flags) => flags,
            Self::Inflate(flags) => flags,
            Self::Inspect(flags) => flags,
            Self::Segment(flags) => flags,
            Self::Score(flags) => flags,
            Self::Season(flags) => flags,
            Self::Warp(flags) => flags,
            Self::Recolor(flags) => flags,
            Self::Render(flags) => flags,
            Self::Synthesize(flags) => flags,
            Self::Cubemap(flags) => flags,
            Self::Export(flags) => flags.as_ref(),
            Self::Crown(flags) => flags,
            Self::Bench(flags) => flags,
            Self::TryModel(flags) => flags,
        }
    }
}

/// The stages of a command that make up its progress, each with its share of the time (any unit).
type Stages = &'static [(&'static str, f64)];

/// A command's flags, as typed.
trait Job: Sync {
    /// The outermost stages that `run` goes through, in order; the percentages that farms read are
    /// made of them. Stages inside these are not listed.
    fn stages(&self) -> Stages;

    /// Checks the flags, then does the work.
    fn run(&self, session: &Session<'_>) -> Result<(), Failure>;
}

/// Runs the program on the arguments of this process.
///
/// Exit codes: 0 done, 1 the environment failed, 2 bad usage or bad input, 3 cancelled.
pub fn run() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => return usage::answered(&error),
    };
    let outcome = match &cli.command {
        Some(_) if !cli.files.is_empty() => Err(Failure::of(
            cli.files[0].display(),
            "is neither a command nor an argument of one",
        )),
        Some(_) if cli.backend.is_some() => Err(Failure::of(
            "--backend",
            "stands behind the command that it is of",
        )),
        Some(command) => cli
            .options
            .check()
            .and_then(|()| run_job(&cli.options, command.job())),
        None => {
            if let Some(library) = cli.options.onnx_runtime() {
                Runtime::choose(Some(&library));
            }
            let backend = cli.backend.unwrap_or_default();
            studio(cli.files, backend.forced())
        }
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            reporter::print_failure(&failure);
            failure.exit_code()
        }
    }
}

/// Runs `job` in threads of its own, listening to signals and telling of progress.
fn run_job(options: &CommonOptions, job: &dyn Job) -> Result<(), Failure> {
    remove_what_is_left(options);
    if let Some(name) = options.vector_level {
        limit_vector_level(name.level());
    }
    Runtime::choose(options.onnx_runtime().as_deref());
    let cancel = Cancel::new();
    let style = options.progress.resolved(std::io::stderr().is_terminal());
    let reporter = reporter::new(style, job.stages());
    let ending = Ending::default();
    let (raised, told, ends) = (cancel.clone(), Arc::clone(&reporter), ending.clone());
    ctrlc::set_handler(move || {
        raised.cancel();
        std::thread::sleep(GRACE);
        end_now(&ends, told.as_ref());
    })
    .map_err(|error| Failure::Environment(format!("signals cannot be handled: {error}")))?;
    let clock = StageClock::new(reporter.as_ref());
    let session = Session {
        options,
        run: Run {
            seed: options.seed,
            shard: options.shard,
            progress: Progress::to(&clock),
            cancel: &cancel,
            output: Output::new(options.policy(), &cancel),
            gate: None,
            shown: None,
        },
        clock: &clock,
    };
    let outcome = with_threads(options.threads.map(usize::from), || job.run(&session))
        .map_err(|error| Failure::Environment(format!("threads cannot be started: {error}")))
        .and_then(|outcome| outcome);
    ending.claim();
    if let Some(note) = Runtime::started().and_then(Runtime::note) {
        session.progress.warn(note);
    }
    reporter.finish(outcome.as_ref().err());
    outcome
}

/// How long a command that was asked to stop may take until it is ended where it stands: some of what
/// it calls (decoders, encoders, drivers) knows no cancelling.
const GRACE: Duration = Duration::from_millis(50);

/// Who tells how the command ended: its own thread or that of the signals, whichever comes first.
#[derive(Clone, Default)]
struct Ending(Arc<AtomicBool>);

impl Ending {
    /// Takes it for the calling thread, or does not return: the other one ends the process.
    fn claim(&self) {
        if self.0.swap(true, Ordering::AcqRel) {
            loop {
                std::thread::park();
            }
        }
    }
}

/// Ends a command that did not stop by itself, with nothing half-written.
fn end_now(ending: &Ending, reporter: &dyn reporter::FinishingReporter) {
    ending.claim();
    end_writing();
    reporter.finish(Some(&Failure::Cancelled));
    reporter::print_failure(&Failure::Cancelled);
    // Without the handlers that libraries leave for the end: a renderer's would take from its threads
    // what they are working with.
    signal_hook::low_level::exit(Failure::Cancelled.status().into());
}

/// Removes the hidden halves of files that an earlier run left where this one goes on, if that was
/// killed: in the folder and two below it (`textures/`, a crown's own).
fn remove_what_is_left(options: &CommonOptions) {
    let goes_on = options.resume || options.overwrite;
    if let Some(out) = options.out.as_deref().filter(|_| goes_on) {
        match out.is_dir() {
            true => remove_left_parts(out, 2),
            false => remove_left_parts(folder_of(out), 0),
        }
    }
}

/// `boscage` alone opens the studio.
fn studio(files: Vec<PathBuf>, backend: Option<Backend>) -> Result<(), Failure> {
    // A mistyped command shall not open a window.
    if let Some(missing) = files.iter().find(|file| !file.exists()) {
        return Err(Failure::of(
            missing.display(),
            "is neither a command nor a file",
        ));
    }
    app::run(files, backend).map_err(|error| {
        Failure::Environment(format!(
            "{error}; commands work without a window, see boscage --help"
        ))
    })
}
