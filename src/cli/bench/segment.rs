//! How well segmenters label a folder of pictures that a person has labelled.
//!
//! For each picture and segmenter: the overlap (intersection over union) of crown and of trunk with the
//! person's, how far the pins are off that follow from the labels, who spoke, how sure, and how long it
//! took. Pins are compared where alpha gives both the same outline.

use super::super::failure::Failure;
use super::super::segmenter::failed;
use super::super::session::Session;
use super::row::{Row, measured};
use crate::base::{Cancel, Progress, read_limited};
use crate::branches::samples;
use crate::geometry::Point;
use crate::raster::{Image, ReadLimits, Straight, read_image_from_memory};
use crate::segment::{
    Classical, Label, Labels, Learned, Provenance, Runtime, Segmented, Segmenter, labels_from_grey,
    standard,
};
use crate::variation::{ExemplarSettings, Outlined, normalized};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Endings of pictures that have labels.
const ENDINGS: [&str; 4] = ["png", "jpg", "jpeg", "webp"];

/// What the name of a label picture ends in.
const LABELS: &str = ".labels.png";

/// Pins off by more than this part of the tree's height are wrong.
const PINS_TOLERANCE: f64 = 0.03;

/// Times the segmenters on a picture of 1,024 × 1,024 pixels.
pub(super) fn rows(cancel: &Cancel) -> Result<Vec<Row>, Failure> {
    let Some(sample) = samples().first() else {
        return Ok(Vec::new());
    };
    let picture = read_image_from_memory(
        sample.bundled(),
        Path::new(sample.name()),
        ReadLimits::default(),
    )?;
    let side = picture.width().min(picture.height());
    let picture = picture.cropped(0, picture.height() - side, side, side);
    // Before a grey sky, as in a photograph: the network looks twice.
    let grey = Straight([168, 176, 186, 255]);
    let photograph = picture.map(|pixel| pixel.over(grey));
    let learned = Learned::built_in().map_err(|error| Failure::of("the model built in", error))?;
    let work = |segmenter: &dyn Segmenter, picture: &Image<Straight>| {
        segmenter.segment(picture, cancel).map(drop)
    };
    let is_native = Runtime::of_process().is_ok_and(Runtime::is_native);
    let target = if is_native { 200.0 } else { 500.0 };
    Ok(vec![
        measured("segment, learned", cancel, || work(&learned, &picture))?.target(target),
        measured("segment, learned, no alpha", cancel, || {
            work(&learned, &photograph)
        })?
        .target(target),
        measured("segment, classical", cancel, || work(&Classical, &picture))?,
    ])
}

/// A picture and what a person says of it.
struct Labelled {
    name: String,
    picture: PathBuf,
    labels: PathBuf,
}

/// The labelled pictures of `folder`: beside their labels, or in folders beside the folder `labels`.
fn labelled(folder: &Path) -> Result<Vec<Labelled>, Failure> {
    let apart = folder.join("labels");
    let mut pictures = BTreeMap::new();
    for place in [folder, &folder.join("billboards"), &folder.join("photos")] {
        if !place.is_dir() {
            continue;
        }
        let failed = |error: std::io::Error| Failure::of(place.display(), error);
        for entry in std::fs::read_dir(place).map_err(failed)? {
            let path = entry.map_err(failed)?.path();
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            let ending = path.extension().unwrap_or_default().to_string_lossy();
            if !ENDINGS.contains(&ending.to_lowercase().as_str()) {
                continue;
            }
            let name = format!("{stem}{LABELS}");
            let mut places = [place.join(&name), apart.join(&name)].into_iter();
            if let Some(labels) = places.find(|labels| labels.is_file()) {
                pictures.insert(stem.into_owned(), (path, labels));
            }
        }
    }
    if pictures.is_empty() {
        let reason = "holds no NAME.png or NAME.jpg with a NAME.labels.png";
        return Err(Failure::of(folder.display(), reason));
    }
    let all = pictures.into_iter();
    Ok(all
        .map(|(name, (picture, labels))| Labelled {
            name,
            picture,
            labels,
        })
        .collect())
}

/// How a segmenter did on a picture.
struct Outcome {
    crown: f64,
    /// `None` where neither sees a trunk.
    trunk: Option<f64>,
    /// Part of the tree's height.
    pins: Option<f64>,
    provenance: Provenance,
    seconds: f64,
}

/// All outcomes on a picture, by the names of the segmenters.
struct Line {
    name: String,
    has_alpha: bool,
    outcomes: Vec<Outcome>,
}

