//! A graphics card, asked for in a way that no answer is a panic.

use crate::render::RenderError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// A device and what it has told of itself since.
#[derive(Debug, Clone)]
pub struct Gpu {
    pub(super) device: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    info: wgpu::AdapterInfo,
    /// The first thing that went wrong outside an error scope.
    trouble: Arc<Mutex<Option<RenderError>>>,
    is_lost: Arc<AtomicBool>,
}

impl Gpu {
    /// The best adapter there is, without a window. OpenGL is looked at only where there is nothing
    /// newer: its drivers stay in a process and may break its end. `WGPU_BACKEND` names another
    /// choice.
    ///
    /// Asks for time stamps where there are any, for nothing else that an adapter may lack.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`].
    pub fn offscreen() -> Result<Self, RenderError> {
        match wgpu::Backends::from_env() {
            Some(chosen) => Self::of(chosen),
            None => Self::of(wgpu::Backends::PRIMARY).or_else(|_| Self::of(wgpu::Backends::GL)),
        }
    }

    /// The best adapter of some backends.
    fn of(backends: wgpu::Backends) -> Result<Self, RenderError> {
        let missing = |reason: String| RenderError::NoAdapter(reason);
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends,
            ..wgpu::InstanceDescriptor::new_without_display_handle_from_env()
        });
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            ..Default::default()
        };
        let adapter = pollster::block_on(instance.request_adapter(&options))
            .map_err(|error| missing(error.to_string()))?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("boscage"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| missing(error.to_string()))?;
        Ok(Self::new(device, queue, adapter.get_info()))
    }

    /// A device that somebody else made, such as that of a window.
    pub fn new(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Self {
        let trouble = Arc::new(Mutex::new(None));
        let lost = Arc::clone(&trouble);
        let is_lost = Arc::new(AtomicBool::new(false));
        let loses = Arc::clone(&is_lost);
        device.set_device_lost_callback(move |_, message| {
            loses.store(true, Ordering::Relaxed);
            note(&lost, RenderError::DeviceLost(message));
        });
        let uncaptured = Arc::clone(&trouble);
        device.on_uncaptured_error(Arc::new(move |error| note(&uncaptured, told(&error))));
        Self {
            device,
            queue,
            info,
            trouble,
            is_lost,
        }
    }

    /// Whether the device is gone: whatever is asked of it fails from now on.
    pub fn is_lost(&self) -> bool {
        // A loss is told to whoever looks.
        let looked = self.poll();
        looked.is_err() || self.is_lost.load(Ordering::Relaxed)
    }

    /// The name of the adapter and what it is reached through.
    pub fn name(&self) -> String {
        format!("{} ({})", self.info.name, self.info.backend)
    }

    /// Whether the adapter is a program on the processor.
    pub fn is_software(&self) -> bool {
        self.info.device_type == wgpu::DeviceType::Cpu
    }

    /// The longest side of a texture.
    pub fn longest_side(&self) -> u32 {
        self.device.limits().max_texture_dimension_2d
    }

    /// A buffer with `contents`, which must not be empty.
    ///
    /// Written through the queue: buffers that are mapped when they are made panic in wgpu's own
    /// helper on a card that is lost or full.
    pub(super) fn buffer(
        &self,
        label: &str,
        contents: &[u8],
        usage: wgpu::BufferUsages,
    ) -> wgpu::Buffer {
        let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some(label),
            size: contents.len() as u64,
            usage: usage | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        self.queue.write_buffer(&buffer, 0, contents);
        buffer
    }

    /// Does `work`, and gives what went wrong with the card meanwhile as an error.
    pub(super) fn guarded<T>(
        &self,
        work: impl FnOnce() -> Result<T, RenderError>,
    ) -> Result<T, RenderError> {
        let memory = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let usage = self.device.push_error_scope(wgpu::ErrorFilter::Validation);
        let done = work();
        let usage = pollster::block_on(usage.pop());
        let memory = pollster::block_on(memory.pop());
        if let Some(error) = self.trouble() {
            return Err(error);
        }
        match memory.or(usage) {
            Some(error) => Err(told(&error)),
            None => done,
        }
    }

    pub(super) fn trouble(&self) -> Option<RenderError> {
        let trouble = self.trouble.lock();
        trouble.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Looks whether the card has news, without waiting for any.
    pub(super) fn poll(&self) -> Result<(), RenderError> {
        let lost = |error: wgpu::PollError| RenderError::DeviceLost(error.to_string());
        self.device
            .poll(wgpu::PollType::Poll)
            .map(drop)
            .map_err(lost)
    }

    /// Waits until all that was submitted is done.
    pub(super) fn wait(&self) -> Result<(), RenderError> {
        // GL answers `Timeout` to a wait of more than 2 s even though the work goes on.
        for _ in 0..LONGEST_WAIT {
            match self.device.poll(wgpu::PollType::Wait {
                submission_index: None,
                timeout: Some(std::time::Duration::from_secs(1)),
            }) {
                Ok(_) => return Ok(()),
                Err(wgpu::PollError::Timeout) => {}
                Err(error) => return Err(RenderError::DeviceLost(error.to_string())),
            }
            if let Some(error) = self.trouble() {
                return Err(error);
            }
        }
        Err(RenderError::DeviceLost("it stopped answering".to_owned()))
    }
}

/// Seconds after which a card that does not answer counts as lost: software adapters take many for
/// a large picture.
const LONGEST_WAIT: u32 = 300;

fn note(trouble: &Mutex<Option<RenderError>>, error: RenderError) {
    let mut first = trouble.lock().unwrap_or_else(PoisonError::into_inner);
    first.get_or_insert(error);
}

/// What an error of the interface means for the caller.
fn told(error: &wgpu::Error) -> RenderError {
    match error {
        wgpu::Error::OutOfMemory { source } => RenderError::OutOfMemory(source.to_string()),
        other => RenderError::DeviceLost(other.to_string()),
    }
}
