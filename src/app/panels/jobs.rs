//! What is being worked on.

use super::super::action::Action;
use super::super::studio::Studio;
use super::super::theme::GAP;
use super::empty;
use crate::jobs::Phase;
use egui::{ProgressBar, Ui};

pub(super) fn show(ui: &mut Ui, studio: &Studio, actions: &mut Vec<Action>) {
    let jobs = studio.jobs.snapshot();
    if jobs.is_empty() {
        empty(
            ui,
            "Nothing to do",
            "Batches, exports and long computations show here.",
        );
        return;
    }
    egui::Frame::NONE.inner_margin(GAP).show(ui, |ui| {
        egui::ScrollArea::vertical()
            .auto_shrink(false)
            .show(ui, |ui| {
                for job in jobs {
                    ui.label(&job.name);
                    let doing = match (job.phase, job.stage) {
                        (Phase::Queued, _) => "waits",
                        (Phase::Paused, _) => "paused",
                        (Phase::Stopping, _) => "stops",
                        (Phase::Running, Some(stage)) => stage,
                        (Phase::Running, None) => "works",
                    };
                    let share = job.fraction().unwrap_or(0.0) as f32;
                    ui.add(ProgressBar::new(share).text(doing).desired_height(16.0));
                    ui.horizontal(|ui| {
                        let is_paused = job.phase == Phase::Paused;
                        if ui
                            .small_button(if is_paused { "Go On" } else { "Pause" })
                            .clicked()
                        {
                            actions.push(Action::PauseJob(job.id, !is_paused));
                        }
                        if ui.small_button("Cancel").clicked() {
                            actions.push(Action::CancelJob(job.id));
                        }
                    });
                    for warning in &job.warnings {
                        ui.colored_label(super::super::theme::tokens(ui).warning, warning);
                    }
                    ui.add_space(GAP);
                }
            });
    });
}
