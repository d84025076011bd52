//! The studio: the window that artists work in.
//!
//! What the window knows is [`Studio`], plain data without a word of `egui`: the project, the pictures
//! it shows, the tools in hand, the jobs that run. Each frame the [`shell`] draws it: panels look at
//! the studio and answer with [`Action`]s; when all are drawn, [`Studio::act`] does what they ask. So
//! nothing changes under a panel that is being drawn, every change of the project is in one file
//! ([`act`]), and a test can do what a user does without a window.
//!
//! A [`Command`] is what has a name: it stands in a menu, in the palette and on a key, all three read
//! from one table.
//!
//! Imports everything but `cli`.

mod act;
mod action;
mod commands;
mod dock;
mod files;
mod live;
mod live_job;
mod live_picture;
mod outcome;
mod palette;
mod panels;
mod photos;
mod preferences;
mod shell;
mod shortcut_sheet;
mod start;
mod studio;
mod theme;

pub use action::{Action, Gesture};
pub use commands::{Command, Menu};
pub use live::{Drawn, LiveAction};
pub use shell::{Shell, StartError, run};
pub use studio::{Studio, Workspace};
