//! Triangle meshes: their bounds, volume, normals, and their place in space.

use glam::DVec3;

/// Triangles over shared vertices.
///
/// Triangles are counter-clockwise as seen from outside, in a right-handed frame. Vertices that no
/// triangle uses are allowed; they take no part in bounds, topology or files for viewers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// The vertices.
    pub positions: Vec<DVec3>,
    /// Indices of `positions`, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|vertex| self.positions[vertex as usize])
    }

    /// The smallest and largest coordinates of the vertices in use, `None` without triangles.
    ///
    /// ```
    /// use boscage::geometry::Mesh;
    /// use glam::DVec3;
    /// let positions = vec![DVec3::splat(9.0), DVec3::ZERO, DVec3::X, 2.0 * DVec3::Y];
    /// let mesh = Mesh { positions, triangles: vec![[1, 2, 3]] };
    /// assert_eq!(mesh.bounds(), Some((DVec3::ZERO, DVec3::new(1.0, 2.0, 0.0))));
    /// ```
    pub fn bounds(&self) -> Option<(DVec3, DVec3)> {
        let corners = self.triangles.iter().flat_map(|&t| self.corners(t));
        corners.fold(None, |bounds, point| match bounds {
            None => Some((point, point)),
            Some((low, high)) => Some((low.min(point), high.max(point))),
        })
    }

    /// The volume inside, in cubed units of the positions; negative when the triangles of a closed
    /// mesh are the wrong way round.
    pub fn volume(&self) -> f64 {
        let six_times = self.triangles.iter().map(|&triangle| {
            let [a, b, c] = self.corners(triangle);
            a.dot(b.cross(c))
        });
        six_times.sum::<f64>() / 6.0
    }

    /// Unit normals of the vertices, pointing outwards: those of the triangles around, weighted by
    /// the angle that each takes (Thürmer & Wüthrich, *Computing vertex normals from polygonal
    /// facets*, 1998), so that they do not depend on how a flat part was divided.
    ///
    /// +Z for a vertex without triangles, or where they cancel out.
    pub fn vertex_normals(&self) -> Vec<DVec3> {
        let mut normals = vec![DVec3::ZERO; self.positions.len()];
        for &triangle in &self.triangles {
            let corners = self.corners(triangle);
            let normal = (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize_or_zero();
            for (i, &vertex) in triangle.iter().enumerate() {
                let here = corners[i];
                let to_next = (corners[(i + 1) % 3] - here).normalize_or_zero();
                let to_previous = (corners[(i + 2) % 3] - here).normalize_or_zero();
                let angle = libm::acos(to_next.dot(to_previous).clamp(-1.0, 1.0));
                normals[vertex as usize] += normal * angle;
            }
        }
        let unit = |normal: &DVec3| normal.try_normalize().unwrap_or(DVec3::Z);
        normals.iter().map(unit).collect()
    }

    /// The mesh with every vertex moved. A `change` that mirrors must be followed by
    /// [`Mesh::reversed`].
    #[must_use]
    pub fn moved(&self, change: impl Fn(DVec3) -> DVec3) -> Self {
        Self {
            positions: self.positions.iter().map(|&point| change(point)).collect(),
            triangles: self.triangles.clone(),
        }
    }

    /// The mesh with its triangles the other way round.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
        self
    }

    /// The mesh without the vertices that no triangle uses; the others keep their order.
    #[must_use]
    pub fn without_unused(&self) -> Self {
        const UNUSED: u32 = u32::MAX;
        let mut new_index = vec![UNUSED; self.positions.len()];
        for &vertex in self.triangles.as_flattened() {
            new_index[vertex as usize] = 0;
        }
        let mut positions = Vec::new();
        for (index, &position) in new_index.iter_mut().zip(&self.positions) {
            if *index != UNUSED {
                *index = positions.len() as u32;
                positions.push(position);
            }
        }
        let renamed = |t: &[u32; 3]| t.map(|vertex| new_index[vertex as usize]);
        Self {
            positions,
            triangles: self.triangles.iter().map(renamed).collect(),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// The corner of a cube cut off: right angles at the origin, legs of 1.
    pub(in crate::geometry) fn tetrahedron() -> Mesh {
        Mesh {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
            triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
        }
    }

    /// `a` and `b` side by side: no vertex is shared.
    pub(in crate::geometry) fn beside(a: &Mesh, b: &Mesh) -> Mesh {
        let offset = a.positions.len() as u32;
        let shifted = b.triangles.iter().map(|t| t.map(|v| v + offset));
        Mesh {
            positions: [&a.positions[..], &b.positions].concat(),
            triangles: a.triangles.iter().copied().chain(shifted).collect(),
        }
    }

    #[test]
    fn volume_has_the_sign_of_the_orientation() {
        let mesh = tetrahedron();
        assert!((mesh.volume() - 1.0 / 6.0).abs() < 1e-15);
        assert!((mesh.clone().reversed().volume() + 1.0 / 6.0).abs() < 1e-15);
        let mirrored = mesh.moved(|p| DVec3::new(p.x, -p.y, p.z)).reversed();
        assert!((mirrored.volume() - 1.0 / 6.0).abs() < 1e-15);
    }

    #[test]
    fn normals_point_outwards_and_ignore_how_a_face_is_divided() {
        let mut mesh = tetrahedron();
        let whole = mesh.vertex_normals();
        assert!(whole[0].abs_diff_eq(DVec3::splat(-1.0).normalize(), 1e-12));
        // The slanted face in two, and a vertex of no use.
        mesh.positions.push((DVec3::X + DVec3::Y) / 2.0);
        mesh.positions.push(DVec3::splat(7.0));
        mesh.triangles[3] = [1, 4, 3];
        mesh.triangles.push([4, 2, 3]);
        let divided = mesh.vertex_normals();
        assert!(divided[3].abs_diff_eq(whole[3], 1e-12));
        assert_eq!(divided[5], DVec3::Z);
    }

    #[test]
    fn unused_vertices_go_and_the_rest_keep_their_order() {
        let mut mesh = tetrahedron();
        let unused = Mesh {
            positions: vec![DVec3::ONE],
            triangles: Vec::new(),
        };
        let spaced = beside(&unused, &mesh);
        assert_eq!(spaced.without_unused(), mesh);
        mesh.triangles.clear();
        assert_eq!(mesh.bounds(), None);
    }
}
