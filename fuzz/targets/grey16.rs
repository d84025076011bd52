//! Any bytes as a 16-bit grey PNG: heights and radii of crowns.
#![no_main]

use boscage::raster::decode_grey16_png;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Err(error) = decode_grey16_png(bytes, 512) {
        assert!(!error.to_string().contains('\n'));
    }
});
