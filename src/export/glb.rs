//! Binary glTF 2.0 (Khronos, 2021): one file with meshes, normals, texture coordinates, colours and
//! textures, in metres, +Y up.
//!
//! One buffer, each run of numbers aligned to four bytes and in its own view; positions carry their
//! bounds, as the format demands. One node, mesh and material a part. Numbers are written in single
//! precision.

use crate::geometry::Mesh;
use glam::DVec3;
use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::material::{PbrBaseColorFactor, PbrMetallicRoughness, StrengthFactor};
use gltf_json::mesh::{Mode, Primitive, Semantic};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Image, Index, Material, Node, Root, Scene, Texture, texture};
use std::collections::BTreeMap;

/// What one mesh of a file is made of.
#[derive(Debug, Clone, Copy)]
pub struct MeshParts<'a> {
    /// Its name in the file.
    pub name: &'a str,
    /// Vertices and triangles, metres. Vertices without triangles are written too.
    pub mesh: &'a Mesh,
    /// Unit normals, one a vertex; `None`: those of [`Mesh::vertex_normals`].
    pub normals: Option<&'a [DVec3]>,
    /// Texture coordinates, one a vertex, origin at the top left of the picture.
    pub uvs: Option<&'a [[f32; 2]]>,
    /// Linear colours with alpha, one a vertex, that multiply the base colour.
    pub colors: Option<&'a [[u8; 4]]>,
    /// Linear colour with alpha that all else is multiplied by.
    pub base_color: [f32; 4],
    /// A PNG file for the base colour; needs `uvs`.
    pub base_color_png: Option<&'a [u8]>,
}

impl<'a> MeshParts<'a> {
    /// A white mesh.
    pub fn new(name: &'a str, mesh: &'a Mesh) -> Self {
        Self {
            name,
            mesh,
            normals: None,
            uvs: None,
            colors: None,
            base_color: [1.0; 4],
            base_color_png: None,
        }
    }
}

/// Why something cannot become a glTF file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GlbError {
    /// A mesh without triangles: glTF has no place for it.
    #[error("mesh '{0}' has no triangles")]
    Empty(String),
    /// Not one value a vertex, or an index of no vertex.
    #[error("mesh '{name}': {what} do not fit its {vertices} vertices")]
    Misfit {
        /// The mesh.
        name: String,
        /// What.
        what: &'static str,
        /// Number of vertices.
        vertices: usize,
    },
    /// A number that is infinite, none at all, or too large for single precision.
    #[error("mesh '{0}' has numbers that are not finite")]
    NotFinite(String),
    /// More than the four gigabytes that the format can count.
    #[error("the file would be larger than the 4 GiB of the format")]
    TooLarge,
}

