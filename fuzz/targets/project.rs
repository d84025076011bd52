//! Any bytes as a project. Digests keep a fuzzer out, so what it writes is also wrapped in a container
//! whose digests are right: the content of sections is what is fuzzed then.
#![no_main]

use boscage::base::{Cancel, Digest};
use boscage::document::{decode, encode};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    check(bytes);
    if let Some(file) = wrapped(bytes) {
        check(&file);
    }
});

fn check(file: &[u8]) {
    match decode(file, |_| None) {
        Ok(decoded) => {
            assert_eq!(decoded.document.complaint(), None);
            // What is read is written and read again as the same.
            let again = encode(&decoded.document.snapshot(), &Cancel::new()).unwrap();
            let again = decode(&again, |_| None).unwrap().document;
            assert_eq!(again.digest(), decoded.document.digest());
        }
        Err(error) => assert!(!error.to_string().contains(char::is_control)),
    }
}

/// The bytes as sections: each begins with its kind's number, its flags and its length.
fn wrapped(mut bytes: &[u8]) -> Option<Vec<u8>> {
    const KINDS: [&[u8; 4]; 6] = [b"DOCU", b"MASK", b"BLOB", b"VIEW", b"HIST", b"WHAT"];
    let (mut table, mut body, mut count) = (Vec::new(), Vec::new(), 0u32);
    while let Some((&[kind, flags, low, high], rest)) = bytes.split_first_chunk::<4>() {
        let length = usize::from(u16::from_le_bytes([low, high])).min(rest.len());
        let (stored, rest) = rest.split_at(length);
        let plain = match flags & 2 {
            0 => length as u64,
            _ => u64::from(stored.len() as u32) * (1 + u64::from(flags >> 2)),
        };
        table.extend(KINDS[usize::from(kind) % KINDS.len()]);
        table.extend([flags, 0, 0, 0]);
        table.extend((length as u64).to_le_bytes());
        table.extend(plain.to_le_bytes());
        table.extend(Digest::of(stored).bytes());
        body.extend_from_slice(stored);
        count += 1;
        bytes = rest;
    }
    let mut file = b"\x89BSCG\r\n\x1a".to_vec();
    file.extend(1u32.to_le_bytes());
    file.extend(count.to_le_bytes());
    file.extend(table);
    let digest = Digest::of(&file);
    file.extend(digest.bytes());
    file.extend(body);
    (count > 0).then_some(file)
}
