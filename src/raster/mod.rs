//! Pictures as plain data: images, masks, resampling, morphology, reading and writing files.
//!
//! Coordinates: origin top-left, x to the right, y down, pixel centres at whole numbers. Colours
//! are 8-bit sRGB; files hold straight alpha, everything that filters or resamples works on
//! premultiplied alpha, and the two are different types ([`Straight`], [`Premultiplied`]).
//! Filtering is done on sRGB values, as the painting programs our users know do by default.
//!
//! Imports `base`.

mod blur;
mod components;
mod cube_envelope;
mod cube_grid;
mod cubemap;
mod dds;
mod decode;
mod envelope;
mod grey16;
mod image;
mod mask;
mod palette_tiff;
mod pyramid;
mod read;
mod rect;
mod resample;
mod write;

pub use blur::{smoothed, smoothed_within};
pub use components::{component_sizes, labelled_components};
pub use cube_envelope::{CubeCones, cube_upper_envelope};
pub use cube_grid::{folded, per_face, smoothed_cubemap};
pub use cubemap::{CubeFace, Cubemap};
pub use grey16::{Grey16Error, decode_grey16_png, encode_grey16_png};
pub use image::{Image, Premultiplied, Straight};
#[cfg(test)]
pub(crate) use mask::mask;
pub use mask::{
    Mask, closed_and_filled, dilated, eroded, flooded_from_outside, opaque_bounds, row_ends,
};
pub use pyramid::Pyramid;
pub use read::{
    ImageError, PictureFormat, ReadLimits, Refusal, read_image, read_image_from_memory,
};
pub use rect::Rect;
pub use resample::{resized, scaled};
pub use write::{Compression, encode_grey_png, encode_jpeg, encode_opaque_png, encode_png};
