//! Any bytes as a picture of any name: an upright picture within the limit, or one clear line.
#![no_main]

use boscage::raster::{ReadLimits, read_image_from_memory};
use libfuzzer_sys::fuzz_target;
use std::path::Path;

fuzz_target!(|bytes: &[u8]| {
    let limits = ReadLimits {
        pixels: 1 << 20,
        ..ReadLimits::default()
    };
    // Only a file of this name may be a TGA without a signature.
    for name in ["a.png", "a.tga"] {
        match read_image_from_memory(bytes, Path::new(name), limits) {
            Ok(image) => {
                let pixels = u64::from(image.width()) * u64::from(image.height());
                assert!(pixels > 0 && pixels <= limits.pixels);
            }
            Err(error) => {
                let line = error.to_string();
                assert!(!line.contains(char::is_control) && line.len() < 300, "{line}");
            }
        }
    }
});
