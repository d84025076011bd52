//! k on the photograph: handles around the silhouette that the hand drags outwards, and k all over the
//! crown in colours.
//!
//! A drag anywhere on the line makes a handle there; what k was before (found by itself, one number, a
//! formula) becomes handles at the first touch.

use super::super::super::k_field::{KField, MOST_K};
use super::super::super::live::ShownCrown;
use super::super::super::studio::Studio;
use super::super::super::theme::{OVER_PHOTO, UNDER_LINE, heat};
use super::super::super::tools::Tool;
use super::super::outline::{Outline, between_neighbours, handle_at};
use super::camera::Camera;
use super::overlay::{caption, lettered};
use crate::document::{CrownSettings, Edit, PhotoId, Tangent};
use egui::{Align2, Painter, Pos2, Shape, Stroke, Ui, vec2};

/// How far from the silhouette a handle stands for k = 1, points.
const STEP: f32 = 11.0;

/// How near the pointer must come to a handle, and to the line, points.
const REACH: f32 = 12.0;
const REACH_OF_LINE: f32 = 16.0;

/// Radius of a handle, points.
const HANDLE: f32 = 5.0;

/// A handle that the hand holds.
#[derive(Debug, Clone)]
pub(super) struct Grip {
    photo: PhotoId,
    settings: CrownSettings,
    points: Vec<(f64, f64)>,
    index: usize,
    /// Where the hand took hold, and the k that was there: the handle follows from there.
    from: (Pos2, f64),
    has_moved: bool,
}

/// All that there is to see and take hold of.
struct Scene<'a> {
    shown: &'a ShownCrown,
    settings: &'a CrownSettings,
    outline: Outline,
    field: KField,
}

impl<'a> Scene<'a> {
    fn of(studio: &'a Studio, camera: &Camera) -> Option<Self> {
        let photo = studio.shown()?;
        let shown = studio.live.shown.as_deref();
        let shown = shown.filter(|shown| shown.photo == photo)?;
        let settings = studio.document().state().content().crowns.get(&photo)?;
        let points = shown.silhouette.points.iter();
        let on_screen = points.map(|&(t, place)| (t, camera.of_pixel(place)));
        Some(Self {
            shown,
            settings,
            outline: Outline::new(on_screen)?,
            field: KField::of(&settings.k, shown.k.map(|[k, _]| k))?,
        })
    }

    /// The handles that there are.
    fn handles(&self) -> &[(f64, f64)] {
        match &self.settings.k {
            Tangent::Profile(points) => points,
            _ => &[],
        }
    }

    fn place(&self, (t, k): (f64, f64)) -> Pos2 {
        let (at, outward) = self.outline.at(t);
        at + outward * (k as f32 * STEP)
    }

    fn k_at(&self, index: usize) -> f64 {
        let (t, place) = self.shown.silhouette.points[index];
        self.field.value(t, self.shown.silhouette.shares(place))
    }

    /// The handle at `pointer`.
    fn handle_at(&self, pointer: Pos2) -> Option<usize> {
        let places: Vec<Pos2> = self.handles().iter().map(|&at| self.place(at)).collect();
        handle_at(&places, pointer, REACH)
    }

    /// The handles with a new one where the pointer is on the line, and which that is.
    fn with_new(&self, pointer: Pos2) -> Option<(Vec<(f64, f64)>, usize)> {
        /// Handles nearer than this along the silhouette are one.
        const SAME: f64 = 0.02;
        let (t, distance) = self.outline.nearest(pointer);
        if distance > REACH_OF_LINE {
            return None;
        }
        let mut points = match &self.settings.k {
            Tangent::Profile(points) => points.clone(),
            _ => self.field.handles(&self.shown.silhouette),
        };
        let apart = |at: f64| {
            let way = (at - t).abs();
            way.min(1.0 - way)
        };
        if let Some(near) = points.iter().position(|(at, _)| apart(*at) < SAME) {
            return Some((points, near));
        }
        let at = points.partition_point(|(at, _)| *at < t);
        let all = &self.shown.silhouette.points;
        let here = all.iter().position(|(own, _)| *own == t)?;
        points.insert(at, (t, self.k_at(here).max(0.0)));
        Some((points, at))
    }
}

/// Takes hold of what is at `pointer`.
pub(super) fn grip(studio: &Studio, camera: &Camera, pointer: Pos2) -> Option<Grip> {
    let scene = Scene::of(studio, camera)?;
    let (points, index) = match scene.handle_at(pointer) {
        Some(index) => (scene.handles().to_vec(), index),
        None => scene.with_new(pointer)?,
    };
    Some(Grip {
        photo: scene.shown.photo,
        settings: scene.settings.clone(),
        from: (pointer, points[index].1),
        points,
        index,
        has_moved: false,
    })
}

