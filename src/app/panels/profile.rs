//! k along the silhouette: a curve with handles, and the same handles around the silhouette itself.

use super::super::action::Gesture;
use super::super::theme::{TIGHT, tokens};
use super::field::gesture_of;
use crate::crown::Profile;
use crate::geometry::Point;
use egui::{Pos2, Rect, Response, Sense, Ui, Vec2, pos2, vec2};

/// k at the upper end of the curve.
const MOST_K: f64 = 6.0;

/// How near the pointer must come to a handle, points.
const REACH: f32 = 12.0;

/// How far from the silhouette a handle stands for k = 1, points.
const STEP: f32 = 8.0;

/// Least way between two handles, as a share of the silhouette.
const APART: f64 = 0.01;

/// Edits a profile.
#[derive(Default)]
pub(super) struct ProfileEditor {
    /// The handle that is held.
    held: Option<usize>,
}

impl ProfileEditor {
    /// Shows `points` (place along the silhouette, k) over `silhouette` (place, position within the
    /// crown's bounds) and changes them; where in a gesture, if it did.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        points: &mut Vec<(f64, f64)>,
        silhouette: &[(f64, Point)],
    ) -> Option<Gesture> {
        let of_curve = self.curve(ui, points);
        let of_outline = match silhouette.len() > 8 {
            true => self.outline(ui, points, silhouette),
            false => None,
        };
        ui.weak("Drag handles; double-click adds one or takes one away.");
        of_curve.or(of_outline)
    }

    fn curve(&mut self, ui: &mut Ui, points: &mut Vec<(f64, f64)>) -> Option<Gesture> {
        let size = vec2(ui.available_width(), 110.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let name = "k along the silhouette";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
        let inner = rect.shrink2(vec2(8.0, 10.0));
        let place = |&(t, k): &(f64, f64)| {
            pos2(
                inner.left() + inner.width() * t as f32,
                inner.bottom() - inner.height() * (k / MOST_K).min(1.0) as f32,
            )
        };
        let back = |at: Pos2| {
            let t = f64::from((at.x - inner.left()) / inner.width()).clamp(0.0, 0.999);
            let k = f64::from((inner.bottom() - at.y) / inner.height()).clamp(0.0, 1.0) * MOST_K;
            (t, k)
        };
        let places: Vec<Pos2> = points.iter().map(place).collect();
        let gesture = self.edited(
            &response,
            &places,
            points,
            |at, _| back(at),
            |at| Some(back(at)),
        );
        draw_curve(ui, rect, inner, points, &place);
        gesture
    }

    /// The silhouette with the handles around it: k is how far they stand off.
    fn outline(
        &mut self,
        ui: &mut Ui,
        points: &mut Vec<(f64, f64)>,
        silhouette: &[(f64, Point)],
    ) -> Option<Gesture> {
        ui.add_space(TIGHT);
        let size = vec2(ui.available_width(), 190.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let name = "Handles of k around the silhouette";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
        let outline = Outline::new(silhouette, rect.shrink(MOST_K as f32 * STEP * 0.6));
        let place = |&(t, k): &(f64, f64)| {
            let (at, outward) = outline.at(t);
            at + outward * (k as f32 * STEP)
        };
        let places: Vec<Pos2> = points.iter().map(place).collect();
        let dragged = |at: Pos2, (t, _): (f64, f64)| {
            let (from, outward) = outline.at(t);
            (t, f64::from(((at - from).dot(outward) / STEP).max(0.0)))
        };
        let added = |at: Pos2| {
            let (t, distance) = outline.nearest(at)?;
            (distance < 3.0 * REACH).then_some((t, 2.0))
        };
        let gesture = self.edited(&response, &places, points, dragged, added);
        outline.draw(ui, rect, points, &place);
        gesture
    }

    /// What the hand does to the handles at `places`.
    fn edited(
        &mut self,
        response: &Response,
        places: &[Pos2],
        points: &mut Vec<(f64, f64)>,
        dragged: impl Fn(Pos2, (f64, f64)) -> (f64, f64),
        added: impl Fn(Pos2) -> Option<(f64, f64)>,
    ) -> Option<Gesture> {
        let pointer = response.interact_pointer_pos()?;
        let near = (0..places.len())
            .min_by(|&a, &b| {
                places[a]
                    .distance(pointer)
                    .total_cmp(&places[b].distance(pointer))
            })
            .filter(|&i| places[i].distance(pointer) < REACH);
        if response.double_clicked() {
            match near {
                Some(at) if points.len() > 1 => drop(points.remove(at)),
                Some(_) => return None,
                None => points.push(added(pointer)?),
            }
            points.sort_by(|a, b| a.0.total_cmp(&b.0));
            points.dedup_by(|a, b| a.0 == b.0);
            return Some(Gesture::Whole);
        }
        if response.drag_started() {
            self.held = near;
        }
        let held = self.held.filter(|&held| held < points.len())?;
        if response.dragged() {
            let (t, k) = dragged(pointer, points[held]);
            let least = held.checked_sub(1).map_or(0.0, |i| points[i].0 + APART);
            let most = points
                .get(held + 1)
                .map_or(1.0 - APART, |next| next.0 - APART);
            points[held] = (t.clamp(least, most.max(least)), k);
        }
        if response.drag_stopped() {
            self.held = None;
        }
        gesture_of(response)
    }
}

fn draw_curve(
    ui: &Ui,
    rect: Rect,
    inner: Rect,
    points: &[(f64, f64)],
    place: &impl Fn(&(f64, f64)) -> Pos2,
) {
    let tokens = tokens(ui);
    let painter = ui.painter();
    painter.rect_filled(rect, 4.0, tokens.sunken);
    let font = egui::TextStyle::Small.resolve(ui.style());
    for (share, name) in [(0.25, "right"), (0.5, "top"), (0.75, "left")] {
        let x = inner.left() + inner.width() * share;
        painter.vline(x, inner.y_range(), (1.0, tokens.line));
        let at = pos2(x, rect.bottom() - 1.0);
        painter.text(
            at,
            egui::Align2::CENTER_BOTTOM,
            name,
            font.clone(),
            tokens.weak,
        );
    }
    let all = points.iter().map(|&(t, k)| [t, k]).collect();
    if let Ok(profile) = Profile::new(vec![all]) {
        let curve = (0..=96).map(|i| {
            let t = f64::from(i) / 96.0;
            place(&(t, profile.value(0, t.min(0.999_999))))
        });
        painter.line(curve.collect(), (1.5, tokens.accent));
    }
    for point in points {
        painter.circle(place(point), 4.5, tokens.accent, (1.0, tokens.sunken));
    }
}

/// A silhouette on the screen.
struct Outline {
    /// Place along it, and where.
    points: Vec<(f64, Pos2)>,
}

impl Outline {
    fn new(silhouette: &[(f64, Point)], rect: Rect) -> Self {
        let scale = rect.width().min(rect.height());
        let middle = rect.center();
        let points = silhouette.iter().map(|&(t, at)| {
            let from_middle = vec2(at.x as f32 - 0.5, at.y as f32 - 0.5);
            (t, middle + from_middle * scale)
        });
        Self {
            points: points.collect(),
        }
    }

    /// The point at `t` and the direction outwards.
    fn at(&self, t: f64) -> (Pos2, Vec2) {
        let count = self.points.len();
        let index = self.points.partition_point(|(at, _)| *at < t) % count;
        // Over a stretch, for pixels have corners.
        let reach = (count / 40).max(1);
        let along =
            self.points[(index + reach) % count].1 - self.points[(index + count - reach) % count].1;
        // The way is counter-clockwise on the screen, where y points down: outside is on the right.
        (self.points[index].1, vec2(-along.y, along.x).normalized())
    }

    fn nearest(&self, to: Pos2) -> Option<(f64, f32)> {
        let distances = self.points.iter().map(|(t, at)| (*t, at.distance(to)));
        distances.min_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn draw(
        &self,
        ui: &Ui,
        rect: Rect,
        points: &[(f64, f64)],
        place: &impl Fn(&(f64, f64)) -> Pos2,
    ) {
        let tokens = tokens(ui);
        let painter = ui.painter().with_clip_rect(rect);
        painter.rect_filled(rect, 4.0, tokens.sunken);
        let outline: Vec<Pos2> = self.points.iter().map(|(_, at)| *at).collect();
        painter.add(egui::Shape::closed_line(outline, (1.0, tokens.weak)));
        for point in points {
            let (from, _) = self.at(point.0);
            painter.line_segment([from, place(point)], (1.0, tokens.accent));
            painter.circle(place(point), 4.5, tokens.accent, (1.0, tokens.sunken));
        }
    }
}
