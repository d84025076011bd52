//! Pictures of trees → a folder of new trees: what `boscage vary` and the studio's batches do.

use super::failure::Failure;
use super::items;
use super::library::opened;
use super::output::recipe;
use super::parents::Parents;
use super::records::{ExemplarRecord, LibraryRecord, OUT_OF_RANGE, TreeCrownRecord, TreeRecord};
use super::run::Run;
use super::tree_crown::{TreeCrown, crown_files_of};
use crate::base::{Digest, Hasher, Seed};
use crate::pipeline::{GalleryTree, Pool, Wishes, tree_maps};
use crate::raster::{Compression, Image, encode_grey_png, encode_png};
use crate::segment::{Segmenter, grey_from_labels};
use crate::variation::{
    ChoiceSettings, Chosen, Decided, ExemplarSettings, Histogram, Library, LibraryPicture, Palette,
    SeasonChoice, Tree, TreeMaker,
};
use clap::ValueEnum;
use rayon::prelude::*;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// A further picture of a tree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum MapName {
    /// Crown and trunk, 8-bit grey: 0 background, 128 trunk, 255 crown
    Labels,
    /// Tangent-space normals, Y+
    Normal,
    /// Height towards the viewer, 8-bit grey
    Depth,
    /// Openness to the sky, 8-bit grey
    Ao,
    /// Light that comes through from behind, 8-bit grey
    Translucency,
}

impl MapName {
    /// What stands between the tree's name and `.png`.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Labels => "labels",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Ao => "ao",
            Self::Translucency => "translucency",
        }
    }
}

/// Which trees are made.
pub(crate) enum Trees {
    /// That many, drawn at random.
    Drawn(u32),
    /// That many, bred from others.
    Bred(Box<Parents>, u32),
    /// These.
    Planned(Plan),
}

/// Trees that were decided on elsewhere.
pub(crate) struct Plan {
    /// Exemplars of the job's library that trees are drawn from.
    pub(crate) pool: Pool,
    /// Each with its name as a seed.
    pub(crate) trees: Vec<GalleryTree>,
    /// What the trees call the pictures that give colours, in the order of the job's.
    pub(crate) likes: Vec<usize>,
    /// The one that those take that are drawn or are siblings, if any.
    pub(crate) like: Option<usize>,
}

impl Trees {
    fn count(&self) -> u32 {
        match self {
            Self::Drawn(count) | Self::Bred(_, count) => *count,
            Self::Planned(plan) => u32::try_from(plan.trees.len()).unwrap_or(u32::MAX),
        }
    }
}

/// The entries of `library` that become trees with `target`: not the same picture under another path.
fn others_and(target: Option<usize>, library: &Library<'_>) -> Vec<usize> {
    let entries = library.entries();
    let is_other = |index: &usize| {
        target.is_none_or(|target| {
            *index == target || entries[*index].digest != entries[target].digest
        })
    };
    (0..entries.len()).filter(is_other).collect()
}

/// A checked job.
pub(crate) struct Vary {
    pub(crate) folder: PathBuf,
    /// The library's pictures and, if there is one, the target as the last.
    pub(crate) pictures: Vec<LibraryPicture>,
    pub(crate) has_target: bool,
    pub(crate) trees: Trees,
    /// Pictures whose colours trees take; those that are drawn all take the first's.
    pub(crate) likes: Vec<LibraryPicture>,
    pub(crate) maps: BTreeSet<MapName>,
    pub(crate) sheet: Option<PathBuf>,
    pub(crate) settings: ExemplarSettings,
    pub(crate) choice: ChoiceSettings,
    /// The season that all trees are put into.
    pub(crate) season: Option<SeasonChoice>,
    /// Texels along a face of the crowns that trees are inflated to, if they are.
    pub(crate) crowns: Option<u32>,
    pub(crate) cache: Option<PathBuf>,
}

