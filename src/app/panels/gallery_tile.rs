//! A tree of the gallery as a tile.

use super::super::act_vary::VaryAction;
use super::super::action::Action;
use super::super::studio::Studio;
use super::super::theme::{TIGHT, tokens};
use super::super::vary::Cell;
use super::gallery::made_of;
use super::icon::{self, Icon};
use super::textures::Textures;
use egui::{Align2, Color32, FontId, Rect, Response, Sense, StrokeKind, Ui, Vec2, pos2, vec2};

/// What a tile stands among.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Favourite,
    /// The trees that the new ones were bred from.
    Parent,
    New,
}

impl Kind {
    fn title(self) -> &'static str {
        match self {
            Self::Favourite => "Favourite",
            Self::Parent => "Parent",
            Self::New => "Tree",
        }
    }
}

/// How a tile looks.
pub(super) struct TileLook<'a> {
    pub(super) cell: &'a Cell,
    /// What stands under it.
    pub(super) name: &'a str,
    pub(super) kind: Kind,
    /// Whether it is a favourite.
    pub(super) is_favourite: bool,
    pub(super) is_selected: bool,
    /// Whether it is one of the two that are most alike, and that is shown.
    pub(super) is_alike: bool,
    pub(super) size: Vec2,
}

/// Draws a tile and takes what is done to it. Whether it was clicked.
pub(super) fn tile_ui(
    ui: &mut Ui,
    studio: &Studio,
    look: &TileLook<'_>,
    textures: &mut Textures,
    actions: &mut Vec<Action>,
) -> bool {
    let (rect, response) = ui.allocate_exact_size(look.size, Sense::click());
    let label = format!("{} {}", look.kind.title(), look.name);
    response.widget_info(|| {
        egui::WidgetInfo::selected(egui::Role::Button, true, look.is_selected, &label)
    });
    if ui.is_rect_visible(rect) {
        ground(ui, look, rect, &response);
        picture(ui, studio, look, picture_rect(rect), textures);
        caption(ui, look, rect);
        buttons(ui, look, rect, actions);
    }
    if response.double_clicked() {
        actions.push(Action::Vary(VaryAction::Enlarge(Some(look.cell.key))));
    }
    let clicked = response.clicked();
    let response = match studio.vary.tile(look.cell) {
        Some(Ok(tile)) => {
            let warning = if tile.is_distorted {
                "\nNo draw fitted well: it may look stretched."
            } else {
                ""
            };
            response.on_hover_text(format!("{}{warning}", made_of(studio, tile)))
        }
        Some(Err(reason)) => response.on_hover_text(reason),
        None => response,
    };
    menu(&response, look, actions);
    clicked
}

/// Where the tree's picture goes.
fn picture_rect(rect: Rect) -> Rect {
    let side = rect.width() - 2.0 * TIGHT;
    Rect::from_min_size(rect.min + vec2(TIGHT, TIGHT), vec2(side, side))
}

fn ground(ui: &Ui, look: &TileLook<'_>, rect: Rect, response: &Response) {
    let tokens = tokens(ui);
    let fill = tokens.stamp(look.is_selected, response.hovered());
    ui.painter().rect_filled(rect, 5.0, fill);
    let frame = match (look.is_alike, look.is_selected) {
        (true, _) => Some((3.0, tokens.warning)),
        (false, true) => Some((1.0, tokens.accent)),
        (false, false) => None,
    };
    if let Some((width, color)) = frame {
        let stroke = egui::Stroke::new(width, color);
        ui.painter()
            .rect_stroke(rect, 5.0, stroke, StrokeKind::Inside);
    }
}

