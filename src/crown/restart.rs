//! A guess for the solution of an edited mask: that of the mask before the edit, mended around the
//! edit by a small direct solution.
//!
//! Carried over alone, the old solution is as wrong at the edit as zero would be, and the search
//! from it saves an iteration or two. Mended in a window around the changed pixels, it saves some
//! more; the preparation of the coarse grids, which is not carried over, remains.

use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Rect, opaque_bounds};
use crate::solve::{Factor, GridSystem};

/// Pixels around the edit that are mended at least. Much less cuts through the bend at the
/// silhouette, much more costs a larger factorisation.
const LEAST_MARGIN: u32 = 24;

/// Mends guesses for one system.
pub(super) struct Restart<'a> {
    system: &'a GridSystem,
    before: &'a GridSystem,
    /// The pixels around the edit with their factor; `None` when there is nothing to mend or too
    /// much.
    window: Option<(GridSystem, Factor)>,
}

impl<'a> Restart<'a> {
    /// Prepares guesses for `system` from solutions of `before`, a system on the same frame.
    pub(super) fn new(
        system: &'a GridSystem,
        before: &'a GridSystem,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let window = match window(system, before) {
            Some(mask) => {
                let window = GridSystem::new(&mask, system.stencil());
                let factor = Factor::new(&window, cancel)?;
                Some((window, factor))
            }
            None => None,
        };
        Ok(Self {
            system,
            before,
            window,
        })
    }

    /// A guess for the solution for `right`, `last` being the solution before the edit.
    pub(super) fn guess(&self, right: &[f64], last: &[f64]) -> Vec<f64> {
        let of = |system: &GridSystem, &(x, y): &(u32, u32)| system.number(x.into(), y.into());
        let pixels = self.system.pixels().iter();
        let carried = |pixel| of(self.before, pixel).map_or(0.0, |number| last[number]);
        let mut guess: Vec<f64> = pixels.map(carried).collect();
        let Some((window, factor)) = &self.window else {
            return guess;
        };
        let product = self.system.product(&guess);
        let numbers: Vec<usize> = window
            .pixels()
            .iter()
            .filter_map(|pixel| of(self.system, pixel))
            .collect();
        let residual: Vec<f64> = numbers.iter().map(|&i| right[i] - product[i]).collect();
        for (&number, value) in numbers.iter().zip(factor.solution(&residual)) {
            guess[number] += value;
        }
        guess
    }
}

/// The unknowns of `system` around the pixels in which it differs from `before`; `None` when there
/// are none, or more than a third of all.
fn window(system: &GridSystem, before: &GridSystem) -> Option<Mask> {
    let (width, height) = system.size();
    let mut changed = Image::filled(width, height, false);
    for (own, other) in [(system, before), (before, system)] {
        for &(x, y) in own.pixels() {
            if other.number(x.into(), y.into()).is_none() {
                changed.set(x, y, true);
            }
        }
    }
    let Rect {
        x,
        y,
        width: columns,
        height: rows,
    } = opaque_bounds(&changed)?;
    let margin = LEAST_MARGIN.max(columns.max(rows) / 2);
    let near = |value: u32, first: u32, count: u32| {
        value + margin >= first && value < first + count + margin
    };
    let mut mask = Image::filled(width, height, false);
    for &(px, py) in system.pixels() {
        mask.set(px, py, near(px, x, columns) && near(py, y, rows));
    }
    let count = mask.count();
    (count > 0 && count <= system.len() / 3).then_some(mask)
}
