//! From light to a picture: `shaders/tone.wgsl` on the processor.
//!
//! Every sample goes through the tone curve before samples are averaged: an edge between the sun
//! and a shadow is as smooth as any other.

use super::target::Target;
use crate::raster::{Image, Straight};
use crate::render::color::{filmic, srgb_byte};
use crate::render::frame::Frame;
use rayon::prelude::*;

/// The picture that `target` holds, `fineness` × `fineness` samples a pixel.
pub(super) fn picture(frame: &Frame, target: &Target, fineness: u32) -> Image<Straight> {
    let width = target.width() / fineness;
    let height = frame.size[1] as u32 / fineness;
    let mut pixels = vec![Straight::default(); (width * height) as usize];
    let rows = pixels.par_chunks_mut(width as usize).enumerate();
    rows.for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            *pixel = averaged(frame, target, (x as u32, y as u32), fineness);
        }
    });
    Image::from_pixels(width, height, pixels)
}

fn averaged(frame: &Frame, target: &Target, (x, y): (u32, u32), fineness: u32) -> Straight {
    let mut sum = [0.0f32; 4];
    for dy in 0..fineness {
        for dx in 0..fineness {
            let sample = target.light(x * fineness + dx, y * fineness + dy);
            for channel in 0..3 {
                // Samples are clear or opaque, so premultiplied light is light.
                sum[channel] += if frame.view == 0 {
                    filmic(sample[channel] * frame.exposure)
                } else {
                    sample[channel].clamp(0.0, 1.0)
                };
            }
            sum[3] += sample[3];
        }
    }
    if sum[3] == 0.0 {
        return Straight([0; 4]);
    }
    let color = |i: usize| srgb_byte(sum[i] / sum[3]);
    let alpha = sum[3] / (fineness * fineness) as f32;
    Straight([color(0), color(1), color(2), (alpha * 255.0 + 0.5) as u8])
}
