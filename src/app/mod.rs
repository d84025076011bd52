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
mod act_mask;
mod act_vary;
mod action;
mod batch_jobs;
mod commands;
mod cpu_window;
mod crown_jobs;
mod dock;
mod files;
mod k_field;
mod live;
mod live_job;
mod live_picture;
mod make_dialog;
mod mask_action;
mod mask_jobs;
mod outcome;
mod own_model;
mod palette;
mod panels;
mod photo_jobs;
mod photos;
mod preferences;
mod run;
mod selecting;
mod shell;
mod shortcut_sheet;
mod start;
mod studio;
mod theme;
mod tools;
mod tour;
mod vary;
mod vary_jobs;
mod vary_making;

pub use act_vary::VaryAction;
pub use action::{Action, Answer, Gesture, Pen};
pub use batch_jobs::{BatchSettings, ExportChoice, Which};
pub use commands::{Command, Menu, Row, TABLE};
pub use cpu_window::{Canvas, Textures};
pub use dock::Pane;
pub use live::{Drawn, LiveAction};
pub use mask_action::{MaskAction, MaskCommand};
pub use preferences::{Navigation, Preferences};
pub use run::{Session, StartError, run};
pub use shell::Shell;
pub use studio::{Next, Notice, ProjectFile, Question, Severity, Studio, Workspace};
pub use tools::{Overlay, Tool, ToolOption};
