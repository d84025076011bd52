//! Panics of other people's code, turned into errors.
//!
//! Decoders of old file formats panic on inputs that their authors did not think of. A picture
//! that cannot be read must not take the studio with it, so such code runs in [`without_panics`].
//! The default hook would still print the panic and its location on stderr, where the command line
//! promises one line for each error; so a hook is put before it, once for the process, that stays
//! quiet on a thread that is inside [`without_panics`] and passes everything else on. Code that
//! panics on threads of its own is not covered: keep decoders single-threaded.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static QUIET: Cell<bool> = const { Cell::new(false) };
}

/// The work panicked; nothing that it was about to give back may be used.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("internal failure: {message}")]
pub struct Panicked {
    /// What the panic said, as it said it: several lines, perhaps.
    pub message: String,
}

/// Runs `work` and returns its result, or what it panicked with, without a word on stderr.
///
/// `work` must give up what it was building when it panics: lend it nothing that is used again.
///
/// # Errors
/// [`Panicked`].
pub fn without_panics<T>(work: impl FnOnce() -> T) -> Result<T, Panicked> {
    static HOOK: Once = Once::new();
    HOOK.call_once(|| {
        let previous = take_hook();
        set_hook(Box::new(move |info| {
            // `try_with`: a thread may panic while its thread-locals are already gone.
            if !QUIET.try_with(Cell::get).unwrap_or(false) {
                previous(info);
            }
        }));
    });
    let before = QUIET.replace(true);
    let result = catch_unwind(AssertUnwindSafe(work));
    QUIET.set(before);
    result.map_err(|payload| Panicked {
        message: payload
            .downcast_ref::<&str>()
            .map(|&text| text.to_owned())
            .or_else(|| payload.downcast_ref::<String>().cloned())
            .unwrap_or_else(|| "no message".to_owned()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_with_its_message() {
        assert_eq!(without_panics(|| 3), Ok(3));
        let zero = 0;
        let panicked = without_panics(|| assert_eq!(zero, 1, "told {zero}")).unwrap_err();
        assert!(panicked.message.contains("told 0"), "{panicked}");
    }

    #[test]
    fn quiet_ends_with_the_work_that_asked_for_it() {
        let nested = without_panics(|| {
            let inner = without_panics(|| panic!("inner"));
            (inner.is_err(), QUIET.get())
        });
        assert_eq!(nested, Ok((true, true)));
        assert!(!QUIET.get());
    }
}
