//! Doing what was asked with the pen and with masks.
//!
//! A brush paints on a copy of the mask that becomes the project's when the pen goes up: one step to
//! undo. Lines and strokes of the selecting tools are kept in a [`Sketch`] until they are closed; what
//! they select is found by a job (see [`super::mask_jobs`]) and then is one step too.

use super::action::{Gesture, Pen};
use super::mask_action::{MaskAction, MaskCommand};
use super::mask_jobs::{MaskResult, Shaped};
use super::selecting::{Line, LineKind, Sketch, Smart, Wire};
use super::studio::{Effect, Painting, Severity, Studio};
use super::tools::{Overlay, Overlays, Tool};
use crate::base::Digest;
use crate::document::{Edit, PhotoId};
use crate::geometry::Point;
use crate::paint::{
    BACKGROUND, BrushSettings, FillRule, Mirror, Over, Paint, Sample, Stroke, TiledMask, grown,
    holes_filled, mirrored, painted, shrunk, smoothed, without_specks,
};
use crate::raster::{Image, Straight};
use std::sync::Arc;

/// What the studio knows of masks besides those in the project.
#[derive(Default)]
pub(super) struct MaskWork {
    /// The selection in progress.
    pub(super) sketch: Option<Sketch>,
    pub(super) overlays: Overlays,
    /// Results that came while the hand was down.
    pub(super) held: Vec<MaskResult>,
    /// The shape of the shown tree, for the overlays.
    pub(super) shape: Option<Shaped>,
    /// What the last shape was asked for.
    pub(super) shape_asked: Option<(Digest, Arc<TiledMask>)>,
}

impl Studio {
    /// The selection in progress on the shown photograph.
    pub(super) fn sketch(&self) -> Option<&Sketch> {
        let shown = self.shown()?;
        let sketch = self.mask_work.sketch.as_ref()?;
        (photo_of(sketch) == shown).then_some(sketch)
    }

    /// Whether a selection or a stroke is in progress: what Escape gives up.
    pub fn is_drawing(&self) -> bool {
        self.painting.is_some() || self.sketch().is_some()
    }

    /// Whether jobs are running or have results that were not taken up.
    pub fn is_waiting(&self) -> bool {
        !self.jobs.is_idle() || !self.mask_work.held.is_empty()
    }

    pub(super) fn act_on_mask(&mut self, action: MaskAction) {
        match action {
            MaskAction::Set(option) => self.tools.set(option),
            MaskAction::Hover(sample) => self.lead_line(sample.position),
            MaskAction::Close => self.close_sketch(),
            MaskAction::Back => {
                self.step_back();
            }
            MaskAction::Import(path) => self.import_mask(path),
            MaskAction::Export(path) => self.export_mask(path),
        }
    }

    pub(super) fn run_on_mask(&mut self, command: MaskCommand) {
        let tools = self.tools;
        let (label, radius) = (tools.label, tools.amount_px);
        let (amount, pixels) = (f64::from(radius), tools.speck_px);
        let over = Over::Background;
        match command {
            MaskCommand::Propose => self.propose_mask(),
            MaskCommand::Grow => self.change_mask("Grow Mask", move |mask, cancel| {
                grown(mask, label, amount, over, cancel)
            }),
            MaskCommand::Shrink => self.change_mask("Shrink Mask", move |mask, cancel| {
                shrunk(mask, label, amount, cancel)
            }),
            MaskCommand::Smooth => self.change_mask("Smooth Mask", move |mask, cancel| {
                smoothed(mask, label, radius, over, cancel)
            }),
            MaskCommand::FillHoles => self.change_mask("Fill Holes", move |mask, cancel| {
                holes_filled(mask, label, pixels, cancel)
            }),
            MaskCommand::RemoveSpecks => self.change_mask("Remove Specks", move |mask, cancel| {
                without_specks(mask, label, pixels.saturating_add(1), cancel)
            }),
            MaskCommand::Flip => self.mirror_mask("Flip Mask", Mirror::Flip),
            MaskCommand::MirrorLeft => self.mirror_mask("Mirror Left Half", Mirror::LeftToRight),
            MaskCommand::MirrorRight => self.mirror_mask("Mirror Right Half", Mirror::RightToLeft),
            MaskCommand::Import => self.effects.push(Effect::AskWhichMask),
            MaskCommand::Export => self.effects.push(Effect::AskWhereToExportMask),
        }
    }

    fn mirror_mask(&mut self, label: &'static str, mirror: Mirror) {
        self.change_mask(label, move |mask, cancel| {
            cancel.check()?;
            let axis_sum = i64::from(mask.width()) - 1;
            Ok(mirrored(mask, mirror, axis_sum))
        });
    }

    /// Shows an overlay or hides it.
    pub(super) fn toggle_overlay(&mut self, overlay: Overlay) {
        self.mask_work.overlays.toggle(overlay);
        self.ask_for_shape();
    }

