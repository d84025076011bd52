//! Which exemplars become a new tree, and how much of each.
//!
//! The paper picks two at random (Argudo, Andújar & Chica 2017, *Tree Variations*, §6.5) and shows
//! where that ends: a thin, sparse tree poured into a thick outline (Fig. 15). We walk on the graph of
//! trees that go together (its §7, see `compatibility`), from one exemplar to a near one, up to
//! [`DRAWS`] times, until the measured distortion is small; if none is, the least distorted draw is
//! taken and says so. Where no two exemplars are of a kind nothing is mixed, unless any pair may be; a
//! target that none goes with stays by itself.
//!
//! The graph's edges from an exemplar are found when the walk comes there: a large library need not
//! be looked at whole to make ten trees.

use super::compatibility::{NEIGHBOURS, Traits, are_of_a_kind, seen_from};
use super::mean_value::CageError;
use super::{Distortion, Layout, Shape};
use crate::base::{Random, Seed};
use serde::{Deserialize, Serialize};

/// Draws for one tree at most; with the 39 real trees some five are needed.
const DRAWS: u64 = 24;

/// Why no tree could be decided on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ChoiceError {
    /// The combined cage has no area.
    #[error(transparent)]
    Cage(#[from] CageError),
    /// Nothing may be mixed.
    #[error("no two of these trees match in trunk, density and habit; any pair must be allowed")]
    NoMatch,
}

/// How a tree gets its colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Coloring {
    /// All from one of the exemplars: the crispest leaves.
    #[default]
    One,
    /// Averaged with the weights of the outline.
    Blend,
}

/// What random choice may do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChoiceSettings {
    /// Exemplars in a tree, the target included.
    pub mix: usize,
    /// Range of the first weight of two, 0 to 1.
    pub weights: (f64, f64),
    /// Where colours come from.
    pub coloring: Coloring,
    /// How far a tree may go from what it is made of: at 0 it is the target, or what its exemplars mix
    /// to; at 1 half of a target's outline comes from other trees, and all of foliage and limbs is new.
    pub strength: f64,
    /// Whether only trees that match are mixed, and pairs that are much distorted drawn again.
    pub selective: bool,
}

impl Default for ChoiceSettings {
    fn default() -> Self {
        Self {
            mix: 2,
            weights: (0.3, 0.7),
            coloring: Coloring::default(),
            strength: 0.7,
            selective: true,
        }
    }
}

/// One exemplar's part in a tree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Part {
    /// Index of the exemplar.
    pub exemplar: usize,
    /// Its share of the outline; all shares sum to 1.
    pub contour_weight: f64,
    /// Its share of the colours; likewise.
    pub color_weight: f64,
}

/// A tree that was decided on.
#[derive(Debug, Clone)]
pub struct Chosen {
    /// Its exemplars.
    pub parts: Vec<Part>,
    /// Its outline and maps.
    pub layout: Layout,
}

/// The part that gives most by `weight`; of equals the first.
pub(super) fn giver(parts: &[Part], weight: impl Fn(&Part) -> f64) -> Option<&Part> {
    let parts = parts.iter().rev();
    parts.max_by(|a, b| weight(a).total_cmp(&weight(b)))
}

impl Chosen {
    /// The part that gives most by `weight`; of equals the first.
    pub fn giver(&self, weight: impl Fn(&Part) -> f64) -> Option<&Part> {
        giver(&self.parts, weight)
    }

    /// The tree of the given `parts` of `shapes`.
    ///
    /// # Errors
    /// [`CageError`] when the combined cage has no area.
    pub fn of(parts: Vec<Part>, shapes: &[&Shape]) -> Result<Self, CageError> {
        let of_parts: Vec<_> = parts
            .iter()
            .map(|part| {
                (
                    shapes[part.exemplar],
                    part.contour_weight,
                    part.color_weight,
                )
            })
            .collect();
        let layout = Layout::new(&of_parts)?;
        Ok(Self { parts, layout })
    }
}

