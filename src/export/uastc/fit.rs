//! The line through colour space that lies nearest to the texels of a block.
//!
//! It starts as the principal axis of the texels. Then ends are rounded to what can be written, each
//! texel takes the nearest step between them, and the ends are solved anew for these steps (least
//! squares), a few times; the best line that was seen wins.

use super::bits::Quantizer;
use crate::raster::Straight;
use std::ops::Range;

/// How often ends are solved anew.
const ROUNDS: usize = 3;

/// Steps of the power iteration for the principal axis: blocks have four dimensions, and the ends
/// are solved anew anyway.
const AXIS_STEPS: usize = 4;

/// How much the colour of a clear texel counts, where that of a solid one counts 1: filters mix
/// it in beside visible ones.
const CLEAR_WEIGHT: f32 = 0.06;

/// Texels of a block as numbers, and how much their colours count.
pub(super) struct Texels {
    values: [[f32; 4]; 16],
    color_weights: [f32; 16],
}

impl Texels {
    pub(super) fn of(texels: &[Straight; 16]) -> Self {
        Self {
            values: texels.map(|texel| texel.0.map(f32::from)),
            color_weights: texels.map(|texel| {
                let alpha = f32::from(texel.alpha()) / 255.0;
                alpha.max(CLEAR_WEIGHT)
            }),
        }
    }

    fn weight(&self, texel: usize, channel: usize) -> f32 {
        if channel == 3 {
            1.0
        } else {
            self.color_weights[texel]
        }
    }
}

/// A line between two ends, and where each texel lies on it.
#[derive(Debug, Clone)]
pub(super) struct Line {
    /// The codes of both ends, by channel.
    pub(super) ends: Vec<[u8; 2]>,
    /// Steps from the first end; the highest bit of the first texel's is zero.
    pub(super) weights: [u8; 16],
    /// Sum of the weighted squares of what is amiss.
    pub(super) error: f32,
}

/// The line nearest to `channels` of the texels, with weights of `weight_bits` bits and ends that
/// `quantizer` can write.
pub(super) fn line(
    texels: &Texels,
    channels: Range<usize>,
    weight_bits: u32,
    quantizer: &Quantizer,
) -> Line {
    let (mut low, mut high) = principal_ends(texels, &channels);
    let mut best: Option<Line> = None;
    for round in 0..ROUNDS {
        let line = rounded_line(texels, &channels, weight_bits, quantizer, &low, &high);
        let steps = line.weights;
        let is_better = best.as_ref().is_none_or(|best| line.error < best.error);
        if is_better {
            best = Some(line);
        }
        if round + 1 == ROUNDS || !is_better {
            break;
        }
        let ramp = ramp(weight_bits);
        let shares = steps.map(|step| f32::from(ramp[usize::from(step)]) / 64.0);
        for channel in channels.clone() {
            if let Some(ends) = solved_ends(texels, channel, &shares) {
                [low[channel], high[channel]] = ends;
            }
        }
    }
    let Some(line) = best else {
        unreachable!("there is at least one round")
    };
    anchored(line, weight_bits)
}

/// Where the texels' principal axis enters and leaves them.
fn principal_ends(texels: &Texels, channels: &Range<usize>) -> ([f32; 4], [f32; 4]) {
    let mut mean = [0.0; 4];
    for channel in channels.clone() {
        let (mut sum, mut total) = (0.0, 0.0);
        for (texel, value) in texels.values.iter().enumerate() {
            let weight = texels.weight(texel, channel);
            sum += weight * value[channel];
            total += weight;
        }
        mean[channel] = sum / total;
    }
    let mut covariance = [[0.0f32; 4]; 4];
    for (texel, value) in texels.values.iter().enumerate() {
        for a in channels.clone() {
            for b in channels.clone() {
                let weight = texels.weight(texel, a) * texels.weight(texel, b);
                covariance[a][b] += weight * (value[a] - mean[a]) * (value[b] - mean[b]);
            }
        }
    }
    let axis = principal_axis(&covariance, channels);
    let along = |value: &[f32; 4]| -> f32 {
        let channels = channels.clone();
        channels.map(|c| (value[c] - mean[c]) * axis[c]).sum()
    };
    let (mut least, mut most) = (0.0f32, 0.0f32);
    for value in &texels.values {
        let at = along(value);
        least = least.min(at);
        most = most.max(at);
    }
    let at = |t: f32| std::array::from_fn(|c| mean[c] + t * axis[c]);
    (at(least), at(most))
}

