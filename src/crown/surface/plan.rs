//! The flat figure that becomes a surface: which vertices, which triangles, which of the vertices
//! lie on the rim that front and back share.

use super::{NO_PIXEL, numbered};
use crate::geometry::{Mesh, Point};
use crate::raster::{Image, Mask};
use glam::DVec3;
use std::collections::HashMap;

/// A triangulated figure with a rim. Triangles are counter-clockwise in (x, y).
pub(super) struct Plan {
    /// Number of each mask pixel, which is that of its vertex in the sheet.
    pub(super) numbers: Image<u32>,
    /// Vertices of the front: those of the sheet, then added ones.
    pub(super) positions: Vec<DVec3>,
    /// Whether the front and the back share the vertex.
    pub(super) is_rim: Vec<bool>,
    /// The vertex that stands for each mask pixel in triangles: its own or, in thin places, a lifted
    /// one.
    pub(super) standing: Vec<u32>,
    pub(super) triangles: Vec<[u32; 3]>,
}

impl Plan {
    /// The pixels as vertices, those of the silhouette on the rim; no triangle yet.
    pub(super) fn of_pixels(mask: &Mask, sheet: &[DVec3]) -> Self {
        let numbers = numbered(mask);
        let mut is_rim = Vec::with_capacity(sheet.len());
        for y in 0..i64::from(mask.height()) {
            for x in 0..i64::from(mask.width()) {
                let outside = |dx, dy| mask.get(x + dx, y + dy) != Some(true);
                if !outside(0, 0) {
                    is_rim.push(outside(1, 0) || outside(-1, 0) || outside(0, 1) || outside(0, -1));
                }
            }
        }
        Self {
            numbers,
            positions: sheet.to_vec(),
            is_rim,
            standing: (0..sheet.len() as u32).collect(),
            triangles: Vec::new(),
        }
    }

    /// Adds a vertex of the front.
    pub(super) fn add(&mut self, position: DVec3, is_rim: bool) -> u32 {
        self.positions.push(position);
        self.is_rim.push(is_rim);
        self.positions.len() as u32 - 1
    }

    /// Adds the triangles of all blocks of 2×2 pixels.
    pub(super) fn add_blocks(&mut self) {
        let (width, height) = (self.numbers.width() as usize, self.numbers.height());
        for y in 1..height {
            for x in 1..width {
                let (upper, lower) = (self.numbers.row(y - 1), self.numbers.row(y));
                // Counter-clockwise in (x, y), y down.
                let block = [upper[x - 1], upper[x], lower[x], lower[x - 1]];
                self.add_block(block);
            }
        }
    }

