//! How deep in a crown a place lies, gaps between leaves left out.

use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Straight, closed_and_filled, smoothed};

/// Nodes of the rounded outline in a cell size.
const NODES: f64 = 6.0;

/// Gaps up to twice this wide, in cell sizes, belong to the inside although the sky reaches into them.
const CLOSED: f64 = 0.16;

/// Where the tree is, gaps between its leaves and boughs included: those of new foliage take their
/// place. `side` is the size of a cell, pixels.
pub(super) fn without_gaps(image: &Image<Straight>, side: f64) -> Mask {
    let reach = (CLOSED * side).clamp(1.0, 60.0) as u8;
    let seen = image.map(|pixel| pixel.alpha() >= 96);
    closed_and_filled(&seen, reach)
}

/// The rounded inside of a crown on a coarse grid: 0 outside, 1 inside.
pub(super) struct Rounded {
    inside: Image<f32>,
    /// Nodes for a pixel.
    scale: f64,
}

impl Rounded {
    /// That of a crown with cells of `side` pixels, rounded by a Gaussian of so many cell sizes.
    pub(super) fn of(
        image: &Image<Straight>,
        side: f64,
        rounding: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let scale = (NODES / side).min(1.0);
        let nodes = |pixels: u32| ((f64::from(pixels) * scale).ceil() as u32).max(2) + 1;
        let mask = without_gaps(image, side);
        let (width, height) = (nodes(image.width()), nodes(image.height()));
        let node = |i: u32| {
            let [x, y] = [i % width, i / width].map(|at| (f64::from(at) / scale) as i64);
            f32::from(u8::from(mask.get(x, y).unwrap_or(false)))
        };
        let inside = Image::from_pixels(width, height, (0..width * height).map(node).collect());
        Ok(Self {
            inside: smoothed(&inside, rounding * NODES, cancel)?,
            scale,
        })
    }

    /// The direction into the crown at pixel (x, y), of length 1 on the rounded outline and less away
    /// from it.
    pub(super) fn inwards(&self, x: f64, y: f64) -> [f64; 2] {
        let [value, across, down] = self.profile(x, y);
        let length = (across * across + down * down).sqrt();
        let share = 4.0 * value * (1.0 - value) / length.max(1e-9);
        // Where nothing rises there is no outline.
        let is_flat = length < 1e-6;
        [across, down].map(|along| if is_flat { 0.0 } else { share * along })
    }

    /// The value at pixel (x, y) and what it rises by across and down, within two nodes each.
    pub(super) fn profile(&self, x: f64, y: f64) -> [f64; 3] {
        let (x, y) = (x * self.scale, y * self.scale);
        let across = self.at(x + 1.0, y) - self.at(x - 1.0, y);
        let down = self.at(x, y + 1.0) - self.at(x, y - 1.0);
        [self.at(x, y), across, down]
    }

    /// Bilinear between nodes.
    fn at(&self, x: f64, y: f64) -> f64 {
        let (width, height) = (self.inside.width(), self.inside.height());
        let within = |value: f64, nodes: u32| value.clamp(0.0, f64::from(nodes) - 1.001);
        let (x, y) = (within(x, width), within(y, height));
        let (left, top) = (x.floor(), y.floor());
        let (s, t) = (x - left, y - top);
        let node = |dx: u32, dy: u32| f64::from(self.inside.at(left as u32 + dx, top as u32 + dy));
        let upper = node(0, 0) + (node(1, 0) - node(0, 0)) * s;
        let lower = node(0, 1) + (node(1, 1) - node(0, 1)) * s;
        upper + (lower - upper) * t
    }
}
