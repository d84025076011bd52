//! The pins of an exemplar, large enough to be dragged: foot, and where the sides of the trunk meet the
//! crown. A pin stays on the outline; a drag is one step to undo.

use super::super::action::{Action, Gesture};
use super::super::studio::Studio;
use super::super::theme::{GAP, PIN, TIGHT, UNDER_LINE, dialog, tokens};
use super::textures::Textures;
use crate::base::Hasher;
use crate::contour::{HandPins, PinnedContour};
use crate::document::{Edit, PhotoId};
use crate::geometry::Point;
use crate::variation::Entry;
use egui::{
    Align2, Color32, Context, CursorIcon, FontId, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2,
    vec2,
};

/// Side of the picture, points; less in a small window.
const SIDE: f32 = 460.0;

/// Half the side of the place that a pin can be taken hold of, points.
const REACH: f32 = 13.0;

/// The pins in the order of their handles: letter, name, and where the letter stands.
const PINS: [(&str, &str, Vec2); 3] = [
    ("B", "Foot of the tree", vec2(0.0, 15.0)),
    ("L", "Left top of the trunk", vec2(-15.0, 0.0)),
    ("R", "Right top of the trunk", vec2(15.0, 0.0)),
];

/// Where L and R wait beside B while no trunk shows, shares of the picture.
const WAITING: [[f64; 2]; 2] = [[-0.05, -0.07], [0.05, -0.07]];

/// Edits the pins of one exemplar.
#[derive(Default)]
pub(super) struct PinEditor {
    photo: Option<PhotoId>,
    /// The pin that is held and where it is.
    held: Option<(usize, [f64; 2])>,
}

impl PinEditor {
    /// Opens the editor.
    pub(super) fn open(&mut self, photo: PhotoId) {
        self.photo = Some(photo);
        self.held = None;
    }

    /// Shows it while it is open.
    pub(super) fn show(
        &mut self,
        ctx: &Context,
        studio: &Studio,
        textures: &mut Textures,
        actions: &mut Vec<Action>,
    ) {
        let content = studio.document().state().content();
        let open = self
            .photo
            .and_then(|id| Some((id, content.photos.get(&id)?)));
        let Some((id, photo)) = open else {
            self.photo = None;
            return;
        };
        let prepared = studio.vary.prepared.as_ref();
        let entry = prepared.and_then(|prepared| prepared.entry(id));
        let modal = dialog(ctx, "pins").show(ctx, |ui| {
            let room = ctx.content_rect().size() - vec2(80.0, 200.0);
            let side = SIDE.min(room.x).min(room.y).max(160.0);
            ui.set_width(side);
            ui.add(egui::Label::new(egui::RichText::new(format!("Pins of {}", photo.name)).heading()).truncate());
            ui.add_space(TIGHT);
            let help = "Drag the pins to where they belong: B to the foot of the tree, L and R to where \
                        the trunk goes into the crown. Both at one place: a tree without a trunk.";
            ui.add(egui::Label::new(egui::RichText::new(help).weak()).wrap());
            ui.add_space(GAP);
            match entry {
                Some((entry, small)) => {
                    let (rect, _) = ui.allocate_exact_size(vec2(side, side), Sense::hover());
                    ui.painter().rect_filled(rect, 5.0, tokens(ui).sunken);
                    let key = Hasher::new("exemplar").with(entry.digest.bytes()).finish();
                    let texture = textures.of(ctx, key, small);
                    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                    ui.painter().image(texture.id(), rect, uv, Color32::WHITE);
                    self.pins(ui, rect, id, entry, actions);
                }
                None => {
                    ui.weak("This picture is being prepared.");
                }
            }
            ui.add_space(GAP);
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                if ui.button("Close").clicked() {
                    ui.close();
                }
                let has_own = content.pins.contains_key(&id);
                let button = ui.add_enabled(has_own, egui::Button::new("Find Them Again"));
                let button = button.on_hover_text("Forgets the pins you set; the segmenter finds its own.");
                if button.clicked() {
                    actions.push(Action::Edit {
                        label: "Find Pins Again",
                        edit: Edit::SetPins(id, None),
                        gesture: Gesture::Whole,
                    });
                }
            });
        });
        if modal.should_close() {
            self.photo = None;
        }
    }

    fn pins(
        &mut self,
        ui: &mut Ui,
        rect: Rect,
        id: PhotoId,
        entry: &Entry,
        actions: &mut Vec<Action>,
    ) {
        let size = f64::from(entry.shape.size);
        let contour = &entry.shape.contour;
        let on_screen = |[x, y]: [f64; 2]| rect.min + vec2(x as f32, y as f32) * rect.width();
        let line = contour
            .points
            .iter()
            .map(|point| on_screen([point.x / size, point.y / size]));
        let line: Vec<Pos2> = line.collect();
        ui.painter().add(Shape::closed_line(
            line.clone(),
            Stroke::new(2.6, UNDER_LINE),
        ));
        ui.painter().add(Shape::closed_line(
            line,
            Stroke::new(1.0, tokens(ui).accent),
        ));
        let mut places = shares(contour, size);
        if let Some((held, place)) = self.held {
            places[held] = place;
        }
        let shown = with_waiting(places);
        for (index, (letter, name, beside)) in PINS.into_iter().enumerate() {
            let at = on_screen(shown[index]);
            let area = Rect::from_center_size(at, Vec2::splat(2.0 * REACH));
            let response = ui.interact(area, ui.scope_id().with(("pin", index)), Sense::drag());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, true, name));
            if let Some(pointer) = response
                .interact_pointer_pos()
                .filter(|_| response.dragged())
            {
                let share = (pointer - rect.min) / rect.width();
                let near = nearest(contour, size, [f64::from(share.x), f64::from(share.y)]);
                self.held = Some((index, near));
            }
            if response.drag_stopped()
                && let Some((held, place)) = self.held.take()
            {
                let mut all = if contour.pins.has_trunk() {
                    places
                } else {
                    shown
                };
                all[held] = place;
                let [bottom, left, right] = all.map(|place| place.map(|at| at.clamp(0.0, 1.0)));
                actions.push(Action::Edit {
                    label: "Move Pin",
                    edit: Edit::SetPins(
                        id,
                        Some(HandPins {
                            bottom,
                            left,
                            right,
                        }),
                    ),
                    gesture: Gesture::Whole,
                });
            }
            let is_hot = response.hovered() || response.dragged();
            pin(ui, at, letter, beside, is_hot);
            response
                .on_hover_cursor(CursorIcon::Grab)
                .on_hover_text(name);
        }
    }
}

