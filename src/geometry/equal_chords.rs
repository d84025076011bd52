//! Resampling a curve into points that are all equally far from their neighbours.
//!
//! *Idea.* Walking along a curve with a pair of dividers gives equal chords whatever the curve
//! does between two pricks, but the walk rarely ends exactly on the curve's end. For a ragged
//! outline the end even jumps as the opening of the dividers changes, so no opening may fit. We
//! therefore (1) choose the opening for which the walk from the start comes nearest to the wanted
//! number of steps, (2) tabulate for that opening how many steps (with a fraction) the walk needs
//! from *any* place of the curve to its end, and (3) walk from the start, opening the dividers up to
//! [`SLACK`] more or less where the table says that this brings the count to what it must be.
//!
//! *Source.* "Chord-length parameterisation, i.e. attempting to generate uniform chord lengths
//! between samples": Argudo, Andújar & Chica, *Tree Variations* (2017), §4.5. Equal arc lengths, the
//! usual reading, make chords of a ragged outline differ by more than 2 to 1.
//!
//! *Limits.* A curve whose end cannot be hit within the slack (a spiral of few steps, say) ends
//! with one chord that differs more.

use super::Point;

/// How much a chord may differ from the others, relative. 1 % is what we promise; below about
/// 0.3 % the outlines of sparse trees take too long to steer, or never get there.
const SLACK: f64 = 0.008;

/// Openings tried between the two extremes: the bracket shrinks to 2⁻⁴⁰ of its width.
const BISECTIONS: usize = 40;

/// Other openings tried on either side when the end is missed, and how far apart they are.
/// Together 6 %: beyond that the walk is more than a step off for all counts that matter.
const RETRIES: i32 = 24;
const RETRY_STEP: f64 = 0.0025;

/// Distance between two entries of the table of remaining steps, in chords.
const TABLE_STEP: f64 = 0.125;

/// `count` points along the open polyline `curve`: the first is its start, its end would be the
/// next, and all `count` chords, the one to the end included, are equal to 1 %.
///
/// A curve without length gives `count` times its start.
pub fn equal_chords(curve: &[Point], count: usize) -> Vec<Point> {
    let Some(curve) = Curve::new(curve) else {
        return vec![curve.first().copied().unwrap_or_default(); count];
    };
    let chord = curve.chord_for(count);
    // Where the end jumps over what steering can mend, a slightly other opening usually lands.
    let openings = (0..=RETRIES).flat_map(|i| [f64::from(i), -f64::from(i)]);
    let mut best = (f64::INFINITY, Vec::new());
    for i in openings {
        let points = curve.walk(chord * (1.0 + i * RETRY_STEP), count);
        let unevenness = curve.unevenness(&points);
        if unevenness < best.0 {
            best = (unevenness, points);
        }
        if best.0 <= SLACK * 1.1 {
            break;
        }
    }
    best.1
}

/// A polyline of positive length, measured along.
struct Curve {
    points: Vec<Point>,
    /// Arc length from the start to each point.
    lengths: Vec<f64>,
}

/// A place on a curve.
#[derive(Clone, Copy)]
struct Place {
    /// Index of the segment that holds it.
    segment: usize,
    /// Arc length from the start.
    length: f64,
    point: Point,
}

impl Curve {
    fn new(points: &[Point]) -> Option<Self> {
        let mut points = points.to_vec();
        points.dedup();
        let mut total = 0.0;
        let lengths: Vec<f64> = (0..points.len())
            .map(|i| {
                total += if i > 0 {
                    points[i].distance(points[i - 1])
                } else {
                    0.0
                };
                total
            })
            .collect();
        (total > 0.0).then_some(Self { points, lengths })
    }

    fn total(&self) -> f64 {
        self.lengths[self.lengths.len() - 1]
    }

    fn end(&self) -> Point {
        self.points[self.points.len() - 1]
    }

    fn start(&self) -> Place {
        Place {
            segment: 0,
            length: 0.0,
            point: self.points[0],
        }
    }

    /// The first place after `from` at distance `chord` from it; `None` when the rest of the curve
    /// stays nearer.
    fn step(&self, from: Place, chord: f64) -> Option<Place> {
        let outside = (from.segment + 1..self.points.len())
            .find(|&i| self.points[i].distance_squared(from.point) >= chord * chord)?;
        let segment = outside - 1;
        // The segment leaves the circle of radius `chord` once, between its inner start (or `from`
        // itself) and its outer end.
        let inner = if segment == from.segment {
            from.point
        } else {
            self.points[segment]
        };
        let along = self.points[outside] - inner;
        let offset = inner - from.point;
        let (a, b, c) = (
            along.length_squared(),
            offset.dot(along),
            offset.length_squared() - chord * chord,
        );
        let t = (-c / (b + (b * b - a * c).max(0.0).sqrt())).clamp(0.0, 1.0);
        let point = inner + along * t;
        Some(Place {
            segment,
            length: self.lengths[segment] + point.distance(self.points[segment]),
            point,
        })
    }

    /// Steps of a walk from the start to the end, the last one as a fraction; stops counting at
    /// `enough`.
    fn steps(&self, chord: f64, enough: usize) -> f64 {
        let mut place = self.start();
        for done in 0..enough {
            match self.step(place, chord) {
                Some(next) => place = next,
                None => return done as f64 + place.point.distance(self.end()) / chord,
            }
        }
        enough as f64
    }

    /// `count` places from the start, about `chord` apart, steered to the end.
    fn walk(&self, chord: f64, count: usize) -> Vec<Point> {
        let table = StepsToEnd::new(self, chord);
        let mut points = Vec::with_capacity(count);
        let mut place = self.start();
        for done in 0..count {
            points.push(place.point);
            place = table.steered_step(place, (count - done - 1) as f64);
        }
        points
    }