/// The unit vector along which `covariance` is largest.
fn principal_axis(covariance: &[[f32; 4]; 4], channels: &Range<usize>) -> [f32; 4] {
    let largest = channels
        .clone()
        .max_by(|&a, &b| covariance[a][a].total_cmp(&covariance[b][b]))
        .unwrap_or(channels.start);
    let mut axis = covariance[largest];
    for _ in 0..AXIS_STEPS {
        axis = unit(axis, largest);
        axis = std::array::from_fn(|row| {
            let products = covariance[row].iter().zip(axis);
            products.map(|(a, b)| a * b).sum()
        });
    }
    unit(axis, largest)
}

/// `vector` of length 1; along `channel` where it has none.
fn unit(vector: [f32; 4], channel: usize) -> [f32; 4] {
    let length = vector.iter().map(|v| v * v).sum::<f32>().sqrt();
    if length > 1e-6 {
        vector.map(|v| v / length)
    } else {
        std::array::from_fn(|c| if c == channel { 1.0 } else { 0.0 })
    }
}

/// The line between the ends nearest to `low` and `high` that can be written.
fn rounded_line(
    texels: &Texels,
    channels: &Range<usize>,
    weight_bits: u32,
    quantizer: &Quantizer,
    low: &[f32; 4],
    high: &[f32; 4],
) -> Line {
    let ends: Vec<[u8; 2]> = channels
        .clone()
        .map(|c| [quantizer.code(low[c]), quantizer.code(high[c])])
        .collect();
    let values: Vec<[u8; 2]> = ends.iter().map(|e| e.map(|c| quantizer.value(c))).collect();
    let ramp = ramp(weight_bits);
    let last = (ramp.len() - 1) as f32;
    let mut weights = [0u8; 16];
    let mut error = 0.0;
    for (texel, value) in texels.values.iter().enumerate() {
        let (mut along, mut length) = (0.0, 0.0);
        for (c, ends) in channels.clone().zip(&values) {
            let [from, to] = ends.map(f32::from);
            let weight = texels.weight(texel, c);
            along += weight * (value[c] - from) * (to - from);
            length += weight * (to - from) * (to - from);
        }
        let share = if length > 0.0 { along / length } else { 0.0 };
        let step = (share * last + 0.5).clamp(0.0, last) as u8;
        weights[texel] = step;
        for (c, &ends) in channels.clone().zip(&values) {
            let amiss = value[c] - f32::from(between(ends, ramp[usize::from(step)]));
            error += texels.weight(texel, c) * amiss * amiss;
        }
    }
    Line {
        ends,
        weights,
        error,
    }
}

/// The ends of `channel` whose line is nearest to the texels at the given shares of the way; none
/// where all texels lie at one place.
fn solved_ends(texels: &Texels, channel: usize, shares: &[f32; 16]) -> Option<[f32; 2]> {
    let (mut aa, mut ab, mut bb, mut at, mut bt) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (texel, &share) in shares.iter().enumerate() {
        let weight = texels.weight(texel, channel);
        let value = texels.values[texel][channel];
        let (a, b) = (1.0 - share, share);
        aa += weight * a * a;
        ab += weight * a * b;
        bb += weight * b * b;
        at += weight * a * value;
        bt += weight * b * value;
    }
    let determinant = aa * bb - ab * ab;
    (determinant > 1e-4).then(|| {
        [
            (at * bb - bt * ab) / determinant,
            (bt * aa - at * ab) / determinant,
        ]
    })
}

/// The same line from its other end, where the first texel's weight has its highest bit set.
fn anchored(line: Line, weight_bits: u32) -> Line {
    let last = (1u8 << weight_bits) - 1;
    if line.weights[0] <= last / 2 {
        return line;
    }
    Line {
        ends: line.ends.iter().map(|&[low, high]| [high, low]).collect(),
        weights: line.weights.map(|step| last - step),
        error: line.error,
    }
}

/// What a decoder makes of two ends and a weight in 64ths.
fn between([from, to]: [u8; 2], weight: u8) -> u8 {
    let [from, to] = [from, to].map(|end| u32::from(end) * 257);
    let weight = u32::from(weight);
    (((from * (64 - weight) + to * weight + 32) >> 6) >> 8) as u8
}

/// The weights of `bits` bits, in 64ths.
fn ramp(bits: u32) -> &'static [u8] {
    match bits {
        1 => &[0, 64],
        2 => &[0, 21, 43, 64],
        3 => &[0, 9, 18, 27, 37, 46, 55, 64],
        4 => &[0, 4, 8, 12, 17, 21, 25, 29, 35, 39, 43, 47, 52, 56, 60, 64],
        _ => &[
            0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30, 34, 36, 38, 40, 42, 44, 46,
            48, 50, 52, 54, 56, 58, 60, 62, 64,
        ],
    }
}
