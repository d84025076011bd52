//! `boscage segment`: pictures → label pictures.

use super::failure::Failure;
use super::input::PictureFile;
use super::items::made;
use super::output::recipe;
use super::segmenter::{SegmenterFlags, add, failed, provenance_json};
use super::session::Session;
use super::{Job, Stages};
use crate::base::Digest;
use crate::raster::{Compression, encode_grey_png};
use crate::segment::{
    Labels, Provenance, Segmented, Segmenter, crown_baseline, crown_count, grey_from_labels,
    labels_from_grey, trunk_count,
};
use clap::Args;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Tell crown, trunk and background apart
///
/// Writes STEM.labels.png for each picture, 8-bit grey of the picture's size: 0 background, 128
/// trunk, 255 crown. In pictures with clear ground, pixels of alpha below 128 are background and all
/// others are not; in photographs the tree is found, too.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage segment oak.png pine.png --out labels")]
pub(super) struct Flags {
    /// Pictures of trees
    #[arg(required = true, value_name = "IMAGE")]
    images: Vec<PathBuf>,
    #[command(flatten)]
    segmenter: SegmenterFlags,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("segment", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let segmenter = self.segmenter.checked(session.cancel)?;
        let tasks = tasks(&self.images, session.options.out()?)?;
        let shard = session.options.shard;
        let ours = (0u64..).zip(&tasks).filter(|(i, _)| shard.contains(*i));
        let outputs: Vec<&PathBuf> = ours.map(|(_, task)| &task.output).collect();
        session.output.check(&outputs)?;
        let has_new = outputs.iter().any(|output| !output.exists());
        let made = rayon::scope(|scope| {
            if has_new {
                scope.spawn(|_| segmenter.prepare());
            }
            made(session, "segment", &tasks, |_, task| {
                task.run(segmenter.as_ref(), session)
            })
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
    fn run(&self, segmenter: &dyn Segmenter, session: &Session<'_>) -> Result<Value, Failure> {
        let file = PictureFile::read(&self.input)?;
        let recipe = recipe("segment")
            .with(file.digest().bytes())
            .with(segmenter.key().as_bytes())
            .finish();
        let Segmented { labels, provenance } = match self.kept(recipe, session)? {
            Some(kept) => kept,
            None => self.made(&file, segmenter, recipe, session)?,
        };
        if crown_count(&labels) + trunk_count(&labels) == 0 {
            let warning = format!("{}: no tree: all background", self.input.display());
            session.progress.warn(&warning);
        }
        Ok(self.description(&labels, &provenance))
    }

    /// The labels that are there already, if they are what would be made.
    fn kept(&self, recipe: Digest, session: &Session<'_>) -> Result<Option<Segmented>, Failure> {
        let note = session.output.ready_note(&self.output, recipe);
        let provenance = note.and_then(|note| serde_json::from_str(&note).ok());
        let Some(provenance) = provenance else {
            return Ok(None);
        };
        let kept = PictureFile::read(&self.output)?.decoded()?;
        Ok(Some(Segmented {
            labels: labels_from_grey(&kept.map(|pixel| pixel.0[0])),
            provenance,
        }))
    }

    fn made(
        &self,
        file: &PictureFile,
        segmenter: &dyn Segmenter,
        recipe: Digest,
        session: &Session<'_>,
    ) -> Result<Segmented, Failure> {
        let made = segmenter
            .segmented(&file.decoded()?, session.cancel)
            .map_err(|error| failed(&self.input, error))?;
        let png = encode_grey_png(&grey_from_labels(&made.labels), Compression::Fast);
        session.cancel.check()?;
        let note = json!(made.provenance).to_string();
        session
            .output
            .write_noted_item(&self.output, png, &note, recipe)?;
        Ok(made)
    }

    fn description(&self, labels: &Labels, provenance: &Provenance) -> Value {
        let mut description = json!({
            "file": self.input.display().to_string(),
            "output": self.output.display().to_string(),
            "width": labels.width(),
            "height": labels.height(),
            "crown_pixels": crown_count(labels),
            "trunk_pixels": trunk_count(labels),
            "baseline_y": crown_baseline(labels),
        });
        add(&mut description, provenance_json(provenance));
        description
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
