//! Values that flags of `vary` take.

use crate::variation::Coloring;
use clap::ValueEnum;
use std::str::FromStr;

/// A range of weights, `0.3..0.7`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct WeightRange {
    pub(super) low: f64,
    pub(super) high: f64,
}

impl FromStr for WeightRange {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || "expected LOW..HIGH with 0 ≤ LOW ≤ HIGH ≤ 1, such as 0.3..0.7".to_owned();
        let (low, high) = text.split_once("..").unwrap_or((text, text));
        let number = |text: &str| text.trim().parse::<f64>().map_err(|_| form());
        let (low, high) = (number(low)?, number(high)?);
        if 0.0 <= low && low <= high && high <= 1.0 {
            Ok(Self { low, high })
        } else {
            Err(form())
        }
    }
}

/// Where a tree's colours come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum ColorsFlag {
    /// All from one of its exemplars, drawn at random: crisp leaves
    #[default]
    One,
    /// From all of its exemplars, averaged with the weights of the outline
    Blend,
}

impl ColorsFlag {
    pub(super) fn coloring(self) -> Coloring {
        match self {
            Self::One => Coloring::One,
            Self::Blend => Coloring::Blend,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_or_refused() {
        let range = |text: &str| text.parse::<WeightRange>();
        assert_eq!(
            range("0.3..0.7"),
            Ok(WeightRange {
                low: 0.3,
                high: 0.7
            })
        );
        assert_eq!(
            range("0.5"),
            Ok(WeightRange {
                low: 0.5,
                high: 0.5
            })
        );
        for bad in [
            "", "a..b", "0.7..0.3", "-1..0", "0..2", "NaN..1", "0.1..inf",
        ] {
            assert!(range(bad).is_err(), "{bad}");
        }
    }
}
