//! The real binary as users and pipelines run it: exit codes, messages, files.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "how near we are is worth reading")]
#![allow(clippy::print_stderr, reason = "a left-out test must say so")]

mod cli;
mod crown;
mod determinism;
mod export;
mod export_crowns;
mod export_interrupted;
mod exported;
mod inflate;
mod limits;
mod pictures;
mod project_files;
#[path = "../reference/mod.rs"]
mod reference;
mod vary;