impl Vary {
    /// Chooses the trees, makes those of this shard, and writes the record, which it gives back.
    pub(crate) fn run(
        &self,
        segmenter: &dyn Segmenter,
        out: &Path,
        session: &Run<'_>,
    ) -> Result<LibraryRecord, Failure> {
        let outputs = Outputs {
            folder: out,
            maps: self.maps(),
        };
        let count = self.trees.count();
        let ours = (0..count).filter(|i| session.shard.contains(u64::from(*i)));
        let with_crown = self.crowns.is_some();
        session
            .output
            .check(ours.flat_map(|i| outputs.of(&tree_name(i), with_crown)))?;
        session.output.check(self.sheet.as_ref())?;
        if self.sheet.is_some() && !session.shard.is_whole() {
            let reason = "a sheet shows all trees; make it with --resume once all shards are done";
            return Err(Failure::of("--sheet", reason));
        }
        let library = opened(
            &self.pictures,
            self.settings,
            segmenter,
            self.cache.as_deref(),
            session,
        )?;
        let target = self.target_of(&library)?;
        let trees = self.decided(&library, target, session)?;
        let likes = self
            .likes
            .iter()
            .map(|picture| Like::of(picture, self.settings, segmenter, session))
            .collect::<Result<Vec<Like>, Failure>>()?;
        let record = self.record(&library, &trees, target, &likes);
        let json = record.to_json();
        session
            .output
            .check_same(&out.join("library.json"), json.as_bytes())?;

        // With a season, pictures give the colours of its leaves.
        let palettes: Vec<Palette> = likes.into_iter().map(|like| like.palette).collect();
        let makers: Vec<TreeMaker<'_>> = std::iter::once(None)
            .chain(palettes.iter().cloned().map(Some))
            .map(|palette| TreeMaker::new(&library, palette))
            .collect();
        let items: Vec<(&Decided, &TreeRecord)> = trees.iter().zip(&record.trees).collect();
        items::made(session, "vary", &items, |_, (tree, record)| {
            let like = tree.genome.like;
            let of_maker = like.filter(|_| record.season.is_none());
            let maker = &makers[of_maker.map_or(0, |like| like + 1)];
            let like = like.map(|like| palettes[like].crown());
            make_tree(maker, &tree.chosen, record, like, &outputs, session)
        })?;
        session
            .output
            .write_same(&out.join("library.json"), json.as_bytes())?;
        self.draw_sheet(out, &record, session)?;
        Ok(record)
    }

    /// The index of the target, which is the last of the library when there is one.
    fn target_of(&self, library: &Library<'_>) -> Result<Option<usize>, Failure> {
        let Some(picture) = self.pictures.last().filter(|_| self.has_target) else {
            return Ok(None);
        };
        let path = &picture.path;
        match library.entries().last() {
            Some(entry) if entry.path == *path => Ok(Some(library.entries().len() - 1)),
            _ => Err(Failure::of(path.display(), "cannot be used as the target")),
        }
    }

    /// The further pictures of each tree: where it is inflated, also how.
    fn maps(&self) -> BTreeSet<MapName> {
        let mut maps = self.maps.clone();
        if self.crowns.is_some() {
            maps.extend([MapName::Normal, MapName::Depth]);
        }
        maps
    }

    fn decided(
        &self,
        library: &Library<'_>,
        target: Option<usize>,
        session: &Run<'_>,
    ) -> Result<Vec<Decided>, Failure> {
        let all = Pool {
            members: others_and(target, library),
            has_target: target.is_some(),
        };
        let seed = |index| Seed(session.seed).derive("tree", index);
        let count = self.trees.count();
        let seeds = (0..u64::from(count)).map(seed);
        let like = match &self.trees {
            Trees::Planned(plan) => plan.like,
            _ => (!self.likes.is_empty()).then_some(0),
        };
        let wishes = Wishes {
            choice: self.choice,
            like,
            season: self.season,
        };
        let (pool, trees): (&Pool, Vec<GalleryTree>) = match &self.trees {
            Trees::Drawn(_) => (&all, seeds.map(|seed| GalleryTree::Drawn(seed.0)).collect()),
            Trees::Bred(parents, _) => {
                let seeds: Vec<Seed> = seeds.collect();
                (&all, parents.children(library, &all.members, &seeds)?)
            }
            Trees::Planned(plan) => (&plan.pool, plan.trees.clone()),
        };
        let stage = session.progress.stage("choose", u64::from(count));
        (0..count)
            .into_par_iter()
            .map(|index| {
                session.cancel.check()?;
                let decided = pool.decided(library, &trees[index as usize], &wishes);
                let mut decided = decided.map_err(|error| Failure::of(tree_name(index), error))?;
                if let Trees::Planned(plan) = &self.trees {
                    let own = |of: usize| plan.likes.iter().position(|like| *like == of);
                    decided.genome.like = decided.genome.like.and_then(own);
                }
                warn_if_distorted(index, &decided.chosen, session);
                stage.advance();
                Ok(decided)
            })
            .collect()
    }

    fn record(
        &self,
        library: &Library<'_>,
        trees: &[Decided],
        target: Option<usize>,
        likes: &[Like],
    ) -> LibraryRecord {
        let trees = (0u32..).zip(trees).map(|(index, tree)| {
            let like = tree.genome.like.map(|like| &likes[like].record);
            let name = tree_name(index);
            let crown = self.crowns.map(|size| TreeCrownRecord::of(&name, size));
            let parents = match &self.trees {
                Trees::Bred(parents, _) => parents.names(),
                _ => Vec::new(),
            };
            TreeRecord {
                crown,
                parents,
                ..TreeRecord::new(&name, tree, library, target, like)
            }
        });
        LibraryRecord::new(&self.folder, library, trees.collect())
    }

