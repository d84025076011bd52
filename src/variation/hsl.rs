//! Hue, saturation and lightness, and a tree moved in them: what scenes commonly do to tell copies
//! apart.
//!
//! After A. R. Smith, *Color Gamut Transform Pairs* (1978), the double hexcone. Hue in turns.

use crate::base::Random;
use crate::raster::{Image, Straight};
use serde::{Deserialize, Serialize};

/// Largest change of hue in turns, of saturation and lightness as shares: a tenth of a turn more
/// would make green trees blue.
const MOST_HUE: f64 = 18.0 / 360.0;
const MOST_SATURATION: f64 = 0.2;
const MOST_LIGHTNESS: f64 = 0.15;

/// A change of all colours of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct HslShift {
    /// Added to the hue, in turns.
    pub hue: f64,
    /// Factor of the saturation.
    pub saturation: f64,
    /// Factor of the lightness.
    pub lightness: f64,
}

impl HslShift {
    /// No change.
    pub const NONE: Self = Self {
        hue: 0.0,
        saturation: 1.0,
        lightness: 1.0,
    };

    /// The change that a scene of jittered copies gives one of them; `amount` 0 is none.
    pub fn drawn(amount: f64, random: &mut Random) -> Self {
        let mut within = |most: f64| amount * random.between(-most, most);
        Self {
            hue: within(MOST_HUE),
            saturation: 1.0 + within(MOST_SATURATION),
            lightness: 1.0 + within(MOST_LIGHTNESS),
        }
    }

    /// The change between this one (`share` 0) and `other` (1).
    #[must_use]
    pub fn between(&self, other: &Self, share: f64) -> Self {
        let mixed = |a: f64, b: f64| a + (b - a) * share;
        Self {
            hue: mixed(self.hue, other.hue),
            saturation: mixed(self.saturation, other.saturation),
            lightness: mixed(self.lightness, other.lightness),
        }
    }

    /// This change and `other` after it, no larger than one drawn with the amount `most`.
    #[must_use]
    pub fn and(&self, other: &Self, most: f64) -> Self {
        let hue = most * MOST_HUE;
        let near_one = |value: f64, range: f64| value.clamp(1.0 - most * range, 1.0 + most * range);
        Self {
            hue: (self.hue + other.hue).clamp(-hue, hue),
            saturation: near_one(self.saturation * other.saturation, MOST_SATURATION),
            lightness: near_one(self.lightness * other.lightness, MOST_LIGHTNESS),
        }
    }

    /// The pixel so changed; alpha stays.
    pub fn applied(&self, pixel: Straight) -> Straight {
        let [r, g, b, a] = pixel.0;
        if a == 0 {
            return pixel;
        }
        let [hue, saturation, lightness] = hsl([r, g, b]);
        let hue = hue + self.hue;
        let moved = [
            hue - hue.floor(),
            (saturation * self.saturation).clamp(0.0, 1.0),
            (lightness * self.lightness).clamp(0.0, 1.0),
        ];
        let [r, g, b] = rgb(moved);
        Straight([r, g, b, a])
    }

    /// Changes all pixels of `image`.
    pub fn apply(&self, image: &mut Image<Straight>) {
        for pixel in image.pixels_mut() {
            *pixel = self.applied(*pixel);
        }
    }
}

/// Hue in turns, saturation and lightness, 0 to 1 each; grey has hue 0.
pub fn hsl(color: [u8; 3]) -> [f64; 3] {
    let [r, g, b] = color.map(|channel| f64::from(channel) / 255.0);
    let (high, low) = (r.max(g).max(b), r.min(g).min(b));
    let (sum, range) = (high + low, high - low);
    if range <= 0.0 {
        return [0.0, 0.0, sum / 2.0];
    }
    let sixths = if high == r {
        (g - b) / range + if g < b { 6.0 } else { 0.0 }
    } else if high == g {
        (b - r) / range + 2.0
    } else {
        (r - g) / range + 4.0
    };
    let room = 1.0 - (sum - 1.0).abs();
    [sixths / 6.0, range / room.max(1e-9), sum / 2.0]
}

/// The colour of that hue in turns, saturation and lightness.
pub fn rgb([hue, saturation, lightness]: [f64; 3]) -> [u8; 3] {
    let range = saturation * (1.0 - (2.0 * lightness - 1.0).abs());
    let low = lightness - range / 2.0;
    let channel = |shift: f64| {
        let turns = hue + shift;
        let sixths = 6.0 * (turns - turns.floor());
        let share = ((sixths - 3.0).abs() - 1.0).clamp(0.0, 1.0);
        (255.0 * (low + range * share) + 0.5) as u8
    };
    [channel(0.0), channel(2.0 / 3.0), channel(1.0 / 3.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Seed;

    #[test]
    fn known_colours_have_known_hues() {
        let near = |found: [f64; 3], expected: [f64; 3]| {
            let pairs = found.iter().zip(expected);
            pairs
                .clone()
                .for_each(|(a, b)| assert!((a - b).abs() < 3e-3, "{found:?}"));
        };
        near(hsl([255, 0, 0]), [0.0, 1.0, 0.5]);
        near(hsl([0, 255, 0]), [1.0 / 3.0, 1.0, 0.5]);
        near(hsl([0, 0, 128]), [2.0 / 3.0, 1.0, 0.251]);
        // CSS: darkolivegreen is hsl(82, 39 %, 30 %).
        near(hsl([85, 107, 47]), [82.0 / 360.0, 0.39, 0.302]);
    }

    #[test]
    fn every_colour_comes_back() {
        let mut random = Seed(1).random();
        for _ in 0..5000 {
            let color = [0; 3].map(|_| random.below(256) as u8);
            assert_eq!(rgb(hsl(color)), color);
        }
    }

    #[test]
    fn no_amount_changes_nothing() {
        let none = HslShift::drawn(0.0, &mut Seed(2).random());
        let pixel = Straight([12, 140, 33, 200]);
        assert_eq!(none.applied(pixel), pixel);
        let some = HslShift::drawn(1.0, &mut Seed(2).random());
        assert_ne!(some.applied(pixel), pixel);
        assert_eq!(some.applied(Straight([1, 2, 3, 0])), Straight([1, 2, 3, 0]));
    }
}
