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

/// Runs `kernel` compiled for the widest vector unit that this processor has.
///
/// `kernel` must be `#[inline(always)]` down to its loops. The compiler vectorises them but never
/// contracts a multiplication and an addition into one rounding, so the result is the same, bit
/// for bit, on every level of x86-64 and elsewhere.
#[inline(always)]
pub fn with_level_of_cpu<T>(kernel: impl FnOnce() -> T) -> T {
    pulp::Arch::new().dispatch(kernel)
}
