//! Where the crown's picture comes from: the window's graphics card, or the processor.

use super::super::action::Action;
use super::super::live::{Drawn, LiveAction, PictureRequest, ShownCrown, leaves};
use super::super::studio::Studio;
use super::color_image;
use crate::render::{
    Gpu, Mode, PreparedMesh, RenderError, RenderSettings, SceneView, Shown, View, Viewport,
};
use crate::scene::{Camera, CrownInstance, Light};
use eframe::egui_wgpu::RenderState;
use egui::{TextureHandle, TextureId, TextureOptions};

/// Longest side of a picture of the processor, pixels.
const CPU_PX: f32 = 420.0;

/// Shows pictures of scenes.
pub(super) struct Screen {
    /// The window's device, as long as there is the window.
    gpu: Option<Gpu>,
    /// What draws on it, until that fails.
    card: Option<Card>,
    /// Why there is no card.
    pub(super) trouble: Option<String>,
    /// A picture of the processor, by its number.
    picture: Option<(u64, TextureHandle)>,
}

struct Card {
    state: RenderState,
    viewport: Viewport,
    /// What is shown, by its number.
    texture: Option<(u64, TextureId)>,
    /// What was drawn last.
    drawn: Option<PictureRequest>,
}

/// All that is to be seen.
pub(super) struct Look<'a> {
    pub(super) shown: &'a ShownCrown,
    pub(super) camera: Camera,
    pub(super) light: Light,
    /// Pixels of the screen.
    pub(super) size: (u32, u32),
}

impl Look<'_> {
    /// All that the picture depends on.
    fn request(&self, studio: &Studio, settings: RenderSettings) -> PictureRequest {
        PictureRequest {
            serial: self.shown.serial,
            quality: self.shown.quality,
            has_surface: self.shown.surface.is_some(),
            camera: self.camera,
            light: self.light,
            backdrop: studio.live.backdrop,
            settings,
        }
    }
}

impl Screen {
    pub(super) fn new(state: Option<&RenderState>) -> Self {
        let device = |state: &RenderState| {
            let info = state.adapter.get_info();
            Gpu::new(state.device.clone(), state.queue.clone(), info)
        };
        let gpu = state.map(device);
        let card = state.zip(gpu.clone()).map(|(state, gpu)| {
            Viewport::new(gpu).map(|viewport| Card {
                state: state.clone(),
                viewport,
                texture: None,
                drawn: None,
            })
        });
        let (card, trouble) = match card {
            Some(Ok(card)) => (Some(card), None),
            Some(Err(error)) => (None, Some(error.to_string())),
            None => (None, Some("no graphics card can be used".to_owned())),
        };
        Self {
            gpu,
            card,
            trouble,
            picture: None,
        }
    }

    /// Whether the window's device was lost.
    pub(super) fn has_lost_card(&self) -> bool {
        self.gpu.as_ref().is_some_and(Gpu::is_lost)
    }

    /// Loses that device, to try out what comes of it.
    #[cfg(debug_assertions)]
    pub(super) fn lose_card(&self) {
        if let Some(card) = &self.card {
            card.state.device.destroy();
        }
    }

    /// The texture to show and whether it is all that was asked for; `None` before there is one.
    pub(super) fn texture(
        &mut self,
        ctx: &egui::Context,
        studio: &Studio,
        look: &Look<'_>,
        actions: &mut Vec<Action>,
    ) -> Option<(TextureId, bool)> {
        if let Some(card) = &mut self.card {
            match card.drawn(studio, look) {
                Ok(drawn) => return Some(drawn),
                Err(error) => {
                    self.trouble = Some(error.to_string());
                    self.card = None;
                }
            }
        }
        self.of_processor(ctx, studio, look, actions)
    }

