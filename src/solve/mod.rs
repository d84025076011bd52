//! Large sparse linear systems on pixel grids: assembled once, factorised once, solved many times.
//!
//! Imports `base`, `raster`.
