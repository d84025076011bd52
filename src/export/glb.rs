//! glTF 2.0 in its binary form: one file with scene, geometry and pictures.
//!
//! The JSON is put together as plain values rather than through typed structures: half of what is
//! written here are extensions (`MSFT_lod`, `EXT_mesh_gpu_instancing`) and custom attributes, which
//! the typed crates do not know. Frame: +Y up, front +Z, metres, texture coordinates from the top
//! left, counter-clockwise triangles.

use super::model_mesh::ModelMesh;
use serde_json::{Map, Value, json};

/// `ARRAY_BUFFER` and `ELEMENT_ARRAY_BUFFER`.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;

/// `FLOAT`, `UNSIGNED_SHORT`, `UNSIGNED_INT`.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;

/// `LINEAR`, `LINEAR_MIPMAP_LINEAR`, `CLAMP_TO_EDGE`.
const LINEAR: u32 = 9729;
const TRILINEAR: u32 = 9987;
const CLAMP: u32 = 33071;

/// How KTX2 files start.
const KTX2_START: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";

/// A mesh of a [`Glb`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MeshId(usize);

/// A node of a [`Glb`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NodeId(usize);

/// A rough material without metal; its back is not drawn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material<'a> {
    /// Its name.
    pub name: &'a str,
    /// Linear colour and alpha that the picture is multiplied by.
    pub color: [f32; 4],
    /// Colour and alpha, a PNG file or a KTX2 file of UASTC; so are all pictures.
    pub albedo: Option<&'a [u8]>,
    /// Normal map with Y+.
    pub normal: Option<&'a [u8]>,
    /// Ambient occlusion in its red channel.
    pub occlusion: Option<&'a [u8]>,
    /// Whether alpha means nothing; otherwise the material is a cut-out: alpha test at 0.5.
    pub is_solid: bool,
}