/// Decides on a tree: `shapes` are the exemplars, `target` the index of the picture to vary, if
/// any. The same arguments give the same tree.
///
/// # Errors
/// [`ChoiceError`] when no draw gives a cage with an area, or there is no target, no two exemplars match
/// and `settings` ask for such that do.
///
/// # Panics
/// When there are no shapes.
pub fn chosen(
    shapes: &[&Shape],
    target: Option<usize>,
    settings: &ChoiceSettings,
    seed: Seed,
) -> Result<Chosen, ChoiceError> {
    let mut best: Option<Chosen> = None;
    let mut last_error = ChoiceError::NoMatch;
    let traits: Vec<Traits> = match settings.selective && settings.mix > 1 {
        true => shapes.iter().map(|shape| Traits::of(shape)).collect(),
        false => Vec::new(),
    };
    for draw in 0..DRAWS {
        let mut random = seed.derive("draw", draw).random();
        let Some(parts) = drawn(shapes, &traits, target, settings, &mut random) else {
            continue;
        };
        let chosen = match Chosen::of(parts, shapes) {
            Ok(chosen) => chosen,
            Err(error) => {
                last_error = error.into();
                continue;
            }
        };
        let good = FINE.hold(&chosen.layout.distortion);
        let penalty = |chosen: &Chosen| chosen.layout.distortion.penalty();
        if best
            .as_ref()
            .is_none_or(|best| penalty(&chosen) < penalty(best))
        {
            best = Some(chosen);
        }
        if good || !settings.selective {
            break;
        }
    }
    match (best, target) {
        (Some(best), _) => Ok(best),
        (None, None) => Err(last_error),
        (None, Some(target)) => Ok(alone(target, shapes)?),
    }
}

/// The target alone: what is random in a tree's foliage and outline makes it others, too.
fn alone(target: usize, shapes: &[&Shape]) -> Result<Chosen, CageError> {
    let part = Part {
        exemplar: target,
        contour_weight: 1.0,
        color_weight: 1.0,
    };
    Chosen::of(vec![part], shapes)
}

/// How far the weights of a tree "more like" another go from its own, 0 to 1: at 1 they could be
/// any. At a third the trees are siblings: alike at a glance, none a copy.
const NEARNESS: f64 = 1.0 / 3.0;

/// A draw of weights near those of `parts`, of the same exemplars. Colours come from where they came
/// from; where all gave some, with the weights of the outline again.
pub fn parts_near(parts: &[Part], seed: Seed) -> Vec<Part> {
    let mut random = seed.derive("near", 0).random();
    let share = NEARNESS * random.between(0.3, 1.0);
    let others = random.convex_weights(parts.len());
    let is_blend = parts.iter().filter(|part| part.color_weight > 0.0).count() > 1;
    let near = parts.iter().zip(others).map(|(part, other)| {
        let contour_weight = (1.0 - share) * part.contour_weight + share * other;
        let color_weight = if is_blend {
            contour_weight
        } else {
            part.color_weight
        };
        Part {
            contour_weight,
            color_weight,
            ..*part
        }
    });
    near.collect()
}

/// One draw of exemplars and weights; `None` when the first exemplar goes with no other.
fn drawn(
    shapes: &[&Shape],
    traits: &[Traits],
    target: Option<usize>,
    settings: &ChoiceSettings,
    random: &mut Random,
) -> Option<Vec<Part>> {
    let first = target.unwrap_or_else(|| random.below(shapes.len()));
    let wanted = settings.mix.saturating_sub(1);
    let exemplars = match settings.selective {
        true => walk(shapes, traits, first, wanted, random),
        false => any_with(shapes.len(), first, wanted, random),
    };
    let is_alone = exemplars.len() == 1 && wanted > 0 && shapes.len() > 1;
    if is_alone {
        return None;
    }
    let contour_weights = match target {
        Some(_) => target_weights(exemplars.len(), settings.strength, random),
        None => free_weights(exemplars.len(), settings.weights, random),
    };
    let color_weights = match settings.coloring {
        Coloring::Blend => contour_weights.clone(),
        Coloring::One => {
            let giver = if target.is_some() {
                0
            } else {
                picked(&contour_weights, random)
            };
            (0..exemplars.len())
                .map(|i| f64::from(u8::from(i == giver)))
                .collect()
        }
    };
    let weights = contour_weights.into_iter().zip(color_weights);
    let parts = exemplars.into_iter().zip(weights);
    let part = |(exemplar, (contour_weight, color_weight))| Part {
        exemplar,
        contour_weight,
        color_weight,
    };
    Some(parts.map(part).collect())
}

