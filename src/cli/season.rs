//! `boscage season`: tree pictures in another season.

use super::failure::Failure;
use super::input::PictureFile;
use super::items;
use super::library::picture_files;
use super::output::recipe;
use super::season_flags::SeasonFlags;
use super::segmenter::{SegmenterFlags, failed};
use super::session::Session;
use super::{Job, Stages};
use crate::base::Seed;
use crate::raster::{Compression, encode_png};
use crate::segment::Segmenter;
use crate::variation::{Finish, Histogram, Palette, SeasonChoice, Tree};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Put tree pictures into another season
///
/// Leaves turn, fall or bud, and snow falls, on the pixels of the crown only; conifers, palms and such
/// keep theirs unless --evergreen no is given. Pictures keep their size.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage season oak.png --season autumn --season-amount 0.5 --out autumn
  boscage season trees --season winter --snow 0.6 --out winter")]
pub(super) struct Flags {
    /// Pictures of trees, or folders of them
    #[arg(required = true, value_name = "IMAGE|FOLDER")]
    images: Vec<PathBuf>,
    #[command(flatten)]
    season: SeasonFlags,
    /// A picture whose crown gives the leaves' colours
    #[arg(long, value_name = "IMAGE")]
    like: Option<PathBuf>,
    #[command(flatten)]
    segmenter: SegmenterFlags,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("season", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        let segmenter = self.segmenter.checked(session.cancel)?;
        let segmenter = segmenter.as_ref();
        let reason = "say which with --season, or how much snow with --snow";
        let job = self.season.checked()?;
        let job = job.ok_or_else(|| Failure::of("--season", reason))?;
        let files = self.files()?;
        let target = |file: &Path| {
            let stem = file.file_stem().unwrap_or_default().to_string_lossy();
            out.join(format!("{stem}.png"))
        };
        let ours = files.iter().zip(0u64..);
        let ours = ours.filter(|(_, index)| session.shard.contains(*index));
        session.output.check(ours.map(|(file, _)| target(file)))?;
        let like = match &self.like {
            None => None,
            Some(path) => {
                let file = PictureFile::read(path)?;
                let tree = segmented(&file, segmenter, session)?;
                Some((file.digest(), Palette::of(&tree.image, &tree.labels)))
            }
        };
        let (digest, leaves) = match &like {
            None => (None, None),
            Some((digest, palette)) => (Some(*digest), Some(palette.crown())),
        };
        let made = items::made(session, "season", &files, |_, file| {
            let picture = PictureFile::read(file)?;
            let like = digest.as_ref().map_or(&[][..], |digest| digest.bytes());
            let recipe = recipe("season")
                .with(picture.digest().bytes())
                .with(file.file_name().unwrap_or_default().as_encoded_bytes())
                .with(format!("{job:?}").as_bytes())
                .with(segmenter.key().as_bytes())
                .with(like)
                .with(&session.seed.to_le_bytes())
                .finish();
            let path = target(file);
            if !session.output.is_ready(&path, recipe) {
                let png = self.made(&picture, job, leaves, segmenter, session)?;
                session.output.write_item(&path, png, recipe)?;
            }
            Ok(path.display().to_string())
        })?;
        session.print_json(|| {
            let written: Vec<&String> = made.ready.iter().map(|(_, path)| path).collect();
            json!({"outputs": written, "seconds": session.seconds()})
        })
    }
}

impl Flags {
    fn files(&self) -> Result<Vec<PathBuf>, Failure> {
        let mut files = Vec::new();
        for path in &self.images {
            if path.is_dir() {
                files.extend(picture_files(path)?);
            } else {
                files.push(path.clone());
            }
        }
        let mut stems: Vec<_> = files.iter().map(|file| file.file_stem()).collect();
        stems.sort();
        if let Some(pair) = stems.windows(2).find(|pair| pair[0] == pair[1]) {
            let name = pair[0].unwrap_or_default().to_string_lossy().into_owned();
            return Err(Failure::of(name, "two pictures have this name"));
        }
        Ok(files)
    }

    /// The picture in the season, as a file.
    fn made(
        &self,
        picture: &PictureFile,
        job: SeasonChoice,
        like: Option<&Histogram>,
        segmenter: &dyn Segmenter,
        session: &Session<'_>,
    ) -> Result<Vec<u8>, Failure> {
        let mut tree = segmented(picture, segmenter, session)?;
        let name = picture
            .path()
            .file_name()
            .unwrap_or_default()
            .to_string_lossy();
        // Each picture turns in its own way.
        let seed = Seed(session.seed).derive("season", picture.digest().leading_u64());
        let finish = Finish {
            season: Some(job.of_picture(&name)),
            ..Finish::default()
        };
        finish.put(&mut tree, like, seed, session.cancel)?;
        session.cancel.check()?;
        Ok(encode_png(&tree.image, Compression::Fast))
    }
}

/// The tree in `picture`, at its own size.
fn segmented(
    picture: &PictureFile,
    segmenter: &dyn Segmenter,
    session: &Session<'_>,
) -> Result<Tree, Failure> {
    let image = picture.decoded()?;
    let labels = segmenter.segment(&image, session.cancel);
    let labels = labels.map_err(|error| failed(picture.path(), error))?;
    Ok(Tree { image, labels })
}
