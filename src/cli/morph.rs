//! `boscage morph`: two trees → the trees between them.

use super::exemplars::{SizeFlag, prepared, with_settings};
use super::failure::Failure;
use super::items::made;
use super::output::recipe;
use super::session::Session;
use super::{Job, Stages};
use crate::base::{Digest, Hasher};
use crate::raster::{Compression, Image, Premultiplied, Straight, encode_png, resized};
use crate::segment::standard;
use crate::sheet::{Cell, contact_sheet};
use crate::variation::{
    Exemplar, ExemplarSettings, Layout, Leaves, Source, WarpPrecision, synthesized,
};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Turn one tree into another, step by step
///
/// Writes frame_0000.png, frame_0001.png …: outline and colours go from A to B in equal steps, both
/// ends included.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage morph oak.png spruce.png --steps 24 --out frames")]
pub(super) struct Flags {
    /// The tree at the beginning
    #[arg(value_name = "A")]
    from: PathBuf,
    /// The tree at the end
    #[arg(value_name = "B")]
    to: PathBuf,
    /// Number of frames
    #[arg(long, default_value_t = 24, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    steps: u32,
    #[command(flatten)]
    size: SizeFlag,
    /// Also write a contact sheet of at most ten of the frames
    #[arg(long, value_name = "FILE.png")]
    sheet: Option<PathBuf>,
}

/// Most frames on the contact sheet.
const MOST_ON_SHEET: u32 = 10;

/// Frames in a row of the contact sheet.
const SHEET_COLUMNS: usize = 5;

/// Side of a frame on the contact sheet, in pixels.
const SHEET_CELL_PX: u32 = 320;

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("prepare", 10.0), ("frames", 88.0), ("sheet", 2.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let folder = session.options.out()?;
        let shard = session.options.shard;
        let frames: Vec<Frame> = (0..self.steps)
            .map(|i| Frame::new(i, self.steps, folder))
            .collect();
        let ours = frames
            .iter()
            .filter(|frame| shard.contains(frame.index.into()));
        // The sheet shows frames of all shards and is made by the first.
        let sheet = self.sheet.as_deref().filter(|_| shard.contains(0));
        let files = ours.map(|frame| frame.file.as_path()).chain(sheet);
        session.output.check(files)?;
        let ends = self.prepared(session)?;
        let made = made(session, "frames", &frames, |_, frame| {
            ends.write(frame, session)
        })?;
        if let Some(path) = sheet {
            let _sheet = session.progress.stage("sheet", 1);
            let png = encode_png(&ends.sheet(self.steps, session)?, Compression::Small);
            session.output.write(path, &png)?;
        }
        session.print_json(|| {
            let frames: Vec<Value> = made.ready.into_iter().map(|(_, frame)| frame).collect();
            let sheet = sheet.map(|path| path.display().to_string());
            json!({"frames": frames, "sheet": sheet, "seconds": session.seconds()})
        })
    }
}

impl Flags {
    fn prepared(&self, session: &Session<'_>) -> Result<Ends, Failure> {
        let stage = session.progress.stage("prepare", 2);
        let settings = self.size.settings();
        let prepare = |path: &Path| {
            let prepared = prepared(path, &settings, standard(), session);
            stage.advance();
            prepared
        };
        let (from, to) = rayon::join(|| prepare(&self.from), || prepare(&self.to));
        let ((from, from_digest), (to, to_digest)) = (from?, to?);
        Ok(Ends {
            names: [
                self.from.display().to_string(),
                self.to.display().to_string(),
            ],
            digests: [from_digest, to_digest],
            settings,
            from,
            to,
        })
    }
}

/// One frame to be made.
struct Frame {
    index: u32,
    /// 0 at the first frame, 1 at the last.
    t: f64,
    file: PathBuf,
}

impl Frame {
    fn new(index: u32, count: u32, folder: &Path) -> Self {
        Self {
            index,
            t: f64::from(index) / f64::from(count - 1),
            file: folder.join(format!("frame_{index:04}.png")),
        }
    }
}

/// The two trees.
struct Ends {
    names: [String; 2],
    digests: [Digest; 2],
    settings: ExemplarSettings,
    from: Exemplar,
    to: Exemplar,
}

impl Ends {
    /// Makes and writes one frame, or keeps the one that is there; says what it is.
    fn write(&self, frame: &Frame, session: &Session<'_>) -> Result<Value, Failure> {
        let layout = self.layout(frame.t)?;
        let recipe = self.recipe(frame.t).finish();
        if !session.output.is_ready(&frame.file, recipe) {
            let image = self.image(&layout, frame.t, session)?;
            let png = encode_png(&image.straight(), Compression::Fast);
            session.cancel.check()?;
            session.output.write_item(&frame.file, png, recipe)?;
        }
        Ok(json!({
            "file": frame.file.display().to_string(),
            "t": frame.t,
            "distortion": layout.distortion,
        }))
    }

    fn recipe(&self, t: f64) -> Hasher {
        with_settings(recipe("morph 2"), &self.settings, standard())
            .with(self.digests[0].bytes())
            .with(self.digests[1].bytes())
            .with(&t.to_le_bytes())
    }

    fn layout(&self, t: f64) -> Result<Layout, Failure> {
        let shapes = [(&self.from.shape, 1.0 - t, 1.0 - t), (&self.to.shape, t, t)];
        let mut layout = Layout::new(&shapes).map_err(|error| {
            Failure::of(format!("{} and {}", self.names[0], self.names[1]), error)
        })?;
        // Pieces of foliage would stand still while the tree moves.
        layout.leaves = Leaves::Stretch;
        Ok(layout)
    }

    fn image(
        &self,
        layout: &Layout,
        t: f64,
        session: &Session<'_>,
    ) -> Result<Image<Premultiplied>, Failure> {
        let source = |exemplar, weight| Source {
            exemplar,
            contour_weight: weight,
            color_weight: weight,
        };
        let sources = [source(&self.from, 1.0 - t), source(&self.to, t)];
        let made = synthesized(
            layout,
            &sources,
            WarpPrecision::Interpolated,
            session.cancel,
        )?;
        Ok(made.image)
    }

    /// The contact sheet: frames evenly spread, both ends included.
    fn sheet(&self, steps: u32, session: &Session<'_>) -> Result<Image<Straight>, Failure> {
        let count = steps.min(MOST_ON_SHEET);
        let mut shown = Vec::new();
        for i in 0..count {
            // The nearest frame, so that the sheet shows what was written.
            let index = (i * (steps - 1) + (count - 1) / 2) / (count - 1);
            let t = f64::from(index) / f64::from(steps - 1);
            let image = self.image(&self.layout(t)?, t, session)?;
            shown.push((t, reduced(&image, SHEET_CELL_PX)));
        }
        let cells: Vec<Cell<'_>> = shown
            .iter()
            .map(|(t, image)| Cell {
                image,
                caption: Some(format!("{:.0} %", 100.0 * t)),
            })
            .collect();
        Ok(contact_sheet(&cells, SHEET_COLUMNS, SHEET_CELL_PX))
    }
}

/// `image`, square, at most `side` pixels wide.
fn reduced(image: &Image<Premultiplied>, side: u32) -> Image<Premultiplied> {
    let side = side.min(image.width());
    resized(image, image.rect(), side, side)
}