impl<'a> Material<'a> {
    /// White and solid, without pictures.
    pub fn white(name: &'a str) -> Self {
        Self {
            name,
            color: [1.0; 4],
            albedo: None,
            normal: None,
            occlusion: None,
            is_solid: true,
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

/// A place for a copy of a mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Position of the foot, in metres.
    pub translation: [f32; 3],
    /// Turn about +Y, in radians.
    pub yaw: f32,
    /// Size, 1 unchanged.
    pub scale: f32,
}

impl Instance {
    /// The turn as a quaternion (x, y, z, w).
    fn rotation(&self) -> [f32; 4] {
        let half = f64::from(self.yaw) / 2.0;
        [0.0, libm::sin(half) as f32, 0.0, libm::cos(half) as f32]
    }
}

/// A file being put together.
#[derive(Debug, Default)]
pub struct Glb {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
    materials: Vec<Value>,
    meshes: Vec<Value>,
    nodes: Vec<Value>,
    scene: Vec<usize>,
    used: Vec<&'static str>,
    required: Vec<&'static str>,
    asset: Map<String, Value>,
    /// The first thing that does not fit into the format; told at the end.
    failure: Option<GlbError>,
}

impl Glb {
    /// An empty file; `copyright` goes where viewers look for it.
    pub fn new(copyright: Option<&str>) -> Self {
        let mut asset = Map::new();
        asset.insert("version".to_owned(), json!("2.0"));
        let generator = concat!("boscage ", env!("CARGO_PKG_VERSION"));
        asset.insert("generator".to_owned(), json!(generator));
        if let Some(copyright) = copyright {
            asset.insert("copyright".to_owned(), json!(copyright));
        }
        Self {
            asset,
            ..Self::default()
        }
    }

    /// Adds a material; the answer goes to [`Glb::mesh`].
    pub fn material(&mut self, material: &Material<'_>) -> usize {
        let mut texture = |map: &str, file: &[u8]| {
            let name = format!("{}_{map}", material.name);
            self.texture(&name, file)
        };
        let albedo = material.albedo.map(|file| texture("albedo", file));
        let normal = material.normal.map(|file| texture("normal", file));
        let occlusion = material.occlusion.map(|file| texture("ao", file));
        // Bent normals are seen at angles that no surface has: there the usual 4 % of mirrored light
        // become a grey haze.
        let mut value = json!({
            "name": material.name,
            "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9},
            "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}},
        });
        self.uses("KHR_materials_specular");
        if material.color != [1.0; 4] {
            value["pbrMetallicRoughness"]["baseColorFactor"] = json!(material.color);
        }
        if let Some(albedo) = albedo {
            value["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": albedo});
        }
        if !material.is_solid {
            value["alphaMode"] = json!("MASK");
            value["alphaCutoff"] = json!(0.5);
        }
        if let Some(normal) = normal {
            value["normalTexture"] = json!({"index": normal});
        }
        if let Some(occlusion) = occlusion {
            value["occlusionTexture"] = json!({"index": occlusion});
        }
        self.materials.push(value);
        self.materials.len() - 1
    }

    /// Adds a mesh with the material that [`Glb::material`] gave; `colors` also writes the wind
    /// weights as vertex colours, which multiply the picture's where nobody knows of them.
    pub fn mesh(&mut self, name: &str, mesh: &ModelMesh, material: usize, colors: bool) -> MeshId {
        self.parts(name, &[(material, mesh)], colors)
    }

    /// Adds a mesh of several parts, each with its material; see [`Glb::mesh`].
    pub fn parts(&mut self, name: &str, parts: &[(usize, &ModelMesh)], colors: bool) -> MeshId {
        let primitives: Vec<Value> = parts
            .iter()
            .map(|&(material, mesh)| {
                self.check(name, mesh);
                self.primitive(mesh, material, colors)
            })
            .collect();
        self.meshes
            .push(json!({"name": name, "primitives": primitives}));
        MeshId(self.meshes.len() - 1)
    }

    fn check(&mut self, name: &str, mesh: &ModelMesh) {
        let failure = if mesh.indices.is_empty() {
            GlbError::Empty(name.to_owned())
        } else if let Some(what) = mesh.misfit() {
            let (name, vertices) = (name.to_owned(), mesh.positions.len());
            GlbError::Misfit {
                name,
                what,
                vertices,
            }
        } else if !mesh.is_finite() {
            GlbError::NotFinite(name.to_owned())
        } else {
            return;
        };
        self.failure.get_or_insert(failure);
    }

    fn primitive(&mut self, mesh: &ModelMesh, material: usize, colors: bool) -> Value {
        let mut attributes = Map::new();
        let mut attribute = |name: &str, accessor: usize| {
            attributes.insert(name.to_owned(), json!(accessor));
        };
        let positions = self.floats(&mesh.positions, "VEC3");
        let [least, most] = mesh.bounds();
        self.accessors[positions]["min"] = json!(least);
        self.accessors[positions]["max"] = json!(most);
        attribute("POSITION", positions);
        attribute("NORMAL", self.floats(&mesh.normals, "VEC3"));
        if !mesh.tangents.is_empty() {
            attribute("TANGENT", self.floats(&mesh.tangents, "VEC4"));
        }
        if !mesh.uvs.is_empty() {
            attribute("TEXCOORD_0", self.floats(&mesh.uvs, "VEC2"));
        }
        if !mesh.wind.is_empty() {
            let wind = self.floats(&mesh.wind, "VEC3");
            attribute("_WIND", wind);
            if colors {
                attribute("COLOR_0", wind);
            }
        }
        let indices = self.indices(&mesh.indices, mesh.positions.len());
        json!({
            "attributes": attributes,
            "indices": indices,
            "material": material,
            "mode": 4,
        })
    }

    /// Adds a node that shows `mesh` at the origin.
    pub fn node(&mut self, name: &str, mesh: MeshId) -> NodeId {
        self.add_node(json!({"name": name, "mesh": mesh.0}))
    }

    /// Adds a node that shows `mesh` at one place.
    pub fn placed_node(&mut self, name: &str, mesh: MeshId, place: &Instance) -> NodeId {
        let scale = [place.scale; 3];
        self.add_node(json!({
            "name": name,
            "mesh": mesh.0,
            "translation": place.translation,
            "rotation": place.rotation(),
            "scale": scale,
        }))
    }

    /// Adds a node that shows `mesh` at many places in one draw (`EXT_mesh_gpu_instancing`, which
    /// readers then must know).
    pub fn instanced_node(&mut self, name: &str, mesh: MeshId, places: &[Instance]) -> NodeId {
        let translations: Vec<[f32; 3]> = places.iter().map(|p| p.translation).collect();
        let rotations: Vec<[f32; 4]> = places.iter().map(Instance::rotation).collect();
        let scales: Vec<[f32; 3]> = places.iter().map(|p| [p.scale; 3]).collect();
        let attributes = json!({
            "TRANSLATION": self.plain_floats(&translations, "VEC3"),
            "ROTATION": self.plain_floats(&rotations, "VEC4"),
            "SCALE": self.plain_floats(&scales, "VEC3"),
        });
        self.requires("EXT_mesh_gpu_instancing");
        self.add_node(json!({
            "name": name,
            "mesh": mesh.0,
            "extensions": {"EXT_mesh_gpu_instancing": {"attributes": attributes}},
        }))
    }

    /// Adds a node with children.
    pub fn group(&mut self, name: &str, children: &[NodeId]) -> NodeId {
        let children: Vec<usize> = children.iter().map(|child| child.0).collect();
        self.add_node(json!({"name": name, "children": children}))
    }

    /// Makes `coarser` the levels of detail below `finest` (`MSFT_lod`); `coverage` is the share of
    /// the screen's height down to which each level serves, the finest first.
    pub fn levels_of_detail(&mut self, finest: NodeId, coarser: &[NodeId], coverage: &[f64]) {
        let ids: Vec<usize> = coarser.iter().map(|node| node.0).collect();
        self.uses("MSFT_lod");
        let node = &mut self.nodes[finest.0];
        node["extensions"] = json!({"MSFT_lod": {"ids": ids}});
        node["extras"] = json!({"MSFT_screencoverage": coverage});
    }

    /// Puts a node into the scene.
    pub fn show(&mut self, node: NodeId) {
        self.scene.push(node.0);
    }

    /// The file's bytes.
    ///
    /// # Errors
    /// [`GlbError`], for what was added or for all of it.
    pub fn into_bytes(mut self) -> Result<Vec<u8>, GlbError> {
        if let Some(failure) = self.failure {
            return Err(failure);
        }
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut root = Map::new();
        root.insert("asset".to_owned(), Value::Object(self.asset));
        root.insert("scene".to_owned(), json!(0));
        root.insert("scenes".to_owned(), json!([{"nodes": self.scene}]));
        let sampler = json!([{
            "magFilter": LINEAR, "minFilter": TRILINEAR, "wrapS": CLAMP, "wrapT": CLAMP
        }]);
        let samplers = if self.textures.is_empty() {
            json!([])
        } else {
            sampler
        };
        let lists = [
            ("nodes", json!(self.nodes)),
            ("meshes", json!(self.meshes)),
            ("materials", json!(self.materials)),
            ("textures", json!(self.textures)),
            ("samplers", samplers),
            ("images", json!(self.images)),
            ("accessors", json!(self.accessors)),
            ("bufferViews", json!(self.views)),
            ("buffers", json!([{"byteLength": self.bytes.len()}])),
            ("extensionsUsed", json!(self.used)),
            ("extensionsRequired", json!(self.required)),
        ];
        // The format allows no empty lists.
        let filled = lists.into_iter().filter(|(_, list)| *list != json!([]));
        root.extend(filled.map(|(name, list)| (name.to_owned(), list)));
        container(&Value::Object(root), &self.bytes)
    }

    fn add_node(&mut self, node: Value) -> NodeId {
        self.nodes.push(node);
        NodeId(self.nodes.len() - 1)
    }

    fn uses(&mut self, extension: &'static str) {
        if !self.used.contains(&extension) {
            self.used.push(extension);
        }
    }

    fn requires(&mut self, extension: &'static str) {
        self.uses(extension);
        if !self.required.contains(&extension) {
            self.required.push(extension);
        }
    }

    fn texture(&mut self, name: &str, file: &[u8]) -> usize {
        let view = self.view(file, None);
        let image = self.images.len();
        let is_ktx2 = file.starts_with(&KTX2_START);
        let kind = if is_ktx2 { "image/ktx2" } else { "image/png" };
        self.images
            .push(json!({"name": name, "mimeType": kind, "bufferView": view}));
        let texture = if is_ktx2 {
            const BASISU: &str = "KHR_texture_basisu";
            self.requires(BASISU);
            json!({"name": name, "sampler": 0, "extensions": {BASISU: {"source": image}}})
        } else {
            json!({"name": name, "sampler": 0, "source": image})
        };
        self.textures.push(texture);
        self.textures.len() - 1
    }

    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({
            "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()
        });
        if let Some(target) = target {
            view["target"] = json!(target);
        }
        self.bytes.extend(bytes);
        self.views.push(view);
        self.views.len() - 1
    }

