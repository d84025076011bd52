//! What is drawn over the photograph: the pixel grid, the selection in progress, the tree's shape, the
//! brush.

use super::super::super::selecting::{LineKind, Sketch};
use super::super::super::studio::Studio;
use super::super::super::theme::{INSIDE, OUTSIDE, OVER_PHOTO, PIN, UNDER_LINE, tokens};
use super::super::super::tools::{Overlay, Tool};
use super::camera::Camera;
use crate::pipeline::PictureShape;
use egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Shape, Stroke, Ui, Vec2, pos2, vec2};

/// Pixels of the screen from which on a pixel of the photograph gets an edge.
const GRID_FROM: f32 = 8.0;

/// Distance of the pointer from the first vertex within which a click closes the line, points.
pub(super) const CLOSING: f32 = 9.0;

/// Half the side of a vertex's mark, points.
const MARK: f32 = 3.0;

/// Lines between pixels, when these are large.
pub(super) fn pixel_grid(painter: &Painter, camera: &Camera, size: Vec2) {
    if camera.scale() < GRID_FROM {
        return;
    }
    let seen = camera.visible(size);
    let stroke = Stroke::new(1.0 / camera.pixels_per_point, Color32::from_black_alpha(70));
    for x in seen.min.x.ceil() as u32..=seen.max.x.floor() as u32 {
        let from = camera.on_screen(pos2(x as f32, seen.min.y));
        let to = camera.on_screen(pos2(x as f32, seen.max.y));
        painter.line_segment([from, to], stroke);
    }
    for y in seen.min.y.ceil() as u32..=seen.max.y.floor() as u32 {
        let from = camera.on_screen(pos2(seen.min.x, y as f32));
        let to = camera.on_screen(pos2(seen.max.x, y as f32));
        painter.line_segment([from, to], stroke);
    }
}

/// The line of lasso, polygon or livewire, as far as it was drawn.
pub(super) fn sketch(painter: &Painter, camera: &Camera, sketch: &Sketch) {
    let color = |erases: bool| if erases { OUTSIDE } else { OVER_PHOTO };
    match sketch {
        Sketch::Line(line) => {
            let points = line.points.iter().chain(&line.hand);
            let mut points: Vec<Pos2> = points.map(|&point| camera.of_pixel(point)).collect();
            let first = points.first().copied();
            if line.kind == LineKind::Straight {
                two_tone(painter, &points, color(line.erases));
                for &point in &line.points {
                    mark(painter, camera.of_pixel(point), color(line.erases));
                }
                closing_ring(painter, first.filter(|_| line.points.len() > 2));
            } else {
                // How it will be closed.
                points.extend(first);
                two_tone(painter, &points, color(line.erases));
            }
        }
        Sketch::Wire(wire) => {
            let points: Vec<Pos2> = wire.line().map(|point| camera.of_pixel(point)).collect();
            two_tone(painter, &points, color(wire.erases));
            let anchors = wire.anchors();
            let on_screen =
                |&(x, y): &(u32, u32)| camera.on_screen(pos2(x as f32 + 0.5, y as f32 + 0.5));
            for anchor in &anchors {
                mark(painter, on_screen(anchor), color(wire.erases));
            }
            closing_ring(
                painter,
                anchors.first().map(on_screen).filter(|_| anchors.len() > 2),
            );
        }
        Sketch::Smart(_) => {}
    }
}

/// Where a click closes the line in progress, on the screen.
pub(super) fn closing_place(camera: &Camera, sketch: &Sketch) -> Option<Pos2> {
    match sketch {
        Sketch::Line(line) if line.kind == LineKind::Straight && line.points.len() > 2 => {
            line.points.first().map(|&point| camera.of_pixel(point))
        }
        Sketch::Wire(wire) => {
            let anchors = wire.anchors();
            let &(x, y) = anchors.first().filter(|_| anchors.len() > 2)?;
            Some(camera.on_screen(pos2(x as f32 + 0.5, y as f32 + 0.5)))
        }
        _ => None,
    }
}

fn closing_ring(painter: &Painter, place: Option<Pos2>) {
    if let Some(place) = place {
        painter.circle_stroke(place, CLOSING, Stroke::new(3.0, UNDER_LINE));
        painter.circle_stroke(place, CLOSING, Stroke::new(1.2, OVER_PHOTO));
    }
}

/// A line that shows on any photograph.
fn two_tone(painter: &Painter, points: &[Pos2], color: Color32) {
    painter.add(Shape::line(points.to_vec(), Stroke::new(3.2, UNDER_LINE)));
    painter.add(Shape::line(points.to_vec(), Stroke::new(1.4, color)));
}

fn mark(painter: &Painter, place: Pos2, color: Color32) {
    let square = Rect::from_center_size(place, Vec2::splat(2.0 * MARK));
    painter.rect_filled(square.expand(1.0), 1.0, UNDER_LINE);
    painter.rect_filled(square, 1.0, color);
}

