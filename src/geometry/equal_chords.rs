//! Resampling a curve into points that are all equally far from their neighbours.
//!
//! *Idea.* Walking along a curve with a pair of dividers gives equal chords whatever the curve
//! does between two pricks, but the walk rarely ends exactly on the curve's end. For a ragged
//! outline the end even jumps as the opening of the dividers changes, so no opening may fit. We
//! therefore (1) choose the opening for which the walk from the start comes nearest to the wanted
//! number of steps, (2) tabulate for that opening how many steps (with a fraction) the walk needs
//! from *any* place of the curve to its end, (3) walk from the start, opening the dividers up to
//! [`SLACK`] more or less where the table says that this brings the count to what it must be, and (4)
//! spread what is left of the misfit over the neighbouring chords by moving the points a little.
//!
//! *Source.* "Chord-length parameterisation, i.e. attempting to generate uniform chord lengths
//! between samples": Argudo, Andújar & Chica, *Tree Variations* (2017), §4.5. Equal arc lengths, the
//! usual reading, make chords of a ragged outline differ by more than 2 to 1.
//!
//! *Limits.* Step 4 leaves the curve, on real outlines by less than a chord and mostly not at all.

use super::Point;

/// How much an opening may differ from the others, relative, to steer the walk.
const SLACK: f64 = 0.004;

/// Unevenness that ends the relaxation, relative: safely below the promised 1 %.
const GOOD: f64 = 0.008;

/// Sweeps of relaxation at most; real outlines need some hundred.
const SWEEPS: usize = 4000;

/// Halvings of the bracket in which the opening is searched.
const BISECTIONS: usize = 40;

/// Openings tried on either side of the chord in one step.
const TRIES: i32 = 3;

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
    let mut points = curve.walk(curve.chord_for(count), count);
    relax(&mut points, curve.end());
    points
}

/// Evens out the chords of `points`, the one to `end` included, by moving points as little as
/// possible: each chord in turn pulls or pushes its two ends to the mean length. The first point
/// and the end stay.
fn relax(points: &mut Vec<Point>, end: Point) {
    points.push(end);
    let last = points.len() - 1;
    let mean = |points: &[Point]| {
        points
            .windows(2)
            .map(|pair| pair[0].distance(pair[1]))
            .sum::<f64>()
            / last as f64
    };
    for sweep in 0..SWEEPS {
        let chord = mean(points);
        if unevenness(points, chord) <= GOOD {
            break;
        }
        for step in 0..last {
            // To and fro, so that a misfit at one end spreads over many chords at once.
            let i = if sweep % 2 == 0 {
                last - 1 - step
            } else {
                step
            };
            let between = points[i + 1] - points[i];
            let length = between.length();
            if length > 0.0 {
                let correction = between * (0.5 * (length - chord) / length);
                let (first, second) = match (i == 0, i + 1 == last) {
                    (true, true) => (0.0, 0.0),
                    (true, false) => (0.0, 2.0),
                    (false, true) => (2.0, 0.0),
                    (false, false) => (1.0, 1.0),
                };
                points[i] += correction * first;
                points[i + 1] -= correction * second;
            }
        }
    }
    points.truncate(last);
}

/// Largest relative deviation of a chord from `chord`.
fn unevenness(points: &[Point], chord: f64) -> f64 {
    let chords = points.windows(2).map(|pair| pair[0].distance(pair[1]));
    chords
        .map(|length| (length / chord - 1.0).abs())
        .fold(0.0, f64::max)
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

    fn end_place(&self) -> Place {
        Place {
            segment: self.points.len() - 2,
            length: self.total(),
            point: self.end(),
        }
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

    /// The openings of one step, the unchanged one first.
    fn openings(&self) -> impl Iterator<Item = f64> + use<> {
        let chord = self.chord;
        let steps = (0..=TRIES).flat_map(|i| [i, -i]).skip(1);
        steps.map(move |i| chord * (1.0 + SLACK * f64::from(i) / f64::from(TRIES)))
    }

    /// How far off the count is at `place` when `wanted` steps should be left.
    fn error(&self, place: Place, wanted: f64) -> f64 {
        (self.at(place.length) - wanted).abs()
    }

    /// One step from `from` that leaves as nearly as possible `wanted` steps.
    fn steered_step(&self, from: Place, wanted: f64) -> Place {
        let mut best = (f64::INFINITY, from);
        for opening in self.openings() {
            let place = self
                .curve
                .step(from, opening)
                .unwrap_or_else(|| self.curve.end_place());
            let error = self.error(place, wanted);
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
            assert!(
                (point.x - 2.0 * i as f64).abs() < 0.02 * i as f64 + 1e-9,
                "{points:?}"
            );
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
            for count in [100, 200, 1600] {
                let points = equal_chords(&curve, count);
                assert_eq!(points.len(), count);
                assert_eq!(points[0], Point::ZERO);
                let mut closed = points.clone();
                closed.push(curve[curve.len() - 1]);
                let lengths = closed.windows(2).map(|pair| pair[0].distance(pair[1]));
                let deviation = unevenness(&closed, lengths.sum::<f64>() / f64::from(count as u32));
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
