//! The flags that put trees into a season.

use super::failure::Failure;
use crate::variation::{Season, SeasonChoice, SeasonSettings};
use clap::{Args, ValueEnum};

/// A season, its extent, snow, and which trees keep their leaves.
#[derive(Debug, Clone, Copy, Args)]
pub(super) struct SeasonFlags {
    /// Put all trees into a season; --like gives the colours of its leaves
    #[arg(long, value_enum, value_name = "SEASON")]
    season: Option<SeasonName>,
    /// How far the season has come: the share of leaves that have turned or fallen
    /// [default: 0.8 in autumn, 0.85 in spring and summer, 1 in winter]
    #[arg(long, value_name = "0..1")]
    season_amount: Option<f64>,
    /// How much of what faces the sky is under snow; alone: snow on trees as they are
    #[arg(long, default_value_t = 0.0, value_name = "0..1")]
    snow: f64,
    /// Which trees keep leaves and colours in all seasons
    #[arg(long, value_enum, default_value_t, value_name = "WHICH")]
    evergreen: Evergreen,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SeasonName {
    /// Young leaves
    Spring,
    /// Green leaves
    Summer,
    /// Turned leaves, in clumps, the top and the outside first
    Autumn,
    /// Bare limbs
    Winter,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum Evergreen {
    /// Conifers, palms and such, by the name of the picture or else by their looks
    #[default]
    Auto,
    /// All
    Yes,
    /// None
    No,
}

impl SeasonFlags {
    /// What was asked for, if anything.
    ///
    /// # Errors
    /// [`Failure::BadInput`] for numbers out of range, or an amount of no season.
    pub(super) fn checked(&self) -> Result<Option<SeasonChoice>, Failure> {
        let within = |name: &str, value: f64| match (0.0..=1.0).contains(&value) {
            true => Ok(()),
            false => Err(Failure::of(name, "must be from 0 to 1")),
        };
        within("--season-amount", self.season_amount.unwrap_or(0.0))?;
        within("--snow", self.snow)?;
        let season = match (self.season, self.season_amount) {
            (None, Some(_)) => return Err(Failure::of("--season-amount", "needs --season")),
            (None, None) if self.snow == 0.0 => return Ok(None),
            (None, None) => SeasonSettings {
                amount: 0.0,
                ..SeasonSettings::of(Season::Summer)
            },
            (Some(season), amount) => {
                let usual = SeasonSettings::of(season.season());
                SeasonSettings {
                    amount: amount.unwrap_or(usual.amount),
                    ..usual
                }
            }
        };
        Ok(Some(SeasonChoice {
            settings: SeasonSettings {
                snow: self.snow,
                ..season
            },
            evergreen: match self.evergreen {
                Evergreen::Auto => None,
                Evergreen::Yes => Some(true),
                Evergreen::No => Some(false),
            },
        }))
    }
}

impl SeasonName {
    fn season(self) -> Season {
        match self {
            Self::Spring => Season::Spring,
            Self::Summer => Season::Summer,
            Self::Autumn => Season::Autumn,
            Self::Winter => Season::Winter,
        }
    }
}
