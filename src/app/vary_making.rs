//! What the jobs of the variations make: exemplars, trees of the gallery, a mix in a season.

use super::outcome::Outcome;
use super::photos::THUMBNAIL_PX;
use super::vary::{Cell, Prepared, TILE_PX, Tile};
use crate::base::{Cancel, Digest, Seed};
use crate::document::PhotoId;
use crate::jobs::{Context, JobError};
use crate::pipeline::{Pool, Wishes};
use crate::raster::{Image, Premultiplied, Straight, resized};
use crate::segment::Auto;
use crate::variation::{
    CompatibilityGraph, Decided, Draft, Exemplar, ExemplarSettings, Finish, Histogram, Library,
    LibraryError, LibraryPicture, Palette, SeasonChoice, Shape, Tree, TreeMaker, library_places,
};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::{Arc, Mutex, PoisonError};

/// Side of the mix in a season, pixels.
const SEASON_PX: u32 = 192;

pub(super) fn failed(error: LibraryError) -> JobError {
    match error {
        LibraryError::Cancelled(cancelled) => cancelled.into(),
        error => JobError::failed(error),
    }
}

/// The exemplars of `pictures`, of which `known` holds what was prepared before.
pub(super) fn prepared(
    (stamp, segmenter): (Digest, &'static Auto),
    pictures: &[LibraryPicture],
    ids: &[PhotoId],
    known: Option<&Library<'_>>,
    context: &Context<Outcome>,
) -> Result<Prepared, JobError> {
    let (library, refused) = Library::of(
        pictures,
        ExemplarSettings::default(),
        segmenter,
        None,
        known,
        context.progress(),
        context.cancel(),
    )?;
    let refused: BTreeMap<PhotoId, String> = refused
        .into_iter()
        .map(|refused| (ids[refused.index], refused.reason.to_string()))
        .collect();
    let photos = ids.iter().copied().filter(|id| !refused.contains_key(id));
    let photos: Vec<PhotoId> = photos.collect();
    let mut small = Vec::new();
    for index in 0..photos.len() {
        let exemplar: Arc<Exemplar> = library.exemplar(index, context.cancel()).map_err(failed)?;
        small.push(Arc::new(reduced(&exemplar.image, THUMBNAIL_PX).straight()));
    }
    let entries = library.entries().iter();
    let shapes: Vec<&Shape> = entries.map(|entry| entry.shape.as_ref()).collect();
    let (places, graph) = (library_places(&shapes), CompatibilityGraph::of(&shapes));
    Ok(Prepared {
        stamp,
        library: Arc::new(library),
        drafts: Arc::default(),
        palettes: Arc::default(),
        photos,
        small,
        places,
        graph,
        refused,
    })
}

/// The whole of a square picture at another size.
pub(super) fn reduced(image: &Image<Premultiplied>, size: u32) -> Image<Premultiplied> {
    resized(image, image.rect(), size, size)
}

/// The palette of an exemplar, made once.
pub(super) fn palette(
    library: &Library<'_>,
    palettes: &Mutex<BTreeMap<usize, Arc<Palette>>>,
    index: usize,
    cancel: &Cancel,
) -> Result<Arc<Palette>, LibraryError> {
    let known = || palettes.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(palette) = known().get(&index) {
        return Ok(Arc::clone(palette));
    }
    let palette = Arc::new(Palette::of_exemplar(&*library.exemplar(index, cancel)?));
    known().insert(index, Arc::clone(&palette));
    Ok(palette)
}

/// All that trees of the gallery are made from, for a job to own.
pub(super) struct GalleryMaker {
    pub(super) library: Arc<Library<'static>>,
    pub(super) palettes: Arc<Mutex<BTreeMap<usize, Arc<Palette>>>>,
    pub(super) pool: Pool,
    pub(super) wishes: Wishes,
}

/// The makers of a job's trees, for each exemplar that gives its histogram.
pub(super) type Makers<'a> = BTreeMap<Option<usize>, TreeMaker<'a>>;

impl GalleryMaker {
    /// The tree of `cell` at full size, and how it was decided.
    pub(super) fn made<'a>(
        &'a self,
        makers: &mut Makers<'a>,
        cell: &Cell,
        cancel: &Cancel,
    ) -> Result<(Image<Straight>, Decided), JobError> {
        let decided = self.pool.decided(&self.library, &cell.tree, &self.wishes);
        let decided = decided.map_err(JobError::failed)?;
        let genome = &decided.genome;
        // In a season the picture gives the colours of its leaves.
        let of_maker = genome.like.filter(|_| genome.finish.season.is_none());
        let maker = match makers.entry(of_maker) {
            Entry::Occupied(maker) => maker.into_mut(),
            Entry::Vacant(place) => place.insert(self.maker(of_maker, cancel)?),
        };
        let mut tree = maker.make(&decided.chosen, cancel).map_err(failed)?;
        let like = genome.like.map(|like| self.palette(like, cancel));
        let like = like.transpose()?;
        let leaves = like.as_ref().map(|palette| palette.crown());
        genome.finish.put(&mut tree, leaves, genome.seed, cancel)?;
        Ok((tree.image, decided))
    }

    fn palette(&self, index: usize, cancel: &Cancel) -> Result<Arc<Palette>, JobError> {
        palette(&self.library, &self.palettes, index, cancel).map_err(failed)
    }

    fn maker(&self, like: Option<usize>, cancel: &Cancel) -> Result<TreeMaker<'_>, JobError> {
        let like = like.map(|like| self.palette(like, cancel)).transpose()?;
        let like = like.map(|like| Palette::clone(&like));
        Ok(TreeMaker::new(&self.library, like))
    }

    pub(super) fn tile<'a>(
        &'a self,
        makers: &mut Makers<'a>,
        cell: &Cell,
        cancel: &Cancel,
    ) -> Result<Tile, JobError> {
        let (image, decided) = self.made(makers, cell, cancel)?;
        Ok(Tile {
            image: Arc::new(reduced(&image.premultiplied(), TILE_PX).straight()),
            is_distorted: !decided.chosen.layout.distortion.is_small(),
            genome: decided.genome,
        })
    }
}

/// The picture of `tree` put into a season, if one is given; `like` gives the colours of its leaves.
pub(super) fn in_season(
    mut tree: Tree,
    season: Option<SeasonChoice>,
    like: Option<&Histogram>,
    cancel: &Cancel,
) -> Result<Image<Straight>, JobError> {
    let finish = Finish {
        season,
        ..Finish::default()
    };
    finish.put(&mut tree, like, Seed(0), cancel)?;
    Ok(tree.image)
}

/// A draft at the size of a stamp.
pub(super) fn small_tree(draft: &Draft) -> Tree {
    let nearest = |i: u32| (2 * i + 1) * draft.image.width() / (2 * SEASON_PX);
    let places = (0..SEASON_PX).flat_map(|y| (0..SEASON_PX).map(move |x| (x, y)));
    let labels = places.map(|(x, y)| draft.labels.at(nearest(x), nearest(y)));
    Tree {
        image: reduced(&draft.image.premultiplied(), SEASON_PX).straight(),
        labels: Image::from_pixels(SEASON_PX, SEASON_PX, labels.collect()),
    }
}
