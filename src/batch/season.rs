//! Seasons in jobs: what was asked for, and what becomes of each tree.

use super::records::SeasonRecord;
use crate::base::{Cancel, Cancelled, Seed};
use crate::variation::{
    Chosen, Histogram, Library, SeasonSettings, Tree, is_evergreen, named_evergreen, put_in_season,
};

/// The season of a job.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SeasonJob {
    pub(crate) settings: SeasonSettings,
    /// Whether trees keep their leaves; else their names and looks decide.
    pub(crate) evergreen: Option<bool>,
}

impl SeasonJob {
    /// What is recorded of the tree `chosen`: it is evergreen if the exemplar of most of its colours is
    /// by its name.
    pub(crate) fn record(&self, chosen: &Chosen, library: &Library<'_>) -> SeasonRecord {
        let heavier = chosen.parts.iter().rev();
        let giver = heavier.max_by(|a, b| a.color_weight.total_cmp(&b.color_weight));
        let name = giver.map(|part| library.entries()[part.exemplar].file_name());
        let named = || name.and_then(|name| named_evergreen(&name));
        SeasonRecord {
            settings: self.settings,
            evergreen: self.evergreen.or_else(named),
        }
    }

    /// What is recorded of the picture `name`.
    pub(crate) fn record_of(&self, name: &str) -> SeasonRecord {
        SeasonRecord {
            settings: self.settings,
            evergreen: self.evergreen.or_else(|| named_evergreen(name)),
        }
    }
}

impl SeasonRecord {
    /// Puts `tree` into the season, with the leaves' colours of `like` if given.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub(crate) fn put(
        &self,
        tree: &mut Tree,
        like: Option<&Histogram>,
        seed: Seed,
        cancel: &Cancel,
    ) -> Result<(), Cancelled> {
        let evergreen = match self.evergreen {
            Some(evergreen) => evergreen,
            None => is_evergreen(tree, cancel)?,
        };
        put_in_season(tree, &self.settings, evergreen, like, seed, cancel)
    }
}
