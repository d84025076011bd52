//! The front of a crown from its mask: a thin plate, held at the silhouette and bent there.
//!
//! Idea: every pixel of the mask becomes a point in space. Those on the silhouette stay where they
//! are; the ring outside lies half a pixel further out and k pixels behind, so the surface arrives
//! at the silhouette steeply; in between, the bilaplacian of all three coordinates is zero.
//!
//! Source: the thesis, §4.3.2. Departures: the centre of the 13-point stencil is 20, not the printed
//! 16, which makes the matrix indefinite; the unknowns in the plane are displacements, which are
//! zero on the silhouette, so that nothing is lost in large coordinates.
//!
//! k enters the heights only, linearly: x and y are solved once for a mask, and so is the height for
//! k = 1. A constant k is then a multiplication, a varying one another solution with the same
//! factor.

use super::domain::Domain;
use super::restart::Restart;
use crate::base::{Cancel, Cancelled, Progress};
use crate::raster::Mask;
use crate::solve::{GridSystem, Method, Solver, Stencil};
use glam::DVec3;
use std::sync::Arc;

/// Unknowns from which on a search from the last solution beats a new factorisation.
const WORTH_A_SEARCH: usize = 60_000;

/// Why a mask cannot be inflated.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum InflationError {
    /// No pixel belongs to the mask.
    #[error("the mask is empty")]
    Empty,
    /// Not one k for each pixel of the ring.
    #[error("{given} values of k for a ring of {expected} pixels")]
    RingLength {
        /// Values given.
        given: usize,
        /// Pixels of the ring.
        expected: usize,
    },
    /// A k that is no number or infinite.
    #[error("k is not finite at pixel ({x}, {y}) of the ring")]
    NotFinite {
        /// Column of the pixel.
        x: i32,
        /// Row of the pixel.
        y: i32,
    },
    /// The work was asked to stop.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
}

/// A surface over a mask, in front of the picture's plane.
#[derive(Debug, Clone)]
pub struct Sheet {
    /// The mask and the classes of its pixels.
    pub domain: Arc<Domain>,
    /// Where each pixel of [`Domain::pixels`] lies: x and y in mask pixels, y down; z in pixels
    /// towards the viewer, 0 on the silhouette.
    pub positions: Vec<DVec3>,
}

/// A mask ready to be inflated with any k.
pub struct Inflation {
    domain: Arc<Domain>,
    solver: Solver,
    /// x, y displacement and height for k = 1 of each unknown.
    base: [Vec<f64>; 3],
}

impl Inflation {
    /// Prepares the system of `domain` and solves what does not depend on k. Stages: `factor`,
    /// `solve`.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn new(
        domain: impl Into<Arc<Domain>>,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, InflationError> {
        Self::with_method(domain, Method::Automatic, progress, cancel)
    }

