//! A crown's radii as a closed mesh: a cube of six grids blown up to the surface.
//!
//! Every direction has one radius, so the surface is star-shaped around the centre and the mesh has
//! the topology of a sphere. Grid lines stand at equal angles, not at equal distances on the cube's
//! faces (J. Everitt, *Projecting a square on a sphere*, the "tangent adjustment"): otherwise cells
//! near the corners would be five times smaller than those in the middle.

use crate::geometry::Mesh;
use crate::raster::{CubeFace, Cubemap, smoothed_cubemap};
use glam::DVec3;
use std::collections::BTreeMap;

/// A closed mesh whose vertices are also those of six square grids.
#[derive(Debug, Clone, PartialEq)]
pub struct CubeSphere {
    /// The surface; every vertex stands once, also those on the cube's edges.
    pub mesh: Mesh,
    /// Cells along a side of a face.
    pub cells: u32,
    /// For each face in the order of [`CubeFace::ALL`] the vertices of its grid, `cells` + 1 in a
    /// row, from the left and the top.
    pub grids: [Vec<u32>; 6],
}

/// The surface at `radius` around `center`, in 6 · `cells`² · 2 triangles.
///
/// Where the cells are larger than the texels, radii are smoothed to what the cells can show.
///
/// ```
/// use boscage::{crown::cube_sphere, raster::Cubemap};
/// use glam::DVec3;
/// let ball = cube_sphere(&Cubemap::filled(8, 2.0), DVec3::Y, 4);
/// assert_eq!(ball.mesh.positions.len(), 6 * 16 + 2);
/// assert!(ball.mesh.positions.iter().all(|p| (p.distance(DVec3::Y) - 2.0).abs() < 1e-6));
/// ```
///
/// # Panics
/// When `cells` is 0.
pub fn cube_sphere(radius: &Cubemap<f32>, center: DVec3, cells: u32) -> CubeSphere {
    /// Standard deviation in cells of what a grid of cells can show without aliasing.
    const SHOWN: f64 = 0.4;
    assert!(cells > 0, "a grid has cells");
    let texels_of_cell = f64::from(radius.size()) / f64::from(cells);
    let radius = if texels_of_cell > 1.0 {
        smoothed_cubemap(radius, SHOWN * texels_of_cell)
    } else {
        radius.clone()
    };
    let mut numbers = BTreeMap::new();
    let mut mesh = Mesh::default();
    let grids = CubeFace::ALL.map(|face| {
        let vertices = (0..=cells).flat_map(|j| (0..=cells).map(move |i| (i, j)));
        let number = |(i, j)| {
            *numbers
                .entry(lattice(face, i, j, cells))
                .or_insert_with(|| {
                    let direction = face.direction(grid_line(i, cells), grid_line(j, cells));
                    let distance = f64::from(radius.sampled(direction));
                    mesh.positions
                        .push(center + direction.normalize() * distance);
                    mesh.positions.len() as u32 - 1
                })
        };
        vertices.map(number).collect::<Vec<u32>>()
    });
    for grid in &grids {
        let row = cells as usize + 1;
        for at in (0..row * row - row).filter(|at| at % row != row - 1) {
            let quad = [grid[at], grid[at + row], grid[at + row + 1], grid[at + 1]];
            mesh.triangles.extend(halves(quad, &mesh.positions));
        }
    }
    CubeSphere { mesh, cells, grids }
}

/// Where grid line `i` of `cells` crosses a face, −1 … 1: at equal angles from the centre.
pub fn grid_line(i: u32, cells: u32) -> f64 {
    match i {
        0 => -1.0,
        _ if i == cells => 1.0,
        _ => {
            let share = (2.0 * f64::from(i) - f64::from(cells)) / f64::from(cells);
            libm::tan(std::f64::consts::FRAC_PI_4 * share)
        }
    }
}

/// A name of the vertex that is the same on all faces that have it.
fn lattice(face: CubeFace, i: u32, j: u32, cells: u32) -> [i64; 3] {
    let line = |i: u32| (2 * i64::from(i) - i64::from(cells)) as f64;
    let [right, down, out] = face.axes();
    let point = right * line(i) + down * line(j) + out * f64::from(cells);
    point.to_array().map(|along| along as i64)
}

/// A quad, counter-clockwise from outside, as two triangles along its shorter diagonal.
fn halves([a, b, c, d]: [u32; 4], positions: &[DVec3]) -> [[u32; 3]; 2] {
    let across = |p: u32, q: u32| positions[p as usize].distance_squared(positions[q as usize]);
    if across(a, c) <= across(b, d) {
        [[a, b, c], [a, c, d]]
    } else {
        [[a, b, d], [b, c, d]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Cancel;
    use crate::crown::radius_cubemap;

    fn bumpy(size: u32) -> Cubemap<f32> {
        Cubemap::from_directions(size, |d| {
            let d = d.normalize();
            (2.0 + 0.3 * libm::sin(4.0 * d.x + 2.0 * d.y) * libm::cos(3.0 * d.z)) as f32
        })
    }

    #[test]
    fn the_mesh_is_a_sphere_in_topology_and_turned_outwards() {
        for cells in [1, 2, 7] {
            let mesh = cube_sphere(&bumpy(16), DVec3::new(1.0, 5.0, 2.0), cells).mesh;
            let mut edges = BTreeMap::new();
            for [a, b, c] in &mesh.triangles {
                for (from, to) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((*from, *to)).or_insert(0) += 1;
                }
            }
            assert!(
                edges
                    .iter()
                    .all(|(&(a, b), &n)| n == 1 && edges.contains_key(&(b, a)))
            );
            let euler =
                mesh.positions.len() as i64 - edges.len() as i64 / 2 + mesh.triangles.len() as i64;
            assert_eq!(euler, 2);
            let volume: f64 = mesh
                .triangles
                .iter()
                .map(|t| t.map(|i| mesh.positions[i as usize]))
                .map(|[a, b, c]| a.dot(b.cross(c)) / 6.0)
                .sum();
            assert!(volume > 0.0);
        }
    }

    #[test]
    fn radii_come_back_from_the_mesh() {
        let center = DVec3::new(0.0, 3.0, 0.0);
        let radius = bumpy(64);
        let mesh = cube_sphere(&radius, center, 64).mesh;
        let back = radius_cubemap(&mesh, center, 64, &Cancel::new()).unwrap();
        for (face, other) in back.faces().iter().zip(radius.faces()) {
            for (found, expected) in face.pixels().iter().zip(other.pixels()) {
                assert!((found - expected).abs() < 5e-3, "{found} {expected}");
            }
        }
    }
}
