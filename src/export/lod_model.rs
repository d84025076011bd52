//! Trees with levels of detail as glTF files.

use super::glb::{Glb, GlbError, MeshId, NodeId};

/// Where wind weights are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum WindChannels {
    /// As the custom attribute `_WIND`, which changes nothing for readers that do not know it.
    #[default]
    Attribute,
    /// As `_WIND` and as vertex colours, which readers multiply with the picture unless told.
    AttributeAndColors,
}

impl WindChannels {
    /// Whether they are vertex colours too.
    pub(super) fn has_colors(self) -> bool {
        self == Self::AttributeAndColors
    }
}

/// How levels and wind are told to an engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct LodStyle {
    /// Whether all levels stand side by side under one node (for importers that group them by name)
    /// instead of behind the first (`MSFT_lod`).
    pub grouped: bool,
    /// Where wind weights go.
    pub wind: WindChannels,
}

/// A tree that is there in several levels of detail, numbered from the finest.
pub trait LodModel {
    /// Its name; levels are `NAME_LOD0`, `NAME_LOD1`, …
    fn name(&self) -> &str;

    /// Number of levels, one at least.
    fn level_count(&self) -> usize;

    /// Adds the materials of all levels; the answer goes to [`LodModel::add_level`].
    fn add_materials(&self, glb: &mut Glb) -> Vec<usize>;

    /// Adds the mesh of one level.
    fn add_level(
        &self,
        glb: &mut Glb,
        materials: &[usize],
        level: usize,
        wind: WindChannels,
    ) -> MeshId;

    /// The name of a level.
    fn level_name(&self, level: usize) -> String {
        format!("{}_LOD{level}", self.name())
    }
}

/// The share of the screen's height down to which level `level` of `count` serves: halved twice for
/// each level, the last down to a hundredth.
fn screen_coverage(count: usize) -> Vec<f64> {
    let inner = (0..count).map(|level| 0.5 / f64::from(4u32.pow(level as u32)));
    let mut coverage: Vec<f64> = inner.collect();
    if let Some(last) = coverage.last_mut() {
        *last = last.min(0.01);
    }
    coverage
}

/// The file of one tree, its foot at the origin.
///
/// # Errors
/// [`GlbError`], for meshes that are none.
pub fn lod_glb(
    model: &impl LodModel,
    style: LodStyle,
    copyright: Option<&str>,
) -> Result<Vec<u8>, GlbError> {
    let mut glb = Glb::new(copyright);
    let materials = model.add_materials(&mut glb);
    let mut node = |level: usize| {
        let mesh = model.add_level(&mut glb, &materials, level, style.wind);
        glb.node(&model.level_name(level), mesh)
    };
    let nodes: Vec<NodeId> = (0..model.level_count()).map(&mut node).collect();
    if style.grouped || nodes.len() == 1 {
        let root = glb.group(model.name(), &nodes);
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
