//! A rim for pixels where the figure is not a surface: lines, single pixels, necks, touching corners.
//!
//! Around a pixel the figure consists of fans of triangles and of bare edges, with gaps between
//! them. A pixel with exactly one fan is ordinary. Any other gets rim vertices in its gaps, half a
//! pixel away, and becomes an inner vertex: triangles fill the space between it, the rim vertices of
//! each gap, and the neighbours where the gap begins and ends. Two such pixels that are neighbours
//! have a quadrilateral between them. A gap is at least 90° wide, so rims of different places keep
//! apart.

use super::super::domain::AROUND;
use super::plan::{Plan, strip_height};
use crate::geometry::Point;
use crate::raster::{Image, Mask};
use glam::{DVec2, DVec3};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_4, PI};

/// Half the width of a pixel: how far the rim of a thin place lies from the pixels' centres.
const RIM_PX: f64 = 0.5;

/// A range of directions around a pixel that no triangle takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Gap {
    /// Where it begins; `None` for a pixel without neighbours.
    from: Option<usize>,
    /// Eighths of a turn to its end.
    eighths: usize,
}

impl Gap {
    /// Where it ends.
    fn to(self) -> Option<usize> {
        self.from.map(|from| (from + self.eighths) % 8)
    }

    /// Directions of its rim vertices: they divide the gap into parts of about 90°, those of a
    /// whole turn without neighbours into four.
    fn rim(self) -> Vec<DVec2> {
        let quarters = self.eighths.div_ceil(2);
        let count = if self.from.is_some() {
            (quarters - 1).max(1)
        } else {
            quarters
        };
        let parts = count + usize::from(self.from.is_some());
        let start = self.from.unwrap_or(0) as f64 * FRAC_PI_4;
        let step = self.eighths as f64 * FRAC_PI_4 / parts as f64;
        let first = usize::from(self.from.is_some());
        let angles = (first..first + count).map(|i| start + i as f64 * step);
        angles.map(direction).collect()
    }
}

/// The unit vector at `angle`, exact along the axes.
fn direction(angle: f64) -> DVec2 {
    let snapped = |value: f64| if value.abs() < 1e-12 { 0.0 } else { value };
    debug_assert!(angle <= 4.0 * PI);
    DVec2::new(snapped(libm::cos(angle)), snapped(libm::sin(angle)))
}

/// The gaps of the pixel at (x, y), counter-clockwise, and whether the pixel is ordinary: one fan.
fn gaps(mask: &Mask, x: i64, y: i64) -> (Vec<Gap>, bool) {
    let present = AROUND.map(|(dx, dy)| mask.get(x + dx, y + dy) == Some(true));
    // Whether the eighth of a turn behind each neighbour is taken by a triangle.
    let filled: [bool; 8] = std::array::from_fn(|eighth| {
        let (axis, diagonal) = (eighth.div_ceil(2) * 2 % 8, eighth / 2 * 2 + 1);
        let other_axis = (diagonal * 2 + 8 - axis) % 8;
        present[axis] && (present[diagonal] || present[other_axis])
    });
    let before = |d: usize| filled[(d + 7) % 8];
    let ends: Vec<usize> = (0..8)
        .filter(|&d| present[d] && !(filled[d] && before(d)))
        .collect();
    if ends.is_empty() {
        let alone = Gap {
            from: None,
            eighths: 8,
        };
        return (vec![alone], false);
    }
    let opening = ends.iter().filter(|&&d| !filled[d]);
    let gaps: Vec<Gap> = opening
        .map(|&from| {
            let wide = (1..=8).find(|i| present[(from + i) % 8] && !before((from + i) % 8));
            Gap {
                from: Some(from),
                eighths: wide.unwrap_or(8),
            }
        })
        .collect();
    let is_ordinary = gaps.len() == 1 && gaps[0].eighths < 8;
    (gaps, is_ordinary)
}

/// A pixel with a rim of its own.
struct ThinPixel {
    x: i64,
    y: i64,
    /// Its lifted vertex.
    vertex: u32,
    gaps: Vec<(Gap, Vec<u32>)>,
}

impl ThinPixel {
    /// The rim vertex behind neighbour `from`, counter-clockwise.
    fn rim_after(&self, from: usize) -> Option<u32> {
        let (_, rim) = self.gaps.iter().find(|(gap, _)| gap.from == Some(from))?;
        rim.first().copied()
    }

    /// The rim vertex before neighbour `to`, counter-clockwise.
    fn rim_before(&self, to: usize) -> Option<u32> {
        let (_, rim) = self.gaps.iter().find(|(gap, _)| gap.to() == Some(to))?;
        rim.last().copied()
    }
}

