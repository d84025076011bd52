//! The tools' icons, drawn: no font has them all, and lines stay sharp at any scale.
//!
//! Each is drawn in a square of 20 × 20 units.

use super::super::super::tools::Tool;
use egui::{Color32, Painter, Pos2, Rect, Shape, Stroke, vec2};

/// Width of lines, units.
const LINE: f32 = 1.5;

/// A square to draw in.
struct Pad<'a> {
    painter: &'a Painter,
    rect: Rect,
    color: Color32,
}

impl Pad<'_> {
    fn at(&self, (x, y): (f32, f32)) -> Pos2 {
        self.rect.min + vec2(x, y) * (self.rect.width() / 20.0)
    }

    fn stroke(&self) -> Stroke {
        Stroke::new(LINE, self.color)
    }

    fn line(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|&point| self.at(point)).collect();
        self.painter.add(Shape::line(points, self.stroke()));
    }

    fn closed(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|&point| self.at(point)).collect();
        self.painter.add(Shape::closed_line(points, self.stroke()));
    }

    fn filled(&self, points: &[(f32, f32)]) {
        let points = points.iter().map(|&point| self.at(point)).collect();
        let shape = Shape::convex_polygon(points, self.color, Stroke::NONE);
        self.painter.add(shape);
    }

    fn dot(&self, at: (f32, f32), radius: f32) {
        self.painter.circle_filled(self.at(at), radius, self.color);
    }

    fn ring(&self, center: (f32, f32), radii: (f32, f32)) {
        let point = |i: i32| {
            let angle = i as f32 / 28.0 * std::f32::consts::TAU;
            (
                center.0 + radii.0 * angle.cos(),
                center.1 + radii.1 * angle.sin(),
            )
        };
        let points: Vec<_> = (0..28).map(point).collect();
        self.closed(&points);
    }
}

/// Draws the icon of `tool` into `rect`.
pub(super) fn tool(painter: &Painter, rect: Rect, tool: Tool, color: Color32) {
    let pad = Pad {
        painter,
        rect,
        color,
    };
    match tool {
        Tool::Brush => {
            pad.line(&[(17.0, 3.0), (9.5, 10.5)]);
            pad.line(&[(15.5, 2.2), (8.5, 9.2)]);
            pad.filled(&[
                (8.0, 9.6),
                (10.6, 12.0),
                (9.2, 15.2),
                (6.4, 16.8),
                (2.6, 17.0),
                (4.6, 14.6),
                (5.2, 11.6),
            ]);
        }
        Tool::Lasso => {
            pad.ring((10.5, 7.6), (7.0, 4.8));
            pad.line(&[(5.4, 10.9), (4.2, 13.0), (5.6, 14.6), (4.6, 17.6)]);
            pad.dot((5.2, 11.4), 1.8);
        }
        Tool::Polygon => {
            let corners = [
                (3.5, 7.0),
                (11.0, 3.0),
                (17.0, 9.0),
                (13.0, 16.5),
                (5.0, 15.0),
            ];
            pad.closed(&corners);
            for corner in corners {
                pad.dot(corner, 1.8);
            }
        }
        Tool::Livewire => livewire(&pad),
        Tool::Flood => {
            pad.closed(&[(9.0, 4.0), (15.6, 10.6), (9.4, 16.2), (3.0, 10.0)]);
            pad.filled(&[(3.6, 10.4), (15.0, 10.6), (9.4, 15.6)]);
            pad.line(&[(9.0, 4.0), (6.6, 1.8)]);
            pad.filled(&[(17.0, 12.4), (18.4, 15.2), (17.0, 16.8), (15.6, 15.2)]);
        }
        Tool::Smart => {
            pad.line(&[(3.0, 17.0), (11.6, 8.4)]);
            pad.line(&[(4.2, 18.0), (12.6, 9.6)]);
            star(&pad, (14.6, 5.6), 4.2);
            star(&pad, (6.0, 5.4), 2.6);
            star(&pad, (16.6, 14.0), 2.6);
        }
        Tool::Depth => {
            // A crown's outline and a handle drawn out of it.
            let arc = |i: i32| {
                let angle = (50.0 + 28.0 * i as f32).to_radians();
                (8.0 + 6.0 * angle.cos(), 11.0 + 6.0 * angle.sin())
            };
            pad.line(&(0..=9).map(arc).collect::<Vec<_>>());
            pad.line(&[(12.0, 7.0), (15.6, 3.8)]);
            pad.dot((16.2, 3.4), 2.2);
        }
        Tool::Hand => {
            // Four arrows: what it does.
            pad.line(&[(10.0, 2.4), (10.0, 17.6)]);
            pad.line(&[(2.4, 10.0), (17.6, 10.0)]);
            pad.line(&[(7.6, 4.6), (10.0, 2.2), (12.4, 4.6)]);
            pad.line(&[(7.6, 15.4), (10.0, 17.8), (12.4, 15.4)]);
            pad.line(&[(4.6, 7.6), (2.2, 10.0), (4.6, 12.4)]);
            pad.line(&[(15.4, 7.6), (17.8, 10.0), (15.4, 12.4)]);
        }
    }
}

