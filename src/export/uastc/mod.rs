//! UASTC: 4×4 texels in 16 bytes, which readers of Basis Universal files turn into whatever blocks
//! the card at hand knows (ASTC, BC7, ETC2, …). The only form of blocks that glTF takes, through
//! `KHR_texture_basisu`.
//!
//! Written after the *UASTC LDR 4×4 Texture Specification* (Binomial LLC, 2020). No encoder of it
//! could be had but a C++ library, and the project builds with Rust alone.
//!
//! Of the 19 modes nine are used: a block of one colour, and blocks whose texels lie on one line
//! through colour space, with more endpoints or more weights as suits them, one with a line of its own
//! for alpha. Blocks of two or three lines are left out: they would sharpen borders between unlike
//! colours by 1 to 2 dB at several times the work. [`fit`] finds lines, [`hints`] what makes the
//! way to ETC1 and ETC2 (old phones) short, [`bits`] writes.
//!
//! Colours of clear texels do not show: they count for little in the error, and a block without any
//! visible texel is of one colour, so that it packs well.

mod bits;
mod fit;
mod hints;

use crate::raster::Straight;
use bits::{BitWriter, Quantizer, RANGE_32, RANGE_48, RANGE_192, RANGE_256, write_endpoints};
use fit::{Line, Texels};
use hints::{EtcHints, alpha_hint, etc_hints, solid_hints};

/// Bytes of a block.
pub(super) const BLOCK_BYTES: usize = 16;

/// Alpha up to which a block counts as clear: no display shows it.
const CLEAR_ALPHA: u8 = 2;

/// A way to write a block whose texels lie on a line.
struct Mode {
    /// The code that starts the block, and its length in bits.
    code: (u32, u32),
    /// 3 without alpha, 4 with.
    channels: usize,
    weight_bits: u32,
    endpoints: &'static std::sync::LazyLock<Quantizer>,
    /// Whether alpha has weights of its own.
    has_alpha_weights: bool,
    /// Which hints stand in the block: the second for BC1, the bias for ETC1.
    has_long_hints: bool,
}

const OPAQUE: [Mode; 4] = [
    Mode::opaque((0x1, 4), 4, &RANGE_192),
    Mode::opaque((0x35, 6), 2, &RANGE_256),
    Mode::opaque((0xB, 5), 3, &RANGE_256),
    Mode::opaque((0x9, 4), 5, &RANGE_32),
];

const WITH_ALPHA: [Mode; 4] = [
    Mode::with_alpha((0x2, 3), 4, &RANGE_48),
    Mode {
        has_alpha_weights: true,
        ..Mode::with_alpha((0x0, 2), 2, &RANGE_48)
    },
    Mode::with_alpha((0x6, 3), 3, &RANGE_192),
    Mode {
        has_long_hints: true,
        ..Mode::with_alpha((0xD, 5), 2, &RANGE_256)
    },
];

/// The code of a block of one colour.
const SOLID: (u32, u32) = (0x17, 5);

impl Mode {
    const fn opaque(
        code: (u32, u32),
        weight_bits: u32,
        endpoints: &'static std::sync::LazyLock<Quantizer>,
    ) -> Self {
        Self {
            code,
            channels: 3,
            weight_bits,
            endpoints,
            has_alpha_weights: false,
            has_long_hints: true,
        }
    }

    const fn with_alpha(
        code: (u32, u32),
        weight_bits: u32,
        endpoints: &'static std::sync::LazyLock<Quantizer>,
    ) -> Self {
        Self {
            channels: 4,
            has_long_hints: false,
            ..Self::opaque(code, weight_bits, endpoints)
        }
    }

    /// The best lines of this mode through `texels`: one, or one for colour and one for alpha.
    fn lines(&self, texels: &Texels) -> Vec<Line> {
        let quantizer: &Quantizer = self.endpoints;
        let line = |channels| fit::line(texels, channels, self.weight_bits, quantizer);
        if self.has_alpha_weights {
            vec![line(0..3), line(3..4)]
        } else {
            vec![line(0..self.channels)]
        }
    }

    fn write(&self, lines: &[Line], hints: &EtcHints, alpha_hint: u32) -> [u8; BLOCK_BYTES] {
        let mut bits = BitWriter::default();
        bits.put(self.code.0, self.code.1);
        // The hints for BC1 only spare its encoder some work; without them it looks by itself.
        bits.put(0, if self.has_long_hints { 2 } else { 1 });
        hints.write(&mut bits, self.has_long_hints);
        if self.channels == 4 {
            bits.put(alpha_hint, 8);
        }
        if self.has_alpha_weights {
            const ALPHA: u32 = 3;
            bits.put(ALPHA, 2);
        }
        let ends: Vec<u8> = lines
            .iter()
            .flat_map(|line| line.ends.iter().flatten())
            .copied()
            .collect();
        write_endpoints(&mut bits, &ends, self.endpoints);
        for texel in 0..16 {
            // The first weight's highest bit is zero and left out.
            let length = self.weight_bits - u32::from(texel == 0);
            for line in lines {
                bits.put(u32::from(line.weights[texel]), length);
            }
        }
        bits.block()
    }
}

/// The block of 16 texels, row by row.
pub(super) fn block(texels: &[Straight; 16]) -> [u8; BLOCK_BYTES] {
    if let Some(color) = one_color(texels) {
        return solid_block(color);
    }
    let is_opaque = texels.iter().all(|texel| texel.alpha() == u8::MAX);
    let modes = if is_opaque { &OPAQUE } else { &WITH_ALPHA };
    let fitted = Texels::of(texels);
    let best = modes
        .iter()
        .map(|mode| {
            let lines = mode.lines(&fitted);
            let error: f32 = lines.iter().map(|line| line.error).sum();
            (error, mode, lines)
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, mode, lines)) = best else {
        unreachable!("there are modes")
    };
    mode.write(&lines, &etc_hints(texels), alpha_hint(texels))
}

/// The colour of a block that has only one, or of which nothing shows.
fn one_color(texels: &[Straight; 16]) -> Option<Straight> {
    if texels.iter().all(|texel| texel == &texels[0]) {
        return Some(texels[0]);
    }
    if texels.iter().any(|texel| texel.alpha() > CLEAR_ALPHA) {
        return None;
    }
    let mean = |channel: usize| {
        let sum: u32 = texels.iter().map(|t| u32::from(t.0[channel])).sum();
        ((sum + 8) / 16) as u8
    };
    Some(Straight([mean(0), mean(1), mean(2), 0]))
}

fn solid_block(color: Straight) -> [u8; BLOCK_BYTES] {
    let mut bits = BitWriter::default();
    bits.put(SOLID.0, SOLID.1);
    for value in color.0 {
        bits.put(u32::from(value), 8);
    }
    let hints = solid_hints(color);
    bits.put(u32::from(hints.is_differential), 1);
    bits.put(hints.intensity, 3);
    bits.put(hints.selector, 2);
    for value in hints.base {
        bits.put(value, 5);
    }
    bits.block()
}

#[cfg(test)]
mod tests;