    /// Floats that are vertices.
    fn floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let view = self.view(&little_endian(values), Some(VERTICES));
        self.accessor(view, FLOAT, values.len(), kind)
    }

    /// Floats that are no vertices.
    fn plain_floats<const N: usize>(&mut self, values: &[[f32; N]], kind: &str) -> usize {
        let view = self.view(&little_endian(values), None);
        self.accessor(view, FLOAT, values.len(), kind)
    }

    fn indices(&mut self, indices: &[u32], vertices: usize) -> usize {
        // 65535 restarts strips and is no index.
        let short = vertices <= usize::from(u16::MAX);
        let bytes: Vec<u8> = if short {
            let short = indices.iter().map(|&i| i as u16);
            short.flat_map(u16::to_le_bytes).collect()
        } else {
            indices.iter().flat_map(|i| i.to_le_bytes()).collect()
        };
        let view = self.view(&bytes, Some(INDICES));
        let kind = if short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        self.accessor(view, kind, indices.len(), "SCALAR")
    }

    fn accessor(&mut self, view: usize, component: u32, count: usize, kind: &str) -> usize {
        self.accessors.push(json!({
            "bufferView": view, "componentType": component, "count": count, "type": kind
        }));
        self.accessors.len() - 1
    }
}

fn little_endian<const N: usize>(values: &[[f32; N]]) -> Vec<u8> {
    values
        .iter()
        .flatten()
        .flat_map(|v| v.to_le_bytes())
        .collect()
}

