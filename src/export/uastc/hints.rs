//! What a block says beside its texels, for readers that turn it into ETC1 or ETC2: which halves,
//! which tables. They take it as it is, so it decides how a tree looks on an old phone.

use super::bits::BitWriter;
use crate::raster::Straight;

/// Steps from a base colour, by table (ETC1).
const INTENSITIES: [[i32; 4]; 8] = [
    [-8, -2, 2, 8],
    [-17, -5, 5, 17],
    [-29, -9, 9, 29],
    [-42, -13, 13, 42],
    [-60, -18, 18, 60],
    [-80, -24, 24, 80],
    [-106, -33, 33, 106],
    [-183, -47, 47, 183],
];

/// Steps from a base alpha, by table (ETC2's EAC); the fourth is the least, the last the most.
const ALPHA_STEPS: [[i32; 8]; 16] = [
    [-3, -6, -9, -15, 2, 5, 8, 14],
    [-3, -7, -10, -13, 2, 6, 9, 12],
    [-2, -5, -8, -13, 1, 4, 7, 12],
    [-2, -4, -6, -13, 1, 3, 5, 12],
    [-3, -6, -8, -12, 2, 5, 7, 11],
    [-3, -7, -9, -11, 2, 6, 8, 10],
    [-4, -7, -8, -11, 3, 6, 7, 10],
    [-3, -5, -8, -11, 2, 4, 7, 10],
    [-2, -6, -8, -10, 1, 5, 7, 9],
    [-2, -5, -8, -10, 1, 4, 7, 9],
    [-2, -4, -8, -10, 1, 3, 7, 9],
    [-2, -5, -7, -10, 1, 4, 6, 9],
    [-3, -4, -7, -10, 2, 3, 6, 9],
    [-1, -2, -3, -10, 0, 1, 2, 9],
    [-4, -6, -8, -9, 3, 5, 7, 8],
    [-3, -5, -7, -9, 2, 4, 6, 8],
];

/// The bias that leaves base colours alone: three digits of 1 to the base of three.
const NO_BIAS: u32 = 13;

/// How ETC1 is to write a block.
pub(super) struct EtcHints {
    /// Halves one above the other, not side by side.
    is_flipped: bool,
    /// The second half's base colour is told as a difference.
    is_differential: bool,
    /// The table of each half.
    intensities: [u32; 2],
}

impl EtcHints {
    pub(super) fn write(&self, bits: &mut BitWriter, has_bias: bool) {
        bits.put(u32::from(self.is_flipped), 1);
        bits.put(u32::from(self.is_differential), 1);
        for table in self.intensities {
            bits.put(table, 3);
        }
        if has_bias {
            bits.put(NO_BIAS, 5);
        }
    }
}

/// The hints for a block of several colours: the halves and tables with the least error.
pub(super) fn etc_hints(texels: &[Straight; 16]) -> EtcHints {
    let [upright, flipped] = [false, true].map(|is_flipped| hints_of_halves(texels, is_flipped));
    if flipped.0 < upright.0 {
        flipped.1
    } else {
        upright.1
    }
}

/// The hints for halves in one direction, with their error.
fn hints_of_halves(texels: &[Straight; 16], is_flipped: bool) -> (i32, EtcHints) {
    let halves = [0, 1].map(|half| {
        let is_inside = |at: usize| {
            let across = if is_flipped { at / 4 } else { at % 4 };
            across / 2 == half
        };
        let inside = (0..16).filter(|&at| is_inside(at));
        let colors: Vec<[i32; 3]> = inside
            .map(|at| [0, 1, 2].map(|c| i32::from(texels[at].0[c])))
            .collect();
        let mean = [0, 1, 2].map(|c| {
            let sum: i32 = colors.iter().map(|color| color[c]).sum();
            (sum + 4) / 8
        });
        (colors, mean)
    });
    let fine = |value: i32| (value * 31 + 127) / 255;
    let differences = [0, 1, 2].map(|c| fine(halves[1].1[c]) - fine(halves[0].1[c]));
    let is_differential = differences.iter().all(|d| (-4..=3).contains(d));
    let steps = if is_differential { 31 } else { 15 };
    let mut error = 0;
    let intensities = halves.each_ref().map(|(colors, mean)| {
        let base = mean.map(|value| (value * steps + 127) / 255 * 255 / steps);
        let best = (0..8).map(|table| (half_error(colors, base, table), table));
        let (least, table) = best.min().unwrap_or_default();
        error += least;
        table as u32
    });
    let hints = EtcHints {
        is_flipped,
        is_differential,
        intensities,
    };
    (error, hints)
}

