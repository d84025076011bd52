//! Trees bred from trees: what a few chosen ones have, mixed anew and changed a little.
//!
//! *Idea.* After K. Sims, *Artificial Evolution for Computer Graphics* (1991): a person judges, chance
//! proposes. What a tree is decided by is a [`Genome`] of few numbers; a child takes each aspect
//! of it from its parents, crossed (outlines and hues lie between those of both, now and then somewhat
//! beyond), and mutated (weights drift, a tree that goes with the others joins, the giver of colours
//! changes, the foliage grows anew, a mirror turns it). An aspect under a lock comes from one parent as
//! it is there.
//!
//! A child is drawn up to [`DRAWS`] times, until its maps distort little, and is decided by the parents,
//! the locks and its seed alone: whoever keeps those need not keep the child.
//!
//! *Limits.* Parents that do not go together (see `compatibility`) are not mixed in outline: a child then
//! has that of one and may have hue, season and foliage of the other.

use super::choice::{ChoiceError, Chosen, FINE, Part};
use super::compatibility::{NEIGHBOURS, Traits, are_of_a_kind, seen_from};
use super::finish::{Finish, Reshaping, SeasonChoice};
use super::individual::IndividualSettings;
use super::{HslShift, Shape};
use crate::base::{Random, Seed};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Draws for a child at most: of parents that are fit to be seen the first or second is, too.
const DRAWS: u64 = 12;

/// How far weights drift at most, as a share of the way to any others.
const DRIFT: f64 = 0.6;

/// How far beyond its parents an outline may lie, as a share of the way between them.
const BEYOND: f64 = 0.2;

/// How often another exemplar joins, and the range of its share.
const JOINS: f64 = 0.4;
const JOINED_SHARE: (f64, f64) = (0.15, 0.4);

/// Most exemplars of a child, unless a parent has more: of more none is seen.
const MOST_PARTS: usize = 4;

/// How often another part gives the colours, and how often a mirror turns the tree.
const OTHER_GIVER: f64 = 0.2;
const TURNS: f64 = 0.2;

/// How much of the usual jitter of hue, saturation and lightness a child's colours move by, and how
/// much they may have moved after many generations.
const HUE_STEP: f64 = 0.6;
const MOST_MOVED: f64 = 1.5;

/// How often an outline is moved anew, and the range of how much.
const RENEWED: f64 = 0.4;
const RESHAPED: (f64, f64) = (0.35, 0.8);

/// How far the strength of an individual and the extent of a season move.
const AMOUNT_STEP: f64 = 0.15;

/// What is inherited by itself, and may be locked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Aspect {
    /// Which exemplars: none that no parent has
    Exemplars,
    /// The outline, with the exemplars that it is made of
    Contour,
    /// Whose colours
    Colors,
    /// How far colours are moved
    Hue,
    /// Foliage, limbs and the mirror
    Foliage,
    /// The season and its extent
    Season,
}

impl Aspect {
    /// In the order in which they are shown.
    pub const ALL: [Self; 6] = [
        Self::Contour,
        Self::Exemplars,
        Self::Colors,
        Self::Hue,
        Self::Foliage,
        Self::Season,
    ];
}

/// All that a tree is decided by.
#[derive(Debug, Clone, PartialEq)]
pub struct Genome {
    /// Its exemplars, with their shares of outline and colours.
    pub parts: Vec<Part>,
    /// The picture whose colours it takes, as whoever keeps such pictures counts them.
    pub like: Option<usize>,
    /// What becomes of it once it is mixed.
    pub finish: Finish,
    /// Where foliage, limbs and turned leaves are drawn from.
    pub seed: Seed,
}

/// What children come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Brood {
    /// At least one; with one a child is a mutation of it.
    pub parents: Vec<Genome>,
    /// Aspects that come from one parent as they are there.
    pub locks: BTreeSet<Aspect>,
}

/// A tree that was decided on, with all that becomes of it.
#[derive(Debug, Clone)]
pub struct Decided {
    /// What it is decided by.
    pub genome: Genome,
    /// Its outline and maps.
    pub chosen: Chosen,
}

