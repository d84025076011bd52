//! The solver that fits a system's size.

use super::factor::Factor;
use super::grid::{GridSystem, Stencil};
use super::multigrid::Multigrid;
use crate::base::{Cancel, Cancelled};

/// Unknowns up to which the bilaplacian is factorised: a disc across 500 pixels, whose factor
/// takes 0.3 GB.
const DIRECT_BILAPLACIAN: usize = 200_000;

/// The same for the Laplacian, whose factor is a third as large.
const DIRECT_LAPLACIAN: usize = 400_000;

/// How a system is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// Factorised for up to some hundred thousand unknowns, multigrid for more.
    Automatic,
    /// Cholesky factorisation.
    Direct,
    /// Multigrid in conjugate gradients; factorised if that stalls.
    Multigrid,
}

/// A system ready to be solved for any number of right-hand sides.
pub struct Solver {
    system: GridSystem,
    kind: Kind,
}

enum Kind {
    Direct(Factor),
    Iterative(Multigrid),
}

impl Solver {
    /// Prepares to solve `system`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn new(system: GridSystem, method: Method, cancel: &Cancel) -> Result<Self, Cancelled> {
        let most = match system.stencil() {
            Stencil::Bilaplacian => DIRECT_BILAPLACIAN,
            Stencil::Laplacian => DIRECT_LAPLACIAN,
        };
        let is_direct = match method {
            Method::Automatic => system.len() <= most,
            Method::Direct => true,
            Method::Multigrid => false,
        };
        let hierarchy = if is_direct {
            None
        } else {
            Multigrid::new(&system, cancel)?
        };
        let kind = match hierarchy {
            Some(multigrid) => Kind::Iterative(multigrid),
            None => Kind::Direct(Factor::new(&system, cancel)?),
        };
        Ok(Self { system, kind })
    }

    /// The system.
    pub fn system(&self) -> &GridSystem {
        &self.system
    }

    /// Whether the system is factorised.
    pub fn is_direct(&self) -> bool {
        matches!(self.kind, Kind::Direct(_))
    }

    /// The solution for `right`, one value an unknown; `start`, if there is one, is a guess that
    /// spares the iterative solver work.
    ///
    /// # Errors
    /// When the work is cancelled.
    ///
    /// # Panics
    /// When `right` has another length than the system.
    pub fn solution(
        &self,
        right: &[f64],
        start: Option<&[f64]>,
        cancel: &Cancel,
    ) -> Result<Vec<f64>, Cancelled> {
        assert_eq!(right.len(), self.system.len(), "one value an unknown");
        cancel.check()?;
        match &self.kind {
            Kind::Direct(factor) => Ok(factor.solution(right)),
            Kind::Iterative(multigrid) => {
                match multigrid.solution(right, start, cancel)?.solution {
                    Some(solution) => Ok(solution),
                    None => Ok(Factor::new(&self.system, cancel)?.solution(right)),
                }
            }
        }
    }
}
