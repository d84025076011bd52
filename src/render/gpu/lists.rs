//! The crowns of a picture by the passes that draw them.

use super::context::Gpu;
use crate::render::SceneView;
use crate::render::frame::{Frame, InstanceNumbers, Resolved, leaf_bound};
use crate::render::settings::RenderSettings;
use std::collections::BTreeMap;
use std::ops::Range;

/// What is drawn in a picture, beside what [`super::kept::Kept`] holds.
#[derive(Debug)]
pub(super) struct Lists {
    pub(super) frame: wgpu::BindGroup,
    pub(super) shadows: Instances,
    pub(super) relief: Instances,
    /// Crowns with about as many leaves, and how many at most.
    pub(super) leaves: Vec<(u32, Instances)>,
}

/// The crowns of a pass, those of one kind after another.
#[derive(Debug)]
pub(super) struct Instances {
    pub(super) buffer: wgpu::Buffer,
    /// For each crown of the scene: first and one after the last instance.
    pub(super) ranges: Vec<Range<u32>>,
}

impl Lists {
    pub(super) fn new(
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        view: &SceneView<'_>,
        settings: &RenderSettings,
    ) -> Self {
        let resolved = Resolved::new(view, settings);
        let count = view.crowns.len();
        let instances = |list: &[(usize, InstanceNumbers)]| Instances::new(gpu, list, count);
        let mut leaves: BTreeMap<u32, Vec<(usize, InstanceNumbers)>> = BTreeMap::new();
        for entry in &resolved.leaves {
            let bound = leaf_bound(view, settings, entry);
            leaves.entry(bound).or_default().push(*entry);
        }
        Self {
            frame: frame_group(gpu, layout, &Frame::new(view, settings)),
            shadows: instances(&resolved.shadows),
            relief: instances(&resolved.relief),
            leaves: leaves
                .into_iter()
                .map(|(bound, list)| (bound, instances(&list)))
                .collect(),
        }
    }
}

fn frame_group(gpu: &Gpu, layout: &wgpu::BindGroupLayout, frame: &Frame) -> wgpu::BindGroup {
    let numbers = gpu.buffer(
        "frame",
        bytemuck::bytes_of(frame),
        wgpu::BufferUsages::UNIFORM,
    );
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("frame"),
        layout,
        entries: &[wgpu::BindGroupEntry {
            binding: 0,
            resource: numbers.as_entire_binding(),
        }],
    })
}

impl Instances {
    /// `list`, sorted by crown, on the card.
    fn new(gpu: &Gpu, list: &[(usize, InstanceNumbers)], crown_count: usize) -> Self {
        let mut numbers: Vec<InstanceNumbers> = list.iter().map(|(_, numbers)| *numbers).collect();
        let first = |crown: usize| list.partition_point(|(index, _)| *index < crown) as u32;
        let ranges = (0..crown_count).map(|crown| first(crown)..first(crown + 1));
        let ranges = ranges.collect();
        // A buffer must not be empty.
        if numbers.is_empty() {
            numbers.push(bytemuck::Zeroable::zeroed());
        }
        let bytes = bytemuck::cast_slice(&numbers);
        Self {
            buffer: gpu.buffer("instances", bytes, wgpu::BufferUsages::VERTEX),
            ranges,
        }
    }
}