/// The table of `folder`, printed.
pub(super) fn table(
    folder: &Path,
    own: Option<&dyn Segmenter>,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let learned = Learned::built_in().map_err(|error| Failure::of("the model built in", error))?;
    let mut segmenters: Vec<(&str, &dyn Segmenter)> = vec![
        ("auto", standard()),
        ("learned", &learned),
        ("classical", &Classical),
    ];
    if let Some(own) = own {
        segmenters = vec![("own", own), ("classical", &Classical)];
    }
    let pictures = labelled(folder)?;
    let stage = session.progress.stage("bench", pictures.len() as u64);
    let mut lines = Vec::new();
    for labelled in &pictures {
        lines.push(line(labelled, &segmenters, session.cancel)?);
        stage.advance();
    }
    drop(stage);
    let names: Vec<&str> = segmenters.iter().map(|(name, _)| *name).collect();
    if session.options.json {
        return session.print_json(|| json_of(&lines, &names));
    }
    use std::io::Write as _;
    write!(std::io::stdout(), "{}", text_of(&lines, &names))
        .map_err(|error| Failure::Environment(format!("stdout: cannot be written: {error}")))
}

fn line(
    labelled: &Labelled,
    segmenters: &[(&str, &dyn Segmenter)],
    cancel: &Cancel,
) -> Result<Line, Failure> {
    let picture = read(&labelled.picture)?;
    let truth = labels_from_grey(&read(&labelled.labels)?.map(|pixel| pixel.0[0]));
    if (truth.width(), truth.height()) != (picture.width(), picture.height()) {
        let reason = "has another size than the picture it belongs to";
        return Err(Failure::of(labelled.labels.display(), reason));
    }
    let has_alpha = picture.pixels().iter().any(|pixel| pixel.alpha() < 128);
    let mut outcomes = Vec::new();
    for (_, segmenter) in segmenters {
        let begin = Instant::now();
        let found = segmenter
            .segmented(&picture, cancel)
            .map_err(|error| failed(&labelled.picture, error))?;
        let seconds = begin.elapsed().as_secs_f64();
        let Segmented { labels, provenance } = found;
        outcomes.push(Outcome {
            crown: overlap(&labels, &truth, Label::Crown).unwrap_or(1.0),
            trunk: overlap(&labels, &truth, Label::Trunk),
            pins: has_alpha
                .then(|| pins_error(&picture, &labels, &truth))
                .flatten(),
            provenance,
            seconds,
        });
    }
    Ok(Line {
        name: labelled.name.clone(),
        has_alpha,
        outcomes,
    })
}

fn read(path: &Path) -> Result<Image<Straight>, Failure> {
    let limits = ReadLimits::default();
    let bytes = read_limited(path, limits.file_bytes)?;
    Ok(read_image_from_memory(&bytes, path, limits)?)
}

/// Intersection over union of what both call `class`; `None` where neither does.
fn overlap(ours: &Labels, truth: &Labels, class: Label) -> Option<f64> {
    let (mut both, mut either) = (0u64, 0u64);
    for (ours, truth) in ours.pixels().iter().zip(truth.pixels()) {
        let (ours, truth) = (*ours == class, *truth == class);
        both += u64::from(ours && truth);
        either += u64::from(ours || truth);
    }
    (either > 0).then(|| both as f64 / either as f64)
}

/// How far the pins of `ours` are off those of `truth`, as part of the tree's height: the worst of foot
/// and columns of the trunk's sides.
fn pins_error(picture: &Image<Straight>, ours: &Labels, truth: &Labels) -> Option<f64> {
    let settings = ExemplarSettings::default();
    let normalized = normalized(picture, settings.size, settings.threshold).ok()?;
    let placement = normalized.placement;
    let outlined = Outlined::new(&normalized, Progress::silent());
    let pins = |labels: &Labels| {
        let (pins, _) = outlined.pins(&placement.placed(labels, Label::Background));
        [pins.bottom, pins.left, pins.right].map(|index| outlined.longest[index])
    };
    let ([bottom, left, right], expected) = (pins(ours), pins(truth));
    let height = f64::from(placement.crop.height) * placement.scale;
    let aside = |one: Point, other: Point| (one.x - other.x).abs();
    let errors = [
        bottom.distance(expected[0]),
        aside(left, expected[1]),
        aside(right, expected[2]),
    ];
    Some(errors.into_iter().fold(0.0, f64::max) / height)
}

/// The means of a segmenter over some pictures.
struct Summary {
    pictures: usize,
    crown: f64,
    /// Of the pictures where either sees a trunk.
    trunk: f64,
    /// Share of the pictures whose pins are right.
    pins: Option<f64>,
    seconds: f64,
}

