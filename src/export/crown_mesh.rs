//! A crown as a textured mesh that any viewer opens: its radius with the relief in it as a
//! [`CubeSphere`], its colours as an [`atlas`].
//!
//! Vertices on the cube's edges stand once for each face, since their texture coordinates differ;
//! positions and normals are those of the closed mesh, so that no edge shows.

use super::atlas::{AtlasLayout, atlas};
use super::glb::{Glb, GlbError, Material};
use super::model_mesh::{ModelMesh, singles};
use crate::crown::{CubeSphere, cube_sphere, grid_line};
use crate::raster::{Compression, CubeFace, encode_opaque_png};
use crate::scene::Crown;

/// Cells along a face: two texels each, and 100,000 triangles at most. Colour carries the detail
/// below that.
const TEXELS_OF_CELL: u32 = 2;

/// Most cells along a face.
const MOST_CELLS: u32 = 96;

/// `crown` as the bytes of a `.glb` file: metres, the tree's base at the origin.
///
/// # Errors
/// [`GlbError`], for radii that are not finite.
pub fn crown_glb(crown: &Crown) -> Result<Vec<u8>, GlbError> {
    let cells = (crown.color.size() / TEXELS_OF_CELL).clamp(8, MOST_CELLS);
    let sphere = cube_sphere(&crown.radius_m, crown.center_m, cells);
    let mesh = divided(&sphere, AtlasLayout::new(crown.color.size()));
    // Fast: the smaller file would take seconds at 1024 texels, in which nobody could cancel.
    let png = encode_opaque_png(&atlas(&crown.color), Compression::Fast);
    let mut glb = Glb::new(None);
    let material = glb.material(&Material {
        albedo: Some(&png),
        ..Material::white("crown")
    });
    let mesh = glb.mesh("crown", &mesh, material, false);
    let node = glb.node("crown", mesh);
    glb.show(node);
    glb.into_bytes()
}

/// The mesh with its vertices standing once for each face that has them, their normals and their
/// texture coordinates.
pub(super) fn divided(sphere: &CubeSphere, layout: AtlasLayout) -> ModelMesh {
    let welded = singles(&sphere.mesh.vertex_normals());
    let positions = singles(&sphere.mesh.positions);
    let mut mesh = ModelMesh::default();
    let line = sphere.cells + 1;
    let triangles_of_face = sphere.mesh.triangles.len() / CubeFace::ALL.len();
    let faces = sphere.mesh.triangles.chunks(triangles_of_face);
    for ((face, grid), triangles) in CubeFace::ALL.into_iter().zip(&sphere.grids).zip(faces) {
        let first = mesh.positions.len() as u32;
        let mut places = vec![0; positions.len()];
        for (at, &vertex) in (0u32..).zip(grid) {
            places[vertex as usize] = first + at;
            mesh.positions.push(positions[vertex as usize]);
            mesh.normals.push(welded[vertex as usize]);
            let [u, v] = [at % line, at / line].map(|i| grid_line(i, sphere.cells));
            mesh.uvs.push(layout.texture_coordinates(face, u, v));
        }
        let corners = triangles.as_flattened().iter();
        mesh.indices
            .extend(corners.map(|&vertex| places[vertex as usize]));
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::{Cubemap, Straight};
    use glam::DVec3;

    #[test]
    fn the_file_opens_and_its_texture_shows_the_colour_of_each_direction() {
        let shade = |d: DVec3| (d.normalize() * 100.0 + 128.0).to_array().map(|c| c as u8);
        let crown = Crown {
            radius_m: Cubemap::from_directions(32, |d| (2.0 + 0.2 * d.x) as f32),
            color: Cubemap::from_directions(32, |d| {
                let [r, g, b] = shade(d);
                Straight([r, g, b, 255])
            }),
            ..Crown::ball(32)
        };
        let bytes = crown_glb(&crown).unwrap();
        let (document, buffers, images) = gltf::import_slice(&bytes).unwrap();
        let primitive = document
            .meshes()
            .next()
            .unwrap()
            .primitives()
            .next()
            .unwrap();
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        let image = &images[0];
        let channels = image.pixels.len() / (image.width * image.height) as usize;
        for (position, [s, t]) in reader.read_positions().unwrap().zip(uvs) {
            let x = ((s * image.width as f32) as u32).min(image.width - 1);
            let y = ((t * image.height as f32) as u32).min(image.height - 1);
            let at = (y * image.width + x) as usize * channels;
            let place = DVec3::from_array(position.map(f64::from));
            for (found, expected) in image.pixels[at..].iter().zip(shade(place - crown.center_m)) {
                assert!(found.abs_diff(expected) <= 10, "{place}");
            }
        }
    }
}
