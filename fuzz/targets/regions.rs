//! Any bytes as a file of regions.
#![no_main]

use boscage::cli::readers::region_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(reason) = region_file(bytes) {
        assert!(!reason.is_empty());
    }
});
