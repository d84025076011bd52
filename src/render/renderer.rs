//! One door to both renderers.

use super::gpu::{Gpu, GpuRenderer};
use super::proxy::Proxy;
use super::{RenderError, RenderSettings, SceneView, cpu};
use crate::base::{Cancel, Progress};
use crate::raster::{Image, Straight};

/// Who draws.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Backend {
    /// The graphics card.
    Gpu,
    /// The processor.
    Cpu,
}

/// Draws scenes.
#[derive(Debug)]
pub enum Renderer {
    /// On a graphics card.
    Gpu(Box<GpuRenderer>),
    /// On the processor.
    Cpu,
}

impl Renderer {
    /// A renderer without a window.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] and other troubles of a graphics card; never for the processor.
    pub fn new(backend: Backend) -> Result<Self, RenderError> {
        Ok(match backend {
            Backend::Cpu => Self::Cpu,
            Backend::Gpu => {
                let renderer = GpuRenderer::new(Gpu::offscreen()?, Proxy::default())?;
                Self::Gpu(Box::new(renderer))
            }
        })
    }

    /// Who draws, for people.
    pub fn name(&self) -> String {
        match self {
            Self::Gpu(renderer) => renderer.gpu().name(),
            Self::Cpu => "processor".to_owned(),
        }
    }

    /// A picture of a scene.
    ///
    /// # Errors
    /// [`RenderError`].
    pub fn picture(
        &mut self,
        view: &SceneView<'_>,
        settings: &RenderSettings,
        cancel: &Cancel,
    ) -> Result<Image<Straight>, RenderError> {
        cancel.check()?;
        match self {
            Self::Gpu(renderer) => renderer.picture(view, settings),
            Self::Cpu => Ok(cpu::picture(view, settings, &Progress::silent(), cancel)?),
        }
    }
}
