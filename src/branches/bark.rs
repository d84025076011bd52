//! The look of bark: reflectance as a function of the place on a limb.
//!
//! Bark is a solid texture (Peachey 1985; Perlin 1985) in the limb's own frame: the place is given
//! on a cylinder around the limb's axis, so that nothing has a seam. Ridges and plates are cells
//! (Worley, *A Cellular Texture Basis Function*, 1996), drawn out along the limb.

use super::noise::{cells, noise3, ramp};
use glam::Vec3;
use serde::{Deserialize, Serialize};

/// Kinds of bark.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BarkKind {
    /// Deep ridges along the limb: oak, willow, old poplar.
    #[default]
    Furrowed,
    /// Pale skin with dark dashes across and black cracks low on the stem: birch.
    Birch,
    /// Nearly smooth with soft stains: beech, young trees, shrubs.
    Smooth,
    /// Plates between dark cracks: pine, spruce.
    Plates,
    /// Thin strips along the stem: cypress, juniper.
    Strips,
    /// Rings and stubs that fallen fronds leave: palms.
    Rings,
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
    /// Factor on the bark's colour, about 0.3..1.4, at `place` on a limb of radius `radius_m`.
    ///
    /// `place` is in the limb's frame, in metres: x and z across, on a circle of about the radius;
    /// y the length of wood below.
    pub fn relief(&self, place: Vec3, radius_m: f32) -> f32 {
        let at =
            |k: f32, along: f32, salt: u32| noise3(place.x * k, place.y * along, place.z * k, salt);
        let grain = 1.0 + 0.13 * at(90.0, 60.0, 3);
        let stain = 1.0 + 0.16 * at(4.0, 2.0, 4) + 0.10 * at(1.3, 0.8, 5);
        // Thin limbs are smooth whatever the stem looks like.
        let old = ramp(0.025, 0.10, radius_m);
        let structure = match self.kind {
            BarkKind::Furrowed => furrows(place),
            BarkKind::Birch => dashes(place),
            BarkKind::Smooth => 1.0 + 0.12 * at(9.0, 22.0, 6),
            BarkKind::Plates => plates(place),
            BarkKind::Strips => strips(place),
            BarkKind::Rings => rings(place, radius_m),
        };
        grain * stain * (1.0 + (structure - 1.0) * old)
    }

    /// sRGB colour in 0..255 at the share `height` of the tree's height.
    pub fn colour(&self, height: f32) -> Vec3 {
        let part = |bark: [u8; 3]| Vec3::from_array(bark.map(f32::from));
        part(self.low).lerp(part(self.high), ramp(0.05, 0.5, height))
    }
}

/// `place` bent sideways, so that what is drawn out along the limb meanders.
fn bent(place: Vec3, by: f32, along: f32, salt: u32) -> Vec3 {
    let shift = |salt| by * noise3(place.x * 5.0, place.y * along, place.z * 5.0, salt);
    place + Vec3::new(shift(salt), 0.4 * shift(salt + 1), shift(salt + 2))
}

fn furrows(place: Vec3) -> f32 {
    let bent = bent(place, 0.035, 2.4, 11);
    let long = cells(bent * Vec3::new(17.0, 2.3, 17.0), 12);
    let fine = cells(bent * Vec3::new(38.0, 9.0, 38.0), 13);
    let ridge = ramp(0.02, 0.34, long.gap);
    let crust = ramp(0.0, 0.3, fine.gap);
    (0.40 + 0.62 * ridge) * (0.74 + 0.28 * crust) + 0.14 * (long.own - 0.5)
}

