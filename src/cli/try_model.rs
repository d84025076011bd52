//! `boscage try-model`: the process that a model from outside first runs in. Nobody types this.

use super::failure::Failure;
use super::session::Session;
use super::{Job, Stages};
use crate::batch::model::try_out;
use clap::Args;
use std::io::Write as _;

/// Run the model on the standard input behind limits, and tell what is wrong with it
#[derive(Debug, Args)]
pub(super) struct Flags {
    /// What describes it
    #[arg(long, value_name = "JSON")]
    card: String,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[]
    }

    fn run(&self, _: &Session<'_>) -> Result<(), Failure> {
        let Some(reason) = try_out(&self.card)? else {
            return Ok(());
        };
        writeln!(std::io::stdout(), "{reason}")
            .map_err(|error| Failure::Environment(format!("stdout: cannot be written: {error}")))?;
        Err(Failure::of("the standard input", reason))
    }
}
