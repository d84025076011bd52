//! How work meets the machine: thread pools and vector units. Neither ever changes a result.

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
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()?;
    Ok(pool.install(work))
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

/// Runs `kernel` compiled for the widest vector unit that this processor has.
///
/// The compiler vectorises but never contracts a multiplication and an addition into one rounding
/// nor reorders sums, so the result is the same, bit for bit, on every level of x86-64 and
/// elsewhere. One call costs some nanoseconds: hand it hundreds of points, not one.
#[inline(always)]
pub fn with_level_of_cpu<K: Kernel>(kernel: K) -> K::Output {
    pulp::Arch::new().dispatch(OnLevel(kernel))
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