/// `parts` as the bytes of a `.glb` file.
///
/// # Errors
/// [`GlbError`].
pub fn glb(parts: &[MeshParts<'_>]) -> Result<Vec<u8>, GlbError> {
    let mut writer = Writer::default();
    let mut nodes = Vec::new();
    for part in parts {
        check(part)?;
        nodes.push(writer.add_part(part)?);
    }
    writer.finish(nodes)
}

fn check(part: &MeshParts<'_>) -> Result<(), GlbError> {
    let vertices = part.mesh.positions.len();
    if part.mesh.triangles.is_empty() {
        return Err(GlbError::Empty(part.name.to_owned()));
    }
    let used = part.mesh.triangles.as_flattened();
    let fits = |count: Option<usize>| count.is_none_or(|count| count == vertices);
    let checks = [
        (
            "triangles",
            used.iter().all(|&vertex| (vertex as usize) < vertices),
        ),
        ("normals", fits(part.normals.map(<[_]>::len))),
        ("texture coordinates", fits(part.uvs.map(<[_]>::len))),
        ("colours", fits(part.colors.map(<[_]>::len))),
        (
            "no texture coordinates",
            part.base_color_png.is_none() || part.uvs.is_some(),
        ),
    ];
    match checks.iter().find(|(_, fits)| !fits) {
        Some(&(what, _)) => Err(GlbError::Misfit {
            name: part.name.to_owned(),
            what,
            vertices,
        }),
        None => Ok(()),
    }
}

#[derive(Default)]
struct Writer {
    root: Root,
    bytes: Vec<u8>,
}

impl Writer {
    fn add_part(&mut self, part: &MeshParts<'_>) -> Result<Index<Node>, GlbError> {
        let finite =
            |values: Vec<[f32; 3]>| match values.as_flattened().iter().all(|v| v.is_finite()) {
                true => Ok(values),
                false => Err(GlbError::NotFinite(part.name.to_owned())),
            };
        let positions = finite(singles(&part.mesh.positions))?;
        let normals = match part.normals {
            Some(normals) => finite(singles(normals))?,
            None => singles(&part.mesh.vertex_normals()),
        };
        let mut attributes = BTreeMap::new();
        let mut add = |semantic, accessor| attributes.insert(Checked::Valid(semantic), accessor);
        add(Semantic::Positions, self.add_positions(&positions));
        add(
            Semantic::Normals,
            self.add_floats(normals.as_flattened(), Type::Vec3),
        );
        if let Some(uvs) = part.uvs {
            add(
                Semantic::TexCoords(0),
                self.add_floats(uvs.as_flattened(), Type::Vec2),
            );
        }
        if let Some(colors) = part.colors {
            add(Semantic::Colors(0), self.add_colors(colors));
        }
        let indices = self.add_indices(part.mesh);
        let material = self.add_material(part);
        let primitive = Primitive {
            attributes,
            extensions: None,
            extras: None,
            indices: Some(indices),
            material: Some(material),
            mode: Checked::Valid(Mode::Triangles),
            targets: None,
        };
        let mesh = self.root.push(gltf_json::Mesh {
            extensions: None,
            extras: None,
            name: Some(part.name.to_owned()),
            primitives: vec![primitive],
            weights: None,
        });
        Ok(self.root.push(Node {
            mesh: Some(mesh),
            name: Some(part.name.to_owned()),
            ..Node::default()
        }))
    }

    /// Adds bytes to the buffer, aligned to four.
    fn add_view(&mut self, bytes: &[u8], target: Option<Target>) -> Index<View> {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.root.push(View {
            buffer: Index::new(0),
            byte_length: USize64::from(bytes.len()),
            byte_offset: Some(USize64::from(offset)),
            byte_stride: None,
            name: None,
            target: target.map(Checked::Valid),
            extensions: None,
            extras: None,
        })
    }

    fn accessor(view: Index<View>, count: usize, component: ComponentType, kind: Type) -> Accessor {
        Accessor {
            buffer_view: Some(view),
            byte_offset: None,
            count: USize64::from(count),
            component_type: Checked::Valid(GenericComponentType(component)),
            extensions: None,
            extras: None,
            type_: Checked::Valid(kind),
            min: None,
            max: None,
            name: None,
            normalized: false,
            sparse: None,
        }
    }

    fn add_positions(&mut self, positions: &[[f32; 3]]) -> Index<Accessor> {
        let fold = |from: f32, pick: fn(f32, f32) -> f32| {
            let axis = |i: usize| positions.iter().fold(from, |bound, p| pick(bound, p[i]));
            serde_json::json!([axis(0), axis(1), axis(2)])
        };
        let (min, max) = (
            fold(f32::INFINITY, f32::min),
            fold(f32::NEG_INFINITY, f32::max),
        );
        let index = self.add_floats(positions.as_flattened(), Type::Vec3);
        let accessor = &mut self.root.accessors[index.value()];
        (accessor.min, accessor.max) = (Some(min), Some(max));
        index
    }

    fn add_floats(&mut self, values: &[f32], kind: Type) -> Index<Accessor> {
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        let view = self.add_view(&bytes, Some(Target::ArrayBuffer));
        let components = if kind == Type::Vec2 { 2 } else { 3 };
        self.root.push(Self::accessor(
            view,
            values.len() / components,
            ComponentType::F32,
            kind,
        ))
    }

    fn add_colors(&mut self, colors: &[[u8; 4]]) -> Index<Accessor> {
        let view = self.add_view(colors.as_flattened(), Some(Target::ArrayBuffer));
        let accessor = Self::accessor(view, colors.len(), ComponentType::U8, Type::Vec4);
        self.root.push(Accessor {
            normalized: true,
            ..accessor
        })
    }

    /// Adds the triangles, in 16 bits where the number of vertices allows.
    fn add_indices(&mut self, mesh: &Mesh) -> Index<Accessor> {
        let indices = mesh.triangles.as_flattened();
        // The largest 16-bit index is reserved.
        let (bytes, component): (Vec<u8>, _) = if mesh.positions.len() < usize::from(u16::MAX) {
            let short = indices
                .iter()
                .flat_map(|&index| (index as u16).to_le_bytes());
            (short.collect(), ComponentType::U16)
        } else {
            let long = indices.iter().flat_map(|index| index.to_le_bytes());
            (long.collect(), ComponentType::U32)
        };
        let view = self.add_view(&bytes, Some(Target::ElementArrayBuffer));
        self.root
            .push(Self::accessor(view, indices.len(), component, Type::Scalar))
    }

    fn add_material(&mut self, part: &MeshParts<'_>) -> Index<Material> {
        let texture = part.base_color_png.map(|png| texture::Info {
            index: self.add_texture(png),
            tex_coord: 0,
            extensions: None,
            extras: None,
        });
        self.root.push(Material {
            name: Some(part.name.to_owned()),
            pbr_metallic_roughness: PbrMetallicRoughness {
                base_color_factor: PbrBaseColorFactor(part.base_color),
                base_color_texture: texture,
                metallic_factor: StrengthFactor(0.0),
                roughness_factor: StrengthFactor(1.0),
                ..PbrMetallicRoughness::default()
            },
            ..Material::default()
        })
    }

    fn add_texture(&mut self, png: &[u8]) -> Index<Texture> {
        let view = self.add_view(png, None);
        let source = self.root.push(Image {
            buffer_view: Some(view),
            mime_type: Some(gltf_json::image::MimeType("image/png".to_owned())),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let sampler = self.root.push(texture::Sampler {
            mag_filter: Some(Checked::Valid(texture::MagFilter::Linear)),
            min_filter: Some(Checked::Valid(texture::MinFilter::LinearMipmapLinear)),
            wrap_s: Checked::Valid(texture::WrappingMode::ClampToEdge),
            wrap_t: Checked::Valid(texture::WrappingMode::ClampToEdge),
            ..texture::Sampler::default()
        });
        self.root.push(Texture {
            name: None,
            sampler: Some(sampler),
            source,
            extensions: None,
            extras: None,
        })
    }

    /// Header, JSON padded with spaces, buffer.
    fn finish(mut self, nodes: Vec<Index<Node>>) -> Result<Vec<u8>, GlbError> {
        let scene = self.root.push(Scene {
            extensions: None,
            extras: None,
            name: None,
            nodes,
        });
        self.root.scene = Some(scene);
        self.root.asset.generator = Some(concat!("Boscage ", env!("CARGO_PKG_VERSION")).to_owned());
        self.root.push(gltf_json::Buffer {
            byte_length: USize64::from(self.bytes.len()),
            name: None,
            uri: None,
            extensions: None,
            extras: None,
        });
        let mut json = self
            .root
            .to_vec()
            .expect("numbers and names are always JSON");
        json.resize(json.len().next_multiple_of(4), b' ');
        let total = 12 + 8 + json.len() + 8 + self.bytes.len();
        let counted = |bytes: usize| u32::try_from(bytes).map_err(|_| GlbError::TooLarge);
        let mut file = Vec::with_capacity(total);
        file.extend(b"glTF");
        file.extend(2u32.to_le_bytes());
        file.extend(counted(total)?.to_le_bytes());
        for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &self.bytes)] {
            file.extend(counted(chunk.len())?.to_le_bytes());
            file.extend(kind);
            file.extend_from_slice(chunk);
        }
        Ok(file)
    }
}

fn singles(values: &[DVec3]) -> Vec<[f32; 3]> {
    values
        .iter()
        .map(|value| value.as_vec3().to_array())
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crown::cube_sphere;
    use crate::raster::{Compression, Cubemap, Straight, encode_png};

    #[test]
    fn a_file_reads_back_as_what_was_written() {
        let radius = Cubemap::from_directions(8, |d| (2.0 + 0.2 * d.x) as f32);
        let mesh = cube_sphere(&radius, DVec3::new(0.0, 5.0, 0.0), 4).mesh;
        let uvs: Vec<[f32; 2]> = mesh.positions.iter().map(|p| [p.x as f32, 0.5]).collect();
        let colors = vec![[10, 20, 30, 255]; mesh.positions.len()];
        let picture = crate::raster::Image::filled(4, 2, Straight([9, 8, 7, 255]));
        let png = encode_png(&picture, Compression::Small);
        let parts = MeshParts {
            uvs: Some(&uvs),
            colors: Some(&colors),
            base_color_png: Some(&png),
            ..MeshParts::new("crown", &mesh)
        };
        let file = glb(&[parts, MeshParts::new("plain", &mesh)]).unwrap();
        let (document, buffers, images) = gltf::import_slice(&file).unwrap();
        assert_eq!(document.nodes().count(), 2);
        assert_eq!((images[0].width, images[0].height), (4, 2));
        assert_eq!(images[0].pixels[..3], [9, 8, 7]);
        let meshes: Vec<_> = document.meshes().collect();
        assert_eq!(meshes[0].name(), Some("crown"));
        let primitive = meshes[0].primitives().next().unwrap();
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        let read: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
        assert_eq!(read, singles(&mesh.positions));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, mesh.triangles.as_flattened());
        let normals: Vec<[f32; 3]> = reader.read_normals().unwrap().collect();
        assert!(
            normals
                .iter()
                .all(|n| (n.iter().map(|c| c * c).sum::<f32>() - 1.0).abs() < 1e-6)
        );
        let read: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
        assert_eq!(read, uvs);
        let read: Vec<[u8; 4]> = reader.read_colors(0).unwrap().into_rgba_u8().collect();
        assert_eq!(read, colors);
        let bounds = primitive.bounding_box();
        let (low, high) = mesh.bounds().unwrap();
        assert_eq!(
            (bounds.min, bounds.max),
            (low.as_vec3().to_array(), high.as_vec3().to_array())
        );
        let material = primitive.material().pbr_metallic_roughness();
        assert!(material.base_color_texture().is_some());
        assert_eq!(file.len() % 4, 0);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let mesh = cube_sphere(&Cubemap::filled(4, 1.0), DVec3::ZERO, 2).mesh;
        let short = [[0.0; 2]; 3];
        let misfit = MeshParts {
            uvs: Some(&short),
            ..MeshParts::new("m", &mesh)
        };
        assert!(matches!(glb(&[misfit]), Err(GlbError::Misfit { .. })));
        let bare = MeshParts {
            base_color_png: Some(&[]),
            ..MeshParts::new("m", &mesh)
        };
        assert!(matches!(glb(&[bare]), Err(GlbError::Misfit { .. })));
        let empty = Mesh::default();
        assert!(matches!(
            glb(&[MeshParts::new("m", &empty)]),
            Err(GlbError::Empty(_))
        ));
        let infinite = mesh.moved(|p| p / 0.0);
        assert!(matches!(
            glb(&[MeshParts::new("m", &infinite)]),
            Err(GlbError::NotFinite(_))
        ));
    }
}