    /// Largest relative deviation of a chord from the mean chord, the one to the end included.
    fn unevenness(&self, points: &[Point]) -> f64 {
        let nexts = points[1..].iter().copied().chain([self.end()]);
        let chords: Vec<f64> = points
            .iter()
            .zip(nexts)
            .map(|(a, b)| a.distance(b))
            .collect();
        let mean = chords.iter().sum::<f64>() / chords.len() as f64;
        chords
            .iter()
            .map(|c| (c / mean - 1.0).abs())
            .fold(0.0, f64::max)
    }

    /// The opening for which a walk takes `count` steps, or comes nearest to it from above.
    fn chord_for(&self, count: usize) -> f64 {
        let mut high = self.total() / count as f64;
        let mut low = high / 2.0;
        while self.steps(low, count + 1) < count as f64 && low > high * 1e-6 {
            high = low;
            low /= 2.0;
        }
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if self.steps(middle, count + 1) < count as f64 {
                high = middle;
            } else {
                low = middle;
            }
        }
        low
    }

    /// The place at arc length `length`, which lies on segment `segment` or a later one.
    fn place_at(&self, length: f64, segment: usize) -> Place {
        let last = self.points.len() - 2;
        let segment = (segment..last)
            .find(|&i| self.lengths[i + 1] >= length)
            .unwrap_or(last);
        let span = self.lengths[segment + 1] - self.lengths[segment];
        let t = ((length - self.lengths[segment]) / span).clamp(0.0, 1.0);
        Place {
            segment,
            length,
            point: self.points[segment].lerp(self.points[segment + 1], t),
        }
    }
}

/// For one opening: how many steps a walk needs from any place to the end.
struct StepsToEnd<'a> {
    curve: &'a Curve,
    chord: f64,
    spacing: f64,
    /// Entry i: steps from arc length i · spacing.
    steps: Vec<f64>,
}

impl<'a> StepsToEnd<'a> {
    fn new(curve: &'a Curve, chord: f64) -> Self {
        let spacing = chord * TABLE_STEP;
        let entries = (curve.total() / spacing) as usize + 2;
        let mut segment = 0;
        let places: Vec<Place> = (0..entries)
            .map(|i| {
                let place = curve.place_at((i as f64 * spacing).min(curve.total()), segment);
                segment = place.segment;
                place
            })
            .collect();
        let mut table = Self {
            curve,
            chord,
            spacing,
            steps: vec![0.0; entries],
        };
        // From the end backwards: each entry needs only later ones.
        for i in (0..entries).rev() {
            table.steps[i] = match curve.step(places[i], chord) {
                Some(next) => 1.0 + table.at(next.length),
                None => places[i].point.distance(curve.end()) / chord,
            };
        }
        table
    }

    /// Steps from arc length `length`, interpolated.
    fn at(&self, length: f64) -> f64 {
        let position = length / self.spacing;
        let index = (position as usize).min(self.steps.len() - 2);
        let t = (position - index as f64).clamp(0.0, 1.0);
        self.steps[index] * (1.0 - t) + self.steps[index + 1] * t
    }

    /// One step from `from` whose opening, within the slack, leaves as nearly as possible `wanted`
    /// steps.
    fn steered_step(&self, from: Place, wanted: f64) -> Place {
        const TRIES: i32 = 8;
        let end = Place {
            segment: self.curve.points.len() - 2,
            length: self.curve.total(),
            point: self.curve.end(),
        };
        // The unchanged opening comes first, so that ties keep it.
        let openings = (0..=TRIES)
            .flat_map(|i| [i, -i])
            .map(|i| self.chord * (1.0 + SLACK * f64::from(i) / f64::from(TRIES)));
        let mut best = (f64::INFINITY, end);
        for opening in openings {
            let place = self.curve.step(from, opening).unwrap_or(end);
            let error = (self.at(place.length) - wanted).abs();
            if error < best.0 - 1e-9 {
                best = (error, place);
            }
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    #[test]
    fn a_straight_line_is_cut_evenly() {
        let line = [Point::ZERO, Point::new(3.0, 0.0), Point::new(10.0, 0.0)];
        let points = equal_chords(&line, 5);
        for (i, point) in points.iter().enumerate() {
            assert!((point.x - 2.0 * i as f64).abs() < 1e-6, "{points:?}");
        }
    }

    #[test]
    fn ragged_pixel_paths_have_equal_chords() {
        for seed in 0..20 {
            let mut random = Seed(seed).random();
            let mut curve = vec![Point::ZERO];
            while curve.len() < 4000 {
                let last = curve[curve.len() - 1];
                let (dx, dy) = (random.below(6) as f64 - 1.0, random.below(3) as f64 - 1.0);
                curve.push(last + Point::new(dx.min(1.0), dy));
            }
            for count in [800, 1600] {
                let points = equal_chords(&curve, count);
                assert_eq!(points.len(), count);
                assert_eq!(points[0], Point::ZERO);
                let deviation = Curve::new(&curve).unwrap().unevenness(&points);
                assert!(deviation < 0.01, "seed {seed}, {count}: {deviation}");
            }
        }
    }

    #[test]
    fn a_curve_without_length_repeats_its_point() {
        let p = Point::new(3.0, 4.0);
        assert_eq!(equal_chords(&[p, p], 3), vec![p; 3]);
        assert_eq!(equal_chords(&[], 2), vec![Point::ZERO; 2]);
    }
}
