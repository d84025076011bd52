//! Triangle meshes as binary PLY files, and back: what a crown keeps its base mesh in.
//!
//! Little-endian, vertices of three floats, faces of a byte (3) and three whole numbers: what
//! Blender, MeshLab and most libraries write. Only this kind is read back.

use crate::geometry::Mesh;
use glam::DVec3;

/// Why some bytes are no mesh.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PlyError {
    /// The header is not one that [`encode_ply`] writes.
    #[error("not a binary PLY file with x, y, z and triangles")]
    Header,
    /// The file ends too early or goes on behind its end.
    #[error("its length is not that of {vertices} vertices and {triangles} triangles")]
    Length {
        /// Number of vertices the header tells.
        vertices: u64,
        /// Number of triangles the header tells.
        triangles: u64,
    },
    /// A vertex is not finite, a face is no triangle or names a vertex that is not there.
    #[error("its {element} {index} is not valid")]
    Content {
        /// `vertex` or `face`.
        element: &'static str,
        /// Which one, from 0.
        index: usize,
    },
}

const VERTEX_BYTES: u64 = 12;
const FACE_BYTES: u64 = 13;

fn header(vertices: u64, triangles: u64) -> String {
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\n\
         property float y\nproperty float z\nelement face {triangles}\n\
         property list uchar uint vertex_indices\nend_header\n"
    )
}

/// `mesh` as the bytes of a PLY file; positions are rounded to single precision.
pub fn encode_ply(mesh: &Mesh) -> Vec<u8> {
    let header = header(mesh.positions.len() as u64, mesh.triangles.len() as u64);
    let mut bytes = header.into_bytes();
    for position in &mesh.positions {
        for along in position.to_array() {
            bytes.extend((along as f32).to_le_bytes());
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|index| index.to_le_bytes()));
    }
    bytes
}

/// The mesh in `bytes`, a file as [`encode_ply`] writes them.
///
/// ```
/// use boscage::{export::{decode_ply, encode_ply}, geometry::Mesh};
/// use glam::DVec3;
/// let mesh = Mesh { positions: vec![DVec3::X, DVec3::Y, DVec3::Z], triangles: vec![[0, 1, 2]] };
/// assert_eq!(decode_ply(&encode_ply(&mesh)).unwrap(), mesh);
/// ```
///
/// # Errors
/// [`PlyError`].
pub fn decode_ply(bytes: &[u8]) -> Result<Mesh, PlyError> {
    let (vertices, triangles, body) = counts(bytes).ok_or(PlyError::Header)?;
    let wrong_length = PlyError::Length {
        vertices,
        triangles,
    };
    let vertex_bytes = vertices.checked_mul(VERTEX_BYTES);
    let face_bytes = triangles.checked_mul(FACE_BYTES);
    let whole = vertex_bytes
        .zip(face_bytes)
        .and_then(|(vertices, faces)| vertices.checked_add(faces));
    if whole != Some(body.len() as u64) {
        return Err(wrong_length);
    }
    let (vertex_bytes, face_bytes) = body.split_at((vertices * VERTEX_BYTES) as usize);
    let word = |bytes: &[u8]| [bytes[0], bytes[1], bytes[2], bytes[3]];
    let positions: Vec<DVec3> = vertex_bytes
        .chunks_exact(VERTEX_BYTES as usize)
        .map(|vertex| {
            let along = |i: usize| f64::from(f32::from_le_bytes(word(&vertex[4 * i..])));
            DVec3::new(along(0), along(1), along(2))
        })
        .collect();
    let triangles: Vec<[u32; 3]> = face_bytes
        .chunks_exact(FACE_BYTES as usize)
        .map(|face| [1, 5, 9].map(|at| u32::from_le_bytes(word(&face[at..]))))
        .collect();
    let bad_vertex = positions.iter().position(|p| !p.is_finite());
    let is_bad = |face: (&[u8], &[u32; 3])| {
        face.0[0] != 3 || face.1.iter().any(|&index| u64::from(index) >= vertices)
    };
    let faces = face_bytes.chunks_exact(FACE_BYTES as usize);
    let bad_face = faces.zip(&triangles).position(is_bad);
    let bad = [("vertex", bad_vertex), ("face", bad_face)];
    match bad
        .into_iter()
        .find_map(|(element, at)| Some((element, at?)))
    {
        Some((element, index)) => Err(PlyError::Content { element, index }),
        None => Ok(Mesh {
            positions,
            triangles,
        }),
    }
}

/// Number of vertices and triangles that the header tells, and what follows it.
fn counts(bytes: &[u8]) -> Option<(u64, u64, &[u8])> {
    /// Longer than any header with two numbers.
    const LONGEST: usize = 300;
    const END: &[u8] = b"end_header\n";
    let head = &bytes[..bytes.len().min(LONGEST)];
    let end = head.windows(END.len()).position(|window| window == END)? + END.len();
    let text = std::str::from_utf8(&bytes[..end]).ok()?;
    let count = |element: &str| {
        let line = text.lines().find_map(|line| line.strip_prefix(element))?;
        line.trim().parse::<u64>().ok()
    };
    let (vertices, triangles) = (count("element vertex ")?, count("element face ")?);
    (text == header(vertices, triangles)).then_some((vertices, triangles, &bytes[end..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_files_are_refused_and_never_panic() {
        let mesh = Mesh {
            positions: vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
        };
        let whole = encode_ply(&mesh);
        for end in 0..whole.len() {
            assert!(decode_ply(&whole[..end]).is_err(), "cut at {end}");
        }
        for at in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[at] ^= 0xff;
            let _ = decode_ply(&damaged);
        }
        let mut beyond = whole.clone();
        let last = beyond.len() - 1;
        beyond[last] = 1;
        let error = decode_ply(&beyond).unwrap_err();
        assert_eq!(
            error,
            PlyError::Content {
                element: "face",
                index: 1
            }
        );
    }
}