impl Brood {
    /// The child of `seed`. `shapes` are all exemplars, `members` those that may join.
    ///
    /// # Errors
    /// [`ChoiceError`] when no draw gives a cage with an area.
    ///
    /// # Panics
    /// When there are no parents, or one has an exemplar that is not among `shapes`.
    pub fn child(
        &self,
        shapes: &[&Shape],
        members: &[usize],
        seed: Seed,
    ) -> Result<Decided, ChoiceError> {
        assert!(!self.parents.is_empty(), "children have parents");
        let mut best: Option<Decided> = None;
        let mut last_error = ChoiceError::NoMatch;
        for draw in 0..DRAWS {
            let mut random = seed.derive("breed", draw).random();
            let genome = self.drawn(shapes, members, seed, &mut random);
            let chosen = match Chosen::of(genome.parts.clone(), shapes) {
                Ok(chosen) => chosen,
                Err(error) => {
                    last_error = error.into();
                    continue;
                }
            };
            let distortion = chosen.layout.distortion;
            let is_best = best
                .as_ref()
                .is_none_or(|best| distortion.penalty() < best.chosen.layout.distortion.penalty());
            if is_best {
                best = Some(Decided { genome, chosen });
            }
            if FINE.hold(&distortion) {
                break;
            }
        }
        best.ok_or(last_error)
    }

    /// What the children of the `generations`th generation after this come from, each bred from all of
    /// the one before; one child for each of `seeds`.
    ///
    /// # Errors
    /// As [`Brood::child`].
    ///
    /// # Panics
    /// As [`Brood::child`].
    pub fn after(
        &self,
        generations: u32,
        shapes: &[&Shape],
        members: &[usize],
        seeds: &[Seed],
    ) -> Result<Self, ChoiceError> {
        let mut brood = self.clone();
        for generation in 0..generations {
            let own = |seed: &Seed| seed.derive("generation", u64::from(generation));
            let child = |seed: &Seed| brood.child(shapes, members, own(seed));
            let children = seeds.iter().map(|seed| Ok(child(seed)?.genome));
            brood.parents = children.collect::<Result<_, ChoiceError>>()?;
        }
        Ok(brood)
    }

    fn is_locked(&self, aspect: Aspect) -> bool {
        self.locks.contains(&aspect)
    }

    /// One draw of a child.
    fn drawn(
        &self,
        shapes: &[&Shape],
        members: &[usize],
        seed: Seed,
        random: &mut Random,
    ) -> Genome {
        let pair = random.choose(self.parents.len(), 2);
        let mother = &self.parents[pair[0]];
        let father = pair.get(1).map_or(mother, |&other| &self.parents[other]);
        let contour = self.contour(shapes, members, [mother, father], random);
        let giver = match self.is_locked(Aspect::Colors) || random.unit() < 0.5 {
            true => mother,
            false => father,
        };
        let foliage_seed = match self.is_locked(Aspect::Foliage) {
            true => mother.seed,
            false => seed,
        };
        Genome {
            parts: self.parts(shapes, &contour, giver, random),
            like: giver.like,
            finish: Finish {
                // Told by the names of the exemplars that it turns out to have.
                has_fronds: false,
                reshaping: self.reshaping([mother, father], seed),
                individual: self.individual([mother, father], random),
                shift: self.shift([mother, father], random),
                season: self.season([mother, father], random),
            },
            seed: foliage_seed,
        }
    }

    /// The outline of a child: shares of exemplars, of sum 1.
    fn contour(
        &self,
        shapes: &[&Shape],
        members: &[usize],
        [mother, father]: [&Genome; 2],
        random: &mut Random,
    ) -> BTreeMap<usize, f64> {
        let [own, other] = [mother, father].map(contour_of);
        if self.is_locked(Aspect::Contour) {
            return own;
        }
        let most = MOST_PARTS.max(own.len()).max(other.len());
        let share = random.between(-BEYOND, 1.0 + BEYOND);
        let mut mix = own.clone();
        let goes = other.keys().all(|&new| goes_with(shapes, &own, new));
        if goes {
            mix = between(&own, &other, share);
        }
        let drift = DRIFT * random.unit();
        let any = random.convex_weights(mix.len());
        for (weight, any) in mix.values_mut().zip(any) {
            *weight += drift * (any - *weight);
        }
        // All draws are made whatever the locks, so that a lock changes its own aspect only.
        let (joins, joined, which) = (
            random.unit(),
            random.between(JOINED_SHARE.0, JOINED_SHARE.1),
            random.unit(),
        );
        if joins < JOINS && !self.is_locked(Aspect::Exemplars) {
            let near = candidates(shapes, members, &mix);
            if let Some(&new) = near.get((which * near.len() as f64) as usize) {
                mix.values_mut().for_each(|weight| *weight *= 1.0 - joined);
                mix.insert(new, joined);
            }
        }
        largest(mix, most)
    }

