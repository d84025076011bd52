//! `boscage vary`: a library of tree pictures → new trees.

use super::failure::Failure;
use super::library::{CacheFlags, opened, picture_files};
use super::output::recipe;
use super::records::{ExemplarRecord, LibraryRecord, TreeRecord};
use super::segment::SegmenterFlags;
use super::session::Session;
use super::vary_flags::{ColorsFlag, MapName, WeightRange};
use super::{Job, Stages, items};
use crate::base::{Digest, Hasher, Seed};
use crate::pipeline::tree_maps;
use crate::raster::{Compression, Image, encode_grey_png, encode_png};
use crate::segment::{Classical, grey_from_labels};
use crate::variation::{
    ChoiceSettings, Chosen, ExemplarSettings, Library, Palette, Shape, Tree, TreeMaker, chosen,
};
use clap::Args;
use rayon::prelude::*;
use serde_json::json;
use std::collections::BTreeSet;
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
  boscage vary --recipe new/library.json#tree_0003 --out again")]
pub(super) struct Flags {
    /// Folder of RGBA tree pictures
    #[arg(long, required_unless_present = "recipe", value_name = "DIR")]
    pub(super) library: Option<PathBuf>,
    /// A picture to make variations of
    #[arg(long, value_name = "IMAGE")]
    pub(super) target: Option<PathBuf>,
    /// How far variations go from the target: 0 copies, 1 as far as looks related
    #[arg(long, default_value_t = 0.7, value_name = "0..1", requires = "target")]
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
    /// Make one tree again: FILE.json#NAME
    #[arg(long, value_name = "FILE.json#NAME", conflicts_with_all = ["target", "count", "mix", "weights", "colors", "size", "maps", "any_pair"])]
    pub(super) recipe: Option<String>,
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
        let segmenter = self.segmenter.checked()?;
        match &self.recipe {
            Some(recipe) => super::vary_again::run(recipe, self, &segmenter, out, session),
            None => self.checked()?.run(&segmenter, out, session),
        }
    }
}

impl Flags {
    /// The job that the flags mean.
    fn checked(&self) -> Result<Vary, Failure> {
        let folder = self.library.as_deref().unwrap_or(Path::new("."));
        if !(0.0..=1.0).contains(&self.strength) {
            return Err(Failure::of("--strength", "must be from 0 to 1"));
        }
        let mut files = picture_files(folder)?;
        files.extend(self.target.clone());
        Ok(Vary {
            files,
            folder: folder.to_owned(),
            has_target: self.target.is_some(),
            count: self.count,
            like: self.like.clone(),
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
            cache: self.cache.folder(),
        })
    }
}

/// A checked job.
pub(super) struct Vary {
    pub(super) folder: PathBuf,
    /// The library's pictures and, if there is one, the target as the last.
    pub(super) files: Vec<PathBuf>,
    pub(super) has_target: bool,
    pub(super) count: u32,
    pub(super) like: Option<PathBuf>,
    pub(super) maps: BTreeSet<MapName>,
    pub(super) sheet: Option<PathBuf>,
    pub(super) settings: ExemplarSettings,
    pub(super) choice: ChoiceSettings,
    pub(super) cache: Option<PathBuf>,
}

impl Vary {
    /// Chooses the trees, makes those of this shard, and writes the record.
    pub(super) fn run(
        &self,
        segmenter: &Classical,
        out: &Path,
        session: &Session<'_>,
    ) -> Result<(), Failure> {
        let outputs = Outputs {
            folder: out,
            maps: self.maps.clone(),
        };
        let ours = (0..self.count).filter(|i| session.options.shard.contains(u64::from(*i)));
        session
            .output
            .check(ours.flat_map(|i| outputs.of(&tree_name(i))))?;
        session.output.check(self.sheet.as_ref())?;
        if self.sheet.is_some() && !session.options.shard.is_whole() {
            let reason = "a sheet shows all trees; make it with --resume once all shards are done";
            return Err(Failure::of("--sheet", reason));
        }
        let library = opened(
            &self.files,
            self.settings,
            segmenter,
            self.cache.as_deref(),
            session,
        )?;
        let target = self.target_of(&library)?;
        let seed = Seed(session.options.seed);
        let trees = self.chosen(&library, target, seed, session)?;
        let like = self
            .like
            .as_ref()
            .map(|path| Like::of(path, self.settings, segmenter, session));
        let like = like.transpose()?;
        let record = self.record(
            &library,
            &trees,
            target,
            like.as_ref().map(|l| &l.record),
            seed,
        );
        let json = record.to_json();
        session
            .output
            .check_same(&out.join("library.json"), json.as_bytes())?;

        let maker = TreeMaker::new(&library, like.map(|like| like.palette));
        let items: Vec<(&Chosen, &TreeRecord)> = trees.iter().zip(&record.trees).collect();
        items::made(session, "vary", &items, |_, (chosen, record)| {
            make_tree(&maker, chosen, record, &outputs, session)
        })?;
        session
            .output
            .write_same(&out.join("library.json"), json.as_bytes())?;
        self.draw_sheet(out, &record, session)?;
        session.print_json(|| {
            json!({
                "library": out.join("library.json").display().to_string(),
                "trees": record.trees,
                "seconds": session.seconds(),
            })
        })
    }

    /// The index of the target, which is the last of the library when there is one.
    fn target_of(&self, library: &Library<'_>) -> Result<Option<usize>, Failure> {
        let Some(path) = self.files.last().filter(|_| self.has_target) else {
            return Ok(None);
        };
        match library.entries().last() {
            Some(entry) if entry.path == *path => Ok(Some(library.entries().len() - 1)),
            _ => Err(Failure::of(path.display(), "cannot be used as the target")),
        }
    }

