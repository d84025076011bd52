//! Closed meshes of star-shaped bodies: a radius in every direction becomes a grid on each face of a
//! cube, joined along the cube's edges.

use super::Mesh;
use glam::DVec3;

/// The faces of the cube: right, down and outwards as seen from outside, as those of cubemaps.
const FACES: [[DVec3; 3]; 6] = [
    [DVec3::NEG_Z, DVec3::NEG_Y, DVec3::X],
    [DVec3::Z, DVec3::NEG_Y, DVec3::NEG_X],
    [DVec3::X, DVec3::Z, DVec3::Y],
    [DVec3::X, DVec3::NEG_Z, DVec3::NEG_Y],
    [DVec3::X, DVec3::NEG_Y, DVec3::Z],
    [DVec3::NEG_X, DVec3::NEG_Y, DVec3::NEG_Z],
];

/// The body that reaches `radius(direction)` from `center` in every direction, as a watertight mesh
/// of 6 `cells`² + 2 vertices. Directions are given with their longest component 1.
///
/// The grid is that of equal angles, not of equal steps on the cube, so that its cells are of
/// nearly equal size on a sphere.
///
/// ```
/// use boscage::geometry::{Topology, star_shaped};
/// use glam::DVec3;
/// let ball = star_shaped(DVec3::ZERO, 16, |_| 2.0);
/// assert!(Topology::of(&ball).is_watertight());
/// let volume = 4.0 / 3.0 * std::f64::consts::PI * 8.0;
/// assert!((ball.volume() / volume - 1.0).abs() < 0.01);
/// ```
///
/// # Panics
/// When `cells` is 0.
pub fn star_shaped(center: DVec3, cells: u32, radius: impl Fn(DVec3) -> f64) -> Mesh {
    assert!(cells > 0, "a cube has cells");
    let lattice = Lattice::new(cells);
    let mut positions = Vec::new();
    let mut vertex_at = vec![u32::MAX; lattice.len()];
    let mut triangles = Vec::with_capacity(12 * (cells * cells) as usize);
    for face in FACES {
        for (y, x) in (0..=cells).flat_map(|y| (0..=cells).map(move |x| (y, x))) {
            let slot = &mut vertex_at[lattice.index(face, x, y)];
            if *slot == u32::MAX {
                *slot = positions.len() as u32;
                let direction = lattice.direction(face, x, y);
                positions.push(center + direction.normalize() * radius(direction));
            }
        }
        for (y, x) in (0..cells).flat_map(|y| (0..cells).map(move |x| (y, x))) {
            let at = |dx, dy| vertex_at[lattice.index(face, x + dx, y + dy)];
            let [a, b, c, d] = [at(0, 0), at(0, 1), at(1, 1), at(1, 0)];
            // Diagonals towards the middle of the face, alike from all sides.
            if (2 * x < cells) == (2 * y < cells) {
                triangles.extend([[a, b, c], [a, c, d]]);
            } else {
                triangles.extend([[a, b, d], [b, c, d]]);
            }
        }
    }
    Mesh {
        positions,
        triangles,
    }
}

/// Places on the surface of a cube, each with one index whichever face it is reached from.
struct Lattice {
    cells: u32,
    /// −1 … 1 at equal angles.
    steps: Vec<f64>,
}

impl Lattice {
    fn new(cells: u32) -> Self {
        let angle =
            |i: u32| (2.0 * f64::from(i) / f64::from(cells) - 1.0) * std::f64::consts::FRAC_PI_4;
        let mut steps: Vec<f64> = (0..=cells).map(|i| libm::tan(angle(i))).collect();
        // Exact ends, and exactly symmetric: edges agree from both sides.
        steps[0] = -1.0;
        for i in 0..=cells as usize / 2 {
            steps[cells as usize - i] = -steps[i];
        }
        Self { cells, steps }
    }

    fn len(&self) -> usize {
        (self.cells as usize + 1).pow(3)
    }

    /// Steps along each axis of space, as an index of the cube's points.
    fn index(&self, [right, down, out]: [DVec3; 3], x: u32, y: u32) -> usize {
        let side = f64::from(self.cells);
        let (x, y) = (f64::from(x) * 2.0 - side, f64::from(y) * 2.0 - side);
        let point = (right * x + down * y + out * side + DVec3::splat(side)) / 2.0;
        let side = self.cells as usize + 1;
        (point.z as usize * side + point.y as usize) * side + point.x as usize
    }

    fn direction(&self, [right, down, out]: [DVec3; 3], x: u32, y: u32) -> DVec3 {
        right * self.steps[x as usize] + down * self.steps[y as usize] + out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Topology;

    #[test]
    fn every_size_is_closed_and_shares_its_edges() {
        for cells in [1, 2, 3, 8, 13] {
            let mesh = star_shaped(DVec3::ONE, cells, |direction| 1.0 + 0.1 * direction.x);
            let found = Topology::of(&mesh);
            assert!(found.is_watertight());
            assert_eq!(found.genus(), Some(0));
            assert_eq!(found.vertices, 6 * (cells * cells) as usize + 2);
            assert!(mesh.volume() > 0.0);
        }
    }
}
