//! What the studio knows of variations besides the project: prepared exemplars, trees that were made.
//!
//! A tree is known by the digest of all that it is made of. So an answer to an older question can
//! never stand in the place of a newer one, and undo finds again what was made before.

use crate::base::{Digest, Hasher};
use crate::document::{ExemplarWeight, Favourite, PhotoId, VariationSettings};
use crate::geometry::Point;
use crate::pipeline::{
    GalleryTree, Pool, Slot, Wishes, brood_of, choice_settings, gallery_slots, genome_of,
    parts_of_mix,
};
use crate::raster::{Image, Straight};
use crate::variation::{
    CompatibilityGraph, Draft, Drafts, Entry, Genome, Library, Palette, Part, Repetition,
    are_of_a_kind,
};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Side of a tree's picture in the gallery, pixels.
pub(super) const TILE_PX: u32 = 256;

/// Trees that are kept though nothing shows them: undo and a slider on its way back find them again.
const MOST_TILES: usize = 800;

/// The mix that the hand holds.
pub(super) struct Mixed {
    /// Of what [`Mixed::plain`] is made of.
    pub(super) plain_key: Digest,
    /// As its exemplars are.
    pub(super) plain: Draft,
    /// Whether it keeps its leaves, by the name of its picture.
    pub(super) evergreen: Option<bool>,
    /// In the season that trees are put into, if they are.
    pub(super) in_season: Option<Image<Straight>>,
}

impl Mixed {
    /// What a tree of the gallery would look like.
    pub(super) fn image(&self) -> &Image<Straight> {
        self.in_season.as_ref().unwrap_or(&self.plain.image)
    }
}

/// The pictures of the project that can be exemplars, prepared.
pub(super) struct Prepared {
    /// What was prepared: all pictures of the project.
    pub(super) stamp: Digest,
    pub(super) library: Arc<Library<'static>>,
    pub(super) drafts: Arc<Drafts>,
    pub(super) palettes: Arc<Mutex<BTreeMap<usize, Arc<Palette>>>>,
    /// The photograph of each exemplar, in the order of their numbers.
    pub(super) photos: Vec<PhotoId>,
    /// Each exemplar as it was normalised, small.
    pub(super) small: Vec<Arc<Image<Straight>>>,
    /// Where each exemplar stands on the map, in the unit square: those that go together side by side.
    pub(super) places: Vec<Point>,
    /// Which go together.
    pub(super) graph: CompatibilityGraph,
    /// Pictures that cannot be exemplars, and why.
    pub(super) refused: BTreeMap<PhotoId, String>,
}

impl Prepared {
    /// The exemplar of a photograph.
    pub(super) fn index(&self, photo: PhotoId) -> Option<usize> {
        self.photos.binary_search(&photo).ok()
    }

    /// The exemplar's vectors and its picture.
    pub(super) fn entry(&self, photo: PhotoId) -> Option<(&Entry, &Arc<Image<Straight>>)> {
        let index = self.index(photo)?;
        Some((&self.library.entries()[index], &self.small[index]))
    }
}

/// A place of the gallery, or a favourite.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Cell {
    /// The digest of all that the tree is made of.
    pub(super) key: Digest,
    /// The seed of its decisions.
    pub(super) seed: u64,
    /// Whether it stays when the gallery is drawn again.
    pub(super) is_locked: bool,
    /// How it is decided on.
    pub(super) tree: GalleryTree,
}

/// A tree that was made.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    /// [`TILE_PX`] square.
    pub(super) image: Arc<Image<Straight>>,
    /// What it was decided by.
    pub(super) genome: Genome,
    /// Whether its sources are stretched or folded so far that it shows.
    pub(super) is_distorted: bool,
}

/// A tree over the whole gallery.
#[derive(Debug, Clone)]
pub(super) struct Large {
    pub(super) cell: Cell,
    /// Once it was made.
    pub(super) image: Option<Arc<Image<Straight>>>,
}

/// How much some trees repeat each other.
#[derive(Debug, Clone)]
pub(super) struct Scored {
    /// Which trees; pairs are numbered in this order.
    pub(super) keys: Vec<Digest>,
    pub(super) repetition: Repetition,
}

/// The mixed tree in all seasons: as it is, spring, summer, autumn, winter.
pub(super) type Seasons = [Arc<Image<Straight>>; 5];