/// Draws the eraser's icon.
pub(super) fn eraser(painter: &Painter, rect: Rect, color: Color32) {
    let pad = Pad {
        painter,
        rect,
        color,
    };
    pad.closed(&[
        (11.6, 3.4),
        (17.0, 8.8),
        (9.8, 16.0),
        (6.0, 16.0),
        (3.0, 12.8),
    ]);
    pad.filled(&[
        (7.2, 8.0),
        (12.4, 13.4),
        (9.8, 16.0),
        (6.0, 16.0),
        (3.0, 12.8),
    ]);
    pad.line(&[(6.0, 16.8), (17.4, 16.8)]);
}

/// Draws the icon of what is done to a mask: three sliders.
pub(super) fn refine(painter: &Painter, rect: Rect, color: Color32) {
    let pad = Pad {
        painter,
        rect,
        color,
    };
    for (y, knob) in [(4.5, 13.0), (10.0, 6.5), (15.5, 11.0)] {
        pad.line(&[(2.5, y), (17.5, y)]);
        pad.dot((knob, y), 2.4);
    }
}

/// Draws the icon of what is shown: an eye.
pub(super) fn show(painter: &Painter, rect: Rect, color: Color32) {
    let pad = Pad {
        painter,
        rect,
        color,
    };
    let lid = |bend: f32| {
        let point = |i: i32| {
            let t = i as f32 / 12.0;
            (2.0 + 16.0 * t, 10.0 + bend * 4.0 * t * (1.0 - t))
        };
        (0..=12).map(point).collect::<Vec<_>>()
    };
    pad.line(&lid(-6.0));
    pad.line(&lid(6.0));
    pad.dot((10.0, 10.0), 2.8);
}

fn livewire(pad: &Pad<'_>) {
    pad.line(&[
        (3.0, 16.0),
        (5.2, 12.4),
        (4.8, 9.2),
        (7.6, 6.2),
        (11.2, 5.6),
        (13.0, 3.6),
    ]);
    pad.dot((3.0, 16.4), 1.9);
    pad.dot((13.4, 3.4), 1.9);
    pad.line(&[
        (11.0, 10.5),
        (11.0, 14.5),
        (13.0, 16.6),
        (15.6, 16.6),
        (17.6, 14.5),
        (17.6, 10.5),
    ]);
    pad.line(&[(9.8, 10.5), (12.2, 10.5)]);
    pad.line(&[(16.4, 10.5), (18.8, 10.5)]);
}

fn star(pad: &Pad<'_>, (x, y): (f32, f32), radius: f32) {
    let waist = radius * 0.28;
    pad.filled(&[
        (x, y - radius),
        (x + waist, y),
        (x, y + radius),
        (x - waist, y),
    ]);
    pad.filled(&[
        (x - radius, y),
        (x, y - waist),
        (x + radius, y),
        (x, y + waist),
    ]);
}
