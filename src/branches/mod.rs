//! Trees grown by code: skeletons, limbs, foliage, and their pictures.
//!
//! A species table gives the numbers; a skeleton grows by space colonisation or by rule; the pipe
//! model gives its limbs thickness; phyllotaxis sets the leaves; a painter makes a billboard with
//! exact labels. The built-in sample library is made here, see [`mod@samples`].
//!
//! Everything is a function of species and seed, bit for bit on every machine: no transcendental
//! function of the platform (`libm` and roots instead), no threads, no clock.
//!
//! Frame: metres, the foot of the stem at the origin, x right, y up, z towards the viewer.
//!
//! Imports `base`, `raster`.

pub mod bark;
pub mod canvas;
pub mod crown;
pub mod foliage;
pub mod light;
pub mod limbs;
mod noise;
pub mod render;
pub mod samples;
pub mod skeleton;
pub mod species;
pub mod sprite;
pub mod twigs;
pub mod whorls;
mod wood;

pub use samples::{GrownTree, Sample, samples};
