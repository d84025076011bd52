//! The built-in library: trees of our own making, the same bits wherever they are grown.
//!
//! Nothing but code goes in, so the pictures carry nobody's licence. The bundled files in
//! `assets/samples` hold exactly what their individuals give at [`USUAL_HEIGHT_PX`]; `digests.txt`
//! beside them names those pixels, and tests compare. The files stay in the program's read-only
//! part: none is touched before it is asked for.

use super::individual::Individual;
use super::species::{LIBRARY, all_species};
use crate::raster::{
    Image, ImageError, ReadLimits, Straight, opaque_bounds, read_image_from_memory,
};
use std::path::Path;

/// Height of a grown picture in pixels unless another is asked for: that of the bundled ones.
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
    species: &'static str,
    index: u32,
    bundled: &'static [u8],
}

macro_rules! samples {
    ($($species:literal: $($number:literal $index:literal),*;)*) => {
        [$($(Sample {
            name: concat!($species, "_", $number),
            species: $species,
            index: $index,
            bundled: include_bytes!(
                concat!("../../assets/samples/", $species, "_", $number, ".webp")
            ),
        },)*)*]
    };
}

static SAMPLES: [Sample; LIBRARY * INDIVIDUALS as usize] = samples! {
    "oak": "01" 1, "02" 2, "03" 3;
    "birch": "01" 1, "02" 2, "03" 3;
    "poplar": "01" 1, "02" 2, "03" 3;
    "willow": "01" 1, "02" 2, "03" 3;
    "maple": "01" 1, "02" 2, "03" 3;
    "sapling": "01" 1, "02" 2, "03" 3;
    "shrub": "01" 1, "02" 2, "03" 3;
    "apple": "01" 1, "02" 2, "03" 3;
    "spruce": "01" 1, "02" 2, "03" 3;
    "pine": "01" 1, "02" 2, "03" 3;
    "cypress": "01" 1, "02" 2, "03" 3;
    "palm": "01" 1, "02" 2, "03" 3;
};

/// The built-in library, in the order it is shown.
pub fn samples() -> &'static [Sample] {
    &SAMPLES
}

/// The individual of each species that stands for it, in the order of the species.
const STARTERS: [u32; LIBRARY] = [2, 1, 3, 2, 1, 1, 2, 2, 1, 2, 2, 2];

/// One sample of each species: enough for a first project, and quickly prepared.
pub fn starters() -> impl Iterator<Item = &'static Sample> {
    SAMPLES
        .chunks_exact(INDIVIDUALS as usize)
        .zip(STARTERS)
        .map(|(three, index)| &three[index as usize - 1])
}

/// The sample of that name.
pub fn sample_named(name: &str) -> Option<&'static Sample> {
    SAMPLES.iter().find(|sample| sample.name == name)
}

impl Sample {
    /// Name of the tree, also of its file: species and number.
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// The bundled picture as the bytes of an image file, [`USUAL_HEIGHT_PX`] high.
    pub fn bundled(&self) -> &'static [u8] {
        self.bundled
    }

    /// The bundled picture without the clear rows and columns around the tree.
    ///
    /// # Errors
    /// [`ImageError`], never of a program as it was built.
    pub fn trimmed(&self) -> Result<Image<Straight>, ImageError> {
        let name = format!("{}.webp", self.name);
        let image = read_image_from_memory(self.bundled, Path::new(&name), ReadLimits::default())?;
        let seen = image.map(|pixel| pixel.alpha() > 0);
        Ok(match opaque_bounds(&seen) {
            Some(b) => image.cropped(b.x, b.y, b.width, b.height),
            None => image,
        })
    }

    /// The individual that the picture shows; `None` for no sample of the library.
    pub fn individual(&self) -> Option<Individual> {
        let species = all_species().iter().find(|s| s.name == self.species)?;
        Some(Individual::new(species, self.index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::{Cancel, Digest};
    use rayon::prelude::*;

    /// Lines of `NAME HEIGHT_PX DIGEST`, of the usual and of a small height.
    const DIGESTS: &str = include_str!("../../assets/samples/digests.txt");

    const SMALL_HEIGHT_PX: u32 = 192;

    fn line(name: &str, image: &Image<Straight>) -> String {
        let digest = Digest::of(bytemuck::cast_slice(image.pixels()));
        format!("{name} {} {digest}", image.height())
    }

    fn assert_listed(line: &str) {
        assert!(
            DIGESTS.lines().any(|listed| listed == line),
            "{line} is not listed"
        );
    }

    fn bundled(sample: &Sample) -> Image<Straight> {
        let file = image::load_from_memory(sample.bundled())
            .unwrap()
            .into_rgba8();
        let pixels = bytemuck::cast_slice(file.as_raw()).to_vec();
        Image::from_pixels(file.width(), file.height(), pixels)
    }

    fn grown(sample: &Sample, height_px: u32) -> Image<Straight> {
        let cancel = Cancel::new();
        let tree = sample.individual().unwrap().grow(&cancel).unwrap();
        let size = picture_size(height_px);
        tree.picture(size, false, &cancel).unwrap().image
    }

    #[test]
    fn the_library_has_three_of_each_species_and_a_starter() {
        for (sample, species) in starters().zip(all_species()) {
            assert_eq!(sample.species, species.name);
        }
        for sample in samples() {
            assert_eq!(sample.name(), sample.individual().unwrap().name());
            assert_eq!(sample_named(sample.name()).unwrap().index, sample.index);
        }
    }

    #[test]
    fn every_bundled_picture_has_the_listed_pixels() {
        samples()
            .par_iter()
            .for_each(|sample| assert_listed(&line(sample.name(), &bundled(sample))));
    }

    #[test]
    fn small_pictures_have_the_listed_pixels() {
        for name in ["palm_01", "pine_02", "sapling_03"] {
            let sample = sample_named(name).unwrap();
            assert_listed(&line(name, &grown(sample, SMALL_HEIGHT_PX)));
        }
    }

    /// All 36 at full size. With `REGENERATE=1` it writes them to `assets/samples` instead, as the
    /// image crate compresses them; `cwebp -lossless -exact -z 9` saves another fifth.
    #[test]
    #[ignore = "takes minutes; last passed on 2026-11-28"]
    fn every_tree_grown_anew_is_the_bundled_one() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/samples");
        let regenerates = std::env::var_os("REGENERATE").is_some();
        let lines: Vec<String> = samples()
            .par_iter()
            .with_max_len(1)
            .flat_map_iter(|sample| {
                let image = grown(sample, USUAL_HEIGHT_PX);
                if regenerates {
                    let file = folder.join(format!("{}.webp", sample.name()));
                    let mut bytes = Vec::new();
                    let encoder = image::codecs::webp::WebPEncoder::new_lossless(&mut bytes);
                    let (width, height) = (image.width(), image.height());
                    let pixels = bytemuck::cast_slice(image.pixels());
                    encoder
                        .encode(pixels, width, height, image::ExtendedColorType::Rgba8)
                        .unwrap();
                    std::fs::write(file, bytes).unwrap();
                }
                let small = grown(sample, SMALL_HEIGHT_PX);
                [&image, &small].map(|image| line(sample.name(), image))
            })
            .collect();
        if regenerates {
            std::fs::write(folder.join("digests.txt"), lines.join("\n") + "\n").unwrap();
        } else {
            lines.iter().for_each(|line| assert_listed(line));
        }
    }
}
