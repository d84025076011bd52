//! Pictures of the crown that are not drawn by the window's graphics card: those of the processor, and
//! those that are kept.

use super::live::{LiveOutcome, PictureRequest, leaves};
use super::outcome::Outcome;
use super::panels::screen::{light, meshes, settings};
use super::studio::Studio;
use crate::base::write_atomic;
use crate::jobs::{Context, JobError, Priority, Request, Topic};
use crate::raster::{Compression, encode_png};
use crate::render::{Backend, RenderSettings, Renderer, SceneView, cpu};
use crate::scene::CrownInstance;
use std::path::PathBuf;

const PICTURE: Topic = Topic {
    kind: "picture of a crown",
    item: 0,
};

/// Samples along each side of a pixel of a picture that is kept.
const KEPT_FINENESS: u32 = 3;

impl Studio {
    /// Draws a picture; one at a time, so that a view in motion is seen to move.
    pub(super) fn draw_on_processor(&mut self, request: PictureRequest) {
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
                leaves: leaves(shown.leaf),
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

    /// Draws what the view shows once more, finely, and writes it to `path`.
    pub(super) fn save_picture(&mut self, path: PathBuf) {
        let (Some(shown), Some((camera, size))) = (self.live.shown.clone(), self.live.seen) else {
            return;
        };
        let (drawn, backdrop, light) = (self.live.drawn, self.live.backdrop, light(self));
        let work = move |context: &Context<Outcome>| {
            let view = SceneView {
                crowns: std::slice::from_ref(&shown.prepared),
                instances: &[CrownInstance::plain(0)],
                meshes: &meshes(&shown, drawn),
                leaves: leaves(shown.leaf),
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
