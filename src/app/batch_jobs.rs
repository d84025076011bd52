//! Batches and exports as jobs: what `boscage vary` and `boscage export` do, from the project's
//! pictures in memory.

use super::outcome::Outcome;
use super::studio::{Severity, Studio};
use super::vary_jobs::VaryOutcome;
use crate::base::{Progress, with_threads};
use crate::batch::export::{Export, ExportSettings};
use crate::batch::export_crown::CrownExportSettings;
use crate::batch::export_tree::{BlockName, ModelTextures};
use crate::batch::failure::Failure;
use crate::batch::output::{Output, Policy};
use crate::batch::run::{Run, Shard};
use crate::batch::vary::{Plan, Trees, Vary};
use crate::batch::{ExportMap, ImpostorName, MapName, TextureForm};
use crate::branches::leaf_name::LeafName;
use crate::document::PhotoId;
use crate::export::{LicenseRecord, Preset, SpriteSettings, WindChannels};
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use crate::pipeline::{GalleryTree, choice_settings};
use crate::raster::{Image, Straight};
use crate::segment::Auto;
use crate::variation::{ExemplarSettings, LibraryPicture};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The job that writes trees.
pub(super) const BATCH: &str = "batch";

/// Where an export's own trees lie, below its folder.
const SOURCES: &str = "trees";

/// Where the exemplars of a batch lie beside it.
const EXEMPLARS: &str = "exemplars";

/// Which trees are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Which {
    /// That many, drawn with the gallery's seed: what `boscage vary` would make.
    Drawn(u32),
    /// Those that the gallery shows.
    Gallery,
    /// The favourites.
    Favourites,
    /// The crown of the shown photograph.
    ShownCrown,
    /// The crowns of all photographs that have one.
    Crowns,
}

impl Which {
    /// Whether crowns are meant, and not pictures of trees.
    pub fn is_of_crowns(self) -> bool {
        matches!(self, Self::ShownCrown | Self::Crowns)
    }
}

/// What to write.
#[derive(Debug, Clone, PartialEq)]
pub struct BatchSettings {
    /// Which trees.
    pub which: Which,
    /// Where to.
    pub folder: PathBuf,
    /// Side of the trees' pictures, pixels.
    pub size: u32,
    /// Further pictures of each tree.
    pub maps: BTreeSet<MapName>,
    /// Whether all trees are also drawn on one sheet.
    pub has_sheet: bool,
    /// Texels along a face of the crowns that trees are also inflated to, if they are.
    pub crowns: Option<u32>,
    /// Whether files that are there are written over; else what is done stays.
    pub replaces: bool,
    /// The export of the trees, if they are not only pictures.
    pub export: Option<ExportChoice>,
}

/// How trees are exported.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportChoice {
    /// For whom.
    pub preset: Preset,
    /// Height of each tree, metres.
    pub height_m: f64,
    /// Maps beside the colours.
    pub maps: Vec<ExportMap>,
    /// Forms of texture files beside PNG.
    pub textures: Vec<TextureForm>,
    /// What the pictures inside models are.
    pub model_textures: ModelTextures,
    /// Whether all trees are also put on atlas pages.
    pub has_atlas: bool,
    /// Leaves of all crowns; none: each has its own.
    pub leaves: Option<LeafName>,
    /// Impostors of crowns.
    pub impostors: BTreeSet<ImpostorName>,
    /// Whether the cubemaps of crowns are also written as OpenEXR.
    pub exr: bool,
    /// Whose work it is; empty: not said.
    pub author: String,
    /// What others may do with it, an SPDX name; empty: not said.
    pub license: String,
}

impl Default for BatchSettings {
    fn default() -> Self {
        Self {
            which: Which::Drawn(50),
            folder: PathBuf::new(),
            size: ExemplarSettings::default().size,
            maps: BTreeSet::new(),
            has_sheet: true,
            crowns: None,
            replaces: false,
            export: None,
        }
    }
}

impl Default for ExportChoice {
    fn default() -> Self {
        Self {
            preset: Preset::Blender,
            height_m: 10.0,
            maps: vec![ExportMap::Normal, ExportMap::Ao],
            textures: Vec::new(),
            model_textures: ModelTextures::Png,
            has_atlas: false,
            leaves: None,
            impostors: [ImpostorName::Full, ImpostorName::Hemisphere].into(),
            exr: false,
            author: String::new(),
            license: String::new(),
        }
    }
}

