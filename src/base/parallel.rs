//! How work meets the machine: thread pools and vector units. Neither ever changes a result.

use std::sync::atomic::{AtomicU8, Ordering};

/// Runs `work` inside a pool of `threads` workers (`None`: one for each core).
///
/// Everything that `work` does through rayon stays inside that pool.
///
/// # Errors
/// The system's reason when no thread can be had.
pub fn with_threads<T: Send>(
    threads: Option<usize>,
    work: impl FnOnce() -> T + Send,
) -> Result<T, rayon::ThreadPoolBuildError> {
    // Scoped: its threads have ended when this returns. A program that exits while some still end lets
    // libraries, drivers of graphics cards above all, clear away what those threads hold.
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build_scoped(|thread| thread.run(), |pool| pool.install(work))
}

/// Work on numbers that is compiled once for every level of vector unit.
///
/// [`Kernel::run`] and all that its loops call must be `#[inline(always)]`: what stays a call of its
/// own is compiled for the least processor. A closure cannot promise that, hence this trait.
pub trait Kernel {
    /// What the work gives.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// How wide a vector unit may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VectorLevel {
    /// What every processor of the family has.
    Least,
    /// At most what x86-64-v3 has: AVX2 and FMA.
    Wide,
    /// The widest there is.
    Widest,
}

/// The level that [`limit_vector_level`] set.
static LIMIT: AtomicU8 = AtomicU8::new(VectorLevel::Widest as u8);

/// From now on [`with_level_of_cpu`] uses nothing wider, in all of this process. It is for comparing:
/// no result may depend on it.
pub fn limit_vector_level(level: VectorLevel) {
    LIMIT.store(level as u8, Ordering::Relaxed);
}

/// The level that is to be used.
#[inline(always)]
fn level() -> pulp::Arch {
    const LEAST: u8 = VectorLevel::Least as u8;
    const WIDEST: u8 = VectorLevel::Widest as u8;
    match LIMIT.load(Ordering::Relaxed) {
        WIDEST => pulp::Arch::new(),
        LEAST => pulp::Arch::Scalar,
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        _ => pulp::x86::V3::try_new().map_or(pulp::Arch::Scalar, pulp::Arch::V3),
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        _ => pulp::Arch::new(),
    }
}

/// Runs `kernel` compiled for the widest vector unit that this processor has.
///
/// The compiler vectorises but never contracts a multiplication and an addition into one rounding
/// nor reorders sums, so the result is the same, bit for bit, on every level of x86-64 and
/// elsewhere. One call costs some nanoseconds: hand it hundreds of points, not one.
#[inline(always)]
pub fn with_level_of_cpu<K: Kernel>(kernel: K) -> K::Output {
    level().dispatch(OnLevel(kernel))
}

/// A kernel as `pulp` takes them.
struct OnLevel<K>(K);

impl<K: Kernel> pulp::NullaryFnOnce for OnLevel<K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.0.run()
    }
}
