//! k as a curve along the silhouette: what an artist drags.
//!
//! Each border of the mask is walked once, counter-clockwise as seen on screen, from its lowest
//! pixel (the middle one of several); t goes from 0 to 1 with the length of the way. Between the
//! points of a profile k follows a periodic cubic that never overshoots: Fritsch & Carlson, *Monotone
//! piecewise cubic interpolation*, 1980 (slopes by the harmonic mean of Fritsch & Butland, 1984).
//!
//! Limits: both sides of a line one pixel wide, and pixels that touch two borders, have one k.

use super::domain::Domain;
use crate::contour::outlines;
use crate::geometry::{Point, signed_area};
use crate::raster::{Image, Mask, labelled_components};
use serde::{Deserialize, Serialize};

/// Values of k along the silhouette of each component of a mask.
///
/// In JSON `{"components":[[[t,k],…],…]}`, the components in the order of their first pixel from the
/// top; the last list serves all further ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct Profile {
    components: Vec<Curve>,
}

/// As it stands in files.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    components: Vec<Vec<[f64; 2]>>,
}

/// Why a profile cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProfileError {
    /// No component, or one without points.
    #[error("a profile needs at least one point [t, k] for each component")]
    Empty,
    /// A point out of range.
    #[error("point {index} is [{t}, {k}]: t must lie from 0 to 1 and k must be a number from 0 up")]
    Point {
        /// Which, from 0.
        index: usize,
        /// Where on the silhouette.
        t: f64,
        /// The value.
        k: f64,
    },
    /// Two points at one place.
    #[error("two points have t = {t} (0 and 1 are the same place)")]
    SamePlace {
        /// Where.
        t: f64,
    },
}

impl Profile {
    /// A profile from lists of (t, k), one a component; the points need no order.
    ///
    /// ```
    /// use boscage::crown::Profile;
    /// let profile = Profile::new(vec![vec![[0.0, 4.0], [0.5, 1.0]]]).unwrap();
    /// assert_eq!(profile.value(7, 0.5), 1.0);
    /// assert_eq!(profile.value(0, 0.25), 2.5);
    /// ```
    ///
    /// # Errors
    /// [`ProfileError`].
    pub fn new(components: Vec<Vec<[f64; 2]>>) -> Result<Self, ProfileError> {
        if components.is_empty() {
            return Err(ProfileError::Empty);
        }
        let curves: Result<_, _> = components.into_iter().map(Curve::new).collect();
        Ok(Self {
            components: curves?,
        })
    }

    /// k at `t` of the border of component number `component`, from 0.
    pub fn value(&self, component: usize, t: f64) -> f64 {
        self.components[component.min(self.components.len() - 1)].value(t)
    }

    /// k for each of `places` (in mask pixels) from the nearest pixel of a border.
    pub(super) fn values(&self, domain: &Domain, places: &[Point]) -> Vec<f64> {
        let borders = k_of_borders(self, domain);
        places
            .iter()
            .map(|&place| nearest(&borders, place))
            .collect()
    }
}

impl TryFrom<Written> for Profile {
    type Error = ProfileError;

    fn try_from(written: Written) -> Result<Self, ProfileError> {
        Self::new(written.components)
    }
}

impl From<Profile> for Written {
    fn from(profile: Profile) -> Self {
        let points = |curve: Curve| curve.points.iter().map(|p| [p.t, p.k]).collect();
        Self {
            components: profile.components.into_iter().map(points).collect(),
        }
    }
}

/// A periodic curve.
#[derive(Debug, Clone, PartialEq)]
struct Curve {
    /// In the order of t.
    points: Vec<Knot>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    t: f64,
    k: f64,
    /// Change of k per t.
    slope: f64,
}

impl Curve {
    fn new(mut points: Vec<[f64; 2]>) -> Result<Self, ProfileError> {
        if points.is_empty() {
            return Err(ProfileError::Empty);
        }
        for (index, &[t, k]) in points.iter().enumerate() {
            if !((0.0..=1.0).contains(&t) && k >= 0.0 && k.is_finite()) {
                return Err(ProfileError::Point { index, t, k });
            }
        }
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        let round = (points[0][0] + 1.0, points[points.len() - 1][0]);
        if points.len() > 1 && round.0 == round.1 {
            return Err(ProfileError::SamePlace { t: 0.0 });
        }
        if let Some(pair) = points.windows(2).find(|pair| pair[0][0] == pair[1][0]) {
            return Err(ProfileError::SamePlace { t: pair[0][0] });
        }
        let knots = (0..points.len()).map(|i| Knot {
            t: points[i][0],
            k: points[i][1],
            slope: slope(&points, i),
        });
        Ok(Self {
            points: knots.collect(),
        })
    }

