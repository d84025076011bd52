//! The first steps: six short texts, shown once and whenever the user asks.
//!
//! It lies in a corner and blocks nothing: each step can be tried while its text is read.

use super::action::Action;
use super::studio::{Studio, Workspace};
use super::theme::{GAP, tokens};
use egui::{Align2, Context, RichText, vec2};

struct Step {
    heading: &'static str,
    text: &'static str,
    workspace: Workspace,
}

const STEPS: [Step; 6] = [
    Step {
        heading: "Pictures",
        text: "On the left are the pictures of the project. Click one to work on it; drop your own \
               photographs and cut-out trees anywhere in the window.",
        workspace: Workspace::Crown,
    },
    Step {
        heading: "The mask",
        text: "Paint over the crown with the brush (B). Ctrl erases, [ and ] change the size, the wheel \
               zooms, Space moves the picture. Every stroke can be undone.",
        workspace: Workspace::Crown,
    },
    Step {
        heading: "The crown",
        text: "What you paint grows a crown in the 3D view beside it. Drag there to turn it round; \
               F shows all of it.",
        workspace: Workspace::Crown,
    },
    Step {
        heading: "Shape and relief",
        text: "On the right you set how deep the crown is and how rough its surface. Or press K and drag \
               the crown's outline itself: outwards is deeper. A double click puts a value back.",
        workspace: Workspace::Crown,
    },
    Step {
        heading: "New trees",
        text: "The Variations workspace mixes new trees from several cut-out ones. Keep those you like, \
               draw the others again.",
        workspace: Workspace::Variations,
    },
    Step {
        heading: "Out into the world",
        text: "Export writes libraries for Blender, Godot, Unity, Unreal and the web. Ctrl+Shift+P finds \
               any command by its name. That is all: make trees!",
        workspace: Workspace::Variations,
    },
];

/// Where the tour stands.
#[derive(Debug, Default)]
pub(super) struct Tour {
    at: Option<usize>,
    was_offered: bool,
}

impl Tour {
    pub(super) fn start(&mut self) {
        self.at = Some(0);
    }

    pub(super) fn show(&mut self, ctx: &Context, studio: &Studio, actions: &mut Vec<Action>) {
        if studio.is_empty() {
            return;
        }
        if !self.was_offered {
            self.was_offered = true;
            if !studio.preferences().tour_was_seen {
                self.start();
            }
        }
        let Some(at) = self.at.filter(|_| studio.question().is_none()) else {
            return;
        };
        let step = &STEPS[at];
        let mut next = Some(at);
        egui::Window::new("Tour")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::LEFT_BOTTOM, vec2(2.0 * GAP, -5.0 * GAP))
            .default_width(360.0)
            .show(ctx, |ui| {
                ui.set_width(360.0);
                ui.horizontal(|ui| {
                    ui.heading(step.heading);
                    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                        let count = format!("{} of {}", at + 1, STEPS.len());
                        ui.label(RichText::new(count).color(tokens(ui).weak));
                    });
                });
                ui.label(step.text);
                ui.add_space(GAP);
                ui.horizontal(|ui| {
                    let is_last = at + 1 == STEPS.len();
                    if ui.button(if is_last { "Done" } else { "Next" }).clicked() {
                        next = (!is_last).then_some(at + 1);
                    }
                    if at > 0 && ui.button("Back").clicked() {
                        next = Some(at - 1);
                    }
                    if !is_last && ui.button("Skip").clicked() {
                        next = None;
                    }
                });
            });
        if next == Some(at) {
            return;
        }
        self.at = next;
        match next {
            Some(next) if STEPS[next].workspace != studio.workspace() => {
                actions.push(Action::Workspace(STEPS[next].workspace));
            }
            Some(_) => {}
            None => actions.push(Action::TourSeen),
        }
    }
}
