//! All keys on one page.

use super::commands::{Menu, TABLE};
use super::theme::{GAP, dialog, tokens};
use egui::{Context, RichText};

pub(super) fn show(ctx: &Context, is_open: &mut bool) {
    let modal = dialog(ctx, "shortcuts").show(ctx, |ui| {
        ui.set_width(720.0);
        ui.heading("Keyboard Shortcuts");
        ui.add_space(GAP);
        let height = ui.ctx().content_rect().height() - 160.0;
        egui::ScrollArea::vertical()
            .max_height(height)
            .show(ui, |ui| {
                ui.columns(3, |columns| {
                    for (index, menu) in Menu::ALL.into_iter().enumerate() {
                        let ui = &mut columns[index % 3];
                        ui.label(
                            RichText::new(menu.title())
                                .color(tokens(ui).accent)
                                .strong(),
                        );
                        egui::Grid::new(menu.title()).num_columns(2).show(ui, |ui| {
                            for row in TABLE.iter().filter(|row| row.menu == menu) {
                                ui.label(row.label);
                                ui.weak(ui.ctx().format_shortcut(&row.shortcut));
                                ui.end_row();
                            }
                        });
                        ui.add_space(GAP);
                    }
                });
            });
        if ui.button("Close").clicked() {
            ui.close();
        }
    });
    if modal.should_close() {
        *is_open = false;
    }
}