/// The tree; while it is being made the one before it, dimmed.
fn picture(ui: &Ui, studio: &Studio, look: &TileLook<'_>, place: Rect, textures: &mut Textures) {
    let vary = &studio.vary;
    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    let words = |text: &str, color| {
        let font = FontId::proportional(11.0);
        ui.painter()
            .text(place.center(), Align2::CENTER_CENTER, text, font, color);
    };
    match vary.tile(look.cell) {
        Some(Ok(tile)) => {
            let texture = textures.of(ui.ctx(), look.cell.key, &tile.image);
            ui.painter().image(texture.id(), place, uv, Color32::WHITE);
        }
        Some(Err(_)) => words("cannot be made", tokens(ui).error),
        None => {
            let before = vary.latest.get(&look.cell.seed);
            match before.and_then(|key| Some((*key, vary.tiles.get(key)?.as_ref().ok()?))) {
                Some((key, tile)) => {
                    let texture = textures.of(ui.ctx(), key, &tile.image);
                    let tint = Color32::from_white_alpha(90);
                    ui.painter().image(texture.id(), place, uv, tint);
                }
                None => words("growing", tokens(ui).weak),
            }
        }
    }
}

fn caption(ui: &Ui, look: &TileLook<'_>, rect: Rect) {
    let color = if look.is_selected {
        tokens(ui).strong
    } else {
        tokens(ui).weak
    };
    let at = pos2(rect.left() + 2.0 * TIGHT, rect.bottom() - 11.0);
    let font = FontId::proportional(11.0);
    let room = rect.width() - 2.0 * icon::SIDE - 4.0 * TIGHT;
    let name = match look.kind {
        Kind::Parent => format!("Parent {}", look.name),
        Kind::Favourite | Kind::New => look.name.to_owned(),
    };
    let text = super::pictures::elided(ui, &name, room);
    ui.painter()
        .text(at, Align2::LEFT_CENTER, text, font, color);
}

fn buttons(ui: &Ui, look: &TileLook<'_>, rect: Rect, actions: &mut Vec<Action>) {
    let tokens = tokens(ui);
    let colors = [tokens.accent, tokens.weak];
    let place = |from_right: f32| {
        let right = rect.right() - TIGHT - from_right * icon::SIDE;
        let top = rect.bottom() - icon::SIDE - 1.0;
        Rect::from_min_size(pos2(right - icon::SIDE, top), vec2(icon::SIDE, icon::SIDE))
    };
    let kind = look.kind.title().to_lowercase();
    let name = format!("Keep {kind} {}", look.name);
    let star = icon::button(
        ui,
        (place(0.0), Icon::Star),
        look.is_favourite,
        &name,
        colors,
    );
    if star
        .on_hover_text("Keeps this tree in the project, whatever changes.")
        .clicked()
    {
        actions.push(Action::Vary(VaryAction::Keep(look.cell.key)));
    }
    if look.kind != Kind::New {
        return;
    }
    let name = format!("Lock tree {}", look.name);
    let lock = icon::button(
        ui,
        (place(1.0), Icon::Lock),
        look.cell.is_locked,
        &name,
        colors,
    );
    if lock
        .on_hover_text("Keeps this seed when the gallery is drawn again.")
        .clicked()
    {
        actions.push(Action::Vary(VaryAction::Lock(look.cell.seed)));
    }
}

fn menu(response: &Response, look: &TileLook<'_>, actions: &mut Vec<Action>) {
    response.context_menu(|ui| {
        let key = look.cell.key;
        let items = [
            ("Show Large", VaryAction::Enlarge(Some(key))),
            ("More Like This", VaryAction::MoreLike(Some(key))),
            ("Take Mix", VaryAction::TakeMix(key)),
            ("Favourite", VaryAction::Keep(key)),
            ("Lock", VaryAction::Lock(look.cell.seed)),
        ];
        let items = items
            .into_iter()
            .filter(|(label, _)| look.kind == Kind::New || *label != "Lock");
        for (label, action) in items {
            if ui.button(label).clicked() {
                actions.push(Action::Vary(action));
                ui.close();
            }
        }
        if ui.button("Copy Seed").clicked() {
            ui.copy_text(look.cell.seed.to_string());
            ui.close();
        }
    });
}