    /// Takes up another tool. A smart selection becomes labels; other lines in progress go.
    pub(super) fn take_tool(&mut self, tool: Tool) {
        self.end_gesture();
        if tool != self.tools.tool {
            match self.mask_work.sketch {
                Some(Sketch::Smart(_)) => self.close_sketch(),
                _ => self.mask_work.sketch = None,
            }
        }
        self.tools.tool = tool;
    }

    /// Drops what belongs to a photograph that is no longer shown.
    pub(super) fn forget_foreign_sketch(&mut self) {
        let shown = self.shown();
        let is_foreign = |sketch: &Sketch| Some(photo_of(sketch)) != shown;
        if self.mask_work.sketch.as_ref().is_some_and(is_foreign) {
            self.mask_work.sketch = None;
        }
        if self
            .painting
            .as_ref()
            .is_some_and(|own| Some(own.photo) != shown)
        {
            self.painting = None;
        }
    }

    pub(super) fn pen(&mut self, pen: Pen) {
        match pen {
            Pen::Down { sample, erases } => {
                self.end_gesture();
                self.press(sample, erases || self.tools.is_erasing);
            }
            Pen::Move(sample) => self.draw_on(sample),
            Pen::Up => {
                self.lift();
                self.take_up_held();
            }
        }
    }

    fn press(&mut self, sample: Sample, erases: bool) {
        let Some(photo) = self.shown() else { return };
        let at = sample.position;
        match self.tools.tool {
            Tool::Brush => {
                self.painting = self.painting_begun(photo, erases);
                self.draw_on(sample);
            }
            Tool::Lasso => {
                let line = Line::new(LineKind::Free, photo, at, erases);
                self.mask_work.sketch = Some(Sketch::Line(line));
            }
            Tool::Polygon => match &mut self.mask_work.sketch {
                Some(Sketch::Line(line)) => line.add(at),
                sketch => {
                    let line = Line::new(LineKind::Straight, photo, at, erases);
                    *sketch = Some(Sketch::Line(line));
                }
            },
            Tool::Livewire => self.press_wire(photo, at, erases),
            Tool::Flood => self.flood(photo, at, erases),
            Tool::Smart => self.press_smart(photo, sample, erases),
            Tool::Depth | Tool::Hand => {}
        }
    }

    fn press_wire(&mut self, photo: PhotoId, at: Point, erases: bool) {
        if let Some(Sketch::Wire(wire)) = &mut self.mask_work.sketch {
            wire.fix(at);
        } else if let Some(picture) = self.picture_at_hand() {
            let wire = Wire::new(photo, picture, at, erases);
            self.mask_work.sketch = Some(Sketch::Wire(Box::new(wire)));
        }
    }

    fn press_smart(&mut self, photo: PhotoId, sample: Sample, is_outside: bool) {
        let Some((width, height)) = self
            .document
            .state()
            .mask(photo)
            .map(|mask| (mask.width(), mask.height()))
        else {
            return;
        };
        let mut settings = self.brush_settings();
        settings.radius_px = self.tools.hint_radius_px(width.max(height));
        settings.hardness = 1.0;
        if !matches!(self.mask_work.sketch, Some(Sketch::Smart(_))) {
            self.mask_work.sketch = Some(Sketch::Smart(Smart::new(photo, width, height)));
        }
        if let Some(Sketch::Smart(smart)) = &mut self.mask_work.sketch {
            smart.press(settings, is_outside);
        }
        self.draw_on(sample);
    }

    fn draw_on(&mut self, sample: Sample) {
        if let Some(painting) = &mut self.painting {
            painting.stroke.extend(&mut painting.mask, sample);
            self.generation += 1;
            return;
        }
        match &mut self.mask_work.sketch {
            Some(Sketch::Line(line)) if line.kind == LineKind::Free => line.add(sample.position),
            Some(Sketch::Smart(smart)) => smart.extend(sample),
            _ => self.lead_line(sample.position),
        }
    }

    /// Ends what lasts as long as the pen is down.
    fn lift(&mut self) {
        if let Some(painting) = self.painting.take() {
            self.take_over(painting);
            return;
        }
        let is_stroke = match &mut self.mask_work.sketch {
            Some(Sketch::Smart(smart)) => smart.lift(),
            _ => false,
        };
        if is_stroke {
            self.think_about_strokes();
        } else if self.is_lasso() {
            self.close_sketch();
        }
    }

    fn is_lasso(&self) -> bool {
        let sketch = &self.mask_work.sketch;
        matches!(sketch, Some(Sketch::Line(line)) if line.kind == LineKind::Free)
    }

    /// What was painted becomes the project's.
    fn take_over(&mut self, painting: Painting) {
        let Painting {
            photo,
            stroke,
            mut mask,
            erases,
        } = painting;
        stroke.finish(&mut mask);
        let label = if erases { "Erase" } else { "Brush" };
        let edited = self
            .document
            .apply(label, Edit::SetMask(photo, Arc::new(mask)));
        self.told(edited);
    }

