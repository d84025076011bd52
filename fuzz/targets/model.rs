//! Any bytes as a model and as its card: what is read before a runtime sees it, which runs in a process
//! of its own behind limits.
#![no_main]

use boscage::segment::{Card, Learned};
use libfuzzer_sys::fuzz_target;
use std::borrow::Cow;

const CARD: &[u8] = include_bytes!("../../models/segmenter.json");

fuzz_target!(|bytes: &[u8]| {
    if let Ok(card) = Card::from_json(bytes) {
        assert!(card.channels() > 0);
        Card::from_json(&card.to_json()).unwrap();
    }
    for sidecar in [None, Some(CARD)] {
        if let Err(error) = Learned::new(Cow::Owned(bytes.to_vec()), sidecar) {
            assert!(!error.to_string().contains('\n'));
        }
    }
});
