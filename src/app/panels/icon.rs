//! Small pictures on buttons, drawn line by line: fonts lack most of them.

use egui::{Color32, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, pos2, vec2};

/// What a button shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Icon {
    /// A padlock, open or shut.
    Lock,
    /// A star, empty or full.
    Star,
    /// A needle with a head.
    Pin,
}

/// Side of an icon button, points.
pub(super) const SIDE: f32 = 20.0;

/// A button with an icon in `rect`, called `name`; `is_on` fills it.
pub(super) fn button(
    ui: &Ui,
    (rect, icon): (Rect, Icon),
    is_on: bool,
    name: &str,
    colors: [Color32; 2],
) -> Response {
    let id = ui.scope_id().with(name);
    let response = ui.interact(rect, id, Sense::click());
    response.widget_info(|| egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_on, name));
    let [on, off] = colors;
    let color = if is_on || response.hovered() { on } else { off };
    let area = rect.shrink(3.5);
    match icon {
        Icon::Lock => lock(ui, area, is_on, color),
        Icon::Star => star(ui, area, is_on, color),
        Icon::Pin => pin(ui, area, is_on, color),
    }
    response
}

fn lock(ui: &Ui, area: Rect, is_shut: bool, color: Color32) {
    let stroke = Stroke::new(1.5, color);
    let body = Rect::from_min_max(
        pos2(area.left() + 1.0, area.center().y - 0.5),
        pos2(area.right() - 1.0, area.bottom()),
    );
    let painter = ui.painter();
    if is_shut {
        painter.rect_filled(body, 1.5, color);
    } else {
        painter.rect_stroke(body, 1.5, stroke, egui::StrokeKind::Inside);
    }
    let radius = 0.3 * area.width();
    let lift = if is_shut { 0.0 } else { 1.5 };
    let middle = pos2(area.center().x, body.top() - lift - 1.0);
    let arc = (0..=10).map(|i| {
        let angle = std::f32::consts::PI * (1.0 + i as f32 / 10.0);
        middle + radius * vec2(angle.cos(), angle.sin())
    });
    let mut points: Vec<Pos2> = arc.collect();
    points.insert(0, pos2(middle.x - radius, body.top()));
    if is_shut {
        points.push(pos2(middle.x + radius, body.top()));
    }
    painter.add(Shape::line(points, stroke));
}

fn pin(ui: &Ui, area: Rect, is_full: bool, color: Color32) {
    let (stroke, painter) = (Stroke::new(1.4, color), ui.painter());
    let head = pos2(area.center().x, area.top() + 4.0);
    painter.line_segment([head + vec2(0.0, 3.5), area.center_bottom()], stroke);
    if is_full {
        painter.circle_filled(head, 4.0, color);
    } else {
        painter.circle_stroke(head, 3.5, stroke);
    }
}

fn star(ui: &Ui, area: Rect, is_full: bool, color: Color32) {
    let outer = 0.54 * area.width();
    let middle = area.center() + vec2(0.0, 0.5);
    let corner = |i: usize| {
        let angle = std::f32::consts::PI * (i as f32 / 5.0 - 0.5);
        let radius = if i.is_multiple_of(2) {
            outer
        } else {
            0.45 * outer
        };
        middle + radius * vec2(angle.cos(), angle.sin())
    };
    let corners: Vec<Pos2> = (0..10).map(corner).collect();
    let painter = ui.painter();
    if is_full {
        // Not convex, so as a fan about its middle.
        let mut mesh = egui::Mesh::default();
        mesh.colored_vertex(middle, color);
        for point in &corners {
            mesh.colored_vertex(*point, color);
        }
        for i in 0..10 {
            mesh.add_triangle(0, 1 + i, 1 + (i + 1) % 10);
        }
        painter.add(Shape::mesh(mesh));
    }
    painter.add(Shape::closed_line(corners, Stroke::new(1.3, color)));
}
