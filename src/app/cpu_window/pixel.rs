//! Arithmetic of pixels: `0xAARRGGBB`, premultiplied, in gamma space; four channels at once in the
//! 16-bit lanes of a `u64`.

/// What changes nothing that it is multiplied with.
pub(super) const WHITE: u32 = u32::MAX;

const LANES: u64 = 0x00ff_00ff_00ff_00ff;
const ONES: u64 = 0x0001_0001_0001_0001;

/// The pixel of a colour of egui.
#[inline(always)]
pub(super) fn pixel(color: egui::Color32) -> u32 {
    let [red, green, blue, alpha] = color.to_array();
    u32::from_be_bytes([alpha, red, green, blue])
}

#[inline(always)]
pub(super) fn alpha(pixel: u32) -> u32 {
    pixel >> 24
}

#[inline(always)]
fn spread(pixel: u32) -> u64 {
    let (high, low) = (pixel & 0xff00_ff00, pixel & 0x00ff_00ff);
    (u64::from(high) << 24) | u64::from(low)
}

/// Of lanes that are bytes.
#[inline(always)]
fn gathered(lanes: u64) -> u32 {
    ((lanes >> 24) as u32 & 0xff00_ff00) | (lanes as u32 & 0x00ff_00ff)
}

/// Lanes up to 255² through 255, rounded.
#[inline(always)]
fn through_255(lanes: u64) -> u64 {
    let rounded = lanes + 128 * ONES;
    ((rounded + ((rounded >> 8) & LANES)) >> 8) & LANES
}

/// All channels of `pixel` times `by` / 255.
#[inline(always)]
fn scaled(pixel: u32, by: u32) -> u32 {
    gathered(through_255(spread(pixel) * u64::from(by)))
}

/// The product of two pixels, channel by channel.
#[inline(always)]
pub(super) fn product(one: u32, other: u32) -> u32 {
    if one == WHITE {
        return other;
    }
    if other == WHITE {
        return one;
    }
    let gray = one & 0xff;
    if one == gray * 0x0101_0101 {
        // Text: what a glyph covers.
        return scaled(other, gray);
    }
    let (one, other) = (one.to_ne_bytes(), other.to_ne_bytes());
    let mut product = [0; 4];
    for channel in 0..4 {
        let exact = u32::from(one[channel]) * u32::from(other[channel]) + 128;
        product[channel] = ((exact + (exact >> 8)) >> 8) as u8;
    }
    u32::from_ne_bytes(product)
}

/// `above` laid over `below`; light that adds (alpha 0) is kept.
#[inline(always)]
pub(super) fn over(below: u32, above: u32) -> u32 {
    match alpha(above) {
        255 => above,
        0 if above == 0 => below,
        opacity => {
            let seen = through_255(spread(below) * u64::from(255 - opacity));
            let sum = seen + spread(above);
            let too_much = (sum >> 8) & ONES;
            gathered((sum | (too_much * 255)) & LANES)
        }
    }
}

/// From `from` to `to` by `share` / 256, which is less than 256.
#[inline(always)]
pub(super) fn between(from: u32, to: u32, share: u32) -> u32 {
    let share = u64::from(share);
    let sum = spread(from) * (256 - share) + spread(to) * share + 128 * ONES;
    gathered((sum >> 8) & LANES)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rounded(value: f64) -> u32 {
        value.round().min(255.0) as u32
    }

    fn channels(pixel: u32) -> [f64; 4] {
        pixel.to_be_bytes().map(f64::from)
    }

    #[test]
    fn channels_are_what_real_numbers_say() {
        let mut random = crate::base::Seed(5).random();
        let mut number = || (random.below(1 << 16) as u32) << 16 | random.below(1 << 16) as u32;
        for _ in 0..20_000 {
            let (a, b) = (number(), number());
            let (x, y) = (channels(a), channels(b));
            let times: Vec<u32> = (0..4).map(|i| rounded(x[i] * y[i] / 255.0)).collect();
            assert_eq!(channels(product(a, b)), channels_of(&times));
            let opacity = y[0];
            let blend = |i: usize| y[i] + (x[i] * (255.0 - opacity) / 255.0).round();
            let laid: Vec<u32> = (0..4).map(|i| rounded(blend(i))).collect();
            assert_eq!(channels(over(a, b)), channels_of(&laid), "{a:x} {b:x}");
            let share = f64::from(a & 0xff);
            let mixed = |i: usize| (x[i] * (256.0 - share) + y[i] * share + 128.0) / 256.0;
            let mixed: Vec<u32> = (0..4).map(|i| mixed(i).floor() as u32).collect();
            assert_eq!(channels(between(a, b, a & 0xff)), channels_of(&mixed));
        }
    }

    fn channels_of(values: &[u32]) -> [f64; 4] {
        std::array::from_fn(|i| f64::from(values[i]))
    }
}
