//! A crown as a model with levels of detail, in two forms: its surface with the relief in it, and
//! cards with leaves around a dark core; both on a stem with bark. The foot stands at the origin.
//!
//! The surface is closed and opaque: the cheapest thing that is right from all sides. Leaf cards are
//! alpha-tested and look best from near. In both each level has about a quarter of the triangles of
//! the one before.

use super::atlas::{AtlasLayout, atlas};
use super::blocks::{BlockFormat, CompressedLevels};
use super::crown_mesh::divided;
use super::glb::{Glb, Material, MeshId};
use super::ktx2_file::encode_ktx2;
use super::leaf_cards::{LeafCards, averaged};
use super::lod_model::{LodModel, WindChannels};
use super::mips::{data_mips, mips};
use super::model_mesh::ModelMesh;
use super::rib_cards::RibCards;
use super::stem::{Stand, bark_picture, stem};
use crate::base::{Cancel, Cancelled, Seed};
use crate::branches::leaf_name::LeafName;
use crate::crown::cube_sphere;
use crate::raster::{Compression, Cubemap, Image, Straight, encode_png};
use crate::render::{Ribs, RibsFrom, srgb_byte};
use crate::scene::{Crown, Trunk};
use glam::DVec3;

/// Cells along a face of the surface, by level.
const SURFACE_CELLS: [u32; 4] = [64, 32, 16, 8];

/// Leaves, each a pair of cards, by level.
const LEAVES: [usize; 4] = [1280, 480, 160, 48];

/// Fronds of a palm and boughs of a conifer, and their pieces, by level.
const FRONDS: [(usize, u32); 4] = [(96, 6), (80, 3), (48, 2), (24, 1)];
const BOUGHS: [(usize, u32); 4] = [(1536, 2), (700, 1), (240, 1), (64, 1)];

/// Quads around and along the stem, by level.
const STEM: [(u32, u32); 4] = [(24, 20), (14, 10), (8, 5), (5, 3)];

/// Cells along a face of the core of a leaf crown, by level.
const CORE_CELLS: [u32; 4] = [12, 8, 5, 4];

/// Size and brightness of the core: it closes the gaps between leaves and is not to be seen itself.
const CORE: f32 = 0.74;
const BOUGH_CORE: f32 = 0.5;
const CORE_LIGHT: f32 = 0.35;
/// Texels along a face of the core's picture.
const CORE_PX: u32 = 32;

/// A material of a model.
#[derive(Debug, Clone)]
pub struct ModelMaterial {
    /// `leaves`, `crown`, `core` or `bark`.
    pub name: &'static str,
    /// Its colours.
    pub picture: Image<Straight>,
    /// The same as a KTX2 file of UASTC, once [`CrownModel::pack_pictures`] made it.
    pub packed: Option<Vec<u8>>,
    /// Whether it is drawn without an alpha test.
    pub is_solid: bool,
}

/// A crown as meshes.
#[derive(Debug, Clone)]
pub struct CrownModel {
    /// Name of its nodes: `NAME_LOD0`, `NAME_LOD1`, …
    pub name: String,
    /// What parts refer to.
    pub materials: Vec<ModelMaterial>,
    /// Levels from fine to coarse; each a list of parts with the index of their material.
    pub levels: Vec<Vec<(usize, ModelMesh)>>,
}

/// The crown's surface, opaque, in four levels from 49,000 to 768 triangles, on its stem.
///
/// # Panics
/// Never for a crown with faces of at least one texel.
pub fn surface_model(crown: &Crown, name: &str) -> CrownModel {
    let (trunk, stand) = standing(crown);
    let layout = AtlasLayout::new(crown.color.size());
    let levels = SURFACE_CELLS.iter().zip(STEM).map(|(&cells, quads)| {
        vec![
            (0, surface(crown, &crown.radius_m, cells, layout, &stand)),
            (1, stem(&trunk, &stand, quads.0, quads.1)),
        ]
    });
    CrownModel {
        name: name.to_owned(),
        levels: levels.collect(),
        materials: vec![
            solid("crown", atlas(&crown.color)),
            solid("bark", bark_picture(&trunk)),
        ],
    }
}

/// `leaf` all over the crown, in four levels, around a core, on its stem; between fronds one sees others, so
/// they have no core.
pub fn leaf_model(crown: &Crown, name: &str, leaf: LeafName, seed: Seed) -> CrownModel {
    let (trunk, stand) = standing(crown);
    let ribs = Ribs::of(leaf);
    let (picture, cards) = match &ribs {
        Some(ribs) => rib_cards(crown, (leaf, ribs), &stand, seed),
        None => {
            let leaves = LeafCards::new(crown, leaf, LEAVES[0], seed);
            let cards = LEAVES.map(|count| leaves.cards(count, &stand));
            (leaves.picture, cards)
        }
    };
    let core = match ribs.map(|ribs| ribs.from) {
        Some(RibsFrom::Heart) => None,
        Some(RibsFrom::Axis) => Some(BOUGH_CORE),
        None => Some(CORE),
    };
    let mut levels: Vec<_> = cards.into_iter().map(|cards| vec![(0, cards)]).collect();
    let mut materials = vec![tested("leaves", picture)];
    if let Some(size) = core {
        let inner = crown.radius_m.map(|&radius| radius * size);
        let colors = averaged(&crown.color, CORE_PX);
        let dark = colors.map(|&color| {
            let [r, g, b] = color.map(|channel| srgb_byte(channel * CORE_LIGHT));
            Straight([r, g, b, 255])
        });
        let layout = AtlasLayout::new(dark.size());
        for (level, cells) in levels.iter_mut().zip(CORE_CELLS) {
            level.push((1, surface(crown, &inner, cells, layout, &stand)));
        }
        materials.push(solid("core", atlas(&dark)));
    }
    let bark = materials.len();
    for (level, (around, along)) in levels.iter_mut().zip(STEM) {
        level.push((bark, stem(&trunk, &stand, around, along)));
    }
    materials.push(solid("bark", bark_picture(&trunk)));
    CrownModel {
        name: name.to_owned(),
        levels,
        materials,
    }
}