impl ExportChoice {
    /// The settings that `boscage export` has for the same flags.
    pub(super) fn settings(&self, out: &Path) -> ExportSettings {
        let mut maps = self.maps.clone();
        maps.sort_by_key(|map| map.name());
        maps.dedup();
        if self.preset == Preset::Web && !maps.is_empty() && !maps.contains(&ExportMap::Depth) {
            // The gallery turns trees by their depth.
            maps.push(ExportMap::Depth);
        }
        let mut textures = self.textures.clone();
        textures.push(TextureForm::Png);
        textures.sort();
        textures.dedup();
        ExportSettings {
            out: out.to_owned(),
            preset: self.preset,
            sprite: SpriteSettings {
                height_m: self.height_m,
                power_of_two: true,
            },
            planes: 3,
            maps,
            textures,
            model_textures: self.model_textures,
            blocks: BlockName::default().format(),
            atlas: self.has_atlas,
            atlas_tree: 256,
            evergreen: false,
            wind: WindChannels::Attribute,
            rights: LicenseRecord {
                author: said(&self.author),
                license: said(&self.license),
            },
            crowns: CrownExportSettings {
                impostors: self.impostors.iter().copied().collect(),
                frames: 8,
                frame_px: 256,
                exr: self.exr,
                leaves: self.leaves,
            },
        }
    }
}

/// What a field says, unless it is empty.
fn said(field: &str) -> Option<String> {
    let field = field.trim();
    (!field.is_empty()).then(|| field.to_owned())
}

/// A batch with all that it needs, for a job to own.
struct Batch {
    settings: BatchSettings,
    vary: Vary,
    segmenter: &'static Auto,
    seed: u64,
}

impl Studio {
    /// Writes trees in a job beside the window.
    pub(super) fn make_batch(&mut self, settings: BatchSettings) {
        if let (true, Some(choice)) = (settings.which.is_of_crowns(), settings.export.clone()) {
            let BatchSettings {
                which,
                folder,
                replaces,
                ..
            } = settings;
            self.export_crowns(which, folder, replaces, choice);
            return;
        }
        let name = match &settings.export {
            Some(export) => format!("Exporting for {}", export.preset.name()),
            None => "Making trees".to_owned(),
        };
        let Some(batch) = self.batch(settings) else {
            self.notify(Severity::Warning, "There are no trees to write.");
            return;
        };
        self.vary.batch_tree = None;
        let work = move |context: &Context<Outcome>| {
            let told = batch.run(context)?;
            Ok(Outcome::Vary(VaryOutcome::Wrote(told)))
        };
        // Batches do not supersede each other.
        let topic = Topic {
            kind: BATCH,
            item: self.next_notice,
        };
        self.next_notice += 1;
        let request = Request::new(name, topic, Priority::Background, work);
        self.jobs.submit(request);
    }

    /// The pictures of the project with these numbers, as a library takes them.
    fn library_pictures(&self, photos: &[PhotoId]) -> Vec<LibraryPicture> {
        let all = &self.document.state().content().photos;
        let picture = |id: &PhotoId| {
            let bytes = self.document.photo_bytes(*id)?;
            Some(LibraryPicture {
                path: PathBuf::from(&all.get(id)?.name),
                bytes: Some(Arc::clone(bytes)),
                pins: self.document.state().content().pins.get(id).copied(),
            })
        };
        photos.iter().filter_map(picture).collect()
    }

