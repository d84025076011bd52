//! Bits of a block, lowest first, and numbers of few values spread over 0 to 255.

use std::sync::LazyLock;

/// 128 bits, filled from the lowest.
#[derive(Debug, Default)]
pub(super) struct BitWriter {
    bits: u128,
    length: u32,
}

impl BitWriter {
    /// Appends the lowest `length` bits of `value`, which has no others.
    pub(super) fn put(&mut self, value: u32, length: u32) {
        debug_assert!(value.checked_shr(length).unwrap_or(0) == 0);
        self.bits |= u128::from(value) << self.length;
        self.length += length;
        debug_assert!(self.length <= 128);
    }

    pub(super) fn block(self) -> [u8; 16] {
        self.bits.to_le_bytes()
    }
}

/// The values that an endpoint may have, as ASTC spreads them over 0 to 255 (Khronos Data Format
/// Specification, "Color Endpoint Unquantization").
#[derive(Debug)]
pub(super) struct Quantizer {
    bits: u32,
    has_trit: bool,
    /// What each code means.
    values: Vec<u8>,
    /// The code whose meaning is nearest to each value.
    nearest: [u8; 256],
}

pub(super) static RANGE_32: LazyLock<Quantizer> = LazyLock::new(|| Quantizer::new(5, None));
pub(super) static RANGE_48: LazyLock<Quantizer> =
    LazyLock::new(|| Quantizer::new(4, Some((b"dcb000dcb", 22))));
pub(super) static RANGE_192: LazyLock<Quantizer> =
    LazyLock::new(|| Quantizer::new(6, Some((b"fedcb000f", 5))));
pub(super) static RANGE_256: LazyLock<Quantizer> = LazyLock::new(|| Quantizer::new(8, None));

impl Quantizer {
    /// Codes of `bits` bits, and a trit above them where there is a spreading: which bit (`a` the
    /// lowest) stands where in its nine, and the factor of the trit.
    fn new(bits: u32, trit: Option<(&[u8; 9], u32)>) -> Self {
        let count = if trit.is_some() { 3 } else { 1 } << bits;
        let values: Vec<u8> = (0..count)
            .map(|code: u32| {
                let low = code & ((1 << bits) - 1);
                match trit {
                    None => repeated(low, bits),
                    Some((spread, factor)) => spread_value(low, code >> bits, spread, factor),
                }
            })
            .collect();
        let nearest = std::array::from_fn(|wanted| {
            let distance = |code: &usize| usize::from(values[*code]).abs_diff(wanted);
            (0..values.len()).min_by_key(distance).unwrap_or(0) as u8
        });
        Self {
            bits,
            has_trit: trit.is_some(),
            values,
            nearest,
        }
    }

    /// The code nearest to `value`, which may lie outside of 0 to 255.
    pub(super) fn code(&self, value: f32) -> u8 {
        self.nearest[(value + 0.5).clamp(0.0, 255.0) as usize]
    }

    /// What `code` means.
    pub(super) fn value(&self, code: u8) -> u8 {
        self.values[usize::from(code)]
    }
}

/// `bits` bits repeated until eight are filled.
fn repeated(low: u32, bits: u32) -> u8 {
    let wide = low << (8 - bits);
    (wide | wide >> bits) as u8
}

fn spread_value(low: u32, trit: u32, spread: &[u8; 9], factor: u32) -> u8 {
    let b = spread.iter().fold(0, |b, &place| {
        let bit = match place {
            b'0' => 0,
            letter => low >> (letter - b'a') & 1,
        };
        b << 1 | bit
    });
    let a = if low & 1 == 1 { 0x1ff } else { 0 };
    let value = (trit * factor + b) ^ a;
    (a & 0x80 | value >> 2) as u8
}

/// Appends the codes of endpoints: first their trits, five (or what is left) in one number to the
/// base of three, then their bits.
pub(super) fn write_endpoints(bits: &mut BitWriter, codes: &[u8], quantizer: &Quantizer) {
    /// Bits of a number of so many trits.
    const LENGTHS: [u32; 6] = [0, 2, 4, 5, 7, 8];
    if quantizer.has_trit {
        for five in codes.chunks(5) {
            let trits = five.iter().map(|&code| u32::from(code) >> quantizer.bits);
            let number = trits.rev().fold(0, |number, trit| number * 3 + trit);
            bits.put(number, LENGTHS[five.len()]);
        }
    }
    let mask = (1 << quantizer.bits) - 1;
    for &code in codes {
        bits.put(u32::from(code) & mask, quantizer.bits);
    }
}
