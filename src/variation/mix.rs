//! The pixels of a new tree, mixed of the pixels that its sources have at the warped places.
//!
//! Sixteen neighbours go together, one in each lane: the reads are scattered and stay scalar, all
//! arithmetic is lane by lane.

use super::Source;
use super::mean_value::{LANES, Lanes};
use super::sampling::bilinear_lanes;
use super::warp::{TILE, WarpTile};
use crate::base::Kernel;
use crate::raster::Premultiplied;
use crate::segment::Label;

/// The needed pixels of a tile, to be mixed of all sources.
pub(super) struct MixTile<'a> {
    /// For each source the places its pixels come from.
    pub parts: &'a [(WarpTile, &'a Source<'a>)],
    /// Bit x of row y: whether the pixel is wanted; the others become clear.
    pub needed: &'a [u32; TILE],
    /// Column of the tile in the picture.
    pub left: usize,
    /// Width of the picture.
    pub size: usize,
    /// The rows of the picture from the tile's first on.
    pub pixels: &'a mut [Premultiplied],
    /// Likewise.
    pub labels: &'a mut [Label],
}

impl Kernel for MixTile<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let pixels = self.pixels.chunks_mut(self.size);
        let rows = pixels.zip(self.labels.chunks_mut(self.size));
        for ((row, &bits), (pixels, labels)) in self.needed.iter().enumerate().zip(rows) {
            for first in (0..TILE).step_by(LANES) {
                let bits = bits >> first & LANE_BITS;
                if bits == 0 {
                    continue;
                }
                let mut mix = Mix::default();
                for (number, (tile, source)) in self.parts.iter().enumerate() {
                    let (x, y) = tile.row(row);
                    mix.add(source, number, &x[first..], &y[first..], bits);
                }
                let from = self.left + first;
                let colors = mix.colors();
                for (lane, pixel) in pixels[from..].iter_mut().take(LANES).enumerate() {
                    *pixel = Premultiplied(colors[lane].to_le_bytes());
                }
                for (lane, label) in labels[from..].iter_mut().take(LANES).enumerate() {
                    *label = mix.label(self.parts, lane);
                }
            }
        }
    }
}

/// A bit for each lane.
const LANE_BITS: u32 = (1 << LANES) - 1;

/// No source.
const NOBODY: u32 = u32::MAX;

/// The colours of [`LANES`] new pixels, coming together.
struct Mix {
    /// Σ weight · premultiplied colour, and Σ weight · alpha.
    sums: [Lanes; 4],
    /// The largest alpha, 0 to 255.
    most: Lanes,
    /// Weight · alpha of the source that counts most, its number and the pixel of it.
    strongest: Lanes,
    source: [u32; LANES],
    x: [i32; LANES],
    y: [i32; LANES],
}

impl Default for Mix {
    #[inline(always)]
    fn default() -> Self {
        Self {
            sums: [[0.0; LANES]; 4],
            most: [0.0; LANES],
            strongest: [0.0; LANES],
            source: [NOBODY; LANES],
            x: [0; LANES],
            y: [0; LANES],
        }
    }
}

impl Mix {
    /// Adds what `source`, the `number`-th, has at the places of the lanes whose bit is set.
    #[inline(always)]
    fn add(&mut self, source: &Source<'_>, number: usize, x: &[f32], y: &[f32], bits: u32) {
        // Places of unwanted pixels were never filled; any place inside does for them.
        let (mut own_x, mut own_y): (Lanes, Lanes) = ([0.0; LANES], [0.0; LANES]);
        let mut share: Lanes = [0.0; LANES];
        let weight = source.color_weight as f32;
        for lane in 0..LANES {
            let wanted = bits >> lane & 1 == 1;
            own_x[lane] = if wanted { x[lane] } else { 0.0 };
            own_y[lane] = if wanted { y[lane] } else { 0.0 };
            share[lane] = if wanted { 1.0 } else { 0.0 };
        }
        let color = bilinear_lanes(&source.exemplar.image, &own_x, &own_y);
        for (sums, values) in self.sums.iter_mut().zip(&color) {
            for lane in 0..LANES {
                sums[lane] += weight * values[lane] * share[lane];
            }
        }
        for lane in 0..LANES {
            let alpha = color[3][lane] * share[lane];
            self.most[lane] = self.most[lane].max(alpha);
            let stronger = weight * alpha > self.strongest[lane];
            let chosen = |new: i32, old: i32| if stronger { new } else { old };
            self.strongest[lane] = self.strongest[lane].max(weight * alpha);
            self.source[lane] = chosen(number as i32, self.source[lane] as i32) as u32;
            self.x[lane] = chosen(own_x[lane].round() as i32, self.x[lane]);
            self.y[lane] = chosen(own_y[lane].round() as i32, self.y[lane]);
        }
    }

    /// The premultiplied colours, red in the lowest byte.
    #[inline(always)]
    fn colors(&self) -> [u32; LANES] {
        let mut colors = [0; LANES];
        for (lane, color) in colors.iter_mut().enumerate() {
            let visible = self.sums[3][lane] > 0.0;
            let scale = self.most[lane] / self.sums[3][lane];
            let scale = if visible { scale } else { 0.0 };
            let rounded = |value: f32| (value + 0.5).min(255.0) as i32 as u32;
            let alpha = rounded(self.most[lane]);
            let byte = |channel: usize| rounded(self.sums[channel][lane] * scale).min(alpha);
            *color = byte(0) | byte(1) << 8 | byte(2) << 16 | alpha << 24;
        }
        colors
    }

    /// The label of the pixel that counts most.
    #[inline(always)]
    fn label(&self, parts: &[(WarpTile, &Source<'_>)], lane: usize) -> Label {
        let Some((_, source)) = parts.get(self.source[lane] as usize) else {
            return Label::default();
        };
        let (x, y) = (i64::from(self.x[lane]), i64::from(self.y[lane]));
        source.exemplar.labels.get(x, y).unwrap_or_default()
    }
}
