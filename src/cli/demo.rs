//! `boscage demo`: the whole pipeline on the built-in samples.

use super::demo_crown::demo_crown;
use super::failure::Failure;
use super::library::pictures;
use super::session::Session;
use super::{Job, Stages};
use crate::batch::vary::{Trees, Vary};
use crate::branches::samples::{Sample, starters};
use crate::segment::standard;
use crate::variation::{ChoiceSettings, ExemplarSettings};
use clap::Args;
use std::path::PathBuf;

/// Make new trees and a crown from the built-in samples
///
/// Writes one sample of each species into DIR/exemplars, new trees and library.json into DIR/trees, all of them on
/// one sheet, DIR/sheet.png, and one sample's crown in three dimensions into DIR/crown, with a
/// picture of it, DIR/crown.png.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage demo --out out/demo")]
pub(super) struct Flags {
    /// How many trees
    #[arg(long, default_value_t = 24, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000))]
    count: u32,
    /// Side of the pictures, in pixels
    #[arg(long, default_value_t = 1024, value_name = "PX", value_parser = clap::value_parser!(u32).range(64..=8192))]
    size: u32,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("samples", 1.0),
            ("prepare", 10.0),
            ("choose", 2.0),
            ("vary", 80.0),
            ("sheet", 7.0),
            ("crown", 60.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        let folder = out.join("exemplars");
        let chosen: Vec<&Sample> = starters().collect();
        let files: Vec<PathBuf> = chosen
            .iter()
            .map(|sample| folder.join(format!("{}.webp", sample.name())))
            .collect();
        let stage = session.progress.stage("samples", files.len() as u64);
        for (file, sample) in files.iter().zip(chosen) {
            session.cancel.check()?;
            session.output.write_same(file, sample.bundled())?;
            stage.advance();
        }
        drop(stage);
        let vary = Vary {
            folder,
            pictures: pictures(&files),
            has_target: false,
            trees: Trees::Drawn(self.count),
            likes: Vec::new(),
            maps: std::collections::BTreeSet::new(),
            sheet: session
                .options
                .shard
                .is_whole()
                .then(|| out.join("sheet.png")),
            settings: ExemplarSettings {
                size: self.size,
                ..Default::default()
            },
            choice: ChoiceSettings::default(),
            season: None,
            crowns: None,
            cache: None,
        };
        vary.run(standard(), &out.join("trees"), session)?;
        if session.options.shard.contains(0) {
            demo_crown(session, &out.join("crown"))?;
        }
        Ok(())
    }
}
