//! `boscage segment`: pictures → label pictures.

use super::failure::Failure;
use super::input::PictureFile;
use super::items::made;
use super::output::recipe;
use super::session::Session;
use super::{Job, Stages};
use crate::raster::{Compression, encode_grey_png};
use crate::segment::{
    Classical, Labels, Segmenter as _, crown_baseline, crown_count, grey_from_labels,
    labels_from_grey, trunk_count,
};
use clap::{Args, ValueEnum};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Tell crown, trunk and background apart
///
/// Writes STEM.labels.png for each picture, 8-bit grey of the picture's size: 0 background, 128
/// trunk, 255 crown. Pixels of alpha below 128 are background.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage segment oak.png pine.png --out labels")]
pub(super) struct Flags {
    /// Pictures of trees on clear ground
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    #[command(flatten)]
    segmenter: SegmenterFlags,
}

/// Which segmenter to use; shared by all commands that segment.
#[derive(Debug, Args)]
pub(super) struct SegmenterFlags {
    /// What tells crown from trunk
    #[arg(long, value_enum, default_value_t, value_name = "NAME")]
    segmenter: SegmenterName,
    /// A segmentation model
    #[arg(long, value_name = "FILE.onnx")]
    model: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum SegmenterName {
    /// The best that this version has: classical
    #[default]
    Auto,
    /// A learned model (not in this version)
    Onnx,
    /// Colour, width profile and height
    Classical,
}

impl SegmenterFlags {
    /// The segmenter asked for.
    ///
    /// # Errors
    /// [`Failure::BadInput`] for one that this version does not have.
    pub(super) fn checked(&self) -> Result<Classical, Failure> {
        const ONLY_CLASSICAL: &str = "this version has only the classical segmenter";
        if let Some(model) = &self.model {
            return Err(Failure::of(model.display(), ONLY_CLASSICAL));
        }
        match self.segmenter {
            SegmenterName::Onnx => Err(Failure::of("--segmenter onnx", ONLY_CLASSICAL)),
            SegmenterName::Auto | SegmenterName::Classical => Ok(Classical),
        }
    }
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("segment", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let segmenter = self.segmenter.checked()?;
        let tasks = tasks(&self.images, session.options.out()?)?;
        let shard = session.options.shard;
        let ours = (0u64..).zip(&tasks).filter(|(i, _)| shard.contains(*i));
        session.output.check(ours.map(|(_, task)| &task.output))?;
        let made = made(session, "segment", &tasks, |_, task| {
            task.run(&segmenter, session)
        })?;
        session.print_json(|| {
            let images: Vec<Value> = made.ready.into_iter().map(|(_, image)| image).collect();
            let refused: Vec<String> = made.refused.into_iter().map(|(_, reason)| reason).collect();
            json!({"images": images, "refused": refused, "seconds": session.seconds()})
        })
    }
}

/// One picture and where its labels go.
#[derive(Debug, PartialEq)]
struct Task {
    input: PathBuf,
    output: PathBuf,
}

/// A task for each picture.
///
/// # Errors
/// [`Failure::BadInput`] when two pictures would have the same label file.
fn tasks(images: &[PathBuf], folder: &Path) -> Result<Vec<Task>, Failure> {
    let mut by_name: BTreeMap<OsString, &Path> = BTreeMap::new();
    let mut tasks = Vec::new();
    for input in images {
        let Some(stem) = input.file_stem() else {
            return Err(Failure::of(input.display(), "names no file"));
        };
        let mut name = stem.to_owned();
        name.push(".labels.png");
        let output = folder.join(&name);
        if let Some(other) = by_name.insert(name, input) {
            let reason = format!(
                "its labels would have the same name as those of {}",
                other.display()
            );
            return Err(Failure::of(input.display(), reason));
        }
        tasks.push(Task {
            input: input.clone(),
            output,
        });
    }
    Ok(tasks)
}

impl Task {
    /// Makes and writes the labels, or keeps those that are there; says what they are.
    fn run(&self, segmenter: &Classical, session: &Session<'_>) -> Result<Value, Failure> {
        let file = PictureFile::read(&self.input)?;
        let recipe = recipe("segment")
            .with(file.digest().bytes())
            .with(segmenter.name().as_bytes())
            .finish();
        let labels = if session.output.is_ready(&self.output, recipe) {
            let kept = PictureFile::read(&self.output)?.decoded()?;
            labels_from_grey(&kept.map(|pixel| pixel.0[0]))
        } else {
            let labels = segmenter.segment(&file.decoded()?, session.cancel)?;
            let png = encode_grey_png(&grey_from_labels(&labels), Compression::Fast);
            session.cancel.check()?;
            session.output.write_item(&self.output, png, recipe)?;
            labels
        };
        if crown_count(&labels) + trunk_count(&labels) == 0 {
            let warning = format!(
                "{}: no pixel is opaque: all background",
                self.input.display()
            );
            session.progress.warn(&warning);
        }
        Ok(self.description(&labels, segmenter.name()))
    }

    fn description(&self, labels: &Labels, source: &str) -> Value {
        json!({
            "file": self.input.display().to_string(),
            "output": self.output.display().to_string(),
            "width": labels.width(),
            "height": labels.height(),
            "source": source,
            "crown_pixels": crown_count(labels),
            "trunk_pixels": trunk_count(labels),
            "baseline_y": crown_baseline(labels),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_named_after_the_stem_and_may_not_clash() {
        let out = Path::new("out");
        let tasks_of = |names: &[&str]| {
            let paths: Vec<PathBuf> = names.iter().map(PathBuf::from).collect();
            tasks(&paths, out)
        };
        let good = tasks_of(&["a/oak.v2.png", "a/pine.tga"]).unwrap();
        assert_eq!(good[0].output, out.join("oak.v2.labels.png"));
        assert!(tasks_of(&["a/oak.png", "b/oak.tga"]).is_err());
        assert!(tasks_of(&[".."]).is_err());
    }
}
