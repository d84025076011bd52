//! Outlines of trees with and without a trunk, made to correspond.
//!
//! A tree whose trunk does not show gives all points of its outline to the crown (Argudo, Andújar &
//! Chica 2017, *Tree Variations*, §4.4), so that crown points meet the trunk points of another tree:
//! mixes of the two stood on a vase. Where both come together,
//!
//! - a tree without a trunk gets a *virtual foot*: the points of the trunk crowd on the piece of its
//!   outline above which a trunk would stand, as wide as the others' trunks. The mix has a trunk,
//!   shorter by the weight of the tree that has none;
//! - but when only trees without a trunk give colours there is nothing to paint a trunk with: then the
//!   others lose theirs and their crowns stand on the ground.
//!
//! Among themselves trees of one sort are left as they are.
//!
//! A mixed trunk follows the giver's profile: averaged with a trunk that forks, or is a foot only, it
//! would bulge where it meets the crown. It may be thicker or thinner as a whole, as its lower part
//! says.

use super::Shape;
use crate::contour::{PinnedContour, Pins, TRUNK_SHARE};
use crate::geometry::Point;
use std::borrow::Cow;

/// A shape, its share of the outline, its share of the colours.
pub(super) type Weighted<'a> = (&'a Shape, f64, f64);

/// The combined outline of trees with `(shape, contour weight, color weight)`: point for point what
/// [`super::Layout::contour`] is, without its maps.
///
/// # Panics
/// When there are no shapes or they were prepared with different settings.
pub fn combined_outline(parts: &[(&Shape, f64, f64)]) -> PinnedContour {
    let contours = matched(parts, |shape| &shape.contour);
    combined(&contours, parts)
}

