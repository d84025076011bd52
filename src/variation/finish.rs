//! What becomes of a tree once it is mixed: another individual, other colours, another season.
//!
//! One description for batches, records and the studio, so that a tree is the same wherever it is made.

use super::{
    Chosen, Histogram, HslShift, Library, SeasonSettings, Tree, is_evergreen, make_individual,
    mirrored, named_evergreen, put_in_season,
};
use crate::base::{Cancel, Cancelled, Seed};
use crate::segment::Label;
use serde::{Deserialize, Serialize};

/// How a tree is made another individual.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct IndividualSettings {
    /// 0 to 1, see [`make_individual`].
    pub strength: f64,
    /// Whether it stands mirrored.
    pub mirrored: bool,
}

impl IndividualSettings {
    /// Least strength at which trees are mirrored.
    const LEAST_MIRRORED: f64 = 0.25;

    /// What becomes of the variation of a target with this seed; nothing without strength.
    pub fn drawn(strength: f64, seed: Seed) -> Option<Self> {
        let side = seed.derive("mirror", 0).random().unit();
        (strength > 0.0).then_some(Self {
            strength,
            mirrored: strength >= Self::LEAST_MIRRORED && side < 0.5,
        })
    }
}

/// The season that a tree is put into.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SeasonChoice {
    /// How it shows.
    pub settings: SeasonSettings,
    /// Whether the tree keeps its leaves; where it is not told, its looks decide.
    pub evergreen: Option<bool>,
}

impl SeasonChoice {
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
        let heavier = chosen.parts.iter().rev();
        let giver = heavier.max_by(|a, b| a.color_weight.total_cmp(&b.color_weight));
        let name = giver.map(|part| library.entries()[part.exemplar].file_name());
        name.map_or(self, |name| self.of_picture(&name))
    }
}

/// All that becomes of a tree. By default nothing.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Finish {
    /// How it is made another individual.
    pub individual: Option<IndividualSettings>,
    /// How its colours are moved, those of the trunk left out.
    pub shift: Option<HslShift>,
    /// The season that it is put into.
    pub season: Option<SeasonChoice>,
}

impl Finish {
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
        if let Some(individual) = &self.individual {
            if individual.mirrored {
                *tree = mirrored(tree);
            }
            make_individual(tree, individual.strength, seed, cancel)?;
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
            let evergreen = match season.evergreen {
                Some(evergreen) => evergreen,
                None => is_evergreen(tree, cancel)?,
            };
            put_in_season(tree, &season.settings, evergreen, like, seed, cancel)?;
        }
        Ok(())
    }
}