/// The pins of a contour in pixels of a picture of `size`, as shares of it: B, L, R.
fn shares(contour: &PinnedContour, size: f64) -> [[f64; 2]; 3] {
    let share = |point: Point| [point.x / size, point.y / size];
    [contour.bottom(), contour.left(), contour.right()].map(share)
}

/// The pins where all can be seen: L and R beside B when they are at one place with it.
fn with_waiting([bottom, left, right]: [[f64; 2]; 3]) -> [[f64; 2]; 3] {
    let beside = |side: [f64; 2], [x, y]: [f64; 2]| match side == bottom {
        true => [bottom[0] + x, bottom[1] + y],
        false => side,
    };
    [bottom, beside(left, WAITING[0]), beside(right, WAITING[1])]
}

/// The place on the outline nearest to `to`, shares of the picture.
fn nearest(contour: &PinnedContour, size: f64, to: [f64; 2]) -> [f64; 2] {
    let place = Point::new(to[0], to[1]) * size;
    let points = contour.points.iter();
    let nearest = points.min_by(|a, b| {
        let distance = |point: &Point| point.distance_squared(place);
        distance(a).total_cmp(&distance(b))
    });
    nearest.map_or(to, |point| [point.x / size, point.y / size])
}

fn pin(ui: &Ui, at: Pos2, letter: &str, beside: Vec2, is_hot: bool) {
    let radius = if is_hot { 7.5 } else { 6.0 };
    let painter = ui.painter();
    painter.circle_filled(at, radius + 1.5, UNDER_LINE);
    painter.circle_filled(at, radius, PIN);
    let place = Rect::from_center_size(at + beside, vec2(15.0, 15.0));
    painter.rect_filled(place, 4.0, tokens(ui).raised);
    let font = FontId::proportional(12.0);
    painter.text(
        place.center(),
        Align2::CENTER_CENTER,
        letter,
        font,
        tokens(ui).strong,
    );
}
