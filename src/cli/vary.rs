//! `boscage vary`: a library of tree pictures → new trees.

use super::failure::Failure;
use super::library::{CacheFlags, picture_files, pictures};
use super::season_flags::SeasonFlags;
use super::segmenter::SegmenterFlags;
use super::session::Session;
use super::vary_flags::{ColorsFlag, WeightRange};
use super::vary_parents::AspectName;
use super::{Job, Stages};
use crate::batch::vary::{MapName, Trees, Vary};
use crate::variation::{ChoiceSettings, ExemplarSettings};
use clap::Args;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Make new trees from a library of tree pictures
///
/// Writes tree_0000.png … and library.json, which says of each tree what it was made of. Pictures
/// that cannot be used are warned of and left out. Pairs of trees that would be distorted are not
/// mixed unless --any-pair is given.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  boscage vary --library trees --count 20 --out new --sheet new/sheet.png
  boscage vary --library trees --target oak.png --strength 0.5 --count 8 --out oaks
  boscage vary --library trees --season autumn --season-amount 0.5 --count 20 --out autumn
  boscage vary --library trees --count 100 --crowns --out new
  boscage vary --recipe new/library.json#tree_0003 --out again
  boscage vary --parents new/library.json#tree_0003 new/library.json#tree_0007 \\
    --library trees --lock contour --count 12 --out next")]
pub(super) struct Flags {
    /// Folder of RGBA tree pictures
    #[arg(long, required_unless_present_any = ["recipe", "parents"], value_name = "DIR")]
    pub(super) library: Option<PathBuf>,
    /// A picture to make variations of
    #[arg(long, value_name = "IMAGE")]
    pub(super) target: Option<PathBuf>,
    /// How far trees go from the target, or from the mix of their exemplars, in outline, foliage and
    /// hue: 0 leaves them that, 1 goes as far as looks related
    #[arg(long, default_value_t = 0.7, value_name = "0..1")]
    pub(super) strength: f64,
    /// How many trees
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(super) count: u32,
    /// Exemplars in each tree
    #[arg(long, default_value_t = 2, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=16))]
    pub(super) mix: u8,
    /// Range of the first exemplar's weight when two are mixed
    #[arg(long, default_value = "0.3..0.7", value_name = "LOW..HIGH")]
    pub(super) weights: WeightRange,
    /// Where a tree's colours come from
    #[arg(long, value_enum, default_value_t, value_name = "HOW")]
    pub(super) colors: ColorsFlag,
    /// Give all trees the colours of this picture
    #[arg(long, value_name = "IMAGE")]
    pub(super) like: Option<PathBuf>,
    /// Further pictures of each tree, separated by commas
    #[arg(long, value_enum, value_delimiter = ',', value_name = "MAPS")]
    pub(super) maps: Vec<MapName>,
    /// Also draw all trees on one sheet
    #[arg(long, value_name = "FILE.png")]
    pub(super) sheet: Option<PathBuf>,
    /// Side of the pictures, in pixels
    #[arg(long, default_value_t = 1024, value_name = "PX", value_parser = clap::value_parser!(u32).range(64..=8192))]
    pub(super) size: u32,
    /// Mix any pair, however much it is distorted
    #[arg(long)]
    pub(super) any_pair: bool,
    /// Also inflate each picture to a crown in three dimensions: crowns/tree_0000 and so on, folders
    /// that render and export take; brings the maps normal and depth
    #[arg(long)]
    crowns: bool,
    /// Texels along a face of the crowns' cubemaps, a multiple of 16
    #[arg(long, default_value_t = 256, value_name = "N", requires = "crowns", value_parser = crown_size)]
    crown_size: u32,
    /// Breed from trees that were made: FILE.json#NAME, one or several. With --library its pictures
    /// may join
    #[arg(long, num_args = 1.., value_name = "FILE.json#NAME", conflicts_with_all = ["target", "mix", "weights", "colors", "like", "size", "any_pair", "season", "season_amount", "snow", "evergreen"])]
    pub(super) parents: Vec<String>,
    /// What children have from one parent as it is there, separated by commas
    #[arg(
        long,
        value_enum,
        value_delimiter = ',',
        value_name = "ASPECTS",
        requires = "parents"
    )]
    pub(super) lock: Vec<AspectName>,
    /// Which generation after the parents: 1 their children, 2 the children of all those, and so on
    #[arg(long, default_value_t = 1, value_name = "N", requires = "parents", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) generation: u32,
    /// Make one tree again: FILE.json#NAME
    #[arg(long, value_name = "FILE.json#NAME", conflicts_with_all = ["target", "count", "mix", "weights", "colors", "size", "maps", "any_pair", "crowns", "parents", "segmenter"])]
    pub(super) recipe: Option<String>,
    #[command(flatten)]
    pub(super) season: SeasonFlags,
    #[command(flatten)]
    pub(super) segmenter: SegmenterFlags,
    #[command(flatten)]
    pub(super) cache: CacheFlags,
}

impl Job for Flags {
    fn stages(&self) -> Stages {
        &[
            ("prepare", 10.0),
            ("choose", 2.0),
            ("vary", 85.0),
            ("sheet", 3.0),
        ]
    }

    fn run(&self, session: &Session<'_>) -> Result<(), Failure> {
        let out = session.options.out()?;
        match &self.recipe {
            Some(recipe) => super::vary_again::run(recipe, self, out, session),
            None => {
                let job = self.checked()?;
                let segmenter = self.segmenter.checked(session.cancel)?;
                let record = job.run(segmenter.as_ref(), out, session)?;
                session.print_json(|| {
                    json!({
                        "library": out.join("library.json").display().to_string(),
                        "trees": record.trees,
                        "seconds": session.seconds(),
                    })
                })
            }
        }
    }
}

impl Flags {
    /// Texels along a face of the crowns, if there are to be any.
    pub(super) fn crowns(&self) -> Option<u32> {
        self.crowns.then_some(self.crown_size)
    }

    /// The job that the flags mean.
    fn checked(&self) -> Result<Vary, Failure> {
        if !self.parents.is_empty() {
            return super::vary_parents::checked(self);
        }
        let folder = self.library.as_deref().unwrap_or(Path::new("."));
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(Failure::of("--strength", "must be from 0 to 1"));
        }
        let mut files = picture_files(folder)?;
        files.extend(self.target.clone());
        Ok(Vary {
            pictures: pictures(&files),
            folder: folder.to_owned(),
            has_target: self.target.is_some(),
            trees: Trees::Drawn(self.count),
            likes: pictures(self.like.as_slice()),
            maps: self.maps.iter().copied().collect(),
            sheet: self.sheet.clone(),
            settings: ExemplarSettings {
                size: self.size,
                ..Default::default()
            },
            choice: ChoiceSettings {
                mix: usize::from(self.mix),
                weights: (self.weights.low, self.weights.high),
                coloring: self.colors.coloring(),
                strength: self.strength,
                selective: !self.any_pair,
            },
            season: self.season.checked()?,
            crowns: self.crowns(),
            cache: self.cache.folder(),
        })
    }
}

/// A size of cubemaps.
fn crown_size(text: &str) -> Result<u32, String> {
    let number = text.parse::<u32>().ok();
    let fits = |size: &u32| (32..=1024).contains(size) && size.is_multiple_of(16);
    number
        .filter(fits)
        .ok_or_else(|| "expected a multiple of 16 from 32 to 1024".to_owned())
}
