//! Variations of trees: outlines, maps, segmenters, sheets and individuals, beside real pictures and what public
//! tools make of them.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "how near we are is worth reading")]
#![allow(clippy::print_stderr, reason = "a left-out test must say so")]

mod compatibility;
mod individuals;
mod learned;
mod oracle;
mod real_trees;
#[path = "../reference/mod.rs"]
mod reference;
mod segmentation;
mod sheets;
