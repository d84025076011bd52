//! Baseline: the bilaplacian by smoothing forth and back (thesis §4.3.1).
//!
//! The flat mesh of the mask's pixels; every silhouette pixel has a twin k pixels behind it. Each of
//! N rounds moves all points by λ towards the mean of their neighbours and then by λ away from the
//! mean of their new ones: together v − λ² L(L(v)), a step of the bilaplacian flow. Silhouette and
//! twins are put back after each round; in between the silhouette must move, or nothing inside would
//! ever learn of the twins.
//!
//! Neighbours are the eight pixels around within the mask, and the twin. Known weakness, which is
//! why the linear system exists: slow, and far from converged after the 2N = 2000 steps of the
//! thesis: only a border of some tens of pixels rises.

use super::domain::{AROUND, Domain};
use super::inflation::{InflationError, Sheet};
use super::surface::{NO_PIXEL, numbered};
use crate::base::{Cancel, Progress};
use glam::DVec3;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How long and how strongly to smooth.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct IterativeSettings {
    /// N: rounds of two steps each.
    pub rounds: u32,
    /// λ, above 0 and at most 0.5: beyond, the finest waves would grow instead of fade.
    pub lambda: f64,
}

impl Default for IterativeSettings {
    /// 2N = 2000 and λ = 0.5, as in the thesis' Fig. 4.10.
    fn default() -> Self {
        Self {
            rounds: 1000,
            lambda: 0.5,
        }
    }
}

/// Pixels that one task moves.
const CHUNK: usize = 4096;

/// The sheet over `domain` after smoothing; `k_of_ring` as for [`super::Inflation::sheet`]. A
/// silhouette pixel takes the mean k of the ring pixels beside it. Stage: `solve`.
///
/// # Errors
/// When `k_of_ring` has not one value a ring pixel, or the work is cancelled.
pub fn iterative_sheet(
    domain: &Arc<Domain>,
    k_of_ring: &[f64],
    settings: IterativeSettings,
    progress: Progress<'_>,
    cancel: &Cancel,
) -> Result<Sheet, InflationError> {
    let (given, expected) = (k_of_ring.len(), domain.ring().len());
    if given != expected {
        return Err(InflationError::RingLength { given, expected });
    }
    let stage = progress.stage("solve", u64::from(settings.rounds));
    let web = Web::new(domain, k_of_ring);
    let flat = |&(x, y): &(u32, u32)| DVec3::new(x.into(), y.into(), 0.0);
    let start: Vec<DVec3> = domain.pixels().iter().map(flat).collect();
    let mut points = start.clone();
    let mut between = start.clone();
    for _ in 0..settings.rounds {
        cancel.check()?;
        web.step(&points, &mut between, settings.lambda);
        cancel.check()?;
        web.step(&between, &mut points, -settings.lambda);
        for (pixel, point) in points.iter_mut().enumerate() {
            if domain.is_silhouette(pixel) {
                *point = start[pixel];
            }
        }
        stage.advance();
    }
    Ok(Sheet {
        domain: Arc::clone(domain),
        positions: points,
    })
}

/// Who is whose neighbour.
struct Web {
    /// The neighbours of each pixel, [`NO_PIXEL`] for those outside.
    neighbours: Vec<[u32; 8]>,
    /// The twin of each silhouette pixel.
    twins: Vec<Option<DVec3>>,
}

impl Web {
    fn new(domain: &Domain, k_of_ring: &[f64]) -> Self {
        let numbers = numbered(domain.mask());
        let number = |x: i64, y: i64| numbers.get(x, y).unwrap_or(NO_PIXEL);
        let around = |&(x, y): &(u32, u32)| {
            AROUND.map(|(dx, dy)| number(i64::from(x) + dx, i64::from(y) + dy))
        };
        let mut sums = vec![(0.0, 0u32); domain.pixels().len()];
        for (pixel, k) in domain.ring().iter().zip(k_of_ring) {
            for (dx, dy) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                let beside = number(i64::from(pixel.x) + dx, i64::from(pixel.y) + dy);
                if beside != NO_PIXEL {
                    sums[beside as usize].0 += k;
                    sums[beside as usize].1 += 1;
                }
            }
        }
        let twin = |(&(x, y), &(sum, count)): (&(u32, u32), &(f64, u32))| {
            (count > 0).then(|| DVec3::new(x.into(), y.into(), -sum / f64::from(count)))
        };
        Self {
            neighbours: domain.pixels().iter().map(around).collect(),
            twins: domain.pixels().iter().zip(&sums).map(twin).collect(),
        }
    }

    /// `to` = `from` + `lambda` L(`from`).
    fn step(&self, from: &[DVec3], to: &mut [DVec3], lambda: f64) {
        to.par_chunks_mut(CHUNK)
            .enumerate()
            .for_each(|(chunk, to)| {
                for (i, moved) in to.iter_mut().enumerate() {
                    let pixel = chunk * CHUNK + i;
                    let near = self.neighbours[pixel].iter().filter(|&&n| n != NO_PIXEL);
                    let (mut sum, mut count) = (DVec3::ZERO, 0u32);
                    for &neighbour in near {
                        sum += from[neighbour as usize];
                        count += 1;
                    }
                    if let Some(twin) = self.twins[pixel] {
                        sum += twin;
                        count += 1;
                    }
                    let mean = if count > 0 {
                        sum / f64::from(count)
                    } else {
                        from[pixel]
                    };
                    *moved = from[pixel] + lambda * (mean - from[pixel]);
                }
            });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    fn sheet(k: f64, rounds: u32) -> Sheet {
        let domain = Arc::new(Domain::new(&Image::filled(15, 15, true)).unwrap());
        let k = vec![k; domain.ring().len()];
        let settings = IterativeSettings {
            rounds,
            lambda: 0.5,
        };
        iterative_sheet(&domain, &k, settings, Progress::silent(), &Cancel::new()).unwrap()
    }

    #[test]
    fn it_rises_with_k_and_keeps_the_silhouette() {
        let (low, high) = (sheet(1.0, 3000), sheet(2.0, 3000));
        let middle = 7 * 15 + 7;
        let z = low.positions[middle].z;
        assert!(z > 0.1, "{z}");
        assert!((high.positions[middle].z - 2.0 * low.positions[middle].z).abs() < 1e-9);
        assert_eq!(low.positions[0], DVec3::ZERO);
        assert!(sheet(0.0, 50).positions.iter().all(|p| p.z == 0.0));
    }

    #[test]
    fn a_cancelled_smoothing_stops() {
        let domain = Arc::new(Domain::new(&Image::filled(5, 5, true)).unwrap());
        let cancel = Cancel::new();
        cancel.cancel();
        let k = vec![1.0; domain.ring().len()];
        let found = iterative_sheet(
            &domain,
            &k,
            IterativeSettings::default(),
            Progress::silent(),
            &cancel,
        );
        assert!(matches!(found, Err(InflationError::Cancelled(_))));
    }
}
