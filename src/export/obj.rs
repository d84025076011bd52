//! Wavefront OBJ: text that every modelling program reads. Positions and faces; nothing else.

use crate::geometry::Mesh;
use std::fmt::Write as _;

/// `mesh` as an OBJ file with `comments` at its top. All vertices are written, also those that no
/// triangle uses, with as many digits as bring the same numbers back.
///
/// ```
/// use boscage::{export::obj, geometry::Mesh};
/// use glam::DVec3;
/// let mesh = Mesh { positions: vec![DVec3::ZERO, DVec3::X, 0.1 * DVec3::Y], triangles: vec![[0, 1, 2]] };
/// let text = String::from_utf8(obj(&mesh, &["a leaf"])).unwrap();
/// assert_eq!(text, "# a leaf\ns 1\nv 0 0 0\nv 1 0 0\nv 0 0.1 0\nf 1 2 3\n");
/// ```
pub fn obj(mesh: &Mesh, comments: &[&str]) -> Vec<u8> {
    let mut text = String::with_capacity(mesh.positions.len() * 60 + mesh.triangles.len() * 24);
    let bug = "a String takes everything";
    for comment in comments {
        writeln!(text, "# {}", comment.replace(['\r', '\n'], " ")).expect(bug);
    }
    // One smoothing group: viewers shade the crown round.
    text.push_str("s 1\n");
    for p in &mesh.positions {
        writeln!(text, "v {} {} {}", p.x + 0.0, p.y + 0.0, p.z + 0.0).expect(bug);
    }
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| vertex + 1);
        writeln!(text, "f {a} {b} {c}").expect(bug);
    }
    text.into_bytes()
}
