//! The house itself: its layers, its shaders, what it is built of.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "how near we are is worth reading")]
#![allow(clippy::print_stderr, reason = "a left-out test must say so")]

mod layering;
mod shaders;
mod supply;
