//! `boscage samples`: the built-in trees as files.

use super::failure::Failure;
use super::input::PictureFile;
use super::items::made;
use super::output::recipe;
use super::session::Session;
use super::{Job, Stages};
use crate::base::Digest;
use crate::branches::samples::BUNDLED_HEIGHT_PX;
use crate::branches::{Sample, samples};
use crate::raster::{
    Compression, Image, ReadLimits, Straight, encode_grey_png, encode_png, read_image_from_memory,
};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Write the built-in trees
///
/// Grows each tree anew and writes NAME.png and labels/NAME.labels.png; --bundled writes the
/// pictures that come with the program, which are the same at the usual height, at once.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage samples --out trees --bundled")]
pub(super) struct Flags {
    /// Height of the pictures, in pixels
    #[arg(long, default_value_t = BUNDLED_HEIGHT_PX, value_name = "PX", value_parser = clap::value_parser!(u32).range(16..=8192))]
    height: u32,
    /// Write the pictures that come with the program, without labels
    #[arg(long, conflicts_with = "height")]
    bundled: bool,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("grow", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let folder = session.options.out()?;
        let tasks: Vec<Task> = samples()
            .iter()
            .map(|sample| Task::new(sample, folder, !self.bundled))
            .collect();
        let shard = session.options.shard;
        let ours = (0u64..).zip(&tasks).filter(|(i, _)| shard.contains(*i));
        let files = ours.flat_map(|(_, task)| [Some(&task.image), task.labels.as_ref()]);
        session.output.check(files.flatten())?;
        let made = made(session, "grow", &tasks, |_, task| {
            task.run(self.height, session)
        })?;
        session.print_json(|| {
            let samples: Vec<Value> = made.ready.into_iter().map(|(_, sample)| sample).collect();
            json!({"samples": samples, "seconds": session.seconds()})
        })
    }
}

/// One tree and where it goes.
struct Task {
    sample: &'static Sample,
    image: PathBuf,
    /// `None` for the bundled picture, which is not grown.
    labels: Option<PathBuf>,
}

impl Task {
    fn new(sample: &'static Sample, folder: &Path, with_labels: bool) -> Self {
        let name = sample.name();
        let labels = || folder.join("labels").join(format!("{name}.labels.png"));
        Self {
            sample,
            image: folder.join(format!("{name}.png")),
            labels: with_labels.then(labels),
        }
    }

    /// Makes and writes the files, or keeps those that are there; says what they are.
    fn run(&self, height: u32, session: &Session<'_>) -> Result<Value, Failure> {
        let recipe = recipe("samples")
            .with(self.sample.name().as_bytes())
            .with(&Digest::of(self.sample.bundled()).bytes()[..])
            .with(&height.to_le_bytes())
            .with(&[u8::from(self.labels.is_some())])
            .finish();
        let mut files = [Some(&self.image), self.labels.as_ref()]
            .into_iter()
            .flatten();
        let (width, height) = if files.all(|file| session.output.is_ready(file, recipe)) {
            let kept = PictureFile::read(&self.image)?.decoded()?;
            (kept.width(), kept.height())
        } else {
            let (image, labels) = self.grown(height, session)?;
            let png = encode_png(&image, Compression::Fast);
            session.cancel.check()?;
            session.output.write_item(&self.image, png, recipe)?;
            if let Some((path, labels)) = self.labels.as_ref().zip(labels) {
                let png = encode_grey_png(&labels, Compression::Fast);
                session.output.write_item(path, png, recipe)?;
            }
            (image.width(), image.height())
        };
        Ok(json!({
            "name": self.sample.name(),
            "file": self.image.display().to_string(),
            "labels": self.labels.as_ref().map(|path| path.display().to_string()),
            "width": width,
            "height": height,
        }))
    }

    /// The picture, and its labels unless it is the bundled one.
    fn grown(
        &self,
        height: u32,
        session: &Session<'_>,
    ) -> Result<(Image<Straight>, Option<Image<u8>>), Failure> {
        if self.labels.is_some() {
            let tree = self.sample.grow(height, session.cancel)?;
            return Ok((tree.image, Some(tree.labels)));
        }
        let name = format!("{}.webp", self.sample.name());
        let limits = ReadLimits::default();
        let image = read_image_from_memory(self.sample.bundled(), Path::new(&name), limits)?;
        Ok((image, None))
    }
}
