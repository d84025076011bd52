//! What stays on the card from picture to picture: only what has changed goes there again.

use super::context::Gpu;
use super::crown::CardCrown;
use super::layouts::Layouts;
use super::leaves::leaf_group;
use crate::base::Digest;
use crate::render::{LeafSet, PreparedCrown, PreparedMesh, SceneView};

/// Crowns, leaves and meshes on the card, in the order of the scene.
#[derive(Debug, Default)]
pub(super) struct Kept {
    pub(super) crowns: Vec<CardCrown>,
    pub(super) leaves: Option<(Digest, wgpu::BindGroup)>,
    pub(super) meshes: Vec<CardMesh>,
}

/// The triangles of a mesh.
#[derive(Debug, Clone)]
pub(super) struct CardMesh {
    digest: Digest,
    pub(super) corners: wgpu::Buffer,
    pub(super) corner_count: u32,
}

impl Kept {
    /// Brings to the card what `view` shows and is not there, and drops what it does not show.
    pub(super) fn keep(&mut self, gpu: &Gpu, layouts: &Layouts, view: &SceneView<'_>) {
        self.keep_crowns(gpu, layouts, view.crowns);
        self.keep_leaves(gpu, layouts, view.leaves);
        let meshes = view.meshes.iter().filter(|mesh| !mesh.corners.is_empty());
        self.meshes = meshes.map(|mesh| self.mesh(gpu, mesh)).collect();
    }

    /// First each crown takes itself, then those that have changed take what is left over.
    fn keep_crowns(&mut self, gpu: &Gpu, layouts: &Layouts, crowns: &[PreparedCrown]) {
        let mut old = std::mem::take(&mut self.crowns);
        let mut kept: Vec<Option<CardCrown>> = Vec::with_capacity(crowns.len());
        for crown in crowns {
            let known = old.iter().position(|known| known.is(crown));
            kept.push(known.map(|index| old.swap_remove(index)));
        }
        for (crown, place) in crowns.iter().zip(&mut kept) {
            if place.is_none() {
                let fitting = old.iter().position(|known| known.can_become(crown));
                *place = fitting.map(|index| {
                    let mut known = old.swap_remove(index);
                    known.become_crown(gpu, crown);
                    known
                });
            }
        }
        self.crowns = kept
            .into_iter()
            .zip(crowns)
            .map(|(known, crown)| known.unwrap_or_else(|| CardCrown::new(gpu, layouts, crown)))
            .collect();
    }

    fn keep_leaves(&mut self, gpu: &Gpu, layouts: &Layouts, leaves: &LeafSet) {
        let known = self.leaves.as_ref();
        if known.is_none_or(|(digest, _)| *digest != leaves.digest) {
            self.leaves = Some((leaves.digest, leaf_group(gpu, layouts, leaves)));
        }
    }

    fn mesh(&self, gpu: &Gpu, mesh: &PreparedMesh) -> CardMesh {
        let known = self.meshes.iter().find(|known| known.digest == mesh.digest);
        known.cloned().unwrap_or_else(|| CardMesh {
            digest: mesh.digest,
            corners: gpu.buffer(
                "mesh",
                bytemuck::cast_slice(&mesh.corners),
                wgpu::BufferUsages::VERTEX,
            ),
            corner_count: mesh.corners.len() as u32,
        })
    }
}
