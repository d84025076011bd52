//! A mesh as engines take it: lists of numbers in single precision, one entry a vertex.

use crate::geometry::Mesh;
use glam::DVec3;

/// A mesh for an engine; all lists that are not empty have one entry a vertex.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelMesh {
    /// In metres.
    pub positions: Vec<[f32; 3]>,
    /// Of unit length.
    pub normals: Vec<[f32; 3]>,
    /// Unit vector along the picture's x, and the sign of the bitangent; none where no normal map is
    /// used.
    pub tangents: Vec<[f32; 4]>,
    /// (0, 0) top left; none where there is no picture.
    pub uvs: Vec<[f32; 2]>,
    /// Edge flutter, phase, sway; each 0 … 1. None for what no wind moves.
    pub wind: Vec<[f32; 3]>,
    /// Three a triangle, counter-clockwise as seen from the front.
    pub indices: Vec<u32>,
}

impl From<&Mesh> for ModelMesh {
    /// The mesh with its [`Mesh::vertex_normals`] and nothing else.
    fn from(mesh: &Mesh) -> Self {
        Self {
            positions: singles(&mesh.positions),
            normals: singles(&mesh.vertex_normals()),
            indices: mesh.triangles.as_flattened().to_vec(),
            ..Self::default()
        }
    }
}

impl ModelMesh {
    /// The smallest and largest coordinates of the vertices.
    pub(super) fn bounds(&self) -> [[f32; 3]; 2] {
        let mut bounds = [[f32::MAX; 3], [f32::MIN; 3]];
        for position in &self.positions {
            for (axis, &value) in position.iter().enumerate() {
                bounds[0][axis] = bounds[0][axis].min(value);
                bounds[1][axis] = bounds[1][axis].max(value);
            }
        }
        bounds
    }

    /// What does not fit the number of vertices, if anything.
    pub(super) fn misfit(&self) -> Option<&'static str> {
        let count = self.positions.len();
        let fits = |entries: usize| entries == 0 || entries == count;
        let lists = [
            (self.normals.len() == count, "normals"),
            (fits(self.tangents.len()), "tangents"),
            (fits(self.uvs.len()), "texture coordinates"),
            (fits(self.wind.len()), "wind weights"),
            (
                self.indices.len().is_multiple_of(3)
                    && self.indices.iter().all(|&index| (index as usize) < count),
                "triangles",
            ),
        ];
        let misfit = lists.iter().find(|(fits, _)| !fits);
        misfit.map(|&(_, what)| what)
    }

    /// Whether all positions and normals are numbers.
    pub(super) fn is_finite(&self) -> bool {
        let lists = [&self.positions, &self.normals];
        lists
            .iter()
            .all(|list| list.as_flattened().iter().all(|value| value.is_finite()))
    }
}

/// Vectors in single precision.
pub(super) fn singles(values: &[DVec3]) -> Vec<[f32; 3]> {
    values.iter().map(|v| v.as_vec3().to_array()).collect()
}
