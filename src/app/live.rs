//! The crown of the shown photograph, made anew after every edit.
//!
//! Two kinds of jobs: a *quick* one, of which one is under way at most, so that a hand that moves
//! always sees something; and, once the hand rests and the quick one has caught up, a *full* one. Every
//! edit has a serial number that goes with the jobs it causes, and no result replaces one of a later
//! edit.

use super::outcome::Outcome;
use super::panels::screen::{light, meshes, settings};
use super::preferences::Navigation;
use super::studio::{Severity, Studio};
use crate::base::write_atomic;
use crate::document::{CrownSettings, PhotoId};
use crate::geometry::Point;
use crate::jobs::{Context, JobError, JobId, Priority, Request, Topic};
use crate::pipeline::{
    CrownError, CrownRequest, LiveCrown, LiveInput, LiveResult, Quality, is_crown,
};
use crate::raster::{Compression, Image, Straight, encode_png};
use crate::render::{
    Backend, LeafSet, PreparedCrown, PreparedMesh, RenderSettings, Renderer, SceneView, cpu,
};
use crate::scene::{Backdrop, Camera, Crown, CrownInstance, Light, Trunk};
use glam::DVec3;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

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
            Self::Wireframe => "Wireframe",
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
    /// Draws a picture on the processor, with these leaves.
    Picture(Box<PictureRequest>, Arc<LeafSet>),
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
    /// Places along its silhouette, see [`LiveResult::silhouette`].
    pub(super) silhouette: Arc<[(f64, Point)]>,
    /// The labels of its sub-crowns.
    pub(super) sub_crowns: Vec<u8>,
    color_version: u64,
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
    picture_job: Option<JobId>,
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

const PICTURE: Topic = Topic {
    kind: "picture of a crown",
    item: 0,
};

