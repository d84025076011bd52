//! Crowns for engines as a job: what `boscage crown` and then `boscage export` do, from the project's
//! pictures in memory.

use super::batch_jobs::{BATCH, ExportChoice, Which};
use super::outcome::Outcome;
use super::studio::{Severity, Studio};
use super::vary_jobs::VaryOutcome;
use crate::base::with_threads;
use crate::batch::export_crown::{CrownExport, check_preset};
use crate::batch::failure::Failure;
use crate::batch::output::{Output, Policy};
use crate::batch::project_crowns::{ProjectCrowns, crowned};
use crate::batch::run::{Run, Shard};
use crate::document::PhotoId;
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use std::path::PathBuf;

/// Crowns to export, for a job to own.
struct CrownBatch {
    folder: PathBuf,
    replaces: bool,
    choice: ExportChoice,
    crowns: ProjectCrowns,
}

impl Studio {
    /// The photographs that have a crown.
    pub(super) fn crowns(&self) -> Vec<PhotoId> {
        crowned(self.document.state())
    }

    /// Exports the shown crown, or all.
    pub(super) fn export_crowns(
        &mut self,
        which: Which,
        folder: PathBuf,
        replaces: bool,
        choice: ExportChoice,
    ) {
        let mut wanted = self.crowns();
        if which == Which::ShownCrown {
            let shown = self.shown();
            wanted.retain(|id| Some(*id) == shown);
        }
        let crowns = ProjectCrowns::of(&self.document, &wanted, choice.leaves);
        if crowns.is_empty() {
            self.notify(
                Severity::Warning,
                "There is no crown to export: paint one first.",
            );
            return;
        }
        let name = format!("Exporting crowns for {}", choice.preset.name());
        let batch = CrownBatch {
            folder,
            replaces,
            choice,
            crowns,
        };
        let work = move |context: &Context<Outcome>| {
            let told = batch.run(context)?;
            Ok(Outcome::Vary(VaryOutcome::Wrote(told)))
        };
        self.vary.batch_tree = None;
        let topic = Topic {
            kind: BATCH,
            item: self.next_notice,
        };
        self.next_notice += 1;
        self.jobs
            .submit(Request::new(name, topic, Priority::Background, work));
    }
}

impl CrownBatch {
    /// Writes everything; what is told the user.
    fn run(&self, context: &Context<Outcome>) -> Result<String, JobError> {
        let policy = if self.replaces {
            Policy::Overwrite
        } else {
            Policy::Resume
        };
        let gate = || context.check();
        let cores = std::thread::available_parallelism().map_or(2, usize::from);
        let progress = context.progress();
        // Threads of its own, and one left for the window.
        let told = with_threads(Some((cores - 1).max(1)), || {
            let run = Run {
                seed: 0,
                shard: Shard::default(),
                progress,
                cancel: context.cancel(),
                output: Output::new(policy, context.cancel()),
                gate: Some(&gate),
                shown: None,
            };
            self.written(&run)
        });
        let told = told.map_err(JobError::failed)?;
        told.map_err(|failure| match failure {
            Failure::Cancelled => JobError::Cancelled(crate::base::Cancelled),
            failure => JobError::failed(failure),
        })
    }

    fn written(&self, run: &Run<'_>) -> Result<String, Failure> {
        check_preset(self.choice.preset)?;
        let made = self.crowns.make(&self.folder, run)?;
        let settings = self.choice.settings(&self.folder);
        let export = CrownExport {
            settings: &settings,
            crowns: &made,
        };
        let exported = export.run(run)?;
        if let Some(refused) = exported.refused.first() {
            return Err(Failure::BadInput(refused.clone()));
        }
        let count = exported.records.len();
        let crowns = if count == 1 { "crown" } else { "crowns" };
        let (name, folder) = (self.choice.preset.name(), self.folder.display());
        Ok(format!("Exported {count} {crowns} for {name} to {folder}"))
    }
}