    /// The parts of a child of that outline, whose colours are those of `giver` where they go with it.
    fn parts(
        &self,
        shapes: &[&Shape],
        contour: &BTreeMap<usize, f64>,
        giver: &Genome,
        random: &mut Random,
    ) -> Vec<Part> {
        let gives = giver.parts.iter().filter(|part| part.color_weight > 0.0);
        let goes = |part: &&Part| {
            contour.contains_key(&part.exemplar) || goes_with(shapes, contour, part.exemplar)
        };
        let mut colors: BTreeMap<usize, f64> = gives
            .filter(goes)
            .map(|part| (part.exemplar, part.color_weight))
            .collect();
        let (mutates, which) = (random.unit(), random.unit());
        let changes = mutates < OTHER_GIVER && !self.is_locked(Aspect::Colors);
        if colors.is_empty() || (changes && colors.len() == 1) {
            colors = BTreeMap::from([(picked(contour, which), 1.0)]);
        }
        let sum: f64 = colors.values().sum();
        let exemplars: BTreeSet<usize> = contour.keys().chain(colors.keys()).copied().collect();
        let part = |exemplar: usize| Part {
            exemplar,
            contour_weight: contour.get(&exemplar).copied().unwrap_or(0.0),
            color_weight: colors.get(&exemplar).copied().unwrap_or(0.0) / sum,
        };
        let mut parts: Vec<Part> = exemplars.into_iter().map(part).collect();
        parts.sort_by(|a, b| b.contour_weight.total_cmp(&a.contour_weight));
        parts
    }

    /// How the outline is moved beside being mixed: as one parent's, or otherwise.
    fn reshaping(&self, [mother, father]: [&Genome; 2], seed: Seed) -> Option<Reshaping> {
        let mut random = seed.derive("reshaping", 0).random();
        let [side, renewed, fresh] = [0; 3].map(|_| random.unit());
        let step = random.between(-AMOUNT_STEP, AMOUNT_STEP);
        if self.is_locked(Aspect::Contour) {
            return mother.finish.reshaping;
        }
        let parent = if side < 0.5 { mother } else { father };
        let own = parent.finish.reshaping.filter(|_| renewed >= RENEWED);
        let drawn = Reshaping {
            strength: RESHAPED.0 + fresh * (RESHAPED.1 - RESHAPED.0),
            seed: random.bits(),
        };
        let inherited = own.map(|own| Reshaping {
            strength: (own.strength + step).clamp(0.0, 1.0),
            ..own
        });
        Some(inherited.unwrap_or(drawn))
    }

    fn individual(
        &self,
        [mother, father]: [&Genome; 2],
        random: &mut Random,
    ) -> Option<IndividualSettings> {
        let [share, side, turn] = [0; 3].map(|_| random.unit());
        let step = random.between(-AMOUNT_STEP, AMOUNT_STEP);
        if self.is_locked(Aspect::Foliage) {
            return mother.finish.individual;
        }
        let [own, other] = [mother, father].map(|parent| parent.finish.individual);
        let strength = |of: Option<IndividualSettings>| of.map_or(0.0, |of| of.strength);
        let is_mirrored = |of: Option<IndividualSettings>| of.is_some_and(|of| of.mirrored);
        let between = strength(own) + share * (strength(other) - strength(own));
        // What was never grown anew stays as it is.
        let strength = match between > 0.0 {
            true => (between + step).clamp(0.0, 1.0),
            false => 0.0,
        };
        let inherited = is_mirrored(if side < 0.5 { own } else { other });
        let mirrored = inherited != (turn < TURNS);
        (strength > 0.0 || mirrored).then_some(IndividualSettings { strength, mirrored })
    }

    fn shift(&self, [mother, father]: [&Genome; 2], random: &mut Random) -> Option<HslShift> {
        let share = random.unit();
        let step = HslShift::drawn(HUE_STEP, random);
        if self.is_locked(Aspect::Hue) {
            return mother.finish.shift;
        }
        let [own, other] = [mother, father].map(|parent| parent.finish.shift);
        let [own, other] = [own, other].map(|shift| shift.unwrap_or(HslShift::NONE));
        Some(own.between(&other, share).and(&step, MOST_MOVED))
    }

