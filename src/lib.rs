//! Boscage turns a few tree pictures into any number of new trees.
//!
//! The modules stand in the order of their imports: each imports only from those above it.

pub mod base;
pub mod branches;
pub mod raster;
