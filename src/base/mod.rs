//! What every other module stands on and that knows nothing of trees: seeded randomness,
//! progress, cancellation, and writing files so that a reader never sees half of one.
//!
//! Imports nothing of ours.

mod cancel;
mod file;
mod hash;
mod panics;
mod parallel;
mod progress;
mod random;
mod text;

pub use cancel::{Cancel, Cancelled};
pub use file::{FileError, changed_at, read_limited, write_all_atomic, write_atomic};
pub use hash::{Digest, Hasher, NoDigest};
pub use panics::{Panicked, without_panics};
pub use parallel::{Kernel, with_level_of_cpu, with_threads};
pub use progress::{Progress, Reporter, Stage, Update};
pub use random::{Random, Seed};
pub use text::one_line;