    fn of_processor(
        &mut self,
        ctx: &egui::Context,
        studio: &Studio,
        look: &Look<'_>,
        actions: &mut Vec<Action>,
    ) -> Option<(TextureId, bool)> {
        let (width, height) = look.size;
        let scale = (CPU_PX / width.max(height) as f32).min(1.0);
        let scaled = |side: u32| ((side as f32 * scale) as u32).max(1);
        let settings = RenderSettings {
            size: (scaled(width), scaled(height)),
            fineness: 1,
            ..settings(studio.live.drawn, look.size)
        };
        let request = look.request(studio, settings);
        let is_new = studio.live.picture_wanted.as_ref() != Some(&request);
        if is_new && !studio.live.is_drawing() {
            actions.push(Action::Live(LiveAction::Picture(Box::new(request))));
        }
        let (number, image) = studio.live.picture.as_ref()?;
        if self.picture.as_ref().is_none_or(|(of, _)| of != number) {
            let image = color_image(image);
            let texture = ctx.load_texture("crown", image, TextureOptions::LINEAR);
            self.picture = Some((*number, texture));
        }
        // A job wakes the window when the next one is there.
        self.picture
            .as_ref()
            .map(|(_, texture)| (texture.id(), true))
    }
}

impl Card {
    fn drawn(
        &mut self,
        studio: &Studio,
        look: &Look<'_>,
    ) -> Result<(TextureId, bool), RenderError> {
        let wanted = look.request(studio, settings(studio.live.drawn, look.size));
        if let Some((_, id)) = self.texture
            && studio.live.is_growing()
            && self.viewport.gpu().is_software()
            && self.drawn.as_ref() == Some(&wanted)
        {
            // The processor has better things to do than to refine what is about to change.
            return Ok((id, true));
        }
        // While the card works, the viewport shows the last scene and takes up none.
        let takes_up = self.viewport.is_idle()?;
        self.drawn = Some(wanted).filter(|_| takes_up);
        let meshes = meshes(look.shown, studio.live.drawn);
        let view = SceneView {
            crowns: std::slice::from_ref(&look.shown.prepared),
            instances: &[CrownInstance::plain(0)],
            meshes: &meshes,
            leaves: leaves(look.shown.leaf),
            camera: &look.camera,
            light: &look.light,
            backdrop: studio.live.backdrop,
        };
        let settings = settings(studio.live.drawn, look.size);
        let shown = self.viewport.draw(&view, &settings)?;
        let mut renderer = self.state.renderer.write();
        let device = &self.state.device;
        let id = match self.texture {
            Some((of, id)) if of == shown.generation => id,
            Some((_, id)) => {
                renderer.update_egui_texture_from_wgpu_texture(
                    device,
                    shown.picture,
                    Shown::FILTER,
                    id,
                );
                id
            }
            None => renderer.register_native_texture(device, shown.picture, Shown::FILTER),
        };
        self.texture = Some((shown.generation, id));
        Ok((id, shown.is_final))
    }
}

/// The triangles of the picture.
pub(in super::super) fn meshes(shown: &ShownCrown, drawn: Drawn) -> Vec<PreparedMesh> {
    let mut meshes = Vec::new();
    if drawn != Drawn::Wireframe {
        // Its triangles are so small that the stem would be black.
        meshes.push(shown.trunk.clone());
    }
    if matches!(drawn, Drawn::Mesh | Drawn::Wireframe) {
        meshes.extend(shown.surface.iter().map(|(_, mesh)| mesh.clone()));
    }
    meshes
}

/// How a picture of `size` is drawn.
pub(in super::super) fn settings(drawn: Drawn, size: (u32, u32)) -> RenderSettings {
    RenderSettings {
        size,
        mode: match drawn {
            Drawn::Relief => Mode::Relief,
            Drawn::Leaves => Mode::Leaves,
            Drawn::Mesh | Drawn::Wireframe => Mode::Mesh,
        },
        view: match drawn {
            Drawn::Wireframe => View::Wireframe,
            _ => View::Picture,
        },
        ..RenderSettings::default()
    }
}

/// The light of the project.
pub(in super::super) fn light(studio: &Studio) -> Light {
    let (sun_yaw_deg, sun_pitch_deg) = studio.document().view().sun_deg;
    Light {
        sun_yaw_deg,
        sun_pitch_deg,
        ..Light::DAY
    }
}
