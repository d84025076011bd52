//! How long the card takes.

use super::context::Gpu;
use super::target::mapped;
use crate::render::RenderError;
use std::time::Instant;
use wgpu::{BufferUsages, QUERY_SIZE};

/// Measures a pass.
pub(super) struct Timer {
    stamps: Option<Stamps>,
    /// For cards without a clock.
    start: Instant,
}

/// The card's own clock: two time stamps, and the way to read them.
struct Stamps {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readable: wgpu::Buffer,
}

const BYTES: u64 = 2 * QUERY_SIZE as u64;

impl Timer {
    pub(super) fn new(gpu: &Gpu) -> Self {
        let has_clock = gpu
            .device
            .features()
            .contains(wgpu::Features::TIMESTAMP_QUERY);
        Self {
            stamps: has_clock.then(|| Stamps::new(gpu)),
            start: Instant::now(),
        }
    }

    /// Where the pass that is measured writes its stamps.
    pub(super) fn writes(&self) -> Option<wgpu::RenderPassTimestampWrites<'_>> {
        let stamps = self.stamps.as_ref()?;
        Some(wgpu::RenderPassTimestampWrites {
            query_set: &stamps.set,
            beginning_of_pass_write_index: Some(0),
            end_of_pass_write_index: Some(1),
        })
    }

    /// Makes the stamps readable, after the pass.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(stamps) = &self.stamps {
            encoder.resolve_query_set(&stamps.set, 0..2, &stamps.resolved, 0);
            encoder.copy_buffer_to_buffer(&stamps.resolved, 0, &stamps.readable, 0, BYTES);
        }
    }

    /// The time, milliseconds; waits for the card.
    pub(super) fn read_ms(&self, gpu: &Gpu) -> Result<f64, RenderError> {
        gpu.wait()?;
        let by_wall = self.start.elapsed().as_secs_f64() * 1e3;
        let Some(stamps) = &self.stamps else {
            return Ok(by_wall);
        };
        let bytes = mapped(gpu, &stamps.readable)?;
        let stamp = |i: usize| {
            let mut number = [0; 8];
            number.copy_from_slice(&bytes[8 * i..8 * i + 8]);
            u64::from_le_bytes(number)
        };
        let ticks = stamp(1).saturating_sub(stamp(0));
        let by_card = ticks as f64 * f64::from(gpu.queue.get_timestamp_period()) * 1e-6;
        // Some drivers stamp both ends when the pass is handed over.
        Ok(if by_card > 0.01 * by_wall {
            by_card
        } else {
            by_wall
        })
    }
}

impl Stamps {
    fn new(gpu: &Gpu) -> Self {
        let buffer = |usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("time stamps"),
                size: BYTES,
                usage,
                mapped_at_creation: false,
            })
        };
        Self {
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("time stamps"),
                ty: wgpu::QueryType::Timestamp,
                count: 2,
            }),
            resolved: buffer(BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC),
            readable: buffer(BufferUsages::MAP_READ | BufferUsages::COPY_DST),
        }
    }
}
