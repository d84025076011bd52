//! Trees grown by code: skeletons, limbs, foliage, and their pictures.
//!
//! A species table gives the numbers; an individual is drawn from it; a skeleton grows by space
//! colonisation or by rule; the pipe model gives its limbs thickness, splines their form;
//! phyllotaxis sets the leaves; a painter makes a billboard with exact labels, depth and normals.
//! The built-in sample library is made here, see [`mod@samples`].
//!
//! Everything is a function of species and number, bit for bit on every machine: no transcendental
//! function of the platform (`libm` and roots instead), no threads, no clock.
//!
//! Frame: metres, the foot of the stem at the origin, x right, y up, z towards the viewer.
//!
//! Imports `base`, `raster`.

pub mod bark;
pub mod canvas;
pub mod crown;
pub mod foliage;
pub mod individual;
pub mod leaf_name;
pub mod light;
pub mod limbs;
mod noise;
pub mod ornament;
pub mod palm;
pub mod photo;
pub mod render;
pub mod samples;
pub mod shadow;
pub mod skeleton;
pub mod species;
pub mod spline;
pub mod sprite;
pub mod tree;
pub mod twig_canvas;
pub mod twigs;
pub mod whorls;
mod wood;

pub use individual::Individual;
pub use samples::{Sample, samples};
pub use tree::{GrownTree, Tree};
