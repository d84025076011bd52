//! `boscage inspect`: one picture → all that is found on it.

use super::exemplars::{SettingsFlags, refused, with_settings};
use super::failure::Failure;
use super::input::PictureFile;
use super::output::recipe;
use super::segmenter::{SegmenterFlags, add, failed, provenance_json};
use super::session::Session;
use super::{Job, Stages};
use crate::base::Digest;
use crate::contour::Pins;
use crate::geometry::Point;
use crate::raster::{Compression, Image, Straight, encode_grey_png, encode_png};
use crate::segment::{
    Label, Labels, Provenance, Segmented, Segmenter, crown_count, grey_from_labels,
    labels_from_grey, trunk_count,
};
use crate::sheet::{Overlay, overlay};
use crate::variation::{ExemplarSettings, Normalized, Outlined, Shape, normalized};
use clap::Args;
use serde_json::{Value, json};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Show what is found on a picture: outline, crown, trunk, pins
///
/// Coordinates are pixels of the normalised picture: the tree cropped, brought to a square of SIZE
/// pixels and stood on its bottom edge.
#[derive(Debug, Args)]
#[command(after_help = "Example: boscage inspect oak.png --dump looks --json > oak.json")]
pub(super) struct Flags {
    /// A picture of a tree
    #[arg(value_name = "IMAGE")]
    image: PathBuf,
    /// Write normalized.png, mask.png, labels.png and overlay.png into this folder
    #[arg(long, value_name = "DIR")]
    dump: Option<PathBuf>,
    #[command(flatten)]
    settings: SettingsFlags,
    #[command(flatten)]
    segmenter: SegmenterFlags,
    /// Labels to use instead of a segmenter's: grey 0 background, 128 trunk, 255 crown, of the size
    /// of the picture or of the normalised one
    #[arg(long, value_name = "FILE.png")]
    labels: Option<PathBuf>,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("read", 2.0),
            ("normalize", 2.0),
            ("segment", 3.0),
            ("contours", 1.0),
            ("pins", 0.1),
            ("resample", 1.0),
            ("simplify", 1.0),
            ("dump", 5.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let settings = self.settings.checked()?;
        let segmenter = self.segmenter.checked(session.cancel)?;
        let segmenter = segmenter.as_ref();
        let files = self.dump.as_deref().map(DumpFiles::within);
        if let Some(files) = &files {
            session.output.check(files.all())?;
        }
        let reading = session.progress.stage("read", 1);
        let inputs = Inputs::read(self)?;
        drop(reading);
        let found = self.found(&inputs, &settings, segmenter, session)?;
        if let Some(files) = &files {
            let _dumping = session.progress.stage("dump", 1);
            let recipe = with_settings(recipe("inspect"), &settings, segmenter)
                .with(inputs.digest.bytes())
                .with(&inputs.labels_digest())
                .finish();
            found.dump(files, recipe, session)?;
        }
        if !session.options.json {
            return found.print_summary(&self.image, &inputs.picture);
        }
        session.print_json(|| found.description(&inputs.picture, session))
    }
}

/// The files given, decoded.
struct Inputs {
    picture: Image<Straight>,
    digest: Digest,
    labels: Option<(Labels, Digest)>,
}

impl Inputs {
    fn read(flags: &Flags) -> Result<Self, Failure> {
        let file = PictureFile::read(&flags.image)?;
        let labels = match &flags.labels {
            None => None,
            Some(path) => {
                let file = PictureFile::read(path)?;
                let grey = file.decoded()?.map(|pixel| pixel.0[0]);
                Some((labels_from_grey(&grey), file.digest()))
            }
        };
        Ok(Self {
            picture: file.decoded()?,
            digest: file.digest(),
            labels,
        })
    }

    fn labels_digest(&self) -> Vec<u8> {
        let labels = self.labels.iter();
        labels.flat_map(|(_, digest)| *digest.bytes()).collect()
    }
}

impl Flags {
    /// All steps of preparation, kept.
    fn found(
        &self,
        inputs: &Inputs,
        settings: &ExemplarSettings,
        segmenter: &dyn Segmenter,
        session: &Session<'_>,
    ) -> Result<Found, Failure> {
        let stage = session.progress.stage("normalize", 1);
        let normalized = normalized(&inputs.picture, settings.size, settings.threshold)
            .map_err(|error| refused(&self.image, error))?;
        drop(stage);
        session.cancel.check()?;
        let stage = session.progress.stage("segment", 1);
        let (provenance, labels) = match &inputs.labels {
            Some((labels, _)) => (None, self.placed(labels, &inputs.picture, &normalized)?),
            None => {
                let image = normalized.image.straight();
                let Segmented { labels, provenance } = segmenter
                    .segmented(&image, session.cancel)
                    .map_err(|error| failed(&self.image, error))?;
                (Some(provenance), labels)
            }
        };
        drop(stage);
        session.cancel.check()?;
        let outlined = Outlined::new(&normalized, session.progress);
        let shape = outlined.shape(&normalized.image, &labels, settings, session.progress);
        let (pins, _) = outlined.pins(&labels);
        Ok(Found {
            normalized,
            provenance,
            labels,
            outlined,
            pins,
            shape,
        })
    }

