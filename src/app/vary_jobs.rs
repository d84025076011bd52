//! The jobs of the variations, and what becomes of their results.

use super::outcome::Outcome;
use super::studio::{Severity, Studio, Workspace};
use super::vary::{Cell, Large, Mixed, Prepared, Scored, Seasons, Tile};
use super::vary_making::{GalleryMaker, Makers, failed, in_season, palette, prepared, small_tree};
use crate::base::{Digest, Hasher};
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use crate::raster::{Image, Straight};
use crate::segment::Segmenter as _;
use crate::variation::{
    Drafts, LibraryPicture, Look, Repetition, Season, SeasonChoice, SeasonSettings, Tree,
    evergreen_by_name,
};
use std::path::PathBuf;
use std::sync::Arc;

/// The job that prepares exemplars.
pub(super) const EXEMPLARS: &str = "exemplars";

/// The job that fills the gallery.
pub(super) const GALLERY: &str = "gallery";

/// What these jobs give back.
pub(super) enum VaryOutcome {
    /// The exemplars.
    Prepared(Box<Prepared>),
    /// A tree of the gallery, or why there is none.
    Tile(Cell, Box<Result<Tile, String>>),
    /// All trees were made.
    GalleryIsFull,
    /// The mix that the hand holds; `None` when it cannot be mixed.
    Draft(Digest, Option<Box<Mixed>>),
    /// The mix of this draft in all seasons.
    Seasons(Digest, Box<Seasons>),
    /// How much trees repeat each other.
    Score(Box<Scored>),
    /// A tree at full size.
    Large(Digest, Arc<Image<Straight>>),
    /// The tree that a batch made last.
    BatchTree(Arc<Image<Straight>>),
    /// A batch was written; what is told.
    Wrote(String),
}

fn topic(kind: &'static str) -> Topic {
    Topic { kind, item: 0 }
}

impl Studio {
    /// Asks for what the variations' workspace shows and is not there: exemplars, trees, the preview.
    pub(super) fn refresh_variations(&mut self) {
        if self.workspace != Workspace::Variations {
            return;
        }
        let stamp = self.prepare_exemplars();
        let is_current = |prepared: &Prepared| prepared.stamp == stamp;
        if self.vary.prepared.as_ref().is_some_and(is_current) {
            let settings = &self.document.state().content().variation;
            self.vary.lay_out(settings);
            self.fill_gallery();
            self.draw_draft();
        }
    }

    /// Takes up what one of these jobs gave.
    pub(super) fn accept_variation(&mut self, outcome: VaryOutcome) {
        match outcome {
            VaryOutcome::Prepared(prepared) => {
                self.vary.prepared = Some(*prepared);
                self.refresh_variations();
            }
            VaryOutcome::Tile(cell, tile) => self.vary.put(&cell, *tile),
            VaryOutcome::GalleryIsFull => {}
            VaryOutcome::BatchTree(image) => self.vary.batch_tree = Some(image),
            VaryOutcome::Wrote(told) => self.notify(Severity::Info, told),
            VaryOutcome::Draft(key, draft) => {
                self.vary.draft = draft.map(|draft| (key, Arc::from(draft)));
                self.draw_seasons();
            }
            VaryOutcome::Seasons(key, seasons) => self.vary.seasons = Some((key, *seasons)),
            VaryOutcome::Score(score) => {
                // An older answer says nothing of what is selected now.
                let is_wanted = score.keys == self.vary.asked_score;
                self.vary.score = is_wanted.then_some(*score);
            }
            VaryOutcome::Large(key, image) => {
                if let Some(large) = &mut self.vary.large
                    && large.cell.key == key
                {
                    large.image = Some(image);
                }
            }
        }
    }

