//! `boscage warp`: one picture, bent so that one polygon becomes another.

use super::failure::Failure;
use super::input::PictureFile;
use super::output::recipe;
use super::polygons::PolygonFile;
use super::session::Session;
use super::{Job, Stages};
use crate::base::{Digest, asking_for_memory};
use crate::geometry::Point;
use crate::raster::{Compression, Image, Straight, encode_png};
use crate::variation::{Cage, Warp, WarpPrecision, coordinates, inside_polygons, warped};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Bend a picture so that one polygon becomes another
///
/// Mean value coordinates: the pixels inside the polygon --to take their colours from where their
/// coordinates lead inside the polygon --from; all others are clear. A polygon file is
/// {"points":[[x,y],…]}, or {"polygons":[[[x,y],…],…]} with the outer polygon first.
#[derive(Debug, Args)]
#[command(
    after_help = "Example: boscage warp oak.png --from oak.json --to wind.json --out bent.png"
)]
pub(super) struct Flags {
    /// The picture
    image: PathBuf,
    /// Polygon in the picture
    #[arg(long, value_name = "POLY.json")]
    from: PathBuf,
    /// Where its points go, as many and in the same order
    #[arg(long, value_name = "POLY.json")]
    to: PathBuf,
    /// Size of the result in pixels [default: that of the picture]
    #[arg(long, num_args = 2, value_names = ["W", "H"], value_parser = clap::value_parser!(u32).range(1..=20_000))]
    size: Option<Vec<u32>>,
    /// Evaluate the coordinates in double precision at every pixel; the default may be off by up to
    /// 0.25 pixel
    #[arg(long)]
    exact: bool,
    /// Points whose coordinates in the polygon --to are added to the JSON
    #[arg(long, value_name = "FILE.json")]
    at: Option<PathBuf>,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[("read", 1.0), ("warp", 2.0), ("write", 1.0)]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        if self.at.is_some() && !session.options.json {
            return Err(Failure::of(
                "--at",
                "its coordinates are printed with --json only",
            ));
        }
        if !session.options.shard.contains(0) {
            return session.print_json(|| json!({"output": null, "seconds": session.seconds()}));
        }
        session.output.check([out])?;
        let checked = self.checked(session)?;
        let recipe = self.recipe(&checked);
        if !session.output.is_ready(out, recipe) {
            checked.make(session, out, recipe)?;
        }
        session.print_json(|| checked.description(&self.image, out, session))
    }
}

impl Flags {
    fn checked(&self, session: &Session<'_>) -> Result<Checked, Failure> {
        let stage = session.progress.stage("read", 1);
        let from = PolygonFile::read(&self.from)?;
        let to = PolygonFile::read(&self.to)?;
        let (source, target) = (from.cage()?, to.cage()?);
        let warp = Warp::new(&target, &source, 1)
            .map_err(|error| Failure::of(format!("{} and {}", from.name(), to.name()), error))?;
        let at = self.at.as_deref().map(PolygonFile::read).transpose()?;
        let file = PictureFile::read(&self.image)?;
        let image = file.decoded()?;
        let size = match self.size.as_deref() {
            Some(&[width, height]) => [width, height],
            _ => [image.width(), image.height()],
        };
        check_memory(size)?;
        stage.advance();
        Ok(Checked {
            size,
            precision: match self.exact {
                true => WarpPrecision::Exact,
                false => WarpPrecision::Interpolated,
            },
            digest: file.digest(),
            image,
            from,
            to,
            source,
            target,
            warp,
            at,
        })
    }

    /// What goes into the result.
    fn recipe(&self, checked: &Checked) -> Digest {
        recipe("warp")
            .with(checked.digest.bytes())
            .with(checked.from.digest().bytes())
            .with(checked.to.digest().bytes())
            .with(bytemuck::bytes_of(&checked.size.map(u32::to_le)))
            .with(&[u8::from(self.exact)])
            .finish()
    }
}

/// Fails where the work would be aborted for want of memory.
fn check_memory([width, height]: [u32; 2]) -> Result<(), Failure> {
    /// A mask, two canvases of four bytes, and a PNG file that did not get smaller.
    const BYTES_PER_PIXEL: usize = 13;
    let bytes = width as usize * height as usize * BYTES_PER_PIXEL;
    let mut rehearsal = Vec::<u8>::new();
    let had = asking_for_memory(|| rehearsal.try_reserve_exact(bytes));
    // Kept from the compiler, which may leave out an allocation that nobody looks at.
    std::hint::black_box(&rehearsal);
    had.map_err(|_| {
        let reason = "pixels need more memory than there is";
        Failure::Environment(format!("--size {width} {height}: {reason}"))
    })
}

/// A warp that can be done.
struct Checked {
    image: Image<Straight>,
    digest: Digest,
    from: PolygonFile,
    to: PolygonFile,
    source: Cage,
    target: Cage,
    warp: Warp,
    at: Option<PolygonFile>,
    /// Width and height of the result, pixels.
    size: [u32; 2],
    precision: WarpPrecision,
}

impl Checked {
    fn make(&self, session: &Session<'_>, out: &Path, recipe: Digest) -> Result<(), Failure> {
        let [width, height] = self.size;
        let stage = session.progress.stage("warp", 1);
        let inside = inside_polygons(self.to.polygons(), width, height);
        let image = self.image.premultiplied();
        let warped = warped(&image, &self.warp, &inside, self.precision, session.cancel)?;
        stage.advance();
        drop(stage);
        let stage = session.progress.stage("write", 1);
        let png = encode_png(&warped.straight(), Compression::Fast);
        session.cancel.check()?;
        session.output.write_item(out, png, recipe)?;
        stage.advance();
        Ok(())
    }

    fn description(&self, file: &Path, out: &Path, session: &Session<'_>) -> Value {
        let mut answer = json!({
            "file": file.display().to_string(),
            "output": out.display().to_string(),
            "size": self.size,
            "seconds": session.seconds(),
        });
        if let Some(at) = &self.at {
            let weights: Vec<Vec<f64>> = at
                .points()
                .map(|point| coordinates(&self.target, point))
                .collect();
            let mapped = weights.iter().map(|weights| {
                let sources = weights.iter().zip(self.source.points());
                let point: Point = sources.map(|(weight, source)| *source * *weight).sum();
                <[f64; 2]>::from(point)
            });
            answer["mapped"] = mapped.map(|point: [f64; 2]| json!(point)).collect();
            answer["coordinates"] = json!(weights);
        }
        answer
    }
}
