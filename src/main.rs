//! The `boscage` program: all of it is in the library, so that tests can reach it.

/// Memory that cannot be had is an error, not an abort.
#[global_allocator]
static MEMORY: boscage::base::EndingAllocator = boscage::base::EndingAllocator;

fn main() -> std::process::ExitCode {
    boscage::cli::run()
}