/// The combination of `contours` with the weights of `parts`.
pub(super) fn combined(
    contours: &[Cow<'_, PinnedContour>],
    parts: &[Weighted<'_>],
) -> PinnedContour {
    let weighted = contours.iter().zip(parts);
    let weighted: Vec<(&PinnedContour, f64)> = weighted
        .map(|(contour, (_, weight, _))| (contour.as_ref(), *weight))
        .collect();
    let mut mix = PinnedContour::combined(&weighted);
    let giving = contours.iter().zip(parts);
    let giving: Vec<(&PinnedContour, f64)> = giving
        .map(|(contour, (_, _, color))| (contour.as_ref(), *color))
        .filter(|(contour, color)| *color > 0.0 && contour.pins.has_trunk())
        .collect();
    // Virtual feet are no trunks and say nothing of how thick one is.
    let real = contours.iter().zip(parts);
    let real: Vec<(&PinnedContour, f64)> = real
        .filter(|(contour, _)| matches!(contour, Cow::Borrowed(_)) && contour.pins.has_trunk())
        .map(|(contour, (_, weight, _))| (contour.as_ref(), *weight))
        .collect();
    if mix.pins.has_trunk() && !giving.is_empty() && contours.len() > 1 {
        give_profile(&mut mix, &giving, &real);
    }
    mix
}

/// Part of a trunk's side, from the foot up, that says how thick the trunk is.
const LOWER_PART: std::ops::Range<f64> = 0.35..0.75;

/// Part of the crown's points on either side over which a corrected trunk fades into the crown.
const FADE: f64 = 0.06;

/// How much thicker or thinner than its profile a trunk may get.
const THICKEST: f64 = 1.8;

/// Gives the trunk of `mix` the profile of the trunks `giving`, and the thickness of the trunks `real`;
/// each with its weight.
fn give_profile(
    mix: &mut PinnedContour,
    giving: &[(&PinnedContour, f64)],
    real: &[(&PinnedContour, f64)],
) {
    let count = mix.points.len();
    let side = mix.pins.right;
    let half = |contour: &PinnedContour, i: usize| {
        (contour.points[i] - contour.points[(count - i) % count]) / 2.0
    };
    let mean = |trunks: &[(&PinnedContour, f64)], i: usize| {
        let sum: f64 = trunks.iter().map(|(_, weight)| weight).sum();
        let halves = trunks.iter().map(|(trunk, w)| w * half(trunk, i).length());
        halves.sum::<f64>() / sum.max(f64::MIN_POSITIVE)
    };
    let profile: Vec<f64> = (0..=side).map(|i| mean(giving, i)).collect();
    let lower = (LOWER_PART.start * side as f64) as usize..(LOWER_PART.end * side as f64) as usize;
    let own: f64 = lower.clone().map(|i| mean(real, i)).sum();
    let given: f64 = profile[lower].iter().sum();
    // With hardly any points there is no lower part.
    let thickness = if own > 0.0 && given > 0.0 {
        (own / given).clamp(1.0 / THICKEST, THICKEST)
    } else {
        1.0
    };
    let mut change = Point::ZERO;
    for (i, wanted) in profile.iter().enumerate().skip(1) {
        let old = half(mix, i);
        change = old.normalize_or_zero() * (wanted * thickness) - old;
        mix.points[i] += change;
        mix.points[count - i] -= change;
    }
    let fade = ((FADE * (count - 2 * side) as f64) as usize).max(1);
    for step in 1..fade {
        let left = 1.0 - step as f64 / fade as f64;
        mix.points[side + step] += change * left;
        mix.points[count - side - step] -= change * left;
    }
}

/// What `contour` takes of each part, so that trunks meet trunks.
pub(super) fn matched<'a>(
    parts: &[Weighted<'a>],
    contour: impl Fn(&'a Shape) -> &'a PinnedContour,
) -> Vec<Cow<'a, PinnedContour>> {
    let contours: Vec<&PinnedContour> = parts.iter().map(|part| contour(part.0)).collect();
    let with_trunk = contours.iter().filter(|contour| contour.pins.has_trunk());
    let widths: Vec<f64> = with_trunk.map(|c| c.left().distance(c.right())).collect();
    if widths.is_empty() || widths.len() == contours.len() {
        return contours.into_iter().map(Cow::Borrowed).collect();
    }
    let gives_trunk = parts
        .iter()
        .zip(&contours)
        .any(|((_, _, color), contour)| *color > 0.0 && contour.pins.has_trunk());
    let width = widths.iter().sum::<f64>() / widths.len() as f64;
    contours
        .into_iter()
        .map(|contour| match (gives_trunk, contour.pins.has_trunk()) {
            (true, false) => Cow::Owned(with_virtual_foot(contour, width)),
            (false, true) => Cow::Owned(grounded_crown(contour)),
            _ => Cow::Borrowed(contour),
        })
        .collect()
}

/// A contour without a trunk in as many points, of which those of a trunk crowd within `width` round
/// the foot.
fn with_virtual_foot(contour: &PinnedContour, width: f64) -> PinnedContour {
    let count = contour.points.len();
    let side = ((count as f64 * TRUNK_SHARE).round() as usize).max(1);
    let length: f64 = edges(&contour.points).map(|(a, b)| a.distance(b)).sum();
    // Never more than the trunk's own share of the way round.
    let half = (0.5 * width).min(TRUNK_SHARE * length);
    let mut places = Vec::with_capacity(count);
    let spread = |places: &mut Vec<f64>, from: f64, to: f64, count: usize| {
        places.extend((0..count).map(|i| from + (to - from) * i as f64 / count as f64));
    };
    spread(&mut places, 0.0, half, side);
    spread(&mut places, half, length - half, count - 2 * side);
    spread(&mut places, length - half, length, side);
    PinnedContour {
        points: points_along(&contour.points, &places),
        pins: Pins {
            bottom: 0,
            right: side,
            left: count - side,
        },
    }
}

/// The points of a closed contour at the given distances from its first, which must rise.
fn points_along(contour: &[Point], places: &[f64]) -> Vec<Point> {
    let mut edges = edges(contour).peekable();
    let mut walked = 0.0;
    let on_edge = |place: &f64| {
        while let Some(&(a, b)) = edges.peek() {
            let edge = a.distance(b);
            if *place <= walked + edge {
                let share = (place - walked) / edge.max(f64::MIN_POSITIVE);
                return a.lerp(b, share.clamp(0.0, 1.0));
            }
            walked += edge;
            edges.next();
        }
        contour[0]
    };
    places.iter().map(on_edge).collect()
}

fn edges(contour: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    let next = contour.iter().cycle().skip(1);
    contour.iter().copied().zip(next.copied())
}

/// The contour with its trunk drawn in: the crown closes where the trunk entered it, and stands where
/// the trunk stood.
fn grounded_crown(contour: &PinnedContour) -> PinnedContour {
    let (right, left) = (contour.pins.right, contour.pins.left);
    let count = contour.points.len();
    let middle = contour.left().midpoint(contour.right());
    let mut points = contour.points.clone();
    for (i, point) in points.iter_mut().enumerate() {
        if i < right {
            *point = middle.lerp(contour.right(), i as f64 / right as f64);
        } else if i > left {
            *point = contour
                .left()
                .lerp(middle, (i - left) as f64 / (count - left) as f64);
        }
    }
    let lowest = points.iter().map(|point| point.y).fold(f64::MIN, f64::max);
    let drop = Point::new(0.0, contour.bottom().y - lowest);
    points.iter_mut().for_each(|point| *point += drop);
    PinnedContour {
        points,
        pins: Pins::without_trunk(0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crown of 60 by 50 on a trunk of 8 by 40, or without one.
    fn shape(has_trunk: bool) -> Shape {
        let crown = [(30.0, -40.0), (30.0, -90.0), (-30.0, -90.0), (-30.0, -40.0)];
        let mut outline = vec![(0.0, 0.0)];
        let pins = if has_trunk {
            outline.extend([(4.0, 0.0), (4.0, -40.0)]);
            outline.extend(crown);
            outline.extend([(-4.0, -40.0), (-4.0, 0.0)]);
            Pins {
                bottom: 0,
                right: 2,
                left: 7,
            }
        } else {
            outline.extend(crown.map(|(x, y)| (x, y + 40.0)));
            Pins::without_trunk(0)
        };
        let outline: Vec<Point> = outline
            .into_iter()
            .map(|(x, y)| Point::new(64.0 + x, 120.0 + y))
            .collect();
        let contour = PinnedContour::resampled(&outline, pins, 200);
        Shape {
            size: 128,
            cage: contour.clone(),
            contour,
            baseline_y: has_trunk.then_some(80.0),
            density: 1.0,
            fullness: 1.0,
            straight: 0.0,
            texture: 0.01,
            gaps: Vec::new(),
        }
    }

    fn width_at(contour: &PinnedContour, y: f64) -> f64 {
        let crossings = edges(&contour.points).filter(|(a, b)| (a.y > y) != (b.y > y));
        let crossings = crossings.map(|(a, b)| a.lerp(b, (y - a.y) / (b.y - a.y)).x);
        let (low, high) = crossings.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    }

    #[test]
    fn a_mix_with_a_trunk_keeps_it_straight() {
        let (with, without) = (shape(true), shape(false));
        let mix = combined_outline(&[(&with, 0.5, 1.0), (&without, 0.5, 0.0)]);
        assert!(mix.pins.has_trunk());
        assert!((mix.bottom().y - 120.0).abs() < 1e-9);
        assert!(
            (mix.right().y - 100.0).abs() < 2.0,
            "half as high: {}",
            mix.right()
        );
        for y in [102.0, 110.0, 118.0] {
            assert!(
                (width_at(&mix, y) - 8.0).abs() < 1.5,
                "{}",
                width_at(&mix, y)
            );
        }
    }

    #[test]
    fn a_mixed_trunk_does_not_bulge() {
        let giver = shape(true);
        let mut forked = giver.clone();
        // Wider towards the crown, three times as wide where it enters it.
        let (side, count) = (forked.contour.pins.right, forked.contour.points.len());
        for i in 1..=side {
            let wider = 8.0 * (i as f64 / side as f64).powi(3);
            forked.contour.points[i].x += wider;
            forked.contour.points[count - i].x -= wider;
        }
        let mix = combined_outline(&[(&giver, 0.5, 1.0), (&forked, 0.5, 0.0)]);
        let (low, high) = (width_at(&mix, 115.0), width_at(&mix, 83.0));
        assert!(high < 1.2 * low, "{low} {high}");
    }

    #[test]
    fn without_a_giver_of_a_trunk_the_crown_stands_on_the_ground() {
        let (with, without) = (shape(true), shape(false));
        let mix = combined_outline(&[(&with, 0.5, 0.0), (&without, 0.5, 1.0)]);
        assert!(!mix.pins.has_trunk());
        let lowest = mix.points.iter().map(|p| p.y).fold(f64::MIN, f64::max);
        assert!((lowest - 120.0).abs() < 1.0);
        assert!(width_at(&mix, 118.0) > 40.0);
    }

    #[test]
    fn trees_of_one_sort_are_left_alone() {
        let with = shape(true);
        let mix = combined_outline(&[(&with, 0.5, 1.0), (&with, 0.5, 0.0)]);
        assert_eq!(mix.points, with.contour.points);
    }
}
