//! Pictures on the graphics card, by digest: only those that were drawn in the last frames.

use super::color_image;
use crate::base::Digest;
use crate::raster::{Image, Straight};
use egui::{Context, TextureHandle, TextureOptions, Ui};
use std::collections::BTreeMap;

/// Frames that a texture outlives its last use: scrolling back and forth loads nothing.
const PATIENCE: u64 = 120;

/// The textures of a panel.
#[derive(Default)]
pub(super) struct Textures {
    known: BTreeMap<Digest, (TextureHandle, u64)>,
}

impl Textures {
    /// The texture of `image`, whose digest is `key`.
    pub(super) fn of(
        &mut self,
        ctx: &Context,
        key: Digest,
        image: &Image<Straight>,
    ) -> &TextureHandle {
        let now = ctx.cumulative_frame_nr();
        let known = self.known.entry(key).or_insert_with(|| {
            let picture = color_image(image);
            let texture = ctx.load_texture("tree", picture, TextureOptions::LINEAR);
            (texture, now)
        });
        known.1 = now;
        &known.0
    }

    /// The texture with this key, if there is one.
    pub(super) fn known(&mut self, ctx: &Context, key: Digest) -> Option<&TextureHandle> {
        let (texture, used) = self.known.get_mut(&key)?;
        *used = ctx.cumulative_frame_nr();
        Some(texture)
    }

    /// Forgets what was not drawn for a while; to be called once a frame.
    pub(super) fn sweep(&mut self, ui: &Ui) {
        let now = ui.ctx().cumulative_frame_nr();
        self.known
            .retain(|_, (_, used)| now.saturating_sub(*used) <= PATIENCE);
    }
}
