//! Thumbnails as a panel draws them. Those that are missing are asked for while they are in sight, so
//! that a project of ten thousand pictures needs no more than a screenful.

use super::super::action::Action;
use super::super::dock::Pane;
use super::super::photos::Thumbnail;
use super::super::studio::Studio;
use super::super::theme::tokens;
use super::textures::Textures;
use crate::document::{Photo, PhotoId};
use egui::{Align2, Color32, FontId, Rect, Ui, pos2, vec2};

/// The thumbnails of a panel.
pub(super) struct Thumbnails {
    pane: Pane,
    textures: Textures,
    /// What this frame would have drawn.
    missing: Vec<PhotoId>,
    /// What was asked for last.
    asked: Vec<PhotoId>,
}

impl Thumbnails {
    /// Thumbnails of the panel `pane`.
    pub(super) fn new(pane: Pane) -> Self {
        Self {
            pane,
            textures: Textures::default(),
            missing: Vec::new(),
            asked: Vec::new(),
        }
    }

    /// The panel's textures, for pictures of its own.
    pub(super) fn textures(&mut self) -> &mut Textures {
        &mut self.textures
    }

    /// Draws a photograph into the middle of `place`, as large as it fits.
    pub(super) fn draw(
        &mut self,
        ui: &Ui,
        studio: &Studio,
        (id, photo): (PhotoId, &Photo),
        place: Rect,
        tint: Color32,
    ) {
        let known = self.textures.known(ui.ctx(), photo.digest);
        let (texture, size) = match (known, studio.photos.thumbnail(photo.digest)) {
            (Some(known), _) => (known.id(), known.size_vec2()),
            (None, Some(Thumbnail::Ready(image))) => {
                let texture = self.textures.of(ui.ctx(), photo.digest, image);
                (texture.id(), texture.size_vec2())
            }
            (None, Some(Thumbnail::Failed(_))) => {
                let (font, color) = (FontId::proportional(11.0), tokens(ui).error);
                let (at, align) = (place.center(), Align2::CENTER_CENTER);
                ui.painter().text(at, align, "unreadable", font, color);
                return;
            }
            (None, None) => {
                self.missing.push(id);
                return;
            }
        };
        let scale = (place.width() / size.x).min(place.height() / size.y);
        let rect = Rect::from_center_size(place.center(), vec2(size.x, size.y) * scale);
        let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
        ui.painter().image(texture, rect, uv, tint);
    }

    /// Asks for what was missing and forgets what is out of sight; to be called once a frame.
    pub(super) fn end_frame(&mut self, ui: &Ui, actions: &mut Vec<Action>) {
        let missing = std::mem::take(&mut self.missing);
        if missing != self.asked {
            self.asked.clone_from(&missing);
            actions.push(Action::SeePhotos(self.pane, missing));
        }
        self.textures.sweep(ui);
    }
}
