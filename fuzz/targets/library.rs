//! Any bytes as a file of library.
#![no_main]

use boscage::cli::readers::library_record;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(reason) = library_record(bytes) {
        assert!(!reason.is_empty());
    }
});
