//! Large sparse problems on pixel grids: linear systems, assembled once, factorised once, solved many
//! times; and minimum cuts of flow networks ([`Network`]).
//!
//! A [`GridSystem`] is a set of pixels with one of two [`Stencil`]s, the negative Laplacian or the
//! bilaplacian; what lies outside the set is zero or belongs to the right-hand side. Two solvers:
//! [`Factor`], a direct Cholesky factorisation for up to some hundred thousand unknowns, and
//! [`Multigrid`] inside conjugate gradients for more. [`Solver`] chooses; [`poisson`] is one solve.
//!
//! Both give the same bits for any number of threads and on every level of x86-64: sums run in a
//! written order and nothing is contracted. That is why the factorisation is our own: libraries
//! dispatch to fused multiplications by the processor they find.
//!
//! Imports `base`, `raster`.

mod dense;
mod dissection;
mod factor;
mod galerkin;
mod grid;
mod level;
mod min_cut;
mod multigrid;
mod network;
mod poisson;
mod solver;

pub use factor::Factor;
pub use grid::{GridSystem, Stencil};
pub use min_cut::Cut;
pub use multigrid::{Iterated, Multigrid};
pub use network::{Edge, HARD, Network};
pub use poisson::poisson;
pub use solver::{Method, Solver};