/// Contour, pins and baseline of the tree, as far as they are wanted; or why there are none.
pub(super) fn shape(ui: &Ui, painter: &Painter, camera: &Camera, studio: &Studio) {
    let work = &studio.mask_work;
    if !work.overlays.need_shape() {
        return;
    }
    let digest = studio
        .shown()
        .and_then(|id| studio.document().state().content().photos.get(&id))
        .map(|photo| photo.digest);
    let Some(shaped) = work
        .shape
        .as_ref()
        .filter(|shaped| Some(shaped.photo) == digest)
    else {
        return;
    };
    match &shaped.shape {
        Ok(shape) => {
            if work.overlays.has(Overlay::Contour) {
                let points = shape.contour.iter().chain(shape.contour.first());
                let points: Vec<Pos2> = points.map(|&point| camera.of_pixel(point)).collect();
                two_tone(painter, &points, INSIDE);
            }
            if work.overlays.has(Overlay::Baseline) {
                baseline(painter, camera, shape);
            }
            if work.overlays.has(Overlay::Pins) {
                pins(painter, camera, shape);
            }
        }
        Err(why) => caption(ui, painter, camera, &format!("No contour: {why}.")),
    }
}

fn baseline(painter: &Painter, camera: &Camera, shape: &PictureShape) {
    let Some(y) = shape.baseline_y else { return };
    let xs = || shape.contour.iter().map(|point| point.x);
    let left = xs().fold(f64::INFINITY, f64::min);
    let right = xs().fold(f64::NEG_INFINITY, f64::max);
    let ends = [left, right].map(|x| camera.of_pixel(crate::geometry::Point::new(x, y)));
    painter.line_segment(ends, Stroke::new(3.2, UNDER_LINE));
    painter.extend(Shape::dashed_line(&ends, Stroke::new(1.4, PIN), 8.0, 5.0));
    lettered(
        painter,
        ends[1] - vec2(0.0, 4.0),
        Align2::RIGHT_BOTTOM,
        "Crown begins",
    );
}

fn pins(painter: &Painter, camera: &Camera, shape: &PictureShape) {
    let bottom = (shape.bottom, "B", Align2::CENTER_TOP, vec2(0.0, 7.0));
    let sides = shape.sides.map(|[left, right]| {
        [
            (left, "L", Align2::RIGHT_CENTER, vec2(-8.0, 0.0)),
            (right, "R", Align2::LEFT_CENTER, vec2(8.0, 0.0)),
        ]
    });
    for (pin, name, align, offset) in sides.into_iter().flatten().chain([bottom]) {
        let place = camera.of_pixel(pin);
        painter.circle_filled(place, 6.0, UNDER_LINE);
        painter.circle_filled(place, 4.5, PIN);
        lettered(painter, place + offset, align, name);
    }
}

/// Text over a photograph.
pub(super) fn lettered(painter: &Painter, place: Pos2, align: Align2, text: &str) {
    let font = FontId::proportional(12.0);
    for offset in [
        vec2(1.0, 0.0),
        vec2(-1.0, 0.0),
        vec2(0.0, 1.0),
        vec2(0.0, -1.0),
    ] {
        painter.text(place + offset, align, text, font.clone(), UNDER_LINE);
    }
    painter.text(place, align, text, font, OVER_PHOTO);
}

/// A line of text at the foot of the canvas.
pub(super) fn caption(ui: &Ui, painter: &Painter, camera: &Camera, text: &str) {
    let tokens = tokens(ui);
    let width = camera.panel.width() - 48.0;
    let galley = painter.layout(
        text.to_owned(),
        FontId::proportional(12.5),
        tokens.text,
        width,
    );
    let foot = camera.panel.center_bottom() - vec2(0.0, 14.0 + galley.size().y / 2.0);
    let place = Rect::from_center_size(foot, galley.size());
    painter.rect_filled(place.expand2(vec2(10.0, 5.0)), 4.0, tokens.raised);
    painter.galley(place.min, galley, tokens.text);
}

/// The brush under the pointer.
pub(super) fn brush(painter: &Painter, camera: &Camera, studio: &Studio, at: Pos2, erases: bool) {
    let tools = &studio.tools;
    let longer = studio.shown_mask();
    let longer = longer.map_or(1, |mask| mask.width().max(mask.height()));
    let radius = match tools.tool {
        Tool::Smart => tools.hint_radius_px(longer),
        _ => tools.radius_px,
    };
    let radius = radius as f32 * camera.zoom;
    let color = if erases { OUTSIDE } else { OVER_PHOTO };
    if radius < 1.5 {
        let arm = 5.0;
        for [from, to] in [
            [vec2(-arm, 0.0), vec2(arm, 0.0)],
            [vec2(0.0, -arm), vec2(0.0, arm)],
        ] {
            painter.line_segment([at + from, at + to], Stroke::new(3.0, UNDER_LINE));
            painter.line_segment([at + from, at + to], Stroke::new(1.0, color));
        }
        return;
    }
    painter.circle_stroke(at, radius, Stroke::new(2.6, UNDER_LINE));
    painter.circle_stroke(at, radius, Stroke::new(1.2, color));
    if tools.tool == Tool::Brush && tools.hardness < 0.95 {
        // What is fully covered.
        let inner = radius * tools.hardness as f32;
        painter.circle_stroke(at, inner, Stroke::new(1.0, color.gamma_multiply(0.5)));
    }
}