    fn painting_begun(&self, photo: PhotoId, erases: bool) -> Option<Painting> {
        let mask = self.document.state().mask(photo)?;
        Some(Painting {
            photo,
            stroke: Stroke::new(self.brush_settings(), self.paint(erases)),
            mask: TiledMask::clone(mask),
            erases,
        })
    }

    fn brush_settings(&self) -> BrushSettings {
        BrushSettings {
            radius_px: self.tools.radius_px,
            hardness: self.tools.hardness,
            smoothing: self.tools.smoothing,
            ..BrushSettings::default()
        }
    }

    fn paint(&self, erases: bool) -> Paint {
        Paint::of(if erases { BACKGROUND } else { self.tools.label })
    }

    /// The pixels of the shown photograph; says so when they are not there yet.
    pub(super) fn picture_at_hand(&mut self) -> Option<Arc<Image<Straight>>> {
        let photos = &self.document.state().content().photos;
        let digest = photos.get(&self.shown()?)?.digest;
        let picture = self.photos.whole(digest).cloned();
        if picture.is_none() {
            self.notify(Severity::Info, "The picture is still being read.");
        }
        picture
    }

    fn flood(&mut self, photo: PhotoId, at: Point, erases: bool) {
        let Some(picture) = self.picture_at_hand() else {
            return;
        };
        let inside = |at: f64, length: u32| (-0.5..f64::from(length) - 0.5).contains(&at);
        if inside(at.x, picture.width()) && inside(at.y, picture.height()) {
            let seed = (at.x.round().max(0.0) as u32, at.y.round().max(0.0) as u32);
            self.select_by_color(photo, picture, seed, self.paint(erases));
        }
    }

    fn lead_line(&mut self, to: Point) {
        match &mut self.mask_work.sketch {
            Some(Sketch::Line(line)) if line.kind == LineKind::Straight => line.hand = Some(to),
            Some(Sketch::Wire(wire)) => wire.lead(to),
            _ => {}
        }
    }

    /// Closes the line in progress, or takes the smart selection.
    pub(super) fn close_sketch(&mut self) {
        match self.mask_work.sketch.take() {
            Some(Sketch::Line(line)) => {
                let paint = self.paint(line.erases);
                let label = match line.kind {
                    LineKind::Free => "Lasso",
                    LineKind::Straight => "Polygon",
                };
                self.select_inside(line.photo, line.points, FillRule::NonZero, paint, label);
            }
            Some(Sketch::Wire(wire)) => {
                let (photo, paint) = (wire.photo, self.paint(wire.erases));
                self.select_inside(photo, wire.closed(), FillRule::NonZero, paint, "Livewire");
            }
            Some(Sketch::Smart(mut smart)) => {
                smart.lift();
                if smart.is_up_to_date() {
                    self.take_smart(smart);
                } else if smart.strokes > 0 {
                    smart.is_wanted = true;
                    self.mask_work.sketch = Some(Sketch::Smart(smart));
                }
            }
            None => {}
        }
    }

    /// The smart selection becomes labels.
    pub(super) fn take_smart(&mut self, smart: Smart) {
        if let Some(selection) = smart.selection {
            let paint = self.paint(self.tools.is_erasing);
            self.paint_selection(smart.photo, &selection, paint, "Smart Select");
        }
    }

    /// Gives `selection` a label: one step to undo.
    pub(super) fn paint_selection(
        &mut self,
        photo: PhotoId,
        selection: &TiledMask,
        paint: Paint,
        label: &'static str,
    ) {
        let Some(mask) = self.document.state().mask(photo) else {
            return;
        };
        let mut mask = TiledMask::clone(mask);
        if mask.rect() == selection.rect() && painted(&mut mask, selection, paint).is_some() {
            self.edit(label, Edit::SetMask(photo, Arc::new(mask)), Gesture::Whole);
        } else {
            self.notify(Severity::Info, format!("{label}: nothing is different."));
        }
    }

    /// Takes back the last click of a selection in progress, or the stroke. Whether there was one.
    pub(super) fn step_back(&mut self) -> bool {
        if self.painting.take().is_some() {
            self.generation += 1;
            return true;
        }
        let is_left = match &mut self.mask_work.sketch {
            None => return false,
            Some(Sketch::Line(line)) if line.kind == LineKind::Straight => {
                line.points.pop();
                !line.points.is_empty()
            }
            Some(Sketch::Wire(wire)) => wire.unfix(),
            Some(_) => false,
        };
        if !is_left {
            self.mask_work.sketch = None;
        }
        true
    }
}

fn photo_of(sketch: &Sketch) -> PhotoId {
    match sketch {
        Sketch::Line(line) => line.photo,
        Sketch::Wire(wire) => wire.photo,
        Sketch::Smart(smart) => smart.photo,
    }
}
