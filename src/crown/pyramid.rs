//! The pyramid that turns luminance into relief: the same steps for a photograph within its mask and
//! for a cubemap, which differ only in how they are smoothed.
//!
//! Levels are smoothed more and more and never made smaller (thesis §4.4: enlarging them again would
//! leave marks). Their sum is weighted, the coarse levels most: whole branches reach out, leaves only
//! roughen them.
//!
//! Departures from the thesis: the finest level is the luminance itself; widths are shares of the
//! crown's size, not pixels, so that a preview at half the size shows the same relief; the light of
//! the sky on one side of the crown may be taken off first (`even_light`).

use serde::{Deserialize, Serialize};

/// How luminance becomes relief.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReliefSettings {
    /// Number of levels, 1 … 8; the thesis uses 4 and 5.
    pub levels: u32,
    /// Standard deviation of the coarsest level, as a share of the crown's width (or of the way
    /// across a cube's face). 0.06 is about a branch of an oak with all its leaves; larger values
    /// make few large bulges, smaller ones gravel.
    pub coarsest: f64,
    /// How much finer each next level is, above 1.
    pub growth: f64,
    /// Weight of each level against the next coarser one, 0 … 1: at 1 leaves rise as far as
    /// branches and the surface is noisy, at 0 only the coarsest level is left.
    pub falloff: f64,
    /// Whether levels are bands (the Laplacian pyramid) or contain all that is coarser (the
    /// Gaussian one, more prominent).
    pub pyramid: Pyramid,
    /// How much of the light that changes slowly over the crown is taken off, 0 … 1: the sun on one
    /// side, the dark below. It would lean the whole relief to one side.
    pub even_light: f64,
    /// How steep the walls of gaps may be, 0.05 … 20: the tangent against the base surface. A
    /// picture that is laid on along the radius is drawn out on steep walls, which makes fur of
    /// leaves; at 1 it is by √2.
    pub steepest: f64,
}

/// What the levels of the pyramid hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pyramid {
    /// Each level all that is coarser than its width.
    #[default]
    Gaussian,
    /// Each level what lies between its width and the next; the coarsest as in `Gaussian`.
    Laplacian,
}

impl Default for ReliefSettings {
    fn default() -> Self {
        Self {
            levels: 5,
            coarsest: 0.06,
            growth: 2.0,
            falloff: 0.4,
            pyramid: Pyramid::Gaussian,
            even_light: 0.8,
            steepest: 0.8,
        }
    }
}

/// A setting is outside its range.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{name} is {value}, not {range}")]
pub struct SettingError {
    /// The setting.
    pub name: &'static str,
    /// What it was.
    pub value: f64,
    /// What it may be.
    pub range: &'static str,
}

/// The standard deviation of what counts as slowly changing light, as a share of the crown's width:
/// a quarter is far coarser than a branch and still follows the round of the crown.
const LIGHT_SIGMA: f64 = 0.25;

impl ReliefSettings {
    /// Checks that all values are in range.
    ///
    /// # Errors
    /// [`SettingError`], the first that is not.
    pub fn check(&self) -> Result<(), SettingError> {
        let inside = |value: f64, low: f64, high: f64| value >= low && value <= high;
        let levels = f64::from(self.levels);
        let rules = [
            ("levels", levels, inside(levels, 1.0, 8.0), "1 to 8"),
            (
                "coarsest",
                self.coarsest,
                inside(self.coarsest, 0.0, 0.25),
                "0 to 0.25",
            ),
            (
                "growth",
                self.growth,
                inside(self.growth, 1.1, 8.0),
                "1.1 to 8",
            ),
            (
                "falloff",
                self.falloff,
                inside(self.falloff, 0.0, 1.0),
                "0 to 1",
            ),
            (
                "even_light",
                self.even_light,
                inside(self.even_light, 0.0, 1.0),
                "0 to 1",
            ),
            (
                "steepest",
                self.steepest,
                inside(self.steepest, 0.05, 20.0),
                "0.05 to 20",
            ),
        ];
        match rules.into_iter().find(|rule| !rule.2) {
            None => Ok(()),
            Some((name, value, _, range)) => Err(SettingError { name, value, range }),
        }
    }

    /// Standard deviations of the levels in pixels, finest (0: the luminance itself) first, for a
    /// crown of `width` pixels.
    pub fn sigmas(&self, width: f64) -> Vec<f64> {
        let finer = |steps: u32| self.coarsest * width / self.growth.powi(steps as i32);
        let coarse = (0..self.levels.saturating_sub(1)).rev().map(finer);
        std::iter::once(0.0).chain(coarse).collect()
    }

    /// Weights of the levels as they stand, of a Gaussian pyramid; of sum 1 or, for bands, such that
    /// the bands have the weights asked for.
    pub fn weights(&self) -> Vec<f64> {
        let levels = self.levels as i32;
        let bands: Vec<f64> = (0..levels)
            .map(|level| self.falloff.powi(levels - 1 - level))
            .collect();
        let sum: f64 = bands.iter().sum();
        let weights = bands.iter().map(|weight| weight / sum);
        match self.pyramid {
            Pyramid::Gaussian => weights.collect(),
            // Σ b_l (G_l − G_{l+1}) + b_L G_L, gathered by levels.
            Pyramid::Laplacian => {
                let finer = std::iter::once(0.0).chain(weights.clone());
                weights.zip(finer).map(|(own, finer)| own - finer).collect()
            }
        }
    }

    /// Standard deviation in pixels of the light to be taken off.
    pub(super) fn light_sigma(width: f64) -> f64 {
        LIGHT_SIGMA * width
    }
}

/// The weighted sum of the levels that `smoothed` makes from `values`, and the slow light taken off.
///
/// `add` adds the second value times the weight to the first.
pub(super) fn summed<T: Clone, E>(
    values: &T,
    settings: &ReliefSettings,
    width: f64,
    mut smoothed: impl FnMut(&T, f64) -> Result<T, E>,
    add: impl Fn(&mut T, &T, f32),
) -> Result<T, E> {
    let mut values = values.clone();
    if settings.even_light > 0.0 {
        let light = smoothed(&values, ReliefSettings::light_sigma(width))?;
        add(&mut values, &light, -settings.even_light as f32);
    }
    let mut sum: Option<T> = None;
    for (sigma, weight) in settings.sigmas(width).into_iter().zip(settings.weights()) {
        let level = smoothed(&values, sigma)?;
        let sum = sum.get_or_insert_with(|| {
            let mut zero = level.clone();
            add(&mut zero, &level, -1.0);
            zero
        });
        add(sum, &level, weight as f32);
    }
    Ok(sum.unwrap_or(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_grow_and_weigh_more_the_coarser_they_are() {
        let settings = ReliefSettings::default();
        let (sigmas, weights) = (settings.sigmas(100.0), settings.weights());
        assert_eq!(sigmas, [0.0, 0.75, 1.5, 3.0, 6.0]);
        assert!(weights.is_sorted() && weights[0] > 0.0);
        assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn bands_of_equal_weight_give_the_picture_back() {
        let settings = ReliefSettings {
            falloff: 1.0,
            levels: 4,
            pyramid: Pyramid::Laplacian,
            ..Default::default()
        };
        // Four bands of 1/4 each: a quarter of what the finest level holds, and nothing else.
        assert_eq!(settings.weights(), [0.25, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn values_out_of_range_are_named() {
        let settings = ReliefSettings {
            falloff: f64::NAN,
            ..Default::default()
        };
        assert_eq!(settings.check().unwrap_err().name, "falloff");
        assert_eq!(ReliefSettings::default().check(), Ok(()));
    }
}
