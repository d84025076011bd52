//! The crown of the shown photograph, made anew after every edit.
//!
//! Two kinds of jobs: a *quick* one, of which one is under way at most, so that a hand that moves
//! always sees something; and, once the hand rests and the quick one has caught up, a *full* one. Every
//! edit has a serial number that goes with the jobs it causes, and no result replaces one of a later
//! edit.

use super::live_job::Making;
use super::outcome::Outcome;
use super::preferences::Navigation;
use super::studio::{Severity, Studio};
use crate::base::Seed;
use crate::branches::leaf_name::LeafName;
use crate::document::{CrownSettings, PhotoId};
use crate::jobs::{Context, JobId, Priority, Request, Topic};
use crate::pipeline::{
    CrownRequest, LiveCrown, LiveInput, Quality, Silhouette, is_crown, leaf_of_picture,
};
use crate::raster::{Image, Straight};
use crate::render::{LeafSet, PreparedCrown, PreparedMesh, RenderSettings};
use crate::scene::{Backdrop, Camera, Crown, Light};
use glam::DVec3;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, OnceLock};

/// Squares along a side of a face where the crown is drawn as a mesh, and as wires.
const MESH_CELLS: u32 = 96;
const WIRE_CELLS: u32 = 20;

/// How the crown is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Drawn {
    /// The relief of its surface.
    #[default]
    Relief,
    /// Twigs with leaves.
    Leaves,
    /// Triangles of its surface.
    Mesh,
    /// Their edges too.
    Wireframe,
}

impl Drawn {
    /// In the order of their buttons.
    pub const ALL: [Self; 4] = [Self::Relief, Self::Leaves, Self::Mesh, Self::Wireframe];

    /// What stands on its button.
    pub fn title(self) -> &'static str {
        match self {
            Self::Relief => "Relief",
            Self::Leaves => "Leaves",
            Self::Mesh => "Mesh",
            Self::Wireframe => "Wires",
        }
    }

    /// Squares of the mesh it needs along a side of a face, if it needs one.
    fn cells(self) -> Option<u32> {
        match self {
            Self::Relief | Self::Leaves => None,
            Self::Mesh => Some(MESH_CELLS),
            Self::Wireframe => Some(WIRE_CELLS),
        }
    }
}

/// What is asked of the crown's view.
#[derive(Debug, Clone, PartialEq)]
pub enum LiveAction {
    /// Looks from elsewhere: yaw and pitch in degrees, and the distance as a share of that at which
    /// the whole tree fits.
    Camera((f64, f64), f64),
    /// Moves the sun: yaw and pitch in degrees.
    Sun((f64, f64)),
    /// Draws the crown in another way.
    Draw(Drawn),
    /// Puts something else behind it.
    Backdrop(Backdrop),
    /// Moves the camera with other buttons.
    Navigation(Navigation),
    /// The view is seen from here now, at so many pixels.
    Seen(Camera, (u32, u32)),
    /// Writes what the view shows to a file.
    SavePicture(PathBuf),
    /// Draws a picture on the processor.
    Picture(Box<PictureRequest>),
}

/// A picture for the processor to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct PictureRequest {
    /// The edit and the quality of the crown that is to be seen.
    pub(super) serial: u64,
    pub(super) quality: Quality,
    pub(super) has_surface: bool,
    pub(super) camera: Camera,
    pub(super) light: Light,
    pub(super) backdrop: Backdrop,
    pub(super) settings: RenderSettings,
}

/// A crown, ready to be drawn.
#[derive(Debug, Clone)]
pub(super) struct ShownCrown {
    pub(super) photo: PhotoId,
    /// Its pixels: photographs of two projects may have one number.
    pub(super) source: Arc<Image<Straight>>,
    /// The edit it shows.
    pub(super) serial: u64,
    pub(super) quality: Quality,
    pub(super) crown: Arc<Crown>,
    pub(super) prepared: PreparedCrown,
    pub(super) trunk: PreparedMesh,
    /// Its surface, with the squares it has.
    pub(super) surface: Option<(u32, PreparedMesh)>,
    /// The middle of the tree and the radius of a ball around it.
    pub(super) bounds: (DVec3, f64),
    pub(super) silhouette: Arc<Silhouette>,
    /// The least and the largest k along the silhouette.
    pub(super) k: Option<[f64; 2]>,
    /// The labels of its sub-crowns.
    pub(super) sub_crowns: Vec<u8>,
    pub(super) leaf: LeafName,
    pub(super) color_version: u64,
}

/// What a job of this file tells.
pub(super) enum LiveOutcome {
    /// A crown.
    Crown(Box<ShownCrown>),
    /// No crown of this edit, and why.
    Failed(u64, String),
    /// A picture of the processor.
    Picture(Image<Straight>),
    /// A picture was written to this file.
    Saved(PathBuf),
}

/// What the crown is made from.
#[derive(Debug, Clone, PartialEq)]
struct Wanted {
    photo: PhotoId,
    input: LiveInput,
    settings: CrownSettings,
    leaf: LeafName,
}

