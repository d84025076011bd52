//! k along the silhouette: a curve with handles, and the same handles around the silhouette itself.

use super::super::action::Gesture;
use super::super::k_field::MOST_K;
use super::super::theme::{TIGHT, tokens};
use super::field::gesture_of;
use super::outline::{Outline, between_neighbours, handle_at};
use crate::crown::Profile;
use crate::pipeline::Silhouette;
use egui::{Pos2, Rect, Response, Sense, Ui, pos2, vec2};

/// How near the pointer must come to a handle, points.
const REACH: f32 = 12.0;

/// How far from the silhouette a handle stands for k = 1, points.
const STEP: f32 = 8.0;

/// Edits a profile.
#[derive(Default)]
pub(super) struct ProfileEditor {
    /// The handle that is held.
    held: Option<usize>,
}

impl ProfileEditor {
    /// Shows `points` (place along the silhouette, k) over `silhouette` and changes them; where in a
    /// gesture, if it did.
    pub(super) fn show(
        &mut self,
        ui: &mut Ui,
        points: &mut Vec<(f64, f64)>,
        silhouette: Option<&Silhouette>,
    ) -> Option<Gesture> {
        let of_curve = self.curve(ui, points);
        let of_outline = silhouette.and_then(|silhouette| self.outline(ui, points, silhouette));
        let help = "Drag handles; double-click adds one or takes one away.";
        ui.add(egui::Label::new(egui::RichText::new(help).weak()).wrap());
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
        silhouette: &Silhouette,
    ) -> Option<Gesture> {
        ui.add_space(TIGHT);
        let size = vec2(ui.available_width(), 190.0);
        let (rect, response) = ui.allocate_exact_size(size, Sense::click_and_drag());
        let name = "Handles of k around the silhouette";
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
        let outline = Outline::within(silhouette, rect.shrink(MOST_K as f32 * STEP * 0.6))?;
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
            let (t, distance) = outline.nearest(at);
            (distance < 3.0 * REACH).then_some((t, 2.0))
        };
        let gesture = self.edited(&response, &places, points, dragged, added);
        draw_outline(ui, rect, &outline, points, &place);
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
        let near = handle_at(places, pointer, REACH);
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
            points[held] = (between_neighbours(points, held, t), k);
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

fn draw_outline(
    ui: &Ui,
    rect: Rect,
    outline: &Outline,
    points: &[(f64, f64)],
    place: &impl Fn(&(f64, f64)) -> Pos2,
) {
    let tokens = tokens(ui);
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 4.0, tokens.sunken);
    let line: Vec<Pos2> = outline.points().iter().map(|(_, at)| *at).collect();
    painter.add(egui::Shape::closed_line(line, (1.0, tokens.weak)));
    for point in points {
        let (from, _) = outline.at(point.0);
        painter.line_segment([from, place(point)], (1.0, tokens.accent));
        painter.circle(place(point), 4.5, tokens.accent, (1.0, tokens.sunken));
    }
}
