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
        let weights = self
            .parts
            .iter()
            .map(|(_, source)| source.color_weight as f32);
        let heaviest = weights.fold(f32::MIN_POSITIVE, f32::max);
        let pixels = self.pixels.chunks_mut(self.size);
        let rows = pixels.zip(self.labels.chunks_mut(self.size));
        for ((row, &bits), (pixels, labels)) in self.needed.iter().enumerate().zip(rows) {
            for first in (0..TILE).step_by(LANES) {
                let bits = bits >> first & LANE_BITS;
                if bits == 0 {
                    continue;
                }
                let share: Lanes = std::array::from_fn(|lane| (bits >> lane & 1) as f32);
                let mut mix = Mix::default();
                for (number, (tile, source)) in (0..).zip(self.parts) {
                    let (x, y) = tile.row(row);
                    let (x, y) = (wanted(x, first, bits), wanted(y, first, bits));
                    let presence = presence(source, heaviest);
                    mix.add((source, number), presence, &x, &y, &share);
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
const NOBODY: i32 = -1;

/// The values from `first` on in the lanes whose bit is set. The others were never filled and become
/// 0, a place that every picture has.
#[inline(always)]
fn wanted(values: &[f32], first: usize, bits: u32) -> Lanes {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&values[first..first + LANES]);
    for (lane, value) in lanes.iter_mut().enumerate() {
        *value = if bits & 1 << lane != 0 { *value } else { 0.0 };
    }
    lanes
}

/// How much of its alpha a source may impose, 0 to 1: all of it from half of the largest weight on.
///
/// Departure from the paper, which takes the largest alpha whatever the weights: there a source of
/// weight 0.01 still draws its whole silhouette, a fringe of other colour round the tree, and pops
/// up as soon as a morph leaves its first picture.
#[inline(always)]
fn presence(source: &Source<'_>, heaviest: f32) -> f32 {
    (2.0 * source.color_weight as f32 / heaviest).min(1.0)
}

/// The colours of [`LANES`] new pixels, coming together.
struct Mix {
    /// Σ weight · premultiplied colour, and Σ weight · alpha.
    sums: [Lanes; 4],
    /// The largest alpha, 0 to 255.
    most: Lanes,
    /// Weight · alpha of the source that counts most, its number and the place in it.
    strongest: Lanes,
    source: [i32; LANES],
    x: Lanes,
    y: Lanes,
}

impl Default for Mix {
    #[inline(always)]
    fn default() -> Self {
        Self {
            sums: [[0.0; LANES]; 4],
            most: [0.0; LANES],
            strongest: [0.0; LANES],
            source: [NOBODY; LANES],
            x: [0.0; LANES],
            y: [0.0; LANES],
        }
    }
}

impl Mix {
    /// Adds what `source`, the `number`-th, has at (`x`, `y`) in the lanes of which `share` is 1.
    #[inline(always)]
    fn add(
        &mut self,
        (source, number): (&Source<'_>, i32),
        presence: f32,
        x: &Lanes,
        y: &Lanes,
        share: &Lanes,
    ) {
        let weight = source.color_weight as f32;
        let color = bilinear_lanes(&source.exemplar.image, x, y);
        for (sums, values) in self.sums.iter_mut().zip(&color) {
            for lane in 0..LANES {
                sums[lane] += weight * values[lane] * share[lane];
            }
        }
        for lane in 0..LANES {
            let alpha = color[3][lane] * share[lane];
            let strength = weight * alpha;
            let stronger = strength > self.strongest[lane];
            self.most[lane] = self.most[lane].max(alpha * presence);
            self.strongest[lane] = if stronger {
                strength
            } else {
                self.strongest[lane]
            };
            self.source[lane] = if stronger { number } else { self.source[lane] };
            self.x[lane] = if stronger { x[lane] } else { self.x[lane] };
            self.y[lane] = if stronger { y[lane] } else { self.y[lane] };
        }
    }

    /// The premultiplied colours, red in the lowest byte.
    #[inline(always)]
    fn colors(&self) -> [u32; LANES] {
        let [red, green, blue, sum] = &self.sums;
        let (mut scale, mut colors) = ([0.0; LANES], [0; LANES]);
        for lane in 0..LANES {
            let quotient = self.most[lane] / sum[lane];
            scale[lane] = if sum[lane] > 0.0 { quotient } else { 0.0 };
        }
        for lane in 0..LANES {
            let alpha = rounded(self.most[lane]);
            let red = rounded(red[lane] * scale[lane]).min(alpha);
            let green = rounded(green[lane] * scale[lane]).min(alpha);
            let blue = rounded(blue[lane] * scale[lane]).min(alpha);
            colors[lane] = red | green << 8 | blue << 16 | alpha << 24;
        }
        colors
    }

    /// The label of the pixel that counts most.
    #[inline(always)]
    fn label(&self, parts: &[(WarpTile, &Source<'_>)], lane: usize) -> Label {
        let source = usize::try_from(self.source[lane]).ok();
        let Some((_, source)) = source.and_then(|number| parts.get(number)) else {
            return Label::default();
        };
        let (x, y) = (self.x[lane].round() as i64, self.y[lane].round() as i64);
        source.exemplar.labels.get(x, y).unwrap_or_default()
    }
}

/// The nearest of 0 to 255 to a value that is not negative.
#[inline(always)]
fn rounded(value: f32) -> u32 {
    (value + 0.5).min(255.0) as i32 as u32
}