    fn season(&self, [mother, father]: [&Genome; 2], random: &mut Random) -> Option<SeasonChoice> {
        let (side, share) = (random.unit(), random.unit());
        let [turned, fallen] = [0; 2].map(|_| random.between(-AMOUNT_STEP, AMOUNT_STEP));
        if self.is_locked(Aspect::Season) {
            return mother.finish.season;
        }
        let [own, other] = [mother, father].map(|parent| parent.finish.season);
        let mut season = if side < 0.5 { own } else { other }?;
        if let (Some(own), Some(other)) = (own, other)
            && own.settings.season == other.settings.season
        {
            let between = |a: f64, b: f64| a + share * (b - a);
            season.settings.amount = between(own.settings.amount, other.settings.amount);
            season.settings.snow = between(own.settings.snow, other.settings.snow);
        }
        let settings = &mut season.settings;
        settings.amount = (settings.amount + turned).clamp(0.0, 1.0);
        // Snow falls on nobody that had none.
        if settings.snow > 0.0 {
            settings.snow = (settings.snow + fallen).clamp(0.0, 1.0);
        }
        Some(season)
    }
}

/// The shares of a genome's outline; none that are 0.
fn contour_of(genome: &Genome) -> BTreeMap<usize, f64> {
    let parts = genome.parts.iter().filter(|part| part.contour_weight > 0.0);
    parts
        .map(|part| (part.exemplar, part.contour_weight))
        .collect()
}

/// The mix of both, `share` of it `other`; shares below 0 are none.
fn between(
    own: &BTreeMap<usize, f64>,
    other: &BTreeMap<usize, f64>,
    share: f64,
) -> BTreeMap<usize, f64> {
    let of = |all: &BTreeMap<usize, f64>, exemplar| all.get(exemplar).copied().unwrap_or(0.0);
    let exemplars: BTreeSet<usize> = own.keys().chain(other.keys()).copied().collect();
    let mixed = exemplars.iter().map(|exemplar| {
        let (a, b) = (of(own, exemplar), of(other, exemplar));
        (*exemplar, (a + share * (b - a)).max(0.0))
    });
    largest(mixed.collect(), exemplars.len())
}

/// The `most` largest shares, of sum 1 again; none that nobody sees.
fn largest(mix: BTreeMap<usize, f64>, most: usize) -> BTreeMap<usize, f64> {
    /// Smaller shares cost as much as large ones and change no outline.
    const LEAST: f64 = 0.02;
    let mut shares: Vec<(usize, f64)> = mix.into_iter().collect();
    shares.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    let seen = shares.iter().take(most).filter(|share| share.1 >= LEAST);
    let count = seen.count().max(1);
    shares.truncate(count);
    let sum: f64 = shares.iter().map(|share| share.1).sum();
    shares
        .into_iter()
        .map(|(exemplar, share)| (exemplar, share / sum))
        .collect()
}

/// Whether exemplar `new` may be mixed with all of `mix`.
fn goes_with(shapes: &[&Shape], mix: &BTreeMap<usize, f64>, new: usize) -> bool {
    let mut all = mix.keys();
    all.all(|&old| old == new || are_of_a_kind(shapes[old], shapes[new]))
}

/// Exemplars that could join `mix`: those nearest to the one of its largest share.
fn candidates(shapes: &[&Shape], members: &[usize], mix: &BTreeMap<usize, f64>) -> Vec<usize> {
    let heaviest = mix.iter().rev().max_by(|a, b| a.1.total_cmp(b.1));
    let Some((&heaviest, _)) = heaviest else {
        return Vec::new();
    };
    let traits: Vec<Traits> = shapes.iter().map(|shape| Traits::of(shape)).collect();
    let near = seen_from(heaviest, shapes, &traits).into_iter();
    let near = near.map(|neighbour| neighbour.exemplar);
    let is_new = |new: &usize| {
        members.contains(new) && !mix.contains_key(new) && goes_with(shapes, mix, *new)
    };
    near.filter(is_new).take(NEIGHBOURS).collect()
}

/// The exemplar of `mix` at `place`, 0 to 1, of its shares laid end to end.
fn picked(mix: &BTreeMap<usize, f64>, place: f64) -> usize {
    let mut left = place;
    let found = mix.iter().find(|(_, share)| {
        left -= *share;
        left < 0.0
    });
    let last = || mix.keys().next_back().copied().unwrap_or(0);
    found.map_or_else(last, |(&exemplar, _)| exemplar)
}

#[cfg(test)]
mod tests;