/// The picture and the levels of fronds or boughs.
fn rib_cards(
    crown: &Crown,
    (leaf, ribs): (LeafName, &Ribs),
    stand: &Stand,
    seed: Seed,
) -> (Image<Straight>, [ModelMesh; 4]) {
    let levels = match ribs.from {
        RibsFrom::Heart => FRONDS,
        RibsFrom::Axis => BOUGHS,
    };
    let leaves = RibCards::new(crown, (leaf, ribs), levels[0].0, seed);
    let cards = levels.map(|(count, bends)| leaves.cards(count, bends, stand));
    (leaves.picture, cards)
}

/// A material that is drawn where its picture has alpha.
fn tested(name: &'static str, picture: Image<Straight>) -> ModelMaterial {
    ModelMaterial {
        name,
        picture,
        packed: None,
        is_solid: false,
    }
}

fn solid(name: &'static str, picture: Image<Straight>) -> ModelMaterial {
    ModelMaterial {
        name,
        picture,
        packed: None,
        is_solid: true,
    }
}

/// The stem of `crown`, and where the tree stands.
fn standing(crown: &Crown) -> (Trunk, Stand) {
    let trunk = Trunk::under(crown);
    let (middle, _) = crown.tree_bounds();
    let stand = Stand {
        height_m: 2.0 * middle.y,
        shift: -trunk.base_m,
    };
    (trunk, stand)
}

/// The surface at `radius` with the texture coordinates of `layout`.
fn surface(
    crown: &Crown,
    radius: &Cubemap<f32>,
    cells: u32,
    layout: AtlasLayout,
    stand: &Stand,
) -> ModelMesh {
    let sphere = cube_sphere(radius, crown.center_m + stand.shift, cells);
    let places = sphere.mesh.positions.iter();
    let reach = places.fold(1e-9, |reach, p| libm::hypot(p.x, p.z).max(reach));
    let mut mesh = divided(&sphere, layout);
    let wind = |&[x, y, z]: &[f32; 3]| {
        let edge = libm::hypot(f64::from(x), f64::from(z)) / reach;
        // One phase: a closed surface that moved in parts would tear.
        [edge, 0.0, stand.sway(f64::from(y))].map(|weight| weight as f32)
    };
    mesh.wind = mesh.positions.iter().map(wind).collect();
    mesh
}

impl CrownModel {
    /// Makes the pictures of files UASTC instead of PNG (`KHR_texture_basisu`). Pictures whose sides
    /// are no multiples of 4, which that extension refuses, stay PNG.
    ///
    /// # Errors
    /// [`Cancelled`].
    pub fn pack_pictures(&mut self, cancel: &Cancel) -> Result<(), Cancelled> {
        for material in &mut self.materials {
            let picture = &material.picture;
            if !picture.width().is_multiple_of(4) || !picture.height().is_multiple_of(4) {
                continue;
            }
            let levels = if material.is_solid {
                data_mips(picture, cancel)?
            } else {
                mips(picture, &[], cancel)?
            };
            let blocks = CompressedLevels::of(&levels, BlockFormat::Uastc, cancel)?;
            material.packed = Some(encode_ktx2(&blocks, true, cancel)?);
        }
        Ok(())
    }

    /// Triangles of each level.
    pub fn triangles(&self) -> Vec<usize> {
        let of = |level: &Vec<(usize, ModelMesh)>| {
            level.iter().map(|(_, mesh)| mesh.indices.len() / 3).sum()
        };
        self.levels.iter().map(of).collect()
    }

    /// Corners of the box around the finest level, metres.
    pub fn bounds_m(&self) -> [DVec3; 2] {
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (_, mesh) in &self.levels[0] {
            for &[x, y, z] in &mesh.positions {
                let at = DVec3::new(f64::from(x), f64::from(y), f64::from(z));
                (low, high) = (low.min(at), high.max(at));
            }
        }
        [low, high]
    }
}

impl LodModel for CrownModel {
    fn name(&self) -> &str {
        &self.name
    }

    fn level_count(&self) -> usize {
        self.levels.len()
    }

    fn add_materials(&self, glb: &mut Glb) -> Vec<usize> {
        let add = |material: &ModelMaterial| {
            let file = match &material.packed {
                Some(packed) => packed.clone(),
                None => encode_png(&material.picture, Compression::Small),
            };
            glb.material(&Material {
                albedo: Some(&file),
                is_solid: material.is_solid,
                ..Material::white(&format!("{}_{}", self.name, material.name))
            })
        };
        self.materials.iter().map(add).collect()
    }

    fn add_level(
        &self,
        glb: &mut Glb,
        materials: &[usize],
        level: usize,
        wind: WindChannels,
    ) -> MeshId {
        let parts = self.levels[level].iter();
        let parts: Vec<_> = parts.map(|(own, mesh)| (materials[*own], mesh)).collect();
        glb.parts(&self.level_name(level), &parts, wind.has_colors())
    }
}
