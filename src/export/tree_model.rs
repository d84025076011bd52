//! A tree as a glTF file: levels of detail made of cards.

use super::cards::{Flat, crossed};
use super::cutout::Cutout;
use super::glb::{Glb, Material, MeshId};
use super::lod_model::{LodModel, WindChannels};
use super::model_mesh::ModelMesh;
use super::sprite::Sprite;

/// How a level of detail is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lod {
    /// This many crossed cut-outs; one is a plain cut-out.
    CutOut(u32),
    /// This many crossed rectangles; one is a plain billboard.
    Rectangle(u32),
}

/// What a file is made of.
#[derive(Debug, Clone, Copy)]
pub struct TreeModel<'a> {
    /// Name of the tree; nodes are `NAME_LOD0`, `NAME_LOD1`, …
    pub name: &'a str,
    /// Its picture.
    pub sprite: &'a Sprite,
    /// Its cut-out.
    pub cutout: &'a Cutout,
    /// Its pictures as files.
    pub material: Material<'a>,
    /// Levels from fine to coarse.
    pub lods: &'a [Lod],
}

impl TreeModel<'_> {
    /// The mesh of one level.
    pub fn mesh(&self, lod: Lod) -> ModelMesh {
        match lod {
            Lod::CutOut(planes) => crossed(self.sprite, &self.cutout.flat, planes),
            Lod::Rectangle(planes) => {
                crossed(self.sprite, &Flat::rectangle(self.sprite.corners()), planes)
            }
        }
    }
}

impl LodModel for TreeModel<'_> {
    fn name(&self) -> &str {
        self.name
    }

    fn level_count(&self) -> usize {
        self.lods.len()
    }

    fn add_materials(&self, glb: &mut Glb) -> Vec<usize> {
        vec![glb.material(&self.material)]
    }

    fn add_level(
        &self,
        glb: &mut Glb,
        materials: &[usize],
        level: usize,
        wind: WindChannels,
    ) -> MeshId {
        let mesh = self.mesh(self.lods[level]);
        let name = self.level_name(level);
        glb.mesh(&name, &mesh, materials[0], wind.has_colors())
    }
}
