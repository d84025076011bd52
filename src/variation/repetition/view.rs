//! A tree as the eye compares it: small, without colour, light and shade against what is around.
//!
//! Two channels of the same frame are kept. *Clumps*: the luminance of the crown minus its mean
//! around, so that neither exposure nor hue counts. *Edges*: the opacity minus its mean around, so
//! that outline and holes count and the mass of the crown, which all trees share, does not. Each
//! has energy 1.

use crate::base::{Cancel, Cancelled};
use crate::raster::{Image, Mask, Premultiplied, resized, smoothed_within};

/// Longer side of a tree in a fine view, in pixels: a tree in the middle distance of a picture.
pub(super) const TREE_PX: u32 = 64;

/// Share of the frame's side that a tree at scale 1 may fill; the rest is room for larger scales.
const FILLED: f64 = 0.8;

/// Alpha from which a pixel belongs to the tree.
const SEEN_ALPHA: u8 = 64;

/// Standard deviations of the two Gaussians of the band, at [`TREE_PX`]: finer is grain, coarser is
/// what all round crowns have in common.
const BAND_PX: [f64; 2] = [0.8, 4.0];

/// Both channels on a square frame, foot of the tree in the middle of the lower edge.
#[derive(Debug, Clone)]
pub(super) struct View {
    pub(super) side: usize,
    /// Clumps, then edges, row by row.
    pub(super) channels: [Vec<f32>; 2],
}

impl View {
    /// The view of the tree that fills `tree`, `scale` times as large as usual; `tree_px` is its
    /// longer side at scale 1.
    pub(super) fn of(
        tree: &Image<Premultiplied>,
        tree_px: u32,
        scale: f64,
        cancel: &Cancel,
    ) -> Result<Self, Cancelled> {
        let side = (f64::from(tree_px) / FILLED).round() as u32;
        let framed = framed(tree, f64::from(tree_px) * scale, side);
        let band = BAND_PX.map(|sigma| sigma * f64::from(tree_px) / f64::from(TREE_PX));
        let mask: Mask = framed.map(|pixel| pixel.alpha() >= SEEN_ALPHA);
        let clumps = banded(&framed.map(|pixel| luma(*pixel)), &mask, band, cancel)?;
        let everywhere = mask.map(|_| true);
        let alpha = framed.map(|pixel| f32::from(pixel.alpha()) / 255.0);
        let edges = banded(&alpha, &everywhere, band, cancel)?;
        Ok(Self {
            side: side as usize,
            channels: [clumps, edges].map(of_energy_one),
        })
    }

    /// The view in a mirror.
    pub(super) fn mirrored(&self) -> Self {
        let flipped = |channel: &Vec<f32>| {
            let rows = channel.chunks(self.side);
            rows.flat_map(|row| row.iter().rev().copied()).collect()
        };
        Self {
            side: self.side,
            channels: [flipped(&self.channels[0]), flipped(&self.channels[1])],
        }
    }
}

/// `tree` with its longer side at `longer` pixels, standing in the middle of a clear frame.
fn framed(tree: &Image<Premultiplied>, longer: f64, side: u32) -> Image<Premultiplied> {
    let scale = longer / f64::from(tree.width().max(tree.height()));
    let sized = |pixels: u32| ((f64::from(pixels) * scale).round() as u32).clamp(1, side);
    let (width, height) = (sized(tree.width()), sized(tree.height()));
    let small = resized(tree, tree.rect(), width, height);
    let mut frame = Image::filled(side, side, Premultiplied::default());
    let left = ((side - width) / 2) as usize;
    // The foot stands a little above the edge: the band needs room below it.
    let top = (side - height) - ((side - height) / 2).min(side / 16);
    for y in 0..height {
        frame.row_mut(top + y)[left..left + width as usize].copy_from_slice(small.row(y));
    }
    frame
}

/// Luminance, 0 to 1, of the colour without alpha.
pub(super) fn luma(pixel: Premultiplied) -> f32 {
    pixel.straight().luma() / 255.0
}

/// `values` between the two Gaussians of `band`, within `mask`; 0 outside.
fn banded(
    values: &Image<f32>,
    mask: &Mask,
    band: [f64; 2],
    cancel: &Cancel,
) -> Result<Vec<f32>, Cancelled> {
    let fine = smoothed_within(values, mask, band[0], cancel)?;
    let coarse = smoothed_within(values, mask, band[1], cancel)?;
    let pixels = fine.pixels().iter().zip(coarse.pixels()).zip(mask.pixels());
    let difference = |((fine, coarse), inside): ((&f32, &f32), &bool)| {
        if *inside { fine - coarse } else { 0.0 }
    };
    Ok(pixels.map(difference).collect())
}

/// The channel scaled so that its squares sum to 1; all 0 when it shows nothing.
fn of_energy_one(channel: Vec<f32>) -> Vec<f32> {
    let energy: f64 = channel.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
    if energy < 1e-9 {
        return vec![0.0; channel.len()];
    }
    let scale = (1.0 / energy.sqrt()) as f32;
    channel.into_iter().map(|value| value * scale).collect()
}
