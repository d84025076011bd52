//! Memory that cannot be had: one line and exit code 1, not an abort.
//!
//! Where a container cannot grow, Rust's standard library aborts the process: code 134, perhaps a core
//! file of gigabytes, and a scheduler that takes it for a crash of the machine. Stable Rust tells of
//! the failure to the allocator only, so the program's is a thin one around the system's: it ends the
//! process in order. Large requests whose failure is an answer (`try_reserve`) are made within
//! [`asking_for_memory`].
//!
//! [`return_free_memory`] is for programs that run for days: glibc keeps what was freed for the thread that
//! freed it, and threads come and go.
//!
//! This is the one file with code that the compiler cannot check: the trait of allocators is unsafe by
//! its nature. Each function passes its arguments on unchanged, so the system's allocator keeps the
//! contract for us.
#![allow(unsafe_code, reason = "an allocator cannot be written without")]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::io::Write as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How long after memory was returned it is again, at the earliest.
const BETWEEN_RETURNS: Duration = Duration::from_secs(5);

thread_local! {
    static MAY_FAIL: Cell<bool> = const { Cell::new(false) };
}

/// Runs `ask`, within which memory that cannot be had is an answer on this thread and not the end.
///
/// ```
/// use boscage::base::asking_for_memory;
/// assert!(asking_for_memory(|| Vec::<u8>::new().try_reserve(1 << 62)).is_err());
/// ```
pub fn asking_for_memory<T>(ask: impl FnOnce() -> T) -> T {
    let before = MAY_FAIL.replace(true);
    let answer = ask();
    MAY_FAIL.set(before);
    answer
}

/// The system's allocator, but a failure ends the process with a line on stderr and exit code 1.
#[derive(Debug)]
pub struct EndingAllocator;

// SAFETY: all is the system allocator's, with our caller's promises handed on as they are; a failure
// that is not passed on never returns.
unsafe impl GlobalAlloc for EndingAllocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as our caller promised.
        had(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as our caller promised.
        had(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        // SAFETY: as our caller promised.
        unsafe { System.dealloc(memory, layout) }
    }

    unsafe fn realloc(&self, memory: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as our caller promised.
        had(unsafe { System.realloc(memory, layout, size) }, size)
    }
}

#[inline(always)]
fn had(memory: *mut u8, bytes: usize) -> *mut u8 {
    if memory.is_null() && !MAY_FAIL.try_with(Cell::get).unwrap_or(true) {
        end(bytes);
    }
    memory
}

/// Ends the process. Needs no memory itself: the line is written on the stack. Where several threads find none at
/// once one of them says so.
#[cold]
fn end(bytes: usize) -> ! {
    static IS_TOLD: AtomicBool = AtomicBool::new(false);
    let mut line = [0; 96];
    let mut rest = &mut line[..];
    let _ = writeln!(rest, "error: memory: {bytes} more bytes cannot be had");
    let left = rest.len();
    if !IS_TOLD.swap(true, Ordering::Relaxed) {
        let _ = std::io::stderr().write_all(&line[..line.len() - left]);
    }
    std::process::exit(1)
}

/// When memory was returned last, and whether a thread waits to do it again.
static RETURNS: Mutex<(Option<Instant>, bool)> = Mutex::new((None, false));

/// Gives memory that is free within the process back to the system. Where that was done a short while ago it is
/// done a short while from now, by this thread, which sleeps, or by one that does so already. Goes through all that
/// is free, so not for the thread that draws. Does nothing where there is no glibc.
pub fn return_free_memory() {
    let returns = || RETURNS.lock().unwrap_or_else(PoisonError::into_inner);
    let wait = {
        let (last, is_awaited) = &mut *returns();
        if *is_awaited {
            return;
        }
        *is_awaited = true;
        last.map_or(Duration::ZERO, |last| {
            BETWEEN_RETURNS.saturating_sub(last.elapsed())
        })
    };
    std::thread::sleep(wait);
    *returns() = (Some(Instant::now()), false);
    trim();
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn trim() {
    use std::ffi::c_int;
    unsafe extern "C" {
        /// glibc's: `int malloc_trim(size_t pad)`.
        fn malloc_trim(pad: usize) -> c_int;
    }
    // SAFETY: takes no pointer, touches nothing that is in use, and may be called by any thread at any time.
    unsafe { malloc_trim(0) };
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn trim() {}