    fn batch(&self, settings: BatchSettings) -> Option<Batch> {
        let own = &self.document.state().content().variation;
        let prepared = self.vary.prepared.as_ref()?;
        let cells = match settings.which {
            Which::Drawn(_) | Which::ShownCrown | Which::Crowns => Vec::new(),
            Which::Gallery => self.vary.gallery.clone(),
            Which::Favourites => self.vary.favourites.clone(),
        };
        let trees: Vec<GalleryTree> = cells.into_iter().map(|cell| cell.tree).collect();
        let mut likes: Vec<usize> = trees.iter().flat_map(GalleryTree::likes).collect();
        likes.extend(self.vary.wishes.like);
        likes.sort_unstable();
        likes.dedup();
        let mut like_photos: Vec<PhotoId> = likes.iter().map(|at| prepared.photos[*at]).collect();
        let (trees, photos, has_target) = match settings.which {
            Which::Drawn(count) => {
                let members = self.vary.pool.members.iter();
                let photos: Vec<PhotoId> = members.map(|index| prepared.photos[*index]).collect();
                (Trees::Drawn(count), photos, self.vary.pool.has_target)
            }
            _ => {
                let plan = Plan {
                    pool: self.vary.pool.clone(),
                    trees,
                    likes,
                    like: self.vary.wishes.like,
                };
                (Trees::Planned(plan), prepared.photos.clone(), false)
            }
        };
        let is_empty = matches!(&trees, Trees::Planned(plan) if plan.trees.is_empty());
        if is_empty || photos.is_empty() {
            return None;
        }
        if matches!(settings.which, Which::Drawn(_)) {
            like_photos = own.like.into_iter().collect();
        }
        let out = settings.out();
        let vary = Vary {
            folder: PathBuf::from(EXEMPLARS),
            pictures: self.library_pictures(&photos),
            has_target,
            trees,
            likes: self.library_pictures(&like_photos),
            maps: settings.maps.clone(),
            sheet: settings.has_sheet.then(|| out.join("sheet.png")),
            settings: ExemplarSettings {
                size: settings.size,
                ..ExemplarSettings::default()
            },
            choice: choice_settings(own),
            season: own.season,
            crowns: settings.crowns,
            cache: None,
        };
        let seed = own.seed;
        Some(Batch {
            settings,
            vary,
            segmenter: self.segmenter(),
            seed,
        })
    }
}

impl BatchSettings {
    /// Where the trees' pictures go.
    fn out(&self) -> PathBuf {
        match self.export {
            Some(_) => self.folder.join(SOURCES),
            None => self.folder.clone(),
        }
    }
}

impl Batch {
    /// Writes everything; what is told the user.
    fn run(&self, context: &Context<Outcome>) -> Result<String, JobError> {
        let policy = if self.settings.replaces {
            Policy::Overwrite
        } else {
            Policy::Resume
        };
        let gate = || context.check();
        let shown = |image: &Image<Straight>| {
            let small = super::vary_making::reduced(&image.premultiplied(), super::vary::TILE_PX);
            let tree = VaryOutcome::BatchTree(Arc::new(small.straight()));
            context.publish(Outcome::Vary(tree));
        };
        // Threads of its own: one that a pause holds up is nobody else's.
        let cores = std::thread::available_parallelism().map_or(2, usize::from);
        let threads = (cores - 1).max(1);
        let progress: Progress<'_> = context.progress();
        let told = with_threads(Some(threads), || {
            let run = Run {
                seed: self.seed,
                shard: Shard::default(),
                progress,
                cancel: context.cancel(),
                output: Output::new(policy, context.cancel()),
                gate: Some(&gate),
                shown: Some(&shown),
            };
            self.written(&run)
        });
        let told = told.map_err(JobError::failed)?;
        told.map_err(|failure| match failure {
            Failure::Cancelled => JobError::Cancelled(crate::base::Cancelled),
            failure => JobError::failed(failure),
        })
    }

    fn written(&self, run: &Run<'_>) -> Result<String, Failure> {
        let out = self.settings.out();
        self.keep_exemplars(&out, run)?;
        let record = self.vary.run(self.segmenter, &out, run)?;
        let folder = self.settings.folder.display();
        let Some(choice) = &self.settings.export else {
            return Ok(format!("Made {} trees in {folder}", record.trees.len()));
        };
        let settings = choice.settings(&self.settings.folder);
        let export = Export {
            settings: &settings,
            trees: &record.trees,
            folder: &out,
        };
        let made = export.run(run)?;
        let name = choice.preset.name();
        Ok(format!(
            "Exported {} trees for {name} to {folder}",
            made.records.len()
        ))
    }

    /// Writes the exemplars beside the batch, so that it can be made again from its record.
    fn keep_exemplars(&self, out: &Path, run: &Run<'_>) -> Result<(), Failure> {
        let folder = out.join(EXEMPLARS);
        for picture in self.vary.pictures.iter().chain(&self.vary.likes) {
            run.check()?;
            let name = picture.path.file_name();
            if let (Some(name), Some(bytes)) = (name, &picture.bytes) {
                run.output.write_same(&folder.join(name), bytes)?;
            }
        }
        Ok(())
    }
}