/// Header, JSON chunk padded with spaces, binary chunk padded with zeros.
fn container(root: &Value, binary: &[u8]) -> Result<Vec<u8>, GlbError> {
    let counted = |bytes: usize| u32::try_from(bytes).map_err(|_| GlbError::TooLarge);
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + text.len() + 8 + binary.len();
    let mut out = Vec::with_capacity(total);
    out.extend(b"glTF");
    out.extend(2u32.to_le_bytes());
    out.extend(counted(total)?.to_le_bytes());
    for (kind, chunk) in [(b"JSON", text.as_slice()), (b"BIN\0", binary)] {
        out.extend(counted(chunk.len())?.to_le_bytes());
        out.extend(kind);
        out.extend(chunk);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crown::cube_sphere;
    use crate::raster::{Compression, Cubemap, Image, Straight, encode_png};
    use glam::DVec3;

    fn card() -> ModelMesh {
        ModelMesh {
            positions: vec![[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            tangents: vec![[1.0, 0.0, 0.0, 1.0]; 3],
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [0.5, 0.0]],
            wind: vec![[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            indices: vec![0, 1, 2],
        }
    }

    #[test]
    fn the_reader_crate_takes_levels_of_detail_and_instances() {
        let png = encode_png(
            &Image::filled(4, 4, Straight([9, 9, 9, 255])),
            Compression::Fast,
        );
        let mut glb = Glb::new(Some("somebody"));
        let material = glb.material(&Material {
            albedo: Some(&png),
            normal: Some(&png),
            is_solid: false,
            ..Material::white("leaf")
        });
        let mesh = glb.mesh("card", &card(), material, true);
        let (fine, coarse) = (glb.node("a_LOD0", mesh), glb.node("a_LOD1", mesh));
        glb.levels_of_detail(fine, &[coarse], &[0.3, 0.01]);
        let place = Instance {
            translation: [1.0, 0.0, 2.0],
            yaw: 1.0,
            scale: 0.5,
        };
        let many = glb.instanced_node("many", mesh, &[place; 3]);
        glb.show(fine);
        glb.show(many);
        let bytes = glb.into_bytes().unwrap();
        // The crate refuses extensions that it does not know, as it must.
        let file = gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
        assert_eq!(file.nodes().count(), 3);
        assert_eq!(file.default_scene().unwrap().nodes().count(), 2);
        let buffer = file.blob.as_deref().unwrap();
        let primitive = file.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(buffer));
        let positions: Vec<_> = reader.read_positions().unwrap().collect();
        assert_eq!(positions, card().positions);
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, [0, 1, 2]);
        assert_eq!(primitive.bounding_box().max, [1.0, 2.0, 0.0]);
        assert_eq!(primitive.material().alpha_cutoff(), Some(0.5));
    }
    #[test]
    fn a_bare_mesh_has_a_colour_and_no_picture() {
        let mesh = cube_sphere(&Cubemap::filled(4, 2.0), DVec3::Y, 4).mesh;
        let mut glb = Glb::new(None);
        let green = glb.material(&Material {
            color: [0.1, 0.2, 0.05, 1.0],
            ..Material::white("green")
        });
        let sphere = glb.mesh("sphere", &ModelMesh::from(&mesh), green, true);
        let node = glb.node("sphere", sphere);
        glb.show(node);
        let bytes = glb.into_bytes().unwrap();
        assert_eq!(bytes.len() % 4, 0);
        let (document, buffers, images) = gltf::import_slice(&bytes).unwrap();
        assert!(images.is_empty());
        let primitive = document.meshes().next().unwrap().primitives().next();
        let primitive = primitive.unwrap();
        let material = primitive.material().pbr_metallic_roughness();
        assert_eq!(material.base_color_factor(), [0.1, 0.2, 0.05, 1.0]);
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, mesh.triangles.as_flattened());
        for (position, normal) in reader
            .read_positions()
            .unwrap()
            .zip(reader.read_normals().unwrap())
        {
            let outward = DVec3::from_array(position.map(f64::from)) - DVec3::Y;
            let normal = DVec3::from_array(normal.map(f64::from));
            assert!((normal.length() - 1.0).abs() < 1e-6);
            assert!(normal.dot(outward) > 1.8);
        }
        assert_eq!(primitive.bounding_box().max[1], 3.0);
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let refused = |change: fn(&mut ModelMesh)| {
            let mut mesh = card();
            change(&mut mesh);
            let mut glb = Glb::new(None);
            let white = glb.material(&Material::white("white"));
            glb.mesh("card", &mesh, white, false);
            glb.into_bytes().unwrap_err()
        };
        let short = refused(|mesh| mesh.uvs.truncate(2));
        assert!(matches!(short, GlbError::Misfit { vertices: 3, .. }));
        let beyond = refused(|mesh| mesh.indices[0] = 3);
        assert!(matches!(beyond, GlbError::Misfit { .. }));
        let empty = refused(|mesh| mesh.indices.clear());
        assert_eq!(empty, GlbError::Empty("card".to_owned()));
        let infinite = refused(|mesh| mesh.positions[0][1] = f32::INFINITY);
        assert_eq!(infinite, GlbError::NotFinite("card".to_owned()));
    }
}