/// `first` and `wanted` others at most: a walk on the graph of trees that go together, each step to a
/// near one that is of a kind with all before.
fn walk(
    shapes: &[&Shape],
    traits: &[Traits],
    first: usize,
    wanted: usize,
    random: &mut Random,
) -> Vec<usize> {
    let mut path = vec![first];
    while path.len() <= wanted {
        let goes_with_all = |new: usize| {
            let mut path = path.iter();
            path.all(|&old| old != new && are_of_a_kind(shapes[old], shapes[new]))
        };
        let nearest = |from: usize| -> Vec<usize> {
            let seen = seen_from(from, shapes, traits).into_iter();
            let near = seen.map(|neighbour| neighbour.exemplar);
            near.filter(|&i| goes_with_all(i))
                .take(NEIGHBOURS)
                .collect()
        };
        let mut near = nearest(path[path.len() - 1]);
        if near.is_empty() && path.len() > 1 {
            near = nearest(first);
        }
        if near.is_empty() {
            break;
        }
        path.push(near[random.below(near.len())]);
    }
    path
}

/// `first` and `wanted` others of `count`, any.
fn any_with(count: usize, first: usize, wanted: usize, random: &mut Random) -> Vec<usize> {
    let others: Vec<usize> = (0..count).filter(|&i| i != first).collect();
    let chosen = random.choose(others.len(), wanted);
    std::iter::once(first)
        .chain(chosen.into_iter().map(|i| others[i]))
        .collect()
}

/// Weights of `count` exemplars: of two the first in the given range, of more any.
fn free_weights(count: usize, (low, high): (f64, f64), random: &mut Random) -> Vec<f64> {
    match count {
        2 => {
            let first = random.between(low, high);
            vec![first, 1.0 - first]
        }
        count => random.convex_weights(count),
    }
}

/// Weights in target mode: the others share between a half and all of `strength` / 2.
fn target_weights(count: usize, strength: f64, random: &mut Random) -> Vec<f64> {
    if count == 1 {
        return vec![1.0];
    }
    let others = strength / 2.0 * random.between(0.7, 1.0);
    let mut weights = vec![1.0 - others];
    weights.extend(
        random
            .convex_weights(count - 1)
            .iter()
            .map(|weight| weight * others),
    );
    weights
}

/// An index, drawn with the given weights of sum 1.
fn picked(weights: &[f64], random: &mut Random) -> usize {
    let mut left = random.unit();
    for (index, weight) in weights.iter().enumerate() {
        left -= weight;
        if left < 0.0 {
            return index;
        }
    }
    weights.len() - 1
}

/// Bounds of a distortion.
pub(super) struct Bounds {
    folded: f64,
    stretch: f64,
    smeared: f64,
}

/// What ends the search for a better draw: no streak shows at full size.
pub(super) const FINE: Bounds = Bounds {
    folded: 0.001,
    stretch: 1.7,
    smeared: 0.02,
};

/// What is fit to be seen: beyond, fans and streaks show at arm's length (looked at on 120 pairs of
/// real trees), and the user is warned.
const FIT: Bounds = Bounds {
    folded: 0.004,
    stretch: 2.2,
    smeared: 0.06,
};

impl Bounds {
    pub(super) fn hold(&self, found: &Distortion) -> bool {
        found.folded <= self.folded
            && found.stretch <= self.stretch
            && found.smeared <= self.smeared
    }
}

impl Distortion {
    /// Whether a tree so distorted is fit to be seen.
    pub fn is_small(&self) -> bool {
        FIT.hold(self)
    }

    /// One number to compare distortions by; the larger, the worse.
    pub fn penalty(&self) -> f64 {
        self.folded / FIT.folded + self.stretch / FIT.stretch + self.smeared / FIT.smeared
    }
}

