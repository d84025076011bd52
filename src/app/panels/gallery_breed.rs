//! Breeding from selected trees, and whether they repeat each other.

use super::super::act_vary::VaryAction;
use super::super::action::Action;
use super::super::studio::Studio;
use super::super::theme::{GAP, tokens};
use super::super::vary::Vary;
use crate::base::Digest;
use crate::variation::Aspect;
use egui::{RichText, Ui};
use std::collections::BTreeSet;

/// What is set for the next generation, and which trees are shown as alike.
#[derive(Default)]
pub(super) struct Breeding {
    locks: BTreeSet<Aspect>,
    /// The two that are most alike, while they are shown.
    pub(super) shown: Vec<Digest>,
}

impl Breeding {
    /// How much the selected trees repeat each other; a click shows the two that do most.
    pub(super) fn score(
        &mut self,
        ui: &mut Ui,
        studio: &Studio,
        selected: &[Digest],
        actions: &mut Vec<Action>,
    ) {
        let vary = &studio.vary;
        ui.label(format!("{} trees", selected.len()));
        let scored = vary.score.as_ref().filter(|scored| scored.keys == selected);
        let Some(scored) = scored else {
            self.shown.clear();
            if vary.asked_score != selected && vary.pictures(selected).is_some() {
                actions.push(Action::Vary(VaryAction::Score(selected.to_vec())));
            }
            ui.weak("comparing…");
            return;
        };
        let score = scored.repetition.score;
        let color = match score {
            score if score >= 0.6 => tokens(ui).error,
            score if score >= 0.3 => tokens(ui).warning,
            _ => tokens(ui).text,
        };
        ui.label(RichText::new(format!("repetition {score:.2}")).color(color))
            .on_hover_text(
                "How like each tree is to the one most like it, whatever their colour and size: 0, no tree has a double; 1, copies.",
            );
        let Some(worst) = scored.repetition.pairs.first() else {
            return;
        };
        let pair = [worst.first, worst.second].map(|at| scored.keys[at]);
        let [one, other] = pair.map(|key| name(vary, key));
        let mirrored = if worst.likeness.is_mirrored {
            ", mirrored"
        } else {
            ""
        };
        let told = format!(
            "most alike: {one} and {other} ({:.2}{mirrored})",
            worst.likeness.score()
        );
        let is_shown = self.shown == pair;
        let help = format!(
            "Frames both. They correlate by {:.2}; {:.0} % of their clumps and gaps are found again.",
            worst.likeness.correlation,
            100.0 * worst.likeness.matched,
        );
        let button = egui::Button::new(told).small().selected(is_shown);
        if ui.add(button).on_hover_text(help).clicked() {
            self.shown = if is_shown { Vec::new() } else { pair.to_vec() };
        }
    }
}

/// What a tree of the wall is called.
fn name(vary: &Vary, key: Digest) -> String {
    let at = |cells: &[super::super::vary::Cell]| cells.iter().position(|cell| cell.key == key);
    let groups = [
        ("Tree", &vary.gallery),
        ("Parent", &vary.parents),
        ("Favourite", &vary.favourites),
    ];
    let found = groups
        .iter()
        .find_map(|(kind, cells)| Some(format!("{kind} {}", at(cells)? + 1)));
    found.unwrap_or_default()
}

/// The button that breeds from `selected`, with what children keep.
pub(super) fn show(
    ui: &mut Ui,
    studio: &Studio,
    selected: &[Digest],
    breeding: &mut Breeding,
    actions: &mut Vec<Action>,
) {
    ui.horizontal(|ui| {
        let are_made = studio.vary.pictures(selected).is_some();
        let button = ui.add_enabled(are_made, egui::Button::new("Breed Next Generation"));
        let help = if selected.len() == 1 {
            "Fills the gallery with mutations of this tree. Choose several to cross them."
        } else {
            "Fills the gallery with children of these trees: outlines, colours and foliage crossed and changed a little. Undo brings this gallery back."
        };
        if button.on_hover_text(help).clicked() {
            let (parents, locks) = (selected.to_vec(), breeding.locks.clone());
            actions.push(Action::Vary(VaryAction::Breed(parents, locks)));
        }
        ui.add_space(GAP);
        ui.weak("keep");
        ui.spacing_mut().item_spacing.x = 2.0;
        for aspect in Aspect::ALL {
            let (title, help) = described(aspect);
            let mut is_locked = breeding.locks.contains(&aspect);
            let toggle = ui.toggle_value(&mut is_locked, title);
            toggle.widget_info(|| {
                let name = format!("Keep {}", title.to_lowercase());
                egui::WidgetInfo::selected(egui::Role::CheckBox, true, is_locked, name)
            });
            if toggle.on_hover_text(help).clicked() {
                match is_locked {
                    true => breeding.locks.insert(aspect),
                    false => breeding.locks.remove(&aspect),
                };
            }
        }
    });
}

/// Which generation the gallery shows, and the way back.
pub(super) fn lineage(ui: &mut Ui, generations: usize, actions: &mut Vec<Action>) {
    if generations == 0 {
        return;
    }
    ui.add_space(GAP);
    ui.label(format!("Generation {generations}"))
        .on_hover_text("The gallery shows children; their parents stand before them.");
    let help =
        "Shows the trees again that the parents were chosen from. Redo and undo go both ways.";
    let back = ui.small_button("Back to Parents").on_hover_text(help);
    if back.clicked() {
        actions.push(Action::Vary(VaryAction::BackToParents));
    }
}

fn described(aspect: Aspect) -> (&'static str, &'static str) {
    match aspect {
        Aspect::Contour => ("Outline", "Children have the outline of one parent."),
        Aspect::Exemplars => (
            "Exemplars",
            "Children are made of their parents' exemplars only; no other joins.",
        ),
        Aspect::Colors => (
            "Leaves",
            "Children have the leaves and colours of one parent.",
        ),
        Aspect::Hue => (
            "Hue",
            "Children's colours are moved as those of one parent.",
        ),
        Aspect::Foliage => (
            "Foliage",
            "Foliage grown anew, limbs and the mirror are as in one parent.",
        ),
        Aspect::Season => (
            "Season",
            "The season and its extent are those of one parent.",
        ),
    }
}
