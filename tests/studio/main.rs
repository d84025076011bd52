//! The real window without a screen: gestures drive it, and what they should have done is looked up.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "how near we are is worth reading")]
#![allow(clippy::print_stderr, reason = "a left-out test must say so")]

mod canvas;
mod card;
mod cpu;
mod crown;
mod crowned;
mod gestures;
mod library;
mod live;
mod model;
mod pictures;
#[path = "../reference/mod.rs"]
mod reference;
mod soak;
mod variations;
mod window;
