//! Where the canvas looks: between pixels of the photograph and points of the screen.
//!
//! Places on the photograph are measured from its upper left corner, so the centre of its first pixel
//! is (½, ½) here and (0, 0) for the tools.

use crate::document::CanvasView;
use crate::geometry::Point;
use crate::paint::Sample;
use egui::{Pos2, Rect, Vec2};

/// Points for a pixel, at least and at most.
const ZOOMS: (f32, f32) = (0.004, 64.0);

/// Share of the panel that a fitted picture fills.
const FITTED: f32 = 0.94;

/// The canvas's view.
#[derive(Debug, Clone, Copy)]
pub(super) struct Camera {
    /// The panel, points of the screen.
    pub(super) panel: Rect,
    /// The place of the photograph in the middle of the panel.
    center: Pos2,
    /// Points for a pixel; 0 before anything was shown.
    pub(super) zoom: f32,
    /// Pixels of the screen for a point.
    pub(super) pixels_per_point: f32,
}

impl Default for Camera {
    fn default() -> Self {
        Self {
            panel: Rect::ZERO,
            center: Pos2::ZERO,
            zoom: 0.0,
            pixels_per_point: 1.0,
        }
    }
}

impl Camera {
    pub(super) fn on_screen(&self, place: Pos2) -> Pos2 {
        self.panel.center() + (place - self.center) * self.zoom
    }

    pub(super) fn on_photo(&self, point: Pos2) -> Pos2 {
        self.center + (point - self.panel.center()) / self.zoom
    }

    /// A pixel's centre on the screen.
    pub(super) fn of_pixel(&self, pixel: Point) -> Pos2 {
        self.on_screen(Pos2::new(pixel.x as f32 + 0.5, pixel.y as f32 + 0.5))
    }

    /// What the tools are told of the pointer.
    pub(super) fn sample(&self, point: Pos2) -> Sample {
        let at = self.on_photo(point);
        Sample::at(f64::from(at.x) - 0.5, f64::from(at.y) - 0.5)
    }

    /// A rectangle of the photograph on the screen.
    pub(super) fn rect_on_screen(&self, rect: Rect) -> Rect {
        Rect::from_min_max(self.on_screen(rect.min), self.on_screen(rect.max))
    }

    /// What of the photograph can be seen.
    pub(super) fn visible(&self, size: Vec2) -> Rect {
        let seen = Rect::from_min_max(self.on_photo(self.panel.min), self.on_photo(self.panel.max));
        seen.intersect(Rect::from_min_size(Pos2::ZERO, size))
    }

    /// Pixels of the screen for a pixel of the photograph.
    pub(super) fn scale(&self) -> f32 {
        self.zoom * self.pixels_per_point
    }

    /// The level of the pyramid to show, up to `most`: the first whose pixels are not smaller than
    /// those of the screen by half or more.
    pub(super) fn level(&self, most: u32) -> u32 {
        let reduction = (1.0 / self.scale().max(1e-6)).max(1.0);
        // A hair more, so that a picture at exactly half its size is not drawn from the whole.
        ((reduction.log2() + 0.01).floor() as u32).min(most)
    }

    /// The panel is here now. When only its upper edge moved, because the options above it take
    /// another line, the picture stays where it is on the screen, under the hand.
    pub(super) fn set_panel(&mut self, panel: Rect) {
        let before = std::mem::replace(&mut self.panel, panel);
        let is_same = before.max == panel.max && before.min.x == panel.min.x;
        if is_same && before.min.y != panel.min.y && self.zoom > 0.0 {
            self.center += (panel.center() - before.center()) / self.zoom;
        }
    }

    pub(super) fn fit(&mut self, size: Vec2) {
        self.center = (size / 2.0).to_pos2();
        let zoom = (self.panel.width() / size.x).min(self.panel.height() / size.y);
        self.set_zoom(zoom * FITTED);
    }

    /// Where it looks, as a project keeps it.
    pub(super) fn view(&self) -> CanvasView {
        CanvasView {
            center: (f64::from(self.center.x), f64::from(self.center.y)),
            zoom: f64::from(self.zoom),
        }
    }

    /// Looks where a project was looked at, if that is a place.
    pub(super) fn look(&mut self, view: CanvasView) {
        let (x, y) = view.center;
        let center = Pos2::new(x as f32, y as f32);
        if center.is_finite() && view.zoom > 0.0 {
            self.center = center;
            self.set_zoom(view.zoom as f32);
        }
    }

    pub(super) fn show_pixels(&mut self) {
        self.set_zoom(1.0 / self.pixels_per_point);
    }

    fn set_zoom(&mut self, zoom: f32) {
        self.zoom = zoom.clamp(ZOOMS.0, ZOOMS.1);
    }

    /// Zooms so that what is at `point` stays there.
    pub(super) fn zoom_at(&mut self, point: Pos2, factor: f32) {
        let under = self.on_photo(point);
        self.set_zoom(self.zoom * factor);
        self.center = under - (point - self.panel.center()) / self.zoom;
    }

    /// Moves the picture by `delta` points; its edge never leaves the middle of the panel.
    pub(super) fn pan(&mut self, delta: Vec2, size: Vec2) {
        let center = self.center - delta / self.zoom;
        self.center = center.clamp(Pos2::ZERO, size.to_pos2());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{pos2, vec2};

    fn camera() -> Camera {
        let mut camera = Camera {
            panel: Rect::from_min_size(pos2(100.0, 50.0), vec2(600.0, 400.0)),
            ..Camera::default()
        };
        camera.fit(vec2(8192.0, 4096.0));
        camera
    }

    #[test]
    fn the_place_under_the_pointer_stays_there() {
        let mut camera = camera();
        let pointer = pos2(250.0, 300.0);
        let before = camera.on_photo(pointer);
        camera.zoom_at(pointer, 5.0);
        assert!((camera.on_photo(pointer) - before).length() < 0.01);
        assert!((camera.on_screen(before) - pointer).length() < 0.01);
    }

    #[test]
    fn levels_are_never_coarser_than_the_screen() {
        let mut camera = camera();
        for zoom in [2.0, 1.0, 0.7, 0.5, 0.3, 0.25, 0.1, 0.01] {
            camera.zoom = zoom;
            let texel = zoom * (1 << camera.level(20)) as f32;
            assert!(
                zoom >= 1.0 || (texel > 0.49 && texel <= 1.01),
                "{zoom}: {texel}"
            );
        }
        assert_eq!(camera.level(2), 2);
    }
}
