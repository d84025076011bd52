//! How pieces of foliage meet: which leaf is in front, how ragged the border is, what is seen behind an edge.

use super::noise::Noise;
use crate::base::Seed;
use crate::raster::Straight;

/// Sky.
pub(super) const CLEAR: Straight = Straight([0; 4]);

/// How ragged the borders of cells are and how fine, in cell sizes: as leaves are.
const RAGGED: f32 = 0.3;
const RAG: f64 = 0.09;

/// The edge of a leaf before what lies behind it, which is seen the less the less there is of the leaf: gaps stay.
pub(super) fn over(leaf: Straight, behind: Straight) -> Straight {
    let [r, g, b, alpha] = leaf.0;
    let share = f32::from(alpha) / 255.0;
    let [behind_r, behind_g, behind_b, behind_alpha] = behind.0;
    let seen = (share * f32::from(behind_alpha)) as u8;
    let behind = Straight([behind_r, behind_g, behind_b, seen]);
    mixed(Straight([r, g, b, 255]), behind, share)
}

/// `share` of the one and else of the other: what lies between leaf and sky is neither.
pub(super) fn mixed(one: Straight, other: Straight, share: f32) -> Straight {
    if share >= 1.0 || one == other {
        return one;
    }
    let [own, rest] =
        [(one, share), (other, 1.0 - share)].map(|(pixel, share)| share * f32::from(pixel.alpha()));
    let alpha = own + rest;
    let channel = |c: usize| {
        let sum = own * f32::from(one.0[c]) + rest * f32::from(other.0[c]);
        (sum / alpha.max(1e-6) + 0.5) as u8
    };
    Straight([channel(0), channel(1), channel(2), (alpha + 0.5) as u8])
}

/// What makes the borders of cells ragged: a tile of noise, of which each cell sees another part.
pub(super) struct Rags {
    tile: Vec<f32>,
    /// Pixels of the tile for one of the picture.
    scale: f32,
}

impl Rags {
    const SIDE: usize = 256;

    pub(super) fn new(side: f64) -> Self {
        /// Pixels of the tile in a wave.
        const WAVE: f64 = 12.0;
        let noise = Noise::new(&mut Seed(0).random());
        let at = |i: usize| [i % Self::SIDE, i / Self::SIDE].map(|along| along as f64 / WAVE);
        let value = |i| RAGGED * (noise.at(at(i)) as f32 - 0.5);
        Self {
            tile: (0..Self::SIDE * Self::SIDE).map(value).collect(),
            scale: (WAVE / (RAG * side)) as f32,
        }
    }

    pub(super) fn at(&self, cell: usize, x: usize, y: usize) -> f32 {
        let place = |along: usize, offset: usize| {
            ((along as f32 * self.scale) as usize + cell * offset) % Self::SIDE
        };
        self.tile[place(y, 47) * Self::SIDE + place(x, 29)]
    }
}

/// How far in front the leaf is, 0 to 1, that a pixel shows with its light moved: lighter ones are.
pub(super) fn front(pixel: Straight, lift: f32) -> f32 {
    let shown = f32::from(pixel.alpha()) / 255.0;
    shown * (0.25 + 0.75 * (pixel.luma() + lift) / 255.0)
}

/// The pixel with its light moved.
pub(super) fn lifted(pixel: Straight, lift: f32) -> Straight {
    let [r, g, b, alpha] = pixel.0;
    // By a factor: shade keeps its colour.
    let own = pixel.luma().max(8.0);
    let factor = ((own + lift) / own).clamp(0.6, 1.6);
    let scaled = |value: u8| (f32::from(value) * factor + 0.5).min(255.0) as u8;
    Straight([scaled(r), scaled(g), scaled(b), alpha])
}

#[cfg(test)]
mod tests {
    use super::*;

    const LEAF: Straight = Straight([40, 90, 30, 255]);
    const EDGE: Straight = Straight([40, 90, 30, 128]);
    const SHADE: Straight = Straight([10, 20, 10, 255]);

    #[test]
    fn gaps_stay_gaps_and_edges_show_what_is_behind() {
        assert_eq!(over(CLEAR, SHADE).alpha(), 0);
        assert_eq!(over(LEAF, SHADE), LEAF);
        assert_eq!(over(EDGE, CLEAR), EDGE);
        let edge = over(EDGE, SHADE);
        assert!((160..224).contains(&edge.alpha()), "{edge:?}");
        assert!((SHADE.0[1]..LEAF.0[1]).contains(&edge.0[1]), "{edge:?}");
    }

    #[test]
    fn what_ends_softly_keeps_its_colour() {
        assert_eq!(mixed(LEAF, CLEAR, 1.0), LEAF);
        assert_eq!(mixed(LEAF, CLEAR, 0.5), EDGE);
        assert_eq!(mixed(LEAF, LEAF, 0.5), LEAF);
    }
}
