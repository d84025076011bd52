//! What a command is given: the common options, and where to tell, stop, write and print.

use super::clock::{Seconds, StageClock};
use super::failure::Failure;
use super::options::CommonOptions;
use crate::batch::run::Run;
use std::io::Write as _;

/// The surroundings of one command. Its work runs inside the thread pool already.
pub(super) struct Session<'a> {
    /// The options of all commands, checked.
    pub(super) options: &'a CommonOptions,
    /// What the work itself is given; its flag is raised by SIGINT and SIGTERM.
    pub(super) run: Run<'a>,
    pub(super) clock: &'a StageClock<'a>,
}

impl<'a> std::ops::Deref for Session<'a> {
    type Target = Run<'a>;

    fn deref(&self) -> &Run<'a> {
        &self.run
    }
}

impl Session<'_> {
    /// Seconds for each stage so far, for `"seconds"` in JSON.
    pub(super) fn seconds(&self) -> Seconds {
        self.clock.seconds()
    }

    /// Prints the answer as one line of JSON when `--json` was given; called once, at the end.
    ///
    /// # Errors
    /// [`Failure::Environment`] when stdout is closed or full.
    pub(super) fn print_json(
        &self,
        answer: impl FnOnce() -> serde_json::Value,
    ) -> Result<(), Failure> {
        if !self.options.json {
            return Ok(());
        }
        let line = answer().to_string();
        writeln!(std::io::stdout(), "{line}")
            .map_err(|error| Failure::Environment(format!("stdout: cannot be written: {error}")))
    }
}