    fn value(&self, t: f64) -> f64 {
        let t = t - t.floor();
        let behind = self.points.partition_point(|knot| knot.t <= t);
        let count = self.points.len();
        let mut left = self.points[(behind + count - 1) % count];
        let mut right = self.points[behind % count];
        if behind == 0 {
            left.t -= 1.0;
        }
        if behind == count {
            right.t += 1.0;
        }
        let width = right.t - left.t;
        let s = (t - left.t) / width;
        let (s2, s3) = (s * s, s * s * s);
        left.k * (2.0 * s3 - 3.0 * s2 + 1.0)
            + width * left.slope * (s3 - 2.0 * s2 + s)
            + right.k * (3.0 * s2 - 2.0 * s3)
            + width * right.slope * (s3 - s2)
    }
}

/// The slope at point `i` of a periodic curve: 0 at extremes, else the weighted harmonic mean of the
/// slopes on both sides.
fn slope(points: &[[f64; 2]], i: usize) -> f64 {
    let count = points.len();
    if count == 1 {
        return 0.0;
    }
    let ([t, k], [mut t0, k0], [mut t1, k1]) = (
        points[i],
        points[(i + count - 1) % count],
        points[(i + 1) % count],
    );
    if i == 0 {
        t0 -= 1.0;
    }
    if i + 1 == count {
        t1 += 1.0;
    }
    let (before, behind) = (t - t0, t1 - t);
    let (left, right) = ((k - k0) / before, (k1 - k) / behind);
    if left * right <= 0.0 {
        return 0.0;
    }
    let (a, b) = (2.0 * behind + before, behind + 2.0 * before);
    (a + b) / (a / left + b / right)
}

/// k at each pixel of a border.
fn k_of_borders(profile: &Profile, domain: &Domain) -> Image<Option<f64>> {
    let mask = domain.mask();
    let components = labelled_components(mask);
    let mut borders = Image::filled(mask.width(), mask.height(), None);
    for outline in outlines(mask).all {
        let points = outline.points;
        let first = points[0];
        let component = components.at(first.x as u32, first.y as u32) as usize - 1;
        for (t, point) in walk(points) {
            let (x, y) = (point.x as u32, point.y as u32);
            if borders.at(x, y).is_none() {
                borders.set(x, y, Some(profile.value(component, t)));
            }
        }
    }
    borders
}

/// The places that t stands for on the longest border of `mask`: each of its pixels with its t,
/// ascending from 0.
///
/// ```
/// use boscage::{crown::silhouette, raster::Image};
/// let walk = silhouette(&Image::filled(5, 5, true));
/// assert_eq!((walk.len(), walk[0].0), (16, 0.0));
/// assert_eq!((walk[0].1.x, walk[0].1.y), (2.0, 4.0));
/// assert_eq!((walk[4].0, walk[4].1.x, walk[4].1.y), (0.25, 4.0, 2.0));
/// ```
pub fn silhouette(mask: &Mask) -> Vec<(f64, Point)> {
    let all = outlines(mask).all.into_iter();
    let longest = all.rev().max_by_key(|outline| outline.points.len());
    longest.map_or(Vec::new(), |outline| walk(outline.points))
}

/// The pixels of a border in the order of t, each with its t.
fn walk(mut points: Vec<Point>) -> Vec<(f64, Point)> {
    if signed_area(&points) < 0.0 {
        points.reverse();
    }
    let start = lowest(&points);
    points.rotate_left(start);
    let step = |i: usize| points[i].distance(points[(i + 1) % points.len()]);
    let length: f64 = (0..points.len()).map(step).sum();
    let mut passed = 0.0;
    let place = |(i, &point): (usize, &Point)| {
        let t = if length > 0.0 { passed / length } else { 0.0 };
        passed += step(i);
        (t, point)
    };
    points.iter().enumerate().map(place).collect()
}

