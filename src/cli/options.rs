//! The options that all commands share.

use super::failure::Failure;
use super::output::Policy;
use crate::base::VectorLevel;
use crate::batch::run::Shard;
use crate::render::Backend;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};

/// Options of every command.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Options of all commands")]
pub(super) struct CommonOptions {
    /// Where results go: a folder or a file, as the command says; folders are made
    #[arg(long, global = true, value_name = "PATH")]
    pub(super) out: Option<PathBuf>,
    /// Replace files that are there already
    #[arg(long, global = true)]
    pub(super) overwrite: bool,
    /// Keep files that are there and were made from the same inputs with the same settings
    #[arg(long, global = true)]
    pub(super) resume: bool,
    /// Same inputs, settings and seed: same files, to the bit
    #[arg(long, global = true, default_value_t = 0, value_name = "U64")]
    pub(super) seed: u64,
    /// Threads at work [default: one for each core]
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Make only items I, I+N, I+2N … of the job
    #[arg(long, global = true, default_value_t, value_name = "I/N")]
    pub(super) shard: Shard,
    /// Print one JSON object on stdout and nothing else
    #[arg(long, global = true)]
    pub(super) json: bool,
    /// Use no wider vector units: for comparing, results are the same
    #[arg(long, global = true, value_enum, hide = true, value_name = "LEVEL")]
    pub(super) vector_level: Option<VectorLevelName>,
    /// A native ONNX Runtime, 1.24 or newer, to run the learned segmenter with, several times faster
    /// than the one built in [env: ORT_DYLIB_PATH]
    #[arg(long, global = true, value_name = "LIBRARY")]
    onnx_runtime: Option<PathBuf>,
    /// How progress is shown
    #[arg(long, global = true, value_enum, default_value_t, value_name = "STYLE")]
    pub(super) progress: ProgressStyle,
}

impl CommonOptions {
    /// Checks what options mean together.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let clash = |options: &str, reason: &str| Err(Failure::of(options, reason));
        if self.overwrite && self.resume {
            return clash("--overwrite and --resume", "only one of them can be meant");
        }
        if self.json && self.progress == ProgressStyle::Openjd {
            return clash(
                "--json and --progress openjd",
                "both want stdout for themselves",
            );
        }
        Ok(())
    }

    /// What happens to outputs that exist.
    pub(super) fn policy(&self) -> Policy {
        match (self.overwrite, self.resume) {
            (true, _) => Policy::Overwrite,
            (false, true) => Policy::Resume,
            (false, false) => Policy::Refuse,
        }
    }

    /// The native ONNX Runtime that was asked for.
    pub(super) fn onnx_runtime(&self) -> Option<PathBuf> {
        let of_system = || std::env::var_os("ORT_DYLIB_PATH").map(PathBuf::from);
        self.onnx_runtime.clone().or_else(of_system)
    }

    /// The value of `--out`.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when it is missing.
    pub(super) fn out(&self) -> Result<&Path, Failure> {
        match &self.out {
            Some(path) if !path.as_os_str().is_empty() => Ok(path),
            _ => Err(Failure::of("--out PATH", "is needed by this command")),
        }
    }
}

/// Who draws.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum BackendName {
    /// The graphics card, or the processor where there is none
    #[default]
    Auto,
    /// The graphics card
    Gpu,
    /// The processor
    Cpu,
}

impl BackendName {
    /// What no other may replace.
    pub(super) fn forced(self) -> Option<Backend> {
        match self {
            Self::Auto => None,
            Self::Gpu => Some(Backend::Gpu),
            Self::Cpu => Some(Backend::Cpu),
        }
    }
}

/// The widest vector units that are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum VectorLevelName {
    /// What every processor of the family has
    Least,
    /// At most AVX2
    Wide,
    /// All there are
    Widest,
}

impl VectorLevelName {
    pub(super) fn level(self) -> VectorLevel {
        match self {
            Self::Least => VectorLevel::Least,
            Self::Wide => VectorLevel::Wide,
            Self::Widest => VectorLevel::Widest,
        }
    }
}

/// How progress is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum ProgressStyle {
    /// A bar on a terminal, nothing otherwise
    #[default]
    Auto,
    /// A bar on stderr
    Bar,
    /// Lines {"stage":…,"done":…,"total":…} on stderr
    Json,
    /// Lines of Open Job Description on stdout
    Openjd,
    /// Nothing
    None,
}

impl ProgressStyle {
    /// The style to use, which is never `Auto`; a bar needs a terminal.
    pub(super) fn resolved(self, on_terminal: bool) -> Self {
        match self {
            Self::Auto | Self::Bar if on_terminal => Self::Bar,
            Self::Auto | Self::Bar => Self::None,
            other => other,
        }
    }
}
