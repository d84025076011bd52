//! Boscage turns a few tree pictures into any number of new trees.
//!
//! The modules stand in the order of their imports: each imports only from those above it.

pub mod base;

pub mod raster;

pub mod geometry;

pub mod solve;

pub mod contour;

pub mod segment;

pub mod paint;

pub mod branches;

pub mod variation;

pub mod crown;

pub mod synth;

pub mod scene;

pub mod document;

pub mod pipeline;

pub mod jobs;

pub mod render;

pub mod export;

pub mod sheet;

pub mod batch;

pub mod app;

pub mod cli;
