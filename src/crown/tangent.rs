//! k(i, j): how steeply the crown leaves its silhouette, everywhere along it (thesis §4.3.2 and
//! Fig. 4.14).
//!
//! k = 0 leaves the crown flat; about 2.1 makes a disc as thick as it is wide. A constant, a formula,
//! or a curve along the silhouette. In formulas i goes from 0 at the left edge of the crown's bounds
//! to 1 at the right one, j from 0 at the top to 1 at the bottom (edges, not centres, of the outermost
//! pixels).
//!
//! Departure: k must not be negative (the thesis asks for z ≥ 0; a negative k turns the surface inside
//! out at the silhouette). `max(0, …)` is what a formula needs to cross zero.

use super::domain::Domain;
use super::expression::{Expression, ExpressionError};
use super::profile::Profile;
use crate::geometry::Point;
use crate::raster::Rect;
use serde::{Deserialize, Serialize};

/// The largest k: beyond it a crown is a needle of hundreds of times its width.
const LARGEST: f64 = 1000.0;

/// A k for every place of a silhouette.
///
/// In files a number, a formula as text, or a [`Profile`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub enum Tangent {
    /// The same everywhere.
    Constant(f64),
    /// A formula in i and j.
    Expression(Expression),
    /// A curve along the silhouette.
    Profile(Profile),
}

/// As it stands in files.
#[derive(Clone, Serialize, Deserialize)]
#[serde(untagged)]
enum Written {
    Constant(f64),
    Expression(String),
    Profile(Profile),
}

/// A named formula.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Its formula.
    pub formula: &'static str,
    /// What it makes, in a few words.
    pub about: &'static str,
}

const fn preset(name: &'static str, formula: &'static str, about: &'static str) -> Preset {
    Preset {
        name,
        formula,
        about,
    }
}

/// Shapes to begin with; the constants and ramps are those of the thesis' Fig. 4.14.
pub const PRESETS: [Preset; 8] = [
    preset("round", "2.1", "as deep as wide: oaks, maples, shrubs"),
    preset("flat", "0.8", "a shallow crown: hedges, trees by a wall"),
    preset("full", "3.5", "deeper than wide"),
    preset("pear", "1+3*j", "deep below, thin above: conifers, poplars"),
    preset(
        "umbrella",
        "4-3*j",
        "deep above, thin below: pines, acacias",
    ),
    preset(
        "leaning",
        "3.5*(1-i)+0.5*i",
        "deep on the left, thin on the right",
    ),
    preset("waist", "1+2*abs(2*j-1)", "thinner in the middle"),
    preset("barrel", "1+2*sin(pi*j)", "deepest in the middle"),
];

/// Why there is no k.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TangentError {
    /// The formula cannot be read.
    #[error(transparent)]
    Expression(#[from] ExpressionError),
    /// A value that cannot be used.
    #[error("k is {k} at i = {i:.3}, j = {j:.3}; it must be a number from 0 to {LARGEST}{}", hint(*.k))]
    Value {
        /// The value.
        k: f64,
        /// Where, 0 … 1 from the left.
        i: f64,
        /// Where, 0 … 1 from the top.
        j: f64,
    },
    /// No preset of this name.
    #[error("there is no preset '{0}'")]
    Preset(String),
}

fn hint(k: f64) -> &'static str {
    if k < 0.0 {
        " (write max(0, …) around it)"
    } else {
        ""
    }
}

impl Tangent {
    /// Reads a number or a formula.
    ///
    /// # Errors
    /// [`TangentError::Expression`], with the column.
    pub fn parse(text: &str) -> Result<Self, TangentError> {
        match text.trim().parse::<f64>() {
            Ok(k) if text.trim().bytes().all(|b| b.is_ascii_digit() || b == b'.') => {
                Ok(Self::Constant(k))
            }
            _ => Ok(Self::Expression(Expression::parse(text)?)),
        }
    }

    /// One of [`PRESETS`].
    ///
    /// # Errors
    /// [`TangentError::Preset`].
    pub fn preset(name: &str) -> Result<Self, TangentError> {
        let found = PRESETS.iter().find(|preset| preset.name == name);
        let preset = found.ok_or_else(|| TangentError::Preset(name.to_owned()))?;
        Self::parse(preset.formula)
    }

