//! `library.json`: what each tree of a library was made of, enough to make it again.

use super::failure::Failure;
use crate::base::read_limited;
use crate::contour::{HandPins, PinnedContour};
use crate::geometry::Point;
use crate::segment::{Classical, Segmenter, Source};
use crate::variation::{
    Decided, Distortion, ExemplarSettings, Finish, HslShift, IndividualSettings, Library,
    Reshaping, SeasonChoice, SeasonSettings,
};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Version of the format; readers refuse others.
const VERSION: u32 = 1;

/// Largest file that is read back: a million trees.
const LARGEST_BYTES: u64 = 1 << 30;

/// A whole library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct LibraryRecord {
    pub(crate) format: String,
    pub(crate) version: u32,
    pub(crate) generator: String,
    /// Folder of the exemplars, as it was given.
    pub(crate) library: String,
    /// How exemplars were prepared.
    pub(crate) settings: ExemplarSettings,
    /// What told crown from trunk.
    #[serde(default)]
    pub(crate) segmenter: SegmenterRecord,
    pub(crate) trees: Vec<TreeRecord>,
}

/// What told crown from trunk in all pictures.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SegmenterRecord {
    /// See [`Segmenter::name`].
    pub(crate) name: String,
    /// Digest of the network that it could ask (see [`Segmenter::model`]).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) model: Option<String>,
}

impl SegmenterRecord {
    /// That of `segmenter`.
    pub(crate) fn of(segmenter: &dyn Segmenter) -> Self {
        Self {
            name: segmenter.name().to_owned(),
            model: segmenter.model().map(|digest| digest.to_string()),
        }
    }
}

/// Records that say nothing of it are older than networks.
impl Default for SegmenterRecord {
    fn default() -> Self {
        Self::of(&Classical)
    }
}

/// What is said of a record that no command writes.
pub(super) const OUT_OF_RANGE: &str = "a number of it is out of its range";

/// One tree.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TreeRecord {
    /// The picture, relative to `library.json`.
    pub(crate) file: String,
    /// The seed of this tree's random decisions.
    pub(crate) seed: u64,
    pub(crate) exemplars: Vec<ExemplarRecord>,
    /// Shares of the outline, in the order of the exemplars.
    pub(crate) contour_weights: Vec<f64>,
    /// Shares of the colours, in the order of the exemplars.
    pub(crate) color_weights: Vec<f64>,
    /// The picture whose colours the tree was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) like: Option<ExemplarRecord>,
    /// Whether its crown is of fronds about one heart, as that of a palm.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub(crate) has_fronds: bool,
    /// How its outline was moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) reshaping: Option<Reshaping>,
    /// How it was made another individual; its pins are told as they then are.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) individual: Option<IndividualSettings>,
    /// How its colours were moved.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) shift: Option<HslShift>,
    /// The season it was put into.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) season: Option<SeasonRecord>,
    /// The trees that it was bred from, as they were named.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub(crate) parents: Vec<String>,
    /// Its crown in three dimensions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) crown: Option<TreeCrownRecord>,
    pub(crate) distortion: Distortion,
    pub(crate) pins: PinsRecord,
    /// Width and height of the picture, in pixels.
    pub(crate) size: [u32; 2],
}

/// An exemplar that a tree was made of.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct ExemplarRecord {
    /// Its file: a name in the library's folder, or the path of the target as given.
    pub(crate) file: String,
    /// Digest of the file's content, BLAKE3.
    pub(crate) digest: String,
    /// Who told its crown from its trunk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) labels: Option<Source>,
    /// The pins that were set in it by hand.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) pins: Option<HandPins>,
}

/// The crown that a tree's picture was inflated to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct TreeCrownRecord {
    /// Its folder, relative to `library.json`.
    pub(crate) folder: String,
    /// Texels along a face of its cubemaps.
    pub(crate) size: u32,
}

/// The season that a tree was put into.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct SeasonRecord {
    #[serde(flatten)]
    pub(crate) settings: SeasonSettings,
    /// Whether it keeps its leaves; where it is not told, its looks decide.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(crate) evergreen: Option<bool>,
}

impl From<SeasonChoice> for SeasonRecord {
    fn from(choice: SeasonChoice) -> Self {
        Self {
            settings: choice.settings,
            evergreen: choice.evergreen,
        }
    }
}

impl From<SeasonRecord> for SeasonChoice {
    fn from(record: SeasonRecord) -> Self {
        Self {
            settings: record.settings,
            evergreen: record.evergreen,
        }
    }
}

/// Foot and trunk tops in pixels of the picture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct PinsRecord {
    #[serde(rename = "B")]
    pub(crate) bottom: [f64; 2],
    #[serde(rename = "L")]
    pub(crate) left: [f64; 2],
    #[serde(rename = "R")]
    pub(crate) right: [f64; 2],
}

impl PinsRecord {
    pub(crate) fn of(contour: &PinnedContour) -> Self {
        let pair = |point: Point| [point.x, point.y];
        Self {
            bottom: pair(contour.bottom()),
            left: pair(contour.left()),
            right: pair(contour.right()),
        }
    }
}