/// Sum of squares of what is amiss with the colours of a half.
fn half_error(colors: &[[i32; 3]], base: [i32; 3], table: usize) -> i32 {
    let candidates = INTENSITIES[table].map(|step| base.map(|v| (v + step).clamp(0, 255)));
    colors
        .iter()
        .map(|color| {
            let error = |candidate: &[i32; 3]| -> i32 {
                let amiss = color.iter().zip(candidate).map(|(a, b)| a - b);
                amiss.map(|d| d * d).sum()
            };
            candidates.iter().map(error).min().unwrap_or_default()
        })
        .sum()
}

/// How ETC2 is to write the alpha of a block: a table, and above it the factor of its steps.
pub(super) fn alpha_hint(texels: &[Straight; 16]) -> u32 {
    let alphas = texels.map(|texel| i32::from(texel.alpha()));
    let (least, most) = alphas
        .iter()
        .fold((255, 0), |(a, b), &alpha| (alpha.min(a), alpha.max(b)));
    let hints = (0..16).map(|table| {
        let steps = ALPHA_STEPS[table];
        let (lowest, highest) = (steps[3], steps[7]);
        let width = highest - lowest;
        let factor = ((most - least + width / 2) / width).clamp(1, 15);
        let share = -lowest as f32 / width as f32;
        let base = (least as f32 + (most - least) as f32 * share + 0.5) as i32;
        let values = steps.map(|step| (base + step * factor).clamp(0, 255));
        let error: i32 = alphas
            .iter()
            .map(|alpha| {
                let nearest = values.iter().map(|value| (value - alpha).abs()).min();
                nearest.unwrap_or_default().pow(2)
            })
            .sum();
        (error, table as u32 | (factor as u32) << 4)
    });
    hints.min().unwrap_or_default().1
}

/// How ETC1 is to write a block of one colour.
pub(super) struct SolidHints {
    pub(super) is_differential: bool,
    pub(super) intensity: u32,
    /// Which step of the table: 0 the least.
    pub(super) selector: u32,
    /// Base colour in 5 bits a channel (4 when not differential).
    pub(super) base: [u32; 3],
}

/// The base colour, table and step that come nearest to `color`.
pub(super) fn solid_hints(color: Straight) -> SolidHints {
    let wide = |five: i32| five << 3 | five >> 2;
    let mut best = (i32::MAX, 0, 0, [0; 3]);
    // Wide tables are for blocks of several colours; their steps are too far apart to be of use.
    for (intensity, steps) in INTENSITIES.iter().enumerate().take(4) {
        for (selector, step) in steps.iter().enumerate() {
            let base = [0, 1, 2].map(|c| {
                let wanted = (i32::from(color.0[c]) - step).clamp(0, 255);
                (wanted * 31 + 127) / 255
            });
            let amiss = [0, 1, 2].map(|c| {
                let found = (wide(base[c]) + step).clamp(0, 255);
                found - i32::from(color.0[c])
            });
            let error = amiss.iter().map(|d| d * d).sum();
            if error < best.0 {
                best = (error, intensity, selector, base);
            }
        }
    }
    let (_, intensity, selector, base) = best;
    SolidHints {
        is_differential: true,
        intensity: intensity as u32,
        selector: selector as u32,
        base: base.map(|value| value as u32),
    }
}