/// A job under way and the edit it is for.
type Flight = Option<(JobId, u64)>;

/// The crown that is shown and the one that is wanted.
#[derive(Default)]
pub(super) struct Live {
    cache: Arc<Mutex<LiveCrown>>,
    wanted: Option<Wanted>,
    /// The number of the edit that made `wanted`.
    serial: u64,
    quick: Flight,
    full: Flight,
    /// The latest edits for which there are results, or never will be.
    quick_done: u64,
    full_done: u64,
    pub(super) shown: Option<Arc<ShownCrown>>,
    /// Why the crown that is wanted cannot be made.
    pub(super) trouble: Option<String>,
    pub(super) drawn: Drawn,
    pub(super) backdrop: Backdrop,
    pub(super) is_turning: bool,
    /// The picture that the processor draws or has drawn last.
    pub(super) picture_wanted: Option<PictureRequest>,
    /// What it drew, with a number of its own.
    pub(super) picture: Option<(u64, Image<Straight>)>,
    pub(super) picture_job: Option<JobId>,
    /// From where the view is seen, and its pixels.
    pub(super) seen: Option<(Camera, (u32, u32))>,
}

const QUICK: Topic = Topic {
    kind: "quick crown",
    item: 0,
};
const FULL: Topic = Topic {
    kind: "full crown",
    item: 0,
};

/// What crowns with such leaves are drawn with; takes up to 200 ms the first time.
pub(super) fn leaves(leaf: LeafName) -> &'static LeafSet {
    static LEAVES: [OnceLock<LeafSet>; LeafName::ALL.len()] =
        [const { OnceLock::new() }; LeafName::ALL.len()];
    LEAVES[leaf as usize].get_or_init(|| LeafSet::new(leaf, Seed(0)))
}

impl Live {
    /// Whether the processor draws a picture.
    pub(super) fn is_drawing(&self) -> bool {
        self.picture_job.is_some()
    }

    /// Whether the crown's last and longest step is under way.
    pub(super) fn is_growing(&self) -> bool {
        self.full.is_some()
    }

    /// Whether a better crown is on its way.
    pub(super) fn is_working(&self) -> bool {
        self.quick.is_some() || self.full.is_some()
    }
}

impl Studio {
    /// The crown that is shown, if there is one, and the number of the edit it shows.
    pub fn shown_crown(&self) -> Option<(&Arc<Crown>, u64)> {
        let shown = self.live.shown.as_ref()?;
        Some((&shown.crown, shown.serial))
    }

    /// Whether the crown that is shown is all that was asked for.
    pub fn crown_is_final(&self) -> bool {
        self.live.full_done == self.live.serial && !self.live.is_working()
    }

    /// Why there is no crown for the present settings, if there is none.
    pub fn crown_trouble(&self) -> Option<&str> {
        self.live.trouble.as_deref()
    }

    pub(super) fn act_live(&mut self, action: LiveAction) {
        match action {
            LiveAction::Camera(camera_deg, distance) => {
                let view = self.document.view_mut();
                view.camera_deg = camera_deg;
                view.distance = distance;
            }
            LiveAction::Sun(sun_deg) => self.document.view_mut().sun_deg = sun_deg,
            LiveAction::Draw(drawn) => {
                self.live.drawn = drawn;
                // What is shown may lack the mesh.
                let cells = drawn.cells();
                let has = self
                    .live
                    .shown
                    .as_ref()
                    .and_then(|shown| shown.surface.as_ref());
                if cells.is_some() && cells != has.map(|(cells, _)| *cells) {
                    self.live.quick_done = 0;
                }
            }
            LiveAction::Backdrop(backdrop) => self.live.backdrop = backdrop,
            LiveAction::Navigation(navigation) => self.preferences.navigation = navigation,
            LiveAction::Seen(camera, size) => self.live.seen = Some((camera, size)),
            LiveAction::SavePicture(path) => self.save_picture(path),
            LiveAction::Picture(request) => self.draw_on_processor(*request),
        }
    }

    /// Looks whether the crown that is shown is still the one that is wanted, and if not has it made.
    pub(super) fn follow_live(&mut self) {
        if !self.preferences.live_crown {
            return;
        }
        // The quick job looks again when it ends; a copy of the mask until then is for nothing.
        if self.live.quick.is_some() && self.painting.is_some() {
            return;
        }
        let wanted = self.wanted_crown();
        if self.live.wanted != wanted {
            let live = &mut self.live;
            live.serial += 1;
            live.trouble = None;
            if let Some((job, _)) = live.full {
                self.jobs.cancel(job);
            }
            let shown = live.shown.as_ref().map(|shown| shown.serial);
            if let Some((job, _)) = live.quick.filter(|(_, serial)| shown == Some(*serial)) {
                // It has answered, and refines what nobody waits for any more.
                self.jobs.cancel(job);
            }
            let source = wanted.as_ref().map(|wanted| &wanted.input.photo);
            let is_of_source = |shown: &Arc<ShownCrown>| {
                source.is_some_and(|source| Arc::ptr_eq(source, &shown.source))
            };
            live.shown = live.shown.take().filter(is_of_source);
            live.wanted = wanted;
        }
        self.start_live_jobs();
    }

