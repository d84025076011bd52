//! The command palette: any command by a few letters of its name.

use super::action::Action;
use super::commands::{Command, Row, TABLE};
use super::studio::Studio;
use super::theme::{TIGHT, dialog, tokens};
use egui::{Context, Key, RichText};

/// The palette, open or closed.
#[derive(Debug, Default)]
pub(super) struct Palette {
    is_open: bool,
    is_new: bool,
    text: String,
    selected: usize,
}

impl Palette {
    pub(super) fn toggle(&mut self) {
        *self = Self {
            is_open: !self.is_open,
            is_new: true,
            ..Self::default()
        };
    }

    pub(super) fn show(&mut self, ctx: &Context, studio: &Studio, actions: &mut Vec<Action>) {
        if !self.is_open {
            return;
        }
        let found = found(&self.text, studio.recent_commands());
        let steps =
            |key| ctx.input_mut(|input| input.count_and_consume_key(egui::Modifiers::NONE, key));
        self.selected += steps(Key::ArrowDown);
        self.selected = self.selected.saturating_sub(steps(Key::ArrowUp));
        self.selected = self.selected.min(found.len().saturating_sub(1));
        let mut chosen = None;
        let modal = dialog(ctx, "palette").show(ctx, |ui| {
            ui.set_width(520.0);
            let field = egui::TextEdit::singleline(&mut self.text)
                .desired_width(f32::INFINITY)
                .hint_text("Type the name of a command");
            let field = ui.add(field);
            if std::mem::take(&mut self.is_new) {
                field.request_focus();
            }
            if field.changed() {
                self.selected = 0;
            }
            if ui.input(|input| input.key_pressed(Key::Enter)) {
                chosen = found.get(self.selected).copied();
            }
            ui.add_space(TIGHT);
            egui::ScrollArea::vertical()
                .max_height(360.0)
                .show(ui, |ui| {
                    for (index, row) in found.iter().enumerate() {
                        let keys = ui.ctx().format_shortcut(&row.shortcut);
                        let label = format!("{}: {}", row.menu.title(), row.label);
                        let button = egui::Button::selectable(index == self.selected, label)
                            .shortcut_text(keys)
                            .min_size(egui::vec2(ui.available_width(), 26.0));
                        let response = ui.add_enabled(studio.can(row.command), button);
                        if response.on_hover_text(row.help).clicked() {
                            chosen = Some(row);
                        }
                    }
                    if found.is_empty() {
                        ui.label(
                            RichText::new("No command has such a name.").color(tokens(ui).weak),
                        );
                    }
                });
        });
        if let Some(row) = chosen.filter(|row| studio.can(row.command)) {
            actions.push(Action::Do(row.command));
            self.is_open = false;
        } else if modal.should_close() {
            self.is_open = false;
        }
    }
}

/// The commands whose names have the letters of `text` in their order; whole words first, and of
/// equals those in `recent`, in its order.
fn found(text: &str, recent: &[Command]) -> Vec<&'static Row> {
    let text = text.trim().to_lowercase();
    let name = |row: &Row| format!("{} {}", row.menu.title(), row.label).to_lowercase();
    let mut found: Vec<&Row> = TABLE
        .iter()
        .filter(|row| has_letters(&name(row), &text))
        .collect();
    let age = |row: &Row| {
        let at = recent.iter().position(|&command| command == row.command);
        // The palette itself was always used just now.
        at.filter(|_| row.command != Command::Palette)
            .unwrap_or(usize::MAX)
    };
    found.sort_by_key(|row| (!name(row).contains(&text), age(row)));
    found
}

/// Whether the letters of `text` stand in `name` in their order.
fn has_letters(name: &str, text: &str) -> bool {
    let mut letters = name.chars();
    text.chars()
        .filter(|c| !c.is_whitespace())
        .all(|wanted| letters.any(|letter| letter == wanted))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_words_come_before_scattered_letters() {
        assert_eq!(found("undo", &[])[0].label, "Undo");
        assert_eq!(found("sv as", &[])[0].label, "Save As…");
        assert_eq!(found("", &[]).len(), TABLE.len());
        assert!(found("zzzz", &[]).is_empty());
        let recent = [Command::Palette, Command::Redo];
        assert_eq!(found("", &recent)[0].command, Command::Redo);
    }
}
