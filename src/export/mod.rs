//! Files that other programs take: one file a format. Functions here make bytes; who writes them to
//! disk is the caller.
//!
//! Imports `base`, `raster`, `geometry`, `scene`.
