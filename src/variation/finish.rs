//! What becomes of a tree once it is mixed: another individual, other colours, another season.
//!
//! One description for batches, records and the studio, so that a tree is the same wherever it is made.

use super::choice::giver;
use super::{
    Chosen, Histogram, HslShift, IndividualSettings, Library, Part, SeasonSettings, Tree,
    has_fronds, make_individual, named_evergreen, put_in_season, reshape,
};
use crate::base::{Cancel, Cancelled, Seed};
use crate::segment::Label;
use serde::{Deserialize, Serialize};

/// The season that a tree is put into.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeasonChoice {
    /// How it shows.
    pub settings: SeasonSettings,
    /// Whether the tree keeps its leaves; where it is not told, its looks decide.
    pub evergreen: Option<bool>,
}

impl SeasonChoice {
    /// Whether all numbers are in their ranges.
    pub fn is_sound(&self) -> bool {
        let numbers = [self.settings.amount, self.settings.snow];
        numbers.iter().all(|value| (0.0..=1.0).contains(value))
    }

    /// The choice for the picture `name`: where nothing was told, its name decides if it can.
    #[must_use]
    pub fn of_picture(self, name: &str) -> Self {
        Self {
            evergreen: self.evergreen.or_else(|| named_evergreen(name)),
            ..self
        }
    }

    /// The choice for the tree `chosen`: it is evergreen, if nothing was told, when the exemplar of
    /// most of its colours is by its name.
    #[must_use]
    pub fn of_tree(self, chosen: &Chosen, library: &Library<'_>) -> Self {
        let told = || evergreen_by_name(&chosen.parts, library);
        Self {
            evergreen: self.evergreen.or_else(told),
            ..self
        }
    }
}

/// Whether a tree of these parts keeps its leaves by the name of the exemplar that gives most of its colours.
pub fn evergreen_by_name(parts: &[Part], library: &Library<'_>) -> Option<bool> {
    let giver = giver(parts, |part| part.color_weight)?;
    named_evergreen(&library.entries()[giver.exemplar].file_name())
}

/// How the outline of a crown is moved, its stem left as it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Reshaping {
    /// 0 (as it is) to 1: limbs, lobes and bays move by about an eighth of the crown.
    pub strength: f64,
    /// Where the moves are drawn from.
    pub seed: u64,
}

impl Reshaping {
    /// How much of the strength asked for is taken: trees of one mix differ in that, too.
    const SHARE: (f64, f64) = (0.5, 1.0);

    /// What becomes of the outline of a mix with this seed; nothing without strength.
    pub fn drawn(strength: f64, seed: Seed) -> Option<Self> {
        let mut random = seed.derive("reshaped", 0).random();
        let share = random.between(Self::SHARE.0, Self::SHARE.1);
        (strength > 0.0).then(|| Self {
            strength: share * strength,
            seed: random.bits(),
        })
    }
}

/// All that becomes of a tree. By default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Finish {
    /// Whether its crown is of fronds about one heart, as that of a palm.
    #[serde(default)]
    pub has_fronds: bool,
    /// How its outline is moved.
    #[serde(default)]
    pub reshaping: Option<Reshaping>,
    /// How it is made another individual.
    pub individual: Option<IndividualSettings>,
    /// How its colours are moved, those of the trunk left out.
    pub shift: Option<HslShift>,
    /// The season that it is put into.
    pub season: Option<SeasonChoice>,
}

impl Finish {
    /// All that for the tree `chosen`: what the names of its pictures tell is known.
    #[must_use]
    pub fn of_tree(self, chosen: &Chosen, library: &Library<'_>) -> Self {
        let giver = chosen.giver(|part| part.contour_weight);
        let name = giver.map(|part| library.entries()[part.exemplar].file_name());
        Self {
            has_fronds: name.is_some_and(|name| has_fronds(&name)),
            season: self.season.map(|season| season.of_tree(chosen, library)),
            ..self
        }
    }

    /// Whether all numbers are in their ranges.
    pub fn is_sound(&self) -> bool {
        let strengths = [
            self.reshaping.map_or(0.0, |own| own.strength),
            self.individual.map_or(0.0, |own| own.strength),
        ];
        let shift_is_sound = self.shift.is_none_or(|shift| {
            let factors = [shift.saturation, shift.lightness];
            shift.hue.abs() <= 1.0 && factors.iter().all(|factor| (0.0..=4.0).contains(factor))
        });
        strengths.iter().all(|value| (0.0..=1.0).contains(value))
            && shift_is_sound
            && self.season.is_none_or(|season| season.is_sound())
    }

    /// Does all that to `tree`. What is random in it comes from `seed`; `like` gives the colours of
    /// a season's leaves.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn put(
        &self,
        tree: &mut Tree,
        like: Option<&Histogram>,
        seed: Seed,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        if let Some(reshaping) = &self.reshaping {
            reshape(tree, reshaping, self.has_fronds, cancel)?;
        }
        if let Some(individual) = &self.individual {
            make_individual(tree, individual, self.has_fronds, seed, cancel)?;
        }
        if let Some(shift) = &self.shift {
            let pixels = tree.image.pixels_mut().iter_mut();
            for (pixel, label) in pixels.zip(tree.labels.pixels()) {
                if *label != Label::Trunk {
                    *pixel = shift.applied(*pixel);
                }
            }
        }
        if let Some(season) = &self.season {
            let evergreen = season.evergreen;
            put_in_season(tree, &season.settings, evergreen, like, seed, cancel)?;
        }
        Ok(())
    }
}