impl Live {
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
            LiveAction::Picture(request, leaves) => self.draw_on_processor(*request, leaves),
        }
    }

    /// Looks whether the crown that is shown is still the one that is wanted, and if not has it made.
    pub(super) fn follow_live(&mut self) {
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
            let photo = wanted.as_ref().map(|wanted| wanted.photo);
            if live.shown.as_ref().map(|shown| shown.photo) != photo {
                live.shown = None;
            }
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
        (fits && has_crown).then(|| Wanted {
            photo: id,
            input: LiveInput {
                photo: Arc::clone(photo),
                labels,
            },
            settings: content.crowns.get(&id).cloned().unwrap_or_default(),
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
            let work = move |context: &Context<Outcome>| making.quick(context);
            let request = Request::new("Shaping the crown", QUICK, Priority::Interactive, work);
            self.live.quick = Some((self.jobs.submit(request), serial));
        } else if self.live.full_done < serial && self.live.full.is_none() && rests {
            let Some(making) = self.making(wanted, serial) else {
                return;
            };
            let work = move |context: &Context<Outcome>| making.full(context);
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
                let is_of_photo = wanted.is_some_and(|wanted| wanted.photo == shown.photo);
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

    /// Draws a picture; one at a time, so that a view in motion is seen to move.
    fn draw_on_processor(&mut self, request: PictureRequest, leaves: Arc<LeafSet>) {
        if self.live.picture_job.is_some() {
            return;
        }
        let Some(shown) = self.live.shown.clone() else {
            return;
        };
        self.live.picture_wanted = Some(request.clone());
        let drawn = self.live.drawn;
        let work = move |context: &Context<Outcome>| {
            let view = SceneView {
                crowns: std::slice::from_ref(&shown.prepared),
                instances: &[CrownInstance::plain(0)],
                meshes: &meshes(&shown, drawn),
                leaves: &leaves,
                camera: &request.camera,
                light: &request.light,
                backdrop: request.backdrop,
            };
            let progress = context.progress();
            let picture = cpu::picture(&view, &request.settings, &progress, context.cancel())?;
            Ok(Outcome::Live(LiveOutcome::Picture(picture)))
        };
        let request = Request::new("Drawing the crown", PICTURE, Priority::Interactive, work);
        self.live.picture_job = Some(self.jobs.submit(request));
    }
}

/// Samples along each side of a pixel of a picture that is kept.
const KEPT_FINENESS: u32 = 3;

impl Studio {
    /// Draws what the view shows once more, finely, and writes it to `path`.
    fn save_picture(&mut self, path: PathBuf) {
        let (Some(shown), Some((camera, size))) = (self.live.shown.clone(), self.live.seen) else {
            return;
        };
        let (drawn, backdrop, light) = (self.live.drawn, self.live.backdrop, light(self));
        let work = move |context: &Context<Outcome>| {
            let view = SceneView {
                crowns: std::slice::from_ref(&shown.prepared),
                instances: &[CrownInstance::plain(0)],
                meshes: &meshes(&shown, drawn),
                leaves: &LeafSet::default(),
                camera: &camera,
                light: &light,
                backdrop,
            };
            let settings = RenderSettings {
                fineness: KEPT_FINENESS,
                ..settings(drawn, size)
            };
            let drawn_by = |backend| {
                let mut renderer = Renderer::new(backend)?;
                renderer.picture(&view, &settings, context.cancel())
            };
            let picture = match drawn_by(Backend::Gpu) {
                Err(error) if error.is_of_device() => drawn_by(Backend::Cpu),
                other => other,
            };
            let picture = picture.map_err(JobError::failed)?;
            let bytes = encode_png(&picture, Compression::Small);
            write_atomic(&path, &bytes).map_err(JobError::failed)?;
            Ok(Outcome::Live(LiveOutcome::Saved(path)))
        };
        let topic = Topic {
            kind: "saved picture",
            item: 0,
        };
        self.jobs.submit(Request::new(
            "Saving a picture",
            topic,
            Priority::Interactive,
            work,
        ));
    }
}

/// A job's share of the work.
struct Making {
    photo: PhotoId,
    input: LiveInput,
    request: CrownRequest,
    serial: u64,
    cache: Arc<Mutex<LiveCrown>>,
    /// What is shown now.
    last: Option<Arc<ShownCrown>>,
    cells: Option<u32>,
}

impl Making {
    fn quick(&self, context: &Context<Outcome>) -> Result<Outcome, JobError> {
        let is_inflated = self.cached().is_inflated(&self.input);
        let quality = if is_inflated {
            Quality::Fine
        } else {
            Quality::Coarse
        };
        self.outcome(quality, context)
    }

    fn full(&self, context: &Context<Outcome>) -> Result<Outcome, JobError> {
        if !self.cached().is_inflated(&self.input) {
            context.publish(self.outcome(Quality::Fine, context)?);
        }
        self.outcome(Quality::Full, context)
    }

    /// A copy of what is known so far.
    fn cached(&self) -> LiveCrown {
        let cache = self.cache.lock();
        cache.unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn outcome(&self, quality: Quality, context: &Context<Outcome>) -> Result<Outcome, JobError> {
        let mut live = self.cached();
        let cancel = context.cancel();
        let made = live.update(
            &self.input,
            &self.request,
            quality,
            context.progress(),
            cancel,
        );
        let cache = self.cache.lock();
        cache.unwrap_or_else(PoisonError::into_inner).adopt(live);
        let outcome = match made {
            Ok(made) => LiveOutcome::Crown(Box::new(self.prepared(made, quality, context)?)),
            Err(error) if error.is_cancelled() => return Err(crate::base::Cancelled.into()),
            Err(error) => LiveOutcome::Failed(self.serial, told(&error)),
        };
        Ok(Outcome::Live(outcome))
    }

    /// What a renderer needs; as much as can be of what is shown now.
    fn prepared(
        &self,
        LiveResult {
            crown,
            color_version,
            silhouette,
            sub_crowns,
        }: LiveResult,
        quality: Quality,
        context: &Context<Outcome>,
    ) -> Result<ShownCrown, JobError> {
        let last = self.last.as_ref().filter(|last| {
            let same = last.photo == self.photo && last.color_version == color_version;
            same && quality != Quality::Full
        });
        let trunk = Trunk::under(&crown);
        let surface = self
            .cells
            .map(|cells| (cells, PreparedMesh::of_crown(&crown, cells)));
        let (prepared, mesh, bounds) = match last {
            Some(last) => (
                last.prepared.reshaped(&crown),
                last.trunk.clone(),
                last.bounds,
            ),
            None => (
                PreparedCrown::new(&crown, context.cancel())?.on_stem(&trunk),
                PreparedMesh::of_trunk(&trunk, &crown),
                crown.tree_bounds(),
            ),
        };
        Ok(ShownCrown {
            photo: self.photo,
            serial: self.serial,
            quality,
            crown,
            prepared,
            trunk: mesh,
            surface,
            bounds,
            silhouette,
            sub_crowns,
            color_version,
        })
    }
}

/// Why there is no crown, in the words of the panel.
fn told(error: &CrownError) -> String {
    error.to_string()
}