    fn chosen(
        &self,
        library: &Library<'_>,
        target: Option<usize>,
        seed: Seed,
        session: &Session<'_>,
    ) -> Result<Vec<Chosen>, Failure> {
        let shapes: Vec<&Shape> = library.entries().iter().map(|e| e.shape.as_ref()).collect();
        let stage = session.progress.stage("choose", u64::from(self.count));
        (0..self.count)
            .into_par_iter()
            .map(|index| {
                session.cancel.check()?;
                let seed = seed.derive("tree", u64::from(index));
                let chosen = chosen(&shapes, target, &self.choice, seed)
                    .map_err(|error| Failure::of(tree_name(index), error))?;
                if !chosen.layout.distortion.is_small() {
                    session.progress.warn(&format!(
                        "{}: no choice fits well; stretched {:.1} times, folded {:.1} %, smeared {:.0} %",
                        tree_name(index),
                        chosen.layout.distortion.stretch,
                        100.0 * chosen.layout.distortion.folded,
                        100.0 * chosen.layout.distortion.smeared,
                    ));
                }
                stage.advance();
                Ok(chosen)
            })
            .collect()
    }

    fn record(
        &self,
        library: &Library<'_>,
        trees: &[Chosen],
        target: Option<usize>,
        like: Option<&ExemplarRecord>,
        seed: Seed,
    ) -> LibraryRecord {
        let trees = (0u32..).zip(trees).map(|(index, chosen)| {
            let seed = seed.derive("tree", u64::from(index));
            TreeRecord::new(tree_name(index), seed, chosen, library, target, like)
        });
        LibraryRecord::new(&self.folder, self.settings, trees.collect())
    }

    fn draw_sheet(
        &self,
        out: &Path,
        record: &LibraryRecord,
        session: &Session<'_>,
    ) -> Result<(), Failure> {
        match &self.sheet {
            None => Ok(()),
            Some(path) => {
                let files: Vec<PathBuf> = record.trees.iter().map(|t| out.join(&t.file)).collect();
                super::sheets::draw(&files, path, session)
            }
        }
    }
}

/// Name of tree `index`, without ending.
fn tree_name(index: u32) -> String {
    format!("tree_{index:04}")
}

/// Where the files of a tree go.
pub(super) struct Outputs<'a> {
    pub(super) folder: &'a Path,
    pub(super) maps: BTreeSet<MapName>,
}

impl Outputs<'_> {
    fn picture(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.png"))
    }

    fn map(&self, name: &str, map: MapName) -> PathBuf {
        self.folder.join(format!("{name}.{}.png", map.name()))
    }

    /// All files of the tree `name`.
    pub(super) fn of(&self, name: &str) -> Vec<PathBuf> {
        let maps = self.maps.iter().map(|map| self.map(name, *map));
        std::iter::once(self.picture(name)).chain(maps).collect()
    }
}

/// The picture that gives all trees its colours.
pub(super) struct Like {
    record: ExemplarRecord,
    pub(super) palette: Palette,
}

impl Like {
    /// Reads and segments the picture.
    pub(super) fn of(
        path: &Path,
        settings: ExemplarSettings,
        segmenter: &Classical,
        session: &Session<'_>,
    ) -> Result<Self, Failure> {
        let library = opened(&[path.to_owned()], settings, segmenter, None, session)?;
        let exemplar = library.exemplar(0, session.cancel)?;
        Ok(Self {
            record: ExemplarRecord {
                file: path.display().to_string(),
                digest: library.entries()[0].digest.to_string(),
            },
            palette: Palette::of_exemplar(&exemplar),
        })
    }
}

/// Makes and writes one tree, unless it is there already.
pub(super) fn make_tree(
    maker: &TreeMaker<'_>,
    chosen: &Chosen,
    record: &TreeRecord,
    outputs: &Outputs<'_>,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let digest = record_digest(record);
    let files = outputs.of(record.name());
    if files
        .iter()
        .all(|file| session.output.is_ready(file, digest))
    {
        return Ok(());
    }
    let tree = maker.make(chosen, session.cancel)?;
    let png = encode_png(&tree.image, Compression::Fast);
    session.cancel.check()?;
    session
        .output
        .write_item(&outputs.picture(record.name()), png, digest)?;
    write_maps(&tree, record, outputs, digest, session)
}

/// Writes the further pictures of a tree.
fn write_maps(
    tree: &Tree,
    record: &TreeRecord,
    outputs: &Outputs<'_>,
    digest: Digest,
    session: &Session<'_>,
) -> Result<(), Failure> {
    let shaped = outputs.maps.iter().any(|map| *map != MapName::Labels);
    let maps = shaped.then(|| tree_maps(&tree.image, session.cancel));
    let maps = maps.transpose()?;
    for &name in &outputs.maps {
        let grey = |image: &Image<u8>| encode_grey_png(image, Compression::Fast);
        let png = match (name, &maps) {
            (MapName::Normal, Some(maps)) => encode_png(&maps.normal, Compression::Fast),
            (MapName::Depth, Some(maps)) => grey(&maps.depth),
            (MapName::Ao, Some(maps)) => grey(&maps.ao),
            (MapName::Translucency, Some(maps)) => grey(&maps.translucency),
            _ => grey(&grey_from_labels(&tree.labels)),
        };
        session.cancel.check()?;
        let path = outputs.map(record.name(), name);
        session.output.write_item(&path, png, digest)?;
    }
    Ok(())
}

/// The digest of all that a tree is made of.
fn record_digest(record: &TreeRecord) -> Digest {
    let hasher: Hasher = recipe("vary");
    hasher.with(record.to_json().as_bytes()).finish()
}
