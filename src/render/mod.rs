//! Pictures of a scene: passes for graphics cards through wgpu, and their twin on the processor.
//!
//! Source: O. Argudo, *Plausible reconstruction and rendering of semi-procedural landscapes*, 2014,
//! chapter 5 ("the thesis" below).
//!
//! Imports `base`, `raster`, `geometry`, `scene`.