    /// Prepares all pictures unless that was asked for; the stamp of what is asked for now.
    fn prepare_exemplars(&mut self) -> Digest {
        let photos = &self.document.state().content().photos;
        let mut stamp = Hasher::new("exemplars");
        let (mut pictures, mut ids) = (Vec::new(), Vec::new());
        for (&id, photo) in photos {
            let pins = self.document.state().content().pins.get(&id).copied();
            stamp = stamp.with(&id.0.to_le_bytes()).with(photo.digest.bytes());
            stamp = stamp.with(format!("{pins:?}").as_bytes());
            if let Some(bytes) = self.document.photo_bytes(id) {
                ids.push(id);
                pictures.push(LibraryPicture {
                    path: PathBuf::from(&photo.name),
                    bytes: Some(Arc::clone(bytes)),
                    pins,
                });
            }
        }
        let segmenter = self.segmenter();
        if let Some(model) = segmenter.model() {
            stamp = stamp.with(model.bytes());
        }
        let stamp = stamp.finish();
        if self.vary.asked_for == Some(stamp) {
            return stamp;
        }
        self.vary.asked_for = Some(stamp);
        let known = self.vary.prepared.as_ref();
        let known = known.map(|prepared| Arc::clone(&prepared.library));
        let work = move |context: &Context<Outcome>| {
            let prepared = prepared(
                (stamp, segmenter),
                &pictures,
                &ids,
                known.as_deref(),
                context,
            )?;
            let prepared = VaryOutcome::Prepared(Box::new(prepared));
            Ok(Outcome::Vary(prepared))
        };
        let request = Request::new(
            "Preparing exemplars",
            topic(EXEMPLARS),
            Priority::Preview,
            work,
        );
        self.jobs.submit(request);
        stamp
    }

    /// Makes the trees that are missing unless that was asked for.
    fn fill_gallery(&mut self) {
        let missing = self.vary.missing();
        let mut asked = Hasher::new("gallery");
        for cell in self.vary.cells() {
            asked = asked.with(cell.key.bytes());
        }
        let asked = asked.finish();
        if self.vary.asked_trees == Some(asked) {
            return;
        }
        self.vary.asked_trees = Some(asked);
        let Some(maker) = self.gallery_maker() else {
            return;
        };
        let work = move |context: &Context<Outcome>| {
            let stage = context.progress().stage("grow trees", missing.len() as u64);
            let mut makers = Makers::default();
            for cell in missing {
                context.check()?;
                let tile = match maker.tile(&mut makers, &cell, context.cancel()) {
                    Err(JobError::Cancelled(cancelled)) => return Err(cancelled.into()),
                    tile => tile.map_err(|error| error.to_string()),
                };
                context.publish(Outcome::Vary(VaryOutcome::Tile(cell, Box::new(tile))));
                stage.advance();
            }
            Ok(Outcome::Vary(VaryOutcome::GalleryIsFull))
        };
        // Also with nothing to do: what is still being made is for settings that are gone.
        let request = Request::new(
            "Growing the gallery",
            topic(GALLERY),
            Priority::Preview,
            work,
        );
        self.jobs.submit(request);
    }

    fn gallery_maker(&self) -> Option<GalleryMaker> {
        let prepared = self.vary.prepared.as_ref()?;
        Some(GalleryMaker {
            library: Arc::clone(&prepared.library),
            palettes: Arc::clone(&prepared.palettes),
            pool: self.vary.pool.clone(),
            wishes: self.vary.wishes.clone(),
        })
    }

    /// Makes the mix that the hand holds.
    fn draw_draft(&mut self) {
        let settings = &self.document.state().content().variation;
        let Some(prepared) = &self.vary.prepared else {
            return;
        };
        let Some(parts) = self.vary.mixed_parts(settings) else {
            self.vary.draft = None;
            return;
        };
        let like = settings.like.and_then(|like| prepared.index(like));
        let season = settings.season;
        let evergreen = evergreen_by_name(&parts, &prepared.library);
        // In a season the picture gives the colours of its leaves.
        let of_maker = like.filter(|_| season.is_none());
        let plain_key = Hasher::new("draft")
            .with(prepared.stamp.bytes())
            .with(format!("{parts:?} {of_maker:?}").as_bytes())
            .finish();
        let key = Hasher::new("draft in season")
            .with(plain_key.bytes())
            .with(format!("{like:?} {season:?}").as_bytes())
            .finish();
        if self.vary.asked_draft == Some(key) {
            return;
        }
        self.vary.asked_draft = Some(key);
        let library = Arc::clone(&prepared.library);
        let drafts: Arc<Drafts> = Arc::clone(&prepared.drafts);
        let palettes = Arc::clone(&prepared.palettes);
        let work = move |context: &Context<Outcome>| {
            let cancel = context.cancel();
            let like = like.map(|like| palette(&library, &palettes, like, cancel));
            let like = like.transpose().map_err(failed)?;
            let of_maker = like.as_deref().filter(|_| of_maker.is_some());
            let plain = drafts.make(&library, &parts, of_maker, cancel);
            let Some(plain) = plain.map_err(failed)? else {
                return Ok(Outcome::Vary(VaryOutcome::Draft(key, None)));
            };
            let put = |season: SeasonChoice| {
                let season = SeasonChoice {
                    evergreen: season.evergreen.or(evergreen),
                    ..season
                };
                let tree = Tree {
                    image: plain.image.clone(),
                    labels: plain.labels.clone(),
                };
                let leaves = like.as_ref().map(|palette| palette.crown());
                in_season(tree, Some(season), leaves, cancel)
            };
            let in_season = season.map(put).transpose()?;
            let mixed = Box::new(Mixed {
                plain_key,
                plain,
                evergreen,
                in_season,
            });
            Ok(Outcome::Vary(VaryOutcome::Draft(key, Some(mixed))))
        };
        let request = Request::new("Mixing", topic("draft"), Priority::Interactive, work);
        self.jobs.submit(request);
    }