/// Lifts the pixels of thin places, adds all triangles between pixels, and those of the rims.
pub(super) fn widen(plan: &mut Plan, mask: &Mask, slope: &impl Fn(Point) -> f64) {
    let mut thin = BTreeMap::new();
    for pixel in 0..plan.numbers.pixels().len() {
        let number = plan.numbers.pixels()[pixel];
        if number == super::NO_PIXEL || !plan.is_rim[number as usize] {
            continue;
        }
        let width = plan.numbers.width() as usize;
        let (x, y) = ((pixel % width) as i64, (pixel / width) as i64);
        let (gaps, is_ordinary) = gaps(mask, x, y);
        if !is_ordinary {
            thin.insert(number, lifted(plan, number, (x, y), gaps, slope));
        }
    }
    plan.add_blocks();
    for pixel in thin.values() {
        add_rim_triangles(plan, pixel, &thin);
    }
}

/// Adds the vertices of a thin pixel.
fn lifted(
    plan: &mut Plan,
    number: u32,
    (x, y): (i64, i64),
    gaps: Vec<Gap>,
    slope: &impl Fn(Point) -> f64,
) -> ThinPixel {
    let place = plan.positions[number as usize].truncate();
    let lift = strip_height(slope(place), RIM_PX);
    let vertex = plan.add(place.extend(lift), false);
    plan.standing[number as usize] = vertex;
    let with_rim = |gap: Gap| {
        let rim = gap.rim().into_iter().map(|direction| {
            let position: DVec3 = (place + direction * RIM_PX).extend(0.0);
            plan.add(position, true)
        });
        (gap, rim.collect())
    };
    ThinPixel {
        x,
        y,
        vertex,
        gaps: gaps.into_iter().map(with_rim).collect(),
    }
}

/// Adds what lies between a thin pixel, its rim and its neighbours.
fn add_rim_triangles(plan: &mut Plan, pixel: &ThinPixel, thin: &BTreeMap<u32, ThinPixel>) {
    let number = |numbers: &Image<u32>, d: usize| {
        let (dx, dy) = AROUND[d];
        numbers.at((pixel.x + dx) as u32, (pixel.y + dy) as u32)
    };
    let here = pixel.vertex;
    for (gap, rim) in &pixel.gaps {
        for pair in rim.windows(2) {
            plan.triangles.push([here, pair[0], pair[1]]);
        }
        let (Some(from), Some(to)) = (gap.from, gap.to()) else {
            plan.triangles.push([here, rim[rim.len() - 1], rim[0]]);
            continue;
        };
        // The side where the gap begins. The neighbour's own rim is met once: here.
        let neighbour = number(&plan.numbers, from);
        let beside = plan.standing[neighbour as usize];
        match thin
            .get(&neighbour)
            .and_then(|n| n.rim_before((from + 4) % 8))
        {
            Some(far) => plan
                .triangles
                .extend([[here, beside, far], [here, far, rim[0]]]),
            None => plan.triangles.push([here, beside, rim[0]]),
        }
        // The side where it ends.
        let neighbour = number(&plan.numbers, to);
        let beside = plan.standing[neighbour as usize];
        let other = thin.get(&neighbour).and_then(|n| n.rim_after((to + 4) % 8));
        if other.is_none() {
            plan.triangles.push([here, rim[rim.len() - 1], beside]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::mask;

    #[test]
    fn gaps_lie_between_fans_and_bare_edges() {
        let found = |rows: &[&str]| gaps(&mask(rows), 1, 1);
        let gap = |from, eighths| Gap {
            from: Some(from),
            eighths,
        };
        assert!(!found(&["...", ".#.", "..."]).1);
        // A straight side: a half turn open upwards (y is down, so from 4 to 0 over 6).
        assert_eq!(found(&["...", "###", "###"]), (vec![gap(4, 4)], true));
        // A convex corner, three of four pixels, and a diagonal side.
        assert_eq!(found(&["...", ".##", ".##"]), (vec![gap(2, 6)], true));
        assert_eq!(found(&["...", ".##", ".#."]), (vec![gap(2, 6)], true));
        assert_eq!(found(&["..#", ".##", "###"]), (vec![gap(3, 4)], true));
        // A line, its end, a corner that touches.
        let line = found(&["...", "###", "..."]);
        assert_eq!(line, (vec![gap(0, 4), gap(4, 4)], false));
        assert_eq!(found(&["...", ".##", "..."]), (vec![gap(0, 8)], false));
        let touching = found(&["#..", ".##", ".##"]);
        assert_eq!(touching, (vec![gap(2, 3), gap(5, 3)], false));
    }

    #[test]
    fn the_rim_of_a_line_runs_along_it_and_around_its_end() {
        let rim = |from, eighths| {
            let gap = Gap { from, eighths };
            gap.rim()
        };
        assert_eq!(rim(Some(0), 4), [DVec2::Y]);
        let end = rim(Some(0), 8);
        let expected = [DVec2::Y, -DVec2::X, -DVec2::Y];
        assert!(
            end.iter()
                .zip(expected)
                .all(|(a, b)| a.abs_diff_eq(b, 1e-12))
        );
        assert_eq!(rim(None, 8).len(), 4);
    }
}
