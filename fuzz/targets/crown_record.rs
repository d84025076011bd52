//! Any bytes as `crown.json`.
#![no_main]

use boscage::export::CrownRecord;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(record) = CrownRecord::read(bytes) {
        assert!(record.radius_max_m > 0.0 && record.size > 0);
    }
});