    /// k for each pixel of the ring of `domain`.
    ///
    /// ```
    /// use boscage::crown::{Domain, Tangent};
    /// use boscage::raster::Image;
    /// let domain = Domain::new(&Image::filled(1, 1, true)).unwrap();
    /// let k = Tangent::parse("1+4*j").unwrap().on_ring(&domain).unwrap();
    /// assert_eq!(k, [1.0, 3.0, 3.0, 5.0]); // above, left, right, below
    /// ```
    ///
    /// # Errors
    /// [`TangentError::Value`] where k is negative, infinite or no number.
    pub fn on_ring(&self, domain: &Domain) -> Result<Vec<f64>, TangentError> {
        let places: Vec<Point> = domain.ring().iter().map(|pixel| pixel.position).collect();
        self.at(domain, &places)
    }

    /// k at `places` of the mask of `domain`, in mask pixels; those beyond the bounds have the k of
    /// the nearest point of the bounds.
    ///
    /// # Errors
    /// As [`Tangent::on_ring`].
    pub fn at(&self, domain: &Domain, places: &[Point]) -> Result<Vec<f64>, TangentError> {
        let bounds = domain.bounds();
        let values: Vec<f64> = match self {
            Self::Constant(k) => vec![*k; places.len()],
            Self::Profile(profile) => profile.values(domain, places),
            Self::Expression(formula) => {
                let value = |&place: &Point| {
                    let [i, j] = shares(bounds, place);
                    formula.value(i, j)
                };
                places.iter().map(value).collect()
            }
        };
        match values.iter().position(|k| !(0.0..=LARGEST).contains(k)) {
            None => Ok(values),
            Some(wrong) => {
                let [i, j] = shares(bounds, places[wrong]);
                Err(TangentError::Value {
                    k: values[wrong],
                    i,
                    j,
                })
            }
        }
    }
}

/// i and j of a place.
fn shares(bounds: Rect, place: Point) -> [f64; 2] {
    let share = |at: f64, first: u32, size: u32| {
        ((at - f64::from(first) + 0.5) / f64::from(size)).clamp(0.0, 1.0)
    };
    [
        share(place.x, bounds.x, bounds.width),
        share(place.y, bounds.y, bounds.height),
    ]
}

impl TryFrom<Written> for Tangent {
    type Error = TangentError;

    fn try_from(written: Written) -> Result<Self, TangentError> {
        Ok(match written {
            Written::Constant(k) => Self::Constant(k),
            Written::Expression(text) => Self::parse(&text)?,
            Written::Profile(profile) => Self::Profile(profile),
        })
    }
}

impl From<Tangent> for Written {
    fn from(tangent: Tangent) -> Self {
        match tangent {
            Tangent::Constant(k) => Self::Constant(k),
            Tangent::Expression(formula) => Self::Expression(formula.text().to_owned()),
            Tangent::Profile(profile) => Self::Profile(profile),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Image;

    fn square() -> Domain {
        Domain::new(&Image::filled(9, 9, true)).unwrap()
    }

    #[test]
    fn presets_are_formulas_that_can_be_used() {
        for preset in PRESETS {
            let k = Tangent::preset(preset.name)
                .unwrap()
                .on_ring(&square())
                .unwrap();
            assert!(k.iter().all(|&k| k > 0.0 && k < 10.0), "{}", preset.name);
        }
        assert!(Tangent::preset("oak").is_err());
    }

    #[test]
    fn values_that_cannot_be_used_are_refused_with_their_place() {
        let message = |text: &str| {
            let k = Tangent::parse(text).unwrap().on_ring(&square());
            k.unwrap_err().to_string()
        };
        assert!(message("j-0.5").contains("k is -0.5 at i = 0.056, j = 0.000"));
        assert!(message("j-0.5").contains("max(0, …)"));
        assert!(message("1/(1-j)").contains("k is inf at"));
        assert!(message("sqrt(0-1)").contains("NaN"));
        assert!(message("10^9").contains("from 0 to 1000"));
    }

    #[test]
    fn every_kind_goes_through_json() {
        let profile = Profile::new(vec![vec![[0.0, 1.0]]]).unwrap();
        let kinds = [
            (Tangent::Constant(2.5), "2.5"),
            (Tangent::parse("1+j").unwrap(), r#""1+j""#),
            (Tangent::Profile(profile), r#"{"components":[[[0.0,1.0]]]}"#),
        ];
        for (tangent, text) in kinds {
            assert_eq!(serde_json::to_string(&tangent).unwrap(), text);
            assert_eq!(serde_json::from_str::<Tangent>(text).unwrap(), tangent);
        }
        assert!(serde_json::from_str::<Tangent>(r#""1+""#).is_err());
    }
}