    /// Shows the mix in all seasons, unless a hand is about to change it.
    fn draw_seasons(&mut self) {
        let Some((_, draft)) = &self.vary.draft else {
            return;
        };
        let key = draft.plain_key;
        if self.document.is_in_gesture() || self.vary.asked_seasons == Some(key) {
            return;
        }
        self.vary.asked_seasons = Some(key);
        let draft = Arc::clone(draft);
        let work = move |context: &Context<Outcome>| {
            let tree = small_tree(&draft.plain);
            let cancel = context.cancel();
            let put = |season: Option<Season>| {
                let season = season.map(|season| SeasonChoice {
                    settings: SeasonSettings::of(season),
                    evergreen: draft.evergreen,
                });
                in_season(tree.clone(), season, None, cancel).map(Arc::new)
            };
            let seasons: Seasons = [
                put(None)?,
                put(Some(Season::Spring))?,
                put(Some(Season::Summer))?,
                put(Some(Season::Autumn))?,
                put(Some(Season::Winter))?,
            ];
            let seasons = VaryOutcome::Seasons(key, Box::new(seasons));
            Ok(Outcome::Vary(seasons))
        };
        let request = Request::new("Seasons", topic("seasons"), Priority::Preview, work);
        self.jobs.submit(request);
    }

    /// Finds how much the trees of `keys` repeat each other, once all of them were made.
    pub(super) fn score(&mut self, keys: Vec<Digest>) {
        self.vary.score = None;
        let Some(pictures) = self.vary.pictures(&keys) else {
            return;
        };
        self.vary.asked_score.clone_from(&keys);
        let work = move |context: &Context<Outcome>| {
            let cancel = context.cancel();
            let look = |image: &Arc<Image<Straight>>| Look::of(&image.premultiplied(), cancel);
            let looks = pictures.iter().map(look).collect::<Result<Vec<_>, _>>()?;
            let looks: Option<Vec<Look>> = looks.into_iter().collect();
            let clear = || JobError::failed("one of the pictures is clear");
            let looks = looks.ok_or_else(clear)?;
            let repetition = Repetition::among(&looks, context.progress(), cancel)?;
            let score = Box::new(Scored { keys, repetition });
            Ok(Outcome::Vary(VaryOutcome::Score(score)))
        };
        let request = Request::new(
            "Comparing trees",
            topic("score"),
            Priority::Interactive,
            work,
        );
        self.jobs.submit(request);
    }

    /// Shows a tree over the whole gallery and makes it at full size.
    pub(super) fn open_large(&mut self, cell: Cell) {
        let Some(maker) = self.gallery_maker() else {
            return;
        };
        self.vary.large = Some(Large {
            cell: cell.clone(),
            image: None,
        });
        let work = move |context: &Context<Outcome>| {
            let mut makers = Makers::default();
            let (image, _) = maker.made(&mut makers, &cell, context.cancel())?;
            let outcome = VaryOutcome::Large(cell.key, Arc::new(image));
            Ok(Outcome::Vary(outcome))
        };
        let request = Request::new(
            "Growing a tree",
            topic("large"),
            Priority::Interactive,
            work,
        );
        self.jobs.submit(request);
    }
}