    fn add_block(&mut self, block: [u32; 4]) {
        let missing = block.iter().filter(|&&pixel| pixel == NO_PIXEL).count();
        if missing > 1 {
            return;
        }
        let hole = block.iter().position(|&pixel| pixel == NO_PIXEL);
        let corner = |i: usize| self.standing[block[i % 4] as usize];
        if let Some(hole) = hole {
            let triangle = [corner(hole + 1), corner(hole + 2), corner(hole + 3)];
            self.triangles.push(triangle);
            return;
        }
        let first = usize::from(!self.prefers_diagonal([0, 1, 2, 3].map(corner)));
        let [a, b, c, d] = [0, 1, 2, 3].map(|i| corner(first + i));
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// Whether the quadrilateral is better cut from its first to its third corner than from its
    /// second to its fourth: not between two points of the rim, and the shorter way.
    fn prefers_diagonal(&self, corners: [u32; 4]) -> bool {
        let [a, b, c, d] = corners.map(|vertex| vertex as usize);
        let rim = |one: usize, other: usize| self.is_rim[one] && self.is_rim[other];
        if rim(a, c) != rim(b, d) {
            return rim(b, d);
        }
        let length =
            |one: usize, other: usize| self.positions[one].distance_squared(self.positions[other]);
        length(a, c) <= length(b, d)
    }

    /// Gives a lifted vertex to each inner edge between two points of the rim and to each triangle
    /// that would be flat otherwise.
    pub(super) fn divide_flat_triangles(&mut self, slope: &impl Fn(Point) -> f64) {
        let middles = self.middles_of_chords(slope);
        let triangles = std::mem::take(&mut self.triangles);
        for triangle in triangles {
            let middle = |i: usize| {
                let ends = [triangle[i], triangle[(i + 1) % 3]];
                // Most edges are no chords, and looking them up would take longer than all the rest.
                let may_be_chord = ends.iter().all(|&end| self.is_rim[end as usize]);
                let found = may_be_chord.then(|| middles.get(&edge(ends[0], ends[1])));
                found.flatten().copied()
            };
            let found = [0, 1, 2].map(middle);
            match found.iter().flatten().count() {
                0 if triangle.iter().all(|&v| self.is_rim[v as usize]) => {
                    self.add_with_middle(triangle, slope);
                }
                0 => self.triangles.push(triangle),
                _ => self.triangles.extend(divided(triangle, found)),
            }
        }
    }

    /// A vertex for each edge of two triangles whose ends both lie on the rim.
    fn middles_of_chords(&mut self, slope: &impl Fn(Point) -> f64) -> HashMap<[u32; 2], u32> {
        let mut seen: HashMap<[u32; 2], u32> = HashMap::new();
        let mut chords = Vec::new();
        for triangle in &self.triangles {
            for i in 0..3 {
                let ends = [triangle[i], triangle[(i + 1) % 3]];
                if ends.iter().any(|&end| !self.is_rim[end as usize]) {
                    continue;
                }
                let times = seen.entry(edge(ends[0], ends[1])).or_insert(0);
                *times += 1;
                if *times == 2 {
                    chords.push(edge(ends[0], ends[1]));
                }
            }
        }
        let mut middles = HashMap::with_capacity(chords.len());
        for chord in chords {
            let [one, other] = chord.map(|vertex| self.positions[vertex as usize]);
            let place = one.midpoint(other);
            let lift = strip_height(slope(place.truncate()), one.distance(other) / 2.0);
            middles.insert(chord, self.add(place + DVec3::Z * lift, false));
        }
        middles
    }

    /// Adds `triangle` in three parts around its middle, lifted over its inscribed circle.
    fn add_with_middle(&mut self, triangle: [u32; 3], slope: &impl Fn(Point) -> f64) {
        let [a, b, c] = triangle.map(|vertex| self.positions[vertex as usize]);
        let twice_area = (b - a).cross(c - a).length();
        let around = a.distance(b) + b.distance(c) + c.distance(a);
        let place = (a + b + c) / 3.0;
        let lift = strip_height(slope(place.truncate()), twice_area / around);
        let middle = self.add(place + DVec3::Z * lift, false);
        let [a, b, c] = triangle;
        let parts = [[a, b, middle], [b, c, middle], [c, a, middle]];
        self.triangles.extend(parts);
    }

    /// The surface: the front, and its mirror image that shares the rim.
    pub(super) fn doubled(self) -> Mesh {
        let mut used = vec![false; self.positions.len()];
        for &vertex in self.triangles.as_flattened() {
            used[vertex as usize] = true;
        }
        let mut positions = self.positions;
        let mut behind: Vec<u32> = (0..positions.len() as u32).collect();
        for vertex in 0..behind.len() {
            if used[vertex] && !self.is_rim[vertex] {
                behind[vertex] = positions.len() as u32;
                let DVec3 { x, y, z } = positions[vertex];
                positions.push(DVec3::new(x, y, -z));
            }
        }
        let mut triangles = self.triangles;
        let back = triangles.iter().map(|&[a, b, c]| [a, c, b]);
        let back: Vec<_> = back.map(|t| t.map(|v| behind[v as usize])).collect();
        triangles.extend(back);
        Mesh {
            positions,
            triangles,
        }
    }
}

/// Height in the middle of an inflated strip of half-width `radius`, where it leaves the plane with
/// the tangent parameter `k`.
pub(super) fn strip_height(k: f64, radius: f64) -> f64 {
    k * radius / 2.0
}

/// The name of an edge.
fn edge(one: u32, other: u32) -> [u32; 2] {
    [one.min(other), one.max(other)]
}

/// `triangle` in two to four parts; `middles[i]` is the vertex on the edge that begins at corner i.
fn divided([a, b, c]: [u32; 3], middles: [Option<u32>; 3]) -> Vec<[u32; 3]> {
    match middles {
        [None, None, None] => vec![[a, b, c]],
        [Some(m), None, None] => vec![[a, m, c], [m, b, c]],
        [Some(ab), Some(bc), None] => vec![[ab, b, bc], [a, ab, bc], [a, bc, c]],
        [Some(ab), Some(bc), Some(ca)] => {
            vec![[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        }
        [ab, bc, ca] => divided([b, c, a], [bc, ca, ab]),
    }
}