/// The variations of the window.
#[derive(Default)]
pub(super) struct Vary {
    pub(super) prepared: Option<Prepared>,
    /// What is being prepared or was last.
    pub(super) asked_for: Option<Digest>,
    pub(super) gallery: Vec<Cell>,
    pub(super) favourites: Vec<Cell>,
    /// The trees that the gallery's were bred from.
    pub(super) parents: Vec<Cell>,
    pub(super) pool: Pool,
    pub(super) wishes: Wishes,
    /// The trees whose likeness was asked for last, and the answer.
    pub(super) asked_score: Vec<Digest>,
    pub(super) score: Option<Scored>,
    /// The mixed tree in all seasons, and the plain draft it was.
    pub(super) seasons: Option<(Digest, Seasons)>,
    pub(super) asked_seasons: Option<Digest>,
    pub(super) tiles: BTreeMap<Digest, Result<Tile, String>>,
    /// The tree that was last made with a seed, whatever the settings: shown until the new one is
    /// there.
    pub(super) latest: BTreeMap<u64, Digest>,
    /// The trees that were asked for last.
    pub(super) asked_trees: Option<Digest>,
    pub(super) draft: Option<(Digest, Arc<Mixed>)>,
    pub(super) asked_draft: Option<Digest>,
    pub(super) large: Option<Large>,
    /// The tree that a batch made last.
    pub(super) batch_tree: Option<Arc<Image<Straight>>>,
    /// The folder that was chosen for a batch.
    pub(super) folder: Option<PathBuf>,
}

impl Vary {
    /// The tree of a cell, if it was made.
    pub(super) fn tile(&self, cell: &Cell) -> Option<&Result<Tile, String>> {
        self.tiles.get(&cell.key)
    }

    /// All cells: the gallery's, its parents, the favourites.
    pub(super) fn cells(&self) -> impl Iterator<Item = &Cell> {
        let kept = self.parents.iter().chain(&self.favourites);
        self.gallery.iter().chain(kept)
    }

    /// The cell with this key.
    pub(super) fn cell(&self, key: Digest) -> Option<&Cell> {
        self.cells().find(|cell| cell.key == key)
    }

    /// The trees of these keys as they are shown, once all of them were made.
    pub(super) fn pictures(&self, keys: &[Digest]) -> Option<Vec<Arc<Image<Straight>>>> {
        let picture = |key: &Digest| {
            let tile = self.tiles.get(key)?.as_ref().ok()?;
            Some(Arc::clone(&tile.image))
        };
        keys.iter().map(picture).collect()
    }

    /// The exemplars of the project with their shares in the mix: those ticked, or all that can be
    /// used when none is; equal shares of the first and one of its kind when no share was given.
    pub(super) fn mix(&self, settings: &VariationSettings) -> Vec<ExemplarWeight> {
        let Some(prepared) = &self.prepared else {
            return Vec::new();
        };
        let ticked = settings.exemplars.iter().copied();
        let mut mix: Vec<ExemplarWeight> = ticked
            .filter(|part| prepared.index(part.photo).is_some())
            .collect();
        if settings.exemplars.is_empty() {
            let all = prepared.photos.iter();
            mix = all
                .map(|&photo| ExemplarWeight { photo, weight: 0.0 })
                .collect();
        }
        if mix.iter().all(|part| part.weight == 0.0) {
            let second = first_match(prepared, &mix);
            for part in mix.iter_mut().take(1) {
                part.weight = 1.0;
            }
            if let Some(part) = second.and_then(|at| mix.get_mut(at)) {
                part.weight = 1.0;
            }
        }
        mix
    }

    /// The parts of the mix that is previewed.
    pub(super) fn mixed_parts(&self, settings: &VariationSettings) -> Option<Vec<Part>> {
        let prepared = self.prepared.as_ref()?;
        let index = |photo| prepared.index(photo);
        parts_of_mix(&self.mix(settings), &[], settings.coloring, index)
    }