impl Summary {
    fn of(outcomes: &[&Outcome]) -> Self {
        let mean = |values: Vec<f64>| {
            let count = values.len().max(1) as f64;
            values.into_iter().sum::<f64>() / count
        };
        let pins: Vec<f64> = outcomes
            .iter()
            .filter_map(|outcome| outcome.pins)
            .map(|error| if error <= PINS_TOLERANCE { 1.0 } else { 0.0 })
            .collect();
        Self {
            pictures: outcomes.len(),
            crown: mean(outcomes.iter().map(|outcome| outcome.crown).collect()),
            trunk: mean(
                outcomes
                    .iter()
                    .filter_map(|outcome| outcome.trunk)
                    .collect(),
            ),
            pins: (!pins.is_empty()).then(|| mean(pins)),
            seconds: mean(outcomes.iter().map(|outcome| outcome.seconds).collect()),
        }
    }

    fn mean(&self) -> f64 {
        (self.crown + self.trunk) / 2.0
    }
}

/// The groups of pictures that are summed up, and whether a picture belongs.
const GROUPS: [(&str, bool); 2] = [("with alpha", true), ("photographs", false)];

/// Summaries of segmenter number `index`, for each group that has pictures.
fn summaries(lines: &[Line], index: usize) -> Vec<(&'static str, Summary)> {
    let group = |(title, has_alpha): (&'static str, bool)| {
        let own = lines.iter().filter(|line| line.has_alpha == has_alpha);
        let outcomes: Vec<&Outcome> = own.map(|line| &line.outcomes[index]).collect();
        (!outcomes.is_empty()).then(|| (title, Summary::of(&outcomes)))
    };
    GROUPS.into_iter().filter_map(group).collect()
}

fn json_of(lines: &[Line], names: &[&str]) -> Value {
    let outcome = |outcome: &Outcome| {
        json!({
            "crown_iou": outcome.crown,
            "trunk_iou": outcome.trunk,
            "pins_error": outcome.pins,
            "source": outcome.provenance.source,
            "confidence": outcome.provenance.confidence,
            "seconds": outcome.seconds,
        })
    };
    let by_name = |values: Vec<Value>| -> Value {
        let names = names.iter().map(|name| (*name).to_owned());
        names.zip(values).collect::<serde_json::Map<_, _>>().into()
    };
    let images = lines.iter().map(|line| {
        json!({
            "image": line.name,
            "has_alpha": line.has_alpha,
            "segmenters": by_name(line.outcomes.iter().map(outcome).collect()),
        })
    });
    let summed = (0..names.len()).map(|index| {
        let groups = summaries(lines, index).into_iter();
        let groups = groups.map(|(title, own)| {
            let summary = json!({
                "pictures": own.pictures, "crown_iou": own.crown, "trunk_iou": own.trunk,
                "mean_iou": own.mean(), "pins_right": own.pins, "seconds": own.seconds,
            });
            (title.to_owned(), summary)
        });
        groups.collect::<serde_json::Map<_, _>>().into()
    });
    json!({"images": images.collect::<Vec<_>>(), "means": by_name(summed.collect())})
}

fn text_of(lines: &[Line], names: &[&str]) -> String {
    let number = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "-".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let mut text = String::new();
    // Writing to a string does not fail.
    for (index, name) in names.iter().enumerate() {
        let _ = writeln!(
            text,
            "{name:<34} {:>6} {:>6} {:>6}  {:<9} {:>10} {:>7}",
            "crown", "trunk", "pins %", "source", "confidence", "s"
        );
        for line in lines {
            let own = &line.outcomes[index];
            let _ = writeln!(
                text,
                "{:<34} {:>6.3} {:>6} {:>6}  {:<9} {:>10} {:>7.3}",
                line.name,
                own.crown,
                number(own.trunk, 3),
                number(own.pins.map(|error| 100.0 * error), 1),
                own.provenance.source.name(),
                number(own.provenance.confidence.map(f64::from), 2),
                own.seconds,
            );
        }
        for (title, own) in summaries(lines, index) {
            let pins = own.pins.map_or_else(String::new, |share| {
                format!(", pins right {:.0} %", 100.0 * share)
            });
            let _ = writeln!(
                text,
                "mean of {} {title}: crown {:.3}, trunk {:.3}, both {:.3}{pins}, {:.3} s",
                own.pictures,
                own.crown,
                own.trunk,
                own.mean(),
                own.seconds,
            );
        }
        text.push('\n');
    }
    text
}
