//! `boscage recolor`: one picture in the colours of another.

use super::failure::Failure;
use super::input::PictureFile;
use super::output::recipe;
use super::session::Session;
use super::{Job, Stages};
use crate::base::Digest;
use crate::raster::{Compression, Image, Straight, encode_png};
use crate::variation::{Histogram, Transfer};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Give a picture the colours of another
///
/// Matches the histograms of red, green and blue over the pixels that show (alpha above 0). Alpha
/// stays as it is, and so does the colour of clear pixels.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage recolor oak.png --like autumn.png --out oak-autumn.png")]
pub(super) struct Flags {
    /// The picture
    image: PathBuf,
    /// The picture whose colours it gets
    #[arg(long, value_name = "IMAGE")]
    like: PathBuf,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("read", 2.0), ("recolor", 1.0), ("write", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        session.output.check([out])?;
        let stage = session.progress.stage("read", 2);
        let image = PictureFile::read(&self.image)?;
        stage.advance();
        let like = PictureFile::read(&self.like)?;
        stage.advance();
        drop(stage);
        let recipe = recipe("recolor")
            .with(image.digest().bytes())
            .with(like.digest().bytes())
            .finish();
        if !session.output.is_ready(out, recipe) {
            let reference = self.reference(&like.decoded()?)?;
            self.make(session, image.decoded()?, &reference, (out, recipe))?;
        }
        session.print_json(|| {
            json!({
                "file": self.image.display().to_string(),
                "like": self.like.display().to_string(),
                "output": out.display().to_string(),
                "seconds": session.seconds(),
            })
        })
    }
}

impl Flags {
    /// The colours to take.
    fn reference(&self, like: &Image<Straight>) -> Result<Histogram, Failure> {
        let histogram = Histogram::of(like);
        if histogram.pixel_count() == 0 {
            let reason = "no pixel of it shows: there are no colours to take";
            return Err(Failure::of(self.like.display(), reason));
        }
        Ok(histogram)
    }

    fn make(
        &self,
        session: &Session<'_>,
        mut image: Image<Straight>,
        reference: &Histogram,
        (out, recipe): (&Path, Digest),
    ) -> Result<(), Failure> {
        let stage = session.progress.stage("recolor", 1);
        let source = Histogram::of(&image);
        if source.pixel_count() == 0 {
            let warning = format!(
                "{}: no pixel of it shows: nothing changes",
                self.image.display()
            );
            session.progress.warn(&warning);
        }
        Transfer::between(&source, reference).apply(&mut image);
        stage.advance();
        drop(stage);
        let stage = session.progress.stage("write", 1);
        session.cancel.check()?;
        let png = encode_png(&image, Compression::Fast);
        session.cancel.check()?;
        session.output.write_item(out, png, recipe)?;
        stage.advance();
        Ok(())
    }
}