    /// The same with a solver of the caller's choice.
    ///
    /// # Errors
    /// When the work is cancelled.
    pub fn with_method(
        domain: impl Into<Arc<Domain>>,
        method: Method,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, InflationError> {
        Self::started(domain.into(), method, None, progress, cancel)
    }

    /// The same for `mask`, this mask after a stroke of the brush: sought from this solution by
    /// conjugate gradients, without factorising anew. It is the surface that [`Self::new`] gives, to
    /// a ten-millionth of its size.
    ///
    /// A `mask` of another size, or a small one whose factorisation is quicker than any search, is
    /// treated as a new one.
    ///
    /// # Errors
    /// When the mask is empty or the work is cancelled.
    pub fn updated(
        &self,
        mask: &Mask,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, InflationError> {
        let domain = Arc::new(Domain::new(mask)?);
        let same_frame = (mask.width(), mask.height()) == self.solver.system().size();
        if !same_frame || domain.unknowns() < WORTH_A_SEARCH {
            return Self::started(domain, Method::Automatic, None, progress, cancel);
        }
        Self::started(domain, Method::Multigrid, Some(self), progress, cancel)
    }

    fn started(
        domain: Arc<Domain>,
        method: Method,
        last: Option<&Self>,
        progress: Progress<'_>,
        cancel: &Cancel,
    ) -> Result<Self, InflationError> {
        let system = GridSystem::new(domain.interior(), Stencil::Bilaplacian);
        let stage = progress.stage("factor", 1);
        let solver = Solver::new(system, method, cancel)?;
        stage.advance();
        drop(stage);
        let stage = progress.stage("solve", 3);
        let restart = match last {
            Some(last) => {
                let restart = Restart::new(solver.system(), last.solver.system(), cancel)?;
                Some((restart, &last.base))
            }
            None => None,
        };
        let mut base = [(); 3].map(|()| Vec::new());
        let sides = right_hand_sides(&domain, solver.system());
        for (axis, right) in sides.iter().enumerate() {
            let start = restart
                .as_ref()
                .map(|(restart, last)| restart.guess(right, &last[axis]));
            base[axis] = solver.solution(right, start.as_deref(), cancel)?;
            stage.advance();
        }
        drop(restart);
        Ok(Self {
            domain,
            solver,
            base,
        })
    }

    /// The mask and the classes of its pixels.
    pub fn domain(&self) -> &Arc<Domain> {
        &self.domain
    }

    /// The surface for `k_of_ring`, one k for each pixel of [`Domain::ring`], in pixels.
    ///
    /// # Errors
    /// When there are more or fewer values, one is not finite, or the work is cancelled.
    pub fn sheet(&self, k_of_ring: &[f64], cancel: &Cancel) -> Result<Sheet, InflationError> {
        let ring = self.domain.ring();
        if k_of_ring.len() != ring.len() {
            return Err(InflationError::RingLength {
                given: k_of_ring.len(),
                expected: ring.len(),
            });
        }
        if let Some(wrong) = k_of_ring.iter().position(|k| !k.is_finite()) {
            let (x, y) = (ring[wrong].x, ring[wrong].y);
            return Err(InflationError::NotFinite { x, y });
        }
        cancel.check()?;
        let first = k_of_ring[0];
        let heights: Vec<f64> = if k_of_ring.iter().all(|&k| k == first) {
            self.base[2].iter().map(|height| height * first).collect()
        } else {
            let mean = k_of_ring.iter().sum::<f64>() / k_of_ring.len() as f64;
            let start: Vec<f64> = self.base[2].iter().map(|height| height * mean).collect();
            let right = self.right_hand_side_of(k_of_ring);
            self.solver.solution(&right, Some(&start), cancel)?
        };
        cancel.check()?;
        Ok(self.sheet_of(&heights))
    }

    fn right_hand_side_of(&self, k_of_ring: &[f64]) -> Vec<f64> {
        let mut right = vec![0.0; self.solver.system().len()];
        for (pixel, k) in self.domain.ring().iter().zip(k_of_ring) {
            self.solver
                .system()
                .spread(pixel.x.into(), pixel.y.into(), -k, &mut right);
        }
        right
    }

    fn sheet_of(&self, heights: &[f64]) -> Sheet {
        let pixels = self.domain.pixels();
        let mut positions: Vec<DVec3> = pixels
            .iter()
            .map(|&(x, y)| DVec3::new(x.into(), y.into(), 0.0))
            .collect();
        let interior = (0..pixels.len()).filter(|&pixel| !self.domain.is_silhouette(pixel));
        for (unknown, pixel) in interior.enumerate() {
            let [x, y, _] = &self.base;
            positions[pixel] += DVec3::new(x[unknown], y[unknown], heights[unknown]);
        }
        Sheet {
            domain: Arc::clone(&self.domain),
            positions,
        }
    }
}

/// The right-hand sides of x, of y, and of the height for k = 1.
fn right_hand_sides(domain: &Domain, system: &GridSystem) -> [Vec<f64>; 3] {
    let mut sides = [(); 3].map(|()| vec![0.0; system.len()]);
    for pixel in domain.ring() {
        let (x, y) = (i64::from(pixel.x), i64::from(pixel.y));
        let displacement = [
            pixel.position.x - x as f64,
            pixel.position.y - y as f64,
            -1.0,
        ];
        for (right, value) in sides.iter_mut().zip(displacement) {
            system.spread(x, y, value, right);
        }
    }
    sides
}
