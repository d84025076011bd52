//! A sample scene: trees scattered over a piece of ground.
//!
//! Places are a jittered grid, each tree within the middle of its cell, so that none stand inside
//! one another; sizes vary by a fifth. The scene shows the second level of detail of each tree if it
//! has one: it is seen from afar.

use super::glb::{Glb, GlbError, Instance};
use super::lod_model::{LodModel, WindChannels};
use crate::base::Seed;

/// How a scene is scattered.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScatterSettings {
    /// Trees along one side of the ground.
    pub side: u32,
    /// Mean distance of neighbours, in metres.
    pub spacing_m: f64,
    /// Whether copies are drawn by `EXT_mesh_gpu_instancing`; otherwise each has its node.
    pub instanced: bool,
    /// Where wind weights go.
    pub wind: WindChannels,
}

/// How far from the middle of its cell a tree may stand, in cells.
const JITTER: f64 = 0.3;

/// The scene's file; each tree is one of `models`, drawn at random.
///
/// # Errors
/// [`GlbError`], for meshes that are none.
///
/// # Panics
/// Without models.
pub fn scattered(
    models: &[impl LodModel],
    settings: ScatterSettings,
    seed: Seed,
    copyright: Option<&str>,
) -> Result<Vec<u8>, GlbError> {
    let mut glb = Glb::new(copyright);
    let mut places: Vec<Vec<Instance>> = vec![Vec::new(); models.len()];
    let mut random = seed.derive("scatter", 0).random();
    for row in 0..settings.side {
        for column in 0..settings.side {
            let middle = f64::from(settings.side - 1) / 2.0;
            let mut along = |cell: u32| {
                let at = f64::from(cell) - middle + random.between(-JITTER, JITTER);
                (at * settings.spacing_m) as f32
            };
            let translation = [along(column), 0.0, along(row)];
            let yaw = random.between(0.0, std::f64::consts::TAU) as f32;
            let scale = random.between(0.8, 1.2) as f32;
            places[random.below(models.len())].push(Instance {
                translation,
                yaw,
                scale,
            });
        }
    }
    for (model, places) in models.iter().zip(&places) {
        if places.is_empty() {
            continue;
        }
        let materials = model.add_materials(&mut glb);
        let level = 1.min(model.level_count() - 1);
        let mesh = model.add_level(&mut glb, &materials, level, settings.wind);
        if settings.instanced {
            let node = glb.instanced_node(model.name(), mesh, places);
            glb.show(node);
        } else {
            for (index, place) in places.iter().enumerate() {
                let node = glb.placed_node(&format!("{}_{index}", model.name()), mesh, place);
                glb.show(node);
            }
        }
    }
    glb.into_bytes()
}
