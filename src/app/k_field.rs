//! k where the user sees it: along the silhouette and all over the crown.

use crate::crown::{Expression, Profile};
use crate::document::Tangent;
use crate::pipeline::Silhouette;

/// The k at which scales and curves end; more can be typed.
pub(super) const MOST_K: f64 = 6.0;

/// Handles that a formula becomes when the hand takes hold of it.
const HANDLES_OF_FORMULA: u32 = 12;

/// Handles that one k becomes.
const HANDLES_OF_CONSTANT: u32 = 4;

/// A k for every place.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum KField {
    /// The same everywhere.
    Constant(f64),
    /// By i and j.
    Formula(Expression),
    /// By the place along the silhouette.
    Profile(Profile),
}

impl KField {
    /// That of `tangent`; `automatic` is what was found where it leaves k open. Nothing of a formula
    /// that cannot be read.
    pub(super) fn of(tangent: &Tangent, automatic: Option<f64>) -> Option<Self> {
        match tangent {
            Tangent::Automatic => automatic.map(Self::Constant),
            Tangent::Expression(text) => {
                let text = text.trim();
                let formula = Expression::parse(text).ok()?;
                Some(match constant_of(text) {
                    Some(k) => Self::Constant(k),
                    None => Self::Formula(formula),
                })
            }
            Tangent::Profile(points) => {
                let points = points.iter().map(|&(t, k)| [t, k]).collect();
                Profile::new(vec![points]).ok().map(Self::Profile)
            }
        }
    }

    /// k at `t` of the silhouette, where i and j are these.
    pub(super) fn value(&self, t: f64, [i, j]: [f64; 2]) -> f64 {
        match self {
            Self::Constant(k) => *k,
            Self::Formula(formula) => formula.value(i, j),
            Self::Profile(profile) => profile.value(0, t),
        }
    }

    /// Handles along `silhouette` at which k is what it is here: (t, k), t ascending.
    pub(super) fn handles(&self, silhouette: &Silhouette) -> Vec<(f64, f64)> {
        let count = match self {
            Self::Constant(_) => HANDLES_OF_CONSTANT,
            Self::Formula(_) | Self::Profile(_) => HANDLES_OF_FORMULA,
        };
        let handle = |i: u32| {
            let t = f64::from(i) / f64::from(count);
            let at = silhouette.points.partition_point(|(at, _)| *at < t);
            let place = silhouette.points.get(at).or(silhouette.points.last());
            let shares = place.map_or([0.5; 2], |(_, place)| silhouette.shares(*place));
            let k = self.value(t, shares);
            (t, if k.is_finite() { k.max(0.0) } else { 0.0 })
        };
        (0..count).map(handle).collect()
    }
}

/// The number that the formula `text` is, if it is a number and nothing else.
pub(super) fn constant_of(text: &str) -> Option<f64> {
    let text = text.trim();
    let is_number = text
        .bytes()
        .all(|byte| byte.is_ascii_digit() || byte == b'.');
    text.parse().ok().filter(|_| is_number)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;

    fn square() -> Silhouette {
        let place = |x: f64, y: f64| Point::new(x, y);
        Silhouette {
            points: vec![
                (0.0, place(5.0, 10.0)),
                (0.25, place(10.0, 5.0)),
                (0.5, place(5.0, 0.0)),
                (0.75, place(0.0, 5.0)),
            ],
            bounds: [place(0.0, 0.0), place(10.0, 10.0)],
        }
    }

    #[test]
    fn handles_of_a_formula_have_its_values_where_they_stand() {
        let field = KField::of(&Tangent::Expression("1+3*j".into()), None).unwrap();
        let handles = field.handles(&square());
        assert_eq!(handles.len(), 12);
        assert_eq!(handles[0], (0.0, 4.0));
        assert_eq!(handles[6], (0.5, 1.0));
        assert_eq!(handles[3], (0.25, 2.5));
    }

    #[test]
    fn what_is_left_open_is_known_once_it_was_found() {
        assert_eq!(KField::of(&Tangent::Automatic, None), None);
        let found = KField::of(&Tangent::Automatic, Some(2.1)).unwrap();
        assert!(found.handles(&square()).iter().all(|&(_, k)| k == 2.1));
        assert_eq!(KField::of(&Tangent::Expression("1+".into()), None), None);
        let constant = KField::of(&Tangent::Expression(" 2.5 ".into()), None);
        assert_eq!(constant, Some(KField::Constant(2.5)));
    }
}
