//! Single trees: a species and a number name one, and always the same one.
//!
//! Traits (age, breadth, bare stem, …) are drawn so that few trees already show what a species can
//! be: every three consecutive individuals form a Latin square (McKay, Beckman & Conover, *A
//! Comparison of Three Methods for Selecting Values of Input Variables*, 1979), one in the lower,
//! one in the middle and one in the upper third of each trait, in an order that differs from trait
//! to trait.

use super::light::Daylight;
use super::species::{Habit, Season, Species};
use crate::base::Seed;
use glam::Vec2;

/// How single trees differ, each in 0..1: low to high in the species'
/// [`Spread`](super::species::Spread).
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Traits {
    /// Young and small to old and tall.
    pub age: f32,
    /// Narrow to broad.
    pub breadth: f32,
    /// Branched low to bare.
    pub bare: f32,
    /// Leaning left to leaning right.
    pub lean: f32,
    /// Leaning towards the viewer to leaning away.
    pub lean_away: f32,
    /// Sparse to dense.
    pub density: f32,
    /// First to last of the species' seasons.
    pub season: f32,
    /// Colder to warmer leaves.
    pub warmth: f32,
    /// Paler to deeper colour.
    pub depth: f32,
    /// Clear to overcast sky.
    pub softness: f32,
    /// Sun far to the left to sun nearly in front.
    pub azimuth: f32,
    /// Low to high sun.
    pub elevation: f32,
}

impl Traits {
    /// The traits of individual `index`, from 1.
    fn new(seed: Seed, index: u32) -> Self {
        let of = |name| third(seed, name, index);
        Self {
            age: of("age"),
            breadth: of("breadth"),
            bare: of("bare"),
            lean: of("lean"),
            lean_away: of("lean away"),
            density: of("density"),
            season: of("season"),
            warmth: of("warmth"),
            depth: of("depth"),
            softness: of("softness"),
            azimuth: of("azimuth"),
            elevation: of("elevation"),
        }
    }
}

/// A number in 0..1, in another third for each of three consecutive individuals.
fn third(seed: Seed, name: &str, index: u32) -> f32 {
    let place = index.saturating_sub(1);
    let mut random = seed.derive(name, u64::from(place / 3)).random();
    let order = random.choose(3, 3);
    let draws = [random.unit(), random.unit(), random.unit()];
    let slot = (place % 3) as usize;
    ((order[slot] as f64 + draws[slot]) / 3.0) as f32
}

/// One tree to be: its species' numbers, changed by its traits.
#[derive(Debug, Clone)]
pub struct Individual {
    pub(super) species: Species,
    pub(super) season: Season,
    pub(super) stance: Stance,
    pub(super) daylight: Daylight,
    pub(super) seed: Seed,
    traits: Traits,
    index: u32,
}

/// What the habits need to know of a single tree beside the species' numbers.
#[derive(Debug, Clone, Copy)]
pub struct Stance {
    /// Height in metres.
    pub height_m: f32,
    /// Factor on the width of the outline.
    pub breadth: f32,
    /// Displacement of the top in x and z, metres a metre of height.
    pub lean: Vec2,
    /// 0 young … 1 old.
    pub age: f32,
}

impl Individual {
    /// Individual `index` (from 1) of `species`.
    pub fn new(species: &Species, index: u32) -> Self {
        let seed = Seed(species.seed).derive(species.name, 0);
        let traits = Traits::new(seed, index);
        let spread = &species.spread;
        let height = within(spread.height, traits.age);
        let count = species.seasons.len();
        let season = ((traits.season * count as f32) as usize).min(count - 1);
        let mut own = *species;
        own.height_m *= height;
        // Stems thicken faster than they grow: a young tree is slender.
        own.stem_m *= height * height.sqrt();
        let bare = within(spread.bare, traits.bare);
        match &mut own.habit {
            Habit::Crown(crown) => {
                crown.base *= bare;
                crown.spacing_m *= 0.4 + 0.6 * height;
                crown.crook *= 0.75 + 0.5 * traits.age;
            }
            Habit::Whorls(whorls) => whorls.base *= bare,
            Habit::Palm(_) => {}
        }
        own.foliage.twigs *= within(spread.density, traits.density);
        let mut season = species.seasons[season];
        own.foliage.twigs *= season.leaves;
        season.tint = season.tint.changed(traits.warmth, traits.depth);
        let lean = Vec2::new(traits.lean, traits.lean_away) * 2.0 - Vec2::ONE;
        Self {
            season,
            stance: Stance {
                height_m: own.height_m,
                breadth: within(spread.breadth, traits.breadth),
                lean: lean * spread.lean,
                age: traits.age,
            },
            daylight: Daylight::new(
                within((-62.0, -12.0), traits.azimuth),
                within((44.0, 62.0), traits.elevation),
                within((0.0, 0.55), traits.softness),
            ),
            seed: seed.derive("individual", u64::from(index)),
            species: own,
            traits,
            index,
        }
    }

    /// Species and number, as in names of files: `oak_01`.
    pub fn name(&self) -> String {
        format!("{}_{:02}", self.species.name, self.index)
    }

    /// Its traits.
    pub fn traits(&self) -> &Traits {
        &self.traits
    }

    /// Name of the species.
    pub fn species_name(&self) -> &'static str {
        self.species.name
    }
}

/// `low` at 0, `high` at 1.
fn within((low, high): (f32, f32), share: f32) -> f32 {
    low + (high - low) * share
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::branches::species::all_species;

    #[test]
    fn three_individuals_span_every_trait() {
        for first in [1, 4, 31] {
            for name in ["age", "lean"] {
                let mut thirds: Vec<u32> = (first..first + 3)
                    .map(|index| (third(Seed(3), name, index) * 3.0) as u32)
                    .collect();
                thirds.sort_unstable();
                assert_eq!(thirds, [0, 1, 2], "{name} from {first}");
            }
        }
    }

    #[test]
    fn an_individual_is_named_by_species_and_number_alone() {
        for species in all_species() {
            let one = Individual::new(species, 7);
            assert_eq!(one.name(), format!("{}_07", species.name));
            assert_eq!(one.traits(), Individual::new(species, 7).traits());
            assert_ne!(one.seed, Individual::new(species, 8).seed);
        }
    }
}