    /// Lays out gallery and favourites anew.
    pub(super) fn lay_out(&mut self, settings: &VariationSettings) {
        let Some(prepared) = &self.prepared else {
            self.gallery.clear();
            self.parents.clear();
            self.favourites.clear();
            return;
        };
        let index = |photo| prepared.index(photo);
        let target = settings.target.and_then(index);
        let members = self
            .mix(settings)
            .into_iter()
            .filter_map(|part| index(part.photo));
        let mut members: Vec<usize> = members.filter(|member| Some(*member) != target).collect();
        members.extend(target);
        let pool = Pool {
            members,
            has_target: target.is_some(),
        };
        let wishes = Wishes {
            choice: choice_settings(settings),
            like: settings.like.and_then(index),
            season: settings.season,
        };
        let laid_out = Layout {
            stamp: prepared.stamp,
            pool: &pool,
            wishes: &wishes,
        };
        let genome = |kept: &Favourite| genome_of(kept, settings.coloring, index).map(Arc::new);
        let around = settings.around.as_ref().and_then(genome);
        let last = settings.lineage.last();
        let brood = last.and_then(|last| brood_of(last, settings.coloring, index));
        let brood = brood.map(Arc::new);
        let kind = |seed| match (&around, &brood) {
            (Some(genome), _) => GalleryTree::Near(Arc::clone(genome), seed),
            (None, Some(brood)) => GalleryTree::Bred(Arc::clone(brood), seed),
            (None, None) => GalleryTree::Drawn(seed),
        };
        // What all trees of the gallery share is told once.
        let told = laid_out.told(&kind(0));
        let slots = gallery_slots(settings).into_iter();
        let slots = slots.filter(|_| !pool.members.is_empty());
        let gallery = slots.map(|slot: Slot| {
            let key = Hasher::new("gallery tree").with(told.bytes());
            Cell {
                key: key.with(&slot.seed.to_le_bytes()).finish(),
                seed: slot.seed,
                is_locked: slot.is_locked,
                tree: kind(slot.seed),
            }
        });
        let gallery = gallery.collect();
        let kept = |kept: &Favourite| {
            let tree = GalleryTree::Kept(genome(kept)?);
            Some(Cell {
                key: laid_out.told(&tree),
                seed: kept.seed,
                is_locked: false,
                tree,
            })
        };
        let favourites = settings.favourites.iter().filter_map(kept).collect();
        let parents = last.filter(|_| around.is_none());
        let parents = parents.iter().flat_map(|last| &last.parents);
        let parents = parents.filter_map(kept).collect();
        (self.gallery, self.favourites, self.parents) = (gallery, favourites, parents);
        (self.pool, self.wishes) = (pool, wishes);
    }

    /// How many trees are to be made.
    pub(super) fn missing_count(&self) -> usize {
        let missing = self
            .cells()
            .filter(|cell| !self.tiles.contains_key(&cell.key));
        missing.count()
    }

    /// Cells whose trees are to be made: the gallery's in order, then those that were kept.
    pub(super) fn missing(&self) -> Vec<Cell> {
        let missing = self
            .cells()
            .filter(|cell| !self.tiles.contains_key(&cell.key));
        missing.cloned().collect()
    }

    /// Takes up a tree; forgets those that nothing shows when there are too many.
    pub(super) fn put(&mut self, cell: &Cell, tile: Result<Tile, String>) {
        self.latest.insert(cell.seed, cell.key);
        self.tiles.insert(cell.key, tile);
        if self.tiles.len() > MOST_TILES {
            let shown: BTreeSet<Digest> = self.cells().map(|cell| cell.key).collect();
            self.tiles.retain(|key, _| shown.contains(key));
            let tiles = &self.tiles;
            self.latest.retain(|_, key| tiles.contains_key(key));
        }
    }
}

/// All that decides how a cell's tree looks, besides the cell.
struct Layout<'a> {
    stamp: Digest,
    pool: &'a Pool,
    wishes: &'a Wishes,
}

impl Layout<'_> {
    /// The digest of all that a tree of this kind is made of.
    fn told(&self, tree: &GalleryTree) -> Digest {
        let Self { pool, wishes, .. } = self;
        let (like, season) = (wishes.like, wishes.season);
        let told = match tree {
            GalleryTree::Drawn(_) => format!("drawn {pool:?} {wishes:?}"),
            GalleryTree::Near(genome, _) => format!("near {genome:?} {like:?} {season:?}"),
            GalleryTree::Bred(brood, _) => format!("bred {brood:?} {:?}", pool.members),
            GalleryTree::Kept(genome) => format!("kept {genome:?}"),
        };
        let stamp = Hasher::new("kind of tree").with(self.stamp.bytes());
        stamp.with(told.as_bytes()).finish()
    }
}

/// The first exemplar of `mix` that is of a kind with its first, or the second if none is.
fn first_match(prepared: &Prepared, mix: &[ExemplarWeight]) -> Option<usize> {
    let shape = |part: &ExemplarWeight| prepared.entry(part.photo).map(|(entry, _)| &entry.shape);
    let first = shape(mix.first()?)?;
    let is_match = |part: &ExemplarWeight| shape(part).is_some_and(|own| are_of_a_kind(first, own));
    let found = mix.iter().skip(1).position(is_match);
    Some(found.map_or(1, |at| at + 1))
}
