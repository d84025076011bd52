//! What every other module stands on and that knows nothing of trees: seeded randomness,
//! progress, cancellation, and writing files so that a reader never sees half of one.
//!
//! Imports nothing of ours.

mod cancel;
mod file;
mod hash;
mod memory;
mod panics;
mod parallel;
mod part;
mod progress;
mod random;
mod text;

pub use cancel::{Cancel, Cancelled};
pub use file::{
    FileError, changed_at, folder_of, read_limited, sync_names, write_all_atomic, write_atomic,
    write_atomic_while,
};
pub use hash::{Digest, Hasher, NoDigest};
pub use memory::{EndingAllocator, asking_for_memory, return_free_memory};
pub use panics::{Panicked, without_panics};
pub use parallel::{Kernel, VectorLevel, limit_vector_level, with_level_of_cpu, with_threads};
pub use part::{end_writing, remove_left_parts};
pub use progress::{Progress, Reporter, Stage, Update};
pub use random::{Random, Seed};
pub use text::{brief_line, one_line};
