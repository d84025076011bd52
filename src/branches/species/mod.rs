//! The species table: every number that makes an oak an oak. One file a group of species.
//!
//! Names say "like": these are characters for pictures, not botany. Leaves are a fifth larger
//! than in nature, as they are in games, so that they can be read at a distance.
//!
//! A species is a middle and a [`Spread`] around it; [`super::individual`] draws single trees.

mod broad;
mod conifers;
mod palms;
mod slender;
mod young;

use super::bark::Bark;
use super::crown::Crown;
use super::foliage::{Foliage, LeafTint};
use super::ornament::Ornament;
use super::palm::Palm;
use super::whorls::Whorls;

/// How a skeleton is made.
#[derive(Debug, Clone, Copy)]
pub enum Habit {
    /// By space colonisation of a lobed crown.
    Crown(Crown),
    /// By rule, in whorls.
    Whorls(Whorls),
    /// By rule, a bare stem under a head of fronds.
    Palm(Palm),
}

/// One species character.
#[derive(Debug, Clone, Copy)]
pub struct Species {
    /// Its name: lower-case letters.
    pub name: &'static str,
    /// Height in metres, of the envelope: a grown tree differs by a few per cent.
    pub height_m: f32,
    /// Radius of the stem above the flare in metres.
    pub stem_m: f32,
    /// Radius of the thinnest skeleton limbs in metres.
    pub tip_m: f32,
    /// Growth.
    pub habit: Habit,
    /// Bark.
    pub bark: Bark,
    /// Leaves.
    pub foliage: Foliage,
    /// What it looks like in the seasons; each is as frequent as it stands here.
    pub seasons: &'static [Season],
    /// How much individuals differ.
    pub spread: Spread,
    /// Chooses among the endless individuals those that come first.
    pub seed: u64,
}

/// The look of a species at a time of the year.
#[derive(Debug, Clone, Copy)]
pub struct Season {
    /// Colours of the leaves.
    pub tint: LeafTint,
    /// Factor on the number of leafy twigs.
    pub leaves: f32,
    /// Blossom or fruit.
    pub ornament: Option<Ornament>,
}

impl Season {
    /// Full foliage in these colours, nothing else.
    const fn plain(tint: LeafTint) -> Self {
        Self {
            tint,
            leaves: 1.0,
            ornament: None,
        }
    }
}

/// Ranges of what individuals differ in: factors on the species' numbers, low and high.
#[derive(Debug, Clone, Copy)]
pub struct Spread {
    /// Height, for young and for old trees; stems thicken and crowns part with it.
    pub height: (f32, f32),
    /// Width of the crown.
    pub breadth: (f32, f32),
    /// Height of the crown's lower edge.
    pub bare: (f32, f32),
    /// Number of leafy twigs.
    pub density: (f32, f32),
    /// Greatest lean, metres a metre of height.
    pub lean: f32,
}

/// The species, in the order they are shown; the first [`LIBRARY`] are those of the built-in
/// library.
static SPECIES: [Species; 15] = [
    broad::OAK,
    slender::BIRCH,
    slender::POPLAR,
    slender::WILLOW,
    broad::MAPLE,
    young::SAPLING,
    young::SHRUB,
    broad::APPLE,
    conifers::SPRUCE,
    conifers::PINE,
    conifers::CYPRESS,
    palms::PALM,
    broad::LINDEN,
    broad::ROBINIA,
    conifers::FIR,
];

/// How many species the built-in library shows.
pub const LIBRARY: usize = 12;

/// All species.
pub fn all_species() -> &'static [Species] {
    &SPECIES
}

/// The species of that name.
pub fn species_named(name: &str) -> Option<&'static Species> {
    SPECIES.iter().find(|species| species.name == name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_ranges_are_in_order() {
        for (index, species) in all_species().iter().enumerate() {
            let same = species_named(species.name).unwrap();
            assert!(std::ptr::eq(same, &all_species()[index]));
            assert!(species.name.bytes().all(|b| b.is_ascii_lowercase()));
            assert!(!species.seasons.is_empty());
            let spread = &species.spread;
            for (low, high) in [spread.height, spread.breadth, spread.bare, spread.density] {
                assert!(0.3 < low && low <= high && high < 2.0, "{}", species.name);
            }
        }
    }
}
