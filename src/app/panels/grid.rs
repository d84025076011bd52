//! Many cells of one size in rows, of which only those in sight are laid out: ten thousand pictures
//! scroll as a dozen do.

use super::super::theme::GAP;
use egui::{Rect, ScrollArea, Ui, UiBuilder, Vec2, vec2};

/// Shows `count` cells as a list that scrolls. `layout` gives, for the width there is, the number of
/// columns and the size of a cell; `cell` draws the one of an index and must take up that size.
pub(super) fn show(
    ui: &mut Ui,
    count: usize,
    layout: impl FnOnce(f32) -> (usize, Vec2),
    mut cell: impl FnMut(&mut Ui, usize, Vec2),
) {
    let area = ScrollArea::vertical().auto_shrink(false);
    area.show_viewport(ui, |ui, seen| {
        let (columns, size) = layout(ui.available_width());
        let columns = columns.max(1);
        ui.spacing_mut().item_spacing = vec2(GAP, GAP);
        let (rows, height) = (count.div_ceil(columns), size.y + GAP);
        ui.set_height((height * rows as f32 - GAP).max(0.0));
        let first = ((seen.min.y / height).max(0.0) as usize).min(rows);
        let behind = ((seen.max.y / height).max(0.0).ceil() as usize).clamp(first, rows);
        let top = ui.max_rect().top();
        let span = top + first as f32 * height..=top + behind as f32 * height;
        let place = Rect::from_x_y_ranges(ui.max_rect().x_range(), span);
        ui.scope_builder(UiBuilder::new().max_rect(place), |ui| {
            // A cell has the same identity wherever the list is scrolled to.
            ui.skip_ahead_auto_ids(first);
            for row in first..behind {
                ui.horizontal(|ui| {
                    for index in row * columns..((row + 1) * columns).min(count) {
                        cell(ui, index, size);
                    }
                });
            }
        });
    });
}
