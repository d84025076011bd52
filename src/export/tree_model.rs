//! A tree as a glTF file: levels of detail made of cards.

use super::cards::{CardMesh, Flat, crossed};
use super::cutout::Cutout;
use super::glb_file::{Glb, Material, MeshId, NodeId};
use super::sprite::Sprite;

/// How a level of detail is made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Lod {
    /// This many crossed cut-outs; one is a plain cut-out.
    CutOut(u32),
    /// This many crossed rectangles; one is a plain billboard.
    Rectangle(u32),
}

/// Where wind weights are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WindChannels {
    /// As the custom attribute `_WIND`, which changes nothing for readers that do not know it.
    #[default]
    Attribute,
    /// As `_WIND` and as vertex colours, which readers multiply with the picture unless told.
    AttributeAndColors,
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
    /// Whether all levels stand side by side under one node (for importers that group them by name)
    /// instead of behind the first (`MSFT_lod`).
    pub grouped: bool,
    /// Where wind weights go.
    pub wind: WindChannels,
}

impl TreeModel<'_> {
    /// The mesh of one level.
    pub fn mesh(&self, lod: Lod) -> CardMesh {
        match lod {
            Lod::CutOut(planes) => crossed(self.sprite, &self.cutout.flat, planes),
            Lod::Rectangle(planes) => {
                crossed(self.sprite, &Flat::rectangle(self.sprite.corners()), planes)
            }
        }
    }

    /// Adds the material and the meshes of all levels to `glb`.
    pub(super) fn meshes(&self, glb: &mut Glb) -> Vec<MeshId> {
        let material = glb.material(&self.material);
        let colors = self.wind == WindChannels::AttributeAndColors;
        let lods = self.lods.iter().enumerate();
        lods.map(|(level, lod)| {
            let name = format!("{}_LOD{level}", self.name);
            glb.mesh(&name, &self.mesh(*lod), material, colors)
        })
        .collect()
    }
}

/// The share of the screen's height down to which level `level` of `count` serves: halved twice for
/// each level, the last down to a hundredth.
pub(super) fn screen_coverage(count: usize) -> Vec<f64> {
    let inner = (0..count).map(|level| 0.5 / f64::from(4u32.pow(level as u32)));
    let mut coverage: Vec<f64> = inner.collect();
    if let Some(last) = coverage.last_mut() {
        *last = last.min(0.01);
    }
    coverage
}

/// The file of one tree, its foot at the origin.
pub fn tree_glb(model: &TreeModel<'_>, copyright: Option<&str>) -> Vec<u8> {
    let mut glb = Glb::new(copyright);
    let meshes = model.meshes(&mut glb);
    let levels = meshes.iter().enumerate();
    let nodes: Vec<NodeId> = levels
        .map(|(level, &mesh)| glb.node(&format!("{}_LOD{level}", model.name), mesh))
        .collect();
    if model.grouped || nodes.len() == 1 {
        let root = glb.group(model.name, &nodes);
        glb.show(root);
    } else {
        glb.levels_of_detail(nodes[0], &nodes[1..], &screen_coverage(nodes.len()));
        glb.show(nodes[0]);
    }
    glb.into_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coverage_falls_and_there_is_one_for_each_level() {
        assert_eq!(screen_coverage(3), [0.5, 0.125, 0.01]);
        assert_eq!(screen_coverage(1), [0.01]);
    }
}