/// The index of the lowest point, the middle one of several.
fn lowest(points: &[Point]) -> usize {
    let bottom = points.iter().fold(f64::NEG_INFINITY, |low, p| low.max(p.y));
    let all: Vec<usize> = (0..points.len())
        .filter(|&i| points[i].y == bottom)
        .collect();
    all[all.len() / 2]
}

/// The value of the pixel nearest to `place` that has one, the first by rows of several.
pub(super) fn nearest(borders: &Image<Option<f64>>, place: Point) -> f64 {
    let reach = borders.width().max(borders.height()) as i64;
    let (x, y) = (libm::rint(place.x) as i64, libm::rint(place.y) as i64);
    let mut best: Option<(f64, f64)> = None;
    for ring in 0..=reach {
        // Pixels of a later ring are farther than this.
        if best.is_some_and(|(distance, _)| distance.sqrt() < ring as f64 - 0.5) {
            break;
        }
        for dy in -ring..=ring {
            let step = if dy.abs() == ring {
                1
            } else {
                (2 * ring).max(1)
            };
            for dx in (-ring..=ring).step_by(step as usize) {
                let Some(Some(k)) = borders.get(x + dx, y + dy) else {
                    continue;
                };
                let pixel = Point::new((x + dx) as f64, (y + dy) as f64);
                let distance = pixel.distance_squared(place);
                if best.is_none_or(|(least, _)| distance < least) {
                    best = Some((distance, k));
                }
            }
        }
    }
    best.map_or(0.0, |(_, k)| k)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_passes_its_points_and_overshoots_nowhere() {
        let points = vec![[0.9, 1.0], [0.1, 3.0], [0.2, 3.0], [0.5, 0.0]];
        let curve = Curve::new(points.clone()).unwrap();
        for [t, k] in points {
            assert!((curve.value(t) - k).abs() < 1e-12);
            assert!((curve.value(t + 1.0) - k).abs() < 1e-12);
        }
        for step in 0..1000 {
            let k = curve.value(f64::from(step) / 1000.0);
            assert!((-1e-12..=3.0 + 1e-12).contains(&k));
        }
        assert!((curve.value(1.0 - 1e-9) - curve.value(1e-9)).abs() < 1e-6);
        assert_eq!(Curve::new(vec![[0.3, 2.0]]).unwrap().value(0.9), 2.0);
    }

    #[test]
    fn bad_profiles_are_refused_with_the_reason() {
        let refused = |points: Vec<[f64; 2]>| Profile::new(vec![points]).unwrap_err();
        assert_eq!(refused(vec![]), ProfileError::Empty);
        assert!(matches!(
            refused(vec![[0.0, 1.0], [1.5, 1.0]]),
            ProfileError::Point { index: 1, .. }
        ));
        assert!(matches!(
            refused(vec![[0.0, -1.0]]),
            ProfileError::Point { .. }
        ));
        assert!(matches!(
            refused(vec![[0.0, 1.0], [1.0, 1.0]]),
            ProfileError::SamePlace { .. }
        ));
        assert!(serde_json::from_str::<Profile>(r#"{"components":[]}"#).is_err());
        let good = Profile::new(vec![vec![[0.25, 2.0], [0.5, 1.0]]]).unwrap();
        let text = serde_json::to_string(&good).unwrap();
        assert_eq!(serde_json::from_str::<Profile>(&text).unwrap(), good);
    }

    #[test]
    fn t_begins_at_the_bottom_and_runs_counter_clockwise_on_screen() {
        let domain = Domain::new(&Image::filled(41, 41, true)).unwrap();
        let points = vec![[0.0, 1.0], [0.25, 2.0], [0.5, 3.0], [0.75, 4.0]];
        let profile = Profile::new(vec![points]).unwrap();
        // Bottom, right, top, left.
        let places = [(20.0, 40.5), (40.5, 20.0), (20.0, -0.5), (-0.5, 20.0)];
        let k = profile.values(&domain, &places.map(|(x, y)| Point::new(x, y)));
        for (found, expected) in k.iter().zip([1.0, 2.0, 3.0, 4.0]) {
            assert!((found - expected).abs() < 0.05, "{k:?}");
        }
    }
}