    fn draw_sheet(
        &self,
        out: &Path,
        record: &LibraryRecord,
        session: &Run<'_>,
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

/// Tells of a tree that looks stretched or folded.
fn warn_if_distorted(index: u32, chosen: &Chosen, session: &Run<'_>) {
    let distortion = &chosen.layout.distortion;
    if !distortion.is_small() {
        session.progress.warn(&format!(
            "{}: no choice fits well; stretched {:.1} times, folded {:.1} %, smeared {:.0} %",
            tree_name(index),
            distortion.stretch,
            100.0 * distortion.folded,
            100.0 * distortion.smeared,
        ));
    }
}

/// Name of tree `index`, without ending.
fn tree_name(index: u32) -> String {
    format!("tree_{index:04}")
}

/// Where the files of a tree go.
pub(crate) struct Outputs<'a> {
    pub(crate) folder: &'a Path,
    pub(crate) maps: BTreeSet<MapName>,
}

impl Outputs<'_> {
    fn picture(&self, name: &str) -> PathBuf {
        self.folder.join(format!("{name}.png"))
    }

    fn map(&self, name: &str, map: MapName) -> PathBuf {
        self.folder.join(format!("{name}.{}.png", map.name()))
    }

    /// All files of the tree `name`, those of its crown included if it has one.
    pub(crate) fn of(&self, name: &str, with_crown: bool) -> Vec<PathBuf> {
        let mut files = self.pictures(name);
        if with_crown {
            files.extend(crown_files_of(self.folder, name));
        }
        files
    }

    /// Its pictures.
    fn pictures(&self, name: &str) -> Vec<PathBuf> {
        let maps = self.maps.iter().map(|map| self.map(name, *map));
        std::iter::once(self.picture(name)).chain(maps).collect()
    }
}

/// The picture that gives all trees its colours.
pub(crate) struct Like {
    record: ExemplarRecord,
    pub(crate) palette: Palette,
}

impl Like {
    /// Reads and segments the picture.
    pub(crate) fn of(
        picture: &LibraryPicture,
        settings: ExemplarSettings,
        segmenter: &dyn Segmenter,
        session: &Run<'_>,
    ) -> Result<Self, Failure> {
        let pictures = std::slice::from_ref(picture);
        let library = opened(pictures, settings, segmenter, None, session)?;
        let exemplar = library.exemplar(0, session.cancel)?;
        Ok(Self {
            record: ExemplarRecord {
                file: picture.path.display().to_string(),
                digest: library.entries()[0].digest.to_string(),
                labels: Some(library.entries()[0].provenance.source),
                pins: None,
            },
            palette: Palette::of_exemplar(&exemplar),
        })
    }

    /// The digest of the picture's file.
    pub(crate) fn digest(&self) -> &str {
        &self.record.digest
    }
}

/// Makes and writes one tree, unless it is there already. In a season, `like` gives the colours of
/// its leaves.
pub(crate) fn make_tree(
    maker: &TreeMaker<'_>,
    chosen: &Chosen,
    record: &TreeRecord,
    like: Option<&Histogram>,
    outputs: &Outputs<'_>,
    session: &Run<'_>,
) -> Result<(), Failure> {
    let digest = record_digest(record, &maker.library().segmenter().key());
    let crown = TreeCrown::of(record, digest, outputs.folder);
    let is_there = |file: &PathBuf| session.output.is_ready(file, digest);
    let has_pictures = outputs.pictures(record.name()).iter().all(is_there);
    let crown = crown.filter(|crown| !crown.is_ready(session));
    if has_pictures && crown.is_none() {
        return Ok(());
    }
    let finish = record.finish();
    if !finish.is_sound() {
        return Err(Failure::of(record.name(), OUT_OF_RANGE));
    }
    let mut tree = maker.make(chosen, session.cancel)?;
    finish.put(&mut tree, like, Seed(record.seed), session.cancel)?;
    if let Some(shown) = session.shown {
        shown(&tree.image);
    }
    if !has_pictures {
        let png = encode_png(&tree.image, Compression::Fast);
        session.cancel.check()?;
        session
            .output
            .write_item(&outputs.picture(record.name()), png, digest)?;
        write_maps(&tree, record, outputs, digest, session)?;
    }
    // Last: a tree that has no crown still is one.
    crown.map_or(Ok(()), |crown| crown.make(&tree, session))
}

/// Writes the further pictures of a tree.
fn write_maps(
    tree: &Tree,
    record: &TreeRecord,
    outputs: &Outputs<'_>,
    digest: Digest,
    session: &Run<'_>,
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
fn record_digest(record: &TreeRecord, segmenter: &str) -> Digest {
    let hasher: Hasher = recipe("vary 3");
    // Who it was bred from and whether there is a crown, too, changes no picture.
    let picture = TreeRecord {
        crown: None,
        parents: Vec::new(),
        ..record.clone()
    };
    hasher
        .with(segmenter.as_bytes())
        .with(picture.to_json().as_bytes())
        .finish()
}
