//! Triangle meshes.

use glam::DVec3;

/// Triangles over shared vertices.
///
/// Triangles are counter-clockwise as seen from outside.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// The vertices.
    pub positions: Vec<DVec3>,
    /// Indices of `positions`, three a triangle.
    pub triangles: Vec<[u32; 3]>,
}