fn dashes(place: Vec3) -> f32 {
    let dash = noise3(place.x * 8.0 + 3.0, place.y * 36.0, place.z * 8.0, 21);
    let long = noise3(place.x * 3.0, place.y * 55.0, place.z * 3.0, 24);
    let dark = ramp(0.42, 0.62, dash).max(0.7 * ramp(0.52, 0.66, long));
    let low = ramp(1.9, 0.1, place.y);
    let crack = noise3(place.x * 10.0, place.y * 4.2, place.z * 10.0, 22)
        + 0.35 * noise3(place.x * 30.0, place.y * 13.0, place.z * 30.0, 23);
    let black = ramp(0.42 - 0.55 * low, 0.60 - 0.45 * low, crack);
    1.08 - 0.58 * dark - 0.80 * black * (0.35 + 0.65 * low)
}

fn plates(place: Vec3) -> f32 {
    let bent = bent(place, 0.05, 6.0, 31);
    let large = cells(bent * Vec3::new(15.0, 4.6, 15.0), 32);
    let small = cells(bent * Vec3::new(40.0, 19.0, 40.0), 33);
    // Cracks open here and close there.
    let open = 0.62 + 0.38 * noise3(place.x * 7.0, place.y * 4.0, place.z * 7.0, 34);
    let crack = open * ramp(0.30, 0.02, large.gap);
    let flake = ramp(0.0, 0.3, small.gap);
    (1.0 - 0.58 * crack) * (0.78 + 0.26 * flake)
        + 0.24 * (large.own - 0.5) * (1.0 - crack)
        + 0.20 * (small.own - 0.5)
}

fn strips(place: Vec3) -> f32 {
    let bent = bent(place, 0.03, 1.5, 41);
    let strip = cells(bent * Vec3::new(34.0, 1.6, 34.0), 42);
    0.62 + 0.42 * ramp(0.0, 0.4, strip.gap) + 0.2 * (strip.own - 0.5)
}

fn rings(place: Vec3, radius_m: f32) -> f32 {
    let out = (place.x * place.x + place.z * place.z).sqrt().max(1e-4);
    let (x, z) = (place.x / out, place.z / out);
    // Scars wander up and down around the stem.
    let wander = 0.02 * noise3(2.0 * x, place.y * 3.0, 2.0 * z, 51)
        + 0.012 * noise3(6.0 * x, place.y * 9.0, 6.0 * z, 52);
    let turn = (place.y + wander) * 13.0;
    let phase = turn - libm::floorf(turn);
    let scar = ramp(0.0, 0.16, phase) * (1.0 - 0.35 * ramp(0.45, 1.0, phase));
    let fibre = cells(
        Vec3::new(x, 0.06 * place.y / radius_m.max(0.05), z) * 16.0,
        53,
    );
    (0.40 + 0.72 * scar) * (0.78 + 0.26 * ramp(0.0, 0.3, fibre.gap)) + 0.16 * (fibre.own - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bark_has_contrast_on_stems_and_none_of_it_is_black_or_glaring() {
        for kind in [
            BarkKind::Furrowed,
            BarkKind::Birch,
            BarkKind::Smooth,
            BarkKind::Plates,
            BarkKind::Strips,
            BarkKind::Rings,
        ] {
            let bark = Bark {
                kind,
                low: [128; 3],
                high: [128; 3],
            };
            let values: Vec<f32> = (0..4000)
                .map(|i| {
                    let (turn, y) = ((i % 50) as f32 * 0.05, (i / 50) as f32 * 0.02);
                    let place = Vec3::new(libm::cosf(turn), 0.0, libm::sinf(turn)) * 0.2;
                    // The painter keeps it in this range.
                    bark.relief(place + Vec3::Y * y, 0.2).clamp(0.1, 1.6)
                })
                .collect();
            let mean = values.iter().sum::<f32>() / values.len() as f32;
            let low = values.iter().copied().fold(f32::INFINITY, f32::min);
            let high = values.iter().copied().fold(0.0, f32::max);
            assert!((0.6..1.2).contains(&mean), "{kind:?}: mean {mean}");
            assert!(high - low > 0.3, "{kind:?}: {low}..{high}");
        }
    }
}
