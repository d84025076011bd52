//! The built-in library: trees of our own making.
//!
//! Nothing but code goes in, so the pictures carry nobody's licence.

/// Height of a grown picture in pixels unless another is asked for.
pub const USUAL_HEIGHT_PX: u32 = 1536;

/// Individuals of each species in the library.
pub const INDIVIDUALS: u32 = 3;

/// The size of a picture of that height: two to three, as trees are.
pub fn picture_size(height_px: u32) -> (u32, u32) {
    ((height_px * 2 / 3).max(1), height_px)
}

/// One tree of the built-in library.
#[derive(Debug, Clone, Copy)]
pub struct Sample {
    name: &'static str,
    bundled: &'static [u8],
}

macro_rules! sample {
    ($name:literal) => {
        Sample {
            name: $name,
            bundled: include_bytes!(concat!("../../assets/samples/", $name, ".webp")),
        }
    };
}

static SAMPLES: [Sample; 13] = [
    sample!("oak"),
    sample!("linden"),
    sample!("birch"),
    sample!("poplar"),
    sample!("maple"),
    sample!("maple_autumn"),
    sample!("sapling"),
    sample!("shrub"),
    sample!("willow"),
    sample!("robinia"),
    sample!("spruce"),
    sample!("fir"),
    sample!("pine"),
];

/// The built-in library, in the order it is shown.
pub fn samples() -> &'static [Sample] {
    &SAMPLES
}

impl Sample {
    /// Name of the tree, also of its file: lower-case letters and underscores.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The bundled picture as the bytes of an image file.
    pub fn bundled(&self) -> &'static [u8] {
        self.bundled
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::Digest;
    use crate::raster::{Image, Straight};

    /// Lines of `NAME HEIGHT_PX DIGEST`.
    const DIGESTS: &str = include_str!("../../assets/samples/digests.txt");

    fn line(name: &str, image: &Image<Straight>) -> String {
        let digest = Digest::of(bytemuck::cast_slice(image.pixels()));
        format!("{name} {} {digest}", image.height())
    }

    fn bundled(sample: &Sample) -> Image<Straight> {
        let file = image::load_from_memory(sample.bundled())
            .unwrap()
            .into_rgba8();
        let pixels = bytemuck::cast_slice(file.as_raw()).to_vec();
        Image::from_pixels(file.width(), file.height(), pixels)
    }

    #[test]
    fn every_bundled_picture_has_the_listed_pixels() {
        for sample in samples() {
            let line = line(sample.name(), &bundled(sample));
            assert!(DIGESTS.lines().any(|listed| listed == line), "{line}");
        }
    }
}
