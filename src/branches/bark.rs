//! The look of bark: reflectance as a function of the place on a limb.

use super::noise::{noise2, ramp};
use glam::Vec3;

/// Kinds of bark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BarkKind {
    /// Deep ridges along the limb: oak, willow, old poplar.
    Furrowed,
    /// Pale skin with dark dashes across and black cracks low on the stem: birch.
    Birch,
    /// Nearly smooth with soft stains: beech, young trees, shrubs.
    Smooth,
    /// Plates between dark cracks: pine, spruce.
    Plates,
}

/// Bark of a species.
#[derive(Debug, Clone, Copy)]
pub struct Bark {
    /// Structure.
    pub kind: BarkKind,
    /// sRGB colour of sunlit bark low on the stem.
    pub low: [u8; 3],
    /// sRGB colour of limbs and of the upper stem.
    pub high: [u8; 3],
}

impl Bark {
    /// Factor on the bark's colour, about 0.3..1.4, at the arc length `around_m` and the length of
    /// wood `along_m`, both in metres, on a limb of radius `radius_m`.
    pub fn relief(&self, around_m: f32, along_m: f32, radius_m: f32) -> f32 {
        let grain = 1.0 + 0.16 * noise2(around_m * 90.0, along_m * 60.0, 3);
        let stain = 1.0 + 0.15 * noise2(around_m * 4.0, along_m * 2.5, 4);
        // Thin limbs are smooth whatever the stem looks like.
        let old = ramp(0.03, 0.12, radius_m);
        let structure = match self.kind {
            BarkKind::Furrowed => furrows(around_m, along_m),
            BarkKind::Birch => dashes(around_m, along_m),
            BarkKind::Smooth => 1.0 + 0.12 * noise2(around_m * 9.0, along_m * 22.0, 5),
            BarkKind::Plates => plates(around_m, along_m),
        };
        grain * stain * (1.0 + (structure - 1.0) * old)
    }

    /// sRGB colour in 0..255 at the share `height` of the tree's height.
    pub fn colour(&self, height: f32) -> Vec3 {
        let part = |bark: [u8; 3]| Vec3::from_array(bark.map(f32::from));
        part(self.low).lerp(part(self.high), ramp(0.05, 0.5, height))
    }
}

fn furrows(around_m: f32, along_m: f32) -> f32 {
    let wander = 0.06 * noise2(around_m * 5.0, along_m * 2.2, 11);
    let deep = noise2((around_m + wander) * 21.0, along_m * 3.1, 12).abs();
    let fine = noise2((around_m + wander) * 44.0, along_m * 8.0, 13).abs();
    let ridge = ramp(0.0, 0.24, deep) * (0.55 + 0.45 * ramp(0.0, 0.25, fine));
    0.60 + 0.55 * ridge
}

fn dashes(around_m: f32, along_m: f32) -> f32 {
    let dash = noise2(around_m * 9.0 + 3.0, along_m * 34.0, 21);
    let dark = ramp(0.38, 0.62, dash);
    let low = ramp(1.6, 0.1, along_m);
    let crack = ramp(
        0.25 - 0.5 * low,
        0.5 - 0.4 * low,
        noise2(around_m * 11.0, along_m * 5.0, 22),
    );
    1.08 - 0.55 * dark - 0.78 * crack * (0.25 + 0.75 * low)
}

fn plates(around_m: f32, along_m: f32) -> f32 {
    let bend = 0.05 * noise2(around_m * 6.0, along_m * 5.0, 31);
    let a = noise2((around_m + bend) * 17.0, (along_m + bend) * 6.5, 32).abs();
    let b = noise2((around_m - bend) * 30.0, (along_m + bend) * 11.0, 33).abs();
    let plate = ramp(0.0, 0.22, a) * (0.55 + 0.45 * ramp(0.0, 0.2, b));
    0.45 + 0.75 * plate
}