impl Grip {
    /// The handle goes to the pointer: outwards and back, or along the line.
    pub(super) fn dragged(
        &mut self,
        studio: &Studio,
        camera: &Camera,
        to: Pos2,
        slides: bool,
    ) -> Option<Edit> {
        // A hand that only clicks trembles.
        let (from, k_before) = self.from;
        self.has_moved |= to.distance(from) > 2.0;
        if !self.has_moved {
            return None;
        }
        let scene = Scene::of(studio, camera)?;
        let (t, k) = self.points[self.index];
        let (_, outward) = scene.outline.at(t);
        let k = if slides {
            k
        } else {
            (k_before + f64::from((to - from).dot(outward) / STEP)).clamp(0.0, 50.0)
        };
        let t = if slides {
            between_neighbours(&self.points, self.index, scene.outline.nearest(to).0)
        } else {
            t
        };
        self.points[self.index] = (t, (k * 100.0).round() / 100.0);
        Some(self.edit())
    }

    fn edit(&self) -> Edit {
        let mut settings = self.settings.clone();
        settings.k = Tangent::Profile(self.points.clone());
        Edit::SetCrown(self.photo, Box::new(settings))
    }
}

/// What a double click at `pointer` does: it takes a handle away, or adds one.
pub(super) fn toggled(studio: &Studio, camera: &Camera, pointer: Pos2) -> Option<Edit> {
    let scene = Scene::of(studio, camera)?;
    let points = match scene.handle_at(pointer) {
        Some(index) if scene.handles().len() > 1 => {
            let mut points = scene.handles().to_vec();
            points.remove(index);
            points
        }
        Some(_) => return None,
        None => scene.with_new(pointer)?.0,
    };
    let mut settings = scene.settings.clone();
    settings.k = Tangent::Profile(points);
    Some(Edit::SetCrown(scene.shown.photo, Box::new(settings)))
}

/// Draws the line in the colours of k, and with the tool in hand its handles.
pub(super) fn draw(
    ui: &Ui,
    painter: &Painter,
    camera: &Camera,
    studio: &Studio,
    held: Option<&Grip>,
    pointer: Option<Pos2>,
) {
    let is_tool = studio.tools.tool == Tool::Depth;
    let Some(scene) = Scene::of(studio, camera) else {
        if is_tool {
            caption(ui, painter, camera, why_nothing(studio));
        }
        return;
    };
    line(painter, &scene);
    if !is_tool {
        return;
    }
    let points = held.map_or(scene.handles(), |grip| &grip.points);
    let near = pointer.and_then(|at| scene.handle_at(at));
    let hot = held.map(|grip| grip.index).or(near);
    for (index, &point) in points.iter().enumerate() {
        handle(painter, &scene, point, hot == Some(index));
    }
    if hot.is_none()
        && let Some((points, index)) = pointer.and_then(|at| scene.with_new(at))
    {
        handle(painter, &scene, points[index], true);
    }
    if points.is_empty() {
        let how = "Drag the outline: outwards makes the crown deeper there, inwards flatter.";
        caption(ui, painter, camera, how);
    }
}

fn why_nothing(studio: &Studio) -> &'static str {
    let shown = studio.live.shown.as_deref();
    match (shown, &studio.live.trouble) {
        (_, Some(_)) => "This formula cannot be drawn; the Crown panel tells why.",
        (Some(shown), _) if !shown.sub_crowns.is_empty() => {
            "With sub-crowns k is set in the Crown panel."
        }
        (Some(_), _) => "The outline shows as soon as the crown is made.",
        (None, _) => "Paint a mask over the crown first.",
    }
}

fn line(painter: &Painter, scene: &Scene<'_>) {
    let points: Vec<Pos2> = scene.outline.points().iter().map(|(_, at)| *at).collect();
    painter.add(Shape::closed_line(
        points.clone(),
        Stroke::new(4.5, UNDER_LINE),
    ));
    for (index, pair) in points.windows(2).enumerate() {
        let color = heat((scene.k_at(index) / MOST_K) as f32);
        painter.line_segment([pair[0], pair[1]], Stroke::new(2.5, color));
    }
}

fn handle(painter: &Painter, scene: &Scene<'_>, (t, k): (f64, f64), is_hot: bool) {
    let (from, _) = scene.outline.at(t);
    let at = scene.place((t, k));
    painter.line_segment([from, at], Stroke::new(3.2, UNDER_LINE));
    painter.line_segment([from, at], Stroke::new(1.4, OVER_PHOTO));
    let radius = if is_hot { HANDLE + 1.5 } else { HANDLE };
    painter.circle_filled(at, radius + 1.5, UNDER_LINE);
    painter.circle_filled(at, radius, heat((k / MOST_K) as f32));
    painter.circle_stroke(at, radius, Stroke::new(1.2, OVER_PHOTO));
    if is_hot {
        let has_room = at.x + 70.0 < painter.clip_rect().right();
        let (align, beside) = match has_room {
            true => (Align2::LEFT_CENTER, 12.0),
            false => (Align2::RIGHT_CENTER, -12.0),
        };
        lettered(painter, at + vec2(beside, 0.0), align, &format!("k {k:.2}"));
    }
}