    /// The user's labels in the normalised frame.
    fn placed(
        &self,
        labels: &Labels,
        picture: &Image<Straight>,
        normalized: &Normalized,
    ) -> Result<Labels, Failure> {
        let size = normalized.placement.size;
        let sides = (labels.width(), labels.height());
        if sides == (picture.width(), picture.height()) {
            return Ok(normalized.placement.placed(labels, Label::Background));
        }
        if sides == (size, size) {
            return Ok(labels.clone());
        }
        let file = self.labels.as_deref().unwrap_or(Path::new("--labels"));
        let reason = format!(
            "{}×{} labels fit neither the picture of {}×{} nor the normalised one of {size}×{size}",
            sides.0,
            sides.1,
            picture.width(),
            picture.height()
        );
        Err(Failure::of(file.display(), reason))
    }
}

/// All that is found on a picture.
struct Found {
    normalized: Normalized,
    /// Who made the labels; `None`: the user.
    provenance: Option<Provenance>,
    labels: Labels,
    outlined: Outlined,
    /// Pins as indices into the longest border.
    pins: Pins,
    shape: Shape,
}

impl Found {
    /// The longest border, beginning at pin B.
    fn longest_from_foot(&self) -> Vec<Point> {
        let mut points = self.outlined.longest.clone();
        points.rotate_left(self.pins.bottom);
        points
    }

    fn description(&self, picture: &Image<Straight>, session: &Session<'_>) -> Value {
        let placement = &self.normalized.placement;
        let crop = placement.crop;
        let count = self.outlined.outlines.all.len();
        let exterior = self.outlined.outlines.exterior().count();
        let pin = |index: usize| pair(self.outlined.longest[index]);
        json!({
            "image": {"width": picture.width(), "height": picture.height()},
            "normalized": {
                "size": placement.size,
                "crop": [crop.x, crop.y, crop.width, crop.height],
                "scale": placement.scale,
                "offset": pair(placement.offset),
            },
            "contours": {
                "count": count,
                "exterior": exterior,
                "interior": count - exterior,
                "longest": pairs(&self.longest_from_foot()),
            },
            "segmentation": self.segmentation(),
            "pins": {
                "B": pin(self.pins.bottom),
                "L": pin(self.pins.left),
                "R": pin(self.pins.right),
            },
            "resampled": pairs(&self.shape.contour.points),
            "simplified": pairs(&self.shape.cage.points),
            "density": self.shape.density,
            "seconds": session.seconds(),
        })
    }

    fn segmentation(&self) -> Value {
        let mut found = json!({
            "crown_pixels": crown_count(&self.labels),
            "trunk_pixels": trunk_count(&self.labels),
            "baseline_y": self.shape.baseline_y,
        });
        let told = match &self.provenance {
            Some(provenance) => provenance_json(provenance),
            None => json!({"source": "labels"}),
        };
        add(&mut found, told);
        found
    }

    /// A few lines for a person.
    fn print_summary(&self, path: &Path, picture: &Image<Straight>) -> Result<(), Failure> {
        let crop = self.normalized.placement.crop;
        let all = self.outlined.outlines.all.len();
        let exterior = self.outlined.outlines.exterior().count();
        let trunk = match self.shape.baseline_y {
            Some(y) if self.pins.has_trunk() => format!("below row {y}"),
            _ => "none that shows".to_owned(),
        };
        let text = format!(
            "{}: {}×{}\n  tree     {}×{} at ({}, {}), {:.0} % of its outline opaque\n  \
             contours {all}, {exterior} of them exterior; the longest has {} points\n  \
             trunk    {trunk}\n",
            crate::base::one_line(&path.display().to_string()),
            picture.width(),
            picture.height(),
            crop.width,
            crop.height,
            crop.x,
            crop.y,
            100.0 * self.shape.density,
            self.outlined.longest.len(),
        );
        write!(std::io::stdout(), "{text}")
            .map_err(|error| Failure::Environment(format!("stdout: cannot be written: {error}")))
    }

    fn dump(
        &self,
        files: &DumpFiles,
        recipe: Digest,
        session: &Session<'_>,
    ) -> Result<(), Failure> {
        let grey = |image: &Image<u8>| encode_grey_png(image, Compression::Fast);
        let color = |image: &Image<Straight>| encode_png(image, Compression::Fast);
        let write = |path: &Path, png: &dyn Fn() -> Vec<u8>| {
            session.cancel.check()?;
            if session.output.is_ready(path, recipe) {
                return Ok(());
            }
            session.output.write_item(path, png(), recipe)
        };
        write(&files.normalized, &|| {
            color(&self.normalized.image.straight())
        })?;
        write(&files.mask, &|| grey(&self.outlined.mask.grey()))?;
        write(&files.labels, &|| grey(&grey_from_labels(&self.labels)))?;
        write(&files.overlay, &|| {
            color(&overlay(&Overlay {
                image: &self.normalized.image,
                borders: &self.outlined.outlines,
                longest: &self.outlined.longest,
                pins: self.pins,
                contour: &self.shape.contour.points,
                cage: &self.shape.cage.points,
                baseline_y: self.shape.baseline_y,
            }))
        })
    }
}

/// What `--dump` writes.
struct DumpFiles {
    normalized: PathBuf,
    mask: PathBuf,
    labels: PathBuf,
    overlay: PathBuf,
}

impl DumpFiles {
    fn within(folder: &Path) -> Self {
        Self {
            normalized: folder.join("normalized.png"),
            mask: folder.join("mask.png"),
            labels: folder.join("labels.png"),
            overlay: folder.join("overlay.png"),
        }
    }

    fn all(&self) -> [&Path; 4] {
        [&self.normalized, &self.mask, &self.labels, &self.overlay]
    }
}

fn pair(point: Point) -> [f64; 2] {
    point.into()
}

fn pairs(points: &[Point]) -> Vec<[f64; 2]> {
    points.iter().copied().map(pair).collect()
}
