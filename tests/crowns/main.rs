//! Crowns from photographs: masks, inflation, relief, foliage and the renderer on the processor, beside real
//! pictures and what public tools make of them.
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]
#![allow(clippy::print_stdout, reason = "how near we are is worth reading")]
#![allow(clippy::print_stderr, reason = "a left-out test must say so")]

mod base_mesh;
#[path = "../reference/crowns.rs"]
mod crowns;
mod cubemap_seams;
mod graph_cut;
mod inflation;
mod paint_photos;
#[path = "../reference/mod.rs"]
mod reference;
mod relief;
mod render_cpu;
mod synthesis_quality;