/// A tree of straight lines: a crown twice as wide as `width` on a trunk, for tests.
#[cfg(test)]
pub(super) fn drawn_shape(width: f64, density: f64) -> Shape {
    use crate::contour::{PinnedContour, Pins};
    use crate::geometry::Point;
    let pins = Pins {
        bottom: 0,
        right: 1,
        left: 5,
    };
    let x = [0.0, 10.0, width, width, -width, -width, -10.0];
    let y = [100.0, 80.0, 70.0, 0.0, 0.0, 70.0, 80.0];
    let outline: Vec<Point> = x
        .iter()
        .zip(y)
        .map(|(x, y)| Point::new(60.0 + x, y))
        .collect();
    let contour = PinnedContour::resampled(&outline, pins, 100);
    Shape {
        size: 128,
        cage: contour.clone(),
        contour,
        baseline_y: Some(80.0),
        density,
        fullness: density,
        straight: 0.0,
        texture: 0.01,
        gaps: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::drawn_shape as shape;
    use super::*;

    #[test]
    fn the_same_seed_chooses_the_same_and_weights_are_convex() {
        let shapes = [
            shape(40.0, 0.9),
            shape(45.0, 0.85),
            shape(50.0, 0.8),
            shape(42.0, 0.9),
        ];
        let shapes: Vec<&Shape> = shapes.iter().collect();
        for mix in 1..5 {
            let settings = ChoiceSettings {
                mix,
                ..Default::default()
            };
            let one = chosen(&shapes, None, &settings, Seed(5)).unwrap();
            let again = chosen(&shapes, None, &settings, Seed(5)).unwrap();
            assert_eq!(one.parts, again.parts);
            assert_eq!(one.parts.len(), mix);
            let sum: f64 = one.parts.iter().map(|part| part.contour_weight).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn trees_of_another_kind_are_left_out() {
        let shapes = [shape(40.0, 0.9), shape(45.0, 0.3), shape(50.0, 0.85)];
        let shapes: Vec<&Shape> = shapes.iter().collect();
        for seed in 0..50 {
            let found = chosen(&shapes, Some(0), &ChoiceSettings::default(), Seed(seed)).unwrap();
            assert_eq!(found.parts[1].exemplar, 2);
            assert!(found.parts[0].contour_weight >= 0.65);
            assert_eq!(found.parts[0].color_weight, 1.0);
        }
    }

    #[test]
    fn a_sparse_tree_and_a_thick_one_are_mixed_only_when_asked() {
        let shapes = [shape(40.0, 0.3), shape(45.0, 0.9)];
        let shapes: Vec<&Shape> = shapes.iter().collect();
        let mut settings = ChoiceSettings::default();
        for seed in 0..20 {
            let free = chosen(&shapes, None, &settings, Seed(seed));
            assert_eq!(free.map(|found| found.parts), Err(ChoiceError::NoMatch));
            let aimed = chosen(&shapes, Some(1), &settings, Seed(seed));
            let exemplars = aimed.map(|found| found.parts.iter().map(|p| p.exemplar).collect());
            assert_eq!(exemplars, Ok(vec![1]));
        }
        settings.selective = false;
        let found = chosen(&shapes, None, &settings, Seed(1)).unwrap();
        assert_eq!(found.parts.len(), 2);
    }

    #[test]
    fn near_weights_are_convex_near_and_keep_the_giver_of_colours() {
        let part = |exemplar, contour_weight, color_weight| Part {
            exemplar,
            contour_weight,
            color_weight,
        };
        let parts = [part(3, 0.6, 0.0), part(1, 0.4, 1.0)];
        for seed in 0..50 {
            let near = parts_near(&parts, Seed(seed));
            let sum: f64 = near.iter().map(|part| part.contour_weight).sum();
            assert!((sum - 1.0).abs() < 1e-12);
            for (near, part) in near.iter().zip(&parts) {
                assert_eq!(near.exemplar, part.exemplar);
                assert_eq!(near.color_weight, part.color_weight);
                assert!((near.contour_weight - part.contour_weight).abs() <= NEARNESS);
            }
        }
        assert_ne!(parts_near(&parts, Seed(1)), parts_near(&parts, Seed(2)));
    }

    #[test]
    fn strength_zero_copies_the_target() {
        let shapes = [shape(40.0, 0.9), shape(45.0, 0.9)];
        let shapes: Vec<&Shape> = shapes.iter().collect();
        let settings = ChoiceSettings {
            strength: 0.0,
            ..Default::default()
        };
        let found = chosen(&shapes, Some(0), &settings, Seed(1)).unwrap();
        assert_eq!(found.layout.contour.points, shapes[0].contour.points);
        assert!(found.layout.distortion.stretch < 1.001);
    }
}
