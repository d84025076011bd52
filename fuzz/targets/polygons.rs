//! Any bytes as a file of polygons.
#![no_main]

use boscage::cli::readers::polygon_file;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(reason) = polygon_file(bytes) {
        assert!(!reason.is_empty());
    }
});
