//! Any bytes as a curve of k along the silhouette.
#![no_main]

use boscage::crown::Profile;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(profile) = serde_json::from_slice::<Profile>(bytes) {
        let again = serde_json::to_vec(&profile).unwrap();
        assert_eq!(serde_json::from_slice::<Profile>(&again).unwrap(), profile);
    }
});
