//! What the studio knows of variations besides the project: prepared exemplars, trees that were made.
//!
//! A tree is known by the digest of all that it is made of. So an answer to an older question can
//! never stand in the place of a newer one, and undo finds again what was made before.

use crate::base::{Digest, Hasher};
use crate::document::{ExemplarWeight, PhotoId, VariationSettings};
use crate::geometry::Point;
use crate::pipeline::{GalleryTree, Pool, gallery_slots, parts_of_mix};
use crate::raster::{Image, Straight};
use crate::variation::{
    Draft, Drafts, Entry, Library, Palette, Part, Shape, are_of_a_kind, combined_outline,
};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

/// Side of a tree's picture in the gallery, pixels.
pub(super) const TILE_PX: u32 = 256;

/// Trees that are kept though nothing shows them: undo and a slider on its way back find them again.
const MOST_TILES: usize = 800;

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
    /// The picture whose histogram it takes.
    pub(super) like: Option<PhotoId>,
}

/// A tree that was made.
#[derive(Debug, Clone)]
pub(super) struct Tile {
    /// [`TILE_PX`] square.
    pub(super) image: Arc<Image<Straight>>,
    /// What it was made of.
    pub(super) parts: Vec<Part>,
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

/// The variations of the window.
#[derive(Default)]
pub(super) struct Vary {
    pub(super) prepared: Option<Prepared>,
    /// What is being prepared or was last.
    pub(super) asked_for: Option<Digest>,
    pub(super) gallery: Vec<Cell>,
    pub(super) favourites: Vec<Cell>,
    pub(super) pool: Pool,
    pub(super) tiles: BTreeMap<Digest, Result<Tile, String>>,
    /// The tree that was last made with a seed, whatever the settings: shown until the new one is
    /// there.
    pub(super) latest: BTreeMap<u64, Digest>,
    /// The trees that were asked for last.
    pub(super) asked_trees: Option<Digest>,
    pub(super) draft: Option<(Digest, Arc<Draft>)>,
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

    /// The cell with this key, among the gallery and the favourites.
    pub(super) fn cell(&self, key: Digest) -> Option<&Cell> {
        let mut all = self.gallery.iter().chain(&self.favourites);
        all.find(|cell| cell.key == key)
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

    /// The combined outline of the mix, and the side of the picture that it lies in, pixels.
    pub(super) fn mixed_outline(&self, settings: &VariationSettings) -> (Vec<Point>, u32) {
        let parts = self.mixed_parts(settings).unwrap_or_default();
        let Some(prepared) = self.prepared.as_ref().filter(|_| !parts.is_empty()) else {
            return (Vec::new(), 1);
        };
        let entries = prepared.library.entries();
        let shape = |part: &Part| entries[part.exemplar].shape.as_ref();
        let weighted = |part: &Part| (shape(part), part.contour_weight, part.color_weight);
        let weighted: Vec<(&Shape, f64, f64)> = parts.iter().map(weighted).collect();
        let size = entries[parts[0].exemplar].shape.size;
        (combined_outline(&weighted).points, size)
    }

    /// Lays out gallery and favourites anew.
    pub(super) fn lay_out(&mut self, settings: &VariationSettings) {
        let Some(prepared) = &self.prepared else {
            self.gallery.clear();
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
        self.pool = Pool {
            members,
            has_target: target.is_some(),
        };
        let around = settings.around.as_ref().and_then(|kept| {
            let coloring = settings.coloring;
            parts_of_mix(&kept.exemplars, &kept.color_weights, coloring, index)
        });
        let choice = crate::pipeline::choice_settings(settings);
        let recipe = format!("{:?} {choice:?} {:?}", self.pool, settings.like);
        let cell = |seed, is_locked, tree: GalleryTree, like: Option<PhotoId>| {
            let told = match &tree {
                GalleryTree::Drawn(_) => format!("{recipe} {tree:?}"),
                _ => format!("{like:?} {tree:?}"),
            };
            let key = Hasher::new("gallery tree")
                .with(prepared.stamp.bytes())
                .with(told.as_bytes())
                .finish();
            Cell {
                key,
                seed,
                is_locked,
                tree,
                like,
            }
        };
        let can_draw = !self.pool.members.is_empty();
        let slots = gallery_slots(settings).into_iter().filter(|_| can_draw);
        let in_gallery = |slot: crate::pipeline::Slot| {
            let tree = match &around {
                Some(parts) => GalleryTree::Near(parts.clone(), slot.seed),
                None => GalleryTree::Drawn(slot.seed),
            };
            cell(slot.seed, slot.is_locked, tree, settings.like)
        };
        self.gallery = slots.map(in_gallery).collect();
        let kept = settings.favourites.iter().filter_map(|kept| {
            let parts = parts_of_mix(
                &kept.exemplars,
                &kept.color_weights,
                settings.coloring,
                index,
            )?;
            Some(cell(kept.seed, false, GalleryTree::Kept(parts), kept.like))
        });
        self.favourites = kept.collect();
    }

    /// How many trees are to be made.
    pub(super) fn missing_count(&self) -> usize {
        let all = self.gallery.iter().chain(&self.favourites);
        let missing = all.filter(|cell| !self.tiles.contains_key(&cell.key));
        missing.count()
    }

    /// Cells whose trees are to be made: the gallery's in order, then favourites.
    pub(super) fn missing(&self) -> Vec<Cell> {
        let all = self.gallery.iter().chain(&self.favourites);
        let missing = all.filter(|cell| !self.tiles.contains_key(&cell.key));
        missing.cloned().collect()
    }

    /// Takes up a tree; forgets those that nothing shows when there are too many.
    pub(super) fn put(&mut self, cell: &Cell, tile: Result<Tile, String>) {
        self.latest.insert(cell.seed, cell.key);
        self.tiles.insert(cell.key, tile);
        if self.tiles.len() > MOST_TILES {
            let all = self.gallery.iter().chain(&self.favourites);
            let shown: std::collections::BTreeSet<Digest> = all.map(|cell| cell.key).collect();
            self.tiles.retain(|key, _| shown.contains(key));
            let tiles = &self.tiles;
            self.latest.retain(|_, key| tiles.contains_key(key));
        }
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