impl TreeRecord {
    /// The record of the tree `name`.
    pub(crate) fn new(
        name: &str,
        Decided { genome, chosen }: &Decided,
        library: &Library<'_>,
        target: Option<usize>,
        like: Option<&ExemplarRecord>,
    ) -> Self {
        let exemplar = |index: usize| {
            let entry = &library.entries()[index];
            let file = if target == Some(index) {
                entry.path.display().to_string()
            } else {
                entry.file_name()
            };
            ExemplarRecord {
                file,
                digest: entry.digest.to_string(),
                labels: Some(entry.provenance.source),
                pins: entry.pins,
            }
        };
        let Finish {
            has_fronds,
            reshaping,
            individual,
            shift,
            season,
        } = genome.finish;
        let record = Self {
            file: format!("{name}.png"),
            seed: genome.seed.0,
            exemplars: chosen
                .parts
                .iter()
                .map(|part| exemplar(part.exemplar))
                .collect(),
            contour_weights: chosen
                .parts
                .iter()
                .map(|part| part.contour_weight)
                .collect(),
            color_weights: chosen.parts.iter().map(|part| part.color_weight).collect(),
            like: like.cloned(),
            has_fronds,
            reshaping,
            individual,
            shift,
            season: season.map(SeasonRecord::from),
            parents: Vec::new(),
            crown: None,
            distortion: chosen.layout.distortion,
            pins: PinsRecord::of(&chosen.layout.contour),
            size: [chosen.layout.size; 2],
        };
        match individual {
            Some(individual) if individual.mirrored => record.with_pins_mirrored(),
            _ => record,
        }
    }

    fn with_pins_mirrored(self) -> Self {
        let last = f64::from(self.size[0]) - 1.0;
        let flipped = |[x, y]: [f64; 2]| [last - x, y];
        let pins = PinsRecord {
            bottom: flipped(self.pins.bottom),
            left: flipped(self.pins.right),
            right: flipped(self.pins.left),
        };
        Self { pins, ..self }
    }

    /// What becomes of the tree once it is mixed.
    pub(crate) fn finish(&self) -> Finish {
        Finish {
            has_fronds: self.has_fronds,
            reshaping: self.reshaping,
            individual: self.individual,
            shift: self.shift,
            season: self.season.map(SeasonChoice::from),
        }
    }

    /// Whether there is one share of outline and colours for each exemplar, of sum 1 each.
    pub(crate) fn weights_are_convex(&self) -> bool {
        let is_convex = |weights: &Vec<f64>| {
            let sum: f64 = weights.iter().sum();
            weights.len() == self.exemplars.len()
                && weights.iter().all(|weight| (0.0..=1.0).contains(weight))
                && (sum - 1.0).abs() < 1e-6
        };
        is_convex(&self.contour_weights) && is_convex(&self.color_weights)
    }

    /// The file's name without its ending.
    pub(crate) fn name(&self) -> &str {
        self.file.strip_suffix(".png").unwrap_or(&self.file)
    }

    /// Whether the tree's files lie in one folder: a record that others wrote may name any path.
    pub(crate) fn is_in_folder(&self) -> bool {
        let name = self.name();
        !name.is_empty() && !name.starts_with('.') && !name.contains(['/', '\\', ':', '\0'])
    }

    /// The record as JSON, on one line.
    pub(crate) fn to_json(&self) -> String {
        json_of(serde_json::to_string(self))
    }
}

impl LibraryRecord {
    pub(crate) fn new(folder: &Path, library: &Library<'_>, trees: Vec<TreeRecord>) -> Self {
        Self {
            format: "boscage-library".to_owned(),
            version: VERSION,
            generator: concat!("boscage ", env!("CARGO_PKG_VERSION")).to_owned(),
            library: folder.display().to_string(),
            settings: *library.settings(),
            segmenter: SegmenterRecord::of(library.segmenter()),
            trees,
        }
    }

    /// The record as JSON.
    pub(crate) fn to_json(&self) -> String {
        json_of(serde_json::to_string_pretty(self)) + "\n"
    }

    /// Reads a record back.
    ///
    /// # Errors
    /// [`Failure::BadInput`] when the file is not such a record.
    pub(crate) fn read(path: &Path) -> Result<Self, Failure> {
        let bytes = read_limited(path, LARGEST_BYTES)?;
        Self::of_bytes(&bytes).map_err(|reason| Failure::of(path.display(), reason))
    }

    /// The record in the content of its file; why there is none, in one line.
    pub(crate) fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        let record: Self = serde_json::from_slice(bytes)
            .map_err(|error| format!("not a library record: {error}"))?;
        if record.format != "boscage-library" || record.version != VERSION {
            let found = format!("{} version {}", record.format, record.version);
            return Err(format!("{found} is not known to this version"));
        }
        if let Some(complaint) = record.settings.complaint() {
            return Err(format!("settings: {complaint}"));
        }
        Ok(record)
    }
}

fn json_of(written: serde_json::Result<String>) -> String {
    written.unwrap_or_else(|_| unreachable!("records hold numbers and text only"))
}
