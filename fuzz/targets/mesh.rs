//! Any bytes as the base mesh of a crown.
#![no_main]

use boscage::export::{decode_ply, encode_ply};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(mesh) = decode_ply(bytes) {
        assert_eq!(decode_ply(&encode_ply(&mesh)).unwrap(), mesh);
    }
});