    /// What the crown should be made from now.
    fn wanted_crown(&self) -> Option<Wanted> {
        let id = self.shown()?;
        let content = self.document.state().content();
        let photo = self.photos.whole(content.photos.get(&id)?.digest)?;
        let labels = match &self.painting {
            Some(painting) if painting.photo == id => Arc::new(painting.mask.clone()),
            _ => Arc::clone(self.document.state().mask(id)?),
        };
        let fits = (photo.width(), photo.height()) == (labels.width(), labels.height());
        let is_known = |wanted: &Wanted| Arc::ptr_eq(&wanted.input.labels, &labels);
        let has_crown =
            self.live.wanted.as_ref().is_some_and(is_known) || labels.bounds(is_crown).is_some();
        let settings = content.crowns.get(&id).cloned().unwrap_or_default();
        let named = content
            .photos
            .get(&id)
            .and_then(|photo| leaf_of_picture(&photo.name));
        (fits && has_crown).then(|| Wanted {
            photo: id,
            input: LiveInput {
                photo: Arc::clone(photo),
                labels,
            },
            leaf: settings.leaf.or(named).unwrap_or_default(),
            settings,
        })
    }

    fn start_live_jobs(&mut self) {
        let Some(wanted) = self.live.wanted.clone() else {
            return;
        };
        if self.live.quick.is_some() {
            return;
        }
        let serial = self.live.serial;
        let rests = self.painting.is_none() && !self.document.is_in_gesture();
        if self.live.quick_done < serial {
            let Some(making) = self.making(wanted, serial) else {
                return;
            };
            let work = move |context: &Context<Outcome>| making.pictured().quick(context);
            let request = Request::new("Shaping the crown", QUICK, Priority::Interactive, work);
            self.live.quick = Some((self.jobs.submit(request), serial));
        } else if self.live.full_done < serial && self.live.full.is_none() && rests {
            let Some(making) = self.making(wanted, serial) else {
                return;
            };
            let work = move |context: &Context<Outcome>| making.pictured().full(context);
            let request = Request::new("Growing foliage", FULL, Priority::Preview, work);
            self.live.full = Some((self.jobs.submit(request), serial));
        }
    }

    /// All that a job needs; nothing when the settings make no sense, which is told.
    fn making(&mut self, wanted: Wanted, serial: u64) -> Option<Making> {
        match CrownRequest::of(&wanted.settings) {
            Ok(request) => Some(Making {
                photo: wanted.photo,
                input: wanted.input,
                request,
                leaf: wanted.leaf,
                serial,
                cache: Arc::clone(&self.live.cache),
                last: self.live.shown.clone(),
                cells: self.live.drawn.cells(),
            }),
            Err(error) => {
                self.live.trouble = Some(error.to_string());
                (self.live.quick_done, self.live.full_done) = (serial, serial);
                None
            }
        }
    }

    pub(super) fn accept_live(&mut self, outcome: LiveOutcome) {
        match outcome {
            LiveOutcome::Crown(shown) => {
                let wanted = self.live.wanted.as_ref();
                let is_of_photo =
                    wanted.is_some_and(|wanted| Arc::ptr_eq(&wanted.input.photo, &shown.source));
                let last = self.live.shown.as_ref();
                let is_later = last.is_none_or(|last| last.serial <= shown.serial);
                let is_better = last.is_none_or(|last| {
                    last.serial < shown.serial
                        || shown.quality == Quality::Full
                        || last.quality != Quality::Full
                });
                if is_of_photo && is_later && !is_better {
                    // Only its mesh was asked for.
                    if let Some(last) = &mut self.live.shown {
                        Arc::make_mut(last).surface = shown.surface;
                    }
                } else if is_of_photo && is_later {
                    if shown.serial == self.live.serial {
                        self.live.trouble = None;
                    }
                    self.live.shown = Some(Arc::new(*shown));
                }
            }
            LiveOutcome::Picture(image) => {
                let number = self.live.picture.as_ref().map_or(0, |(number, _)| *number);
                self.live.picture = Some((number + 1, image));
            }
            LiveOutcome::Saved(path) => {
                self.notify(Severity::Info, format!("Saved {}", path.display()));
            }
            LiveOutcome::Failed(serial, why) => {
                if serial == self.live.serial {
                    self.live.trouble = Some(why);
                    self.live.full_done = serial;
                }
            }
        }
    }

    /// A job of these ended, in whatever way.
    pub(super) fn live_job_ended(&mut self, job: JobId) {
        let live = &mut self.live;
        live.picture_job.take_if(|id| *id == job);
        if let Some((_, serial)) = live.quick.take_if(|(id, _)| *id == job) {
            live.quick_done = live.quick_done.max(serial);
        }
        if let Some((_, serial)) = live.full.take_if(|(id, _)| *id == job) {
            live.full_done = live.full_done.max(serial);
        }
    }
}
